//! Delay of the motion behind commands that are taken as straight lines between their rows. It
//! shows what the commands do between rows: if they are held, the delay is half of the time between
//! rows, Δt/2; if they are lines, it is zero.
//!
//! ```text
//! d̂ = Σ d_k σ_k⁻² / Σ σ_k⁻²      over the balances of runs and degrees of freedom ([`measure`])
//! σ(d̂) < Δt/8
//! held: d̂ > Δt/4
//! ```
//!
//! If a run logs no velocity along any axis, there is no answer: slopes of position fixes do not
//! resolve a twentieth of a second. The curve of a thruster is not known here, so that the delay of
//! a voltage counts only if the balance explains nearly all of the motion: if it leaves a tenth
//! unexplained, the delay is off by half a sample or more.

use crate::check::balance::Balance;
use crate::check::commands::measure;
use crate::frame::Dof;
use crate::run::Run;

/// Largest standard deviation of the delay, in units of the time between rows: half a row then
/// differs from zero by four standard deviations.
const CLEAR: f64 = 0.125;

/// Part of the changes of velocity that voltages, whose curve is not known, must explain for their
/// delay to count.
const STRAIGHT: f64 = 0.95;

/// Behaviour of the commands between their rows.
pub(super) struct BetweenRows {
    /// Whether commands are held.
    pub held: bool,
    /// Delay of the motion behind commands that are lines between rows, s.
    pub delay: f64,
}

/// Returns what the motion of all runs and degrees of freedom shows about commands whose rows are
/// `step` s apart. `None` if the delay is too uncertain to distinguish half a step from zero, or if
/// the motion precedes the commands by more than a quarter of a step.
pub(super) fn between_rows<'a>(runs: impl IntoIterator<Item = &'a Run>, step: f64) -> Option<BetweenRows> {
    let runs: Vec<&Run> = runs.into_iter().collect();
    if !runs.iter().all(|run| tells_velocity(run)) {
        return None;
    }
    let answers = runs.into_iter().flat_map(|run| Dof::ALL.into_iter().filter_map(|dof| Balance::new(run, dof)));
    // all commands of a balance share one delay
    let delays = answers.filter_map(|balance| {
        let delay = measure(&balance).first()?.delay?;
        let is_voltage = balance.channels().iter().all(|name| name.starts_with('V'));
        let explained = || balance.fit(delay.seconds).map_or(0.0, |fit| fit.explained);
        (!is_voltage || explained() > STRAIGHT).then_some(delay)
    });
    let (mut sum, mut weight) = (0.0, 0.0);
    for delay in delays.filter(|delay| delay.std > 0.0) {
        sum += delay.seconds / delay.std.powi(2);
        weight += 1.0 / delay.std.powi(2);
    }
    let known = weight > 0.0 && weight.sqrt().recip() < CLEAR * step;
    let delay = known.then(|| sum / weight).filter(|delay| *delay > -0.25 * step)?;
    Some(BetweenRows { held: delay > 0.25 * step, delay })
}

/// Whether a run logs a velocity along an axis.
fn tells_velocity(run: &Run) -> bool {
    let is_told = |dof: &Dof| run.signal(dof.velocity()).is_some_and(|s| !s.is_empty());
    Dof::ALL.iter().filter(|dof| !dof.is_rotation()).any(is_told)
}
