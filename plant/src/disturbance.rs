//! Random force: a first-order Gauss-Markov process in each degree of freedom.
//!
//! ```text
//! T ḋ = −d + √(2T) σ w(t)
//! exactly at nodes: d₊ = a d + σ √(1 − a²) n,  a = e^(−Δ/T);  straight lines between them
//! T = 0: a new number at every command sample, held over it
//! ```
//!
//! Nodes are 0.01 s apart, or at most T/50 if that is less. On average over a cell, linear
//! interpolation reduces the variance by a share of (1 − a)/3: 0.7 % at most.

use crate::random::Random;

/// Random force of one degree of freedom over a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Force {
    start: f64,
    spacing: f64,
    held: bool,
    nodes: Vec<f64>,
}

/// Maximum distance of nodes, s.
const SPACING: f64 = 0.01;

impl Force {
    /// A realisation of root mean square `rms` and correlation time `time` from `start` to `end`;
    /// `sample` is the period of the commands, s.
    pub fn realise(rms: f64, time: f64, start: f64, end: f64, sample: f64, random: &mut Random) -> Force {
        let held = time <= 0.0;
        let spacing = if held { sample } else { node_spacing(time) };
        let count = ((end - start) / spacing).ceil() as usize + 2;
        let a = if held { 0.0 } else { (-spacing / time).exp() };
        let fresh = (1.0 - a * a).sqrt();
        let mut value = random.normal();
        let nodes = (0..count).map(|k| {
            if k > 0 {
                value = a * value + fresh * random.normal();
            }
            rms * value
        });
        Force { start, spacing, held, nodes: nodes.collect() }
    }

    /// Value of the force at `from`, and its slope, on an interval without a node inside.
    pub fn line(&self, from: f64, to: f64) -> (f64, f64) {
        let position = (0.5 * (from + to) - self.start) / self.spacing;
        let k = (position.max(0.0) as usize).min(self.nodes.len() - 2);
        if self.held {
            return (self.nodes[k], 0.0);
        }
        let slope = (self.nodes[k + 1] - self.nodes[k]) / self.spacing;
        (self.nodes[k] + slope * (from - self.start - k as f64 * self.spacing), slope)
    }
}

/// Distance of the nodes of a force with correlation time `time` > 0, s.
pub fn node_spacing(time: f64) -> f64 {
    SPACING / (SPACING * 50.0 / time).ceil().max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Root mean square and correlation are those asked for. 20 000 s of a force with T of 0.5 s
    /// correspond to some 20 000 independent numbers, which give the mean square within 3 %.
    #[test]
    fn law_rms_and_correlation_are_those_asked_for() {
        for (time, lag) in [(0.5, 0.5), (3.0, 2.0), (0.05, 0.1)] {
            let force = Force::realise(2.0, time, -1.0, 20_000.0, 0.1, &mut Random::new(5, 1));
            let every = (0.1 / node_spacing(time)).round() as usize;
            let list: Vec<f64> = force.nodes.iter().step_by(every).copied().collect();
            let product = |k: usize| list.iter().zip(&list[k..]).map(|(a, b)| a * b).sum::<f64>() / list.len() as f64;
            let steps = (lag / 0.1_f64).round() as usize;
            assert!((product(0).sqrt() / 2.0 - 1.0).abs() < 0.05, "{time}: {}", product(0).sqrt());
            assert!((product(steps) / product(0) - (-lag / time).exp()).abs() < 0.03, "{time}");
        }
    }

    #[test]
    fn white_force_is_held_over_a_sample() {
        let force = Force::realise(1.0, 0.0, 0.0, 10.0, 0.2, &mut Random::new(5, 1));
        let (a, slope) = force.line(0.4, 0.45);
        assert_eq!((a.to_bits(), slope.to_bits()), (force.nodes[2].to_bits(), 0.0f64.to_bits()));
        assert_eq!(a.to_bits(), force.line(0.55, 0.6).0.to_bits());
    }
}
