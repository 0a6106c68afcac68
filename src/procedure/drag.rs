//! Stage (ii): drag from constant-velocity runs, and from towing.
//!
//! ```text
//! τᵢ − (W − B) sin θ = k_Q ν|ν| + k_L ν + b        (18), (19): one row a steady window, means over it
//! ```
//!
//! Towed, the load cell stands in place of the thrust. Rows are the regressors of the model itself, integrated over the
//! window and divided by its length, with no inertia: so the pitch term, a drag per direction, or any other effect of
//! the model takes part. With few windows the deviations are widened by Student's t, so that two of them hold 95.4 %.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::held::{Direction, Held};
use super::numbers::DRAG;
use super::result::Stage;
use super::{ProcedureError, StagedOptions, codes, parameters_at};
use crate::estimate::{Columns, RegressorOptions, RowFit, Span, StdMethod, SteadyWindow, mean_of, steady_windows};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, Signal};

/// A run cut to a steady window, and which way it moves.
struct Steady {
    run: Run,
    direction: Direction,
}

/// What a drag stage has found.
pub(super) struct Drag {
    pub stages: Vec<Stage>,
    /// The fit of all windows.
    pub fit: RowFit,
    /// What is held by later stages.
    pub held: Held,
}

/// Drag of `dof` from `runs` of constant velocity; `Ok(Err(…))` says why there is none.
pub(super) fn stage(
    name: &str,
    dof: Dof,
    runs: &[&Run],
    model: &Model,
    options: &StagedOptions,
) -> Result<Result<Drag, Finding>, ProcedureError> {
    let windows: Vec<Steady> = runs.iter().flat_map(|run| cut(run, dof, options)).collect();
    if windows.is_empty() {
        let text = format!("{name}, {dof}: no steady window in {} runs", runs.len());
        return Ok(Err(Finding::new(&codes::NO_STEADY, text)));
    }
    let still = without_inertia(model, dof);
    let drag = parameters_at(model, dof, &DRAG);
    let with_bias = [drag.clone(), parameters_at(model, dof, &["bias"])].concat();
    let all: Vec<&Run> = windows.iter().map(|w| &w.run).collect();
    let free = if all.len() > with_bias.len() { &with_bias } else { &drag };
    let mut fit = match ProcedureError::unless_data(name, dof, means(dof, &all, &still, free))? {
        Ok(fit) => fit,
        Err(finding) => return Ok(Err(finding)),
    };
    let mut stages = vec![of(name, dof, &all, &still, &mut fit)];
    let mut held = Held::default();
    if options.per_direction && dof == Dof::Yaw {
        let ways = [(Direction::Positive, "clockwise"), (Direction::Negative, "anticlockwise")];
        let mut both = Vec::new();
        for (direction, word) in ways {
            let of_it: Vec<&Run> = windows.iter().filter(|w| w.direction == direction).map(|w| &w.run).collect();
            // what only tells the directions apart has no place in one direction
            let one_way: Vec<usize> =
                free.iter().copied().filter(|p| model.parameters[*p].effect != "drag_asymmetry").collect();
            if of_it.len() > one_way.len()
                && let Ok(mut fit) = ProcedureError::unless_data(name, dof, means(dof, &of_it, &still, &one_way))?
            {
                both.push((of(&format!("{name} {word}"), dof, &of_it, &still, &mut fit), fit, direction));
            }
        }
        if both.len() == ways.len() {
            for (_, fit, direction) in &both {
                held.add(fit, &drag, Some(*direction));
            }
            // each direction has all of its drag
            parameters_at(model, dof, &["drag_asymmetry"]).into_iter().for_each(|p| held.know(p, 0.0));
        }
        stages.extend(both.into_iter().map(|(stage, ..)| stage));
    }
    if !drag.iter().any(|p| held.has(*p)) {
        held.add(&fit, &drag, None);
    }
    Ok(Ok(Drag { stages, fit, held }))
}

/// The load cell's reading in place of the nominal force.
pub(super) fn towed(run: &Run, dof: Dof) -> Option<Run> {
    let load = run.signal(dof.load())?.clone();
    let mut towed = run.clone();
    // the carriage moves the vehicle straight ahead and level: what it does not log is 0
    for other in Dof::ALL {
        for name in [other.velocity(), other.position()] {
            let zero = || Signal::new(load.shared_time().clone(), vec![0.0; load.len()]);
            towed.signals.entry(name.to_string()).or_insert_with(zero);
        }
    }
    towed.signals.insert(dof.force().into(), load);
    Some(towed)
}

fn of(name: &str, dof: Dof, windows: &[&Run], model: &Model, fit: &mut RowFit) -> Stage {
    let freedom = (fit.rows - fit.values.len()) as f64;
    let widening = student(freedom);
    for row in &mut fit.covariance {
        row.iter_mut().for_each(|c| *c *= widening * widening);
    }
    let mut names: Vec<String> = windows.iter().map(|r| r.name.clone()).collect();
    names.dedup();
    let mut stage = Stage::of_fit(name, dof, names, model, fit);
    if widening > 1.1 {
        let text = format!(
            "{name}, {dof}: {} steady windows for {} parameters; deviations are widened by {widening:.2}",
            fit.rows,
            fit.values.len()
        );
        stage.warnings.push(Finding::new(&codes::FEW_SPEEDS, text));
    }
    stage
}

/// Half of the quantile of Student's t that holds what two standard deviations of a normal hold.
fn student(freedom: f64) -> f64 {
    const TWO_SIGMA: f64 = 0.977_249_868_051_820_8;
    StudentsT::new(0.0, 1.0, freedom.max(1.0)).map_or(1.0, |t| t.inverse_cdf(TWO_SIGMA) / 2.0)
}

/// Mean forces over the windows.
fn means(dof: Dof, runs: &[&Run], model: &Model, free: &[usize]) -> Result<RowFit, crate::estimate::IntegralError> {
    let whole = RegressorOptions { span: Span::Samples(usize::MAX), ..RegressorOptions::default() };
    let over_time = |columns: &mut Columns| {
        for (row, (from, to)) in columns.span.iter().enumerate() {
            let length = to - from;
            columns.rhs[row] /= length;
            columns.columns.iter_mut().for_each(|c| c[row] /= length);
        }
    };
    Held::default().fit((dof, runs), model, free, (whole, StdMethod::Paper), &over_time)
}

/// `model` at constant velocity: its momentum in `dof` does not change.
fn without_inertia(model: &Model, dof: Dof) -> Model {
    let mut still = model.clone();
    for p in parameters_at(model, dof, &["inertia", "added_mass_coupling", "added_mass_amplitude"]) {
        still.parameters[p].value = 0.0;
    }
    for p in &mut still.parameters {
        let momentum = ["inertia", "added_mass_coupling", "added_mass_amplitude"].contains(&p.effect.as_str());
        if momentum && p.place.dof == Some(dof) {
            p.value = 0.0;
        }
    }
    still
}

/// The steady windows of a run: its own velocity cut, everything else whole.
fn cut(run: &Run, dof: Dof, options: &StagedOptions) -> Vec<Steady> {
    let Some(velocity) = run.signal(dof.velocity()) else { return Vec::new() };
    let of_window = |window: SteadyWindow| {
        let inside: Vec<usize> =
            (0..velocity.len()).filter(|k| (window.from..=window.to).contains(&velocity.time()[*k])).collect();
        let pick = |x: &[f64]| -> Vec<f64> { inside.iter().map(|k| x[*k]).collect() };
        let mut part = run.clone();
        part.signals.insert(dof.velocity().into(), Signal::new(pick(velocity.time()).into(), pick(velocity.values())));
        let mean = mean_of(run, dof.velocity(), window)?;
        let direction = if mean.value < 0.0 { Direction::Negative } else { Direction::Positive };
        Some(Steady { run: part, direction })
    };
    steady_windows(run, dof.velocity(), Some(dof.force()), options.steady).into_iter().filter_map(of_window).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_quantiles_of_student() {
        // tables: t(0.97725) is 13.97 for 1, 3.307 for 3 and 2.0 for infinitely many degrees of freedom
        for (freedom, quantile) in [(1.0, 13.97), (3.0, 3.307), (1e6, 2.0)] {
            assert!((2.0 * student(freedom) / quantile - 1.0).abs() < 1e-3, "four printed digits: {freedom}");
        }
    }
}
