//! The request for a plan, and its meaning for a model: wishes, limits of thrust, sensors.

use std::collections::BTreeMap;
use std::str::FromStr;

use nalgebra::Vector6;
use serde::Deserialize;

use super::error::Error;
use super::plan_source::PlanSource;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::{Model, Parameter};
use crate::nearest::nearest;
use crate::plan::{GridOptions, Instrument, Instruments, Manoeuvre, Wish, codes, usual};
use crate::thrust::allocation::Allocation;
use crate::thrust::thruster::Thruster;

/// A wanted standard deviation: `TERM=STD` in SI units, `TERM=5%` of the value, or `5%` for all parameters.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub struct Want {
    /// Term or symbol: `quadratic_drag@surge`, `k_u|u|`; all free parameters if absent.
    pub parameter: Option<String>,
    /// Standard deviation, SI, or share of the value.
    pub amount: f64,
    /// Whether the amount is a share of the value.
    pub relative: bool,
}

impl TryFrom<String> for Want {
    type Error = String;

    fn try_from(text: String) -> Result<Want, String> {
        text.parse()
    }
}

impl FromStr for Want {
    type Err = String;

    fn from_str(text: &str) -> Result<Want, String> {
        // symbols hold no `=`
        let (parameter, amount) = text.rsplit_once('=').map_or((None, text), |(p, a)| (Some(p.trim()), a));
        let (number, relative) = amount.trim().strip_suffix('%').map_or((amount, false), |n| (n, true));
        let number: f64 = number.trim().parse().unwrap_or(f64::NAN);
        if !(number.is_finite() && number > 0.0) || (parameter.is_none() && !relative) {
            return Err(format!(
                "`{text}`: a requested standard error is written TERM=STD, TERM=5% or 5%, with a positive number"
            ));
        }
        let amount = if relative { number / 100.0 } else { number };
        Ok(Want { parameter: parameter.map(str::to_string), amount, relative })
    }
}

/// The request for a plan.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlanRequest {
    /// Wanted standard deviations; a later one overrides an earlier one. 5 % of every parameter if
    /// empty.
    pub wants: Vec<Want>,
    /// Limits of thrust, N and N·m, in addition to the known ones or instead of them.
    pub limits: BTreeMap<Dof, f64>,
    /// Noise of sensors by channel, SI, instead of the known noise; `x`, `y`, `z` make position an
    /// independent measurement.
    pub noise: BTreeMap<String, f64>,
    /// Rates of sensors by channel, Hz; the empty name means all of them.
    pub rates: BTreeMap<String, f64>,
    /// Length of each run, s.
    pub length: f64,
    /// Largest number of runs.
    pub most: usize,
    /// Greatest horizontal distance from the start of a run, m.
    pub room: Option<f64>,
    /// Whether the new runs will be fitted alone, without those that the model comes from.
    pub without_known: bool,
    /// Runs that are judged; if absent, runs are proposed.
    pub runs: Option<Vec<Manoeuvre>>,
    /// Number of simulated campaigns of the rehearsal.
    pub rehearse: usize,
    /// Seed of the rehearsal.
    pub seed: u64,
}

impl Default for PlanRequest {
    fn default() -> PlanRequest {
        PlanRequest {
            wants: Vec::new(),
            limits: BTreeMap::new(),
            noise: BTreeMap::new(),
            rates: BTreeMap::new(),
            length: GridOptions::default().length,
            most: 12,
            room: None,
            without_known: false,
            runs: None,
            rehearse: 0,
            seed: 1,
        }
    }
}

/// Returns the wishes, by the index of the parameter.
pub(super) fn wishes(model: &Model, wants: &[Want]) -> Result<Vec<Wish>, Error> {
    let everything = [Want { parameter: None, amount: 0.05, relative: true }];
    let wants = if wants.is_empty() { &everything[..] } else { wants };
    let mut wishes: Vec<Wish> = Vec::new();
    for want in wants {
        let named = |p: &Parameter| want.parameter.as_ref().is_none_or(|name| *name == p.term || *name == p.spec.name);
        let found: Vec<usize> = model.free().into_iter().filter(|p| named(&model.parameters[*p])).collect();
        if let (Some(name), true) = (&want.parameter, found.is_empty()) {
            let known = model.parameters.iter().flat_map(|p| [p.term.as_str(), p.spec.name.as_str()]);
            let near = nearest(name, known).map(|n| format!(", did you mean `{n}`?")).unwrap_or_default();
            return Err(Error::Asked(format!("no free parameter of the model is called `{name}`{near}")));
        }
        for parameter in found {
            let value = model.parameters[parameter].value.abs();
            let std = if want.relative { want.amount * value } else { want.amount };
            wishes.retain(|w| w.parameter != parameter);
            // a share of a value of 0 is no wish
            if std > 0.0 {
                wishes.push(Wish { parameter, std });
            }
        }
    }
    Ok(wishes)
}

/// Returns the limits of thrust: those requested, otherwise those of the thrusters, otherwise (if
/// none is requested) the greatest force of the runs of the fit.
pub(super) fn limits(
    source: &PlanSource,
    request: &PlanRequest,
    warnings: &mut Vec<Finding>,
) -> Result<BTreeMap<Dof, f64>, Error> {
    for (dof, limit) in &request.limits {
        if !(limit.is_finite() && *limit >= 0.0) {
            return Err(Error::Asked(format!("limit of {dof} = {limit}: a finite force or moment, 0 for none")));
        }
    }
    let mut limits = request.limits.clone();
    for dof in source.model.dofs.iter().filter(|dof| !request.limits.contains_key(dof)) {
        if let Some(limit) = authority(&source.thrusters, *dof) {
            limits.insert(*dof, limit);
        } else if let Some([low, high]) = source.envelope.get(dof.force()).filter(|_| request.limits.is_empty()) {
            let limit = low.abs().max(high.abs());
            limits.insert(*dof, limit);
            let unit = if dof.is_rotation() { "N*m" } else { "N" };
            let text =
                format!("{dof}: no limit of thrust is given; the {limit:.4} {unit} of the model's own runs are used");
            warnings.push(Finding::new(&codes::LIMITS_SEEN, text));
        }
    }
    limits.retain(|dof, limit| *limit > 0.0 && source.model.dofs.contains(dof));
    Ok(limits)
}

/// Returns the force or moment that the thrusters give in `dof` alone, in both directions, N or
/// N·m; `None` if it has no bound or there is none.
fn authority(thrusters: &[Thruster], dof: Dof) -> Option<f64> {
    /// A wrench that exceeds every thruster, N or N·m.
    const HUGE: f64 = 1e6;
    let allocation = Allocation::new(thrusters).ok()?;
    let way = |sign: f64| {
        let mut wanted = Vector6::zeros();
        wanted[dof.index()] = sign * HUGE;
        let given = allocation.allocate(&wanted);
        (given.part < 1.0 && given.wrench[dof.index()] * sign > 0.0).then_some(given.part * HUGE)
    };
    Some(way(1.0)?.min(way(-1.0)?))
}

/// Returns the sensors: those requested, otherwise those of the fit, otherwise usual ones.
pub(super) fn sensors(
    source: &PlanSource,
    request: &PlanRequest,
    warnings: &mut Vec<Finding>,
) -> Result<Instruments, Error> {
    let usual = usual(&source.model);
    let mut sensors = source.sensors.clone();
    sensors.retain(|channel, _| source.model.dofs.iter().any(|d| d.velocity() == channel || d.position() == channel));
    if sensors.is_empty() {
        sensors.clone_from(&usual);
        if request.noise.is_empty() {
            warnings.push(Finding::new(
                &codes::INSTRUMENTS_USUAL,
                "noise and rate of the sensors are not known: those of an ordinary DVL and gyro are assumed",
            ));
        }
    }
    let rates = request.rates.values();
    if let Some(wrong) = request.noise.values().chain(rates).find(|x| !(x.is_finite() && **x > 0.0)) {
        return Err(Error::Asked(format!("noise or rate of {wrong}: must be a positive number")));
    }
    for (channel, noise) in &request.noise {
        let dof = source.model.dofs.iter().find(|d| d.velocity() == channel || d.position() == channel);
        if dof.is_none() {
            return Err(Error::Asked(format!("noise of `{channel}`: the model predicts no channel with this name")));
        }
        let rate = sensors.get(channel).map_or(10.0, |s| s.rate);
        sensors.insert(channel.clone(), Instrument { noise: *noise, rate });
    }
    for (channel, rate) in &request.rates {
        if !channel.is_empty() && !sensors.contains_key(channel) {
            return Err(Error::Asked(format!("rate of `{channel}`: no sensor logs it; give its noise too")));
        }
        for (_, sensor) in sensors.iter_mut().filter(|(name, _)| channel.is_empty() || *name == channel) {
            sensor.rate = *rate;
        }
    }
    Ok(sensors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wishes_are_written_in_three_ways() {
        let want = |text: &str| text.parse::<Want>();
        let all = Want { parameter: None, amount: 0.05, relative: true };
        assert_eq!(want("5%").unwrap(), all);
        assert_eq!(want("k_u|u|=10%").unwrap(), Want { parameter: Some("k_u|u|".into()), amount: 0.1, relative: true });
        assert_eq!(want("inertia@yaw = 3.5").unwrap().amount, 3.5);
        for wrong in ["5", "x=", "x=-1", "x=nan", "", "x=inf%"] {
            assert!(want(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn limits_of_thrust_are_those_of_the_weakest_thruster() {
        let thruster = |name: &str, y: f64, max: f64| -> Thruster {
            let text = format!(
                "name = '{name}'\nposition = [0.0, {y}, 0.0]\naxis = [1.0, 0.0, 0.0]\nmax = {max}\nforward = {{ a = 2.0, b = 0.0 }}\nreverse = {{ a = 1.0, b = 0.0 }}"
            );
            toml::from_str(&text).unwrap()
        };
        let pair = [thruster("port", -0.5, 10.0), thruster("starboard", 0.5, 10.0)];
        // 1 N/V² astern at 10 V limits each of the two to 100 N
        let surge = authority(&pair, Dof::Surge).unwrap();
        let yaw = authority(&pair, Dof::Yaw).unwrap();
        assert!((surge - 200.0).abs() < 1e-6 && (yaw - 100.0).abs() < 1e-6, "{surge} {yaw}");
        assert_eq!(authority(&pair, Dof::Sway), None);
        assert_eq!(authority(&[], Dof::Surge), None);
    }
}
