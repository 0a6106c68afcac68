//! Stage (ii): drag from constant-velocity runs and from towing.
//!
//! ```text
//! τᵢ − (W − B) sin θ = k_Q ν|ν| + k_L ν + b        (18), (19): one row per steady window, means over it
//! ```
//!
//! In towing, the reading of the load cell replaces the thrust. Rows are the regressors of the
//! model itself, integrated over the window and divided by its length, without inertia: so the
//! pitch term, a drag per direction, or any other effect of the model takes part. With few windows
//! the standard deviations are widened by Student's t, so that two of them cover 95.4 %.

use super::result::Stage;
use super::stage_covariance::{Direction, Found, Held, How, Known};
use super::{ProcedureError, SteadyStage, codes, parameters_at, parameters_of};
use crate::chain::{Nature, nature};
use crate::effects::id;
use crate::estimate::{Columns, Mean, RegressorOptions, Span, StdMethod, SteadyWindow, mean_of, steady_windows};
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, Signal};

/// A run cut to a steady window, and its direction of motion.
struct Steady {
    run: Run,
    direction: Direction,
}

/// Result of a drag stage.
pub(super) struct Drag {
    pub stages: Vec<Stage>,
    /// The fit of all windows.
    pub found: Found,
    /// Fits of one direction each: both or none.
    ways: Vec<(Found, Direction)>,
}

impl Drag {
    /// Estimated parameters with their standard deviations.
    pub fn deviations(&self) -> Vec<(usize, f64)> {
        self.found.fit.parameters.iter().enumerate().map(|(k, c)| (c.parameter, self.found.fit.std(k))).collect()
    }

    /// Adds J cov(D) Jᵀ to the covariance of quantities whose derivative with respect to this drag
    /// is `jacobian`.
    pub fn carry(&self, jacobian: &[Vec<f64>], covariance: &mut [Vec<f64>]) {
        let own = &self.found.fit.covariance;
        for (i, row) in covariance.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                let through = |(k, a): (usize, &f64)| -> f64 {
                    jacobian[j].iter().enumerate().map(|(l, b)| a * own[k][l] * b).sum()
                };
                *entry += jacobian[i].iter().enumerate().map(through).sum::<f64>();
            }
        }
    }

    /// Passes the drag to later stages, by direction if it was estimated so.
    pub fn hold(&self, held: &mut Held, model: &Model, dof: Dof) {
        let every: Vec<usize> = self.found.fit.parameters.iter().map(|c| c.parameter).collect();
        let drag = parameters_of(model, dof, Nature::Drag);
        let asymmetry = model.at(id::DRAG_ASYMMETRY, dof);
        let quadratic = model.at(id::QUADRATIC_DRAG, dof);
        let of_all = held.add(&self.found, &every, None);
        for (part, direction) in &self.ways {
            let extra = |p: usize| asymmetry.filter(|_| Some(p) == quadratic);
            held.add_direction(part, &drag, *direction, (&self.found, &of_all), extra);
        }
        if !self.ways.is_empty() {
            // each direction has its complete drag, so the asymmetry is 0
            for p in parameters_at(model, dof, &[id::DRAG_ASYMMETRY]) {
                for direction in [Direction::Positive, Direction::Negative] {
                    held.know(Known::Parameter(p, Some(direction)), 0.0, &[0.0]);
                }
            }
        }
    }
}

/// Drag of `dof` from `runs` of constant velocity, with nominal forces; `Ok(Err(…))` is a finding
/// that says why there is none.
pub(super) fn stage(
    name: &str,
    dof: Dof,
    runs: &[&Run],
    model: &Model,
    held: &Held,
    options: &SteadyStage,
) -> Result<Result<Drag, Finding>, ProcedureError> {
    let windows: Vec<Steady> = runs.iter().flat_map(|run| cut(run, dof, options)).collect();
    if windows.is_empty() {
        let text = format!("{name}, {dof}: no steady window in {} runs", runs.len());
        return Ok(Err(Finding::new(&codes::NO_STEADY, text)));
    }
    let still = without_inertia(model, dof);
    let drag = parameters_of(model, dof, Nature::Drag);
    let with_bias = [drag.clone(), parameters_at(model, dof, &[id::BIAS])].concat();
    let all: Vec<&Run> = windows.iter().map(|w| &w.run).collect();
    let free = if all.len() > with_bias.len() { &with_bias } else { &drag };
    let found = match ProcedureError::unless_data(name, dof, means(dof, &all, &still, free, held))? {
        Ok(found) => found,
        Err(finding) => return Ok(Err(finding)),
    };
    let mut stages = vec![of(name, dof, &all, &still, &found)];
    let mut ways = Vec::new();
    if options.per_direction && dof == Dof::Yaw {
        for (direction, word) in [(Direction::Positive, "clockwise"), (Direction::Negative, "anticlockwise")] {
            let of_it: Vec<&Run> = windows.iter().filter(|w| w.direction == direction).map(|w| &w.run).collect();
            // a parameter that only separates the directions is not in a fit of one direction
            let one_way: Vec<usize> =
                free.iter().copied().filter(|p| model.parameters[*p].effect != id::DRAG_ASYMMETRY).collect();
            if of_it.len() > one_way.len()
                && let Ok(found) = ProcedureError::unless_data(name, dof, means(dof, &of_it, &still, &one_way, held))?
            {
                stages.push(of(&format!("{name} {word}"), dof, &of_it, &still, &found));
                ways.push((found, direction));
            }
        }
        if ways.len() < 2 {
            stages.truncate(1);
            ways.clear();
        }
    }
    Ok(Ok(Drag { stages, found, ways }))
}

/// The run with the reading of the load cell in place of the nominal force.
pub fn towed(run: &Run, dof: Dof) -> Option<Run> {
    let load = run.signal(dof.load())?.clone();
    let mut towed = run.clone();
    // the carriage moves the vehicle straight ahead and level: motion that is not logged is 0
    for other in Dof::ALL {
        for name in [other.velocity(), other.position()] {
            let zero = || Signal::new(load.shared_time().clone(), vec![0.0; load.len()]);
            towed.signals.entry(name.to_string()).or_insert_with(zero);
        }
    }
    towed.signals.insert(dof.force().into(), load);
    Some(towed)
}

/// Mean velocity and mean force of `dof` over each steady window of a run, m/s and N or rad/s and N·m.
pub fn steady_means(run: &Run, dof: Dof, options: &SteadyStage) -> Vec<(Mean, Mean)> {
    let mean = |window: &Steady| {
        let (from, to) = window.run.signal(dof.velocity()).map(|v| (v.time()[0], v.time()[v.len() - 1]))?;
        let whole = SteadyWindow { from, to };
        Some((mean_of(&window.run, dof.velocity(), whole)?, mean_of(&window.run, dof.force(), whole)?))
    };
    cut(run, dof, options).iter().filter_map(mean).collect()
}

fn of(name: &str, dof: Dof, windows: &[&Run], model: &Model, found: &Found) -> Stage {
    let fit = &found.fit;
    let widening = found.widening;
    let mut names: Vec<String> = windows.iter().map(|r| r.name.clone()).collect();
    names.dedup();
    let mut stage = Stage::of_fit(name, dof, names, model, fit);
    if widening > 1.1 {
        let text = format!(
            "{name}, {dof}: {} steady windows for {} parameters; standard errors are widened by {widening:.2}",
            fit.rows,
            fit.values.len()
        );
        stage.warnings.push(Finding::new(&codes::FEW_SPEEDS, text));
    }
    stage
}

/// Fits the mean forces over the windows.
fn means(
    dof: Dof,
    runs: &[&Run],
    model: &Model,
    free: &[usize],
    held: &Held,
) -> Result<Found, crate::estimate::IntegralError> {
    let regressor = RegressorOptions { span: Span::Samples(usize::MAX), ..RegressorOptions::default() };
    let over_time = |columns: &mut Columns| {
        for (row, (from, to)) in columns.span.iter().enumerate() {
            let length = to - from;
            columns.rhs[row] /= length;
            columns.columns.iter_mut().for_each(|c| c[row] /= length);
        }
    };
    held.fit((dof, runs), model, free, How { regressor, std: StdMethod::Paper, few: true }, &over_time)
}

/// `model` at constant velocity: its momentum in `dof` does not change.
fn without_inertia(model: &Model, dof: Dof) -> Model {
    let mut still = model.clone();
    for term in model.terms.iter().filter(|t| t.place.dof == Some(dof) && nature(model, t) == Nature::Inertia) {
        term.parameters.iter().for_each(|p| still.parameters[*p].value = 0.0);
    }
    still
}

/// The steady windows of a run: only its own velocity is cut, all other channels stay whole.
fn cut(run: &Run, dof: Dof, options: &SteadyStage) -> Vec<Steady> {
    let Some(velocity) = run.signal(dof.velocity()).filter(|s| !s.is_empty()) else { return Vec::new() };
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
    let given: Vec<SteadyWindow> =
        options.windows.iter().filter(|w| w.run == run.name).map(super::options::GivenWindow::window).collect();
    let found = || {
        let (first, last) = (velocity.time()[0], velocity.time()[velocity.len() - 1]);
        let late = run.between(last - options.steady_part * (last - first), last);
        steady_windows(&late, dof.velocity(), Some(dof.force()), options.limits())
    };
    let windows = if given.is_empty() { found() } else { given };
    windows.into_iter().filter_map(of_window).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 40 s: a ramp to 1 m/s over 10 s, then steady.
    fn run() -> Run {
        let time: Vec<f64> = (0..=400).map(|k| 0.1 * f64::from(k)).collect();
        let mut run = Run { name: "a.csv".into(), ..Run::default() };
        let speed: Vec<f64> = time.iter().map(|t| (0.1 * t).min(1.0)).collect();
        run.signals.insert("tau_u".into(), Signal::new(time.clone().into(), vec![100.0; time.len()]));
        run.signals.insert("u".into(), Signal::new(time.into(), speed));
        run
    }

    #[test]
    fn windows_are_found_in_the_last_part_or_given() {
        let span = |options: &SteadyStage| -> Vec<(f64, f64)> {
            cut(&run(), Dof::Surge, options)
                .iter()
                .filter_map(|s| s.run.signal("u"))
                .map(|u| (u.time()[0], u.time()[u.len() - 1]))
                .collect()
        };
        assert_eq!(span(&SteadyStage::default()), [(20.0, 40.0)]);
        let given = |run: &str| {
            let window = super::super::options::GivenWindow { run: run.into(), from: 12.0, to: 15.0 };
            SteadyStage { windows: vec![window], ..SteadyStage::default() }
        };
        assert_eq!(span(&given("a.csv")), [(12.0, 15.0)]);
        assert_eq!(span(&given("b.csv")), [(20.0, 40.0)], "windows of another run");
        let means = steady_means(&run(), Dof::Surge, &SteadyStage::default());
        assert_eq!(means.len(), 1);
        // exact but for the rounding of a mean of 201 samples
        assert!((means[0].0.value - 1.0).abs() < 1e-12 && (means[0].1.value - 100.0).abs() < 1e-10);
    }

    #[test]
    fn a_speed_that_wanders_is_steady_within_the_scatter() {
        let mut wandering = run();
        let time = wandering.signals["u"].shared_time().clone();
        // a standard deviation of 3 % about 1 m/s
        let speed: Vec<f64> = time.iter().map(|t| 1.0 + 0.03 * f64::sqrt(2.0) * (2.0 * t).sin()).collect();
        wandering.signals.insert("u".into(), Signal::new(time, speed));
        let windows =
            |scatter| cut(&wandering, Dof::Surge, &SteadyStage { scatter, drift: 0.1, ..SteadyStage::default() }).len();
        assert_eq!((windows(0.08), windows(0.01)), (1, 0));
    }
}
