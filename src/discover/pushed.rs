//! Random forces compared with the commands: what water does, what it does not, and what leaves nothing to tell.
//!
//! ```text
//! σ_d / rms τ_d        > 0.2: pushed hard        > 10: what moves the vehicle is not its commands
//! ```

use crate::estimate::filter_error::{FilterErrorFit, RandomForce};
use crate::frame::Dof;
use crate::run::{Run, commanded_rms};

/// Share of the command's rms beyond which a random force is more than the water's: turbulence and tethers stay at a tenth.
const MUCH: f64 = 0.2;

/// Correlation time above which a force is slow, s: three times that of what is slowest in water.
const SLOW: f64 = 10.0;

/// Whether a force is slower than what water does.
pub(super) fn is_slow(force: &RandomForce) -> bool {
    force.time > SLOW
}

/// Whether a force stays for so long that it follows what is another one in every run: over a minute the mean of one that forgets
/// in half of [`SLOW`] has still 0.4 of its deviation.
pub(super) fn is_slow_within_a_run(force: &RandomForce) -> bool {
    force.time > 0.5 * SLOW
}

/// Whether what moves the vehicle is not its commands, in half of the degrees of freedom that are commanded or more: nothing
/// tells a force from the inertia there, and fits go astray for hours. Only what is done with the commands may mend it: two
/// thrusters that are exchanged make nonsense of them.
pub(super) fn is_hopeless(fit: &FilterErrorFit, runs: &[Run]) -> bool {
    let commanded = fit.model.dofs.iter().filter(|dof| commanded_rms(runs, **dof).is_some()).count();
    let lost = overwhelmed(&fit.noise.forces, runs).len();
    lost > 0 && 2 * lost >= commanded
}

/// Degrees of freedom that are commanded on `runs` and that a random force moves all the same, with how many times that of
/// the command it is.
pub(super) fn overwhelmed(forces: &[RandomForce], runs: &[Run]) -> Vec<(Dof, f64)> {
    beside_commands(forces, runs, |_, times| times > RandomForce::OVERWHELMING)
}

/// Those in which it is more than turbulence and tethers make.
pub(super) fn pushed_hard(forces: &[RandomForce], runs: &[Run]) -> Vec<(Dof, f64)> {
    beside_commands(forces, runs, |_, times| times > MUCH)
}

/// Degrees of freedom in which a random force stays for tens of seconds and is a good part of the commands' (root mean square
/// over theirs): a tether, a tide, a payload, and no turbulence.
pub(super) fn lasting(forces: &[RandomForce], runs: &[Run]) -> Vec<(Dof, f64)> {
    beside_commands(forces, runs, |force, times| is_slow(force) && times > MUCH)
}

/// Forces in degrees of freedom that are commanded, with how many times the command's root mean square they are, those that
/// are too much of it.
fn beside_commands(
    forces: &[RandomForce],
    runs: &[Run],
    is_too_much: impl Fn(&RandomForce, f64) -> bool,
) -> Vec<(Dof, f64)> {
    let times = |force: &RandomForce| commanded_rms(runs, force.dof).map(|thrust| force.rms / thrust);
    let found = |force: &RandomForce| Some((force.dof, times(force).filter(|times| is_too_much(force, *times))?));
    forces.iter().filter_map(found).collect()
}
