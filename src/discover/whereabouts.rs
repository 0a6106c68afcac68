//! Where model and data disagree: in which run and degree of freedom, from when to when, under which conditions.
//!
//! Each segment of the fit has its own initial state, so that what is left in it is made in it. A stretch of segments
//! whose residual stands above the noise is one place; the condition is the quantity whose size in the segments goes
//! best with the size of the residual (Pearson's correlation over all segments).

use serde::Serialize;

use crate::estimate::output_error::OutputErrorFit;
use crate::frame::Measured;
use crate::run::Run;

/// A residual counts as above the noise from this multiple of it on.
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
    /// Under which condition, in one sentence.
    pub condition: String,
}

/// Places at which `fit` disagrees with its runs, the worst first.
pub fn whereabouts(fit: &OutputErrorFit, runs: &[Run]) -> Vec<Where> {
    let mut found = Vec::new();
    for dof in fit.model.measured() {
        let Some(output) = fit.problem.dynamics.outputs.iter().position(|o| *o == dof.channel()) else { continue };
        let sizes: Vec<f64> = fit
            .linearised
            .iter()
            .map(|s| (s.squares[output] * fit.problem.dynamics.outputs.len() as f64 / s.samples.max(1) as f64).sqrt())
            .collect();
        if sizes.iter().all(|s| *s < ABOVE) {
            continue;
        }
        let condition = condition(fit, runs, &dof, &sizes);
        let mut open: Option<(usize, usize, Vec<f64>)> = None;
        for (k, stretch) in fit.problem.segments.iter().enumerate() {
            let here = sizes[k] >= ABOVE;
            let goes_on = open.as_ref().is_some_and(|(track, _, _)| *track == stretch.track);
            if let (true, Some((_, last, values))) = (here && goes_on, open.as_mut()) {
                *last = k;
                values.push(sizes[k]);
                continue;
            }
            if let Some(place) = open.take() {
                found.push(place_of(fit, &dof, place, &condition));
            }
            if here {
                open = Some((stretch.track, k, vec![sizes[k]]));
            }
        }
        if let Some(place) = open {
            found.push(place_of(fit, &dof, place, &condition));
        }
    }
    found.sort_by(|a, b| b.times_noise.total_cmp(&a.times_noise));
    found
}

fn place_of(
    fit: &OutputErrorFit,
    dof: &Measured,
    (track, last, values): (usize, usize, Vec<f64>),
    condition: &str,
) -> Where {
    let first = last + 1 - values.len();
    let t = &fit.problem.tracks[track];
    let rms = (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
    Where {
        run: t.name.clone(),
        dof: dof.clone(),
        from: t.time[fit.problem.segments[first].first],
        to: t.time[fit.problem.segments[last].last],
        times_noise: rms,
        condition: condition.to_string(),
    }
}

/// The sentence that says with what the residual goes.
fn condition(fit: &OutputErrorFit, runs: &[Run], dof: &Measured, sizes: &[f64]) -> String {
    let mut best: Option<(f64, String)> = None;
    for (name, values) in quantities(fit, runs) {
        let r = correlation(sizes, &values);
        if best.as_ref().is_none_or(|(known, _)| r > *known) {
            best = Some((r, name));
        }
    }
    match best {
        Some((r, name)) if r > 0.5 => {
            format!("{dof}: the disagreement grows with {name} (correlation {r:.2} over segments)")
        }
        _ => format!("{dof}: the disagreement goes with no single state, command or time"),
    }
}

/// Mean size of states, commands and their products in each segment, and the time.
fn quantities(fit: &OutputErrorFit, runs: &[Run]) -> Vec<(String, Vec<f64>)> {
    let dofs = &fit.model.dofs;
    let mean = |f: &dyn Fn(&Run, f64) -> Option<f64>| -> Vec<f64> {
        fit.problem
            .segments
            .iter()
            .map(|s| {
                let track = &fit.problem.tracks[s.track];
                let run = &runs[track.run];
                let values: Vec<f64> = track.time[s.first..=s.last].iter().filter_map(|t| f(run, *t)).collect();
                values.iter().sum::<f64>() / values.len().max(1) as f64
            })
            .collect()
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
