//! The value of a channel of a run at an instant.
//!
//! ```text
//! line:  x_k + (x_{k+1} − x_k)/(t_{k+1} − t_k) (t − t_k)        held:  x_k        t_k ≤ t < t_{k+1}
//! ```
//!
//! Constant outside the samples. At a jump a held channel has a value just before and another just
//! after.

use super::edges::{Between, corners, edges, softened};
use crate::run::{Signal, rounding};
use crate::symbolic::{Lateness, Leaf};

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
    /// Whether the value is multiplied by the time of the run.
    elapsed: bool,
    late: Lateness,
    /// The stamp from which the time of the run counts, s.
    origin: f64,
    /// Where the command begins and ends an edge or has a corner, s, before any delay.
    edges: Vec<f64>,
}

/// The delay of an input for given values of the parameters.
#[derive(Debug, Clone, Copy)]
pub(super) struct Late {
    constant: f64,
    drift: f64,
    origin: f64,
}

impl Late {
    /// The instant of the command that acts at `t`.
    pub(super) fn before(self, t: f64) -> f64 {
        t - self.constant - self.drift * (t - self.origin)
    }

    /// The instant at which a command of `t` acts.
    fn after(self, t: f64) -> f64 {
        t + (self.constant + self.drift * (t - self.origin)) / (1.0 - self.drift)
    }
}

impl Input {
    /// The input that `leaf` reads from `channel` of a run that begins at `origin`. `command`: behaviour between samples,
    /// for a command; `sought`: its delay is estimated.
    pub(super) fn new(leaf: Leaf, channel: Channel, origin: f64, command: Option<Between>, sought: bool) -> Input {
        let rate = matches!(leaf, Leaf::Rate(_) | Leaf::DelayedRate { .. });
        let elapsed = matches!(leaf, Leaf::DelayedRate { elapsed: true, .. });
        let late = match leaf {
            Leaf::Delayed { late, .. } | Leaf::DelayedRate { late, .. } => late,
            _ => Lateness::default(),
        };
        let (channel, between, edges) = match (channel, command) {
            (Channel::Samples(signal), Some(between)) if sought => {
                let (soft, mut edges) = softened(&signal, between);
                edges.extend(corners(&signal, between));
                (Channel::Samples(soft), Between::Line, edges)
            }
            (Channel::Samples(signal), Some(between)) => {
                let mut edges = edges(&signal, between);
                edges.extend(corners(&signal, between));
                (Channel::Samples(signal), between, edges)
            }
            (channel, _) => (channel, Between::Line, Vec::new()),
        };
        Input { channel, between, rate, elapsed, late, origin, edges }
    }

    /// Delay of the input for these parameter values.
    pub(super) fn late(&self, theta: &[f64]) -> Late {
        let [constant, drift] = self.late.values(theta);
        Late { constant, drift, origin: self.origin }
    }

    /// Factor of the value that acts at `t`.
    pub(super) fn weight(&self, t: f64) -> f64 {
        if self.elapsed { t - self.origin } else { 1.0 }
    }

    /// Instants at which the integrator has to stop.
    pub(super) fn stops<'a>(&'a self, theta: &[f64]) -> impl Iterator<Item = f64> + use<'a> {
        let late = self.late(theta);
        self.edges.iter().map(move |t| late.after(*t))
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
        let input = |leaf, between| Input::new(leaf, Channel::Samples(signal.clone()), 0.0, Some(between), false);
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
        let late = Lateness { constant: Some(1), drift: None };
        let leaf = Leaf::DelayedRate { input: 0, late, elapsed: false };
        let input = Input::new(leaf, Channel::Samples(signal), 0.0, Some(Between::Held), true);
        let stops: Vec<f64> = input.stops(&[9.0, 0.3]).collect();
        assert_eq!((stops.len(), input.late(&[9.0, 0.3]).before(1.0)), (2, 0.7));
        assert!(stops.iter().all(|t| (t - 0.8).abs() < 1e-3));
        let mut slope = input.reader();
        let pulse = slope.after(0.5);
        assert!((pulse * (stops[1] - stops[0]) - 2.0).abs() < 1e-9, "the pulse is the jump: {pulse}");
        assert_eq!([slope.after(0.2), slope.after(0.7)], [0.0, 0.0]);
    }

    /// A clock of the sensors that is a tenth fast from 5 s on, and 0.3 s late.
    #[test]
    fn a_drifting_clock_brings_a_command_later_and_later() {
        let signal = Signal::new(vec![5.0, 10.0, 15.0].into(), vec![0.0, 1.0, 3.0]);
        let late = Lateness { constant: Some(0), drift: Some(1) };
        let theta = [0.3, 0.1];
        let command = |leaf| Input::new(leaf, Channel::Samples(signal.clone()), 5.0, Some(Between::Held), false);
        let input = command(Leaf::Delayed { input: 0, late });
        let stops: Vec<f64> = input.stops(&theta).collect();
        // the edge of 10 s acts at t with t − 0.3 − 0.1 (t − 5) = 10
        assert!((stops[0] - 9.8 / 0.9).abs() < 1e-12, "{stops:?}");
        let acts = |t: f64| input.reader().after(input.late(&theta).before(t));
        assert_eq!([acts(stops[0] - 1e-6), acts(stops[0] + 1e-6)], [0.0, 1.0]);
        let by_drift = command(Leaf::DelayedRate { input: 0, late, elapsed: true });
        assert_eq!([by_drift.weight(9.0), input.weight(9.0)], [4.0, 1.0]);
    }
}
