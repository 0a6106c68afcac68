//! The value of a channel of a run at an instant.
//!
//! ```text
//! line:  x_k + (x_{k+1} − x_k)/(t_{k+1} − t_k) (t − t_k)        held:  x_k        t_k ≤ t < t_{k+1}
//! ```
//!
//! Constant outside the samples. At a jump a held channel has a value just before and another just
//! after.

use super::edges::{Between, edges, softened};
use crate::run::{Signal, rounding};
use crate::symbolic::Leaf;

/// The source of an input.
#[derive(Debug, Clone)]
pub(super) enum Channel {
    /// The time of the run, counted from this stamp, s.
    Time(f64),
    /// A channel of the log.
    Samples(Signal),
}

/// One input of the dynamics in one run.
#[derive(Debug, Clone)]
pub(super) struct Input {
    channel: Channel,
    between: Between,
    rate: bool,
    delay: Option<usize>,
    /// Where the command begins and ends an edge, s, before any delay.
    edges: Vec<f64>,
}

impl Input {
    /// The input that `leaf` reads from `channel`. `command`: behaviour between samples, for a
    /// command; `sought`: its delay is estimated.
    pub(super) fn new(leaf: Leaf, channel: Channel, command: Option<Between>, sought: bool) -> Input {
        let rate = matches!(leaf, Leaf::Rate(_) | Leaf::DelayedRate { .. });
        let delay = match leaf {
            Leaf::Delayed { delay, .. } | Leaf::DelayedRate { delay, .. } => Some(usize::from(delay)),
            _ => None,
        };
        match (channel, command) {
            (Channel::Samples(signal), Some(between)) if sought => {
                let (soft, edges) = softened(&signal, between);
                Input { channel: Channel::Samples(soft), between: Between::Line, rate, delay, edges }
            }
            (Channel::Samples(signal), Some(between)) => {
                let edges = edges(&signal, between);
                Input { channel: Channel::Samples(signal), between, rate, delay, edges }
            }
            (channel, _) => Input { channel, between: Between::Line, rate, delay, edges: Vec::new() },
        }
    }

    /// Delay of the input for these parameter values, s.
    pub(super) fn late(&self, theta: &[f64]) -> f64 {
        self.delay.map_or(0.0, |p| theta[p])
    }

    /// Instants at which the integrator has to stop.
    pub(super) fn stops<'a>(&'a self, theta: &[f64]) -> impl Iterator<Item = f64> + use<'a> {
        let late = self.late(theta);
        self.edges.iter().map(move |t| t + late)
    }

    /// A reader at the beginning of the channel.
    pub(super) fn reader(&self) -> Reader<'_> {
        Reader { channel: &self.channel, near: 0, held: self.between == Between::Held, rate: self.rate }
    }
}

/// Reads one channel at instants that mostly grow.
pub(super) struct Reader<'a> {
    channel: &'a Channel,
    near: usize,
    held: bool,
    rate: bool,
}

impl Reader<'_> {
    /// Value just after `t`.
    pub(super) fn after(&mut self, t: f64) -> f64 {
        self.read(t, false)
    }

    /// Value just before `t`.
    pub(super) fn before(&mut self, t: f64) -> f64 {
        self.read(t, true)
    }

    fn read(&mut self, t: f64, before: bool) -> f64 {
        let signal = match self.channel {
            Channel::Samples(signal) => signal,
            Channel::Time(_) if self.rate => return 1.0,
            Channel::Time(origin) => return t - origin,
        };
        let (time, x) = (signal.time(), signal.values());
        // an instant that differs from a sample by rounding alone is that sample's
        let slack = rounding(t);
        let t_search = if before { t - slack } else { t + slack };
        while self.near + 1 < time.len() && time[self.near + 1] <= t_search {
            self.near += 1;
        }
        while self.near > 0 && time[self.near] > t_search {
            self.near -= 1;
        }
        let k = self.near;
        if k + 1 >= time.len() || t_search < time[0] {
            let end = if t_search < time[0] { x[0] } else { x[time.len() - 1] };
            return if self.rate { 0.0 } else { end };
        }
        let slope = (x[k + 1] - x[k]) / (time[k + 1] - time[k]);
        match (self.rate, self.held) {
            (true, true) => 0.0,
            (true, false) => slope,
            (false, true) => x[k],
            (false, false) => x[k] + slope * (t - time[k]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn held_inputs_keep_their_sample_to_the_end_of_the_step() {
        let signal = Signal::new(vec![0.0, 0.5, 1.0].into(), vec![1.0, 3.0, 2.0]);
        let input = |leaf, between| Input::new(leaf, Channel::Samples(signal.clone()), Some(between), false);
        let input_held = input(Leaf::Input(0), Between::Held);
        let mut held = input_held.reader();
        assert_eq!([held.after(0.0), held.after(0.25), held.before(0.5), held.after(0.5)], [1.0, 1.0, 1.0, 3.0]);
        let input_line = input(Leaf::Input(0), Between::Line);
        let mut linear = input_line.reader();
        assert_eq!(
            [linear.after(0.25), linear.before(0.5), linear.after(0.75), linear.after(9.0)],
            [2.0, 3.0, 2.5, 2.0]
        );
        let input_rate = input(Leaf::Rate(0), Between::Line);
        let mut slope = input_rate.reader();
        assert_eq!([slope.after(0.0), slope.before(0.5), slope.after(0.5), slope.after(2.0)], [4.0, 4.0, -2.0, 0.0]);
    }

    #[test]
    fn a_delay_that_is_sought_has_a_slope_at_every_edge() {
        let signal = Signal::new(vec![0.0, 0.5, 1.0].into(), vec![1.0, 3.0, 3.0]);
        let leaf = Leaf::DelayedRate { input: 0, delay: 1 };
        let input = Input::new(leaf, Channel::Samples(signal), Some(Between::Held), true);
        let stops: Vec<f64> = input.stops(&[9.0, 0.3]).collect();
        assert_eq!((stops.len(), input.late(&[9.0, 0.3])), (2, 0.3));
        assert!(stops.iter().all(|t| (t - 0.8).abs() < 1e-3));
        let mut slope = input.reader();
        let pulse = slope.after(0.5);
        assert!((pulse * (stops[1] - stops[0]) - 2.0).abs() < 1e-9, "the pulse is the jump: {pulse}");
        assert_eq!([slope.after(0.2), slope.after(0.7)], [0.0, 0.0]);
    }
}
