//! A model run along a new log: does it still fit, and if not, since when, where, and why most likely.
//!
//! ```text
//! Q = Σ (y − ŷ)²/σ²  in a window and degree of freedom, against χ²(n − 1)
//! S_k = max(0, S_{k−1} + Q_k/(n_k − 1) − 1 − κ)         a change where S passes h; it began after the last S = 0
//! ```
//!
//! ŷ: simulated from a state that is estimated in the window with all parameters held, so that what is left in a window
//! is made in it; σ: noise of the sensor; n: samples. A window counts as off where chance is unlikely *and* the
//! disagreement is large beside the noise: residuals of sensors are never quite white. Page, *Biometrika* 41 (1954);
//! Basseville and Nikiforov, *Detection of Abrupt Changes* (1993), ch. 2. The reason is looked for in `reason`.

mod reason;

use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};

pub use reason::{Reason, reasons};

use crate::estimate::output_error::{OutputErrorError, OutputErrorFit, OutputErrorOptions, Problem, fit_from};
use crate::finding::{Finding, codes};
use crate::frame::Dof;
use crate::model::Model;
use crate::progress::tell;
use crate::run::Run;

codes! {
    NO_LONGER_FITS = "W001" "no-longer-fits" Warning "The model no longer fits the log: it disagrees by much more than the noise, from the instant that is told. The likely reasons are ranked; fit the model anew, or look at the vehicle.";
    PASSING = "W002" "passing-disagreement" Note "The model disagrees with the log in some windows and agrees again afterwards: a touch, a wave, a gust of current, rather than a change of the vehicle.";
}

/// How a log is watched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MonitorOptions {
    /// Length of a window, s.
    pub window: f64,
    /// Probability of any false alarm in the whole log, by white noise.
    pub level: f64,
}

impl Default for MonitorOptions {
    /// 8 s: long enough to see slow drag, short enough that unstable motion stays near the data. 1 %.
    fn default() -> MonitorOptions {
        MonitorOptions { window: 8.0, level: 0.01 }
    }
}

/// Disagreement over noise from which on a window may count as off: as in the search for missing effects.
const ABOVE: f64 = 1.5;

/// κ: half of the rise of the mean square that [`ABOVE`] means.
const SLACK: f64 = 0.5 * (ABOVE * ABOVE - 1.0);

/// h: what two windows at twice the noise add up to.
const THRESHOLD: f64 = 2.0 * (4.0 - 1.0 - SLACK);

/// One window in one degree of freedom.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Window {
    /// Name of the run.
    pub run: String,
    /// Degree of freedom.
    pub dof: Dof,
    /// Beginning, s.
    pub from: f64,
    /// End, s.
    pub to: f64,
    /// Number of samples.
    pub samples: usize,
    /// Root mean square of measured − simulated, m/s or rad/s.
    pub rms: f64,
    /// Standard deviation of the noise, m/s or rad/s.
    pub noise: f64,
    /// Σ (residual/σ)².
    pub chi_squared: f64,
    /// Probability of so much by white noise.
    pub p_value: f64,
    /// The sum S of the change detector after this window.
    pub cusum: f64,
    /// Whether the window is off.
    pub off: bool,
}

/// A lasting change.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// Name of the run.
    pub run: String,
    /// Degree of freedom.
    pub dof: Dof,
    /// When it began, s: the beginning of the first window that is off in a row.
    pub from: f64,
    /// Disagreement over noise from there on.
    pub times_noise: f64,
}

/// What watching has found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Watch {
    /// Whether the model still fits everywhere.
    pub fits: bool,
    /// Lasting changes, one a run and degree of freedom at most.
    pub changes: Vec<Change>,
    /// Likely reasons, the best first; empty where the model fits.
    pub reasons: Vec<Reason>,
    /// All windows.
    pub windows: Vec<Window>,
    /// What there is to say.
    pub warnings: Vec<Finding>,
}

/// Runs `model`, all parameters held, along `runs`.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what the model reads.
pub fn watch(
    model: &Model,
    runs: &[Run],
    fitting: &OutputErrorOptions,
    options: &MonitorOptions,
) -> Result<Watch, OutputErrorError> {
    let mut held = model.clone();
    for p in &mut held.parameters {
        p.fixed = true;
        p.per_run.clear();
    }
    let at = OutputErrorOptions { segment: options.window, iterations: 6, ..fitting.clone() };
    let problem = Problem::new(&held, runs, &at)?;
    let x0 = problem.initial_states(&held);
    tell("simulating windows", 0, 0);
    let fit = fit_from(&held, problem, x0, &at)?;
    let mut windows = windows(&fit, options.level);
    let changes = changes(&mut windows);
    let mut warnings = Vec::new();
    for change in &changes {
        let text = format!(
            "run `{}`: from {:.1} s on the model no longer fits in {}: the disagreement is {:.1} times the noise",
            change.run, change.from, change.dof, change.times_noise
        );
        warnings.push(Finding::new(&NO_LONGER_FITS, text).of_run(&change.run));
    }
    let lasting = |w: &Window| changes.iter().any(|c| c.run == w.run && c.dof == w.dof);
    let passing: Vec<&Window> = windows.iter().filter(|w| w.off && !lasting(w)).collect();
    for w in &passing {
        let text = format!(
            "run `{}`: between {:.1} and {:.1} s the model disagrees in {} by {:.1} times the noise, and agrees again afterwards",
            w.run,
            w.from,
            w.to,
            w.dof,
            w.rms / w.noise
        );
        warnings.push(Finding::new(&PASSING, text).of_run(&w.run));
    }
    let off: Vec<bool> = segments_off(&fit, &windows, &changes);
    tell("likely reasons", 0, 0);
    let reasons = if off.contains(&true) { reasons(model, &fit, runs, &off, &at)? } else { Vec::new() };
    Ok(Watch { fits: changes.is_empty(), changes, reasons, windows, warnings })
}

/// Disagreement of each segment in each degree of freedom.
fn windows(fit: &OutputErrorFit, level: f64) -> Vec<Window> {
    let dynamics = &fit.problem.dynamics;
    let width = dynamics.outputs.len();
    let column = |dof: &Dof| dynamics.outputs.iter().position(|o| *o == dof.velocity());
    let columns: Vec<(Dof, usize)> = fit.model.dofs.iter().filter_map(|d| Some((*d, column(d)?))).collect();
    // all windows together may give a false alarm with this probability
    let least = level / (fit.problem.segments.len() * columns.len()).max(1) as f64;
    let mut all = Vec::new();
    for (dof, output) in columns {
        for (segment, linearised) in fit.problem.segments.iter().zip(&fit.linearised) {
            let track = &fit.problem.tracks[segment.track];
            let observed = track.observed[segment.first * width..(segment.last + 1) * width].iter();
            let samples = observed.skip(output).step_by(width).filter(|y| !y.is_nan()).count();
            if samples < 3 {
                continue;
            }
            let chi_squared = linearised.squares[output];
            // one sample's worth goes into the state from which the window starts
            let freedom = (samples - 1) as f64;
            let p_value = ChiSquared::new(freedom).map_or(1.0, |law| law.sf(chi_squared));
            let ratio = (chi_squared / freedom).sqrt();
            all.push(Window {
                run: track.name.clone(),
                dof,
                from: track.time[segment.first],
                to: track.time[segment.last],
                samples,
                rms: ratio * fit.problem.sigma[output],
                noise: fit.problem.sigma[output],
                chi_squared,
                p_value,
                cusum: 0.0,
                // an overflow of the simulation is off as well
                off: ratio.is_nan() || ratio.is_infinite() || (ratio > ABOVE && p_value < least),
            });
        }
    }
    all
}

/// Fills in the sums of the change detector and returns where they pass the threshold and stay there.
fn changes(windows: &mut [Window]) -> Vec<Change> {
    let mut found = Vec::new();
    let mut begin = 0;
    while begin < windows.len() {
        let same = |w: &Window| w.run == windows[begin].run && w.dof == windows[begin].dof;
        let end = begin + windows[begin..].iter().take_while(|w| same(w)).count();
        let (mut sum, mut since): (f64, usize) = (0.0, begin);
        for k in begin..end {
            let excess = (windows[k].rms / windows[k].noise).powi(2) - 1.0 - SLACK;
            if sum <= 0.0 {
                since = k;
            }
            // one window alone must not carry the sum beyond what good ones can bring down again
            sum = (sum + excess.clamp(-1.0 - SLACK, THRESHOLD)).max(0.0);
            windows[k].cusum = sum;
        }
        let row = &windows[since..end];
        let off = row.iter().filter(|w| w.off).count();
        if sum > THRESHOLD && off >= 2 {
            let first = row.iter().position(|w| w.off).unwrap_or(0);
            let rest = &row[first..];
            let squares: f64 = rest.iter().map(|w| (w.rms / w.noise).powi(2)).sum();
            found.push(Change {
                run: row[0].run.clone(),
                dof: row[0].dof,
                from: rest[0].from,
                times_noise: (squares / rest.len() as f64).sqrt(),
            });
        }
        begin = end;
    }
    found
}

/// Segments that lie in a lasting change.
fn segments_off(fit: &OutputErrorFit, windows: &[Window], changes: &[Change]) -> Vec<bool> {
    let lasts = |run: &str, from: f64| changes.iter().any(|c| c.run == run && from >= c.from);
    let known = |run: &str, from: f64| windows.iter().any(|w| w.run == run && w.from.to_bits() == from.to_bits());
    fit.problem
        .segments
        .iter()
        .map(|s| {
            let track = &fit.problem.tracks[s.track];
            let from = track.time[s.first];
            known(&track.name, from) && lasts(&track.name, from)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(ratios: &[f64]) -> Vec<Window> {
        let one = |(k, ratio): (usize, &f64)| Window {
            run: "dive".into(),
            dof: Dof::Surge,
            from: 8.0 * k as f64,
            to: 8.0 * (k + 1) as f64,
            samples: 80,
            rms: *ratio,
            noise: 1.0,
            chi_squared: 79.0 * ratio * ratio,
            p_value: 0.0,
            cusum: 0.0,
            off: *ratio > ABOVE,
        };
        ratios.iter().enumerate().map(one).collect()
    }

    #[test]
    fn a_lasting_change_is_dated_by_its_first_window() {
        let found = changes(&mut row(&[1.0, 1.1, 0.9, 1.0, 3.0, 2.5, 3.2, 2.8]));
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].from, found[0].dof), (32.0, Dof::Surge));
        assert!((found[0].times_noise - 2.89).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn a_touch_that_passes_is_no_change() {
        assert!(changes(&mut row(&[1.0, 1.0, 20.0, 1.0, 1.0, 1.0, 1.0, 1.0])).is_empty());
        assert!(changes(&mut row(&[1.0, 1.2, 1.3, 1.1, 1.4, 1.2])).is_empty());
    }
}
