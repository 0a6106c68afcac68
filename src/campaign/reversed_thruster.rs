//! One thruster that is reversed in all runs.
//!
//! ```text
//! F' = −F(V)   its axis is reversed: the propeller faces the other way
//! F' = F(−V)   its command is reversed: the motor turns the other way
//! τ' = τ + b (F' − F)         b: force or moment of the thruster per N
//! ```
//!
//! The two differ where a thruster pushes weaker astern. No effect of the catalogue turns a
//! thruster, and a model whose thrusters work against each other lacks so much that a search ends in
//! stand-ins, after minutes. The search works on the turned force; the files stay unchanged.

use super::check::driven;
use super::load::Campaign;
use crate::check::wiring;
use crate::discover::LogFinding;
use crate::frame::Dof;
use crate::run::{Role, Run, Signal, thruster_command, thruster_force};
use crate::thrust::efficiency::Efficiency;
use crate::thrust::thruster::Thruster;

/// What is reversed of a thruster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum What {
    Command,
    Axis,
}

/// A reversed thruster.
#[derive(Debug)]
pub(super) struct Reversed {
    thruster: usize,
    what: What,
    gained: String,
}

impl Reversed {
    /// Returns the thruster that the runs of the fit show to be reversed.
    pub fn shown(campaign: &Campaign, runs: &[Run]) -> Option<Reversed> {
        let thrusters = &campaign.file.thrusters;
        // losses that depend on all thrusters together were applied to the wrong forces
        if thrusters.len() < 2 || campaign.file.efficiency != Efficiency::default() {
            return None;
        }
        let train: Vec<&Run> = runs.iter().filter(|run| run.role == Role::Train).collect();
        let dofs = driven(campaign);
        let (thruster, gained) = wiring::reversed(&train, &dofs, thrusters)?;
        let explained = |what: What| {
            let mut turned: Vec<Run> = train.iter().map(|run| (*run).clone()).collect();
            turned.iter_mut().for_each(|run| turn(run, thruster, what, thrusters));
            wiring::explained(&turned.iter().collect::<Vec<_>>(), &dofs, thrusters)
        };
        let what = if explained(What::Axis) > explained(What::Command) { What::Axis } else { What::Command };
        Some(Reversed { thruster, what, gained })
    }

    /// Turns its force.
    pub fn mend(&self, campaign: &Campaign, runs: &mut [Run]) {
        runs.iter_mut().for_each(|run| turn(run, self.thruster, self.what, &campaign.file.thrusters));
    }

    /// Returns the fault as an entry of the discovery's result.
    pub fn finding(&self) -> LogFinding {
        let channel = thruster_command(self.thruster);
        LogFinding { kind: "sign".into(), channel, factor: -1.0, message: self.to_string() }
    }
}

/// Puts the force of a reversed thruster into a run, and its difference into the totals.
fn turn(run: &mut Run, thruster: usize, what: What, thrusters: &[Thruster]) {
    let Some(given) = run.signals.get(&thruster_force(thruster)).cloned() else { return };
    let (curve, volts) = (thrusters[thruster].curve(), run.supply_voltage().cloned());
    let turned = |t: f64, force: f64| match (what, &volts) {
        (What::Axis, _) => -force,
        (What::Command, Some(volts)) => {
            let supply = volts.at(t);
            curve.force_at(-curve.inverse_at(force, supply).voltage, supply)
        }
        (What::Command, None) => curve.force(-curve.inverse(force).voltage),
    };
    let values: Vec<f64> = given.time().iter().zip(given.values()).map(|(t, force)| turned(*t, *force)).collect();
    let change: Vec<f64> = values.iter().zip(given.values()).map(|(new, old)| new - old).collect();
    let change = Signal::new(given.shared_time().clone(), change);
    let share = thrusters[thruster].unit_wrench();
    for dof in Dof::ALL {
        let per_newton = share[dof.index()];
        if let Some(total) = run.signals.get_mut(dof.force()).filter(|_| per_newton.abs() > 0.0) {
            let pairs = total.time().iter().zip(total.values());
            let sum: Vec<f64> = pairs.map(|(t, x)| x + per_newton * change.at(*t)).collect();
            *total = Signal::new(total.shared_time().clone(), sum);
        }
    }
    run.signals.insert(thruster_force(thruster), Signal::new(given.shared_time().clone(), values));
}

impl std::fmt::Display for Reversed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Reversed { thruster, what, gained } = self;
        let command = thruster_command(*thruster);
        let remedy = match what {
            What::Command => format!("set sign = -1 in columns.{command}"),
            What::Axis => "turn its axis in [[thruster]]".to_string(),
        };
        let number = thruster + 1;
        write!(f, "thruster {number} is reversed ({command}): with it turned the thrusters explain {gained}; {remedy}")
    }
}
