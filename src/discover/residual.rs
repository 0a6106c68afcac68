//! The missing force: the residual of the momentum balance of the fitted baseline, along the log.
//!
//! ```text
//! Fᵢ = (Δπᵢ − ∫(wᵢ + τᵢ) dt)/Δt          over windows of about a second, N and N·m
//! ```
//!
//! Velocities are those of the log, so that F is the force at that moment even where the simulation would have
//! drifted. F is correlated with each velocity, command and product of two velocities (Pearson's r over all windows),
//! with the heading by its first harmonic (multiple R), and with depth, time and the amplitude of the run. Within
//! each run a change of its mean is detected from the cumulative sum of its deviations, which drifts where the mean
//! changes (Ploberger and Krämer, *Econometrica* 60 (1992) 271, with the long-run variance of Newey and West).

use serde::Serialize;

use crate::effects::id;
use crate::estimate::filter_error::FilterErrorFit;
use crate::estimate::{RegressorOptions, Span, regressors_of};
use crate::frame::Dof;
use crate::model::Model;
use crate::run::Run;

/// Length of the windows, s: long enough to average the noise of a sample, short compared with the motion.
const WINDOW: f64 = 1.0;
/// Least correlation that is reported.
const TOLD: f64 = 0.3;
/// Maximum number of dependences that are reported.
const MOST: usize = 4;
/// Minimum number of windows of a run for the detection of a change.
const FEWEST: usize = 20;
/// Threshold of the sum of deviations over its spread. By simulation chance exceeds it in one of a thousand runs of 120
/// windows whose noise is AR(1) with 0.5; for long series of white noise the threshold would be 1.95.
const CHANGED: f64 = 3.0;

/// The missing force of one degree of freedom.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Residual {
    /// Degree of freedom.
    pub dof: Dof,
    /// Root mean square of the missing force, in `unit`.
    pub rms: f64,
    /// Part that the noise of the velocity causes, in `unit`.
    pub noise: f64,
    /// `N` or `N*m`.
    pub unit: &'static str,
    /// Quantities that it correlates with, the closest first.
    pub goes_with: Vec<Dependence>,
    /// Instants at which its mean changes.
    pub changes: Vec<Change>,
    /// Summary in one sentence.
    pub sentence: String,
}

/// A quantity that a missing force correlates with.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Dependence {
    /// A channel, a product of two, `heading`, `depth`, `time`, `amplitude`.
    pub quantity: String,
    /// Correlation, −1 to 1; for the heading 0 to 1.
    pub correlation: f64,
    /// The quantity and the force, window by window, for a figure.
    #[serde(skip)]
    pub points: Vec<(f64, f64)>,
}

/// An instant at which the missing force changes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// Name of the run.
    pub run: String,
    /// Instant, s.
    pub at: f64,
    /// Mean before, in the unit of the force.
    pub before: f64,
    /// Mean after.
    pub after: f64,
}

/// One window.
struct Window {
    run: usize,
    time: f64,
    force: f64,
}

/// The missing force of each degree of freedom whose momentum balance the log allows; others are left out.
pub fn residuals(fit: &FilterErrorFit, runs: &[Run]) -> Vec<Residual> {
    fit.model.dofs.iter().filter_map(|dof| of(fit, runs, *dof)).collect()
}

fn of(fit: &FilterErrorFit, runs: &[Run], dof: Dof) -> Option<Residual> {
    let windows = windows(&fit.model, runs, dof)?;
    let unit = if dof.is_rotation() { "N*m" } else { "N" };
    let rms = (windows.iter().map(|w| w.force * w.force).sum::<f64>() / windows.len() as f64).sqrt();
    let outputs = &fit.filtered.problem.dynamics.outputs;
    let sigma = outputs.iter().position(|o| *o == dof.velocity()).map(|k| fit.noise.sensors[k].std)?;
    let noise = fit.model.value_at(id::INERTIA, dof)?.abs() * sigma * std::f64::consts::SQRT_2 / WINDOW;
    let mut goes_with = dependences(&fit.model, runs, &windows);
    goes_with.sort_by(|a, b| b.correlation.abs().total_cmp(&a.correlation.abs()));
    goes_with.truncate(MOST);
    let loud = rms > 1.5 * noise;
    goes_with.retain(|d| loud && d.correlation.abs() >= TOLD);
    let changes = if loud { changes(runs, &windows) } else { Vec::new() };
    let sentence = sentence(dof, (rms, noise, unit), &goes_with, &changes);
    Some(Residual { dof, rms, noise, unit, goes_with, changes, sentence })
}

/// The missing force in windows; `None` if the log does not allow the momentum balance.
fn windows(model: &Model, runs: &[Run], dof: Dof) -> Option<Vec<Window>> {
    let mut held = model.clone();
    let inertia = held.inertia(dof)?;
    for (k, p) in held.parameters.iter_mut().enumerate() {
        p.fixed = k != inertia;
    }
    let mass = held.parameters[inertia].value;
    let samples = crate::estimate::samples_in(WINDOW, model, runs);
    let options = RegressorOptions { span: Span::Samples(samples), ..RegressorOptions::default() };
    let all: Vec<&Run> = runs.iter().collect();
    let columns = regressors_of(dof, &all, &held, options).ok()?;
    let of_inertia = columns.column_of(inertia)?;
    let mut windows = Vec::new();
    for block in &columns.blocks {
        for k in block.rows.clone() {
            let (from, to) = columns.span[k];
            let impulse = mass * columns.columns[of_inertia][k] - columns.rhs[k];
            windows.push(Window { run: block.run, time: 0.5 * (from + to), force: impulse / (to - from) });
        }
    }
    (!windows.is_empty()).then_some(windows)
}

fn dependences(model: &Model, runs: &[Run], windows: &[Window]) -> Vec<Dependence> {
    let mut all = Vec::new();
    let mut hold = |name: &str, f: &dyn Fn(&Run, f64) -> Option<f64>| {
        let points: Vec<(f64, f64)> =
            windows.iter().filter_map(|w| Some((f(&runs[w.run], w.time)?, w.force))).collect();
        if points.len() == windows.len() {
            all.push(Dependence { quantity: name.to_string(), correlation: correlation(&points), points });
        }
    };
    for (i, a) in model.dofs.iter().enumerate() {
        let (x, force) = (a.velocity(), a.force());
        hold(x, &|run, t| value(run, x, t));
        hold(&format!("|{x}| {x}"), &|run, t| value(run, x, t).map(|v| v * v.abs()));
        hold(force, &|run, t| value(run, force, t));
        for b in &model.dofs[i + 1..] {
            let y = b.velocity();
            hold(&format!("{x} {y}"), &|run, t| Some(value(run, x, t)? * value(run, y, t)?));
        }
        let amplitude = crate::effects::channel::keulegan_carpenter(*a);
        hold(&format!("amplitude ({amplitude})"), &|run, t| value(run, &amplitude, t));
    }
    hold("depth", &|run, t| value(run, "z", t));
    hold("time", &|_, t| Some(t));
    all.extend(heading(runs, windows));
    all
}

/// Dependence on the heading by its first harmonic: R of F = a cos ψ + b sin ψ + c.
fn heading(runs: &[Run], windows: &[Window]) -> Option<Dependence> {
    let psi: Vec<f64> = windows.iter().map(|w| value(&runs[w.run], "psi", w.time)).collect::<Option<_>>()?;
    let pair = |f: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        psi.iter().zip(windows).map(|(p, w)| (f(*p), w.force)).collect()
    };
    let (c, s) = (pair(&f64::cos), pair(&f64::sin));
    let (rc, rs) = (correlation(&c), correlation(&s));
    let cross: Vec<(f64, f64)> = c.iter().zip(&s).map(|(a, b)| (a.0, b.0)).collect();
    let rcs = correlation(&cross);
    let spare = 1.0 - rcs * rcs;
    // a heading that hardly changes is indistinguishable from a constant
    if spare < 0.05 {
        return None;
    }
    let r = ((rc * rc + rs * rs - 2.0 * rc * rs * rcs) / spare).max(0.0).sqrt();
    let turn = |p: f64| (p + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
    Some(Dependence { quantity: "heading".into(), correlation: r, points: pair(&turn) })
}

/// The instant in each run at which the mean of the force changes, if it does.
fn changes(runs: &[Run], windows: &[Window]) -> Vec<Change> {
    let of_run = |k: usize| -> Vec<&Window> { windows.iter().filter(|w| w.run == k).collect() };
    let change = |k: usize| {
        let own = of_run(k);
        let forces: Vec<f64> = own.iter().map(|w| w.force).collect();
        let split = change_of_mean(&forces)?;
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let at = 0.5 * (own[split - 1].time + own[split].time);
        Some(Change { run: runs[k].name.clone(), at, before: mean(&forces[..split]), after: mean(&forces[split..]) })
    };
    (0..runs.len()).filter_map(change).collect()
}

/// Index at which the mean of a series changes; `None` if it varies no more than by chance.
fn change_of_mean(x: &[f64]) -> Option<usize> {
    let n = x.len();
    if n < FEWEST {
        return None;
    }
    let mean = x.iter().sum::<f64>() / n as f64;
    let mut sum = 0.0;
    let walk: Vec<f64> = x
        .iter()
        .map(|v| {
            sum += v - mean;
            sum
        })
        .collect();
    let split = (0..n - 1).max_by(|a, b| walk[*a].abs().total_cmp(&walk[*b].abs()))? + 1;
    // the variance about both means: a step must not raise the variance that it is compared with
    let part = |k: usize| if k < split { &x[..split] } else { &x[split..] };
    let centred: Vec<f64> = (0..n).map(|k| x[k] - part(k).iter().sum::<f64>() / part(k).len() as f64).collect();
    let lags = (4.0 * (n as f64 / 100.0).powf(2.0 / 9.0)).ceil() as usize;
    let covariance = |lag: usize| centred.iter().zip(&centred[lag..]).map(|(a, b)| a * b).sum::<f64>() / n as f64;
    let weight = |lag: usize| 2.0 * (1.0 - lag as f64 / (lags + 1) as f64);
    let variance = covariance(0) + (1..=lags).map(|lag| weight(lag) * covariance(lag)).sum::<f64>();
    let spread = (variance.max(covariance(0)) * n as f64).sqrt();
    (walk[split - 1].abs() > CHANGED * spread).then_some(split)
}

fn sentence(dof: Dof, (rms, noise, unit): (f64, f64, &str), goes_with: &[Dependence], changes: &[Change]) -> String {
    if rms <= 1.5 * noise {
        return format!("{dof}: no force is missing beyond the {noise:.2} {unit} that sensor noise causes");
    }
    let with = match goes_with.first() {
        None => "; it correlates with no single state, command or time".to_string(),
        Some(d) => format!("; it correlates with {} (r = {:.2})", d.quantity, d.correlation),
    };
    let when = match changes {
        [] => String::new(),
        [one] => format!(", and changes from {:.2} to {:.2} at {:.1} s of {}", one.before, one.after, one.at, one.run),
        [one, ..] => format!(", and changes within {} runs, e.g. at {:.1} s of {}", changes.len(), one.at, one.run),
    };
    // if the fit has taken the sensor noise for zero, the ratio is meaningless
    let times = match rms / noise {
        times if times < 1000.0 => format!("{times:.1} times"),
        _ => "far beyond".to_string(),
    };
    format!("{dof}: a force of {rms:.2} {unit} is missing, {times} what sensor noise causes{with}{when}")
}

/// Value of a channel at an instant, by linear interpolation.
fn value(run: &Run, channel: &str, t: f64) -> Option<f64> {
    let signal = run.signal(channel).filter(|s| !s.is_empty())?;
    let (time, x) = (signal.time(), signal.values());
    Some(match time.partition_point(|s| *s <= t) {
        0 => x[0],
        k if k == x.len() => x[k - 1],
        k => x[k - 1] + (x[k] - x[k - 1]) * (t - time[k - 1]) / (time[k] - time[k - 1]),
    })
}

/// Pearson's correlation; 0 if one of the two does not vary.
fn correlation(points: &[(f64, f64)]) -> f64 {
    let n = points.len().max(1) as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let sums = points.iter().fold((0.0, 0.0, 0.0), |(xx, xy, yy), (x, y)| {
        (xx + (x - mx).powi(2), xy + (x - mx) * (y - my), yy + (y - my).powi(2))
    });
    if sums.0 > 0.0 && sums.2 > 0.0 { sums.1 / (sums.0 * sums.2).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tank::Noise;

    #[test]
    fn a_step_is_found_where_it_is_and_noise_has_none() {
        let noise = Noise::new(5, 1).coloured(120, 0.5);
        let step: Vec<f64> = noise.iter().enumerate().map(|(k, e)| e + if k < 70 { 0.0 } else { 3.0 }).collect();
        let found = change_of_mean(&step).unwrap();
        assert!((66..=74).contains(&found), "{found}");
        let alarms = (0..200).filter(|seed| change_of_mean(&Noise::new(*seed, 2).coloured(120, 0.5)).is_some()).count();
        // one in a thousand: by chance two of two hundred exceed it in one of fifty sets of seeds
        assert!(alarms <= 2, "{alarms}");
    }

    #[test]
    fn exact_correlations() {
        let line: Vec<(f64, f64)> = (0..9).map(|k| (f64::from(k), 3.0 - 2.0 * f64::from(k))).collect();
        assert!((correlation(&line) + 1.0).abs() < 1e-15);
        assert_eq!(correlation(&[(1.0, 2.0), (1.0, 3.0)]), 0.0);
    }
}
