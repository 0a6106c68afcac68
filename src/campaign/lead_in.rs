//! First seconds of a log that begins under way, where late thrust depends on commands from before
//! the log.
//!
//! ```text
//! τ(t) = command(t − T)    known from t₀ + T on
//! sensors are used from t₀ + 2 s on, commands from t₀ on
//! ```
//!
//! If the first command of the log is taken for the commands before it, a model with late thrust is
//! pushed the wrong way, and the error looks like a missing effect. A log that begins with
//! thrusters and vehicle at rest has no earlier commands. If the vehicle moves while the command is
//! zero, the command swings through zero.

use crate::frame::Dof;
use crate::model::Model;
use crate::run::{Run, Signal};

/// Time that is left out, s: the longest delay that the search starts with (1.6 s), and a little
/// more.
const LEAD: f64 = 2.0;

/// Largest share of a run that is left out.
const MOST: f64 = 0.1;

/// Ratio of a command to the greatest one below which the thrusters are at rest.
const AT_REST: f64 = 1e-3;

/// Ratio of a velocity to the greatest one below which the vehicle is at rest, and number of
/// samples whose mean is taken, because noise is no motion.
const SLOW: (f64, usize) = (0.1, 5);

/// Whether the thrust of a model is late.
pub(super) fn is_late(model: &Model) -> bool {
    model.terms.iter().any(|term| term.effect.delays_command().is_some())
}

/// Returns the runs without the first seconds of the channels that `model` predicts, where commands
/// from before the log may act: in runs that begin under way and, if the thrust of the model is
/// late, in runs whose vehicle moves while its command swings through zero.
pub(super) fn settled(mut runs: Vec<Run>, model: &Model) -> Vec<Run> {
    let predicted = |dof: &Dof| [dof.velocity(), dof.position()].map(str::to_string);
    let functions = model.observers.iter().map(|observer| observer.channel().to_string());
    let channels: Vec<String> = model.dofs.iter().flat_map(predicted).chain(functions).collect();
    let late = is_late(model);
    for run in runs.iter_mut().filter(|run| begins_under_way(run) || late && moves_at_first(run)) {
        let Some((first, last)) = run.span() else { continue };
        let from = first + LEAD.min(MOST * (last - first));
        for name in &channels {
            let Some(signal) = run.signals.get_mut(name) else { continue };
            let k = signal.time().partition_point(|t| *t < from);
            *signal = Signal::new(signal.time()[k..].into(), signal.values()[k..].to_vec());
        }
    }
    runs
}

fn begins_under_way(run: &Run) -> bool {
    let commands = || Dof::ALL.into_iter().filter_map(|dof| run.signal(dof.force()));
    let greatest = commands().flat_map(|s| s.values()).fold(0.0, |m: f64, x| m.max(x.abs()));
    commands().filter_map(|s| s.values().first()).any(|x| x.abs() > AT_REST * greatest)
}

/// Whether a velocity with a command differs from that of a vehicle at rest when the log begins.
fn moves_at_first(run: &Run) -> bool {
    let (slow, samples) = SLOW;
    let commanded = |dof: &Dof| run.signal(dof.force()).is_some_and(|s| s.values().iter().any(|x| *x != 0.0));
    let moves = |dof: Dof| {
        let velocity = run.signal(dof.velocity()).map_or(&[][..], Signal::values);
        let first = &velocity[..samples.min(velocity.len())];
        let fastest = velocity.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        first.iter().sum::<f64>().abs() > slow * fastest * first.len() as f64
    };
    Dof::ALL.into_iter().filter(commanded).any(moves)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;

    fn run(first: f64) -> Run {
        let time: std::sync::Arc<[f64]> = (0..601).map(|k| 0.1 * f64::from(k)).collect();
        let mut run = Run::default();
        for name in ["u", "x", "w", "supply_V"] {
            run.signals.insert(name.into(), Signal::new(time.clone(), vec![1.0; 601]));
        }
        let mut command = vec![5.0; 601];
        command[0] = first;
        run.signals.insert("tau_u".into(), Signal::new(time, command));
        run
    }

    /// The same from rest: the vehicle gathers speed.
    fn gathering(first: f64) -> Run {
        let mut run = run(first);
        let time = run.signals["u"].shared_time().clone();
        let speed: Vec<f64> = time.iter().map(|t| 1.0 - (-t / 5.0).exp()).collect();
        run.signals.insert("u".into(), Signal::new(time, speed));
        run
    }

    #[test]
    fn a_log_that_begins_under_way_is_asked_two_seconds_later() {
        let model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "thrust_delay"]).unwrap();
        assert!(is_late(&model));
        let first = |run: &Run, name: &str| run.signals[name].time()[0];
        let cut = &settled(vec![run(5.0)], &model)[0];
        assert!((first(cut, "u") - 2.0).abs() < 1e-9 && (first(cut, "x") - 2.0).abs() < 1e-9);
        for name in ["tau_u", "w", "supply_V"] {
            assert_eq!(first(cut, name), 0.0, "{name} is no prediction of the model");
        }
        let still = &settled(vec![gathering(0.0)], &model)[0];
        assert_eq!(first(still, "u"), 0.0, "from rest nothing is before");
        let swings = &settled(vec![run(0.0)], &model)[0];
        assert!((first(swings, "u") - 2.0).abs() < 1e-9, "its command swings through zero");
    }
}
