//! Closed loop: a controller that holds the speed makes the command follow the speed.
//!
//! ```text
//! ρ = corr(Δτ, Δν) over successive windows of 1 s
//! closed:  ρ < −0.5 while the speed stays within a quarter of its mean
//! ```
//!
//! Without a controller a larger force comes with a rising speed, ρ > 0; a controller lowers the force
//! as the speed rises. A fit to such data takes the gain of the controller for drag. Source: Ljung,
//! *System Identification*, 2nd ed. (1999), section 13.4.

use serde::Serialize;

use super::balance::commands;
use super::codes;
use super::report::Found;
use super::samples::{Samples, windows};
use crate::frame::Dof;
use crate::log::number::short;
use crate::run::Run;

/// Length of a window, s.
const WINDOW: f64 = 1.0;
/// Largest spread of a held speed, relative to its mean.
const HELD: f64 = 0.25;
/// Correlation below which the command follows the speed.
const FOLLOWS: f64 = -0.5;

/// A speed and its command.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Loop {
    /// Channel of the speed.
    pub channel: String,
    /// Channels of its command; several are added.
    pub commands: Vec<String>,
    /// Correlation of the changes of both.
    pub correlation: f64,
    /// Half the range from the 10th to the 90th percentile of the speed, over its mean; infinite
    /// for a mean of zero.
    pub spread: f64,
}

/// Measures surge, sway and heave: speeds that a controller may hold.
pub fn measure(run: &Run) -> Vec<Loop> {
    [Dof::Surge, Dof::Sway, Dof::Heave].into_iter().filter_map(|dof| of(run, dof)).collect()
}

fn of(run: &Run, dof: Dof) -> Option<Loop> {
    let nu = Samples::of(run.signal(dof.velocity())?)?;
    let names = commands(run, dof);
    // the sum of the commands of all thrusters is a thrust ahead, and has no meaning in other directions
    if names.is_empty() || (dof != Dof::Surge && names[0] != dof.force()) {
        return None;
    }
    let commands: Option<Vec<Samples>> = names
        .iter()
        .map(|n| run.signal(n).and_then(|s| Samples::new(s.time().to_vec(), s.values().to_vec())))
        .collect();
    let commands = commands?;
    let mut all: Vec<&Samples> = commands.iter().collect();
    all.push(&nu);
    let windows = windows(&all, WINDOW.max(2.0 * nu.step()), 0.0);
    let mean = |s: &Samples| -> Vec<f64> { windows.iter().map(|(a, b)| s.integral(*a, *b) / (b - a)).collect() };
    let speed = mean(&nu);
    let mut force = vec![0.0; speed.len()];
    for c in &commands {
        mean(c).iter().zip(&mut force).for_each(|(x, f)| *f += x);
    }
    let average = speed.iter().sum::<f64>() / speed.len().max(1) as f64;
    // 10th to 90th percentile: a start from rest is not part of the held speed
    let quantile = |p: f64| crate::log::check::statistics::quantile(speed.iter().copied(), p);
    let spread = 0.5 * (quantile(0.9)? - quantile(0.1)?) / average.abs();
    let change = |x: &[f64]| -> Vec<f64> { x.windows(2).map(|w| w[1] - w[0]).collect() };
    let correlation = correlation(&change(&force), &change(&speed))?;
    Some(Loop { channel: dof.velocity().to_string(), commands: names, correlation, spread })
}

fn correlation(x: &[f64], y: &[f64]) -> Option<f64> {
    if x.len() < 20 {
        return None;
    }
    let n = x.len() as f64;
    let (a, b) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let sum = |f: &dyn Fn(f64, f64) -> f64| x.iter().zip(y).map(|(x, y)| f(x - a, y - b)).sum::<f64>();
    let scale = (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt();
    (scale > 0.0).then(|| sum(&|x, y| x * y) / scale)
}

/// Channel that is 1 where the mode in the log says that a controller steers, 0 elsewhere.
pub const MODE: &str = "closed_loop";

/// Finds the stretches in which the log itself says that a controller steers.
pub fn judge_modes(run: &Run) -> Vec<Found> {
    let Some(mode) = run.signal(MODE).filter(|s| !s.is_empty()) else { return Vec::new() };
    let (time, steers) = (mode.time(), mode.values());
    let mut stretches: Vec<(f64, f64)> = Vec::new();
    for k in 0..steers.len() {
        match (steers[k] >= 0.5, stretches.last_mut()) {
            (true, Some(last)) if k > 0 && steers[k - 1] >= 0.5 => last.1 = time[k],
            (true, _) => stretches.push((time[k], time[k])),
            _ => {}
        }
    }
    if stretches.is_empty() {
        return Vec::new();
    }
    let total: f64 = stretches.iter().map(|(a, b)| b - a).sum();
    let first = stretches[0];
    let text = format!(
        "according to the logged modes, a controller steers for {} s in {} stretch{}, first from {} to {} s: there the \
         command depends on the motion; exclude it with where = \"{MODE} < 0.5\", or fit with force noise and trust \
         the result less",
        short(total, 4),
        stretches.len(),
        if stretches.len() == 1 { "" } else { "es" },
        short(first.0, 6),
        short(first.1, 6)
    );
    vec![Found::new(&codes::MODE_CLOSED_LOOP, &[MODE], text)]
}

/// Finds the loops that are closed.
pub fn judge(loops: &[Loop]) -> Vec<Found> {
    let closed = loops.iter().filter(|l| l.spread < HELD && l.correlation < FOLLOWS);
    let say = |l: &Loop| {
        let text = format!(
            "{} is held by a controller: it stays within {} % while {} reacts to it (correlation of the changes {}); a \
             fit would identify the controller, not the vehicle; repeat the run with open-loop commands",
            l.channel,
            short(100.0 * l.spread, 2),
            if l.commands.len() == 1 { l.commands[0].clone() } else { format!("the sum of {}", l.commands.join(", ")) },
            short(l.correlation, 2)
        );
        Found::new(&codes::CLOSED_LOOP, &[&l.channel], text)
    };
    closed.map(say).collect()
}
