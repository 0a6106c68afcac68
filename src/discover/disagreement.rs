//! Where model and data disagree: in which run and degree of freedom, from when to when, under which conditions.
//!
//! A place is a stretch of windows in which the free run errs more than the best model expects. The condition is the
//! quantity whose size correlates best with that of the error (Pearson's correlation over all windows).

use serde::Serialize;

use crate::estimate::filter_error::Forecast;
use crate::frame::Measured;
use crate::model::Model;
use crate::run::Run;

/// Ratio to the noise from which a residual counts as above it.
const ABOVE: f64 = 1.5;

/// A place of disagreement.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Where {
    /// Name of the run.
    pub run: String,
    /// Degree of freedom, or the channel of an observed function of the states.
    pub dof: Measured,
    /// Beginning, s.
    pub from: f64,
    /// End, s.
    pub to: f64,
    /// Root mean square of the residual there over the noise.
    pub times_noise: f64,
    /// Condition under which they disagree, in one sentence.
    pub condition: String,
}

/// Length of the windows, s: that of the longest prediction.
const WINDOW: f64 = 8.0;

/// A window of a run, with the size of its normalised errors.
struct Window {
    run: usize,
    from: f64,
    to: f64,
    size: f64,
}

/// Places at which the model disagrees with `runs`, the worst first. The errors are those of its `forecasts` of
/// `runs`, in units of the error that the `best` model expects, whose noise is not inflated by missing effects.
pub fn disagreement(
    model: &Model,
    outputs: &[String],
    (forecasts, best): (&[Forecast], &[Forecast]),
    runs: &[Run],
) -> Vec<Where> {
    let mut found = Vec::new();
    for dof in model.measured() {
        let Some(output) = outputs.iter().position(|o| *o == dof.channel()) else { continue };
        let windows = windows(forecasts, output, runs, expected(best, output));
        if windows.iter().all(|w| w.size < ABOVE) {
            continue;
        }
        let condition = condition(model, runs, &dof, &windows);
        let mut open: Option<Where> = None;
        for window in &windows {
            let name = &runs[window.run].name;
            match open
                .as_mut()
                .filter(|place| window.size >= ABOVE && place.run == *name && place.to >= window.from - 1e-6)
            {
                Some(place) => {
                    place.to = window.to;
                    place.times_noise = place.times_noise.max(window.size);
                }
                None => {
                    found.extend(open.take());
                    open = (window.size >= ABOVE).then(|| Where {
                        run: name.clone(),
                        dof: dof.clone(),
                        from: window.from,
                        to: window.to,
                        times_noise: window.size,
                        condition: condition.clone(),
                    });
                }
            }
        }
        found.extend(open);
    }
    found.sort_by(|a, b| b.times_noise.total_cmp(&a.times_noise));
    found
}

/// Mean expected error of the free runs of an output.
fn expected(forecasts: &[Forecast], output: usize) -> f64 {
    let points = || forecasts.iter().flat_map(|f| &f.channels).filter(|c| c.output == output).flat_map(|c| &c.free);
    (points().map(|p| p.std * p.std).sum::<f64>() / points().count().max(1) as f64).sqrt()
}

/// Root mean square of the normalised errors of the free run of an output in windows.
fn windows(forecasts: &[Forecast], output: usize, runs: &[Run], expected: f64) -> Vec<Window> {
    let mut all = Vec::new();
    for forecast in forecasts {
        let Some(run) = runs.iter().position(|r| r.name == forecast.run) else { continue };
        let points = forecast.channels.iter().find(|c| c.output == output).map_or(&[][..], |c| &c.free[..]);
        let mut rest = points;
        while let Some(first) = rest.first() {
            let count = rest.iter().take_while(|p| p.time < first.time + WINDOW).count();
            let (now, later) = rest.split_at(count);
            let square: f64 = now.iter().map(|p| ((p.measured - p.mean) / p.std.min(expected)).powi(2)).sum();
            let to = later.first().map_or(now[count - 1].time, |p| p.time);
            all.push(Window { run, from: first.time, to, size: (square / count as f64).sqrt() });
            rest = later;
        }
    }
    all
}

/// Sentence that names the quantity with which the residual grows.
fn condition(model: &Model, runs: &[Run], dof: &Measured, windows: &[Window]) -> String {
    let sizes: Vec<f64> = windows.iter().map(|w| w.size).collect();
    let mut best: Option<(f64, String)> = None;
    for (name, values) in quantities(model, runs, windows) {
        let r = correlation(&sizes, &values);
        if best.as_ref().is_none_or(|(known, _)| r > *known) {
            best = Some((r, name));
        }
    }
    match best {
        Some((r, name)) if r > 0.5 => {
            format!("{dof}: the disagreement grows with {name} (correlation {r:.2} over windows of {WINDOW} s)")
        }
        _ => format!("{dof}: the disagreement correlates with no single state, command or time"),
    }
}

/// Mean size of states, commands and their products in each window, and the time.
fn quantities(model: &Model, runs: &[Run], windows: &[Window]) -> Vec<(String, Vec<f64>)> {
    let dofs = &model.dofs;
    /// Number of instants of a window that are evaluated.
    const INSTANTS: usize = 32;
    let mean = |f: &dyn Fn(&Run, f64) -> Option<f64>| -> Vec<f64> {
        let of = |w: &Window| {
            let at = |k: usize| w.from + (w.to - w.from) * (k as f64 + 0.5) / INSTANTS as f64;
            let values: Vec<f64> = (0..INSTANTS).filter_map(|k| f(&runs[w.run], at(k))).collect();
            values.iter().sum::<f64>() / values.len().max(1) as f64
        };
        windows.iter().map(of).collect()
    };
    let mut all = Vec::new();
    for (i, a) in dofs.iter().enumerate() {
        for channel in [a.velocity(), a.force()] {
            all.push((format!("|{channel}|"), mean(&|run, t| Some(value(run, channel, t)?.abs()))));
        }
        for b in &dofs[i + 1..] {
            let (x, y) = (a.velocity(), b.velocity());
            all.push((format!("|{x} {y}|"), mean(&|run, t| Some((value(run, x, t)? * value(run, y, t)?).abs()))));
        }
        let astern = mean(&|run, t| Some(f64::from(u8::from(value(run, a.velocity(), t)? < 0.0))));
        all.push((format!("negative {}", a.velocity()), astern));
    }
    all.push(("the time of the run".into(), mean(&|_, t| Some(t))));
    if runs.iter().all(|r| r.signal("z").is_some()) {
        all.push(("depth".into(), mean(&|run, t| value(run, "z", t))));
    }
    all
}

fn value(run: &Run, channel: &str, t: f64) -> Option<f64> {
    let signal = run.signal(channel)?;
    let k = signal.time().partition_point(|x| *x < t);
    signal.values().get(k.min(signal.len().saturating_sub(1))).copied()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().max(1) as f64;
    let (ma, mb) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        ab += (x - ma) * (y - mb);
        aa += (x - ma).powi(2);
        bb += (y - mb).powi(2);
    }
    if aa > 0.0 && bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_correlation_of_a_line_is_one() {
        assert!((correlation(&[1.0, 2.0, 3.0], &[2.0, 4.0, 6.0]) - 1.0).abs() < 1e-15);
        assert_eq!(correlation(&[1.0, 1.0], &[2.0, 4.0]), 0.0);
    }
}
