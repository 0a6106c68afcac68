//! A thruster as a campaign describes it: position, direction, and force for a command.
//!
//! ```text
//! w = F (s, p × s)          V = (pwm − neutral)/span
//! ```
//!
//! p is the position (m) and s the unit axis in body axes, F the force along s (N), w the wrench at
//! the body origin (N, N·m); pwm is the pulse width that the thruster's controller receives (µs), V
//! the normalised command.

use std::fmt;

use nalgebra::{Vector3, Vector6};
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, Deserializer, MapAccess, Visitor};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::curve::{Coefficients, CurveError, Supply, ThrustCurve};
use crate::frame::Dof;

/// A `[[thruster]]` table of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Thruster {
    /// Name, as the maker of the vehicle uses it.
    pub name: String,
    /// Position p in body axes, m.
    pub position: [f64; 3],
    /// Direction of positive force in body axes; any length but zero, only the direction counts.
    pub axis: [f64; 3],
    /// Coefficients of the curve for V > 0; all 0 if they are fitted to `bollard`.
    #[serde(default, skip_serializing_if = "Coefficients::are_none")]
    pub forward: Coefficients,
    /// Coefficients of the curve for V < 0; all 0 if they are fitted to `bollard`.
    #[serde(default, skip_serializing_if = "Coefficients::are_none")]
    pub reverse: Coefficients,
    /// Table to which the curve is fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bollard: Option<BollardTable>,
    /// Dead band of the command, as V.
    #[serde(default)]
    pub deadband: f64,
    /// Greatest |V|; no limit when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
    /// Pulse width at no thrust, µs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub neutral: Option<f64>,
    /// Change of pulse width that makes a command of 1, µs; negative where the thruster runs the other way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub span: Option<f64>,
    /// Dependence on the supply voltage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub supply: Option<Supply>,
}

/// A bollard-pull table of one thruster as a campaign names it: a path, or a TOML table with
/// options.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BollardTable {
    /// CSV file, relative to the campaign's folder.
    pub file: String,
    /// Column of the command; if absent, that of this thruster's number, `V1` …, or the only one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
    /// Column of the force along the axis, N; if absent, `force` or the only load cell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<String>,
    /// Whether the dead band is fitted to the table; else `deadband` of the thruster is held.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub fit_deadband: bool,
    /// Supply voltage at which the coefficients hold, V; the median of the table if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_supply: Option<f64>,
}

impl From<String> for BollardTable {
    fn from(file: String) -> BollardTable {
        BollardTable { file, command: None, force: None, fit_deadband: false, reference_supply: None }
    }
}

impl<'de> Deserialize<'de> for BollardTable {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<BollardTable, D::Error> {
        struct Written;
        impl<'de> Visitor<'de> for Written {
            type Value = BollardTable;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a path or a table {file, command, force, fit_deadband, reference_supply}")
            }

            fn visit_str<E: de::Error>(self, file: &str) -> Result<BollardTable, E> {
                Ok(BollardTable::from(file.to_string()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<BollardTable, A::Error> {
                #[derive(Deserialize)]
                #[serde(deny_unknown_fields)]
                struct Table {
                    file: String,
                    command: Option<String>,
                    force: Option<String>,
                    #[serde(default)]
                    fit_deadband: bool,
                    reference_supply: Option<f64>,
                }
                let Table { file, command, force, fit_deadband, reference_supply } =
                    Table::deserialize(MapAccessDeserializer::new(map))?;
                Ok(BollardTable { file, command, force, fit_deadband, reference_supply })
            }
        }
        deserializer.deserialize_any(Written)
    }
}

/// The reason why a thruster cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ThrusterError {
    /// Axis or position is not usable.
    #[error("thruster {name:?}: {key} = {value:?} must be three finite numbers{}", if *.key == "axis" { ", not all zero" } else { "" })]
    BadVector {
        /// Which thruster.
        name: String,
        /// `position` or `axis`.
        key: &'static str,
        /// The value.
        value: [f64; 3],
    },
    /// A curve that no thruster can have.
    #[error("thruster {name:?}: {source}")]
    Curve {
        /// Which thruster.
        name: String,
        /// The error of its curve.
        source: CurveError,
    },
    /// There is neither a curve nor a table.
    #[error(
        "thruster {name:?} has no curve: give forward = {{ a, b }} and reverse = {{ a, b }}, or bollard = \
         \"table.csv\" to fit them to"
    )]
    NoCurve {
        /// Which thruster.
        name: String,
    },
    /// There are both a curve and a table.
    #[error(
        "thruster {name:?} has both coefficients and a bollard table: keep either `forward` and `reverse`, or \
             `bollard`"
    )]
    TwoCurves {
        /// Which thruster.
        name: String,
    },
    /// A pulse width cannot be converted to a command.
    #[error(
        "thruster {name:?}: a command in us needs a finite `neutral` and a `span` other than 0, but they are \
         {neutral:?} and {span:?}"
    )]
    NoPulse {
        /// Which thruster.
        name: String,
        /// Pulse width at no thrust, µs.
        neutral: Option<f64>,
        /// Change of pulse width that makes a command of 1, µs.
        span: Option<f64>,
    },
    /// Two thrusters have one name.
    #[error("two thrusters are called {name:?}: each needs its own name")]
    SameName {
        /// The name.
        name: String,
    },
}

impl Thruster {
    /// Force as a function of command.
    pub fn curve(&self) -> ThrustCurve {
        ThrustCurve {
            forward: self.forward,
            reverse: self.reverse,
            deadband: self.deadband,
            max: self.max.unwrap_or(f64::INFINITY),
            supply: self.supply,
        }
    }

    /// Unit vector s of positive force, body axes.
    pub fn direction(&self) -> Vector3<f64> {
        Vector3::from(self.axis).normalize()
    }

    /// Wrench at the body origin of a force of 1 N along the axis: (s, p × s) in N/N and N·m/N.
    pub fn unit_wrench(&self) -> Vector6<f64> {
        let s = self.direction();
        let moment = Vector3::from(self.position).cross(&s);
        Vector6::new(s.x, s.y, s.z, moment.x, moment.y, moment.z)
    }

    /// Whether it gives a force or moment in `dof` beyond the rounding of its axis.
    pub fn pushes(&self, dof: Dof) -> bool {
        self.unit_wrench()[dof.index()].abs() > 1e-12
    }

    /// Normalised command (pwm − neutral)/span of a pulse width, µs.
    ///
    /// # Errors
    /// If `neutral` or `span` is absent or not usable.
    pub fn command_of_pulse(&self, pulse: f64) -> Result<f64, ThrusterError> {
        match (self.neutral, self.span) {
            (Some(neutral), Some(span)) if neutral.is_finite() && span.is_finite() && span.abs() > 0.0 => {
                Ok((pulse - neutral) / span)
            }
            (neutral, span) => Err(ThrusterError::NoPulse { name: self.name.clone(), neutral, span }),
        }
    }

    /// Checks the thruster.
    ///
    /// # Errors
    /// A position or axis that is not finite, an axis of length zero, no curve, two or an
    /// impossible one, an incomplete description of the pulse.
    pub fn validate(&self) -> Result<(), ThrusterError> {
        let name = || self.name.clone();
        if !self.position.iter().all(|x| x.is_finite()) {
            return Err(ThrusterError::BadVector { name: name(), key: "position", value: self.position });
        }
        if !self.axis.iter().all(|x| x.is_finite()) || Vector3::from(self.axis).norm() <= 0.0 {
            return Err(ThrusterError::BadVector { name: name(), key: "axis", value: self.axis });
        }
        if self.neutral.is_some() || self.span.is_some() {
            self.command_of_pulse(0.0)?;
        }
        let given = !(self.forward.are_none() && self.reverse.are_none());
        match (&self.bollard, given) {
            (None, false) => Err(ThrusterError::NoCurve { name: name() }),
            (Some(_), true) => Err(ThrusterError::TwoCurves { name: name() }),
            (Some(_), false) if !(self.deadband.is_finite() && self.deadband >= 0.0) => {
                let source =
                    CurveError::BadDeadband { deadband: self.deadband, max: self.max.unwrap_or(f64::INFINITY) };
                Err(ThrusterError::Curve { name: name(), source })
            }
            (Some(_), false) => Ok(()),
            (None, true) => self.curve().validate().map_err(|source| ThrusterError::Curve { name: name(), source }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T200: &str = "name = 'T1'\nposition = [0.2, 0.1, 0.0]\naxis = [0, 0, 2]\n\
        forward = {a = 37.4, b = 16.5}\nreverse = {a = 28.4, b = 13.7}\nneutral = 1500\nspan = 400\nmax = 1\n";

    fn t200() -> Thruster {
        toml::from_str(T200).unwrap()
    }

    #[test]
    fn a_pulse_becomes_a_command_and_a_force() {
        let thruster = t200();
        thruster.validate().unwrap();
        let command = thruster.command_of_pulse(1100.0).unwrap();
        assert!((command + 1.0).abs() < 1e-15);
        assert!((thruster.curve().force(command) + 42.1).abs() < 1e-12);
        let mute = Thruster { span: None, ..t200() };
        assert!(matches!(mute.command_of_pulse(1500.0), Err(ThrusterError::NoPulse { span: None, .. })));
        assert!(mute.validate().is_err() && Thruster { neutral: None, ..mute }.validate().is_ok());
    }

    #[test]
    fn exact_wrench_of_a_force_off_the_origin() {
        // down at (0.2, 0.1, 0): roll y·Fz, pitch −x·Fz; the length of the axis does not matter
        assert!((t200().unit_wrench() - Vector6::new(0.0, 0.0, 1.0, 0.1, -0.2, 0.0)).amax() < 1e-15);
    }

    #[test]
    fn what_cannot_be_used_is_named() {
        let flat = Thruster { axis: [0.0; 3], ..t200() };
        let message = flat.validate().unwrap_err().to_string();
        assert_eq!(message, "thruster \"T1\": axis = [0.0, 0.0, 0.0] must be three finite numbers, not all zero");
        let falling = Thruster { forward: Coefficients { a: 1.0, b: -1.0 }, ..t200() };
        assert!(matches!(falling.validate(), Err(ThrusterError::Curve { .. })));
        assert!(Thruster { position: [f64::NAN, 0.0, 0.0], ..t200() }.validate().is_err());
        assert!(toml::from_str::<Thruster>(&format!("{T200}pitch = 3")).is_err());
    }

    #[test]
    fn a_curve_is_given_or_to_be_found() {
        let place = "name = 'T1'\nposition = [0, 0, 0]\naxis = [1, 0, 0]\n";
        let read = |more: &str| toml::from_str::<Thruster>(&format!("{place}{more}")).unwrap();
        let told = read("bollard = 't1.csv'");
        assert_eq!(told.bollard.as_ref().map(|b| b.file.as_str()), Some("t1.csv"));
        told.validate().unwrap();
        let more = read("deadband = 0.1\nbollard = { file = 't1.csv', command = 'V3', fit_deadband = true }");
        assert!(more.bollard.as_ref().is_some_and(|b| b.fit_deadband && b.command.as_deref() == Some("V3")));
        assert_eq!(toml::from_str::<Thruster>(&toml::to_string(&more).unwrap()).unwrap(), more);
        assert!(matches!(read("").validate(), Err(ThrusterError::NoCurve { .. })));
        let both = Thruster { forward: Coefficients { a: 1.0, b: 0.0 }, ..told };
        assert!(matches!(both.validate(), Err(ThrusterError::TwoCurves { .. })));
        let wrong = toml::from_str::<Thruster>(&format!("{place}bollard = {{ file = 'a.csv', comand = 'V1' }}"));
        assert!(wrong.unwrap_err().message().contains("comand"));
    }

    #[test]
    fn what_is_written_is_read_back() {
        assert_eq!(toml::from_str::<Thruster>(&toml::to_string(&t200()).unwrap()).unwrap(), t200());
    }
}
