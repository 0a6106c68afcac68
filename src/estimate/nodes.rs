//! Instants at which a balance is evaluated, and the values of the log there.
//!
//! Rows begin and end at stamps of the *own* sensor, which logs the velocity of the balance: its
//! increments are small differences that interpolation would spoil. Every other channel is read
//! there on a straight line between its own samples (for a command that is held: its last sample);
//! headings turn the shorter way. Nothing is read beyond a channel's last sample or across a gap. A
//! channel with a single sample is constant over the run.

use serde::{Deserialize, Serialize};

use super::balance::Source;
use crate::log::check::time::gaps_of;
use crate::model::Interpolation;
use crate::navigation::unwrap;
use crate::run::{Run, Signal, is_command, rounding};

/// Instants of the trapezoid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Nodes {
    /// The stamps of every channel that the balance reads: a command that changes sign between two
    /// samples of a slow velocity is integrated as it was. The same as `Own` if all channels share
    /// their stamps.
    #[default]
    Every,
    /// The stamps of the own velocity sensor alone, as in the paper.
    Own,
}

/// The time that a row of the regression spans.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Span {
    /// This many intervals of the own sensor, end to end; 1 in the paper.
    Samples(usize),
    /// From the first sample of the stretch to each later one.
    FromStart,
}

impl Default for Span {
    fn default() -> Span {
        Span::Samples(1)
    }
}

/// A stretch of a run without gaps.
#[derive(Debug, Clone)]
pub(super) struct Stretch {
    /// Instants, s.
    pub time: Vec<f64>,
    /// Whether an instant is a sample of the own sensor; the first and the last one are.
    pub own: Vec<bool>,
}

/// Reads one leaf at increasing instants.
#[derive(Debug)]
pub(super) struct Reader {
    name: Option<String>,
    samples: Option<Signal>,
    near: usize,
    held: bool,
    late: f64,
    /// Time stamp from which the time of the run is counted, s.
    origin: f64,
}

impl Reader {
    /// A reader of a leaf that is read from the run; `late` is the value of its delay, s.
    pub fn new(run: &Run, source: &Source, late: f64, input: Interpolation) -> Reader {
        let name = match source {
            Source::Channel { name, .. } => Some(name.as_str()),
            _ => None,
        };
        let samples = name.and_then(|name| run.signal(name)).map(|signal| match name.unwrap_or_default() {
            "phi" | "psi" => Signal::new(signal.shared_time().clone(), unwrap(signal.values())),
            _ => signal.clone(),
        });
        let held = input == Interpolation::Hold && name.is_some_and(is_command);
        Reader { name: name.map(str::to_string), samples, near: 0, held, late, origin: run.origin() }
    }

    /// Whether the value just before an instant may differ from that just after it.
    pub fn jumps(&self) -> bool {
        self.held
    }

    /// Value just after (or, with `before`, just before) `t`.
    pub fn read(&mut self, t: f64, before: bool) -> f64 {
        let t = t - self.late;
        let Some(signal) = &self.samples else { return t - self.origin };
        let (time, x) = (signal.time(), signal.values());
        let slack = rounding(t);
        let search = if before && self.held { t - slack } else { t + slack };
        while self.near + 1 < time.len() && time[self.near + 1] <= search {
            self.near += 1;
        }
        while self.near > 0 && time[self.near] > search {
            self.near -= 1;
        }
        let k = self.near;
        if self.held || k + 1 >= time.len() || t < time[0] {
            return x[k];
        }
        x[k] + (x[k + 1] - x[k]) / (time[k + 1] - time[k]) * (t - time[k])
    }

    /// The channel's values, if they are read unchanged at the stamps of `own`.
    pub fn on_stamps(&self, own: &Signal) -> Option<&[f64]> {
        let signal = self.samples.as_ref().filter(|_| !self.held && self.late.abs() <= 0.0)?;
        let shared = std::ptr::eq(signal.time(), own.time()) || signal.time() == own.time();
        shared.then(|| signal.values())
    }

    /// Whether it reads the time stamp itself.
    pub fn is_time(&self) -> bool {
        self.samples.is_none() && self.origin.abs() <= 0.0
    }

    /// The part of `from..to` over which the channel has samples.
    fn cover(&self, from: f64, to: f64) -> (f64, f64) {
        let Some(signal) = self.samples.as_ref().filter(|s| s.len() > 1) else { return (from, to) };
        let time = signal.time();
        let inside = &time[time.partition_point(|t| *t < from)..time.partition_point(|t| *t < to)];
        match (inside.first(), inside.last()) {
            (Some(first), Some(last)) => (first + self.late, if self.held { to } else { last + self.late }),
            _ => (to, from),
        }
    }

    fn stamps(&self) -> &[f64] {
        self.samples.as_ref().map_or(&[], Signal::time)
    }
}

/// The stretches of `run` over which all `readers` have samples, on the stamps of `own`, the channel `name`.
pub(super) fn stretches(run: &Run, name: &str, own: &Signal, readers: &[Reader], nodes: Nodes) -> Vec<Stretch> {
    let mut edges = vec![f64::NEG_INFINITY];
    edges.extend(gaps_of(run, readers.iter().filter_map(|r| r.name.as_deref()).chain([name])));
    edges.push(f64::INFINITY);
    edges.sort_unstable_by(f64::total_cmp);
    let mut found = Vec::new();
    for edge in edges.windows(2) {
        let covers = readers.iter().map(|r| r.cover(edge[0], edge[1]));
        let (from, to) = covers.fold((edge[0], edge[1]), |(a, b), (c, d)| (a.max(c), b.min(d)));
        let slack = rounding(if from.is_finite() { from } else { 0.0 });
        let time = own.time();
        let first = time.partition_point(|t| *t < edge[0] || *t < from - slack);
        let end = time.partition_point(|t| *t < edge[1] && *t <= to + slack);
        if end < first + 2 {
            continue;
        }
        let stamps = time[first..end].to_vec();
        let others: Vec<&Reader> = match nodes {
            Nodes::Own => Vec::new(),
            Nodes::Every => readers.iter().filter(|r| r.late.abs() > 0.0 || r.stamps() != own.time()).collect(),
        };
        found.push(merge(stamps, &others));
    }
    found
}

/// The own stamps, with those of the others in between.
fn merge(own: Vec<f64>, others: &[&Reader]) -> Stretch {
    if others.is_empty() {
        return Stretch { own: vec![true; own.len()], time: own };
    }
    let mut extra: Vec<f64> = others.iter().flat_map(|r| r.stamps().iter().map(|t| t + r.late)).collect();
    extra.sort_unstable_by(f64::total_cmp);
    let mut next = extra.into_iter().peekable();
    let mut stretch = Stretch { time: Vec::with_capacity(own.len()), own: Vec::with_capacity(own.len()) };
    for t in own {
        let slack = rounding(t);
        while let Some(e) = next.next_if(|e| *e <= t + slack) {
            let last = stretch.time.last().copied();
            // none is wanted before the first own stamp; one equal to an own stamp is there already
            if last.is_some_and(|last| e > last + slack) && e < t - slack {
                stretch.time.push(e);
                stretch.own.push(false);
            }
        }
        stretch.time.push(t);
        stretch.own.push(true);
    }
    stretch
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(name: &str) -> Source {
        Source::Channel { name: name.into(), late: None }
    }

    fn run() -> Run {
        let mut run = Run { gaps: vec![3.0], ..Run::default() };
        let own = vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        run.signals.insert("u".into(), Signal::new(own.into(), vec![0.0; 6]));
        let tau = vec![-0.5, 0.5, 1.0, 2.2, 3.1, 3.5, 5.0];
        run.signals.insert("tau_u".into(), Signal::new(tau.into(), vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
        run
    }

    #[test]
    fn rows_stay_inside_gaps_and_samples() {
        let run = run();
        let readers = [Reader::new(&run, &channel("tau_u"), 0.0, Interpolation::Linear)];
        let own = run.signal("u").unwrap();
        let times = |nodes| stretches(&run, "u", own, &readers, nodes).into_iter().map(|s| s.time).collect::<Vec<_>>();
        assert_eq!(times(Nodes::Own), [vec![0.0, 1.0, 2.0], vec![4.0, 5.0]]);
        assert_eq!(times(Nodes::Every), [vec![0.0, 0.5, 1.0, 2.0], vec![4.0, 5.0]]);
    }

    #[test]
    fn held_commands_jump_and_lines_do_not() {
        let run = run();
        let mut line = Reader::new(&run, &channel("tau_u"), 0.0, Interpolation::Linear);
        assert_eq!((line.read(0.75, false), line.read(1.0, true), line.read(1.0, false)), (1.5, 2.0, 2.0));
        let mut held = Reader::new(&run, &channel("tau_u"), 0.0, Interpolation::Hold);
        assert_eq!((held.read(0.75, false), held.read(1.0, true), held.read(1.0, false)), (1.0, 1.0, 2.0));
        let mut late = Reader::new(&run, &channel("tau_u"), 0.25, Interpolation::Linear);
        assert_eq!(late.read(1.0, false), 1.5);
    }

    #[test]
    fn headings_turn_the_shorter_way() {
        let mut run = Run::default();
        run.signals.insert("psi".into(), Signal::new(vec![0.0, 1.0].into(), vec![3.1, -3.1]));
        let mut psi = Reader::new(&run, &channel("psi"), 0.0, Interpolation::Linear);
        assert!((psi.read(0.5, false) - std::f64::consts::PI).abs() < 1e-12, "rounding only");
    }
}
