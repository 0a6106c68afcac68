//! The verb `plan`: runs that bring a model's parameters to wanted deviations, or what given runs will bring.

use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;

use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

use super::error::Error;
use super::fit::{Fit, row_of};
use super::load::Campaign;
use super::model_file::{ModelFile, ModelFileError};
use crate::envelope::Envelope;
use crate::estimate::output_error::OutputErrorOptions;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::{Model, Parameter};
use crate::nearest::nearest;
use crate::plan::{
    Course, GridOptions, Instrument, Instruments, Manoeuvre, PlanOptions, Proposal, Push, Rehearsal, Wish, codes,
    predict, propose, rehearse, usual,
};
use crate::run::{Run, RunKind, Signal};
use crate::thrust::allocation::Allocation;
use crate::thrust::thruster::Thruster;
use crate::vehicle::Vehicle;

/// A wanted standard deviation: `TERM=STD` in SI units, `TERM=5%` of the value, or `5%` for all parameters.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub struct Want {
    /// Term or symbol: `quadratic_drag@surge`, `k_u|u|`; all free parameters when absent.
    pub parameter: Option<String>,
    /// Deviation, SI, or share of the value.
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
                "`{text}`: a wanted deviation is written TERM=STD, TERM=5% or 5%, with a positive number"
            ));
        }
        let amount = if relative { number / 100.0 } else { number };
        Ok(Want { parameter: parameter.map(str::to_string), amount, relative })
    }
}

/// What a plan is asked for.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlanRequest {
    /// Wanted deviations; a later one overrides an earlier one. 5 % of every parameter when empty.
    pub wants: Vec<Want>,
    /// Limits of thrust, N and N·m, beside or instead of those that are known.
    pub limits: BTreeMap<Dof, f64>,
    /// Noise of sensors by channel, SI, instead of what is known; `x`, `y`, `z` make position an independent measurement.
    pub noise: BTreeMap<String, f64>,
    /// Rates of sensors by channel, Hz; under the empty name that of all.
    pub rates: BTreeMap<String, f64>,
    /// Length of each run, s.
    pub length: f64,
    /// Most runs.
    pub most: usize,
    /// Greatest horizontal distance from the start of a run, m.
    pub room: Option<f64>,
    /// Whether the new runs will be fitted together with those that the model comes from.
    pub with_known: bool,
    /// Runs to be judged instead of proposed.
    pub runs: Option<Vec<Manoeuvre>>,
    /// Number of simulated campaigns with which the plan is rehearsed.
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
            with_known: false,
            runs: None,
            rehearse: 0,
            seed: 1,
        }
    }
}

/// What a plan is made from: a model and what is known of its vehicle and sensors.
#[derive(Debug, Clone)]
pub struct PlanSource {
    model: Model,
    vehicle: Vehicle,
    envelope: Envelope,
    sensors: Instruments,
    thrusters: Vec<Thruster>,
    covariance: Vec<Vec<f64>>,
    fitting: OutputErrorOptions,
}

impl PlanSource {
    /// From a model file; `path` is named in messages.
    ///
    /// # Errors
    /// [`ModelFileError`] when this version has another idea of a term.
    pub fn of_file(file: &ModelFile, path: &Path) -> Result<PlanSource, ModelFileError> {
        Ok(PlanSource {
            model: file.model(&[], path)?,
            vehicle: file.vehicle.clone(),
            envelope: file.envelope.clone(),
            sensors: file.sensors.clone(),
            thrusters: Vec::new(),
            covariance: file.covariance.clone(),
            fitting: OutputErrorOptions::default(),
        })
    }

    /// From a campaign and its fit.
    pub fn of_fit(campaign: &Campaign, fit: &Fit) -> PlanSource {
        PlanSource {
            model: fit.model.clone(),
            vehicle: campaign.vehicle.clone(),
            envelope: fit.envelope.clone(),
            sensors: fit.instruments.clone(),
            thrusters: campaign.file.thrusters.clone(),
            covariance: fit.covariance.clone(),
            fitting: campaign.options.output_error.clone(),
        }
    }
}

/// A plan. Serialises as `hydrosysid plan --json`.
#[derive(Debug, Clone, Serialize)]
pub struct Plan {
    /// Format of the result: 1.
    pub format: u32,
    /// The runs, the most valuable first.
    pub runs: Vec<PlannedRun>,
    /// What they will give together.
    pub parameters: Vec<PlannedParameter>,
    /// Predicted covariance in the order of `parameters`, SI; `null` when the runs do not show all of them.
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Limits of thrust that the plan keeps, N and N·m.
    pub limits: BTreeMap<Dof, f64>,
    /// Sensors that it counts on.
    pub sensors: Instruments,
    /// Number of candidates that were judged; 0 where the runs were given.
    pub candidates: usize,
    /// Simulated campaigns of this plan, where they were asked for.
    pub rehearsal: Option<Rehearsal>,
    /// What there is to say.
    pub warnings: Vec<Finding>,
    /// Command histories, N and N·m, each ready to be written as a log.
    #[serde(skip)]
    pub commands: Vec<Run>,
}

/// One run of a plan; name, kind, length and pushes are what [`PlanRequest::runs`] reads.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlannedRun {
    /// Name.
    pub name: String,
    /// Kind of experiment.
    pub kind: RunKind,
    /// Length, s.
    pub length: f64,
    /// Who pushes where.
    pub pushes: Vec<Push>,
    /// Greatest speed of each degree of freedom that the model foresees, by channel, m/s and rad/s.
    pub greatest: BTreeMap<String, f64>,
    /// Greatest horizontal distance from the start that it foresees, m.
    pub reach: f64,
    /// Greatest deviation over the wanted one, once this run and those before it are sailed; `null` while a wanted
    /// parameter is not shown.
    pub worst: Option<f64>,
}

/// What a plan gives for one parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlannedParameter {
    /// Id of the effect.
    pub effect: String,
    /// Degree of freedom; `null` for the whole vehicle.
    pub dof: Option<Dof>,
    /// The other degree of freedom of a coupling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other: Option<Dof>,
    /// Symbol.
    pub name: String,
    /// Value in the model, SI.
    pub value: f64,
    /// Unit.
    pub unit: String,
    /// Deviation in the model, SI.
    pub std_now: Option<f64>,
    /// Wanted deviation, SI.
    pub wanted: Option<f64>,
    /// Deviation that the plan gives, SI; `null` when it does not show the parameter apart from others.
    pub std: Option<f64>,
    /// Root mean square of estimate − truth in the rehearsal, SI.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rehearsed: Option<f64>,
}

/// Plans the next runs, or judges those that are given. `progress` is called after each campaign of a rehearsal.
///
/// # Errors
/// [`Error::Asked`] for wishes of parameters that are none, [`Error::Plan`] where nothing can be planned.
pub fn plan(source: &PlanSource, request: &PlanRequest, progress: &(dyn Fn() + Sync)) -> Result<Plan, Error> {
    let wishes = wishes(&source.model, &request.wants)?;
    let mut warnings = Vec::new();
    let limits = limits(source, request, &mut warnings)?;
    let sensors = sensors(source, request, &mut warnings)?;
    let positive = |x: f64| x.is_finite() && x >= 10.0;
    if !positive(request.length) || request.length > 3600.0 {
        return Err(Error::Asked(format!("length = {}: runs are 10 to 3600 s long", request.length)));
    }
    if request.most == 0 || request.most > 100 {
        return Err(Error::Asked(format!("most = {}: 1 to 100 runs", request.most)));
    }
    let course = Course {
        model: source.model.clone(),
        instruments: sensors.clone(),
        length: source.vehicle.characteristic_length().unwrap_or(1.0),
    };
    let options = PlanOptions {
        limits: limits.clone(),
        most: request.most,
        room: request.room,
        grid: GridOptions { length: request.length, ..GridOptions::default() },
        fitting: source.fitting.clone(),
        known: request.with_known.then(|| known(source)),
    };
    let proposal = match &request.runs {
        None => propose(&course, &wishes, &options)?,
        Some(runs) => predict(&course, runs, &wishes, &options)?,
    };
    let rehearsal = (request.rehearse > 0).then(|| {
        // a rehearsal reaches what the runs alone give
        let alone = PlanOptions { known: None, ..options.clone() };
        let told: Vec<Manoeuvre> = proposal.runs.iter().map(|run| run.sailed.manoeuvre.clone()).collect();
        let plan = if request.with_known { predict(&course, &told, &wishes, &alone).ok() } else { None };
        let plan = plan.as_ref().unwrap_or(&proposal);
        rehearse(&course, plan, &source.fitting, (request.rehearse, request.seed), progress)
    });
    warnings.extend(proposal.warnings.iter().cloned());
    warnings.extend(beyond(&proposal, &source.envelope));
    let rehearsal = rehearsal.map(|(rehearsal, findings)| {
        warnings.extend(findings);
        rehearsal
    });
    let parameters = proposal.parameters.iter().map(|told| {
        let p = &source.model.parameters[told.parameter];
        let rehearsed = rehearsal.as_ref().and_then(|r| r.parameters.iter().find(|q| q.parameter == told.parameter));
        PlannedParameter {
            effect: p.effect.clone(),
            dof: row_of(&p.effect, p.place),
            other: p.place.other,
            name: p.spec.name.clone(),
            value: told.value,
            unit: p.spec.dimension.to_string(),
            std_now: p.std,
            wanted: told.wanted,
            std: told.std,
            rehearsed: rehearsed.map(|q| q.reached),
        }
    });
    let count = proposal.parameters.len();
    Ok(Plan {
        format: 1,
        parameters: parameters.collect(),
        covariance: proposal.covariance.as_ref().map(|c| c.chunks(count.max(1)).map(<[f64]>::to_vec).collect()),
        commands: proposal.runs.iter().map(|run| commands(&run.sailed.run, &source.thrusters)).collect(),
        runs: proposal.runs.iter().map(planned).collect(),
        limits,
        sensors,
        candidates: proposal.candidates,
        rehearsal,
        warnings,
    })
}

fn planned(run: &crate::plan::ProposedRun) -> PlannedRun {
    let Manoeuvre { name, kind, length, pushes } = run.sailed.manoeuvre.clone();
    let greatest = run.sailed.greatest.iter().map(|(dof, v)| (dof.velocity().into(), *v)).collect();
    PlannedRun { name, kind, length, pushes, greatest, reach: run.sailed.reach, worst: run.worst }
}

/// The command history of a run: forces and, where the thrusters are known, their commands.
fn commands(run: &Run, thrusters: &[Thruster]) -> Run {
    let forces: BTreeMap<String, Signal> =
        Dof::ALL.iter().filter_map(|dof| Some((dof.force().to_string(), run.signal(dof.force())?.clone()))).collect();
    let mut told = Run { name: run.name.clone(), kind: run.kind, signals: forces, ..Run::default() };
    let (Ok(allocation), Some(first)) = (Allocation::new(thrusters), told.signals.values().next()) else { return told };
    let time = first.shared_time().clone();
    let mut volts = vec![Vec::with_capacity(time.len()); allocation.len()];
    for k in 0..time.len() {
        let value = |dof: Dof| told.signal(dof.force()).map_or(0.0, |s| s.values()[k]);
        let wrench = Vector6::from_iterator(Dof::ALL.into_iter().map(value));
        for (list, v) in volts.iter_mut().zip(allocation.allocate(&wrench).commands) {
            list.push(v);
        }
    }
    for (k, values) in volts.into_iter().enumerate() {
        told.signals.insert(format!("V{}", k + 1), Signal::new(time.clone(), values));
    }
    told
}

/// Wishes by the index of the parameter.
fn wishes(model: &Model, wants: &[Want]) -> Result<Vec<Wish>, Error> {
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
            // a share of 0 is no wish
            if std > 0.0 {
                wishes.push(Wish { parameter, std });
            }
        }
    }
    Ok(wishes)
}

/// Limits of thrust: as given, else of the thrusters, else the greatest force of the runs of the fit.
fn limits(
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
                format!("{dof}: no limit of thrust is given, the {limit:.4} {unit} of the model's own runs are taken");
            warnings.push(Finding::new(&codes::LIMITS_SEEN, text));
        }
    }
    limits.retain(|dof, limit| *limit > 0.0 && source.model.dofs.contains(dof));
    Ok(limits)
}

/// Force or moment that the thrusters give in `dof` alone, both ways, N or N·m; `None` where it has no bound or is none.
fn authority(thrusters: &[Thruster], dof: Dof) -> Option<f64> {
    /// A wrench beyond every thruster, N or N·m.
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

/// Sensors: as given, else those of the fit, else ordinary ones.
fn sensors(source: &PlanSource, request: &PlanRequest, warnings: &mut Vec<Finding>) -> Result<Instruments, Error> {
    let usual = usual(&source.model);
    let mut sensors = source.sensors.clone();
    sensors.retain(|channel, _| source.model.dofs.iter().any(|d| d.velocity() == channel || d.position() == channel));
    if sensors.is_empty() {
        sensors.clone_from(&usual);
        if request.noise.is_empty() {
            warnings.push(Finding::new(
                &codes::INSTRUMENTS_USUAL,
                "noise and rate of the sensors are not known: those of an ordinary DVL and gyro are taken",
            ));
        }
    }
    let rates = request.rates.values();
    if let Some(wrong) = request.noise.values().chain(rates).find(|x| !(x.is_finite() && **x > 0.0)) {
        return Err(Error::Asked(format!("noise or rate of {wrong}: a positive number")));
    }
    for (channel, noise) in &request.noise {
        let dof = source.model.dofs.iter().find(|d| d.velocity() == channel || d.position() == channel);
        if dof.is_none() {
            return Err(Error::Asked(format!("noise of `{channel}`: the model predicts no channel of this name")));
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

/// Covariance of the shared free parameters that the model has already, row-major.
fn known(source: &PlanSource) -> Vec<f64> {
    let free: Vec<usize> =
        source.model.free().into_iter().filter(|p| !source.model.parameters[*p].spec.per_run).collect();
    let at = |a: usize, b: usize| source.covariance.get(a).and_then(|row| row.get(b)).copied().unwrap_or(0.0);
    free.iter().flat_map(|a| free.iter().map(|b| at(*a, *b)).collect::<Vec<_>>()).collect()
}

/// Share by which a run may be faster than those of the fit before it is said.
const MARGIN: f64 = 1.2;

/// Says where proposed runs are faster than what the model comes from.
fn beyond(proposal: &Proposal, envelope: &Envelope) -> Vec<Finding> {
    let mut findings = Vec::new();
    for run in &proposal.runs {
        for (dof, speed) in &run.sailed.greatest {
            let Some([low, high]) = envelope.get(dof.velocity()) else { continue };
            let known = low.abs().max(high.abs());
            if *speed > MARGIN * known {
                let name = &run.sailed.manoeuvre.name;
                let text = format!(
                    "run `{name}` reaches {} = {speed:.3}, the model comes from runs up to {known:.3}",
                    dof.velocity()
                );
                findings.push(Finding::new(&codes::BEYOND, text).of_run(name));
            }
        }
    }
    findings
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
