//! The verb `plan`: runs that bring a model's parameters to wanted standard deviations, or what
//! given runs will achieve.

use std::collections::BTreeMap;

use nalgebra::Vector6;
use serde::Serialize;

use super::error::Error;
use super::fit::row_of;
use super::plan_rehearsal::{rehearsed, spoilt};
use super::plan_request::{PlanRequest, limits, sensors, wishes};
use super::plan_source::PlanSource;
use crate::effects::Scope;
use crate::envelope::Envelope;
use crate::estimate::filter_error::RandomForce;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::plan::{
    Course, GridOptions, Instruments, Manoeuvre, PlanOptions, Proposal, Push, Rehearsal, RehearsedParameter, codes,
    predict, propose,
};
use crate::run::{Run, RunKind, Signal, thruster_command};
use crate::thrust::allocation::Allocation;
use crate::thrust::thruster::Thruster;

/// A plan. Serialises as `hydrosysid plan --json`.
#[derive(Debug, Clone, Serialize)]
pub struct Plan {
    /// Format of the result: 1.
    pub format: u32,
    /// Summary of the plan.
    pub sentence: String,
    /// The runs, the most valuable first.
    pub runs: Vec<PlannedRun>,
    /// Parameters, with what all the runs together will give.
    pub parameters: Vec<PlannedParameter>,
    /// Predicted covariance in the order of `parameters`, SI; `null` if the runs do not show all of
    /// them.
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Limits of thrust that the plan respects, N and N·m.
    pub limits: BTreeMap<Dof, f64>,
    /// Sensors that it assumes.
    pub sensors: Instruments,
    /// Number of candidates that were judged; 0 if the runs were given.
    pub candidates: usize,
    /// Simulated campaigns of this plan, if they were requested.
    pub rehearsal: Option<Rehearsal>,
    /// Findings for the user.
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
    /// Control laws of the degrees of freedom that are pushed.
    pub pushes: Vec<Push>,
    /// Greatest speed of each degree of freedom that the model predicts, by channel, m/s and rad/s.
    pub greatest: BTreeMap<String, f64>,
    /// Greatest horizontal distance from the start that it predicts, m.
    pub reach: f64,
    /// Greatest ratio of a standard deviation to the wanted one, after this run and those before
    /// it; `null` while a wanted parameter is not shown.
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
    /// Standard deviation in the model, SI.
    pub std_now: Option<f64>,
    /// Wanted standard deviation, SI.
    pub wanted: Option<f64>,
    /// Standard deviation that the plan gives, SI; `null` if it does not separate the parameter
    /// from others.
    pub std: Option<f64>,
    /// Root mean square of estimate − truth in the rehearsal, SI.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rehearsed: Option<f64>,
    /// `rehearsed` over what is predicted for the runs that were rehearsed, those of the plan
    /// alone.
    #[serde(skip)]
    pub rehearsed_ratio: Option<f64>,
}

/// Plans the next runs, or judges given ones. `progress` is called after each campaign of a
/// rehearsal.
///
/// # Errors
/// [`Error::Asked`] for wishes about unknown parameters, [`Error::Plan`] if nothing can be planned.
pub fn plan(source: &PlanSource, request: &PlanRequest, progress: &(dyn Fn() + Sync)) -> Result<Plan, Error> {
    if let Some(term) = source.model.terms.iter().find(|term| term.effect.about().scope == Scope::Thrusters) {
        let text = format!(
            "a plan drives degrees of freedom, but `{}` belongs to single thrusters: if it is a fault, repair the \
             vehicle, take the effect out of the model, and plan again",
            term.name()
        );
        return Err(Error::Asked(text));
    }
    let wishes = wishes(&source.model, &request.wants)?;
    let mut warnings = source.warnings.clone();
    let limits = limits(source, request, &mut warnings)?;
    let sensors = sensors(source, request, &mut warnings)?;
    let positive = |x: f64| x.is_finite() && x >= 10.0;
    if !positive(request.length) || request.length > 3600.0 {
        return Err(Error::Asked(format!("length = {}: runs must be 10 to 3600 s long", request.length)));
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
        forces: source.forces.clone(),
        known: (!request.without_known).then(|| known(source)),
    };
    let proposal = match &request.runs {
        None => propose(&course, &wishes, &options)?,
        Some(runs) => predict(&course, runs, &wishes, &options)?,
    };
    let (rehearsal, told) = match request.rehearse {
        0 => (None, Vec::new()),
        _ => rehearsed((&course, source), &proposal, (&wishes, &options), request, progress),
    };
    warnings.extend(proposal.warnings.iter().cloned());
    warnings.extend(beyond(&proposal, &source.envelope));
    warnings.extend(told);
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
            rehearsed_ratio: rehearsed.map(RehearsedParameter::ratio),
        }
    });
    let parameters: Vec<PlannedParameter> = parameters.collect();
    let commands: Vec<(Run, f64)> =
        proposal.runs.iter().map(|run| commands(&run.sailed.run, &source.thrusters)).collect();
    warnings.extend(commands.iter().filter(|(_, part)| *part < WHOLE).map(saturates));
    let count = proposal.parameters.len();
    Ok(Plan {
        format: 1,
        sentence: spoilt(rehearsal.as_ref())
            + &sentence(&parameters, proposal.runs.len(), source.forces.as_deref().unwrap_or_default()),
        parameters,
        covariance: proposal.covariance.as_ref().map(|c| c.chunks(count.max(1)).map(<[f64]>::to_vec).collect()),
        commands: commands.into_iter().map(|(run, _)| run).collect(),
        runs: proposal.runs.iter().map(planned).collect(),
        limits,
        sensors,
        candidates: proposal.candidates,
        rehearsal,
        warnings,
    })
}

/// Says whether the model is good enough as it is, and what the runs bring.
fn sentence(parameters: &[PlannedParameter], runs: usize, forces: &[RandomForce]) -> String {
    let met = |std: Option<f64>, p: &PlannedParameter| p.wanted.is_none_or(|w| std.is_some_and(|s| s <= w));
    let counted = match forces {
        [] => "",
        _ => " The random force is included.",
    };
    if parameters.iter().all(|p| met(p.std_now, p)) {
        return format!("Enough already: what is known meets every requested accuracy.{counted}");
    }
    let open: Vec<&str> = parameters.iter().filter(|p| !met(p.std, p)).map(|p| p.name.as_str()).collect();
    let (runs, s) = if runs == 1 { ("One run".to_string(), "s") } else { (format!("{runs} runs"), "") };
    match &open[..] {
        [] => format!("{runs} meet{s} every requested accuracy.{counted}"),
        open => format!("{runs} leave{s} {} less accurate than requested.{counted}", open.join(", ")),
    }
}

fn planned(run: &crate::plan::ProposedRun) -> PlannedRun {
    let Manoeuvre { name, kind, length, pushes } = run.sailed.manoeuvre.clone();
    let greatest = run.sailed.greatest.iter().map(|(dof, v)| (dof.velocity().into(), *v)).collect();
    PlannedRun { name, kind, length, pushes, greatest, reach: run.sailed.reach, worst: run.worst }
}

/// Part of a wrench from which it counts as all of it, because of rounding.
const WHOLE: f64 = 0.999;

fn saturates((run, part): &(Run, f64)) -> Finding {
    let text = format!(
        "{}: the thrusters provide {:.0} % of the forces requested at the same time: these are clipped, and the run \
         shows less than predicted; lower the limits with --limit",
        run.name,
        100.0 * part
    );
    Finding::new(&codes::SATURATES, text)
}

/// Returns the command history of a run: forces and, if the thrusters are known, their commands;
/// and the least part of the forces that the thrusters can give, 0 to 1.
fn commands(run: &Run, thrusters: &[Thruster]) -> (Run, f64) {
    let forces: BTreeMap<String, Signal> =
        Dof::ALL.iter().filter_map(|dof| Some((dof.force().to_string(), run.signal(dof.force())?.clone()))).collect();
    let mut told = Run { name: run.name.clone(), kind: run.kind, signals: forces, ..Run::default() };
    let (Ok(allocation), Some(first)) = (Allocation::new(thrusters), told.signals.values().next()) else {
        return (told, 1.0);
    };
    let time = first.shared_time().clone();
    let mut volts = vec![Vec::with_capacity(time.len()); allocation.len()];
    let mut part: f64 = 1.0;
    for k in 0..time.len() {
        let value = |dof: Dof| told.signal(dof.force()).map_or(0.0, |s| s.values()[k]);
        let wrench = Vector6::from_iterator(Dof::ALL.into_iter().map(value));
        let given = allocation.allocate(&wrench);
        part = part.min(given.part);
        for (list, v) in volts.iter_mut().zip(given.commands) {
            list.push(v);
        }
    }
    for (k, values) in volts.into_iter().enumerate() {
        told.signals.insert(thruster_command(k), Signal::new(time.clone(), values));
    }
    (told, part)
}

/// Returns the covariance of the shared free parameters in the model, row-major.
fn known(source: &PlanSource) -> Vec<f64> {
    let free: Vec<usize> =
        source.model.free().into_iter().filter(|p| !source.model.parameters[*p].spec.per_run).collect();
    let at = |a: usize, b: usize| source.covariance.get(a).and_then(|row| row.get(b)).copied().unwrap_or(0.0);
    free.iter().flat_map(|a| free.iter().map(|b| at(*a, *b)).collect::<Vec<_>>()).collect()
}

/// Ratio of the speed of a run to that of the runs of the fit above which there is a finding.
const MARGIN: f64 = 1.2;

/// Returns findings about proposed runs that are faster than the runs from which the model comes.
fn beyond(proposal: &Proposal, envelope: &Envelope) -> Vec<Finding> {
    let mut findings = Vec::new();
    for run in &proposal.runs {
        for (dof, speed) in &run.sailed.greatest {
            let Some([low, high]) = envelope.get(dof.velocity()) else { continue };
            let known = low.abs().max(high.abs());
            if *speed > MARGIN * known {
                let name = &run.sailed.manoeuvre.name;
                let text = format!(
                    "run `{name}` reaches {} = {speed:.3}, but the model comes from runs up to {known:.3}",
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
    use crate::thrust::curve::Coefficients;

    /// Two thrusters side by side give all of a surge force or all of a yaw moment, and half of
    /// both at once.
    #[test]
    fn what_thrusters_do_not_give_together_is_told() {
        let side = Coefficients { a: 10.0, b: 0.0 };
        let thruster = |y: f64| Thruster {
            name: format!("{y}"),
            position: [0.0, y, 0.0],
            axis: [1.0, 0.0, 0.0],
            forward: side,
            reverse: side,
            bollard: None,
            deadband: 0.0,
            max: Some(1.0),
            neutral: None,
            span: None,
            supply: None,
        };
        let pushed = |tau_u: f64, tau_r: f64| {
            let mut run = Run { name: "plan01".into(), ..Run::default() };
            for (name, values) in [("tau_u", vec![0.0, tau_u]), ("tau_r", vec![0.0, tau_r])] {
                run.signals.insert(name.into(), Signal::new(vec![0.0, 1.0].into(), values));
            }
            commands(&run, &[thruster(0.2), thruster(-0.2)])
        };
        let (run, part) = pushed(20.0, 0.0);
        assert!(part > WHOLE && (run.signals["V1"].values()[1] - 1.0).abs() < 1e-9, "{run:?}");
        let half = pushed(20.0, 4.0);
        assert!((half.1 - 0.5).abs() < 1e-9, "{}", half.1);
        assert!(saturates(&half).message.contains("50 % of the forces"), "{}", saturates(&half).message);
    }
}
