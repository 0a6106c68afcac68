//! One run as an instruction to a pilot: which degree of freedom is pushed, how hard, how often, and for how long.
//!
//! ```text
//! push     τ = B + A sin(2πt/P)          constant without a period
//! zig-zag  τ = ±A, flips at |ψ − ψ₀| ≥ bound
//! hold     τ = k (z₀ − z) − k w          keeps the depth of the start
//! ```

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::effects::channel;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{RunKind, Signal};
use crate::tank::{Law, Measured, Pilot, Sine, Trial};

/// Depth at which runs begin, m: deep enough for a heave run.
const DEPTH: f64 = 5.0;

/// Control law of one degree of freedom. Several pushes in one degree of freedom add up.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Push {
    /// Degree of freedom that is pushed.
    pub dof: Dof,
    /// Offset B, N or N·m.
    #[serde(default)]
    pub offset: f64,
    /// Amplitude A, N or N·m.
    #[serde(default)]
    pub amplitude: f64,
    /// Period P of a sine, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period: Option<f64>,
    /// Angle at which a zig-zag turns back, rad from the initial one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<f64>,
    /// Stiffness k that holds the initial pose, N/m or N·m/rad; the damping has the same number, per m/s or rad/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hold: Option<f64>,
}

impl Push {
    /// A constant force B.
    pub const fn constant(dof: Dof, offset: f64) -> Push {
        Push { dof, offset, amplitude: 0.0, period: None, bound: None, hold: None }
    }

    /// B + A sin(2πt/P).
    pub const fn sine(dof: Dof, offset: f64, amplitude: f64, period: f64) -> Push {
        Push { amplitude, period: Some(period), ..Push::constant(dof, offset) }
    }

    /// ±A, flipped where the angle is `bound` from the initial one.
    pub const fn zigzag(dof: Dof, amplitude: f64, bound: f64) -> Push {
        Push { amplitude, bound: Some(bound), ..Push::constant(dof, 0.0) }
    }

    /// Holds the initial pose.
    pub const fn hold(dof: Dof, stiffness: f64) -> Push {
        Push { hold: Some(stiffness), ..Push::constant(dof, 0.0) }
    }
}

/// One planned run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manoeuvre {
    /// Name of the run, also used for its file.
    pub name: String,
    /// Kind of experiment.
    #[serde(default)]
    pub kind: RunKind,
    /// Length, s.
    pub length: f64,
    /// Control laws.
    pub pushes: Vec<Push>,
}

/// Error of a run that cannot be carried out as specified.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ManoeuvreError {
    /// A number out of its range.
    #[error("run `{run}`: {key} = {value}: must be {right}")]
    Number {
        /// Name of the run.
        run: String,
        /// Key of the number.
        key: &'static str,
        /// Its value.
        value: f64,
        /// Allowed values.
        right: &'static str,
    },
    /// A push in a degree of freedom that the model does not simulate.
    #[error("run `{run}`: the model does not simulate {dof}")]
    NotModelled {
        /// Name of the run.
        run: String,
        /// The degree of freedom.
        dof: Dof,
    },
    /// A push with more than one law.
    #[error("run `{run}`: the push in {dof} has more than one of `period`, `bound` and `hold`")]
    TwoLaws {
        /// Name of the run.
        run: String,
        /// The degree of freedom.
        dof: Dof,
    },
    /// More thrust than the vehicle has.
    #[error("run `{run}`: requests {asked:.3} in {dof}, but the vehicle provides {limit:.3}")]
    TooStrong {
        /// Name of the run.
        run: String,
        /// The degree of freedom.
        dof: Dof,
        /// Greatest force requested, N or N·m.
        asked: f64,
        /// Greatest force available, N or N·m.
        limit: f64,
    },
    /// No push at all.
    #[error("run `{run}`: nothing pushes the vehicle")]
    NoPush {
        /// Name of the run.
        run: String,
    },
}

impl Manoeuvre {
    /// Checks that `model` can carry it out within the `limits` of thrust (N, N·m; unlimited where one is absent).
    ///
    /// # Errors
    /// [`ManoeuvreError`].
    pub fn validate(&self, model: &Model, limits: &BTreeMap<Dof, f64>) -> Result<(), ManoeuvreError> {
        let run = || self.name.clone();
        let number = |key, value: f64, right| ManoeuvreError::Number { run: run(), key, value, right };
        if !(self.length.is_finite() && self.length >= 1.0) {
            return Err(number("length", self.length, "a number of seconds, 1 or more"));
        }
        if self.pushes.is_empty() {
            return Err(ManoeuvreError::NoPush { run: run() });
        }
        for push in &self.pushes {
            if !model.dofs.contains(&push.dof) {
                return Err(ManoeuvreError::NotModelled { run: run(), dof: push.dof });
            }
            for (key, value) in [("offset", push.offset), ("amplitude", push.amplitude)] {
                if !value.is_finite() {
                    return Err(number(key, value, "a finite force or moment"));
                }
            }
            for (key, value) in [("period", push.period), ("bound", push.bound), ("hold", push.hold)] {
                if let Some(value) = value.filter(|x| !(x.is_finite() && *x > 0.0)) {
                    return Err(number(key, value, "a positive number"));
                }
            }
            if [push.period, push.bound, push.hold].iter().flatten().count() > 1 {
                return Err(ManoeuvreError::TwoLaws { run: run(), dof: push.dof });
            }
        }
        for dof in &model.dofs {
            let asked: f64 =
                self.pushes.iter().filter(|p| p.dof == *dof).map(|p| p.offset.abs() + p.amplitude.abs()).sum();
            // a sum of shares of the limit may exceed it by rounding
            if let Some(limit) = limits.get(dof).filter(|limit| asked > **limit * (1.0 + 1e-9)) {
                return Err(ManoeuvreError::TooStrong { run: run(), dof: *dof, asked, limit: *limit });
            }
        }
        Ok(())
    }

    /// The trial in the virtual tank, from rest. A supply voltage, if the model reads one, has its reference value.
    pub(super) fn trial(&self) -> Trial {
        let mut start = Measured::default();
        start.pose[2] = DEPTH;
        let law = |push: &Push| match (push.period, push.bound, push.hold) {
            (Some(period), _, _) => Law::Sines(push.offset, vec![Sine::new(push.amplitude, period)]),
            (_, Some(bound), _) => Law::Zigzag { moment: push.amplitude, centre: start.pose[push.dof.index()], bound },
            (_, _, Some(stiffness)) => {
                Law::Hold { target: start.pose[push.dof.index()], stiffness, damping: stiffness }
            }
            _ => Law::constant(push.offset + push.amplitude),
        };
        let laws = self.pushes.iter().map(|push| (push.dof, law(push))).collect();
        let ends: std::sync::Arc<[f64]> = vec![0.0, self.length].into();
        let supply = (channel::SUPPLY_RATIO.to_string(), Signal::new(ends, vec![1.0; 2]));
        Trial {
            name: self.name.clone(),
            kind: self.kind,
            duration: self.length,
            pilot: Pilot::new(laws),
            start,
            channels: BTreeMap::from([supply]),
            ..Trial::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;

    fn run(pushes: Vec<Push>) -> Manoeuvre {
        Manoeuvre { name: "one".into(), kind: RunKind::Free, length: 30.0, pushes }
    }

    #[test]
    fn what_cannot_be_sailed_is_refused_with_the_reason() {
        let model = Model::with_effects(&[Dof::Surge, Dof::Yaw], Coriolis::Tied, &["inertia"]).unwrap();
        let limits = BTreeMap::from([(Dof::Surge, 100.0)]);
        let refuse = |pushes| run(pushes).validate(&model, &limits).unwrap_err().to_string();
        assert!(refuse(vec![]).contains("nothing pushes"));
        assert!(refuse(vec![Push::constant(Dof::Heave, 1.0)]).contains("does not simulate heave"));
        assert!(refuse(vec![Push::sine(Dof::Surge, 60.0, 50.0, 8.0)]).contains("requests 110.000 in surge"));
        assert!(refuse(vec![Push::sine(Dof::Surge, 6.0, 5.0, -8.0)]).contains("period = -8"));
        let both = Push { bound: Some(1.0), ..Push::sine(Dof::Yaw, 0.0, 5.0, 8.0) };
        assert!(refuse(vec![both]).contains("more than one"));
        let endless = Manoeuvre { length: f64::INFINITY, ..run(vec![Push::constant(Dof::Surge, 9.0)]) };
        assert!(endless.validate(&model, &limits).is_err());
        assert_eq!(run(vec![Push::sine(Dof::Surge, 50.0, 50.0, 8.0)]).validate(&model, &limits), Ok(()));
    }

    #[test]
    fn a_manoeuvre_is_written_and_read_back() {
        let told = run(vec![Push::sine(Dof::Surge, 60.0, 50.0, 8.0), Push::zigzag(Dof::Yaw, 5.0, 1.0)]);
        let text = toml::to_string(&told).unwrap();
        assert_eq!(toml::from_str::<Manoeuvre>(&text).unwrap(), told);
        assert!(toml::from_str::<Manoeuvre>(&text.replace("period", "perod")).is_err());
    }
}
