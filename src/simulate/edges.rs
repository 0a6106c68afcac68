//! Edges and corners of the commands: the instants at which the integrator stops, and their treatment under a
//! delay that is estimated.
//!
//! ```text
//! held:       u(t) = u_k                                              e_k ≤ t < e_{k+1}
//! softened:   u(t) = u_{k−1} + (u_k − u_{k−1}) (t − e_k + w/2)/w       |t − e_k| ≤ w/2
//! ```
//!
//! A step of the integrator across an edge would read it too early or too late by a part of the
//! step; so no step crosses an edge. The derivative of u(t − T) by the delay T is −u̇(t − T): for a
//! held command a pulse at every edge, which the scheme would meet at no instant. If T is to be
//! estimated, edges therefore have the width w, far below the time constants of a vehicle and far
//! above the rounding of time stamps, and are centred, so that they come neither early nor late.
//!
//! A line has corners at its samples. Across a corner in the middle of a step h the scheme takes
//! (1, 4, 1)/6 of the values where (1, 2, 1)/4 is right, an error of h²/24 times the change of slope:
//! a random force where commands that jump about come faster than the sensors. So no step crosses a
//! corner, either. A smooth command in fine samples has none: its changes of slope d follow each other, and the
//! parabola of the scheme is closer to it than the line.

use crate::run::Signal;

/// w: width of a softened edge, s.
const WIDTH: f64 = 1e-3;

/// Distance of two samples of a line up to which they are an edge that was written as a line, s.
const STEEP: f64 = 1e-5;

/// Change of a line from its continuation, in units of its range, below which a sample is no corner:
/// the error is then below a ten thousandth of the command.
const STRAIGHT: f64 = 1e-3;

/// Least correlation of a change of slope with the next one for a smooth command: that of a sinusoid of five samples a
/// period. White noise has −2/3, a random walk −1/2, ramps 0.
const SMOOTH: f64 = 0.25;

/// Behaviour of a command between its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Between {
    /// It keeps the earlier sample.
    Held,
    /// It follows the straight line.
    Line,
}

/// Instants at which a command begins and ends an edge.
pub(super) fn edges(signal: &Signal, between: Between) -> Vec<f64> {
    let (time, _, steep) = as_line(signal, between);
    steep.into_iter().flat_map(|k| [time[k - 1], time[k]]).collect()
}

/// Instants at which a line changes its slope; none for a smooth command, nor for a held one, which has edges only.
pub(super) fn corners(signal: &Signal, between: Between) -> Vec<f64> {
    if between == Between::Held {
        return Vec::new();
    }
    let (time, x) = (signal.time(), signal.values());
    let (low, high) = x.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
    let change = |k: usize| {
        let (before, after) = (time[k] - time[k - 1], time[k + 1] - time[k]);
        ((x[k + 1] - x[k]) / after - (x[k] - x[k - 1]) / before) * before.min(after)
    };
    let changes: Vec<f64> = (1..time.len().saturating_sub(1)).map(change).collect();
    let follow: f64 = changes.windows(2).map(|d| d[0] * d[1]).sum();
    if follow > SMOOTH * changes.iter().map(|d| d * d).sum::<f64>() {
        return Vec::new();
    }
    let is_corner = |d: &f64| d.abs() > STRAIGHT * (high - low);
    time.iter().skip(1).zip(&changes).filter(|(_, d)| is_corner(d)).map(|(t, _)| *t).collect()
}

/// A command as a line with edges that are [`WIDTH`] wide, narrower where samples are as close, and
/// the instants at which edges begin and end.
pub(super) fn softened(signal: &Signal, between: Between) -> (Signal, Vec<f64>) {
    let (sharp, values, steep) = as_line(signal, between);
    let mut time = sharp.clone();
    let mut borders = Vec::with_capacity(2 * steep.len());
    for k in steep {
        let centre = 0.5 * (sharp[k - 1] + sharp[k]);
        let before = k.checked_sub(2).map_or(f64::INFINITY, |i| centre - sharp[i]);
        let after = sharp.get(k + 1).map_or(f64::INFINITY, |t| t - centre);
        let half = (0.5 * WIDTH).min(0.25 * before).min(0.25 * after);
        (time[k - 1], time[k]) = (centre - half, centre + half);
        borders.extend([time[k - 1], time[k]]);
    }
    (Signal::new(time.into(), values), borders)
}

/// The corners of a command as a line, where a held command has edges of zero width, and the
/// indices of the corners that end an edge.
fn as_line(signal: &Signal, between: Between) -> (Vec<f64>, Vec<f64>, Vec<usize>) {
    let (given, x) = (signal.time(), signal.values());
    let (mut time, mut values, mut steep) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..given.len() {
        let changes = k > 0 && x[k].to_bits() != x[k - 1].to_bits();
        if changes && between == Between::Held {
            time.push(given[k]);
            values.push(x[k - 1]);
        }
        if changes && (between == Between::Held || given[k] - given[k - 1] <= STEEP) {
            steep.push(time.len());
        }
        time.push(given[k]);
        values.push(x[k]);
    }
    (time, values, steep)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signal(time: &[f64], values: &[f64]) -> Signal {
        Signal::new(time.into(), values)
    }

    #[test]
    fn a_held_command_has_an_edge_where_it_changes() {
        let held = signal(&[0.0, 0.5, 1.0, 1.5], &[1.0, 1.0, 3.0, 2.0]);
        assert_eq!(edges(&held, Between::Held), [1.0, 1.0, 1.5, 1.5]);
        assert!(edges(&held, Between::Line).is_empty());
        let (soft, borders) = softened(&held, Between::Held);
        assert_eq!(borders, [0.9995, 1.0005, 1.4995, 1.5005]);
        let near = |t: f64, value: f64| assert!((soft.at(t) - value).abs() < 1e-9, "{} at {t}", soft.at(t));
        for (t, value) in [(0.2, 1.0), (0.99, 1.0), (1.0, 2.0), (1.01, 3.0), (1.45, 3.0), (1.6, 2.0)] {
            near(t, value);
        }
    }

    #[test]
    fn an_edge_that_was_written_as_a_line_is_one() {
        let line = signal(&[0.0, 1.0 - 1e-6, 1.0, 2.0], &[0.0, 0.0, 4.0, 5.0]);
        assert_eq!(edges(&line, Between::Line), [1.0 - 1e-6, 1.0]);
        let (soft, _) = softened(&line, Between::Line);
        assert!((soft.at(1.0 - 0.5e-6) - 2.0).abs() < 1e-9 && (soft.at(1.5) - 4.5).abs() < 1e-3);
    }

    #[test]
    fn a_line_has_corners_where_its_slope_changes() {
        let ramps = signal(&[0.0, 0.1, 0.2, 0.4, 0.5, 0.6, 0.7], &[0.0, 1.0, 2.0, 4.0, 4.0, 4.0, 3.0]);
        assert_eq!(corners(&ramps, Between::Line), [0.4, 0.6]);
        assert!(corners(&ramps, Between::Held).is_empty());
        let of_line = |time: &[f64], values: &[f64]| corners(&signal(time, values), Between::Line);
        assert!(of_line(&[0.0], &[1.0]).is_empty() && of_line(&[0.0, 1.0], &[1.0, 2.0]).is_empty());
        // a smooth command has none
        let time: Vec<f64> = (0..100).map(|k| 0.5 * f64::from(k)).collect();
        let wave: Vec<f64> = time.iter().map(|t| t.sin()).collect();
        assert!(of_line(&time, &wave).is_empty());
    }

    /// Commands at 4 kHz: edges are narrower than [`WIDTH`] and stay in order.
    #[test]
    fn close_edges_stay_apart() {
        let time: Vec<f64> = (0..9).map(|k| 2.5e-4 * f64::from(k)).collect();
        let (soft, borders) = softened(&signal(&time, &[0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0]), Between::Held);
        assert!(borders.windows(2).all(|w| w[0] < w[1]) && soft.time().windows(2).all(|w| w[0] < w[1]));
    }
}
