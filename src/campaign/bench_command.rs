//! Conversion of the command of a bench run to the command that the curve of its thruster takes.

use super::codes;
use super::logs::Logged;
use crate::finding::Finding;
use crate::run::{Run, Signal, thruster_of};
use crate::thrust::thruster::Thruster;

/// Neutral and span of a pulse, µs, for a thruster that does not state them: the usual values of
/// its drives.
const PULSE: [f64; 2] = [1500.0, 400.0];

/// Returns the column with the command of a bench run, if exactly one of `V1`, `V2`, … is logged.
pub(super) fn command_of(run: &Run) -> Option<String> {
    let mut columns = run.signals.keys().filter(|name| thruster_of(name, "V").is_some());
    let only = columns.next()?;
    columns.next().is_none().then(|| only.clone())
}

/// Converts the command of a bench run to that of the curve: a pulse by the thruster's neutral and
/// span.
///
/// # Errors
/// A finding if there is no command, or more than one.
pub(super) fn commanded(logged: &mut Logged, thrusters: &[Thruster]) -> Result<(), Vec<Finding>> {
    let name = logged.run.name.clone();
    let Some(column) = command_of(&logged.run) else {
        let text = "a bench run has one column with the command of its thruster, V1 to V99, and `force`";
        return Err(vec![Finding::at(&codes::NO_THRUSTER, &name, None, Some("V1"), text).of_run(&name)]);
    };
    if logged.units.get(&column) == Some(&"us") {
        let thruster = column[1..].parse::<usize>().ok().and_then(|n| thrusters.get(n.wrapping_sub(1)));
        let neutral = thruster.and_then(|t| t.neutral).unwrap_or(PULSE[0]);
        let span = thruster.and_then(|t| t.span).unwrap_or(PULSE[1]);
        let signal = &logged.run.signals[&column];
        let values: Vec<f64> = signal.values().iter().map(|x| (x - neutral) / span).collect();
        let signal = Signal::new(signal.shared_time().clone(), values);
        logged.run.signals.insert(column, signal);
    }
    Ok(())
}
