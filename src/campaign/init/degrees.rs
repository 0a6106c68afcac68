//! The degrees of freedom of the model: those that some dive measures, moves and drives.
//!
//! Sway and heave without a command are modelled beside the two motions that throw a vehicle
//! outwards when it turns at speed. So is the surge of a vehicle that fins steer under a constant
//! thrust: turns slow it down, and the thrust is one unknown force.

use super::reading::Understood;
use super::{drives, kinds};
use crate::check::fins;
use crate::check::motion::{self, Moved};
use crate::effects::{Place, id};
use crate::frame::Dof;
use crate::model::name_of;
use crate::thrust::thruster::Thruster;

/// Message if no degree of freedom is left, also for the terminal.
const IDLE: &str = "no degree of freedom moves under a command: nothing can be learned from these logs";

/// The degrees of freedom that are modelled, and the remarks about the others.
pub struct Chosen {
    pub dofs: Vec<Dof>,
    pub words: Vec<String>,
    /// Those that are modelled though nothing commands them.
    pub undriven: Vec<Dof>,
    /// Whether the vehicle is pushed ahead by a thrust that never varies or is not logged.
    pub pushed: bool,
    /// Whether it is pushed by a thrust known only up to a factor: its curve is guessed, or the
    /// hull takes a part of it.
    pub scaled: bool,
    /// Message for the terminal: nothing moves under a command.
    pub idle: Option<String>,
    /// Messages for the terminal: degrees of freedom without a command or a measurement.
    pub left_out: Vec<String>,
}

impl Chosen {
    /// Chooses the degrees of freedom for `logs` of a vehicle with these thrusters.
    pub fn of(logs: &[Understood], thrusters: &[Thruster]) -> Chosen {
        let (mut dofs, mut drifting, mut absent) = (Vec::new(), Vec::new(), Vec::new());
        let (mut measured_all, mut driven_all, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
        let mut held = Vec::new();
        let read = || logs.iter().filter_map(|log| log.log.as_ref());
        for dof in Dof::ALL {
            let is_loaded = read().any(|log| log.signals.contains_key(dof.load()));
            let is_towed = logs.iter().any(|log| kinds::is_towed(log, dof));
            let moved = read().map(|log| motion::of(&log.signals, dof)).max().unwrap_or(Moved::Unmeasured);
            let moved = if is_towed { Moved::Moves } else { moved };
            let driven =
                is_towed || logs.iter().any(|log| is_driven(log, dof, thrusters)) || differs(logs, dof, thrusters);
            if is_loaded && moved < Moved::Moves {
                // a bollard pull: thrusters push, and nothing is to move
                held.push(dof);
                continue;
            }
            if moved > Moved::Unmeasured {
                measured_all.push(dof);
                driven_all.extend(driven.then_some(dof));
            }
            match (moved, driven) {
                (Moved::Moves, true) => dofs.push(dof),
                (Moved::Moves, false) => drifting.push(dof),
                (Moved::Rests, _) => absent.push((dof, "it does not move beyond the noise of its sensor")),
                (Moved::Unmeasured, true) => {
                    absent.push((dof, "no log measures it"));
                    // guessed thrusters may drive degrees of freedom of which nothing is logged: no
                    // message then
                    if read().any(|log| log.signals.contains_key(dof.force())) {
                        left_out.push(format!("{dof} (commanded, but no log measures it)"));
                    }
                }
                (Moved::Unmeasured, false) => {}
            }
        }
        let (mut words, mut undriven, mut pushed) = (Vec::new(), Vec::new(), false);
        for dof in drifting {
            if dof == Dof::Surge && is_steered(logs) {
                let slowed = format!("{dof}: no varying command drives it, but turns with the fins slow it down");
                pushed = !thrusters.iter().any(|t| t.unit_wrench()[dof.index()].abs() > 1e-6);
                words.push(match pushed {
                    true => format!("{slowed}; its thrust is one unknown force, {}", name_of(id::BIAS, Place::at(dof))),
                    false => slowed,
                });
                dofs.push(dof);
                undriven.extend(pushed.then_some(dof));
                continue;
            }
            // turning at speed throws a vehicle outwards: it drifts, and the drift shows its drag
            let thrown = match dof {
                Dof::Sway => Some([Dof::Surge, Dof::Yaw]),
                Dof::Heave => Some([Dof::Surge, Dof::Pitch]),
                _ => None,
            };
            match thrown.filter(|thrown| thrown.iter().all(|dof| dofs.contains(dof))) {
                Some([ahead, turn]) => {
                    words.push(format!(
                        "{dof}: no command drives it, but {ahead} and {turn} together throw the vehicle outwards"
                    ));
                    dofs.push(dof);
                    undriven.push(dof);
                }
                None => {
                    let why = "it moves, but no command drives it";
                    absent.push((dof, why));
                    left_out.push(format!("{dof} ({why})"));
                }
            }
        }
        dofs.sort_unstable();
        let is_unread = !logs.is_empty() && read().next().is_none();
        // a bench and a bollard pull show thrust: no motion is expected
        let is_bench = read().next().is_some() && logs.iter().filter(|log| log.log.is_some()).all(kinds::is_bench);
        let is_idle = !is_unread && !is_bench && held.is_empty() && dofs.is_empty();
        let is_still = !is_unread && dofs.is_empty();
        if is_still {
            match held.is_empty() {
                false => words.push(
                    "load cells measure the force, but no log shows motion: these are listed for runs with motion to \
                     come"
                        .into(),
                ),
                true if is_bench => {
                    words.push(
                        "a bench shows a thruster and no motion: these are listed for runs with motion to come".into(),
                    );
                }
                true => {}
            }
            dofs = held;
        }
        // if nothing can be modelled, all degrees of freedom that are there stand in the model,
        // with a remark
        let out = if is_still { "" } else { " is left out" };
        words.splice(0..0, absent.into_iter().map(|(dof, why)| format!("{dof}{out}: {why}")));
        let mut idle = None;
        if is_unread {
            words.push("no log could be read: these are listed as an example".into());
        } else if is_idle {
            words.push(format!("{IDLE}; those that are measured or driven are listed all the same"));
            let moving: Vec<&str> = measured_all.iter().map(|dof: &Dof| dof.force()).collect();
            let of = if moving.is_empty() { "tau_u or V1".into() } else { format!("{} or V1", moving.join(", ")) };
            idle =
                Some(format!("{IDLE}; name the columns of the commands: --log 'columns.NAME = \"HEADER\"' for {of}"));
            dofs = if driven_all.is_empty() { measured_all } else { driven_all };
            left_out.clear();
        }
        if dofs.is_empty() {
            dofs = vec![Dof::Surge, Dof::Sway, Dof::Yaw];
        }
        let forced = read().any(|log| log.signals.keys().any(|name| name.starts_with("tau_")));
        let ahead = thrusters.iter().any(|t| t.unit_wrench()[Dof::Surge.index()].abs() > 1e-6);
        let scaled = ahead && !pushed && !forced && dofs.contains(&Dof::Surge) && is_steered(logs);
        Chosen { dofs, words, undriven, pushed, scaled, idle, left_out }
    }
}

/// Whether fins whose angles are logged steer the vehicle.
pub fn is_steered(logs: &[Understood]) -> bool {
    logs.iter().filter_map(Understood::as_run).any(|run| !fins::steered(&run).is_empty())
}

/// Whether the command of a thruster that pushes in `dof` begins with another value in one log than
/// in another.
fn differs(logs: &[Understood], dof: Dof, thrusters: &[Thruster]) -> bool {
    let first = |k: usize| logs.iter().filter_map(move |l| drives::signals(l).get(k)?.values().first().copied());
    let pushes = (0..thrusters.len()).filter(|k| thrusters[*k].unit_wrench()[dof.index()].abs() > 1e-6);
    pushes.into_iter().any(|k| first(k).any(|x| first(k).next().is_some_and(|y| x.to_bits() != y.to_bits())))
}

/// Whether a log commands `dof`.
fn is_driven(understood: &Understood, dof: Dof, thrusters: &[Thruster]) -> bool {
    let Some(log) = &understood.log else { return false };
    if log.signals.get(dof.force()).is_some_and(|force| force.values().iter().any(|x| *x != 0.0)) {
        return true;
    }
    // fins may turn a vehicle that no thruster turns
    if understood.as_run().is_some_and(|run| fins::steered(&run).contains(&dof)) {
        return true;
    }
    if log.signals.keys().any(|name| name.starts_with("tau_")) {
        return false;
    }
    let signals = drives::signals(understood);
    thrusters.iter().zip(signals).any(|(t, s)| t.unit_wrench()[dof.index()].abs() > 1e-6 && s.varies())
}
