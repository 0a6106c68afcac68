//! The terminal output of `simulate`: the error of each run's simulation.

use super::answer;
use super::output::Output;
use super::table::{number, size, table};
use crate::campaign::{Simulated, Simulation};
use crate::frame::Dof;
use crate::run::Role;
use crate::wording::count;

/// The error of one run in the degree of freedom in which it is greatest relative to the motion.
struct Error {
    dof: Dof,
    rms: f64,
    /// Root mean square of the measured velocity of this run.
    motion: f64,
    /// Greatest root mean square of the measured velocity over all runs: a run at rest has no
    /// motion of its own.
    most: f64,
}

impl Error {
    fn share(&self) -> f64 {
        self.rms / self.most.max(f64::MIN_POSITIVE)
    }
}

pub(super) fn print(result: &Simulation, output: &Output) {
    let errors: Vec<(&Simulated, Option<Error>)> =
        result.runs.iter().map(|run| (run, worst(run, &result.runs))).collect();
    answer::verdict(&verdict(&errors), output);
    let row = |(run, error): &(&Simulated, Option<Error>)| {
        let seconds = run.time.last().zip(run.time.first()).map_or(0.0, |(b, a)| b - a);
        let role = format!("{:?}", run.role).to_lowercase();
        let mut row = vec![run.run.clone(), role, number(seconds)];
        row.extend(match error {
            Some(e) => [e.dof.to_string(), size(e.rms), size(e.motion), unit(e.dof).into()],
            None => ["-", "-", "-", ""].map(String::from),
        });
        row
    };
    let rows: Vec<Vec<String>> = errors.iter().map(row).collect();
    if !rows.is_empty() {
        output.print(&table(&["run", "role", "s", "worst in", "rms error", "rms motion", "unit"], &rows));
    }
    if output.is_verbose() {
        let row = |run: &Simulated| {
            let channels: Vec<&str> = run.simulated.keys().map(String::as_str).collect();
            vec![run.run.clone(), run.time.len().to_string(), channels.join(" ")]
        };
        output.print(&table(&["run", "instants", "simulated"], &result.runs.iter().map(row).collect::<Vec<_>>()));
    }
}

fn unit(dof: Dof) -> &'static str {
    if dof.is_rotation() { "rad/s" } else { "m/s" }
}

fn verdict(errors: &[(&Simulated, Option<Error>)]) -> String {
    let is_held = |run: &Simulated| run.role == Role::Validate;
    let any_held = errors.iter().any(|(run, _)| is_held(run));
    let judged = errors.iter().filter(|(run, _)| !any_held || is_held(run));
    let known = judged.filter_map(|(run, error)| Some((run, error.as_ref()?)));
    let worst = known.max_by(|a, b| a.1.share().total_cmp(&b.1.share()));
    let runs = count(errors.len(), "run");
    let of = if any_held { "Among the held-out runs" } else { "Among them" };
    // `compare` ranks by another measure: the predicted error
    match worst {
        None => format!("{runs} simulated; none logs a velocity that the model predicts."),
        Some((run, e)) => format!(
            "{runs} simulated. {of}, the largest error relative to the motion is in {} of {}: {} {} (rms), {:.0} % of \
             the motion in the run that moves most there.",
            e.dof,
            run.run,
            size(e.rms),
            unit(e.dof),
            100.0 * e.share()
        ),
    }
}

/// The degree of freedom with the greatest error of a run's simulation, relative to the motion in
/// all runs.
fn worst(run: &Simulated, all: &[Simulated]) -> Option<Error> {
    let of = |dof: Dof| {
        let rms = rms(run, dof, |y, x| y - x)?;
        let moved = |run: &Simulated| self::rms(run, dof, |y, _| y);
        let most = all.iter().filter_map(moved).fold(0.0, f64::max);
        Some(Error { dof, rms, motion: moved(run)?, most })
    };
    Dof::ALL.into_iter().filter_map(of).max_by(|a, b| a.share().total_cmp(&b.share()))
}

/// Root mean square of a function of measured and simulated velocity; `None` if there is no
/// measurement.
fn rms(run: &Simulated, dof: Dof, of: impl Fn(f64, f64) -> f64) -> Option<f64> {
    let (measured, simulated) = (run.measured.get(dof.velocity())?, run.simulated.get(dof.velocity())?);
    let squares: Vec<f64> = measured.iter().zip(simulated).filter_map(|(y, x)| Some(of((*y)?, *x).powi(2))).collect();
    (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}
