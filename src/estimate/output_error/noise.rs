//! Standard deviation of the noise of each output: as given, else estimated from third differences.
//!
//! ```text
//! σ = median |yₖ₊₃ − 3 yₖ₊₂ + 3 yₖ₊₁ − yₖ| / (0.6745 √20)
//! ```
//!
//! Third differences of white noise have √20 times its standard deviation; the median of |x| is
//! 0.6745 σ. The noise of a turn (see [`upright`]) is that of the logged attitude: the noise given
//! for the instrument of tilt or heading, if any.

use std::collections::BTreeMap;

use nalgebra::Quaternion;

use crate::dynamics::Dynamics;
use crate::navigation::upright;
use crate::simulate::Track;

/// Given noise of an output, if any.
fn given(known: Option<&BTreeMap<String, f64>>, output: &str) -> Option<f64> {
    let known = known?;
    known.get(output).or_else(|| known.get(upright::instrument_of(output)?)).copied()
}

/// Noise of every output, in its unit.
pub(super) fn of_outputs(dynamics: &Dynamics, tracks: &[Track], known: Option<&BTreeMap<String, f64>>) -> Vec<f64> {
    let estimate = |output: usize| {
        let mut sizes = Vec::new();
        let mut range: f64 = 0.0;
        for track in tracks {
            match upright::TURNS.iter().position(|turn| *turn == dynamics.outputs[output]) {
                Some(axis) => {
                    range = 1.0;
                    let samples = attitudes(dynamics, track, output);
                    sizes.extend(upright::third_differences(&samples, axis).map(f64::abs));
                }
                None => {
                    let y: Vec<f64> =
                        samples(dynamics, track, output).map(|k| observed(dynamics, track, output, k)).collect();
                    range = y.iter().fold(range, |r, y| r.max(y.abs()));
                    sizes.extend(y.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs()));
                }
            }
        }
        sizes.sort_unstable_by(f64::total_cmp);
        let median = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
        (median / (0.6745 * 20f64.sqrt())).max(1e-9 * range.max(1e-3))
    };
    (0..dynamics.outputs.len()).map(|k| given(known, &dynamics.outputs[k]).unwrap_or_else(|| estimate(k))).collect()
}

fn observed(dynamics: &Dynamics, track: &Track, output: usize, k: usize) -> f64 {
    track.observed[k * dynamics.outputs.len() + output]
}

/// Grid points at which an output has a sample.
fn samples<'a>(dynamics: &'a Dynamics, track: &'a Track, output: usize) -> impl Iterator<Item = usize> + 'a {
    (0..track.time.len()).filter(move |k| !observed(dynamics, track, output, *k).is_nan())
}

/// The logged attitude at the samples of an output.
fn attitudes(dynamics: &Dynamics, track: &Track, output: usize) -> Vec<Quaternion<f64>> {
    samples(dynamics, track, output).filter_map(|k| logged_attitude(dynamics, track, k)).collect()
}

/// The logged attitude at a grid point; `None` if the model does not read it.
pub(super) fn logged_attitude(dynamics: &Dynamics, track: &Track, k: usize) -> Option<Quaternion<f64>> {
    let slot = |name: &str| dynamics.inputs.iter().position(|(_, input)| input == name);
    let value = |name: &str| Some(track.inputs_at[k * dynamics.inputs.len() + slot(name)?]);
    let [w, x, y, z] = upright::LOGGED;
    Some(Quaternion::new(value(w)?, value(x)?, value(y)?, value(z)?).normalize())
}
