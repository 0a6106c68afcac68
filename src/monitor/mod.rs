//! Monitoring of a model on a new log: does it still fit, and if not, since when, where, and for which likely reason.
//!
//! ```text
//! e = y − ŷ(t | samples before t),   z = e/√s         a change: z is no longer what it was where the model was fitted
//! ```
//!
//! The Kalman filter of the model predicts each sample from those before it, with all parameters held. It works in
//! windows that begin with an unknown state each, so that the residual of a window arises within it. `innovations`
//! describes the test of the windows, `reason` the search for the reason. Willsky and Jones, *IEEE Transactions on
//! Automatic Control* 21 (1976) 108-112.

mod innovations;
mod reason;
mod window;

use serde::Serialize;

pub use innovations::restlessness;
pub use reason::{Reason, reasons};
pub use window::{Change, Window};

use crate::estimate::filter_error::{Filtered, NoiseModel, Point, SensorNoise};
use crate::estimate::output_error::{OutputErrorError, OutputErrorOptions, Problem};
use crate::finding::{Finding, codes};
use crate::frame::Dof;
use crate::model::Model;
use crate::progress::tell;
use crate::run::Run;
use innovations::{FEWEST, is_large, normalised};

codes! {
    NO_LONGER_FITS = "W001" "no-longer-fits" Warning "The model no longer fits the log: from the given instant its innovations (what each sample adds to the prediction from the samples before it) are larger than where the model was fitted. The likely reasons are ranked; fit the model again, or inspect the vehicle.";
    PASSING = "W002" "passing-disagreement" Note "The model disagrees with the log in some windows and agrees again afterwards: a contact, a wave or a gust of current, rather than a change of the vehicle.";
}

/// Options of the monitoring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MonitorOptions {
    /// Length of a window, s.
    pub window: f64,
    /// Probability of any false alarm in the whole log.
    pub level: f64,
}

impl Default for MonitorOptions {
    /// 8 s: long enough to see slow drag, short enough that unstable motion stays near the data. 1 %.
    fn default() -> MonitorOptions {
        MonitorOptions { window: 8.0, level: 0.01 }
    }
}

/// Limit in standard deviations at which an innovation is clipped when it corrects the state: one outlier must not
/// carry it away.
const LIMIT: f64 = 5.0;

/// Noise of the logs, as far as it is known beforehand.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownNoise {
    /// Random force and sensor noise, in the order of the model's outputs.
    pub noise: NoiseModel,
    /// Factor by which the windows of each output differ from white innovations more than chance, where the model was
    /// fitted: [`restlessness`].
    pub restless: Vec<f64>,
}

/// Result of the monitoring.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Watch {
    /// Whether the model still fits everywhere.
    pub fits: bool,
    /// Lasting changes, at most one per run and degree of freedom.
    pub changes: Vec<Change>,
    /// Likely reasons, the best first; empty where the model fits.
    pub reasons: Vec<Reason>,
    /// All windows.
    pub windows: Vec<Window>,
    /// Findings for the user.
    pub warnings: Vec<Finding>,
}

/// Runs `model` along `runs` with all parameters held. Without `noise` there is no random force, and the sensor noise
/// is estimated from the runs.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what the model reads.
pub fn watch(
    model: &Model,
    noise: Option<&KnownNoise>,
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
    let filtered = Filtered::in_windows(&held, runs, &at)?;
    tell("filtering windows", 0, 0);
    let seen = || NoiseModel {
        forces: Vec::new(),
        sensors: filtered.problem.sigma.iter().map(|std| SensorNoise { std: *std, coloured: None }).collect(),
    };
    let random = noise.map_or_else(seen, |known| known.noise.clone());
    let (mut windows, z) = windows(&held, &filtered, &random, noise.map(|n| &n.restless[..]), options.level);
    let changes = innovations::changes(&mut windows, &z, options.level);
    let mut warnings = Vec::new();
    for change in &changes {
        let text = format!(
            "run `{}`: from {:.1} s on the model no longer fits in {}: its innovations are {:.1} times the expected \
             size",
            change.run, change.from, change.dof, change.times_noise
        );
        warnings.push(Finding::new(&NO_LONGER_FITS, text).of_run(&change.run));
    }
    let lasting = |w: &Window| changes.iter().any(|c| c.run == w.run && c.dof == w.dof);
    let passing: Vec<&Window> = windows.iter().filter(|w| w.off && !lasting(w)).collect();
    for w in &passing {
        let text = format!(
            "run `{}`: between {:.1} and {:.1} s the model disagrees in {}, where its innovations are {:.1} times the \
             expected size, and agrees again afterwards",
            w.run,
            w.from,
            w.to,
            w.dof,
            w.rms / w.noise
        );
        warnings.push(Finding::new(&PASSING, text).of_run(&w.run));
    }
    let off: Vec<bool> = segments_off(&filtered.problem, &windows, &changes);
    let reasons = if off.contains(&true) {
        tell("likely reasons", 0, 0);
        reasons(&held, &random, runs, &off, &at)?
    } else {
        Vec::new()
    };
    Ok(Watch { fits: changes.is_empty(), changes, reasons, windows, warnings })
}

/// Windows of each degree of freedom in each run, in order, and their normalised innovations.
fn windows(
    held: &Model,
    filtered: &Filtered,
    noise: &NoiseModel,
    restless: Option<&[f64]>,
    level: f64,
) -> (Vec<Window>, Vec<Vec<f64>>) {
    let problem = &filtered.problem;
    let outputs = &problem.dynamics.outputs;
    let forecasts = filtered.forecast(held, noise, LIMIT);
    let column = |name: &str| outputs.iter().position(|o| o == name);
    let of = |dof: &Dof| Some((*dof, column(dof.velocity()).or_else(|| column(dof.position()))?));
    let columns: Vec<(Dof, usize)> = held.dofs.iter().filter_map(of).collect();
    // probability of a false alarm in one window, so that all windows together have `level`
    let least = level / (problem.segments.len() * columns.len()).max(1) as f64;
    let (mut all, mut innovations) = (Vec::new(), Vec::new());
    for (dof, output) in columns {
        let restless = restless.and_then(|restless| restless.get(output)).copied().unwrap_or(1.0);
        for (segment, forecast) in problem.segments.iter().zip(&forecasts) {
            let channel = &forecast.channels[output];
            let z = normalised(channel);
            if z.len() < FEWEST {
                continue;
            }
            let track = &problem.tracks[segment.track];
            let likelihood_ratio = innovations::ratio(&z) / restless;
            let p_value = (-0.5 * likelihood_ratio).exp();
            let points = || channel.next.iter().skip(1);
            let mean = |f: &dyn Fn(&Point) -> f64| points().map(f).sum::<f64>() / z.len() as f64;
            let large = is_large(&z) || likelihood_ratio.is_nan();
            all.push(Window {
                run: track.name.clone(),
                dof,
                from: track.time[segment.first],
                to: track.time[segment.last],
                samples: z.len(),
                rms: mean(&|p| (p.measured - p.mean).powi(2)).sqrt(),
                mean: mean(&|p| p.measured - p.mean),
                noise: mean(&|p| p.std * p.std).sqrt(),
                chi_squared: z.iter().map(|z| z * z).sum(),
                likelihood_ratio,
                p_value,
                cusum: 0.0,
                large,
                // a simulation that overflows is off as well
                off: likelihood_ratio.is_nan() || (large && p_value < least),
            });
            innovations.push(z);
        }
    }
    (all, innovations)
}

/// Segments that lie in a lasting change.
fn segments_off(problem: &Problem, windows: &[Window], changes: &[Change]) -> Vec<bool> {
    // a window that contains the instant of the change counts
    let lasts = |run: &str, to: f64| changes.iter().any(|c| c.run == run && to > c.from);
    let known = |run: &str, from: f64| windows.iter().any(|w| w.run == run && w.from.to_bits() == from.to_bits());
    problem
        .segments
        .iter()
        .map(|s| {
            let track = &problem.tracks[s.track];
            known(&track.name, track.time[s.first]) && lasts(&track.name, track.time[s.last])
        })
        .collect()
}
