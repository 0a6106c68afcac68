//! What the motion tells of commands between their rows: how long after a command on a straight line it comes. Where commands are held
//! that is half of the time between rows, Δt/2, where they are lines not at all.
//!
//! ```text
//! d̂ = Σ d_k σ_k⁻² / Σ σ_k⁻²      over the balances of runs and degrees of freedom ([`measure`])      σ(d̂) < Δt/8
//! held: d̂ > Δt/4
//! ```
//!
//! A log without the velocity along any axis is not asked: slopes of fixes do not tell a twentieth of a second. A straight line in the
//! place of the unknown curve of a thruster has the delay off by half a sample and more, where it leaves a tenth of the motion
//! unexplained.

use crate::check::balance::Balance;
use crate::check::commands::measure;
use crate::frame::Dof;
use crate::run::Run;

/// Deviation of the delay over the time between rows, up to which it tells a half from none by four deviations.
const CLEAR: f64 = 0.125;

/// Part of the changes of velocity that commands whose curve is not known have to explain for their delay to be one.
const STRAIGHT: f64 = 0.95;

/// What the motion tells.
pub(super) struct BetweenRows {
    /// Whether commands are held.
    pub held: bool,
    /// Delay of the motion behind commands on a line, s.
    pub delay: f64,
}

/// What the motion of all runs and degrees of freedom tells of commands whose rows are `step` s apart; `None` where it does not tell a
/// half of a step from none, or comes before both.
pub(super) fn between_rows<'a>(runs: impl IntoIterator<Item = &'a Run>, step: f64) -> Option<BetweenRows> {
    let runs: Vec<&Run> = runs.into_iter().collect();
    if !runs.iter().all(|run| tells_velocity(run)) {
        return None;
    }
    let answers = runs.into_iter().flat_map(|run| Dof::ALL.into_iter().filter_map(|dof| Balance::new(run, dof)));
    // one delay for all commands of a balance
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

/// Whether a sensor tells a velocity along an axis.
fn tells_velocity(run: &Run) -> bool {
    let is_told = |dof: &Dof| run.signal(dof.velocity()).is_some_and(|s| !s.is_empty());
    Dof::ALL.iter().filter(|dof| !dof.is_rotation()).any(is_told)
}
