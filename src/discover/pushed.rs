//! Random forces compared with the commands: usual forces of water, larger ones, and ones that allow no identification.
//!
//! ```text
//! σ_d / rms τ_d        > 0.2: pushed hard        > 10: what moves the vehicle is not its commands
//! ```

use crate::estimate::filter_error::{FilterErrorFit, RandomForce};
use crate::frame::Dof;
use crate::run::{Run, commanded_rms};

/// Share of the command's rms above which a random force is too large for water: turbulence and tethers stay at 0.1.
const MUCH: f64 = 0.2;

/// Correlation time above which a force is slow, s: three times that of the slowest force of water.
const SLOW: f64 = 10.0;

/// Whether a force is slower than forces of water.
pub(super) fn is_slow(force: &RandomForce) -> bool {
    force.time > SLOW
}

/// Whether a force is slow enough to follow an effect that differs from run to run: if its correlation time is half of
/// [`SLOW`], its mean over a minute still has 0.4 of its standard deviation.
pub(super) fn is_slow_within_a_run(force: &RandomForce) -> bool {
    force.time > 0.5 * SLOW
}

/// Whether random forces instead of the commands move the vehicle in at least half of the commanded degrees of
/// freedom. Force and inertia are then indistinguishable, and fits go astray for hours. Only an effect on the
/// commands may correct it: two swapped thrusters make the commands meaningless.
pub(super) fn is_hopeless(fit: &FilterErrorFit, runs: &[Run]) -> bool {
    let commanded = fit.model.dofs.iter().filter(|dof| commanded_rms(runs, **dof).is_some()).count();
    let lost = overwhelmed(&fit.noise.forces, runs).len();
    lost > 0 && 2 * lost >= commanded
}

/// Degrees of freedom that are commanded on `runs` but moved by a random force, with the ratio of force to command.
pub(super) fn overwhelmed(forces: &[RandomForce], runs: &[Run]) -> Vec<(Dof, f64)> {
    beside_commands(forces, runs, |_, times| times > RandomForce::OVERWHELMING)
}

/// Commanded degrees of freedom in which the random force is too large for turbulence and tethers.
pub(super) fn pushed_hard(forces: &[RandomForce], runs: &[Run]) -> Vec<(Dof, f64)> {
    beside_commands(forces, runs, |_, times| times > MUCH)
}

/// Degrees of freedom in which a random force lasts for tens of seconds and is a good part of the commands, with the
/// ratio of their root mean squares: a tether, a tide or a payload, not turbulence.
pub(super) fn lasting(forces: &[RandomForce], runs: &[Run]) -> Vec<(Dof, f64)> {
    beside_commands(forces, runs, |force, times| is_slow(force) && times > MUCH)
}

/// Commanded degrees of freedom whose force satisfies `is_too_much`, with the ratio of the force to the command's
/// root mean square.
fn beside_commands(
    forces: &[RandomForce],
    runs: &[Run],
    is_too_much: impl Fn(&RandomForce, f64) -> bool,
) -> Vec<(Dof, f64)> {
    let times = |force: &RandomForce| commanded_rms(runs, force.dof).map(|thrust| force.rms / thrust);
    let found = |force: &RandomForce| Some((force.dof, times(force).filter(|times| is_too_much(force, *times))?));
    forces.iter().filter_map(found).collect()
}
