//! A run prepared for the integrator.
//!
//! The grid is the union of the time stamps of the observed channels. Between two grid points the
//! step is divided at the edges of the commands, shifted by their delay, and so that no substep is
//! longer than the limit. Every substep has its inputs at its beginning, middle and end, by the
//! run's interpolation: for held inputs the end of a step still has the sample of its beginning.

use std::collections::BTreeSet;

use thiserror::Error;

use super::edges::Between;
use super::first_samples::{self, FirstSample};
use super::reader::{Channel, Input};
use crate::dynamics::Dynamics;
use crate::log::check::time::gaps_of;
use crate::model::Interpolation;
use crate::run::{Run, Signal, is_command, rounding};
use crate::symbolic::Leaf;

/// Marks an instant at which a channel has no sample.
pub const NO_SAMPLE: f64 = f64::NAN;

/// The reason why a run cannot be simulated or fitted.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TrackError {
    /// The model reads a channel that the run does not have.
    #[error("run `{run}` has no channel `{channel}`, which the model reads")]
    MissingChannel {
        /// Name of the run.
        run: String,
        /// Name of the channel.
        channel: String,
    },
    /// Fewer than two instants.
    #[error("run `{run}` has {samples} instants; a simulation needs at least 2")]
    TooShort {
        /// Name of the run.
        run: String,
        /// How many it has.
        samples: usize,
    },
    /// So many steps between the instants that the time stamps are probably not in seconds.
    #[error(
        "run `{run}` has {samples} instants over {seconds:.4e} s: at {longest} s a step that is {steps:.4e} steps of the integrator; \
         if its time stamps are no seconds set time_unit, else set fit.longest_step"
    )]
    TooManySteps {
        /// Name of the run.
        run: String,
        /// How many instants it has.
        samples: usize,
        /// Their time span without gaps, s.
        seconds: f64,
        /// Longest step that is allowed, s.
        longest: f64,
        /// Number of steps that it would take.
        steps: f64,
    },
}

/// One step of the integrator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Substep {
    /// Time at its beginning, s.
    pub time: f64,
    /// Length, s.
    pub step: f64,
    /// Grid point that it ends at; `None` inside a grid interval.
    pub ends_at: Option<usize>,
}

/// A run prepared for the integrator.
#[derive(Debug, Clone)]
pub struct Track {
    /// Name of the run.
    pub name: String,
    /// Index of the run, for parameters that have a value in each.
    pub run: usize,
    /// Time stamps of the grid, s.
    pub time: Vec<f64>,
    /// Observations: `time.len()` rows with one value for each output of the dynamics,
    /// [`NO_SAMPLE`] if there is none.
    pub observed: Vec<f64>,
    /// First samples that are left out of the observations.
    pub left_out: Vec<FirstSample>,
    /// First grid point of each stretch without a gap of the log or of a sensor that the model
    /// reads; starts with 0.
    pub starts: Vec<usize>,
    /// Steps of the integrator; those that end at grid point k are `steps_to[k]..steps_to[k + 1]`.
    pub substeps: Vec<Substep>,
    /// Index of the first substep that leads to grid point k from k − 1; one more entry than grid points.
    pub steps_to: Vec<usize>,
    /// Inputs: for each substep at its beginning, middle and end one value for each input of the
    /// dynamics.
    pub inputs: Vec<f64>,
    /// Inputs at each grid point.
    pub inputs_at: Vec<f64>,
    sources: Vec<Input>,
    /// Longest step after each grid point, s.
    longest: Vec<f64>,
    /// Number of parts into which each of these steps is further divided.
    parts: usize,
}

impl Track {
    /// Prepares a run for `dynamics`. `theta`: values of the model's parameters, delays among them;
    /// `interpolation`: behaviour of commands between samples; `longest`: longest step, s.
    ///
    /// # Errors
    /// [`TrackError`] if a channel is missing, or the run is too short or would take too many
    /// steps.
    pub fn new(
        run: &Run,
        index: usize,
        dynamics: &Dynamics,
        theta: &[f64],
        interpolation: Interpolation,
        longest: f64,
    ) -> Result<Track, TrackError> {
        let between = if interpolation == Interpolation::Hold { Between::Held } else { Between::Line };
        let sought = |leaf: Leaf| match leaf {
            Leaf::Delayed { input, late } => {
                let rates = [false, true].map(|elapsed| Leaf::DelayedRate { input, late, elapsed });
                dynamics.inputs.iter().any(|(other, _)| rates.contains(other))
            }
            leaf => matches!(leaf, Leaf::DelayedRate { .. }),
        };
        let source = |(leaf, name): &(Leaf, String)| {
            let channel = match run.signal(name) {
                Some(signal) if !signal.is_empty() => Channel::Samples(signal.clone()),
                _ if name == "t" => Channel::Time(run.origin()),
                _ => return Err(TrackError::MissingChannel { run: run.name.clone(), channel: name.clone() }),
            };
            Ok(Input::new(*leaf, channel, run.origin(), is_command(name).then_some(between), sought(*leaf)))
        };
        let sources = dynamics.inputs.iter().map(source).collect::<Result<Vec<_>, _>>()?;
        let observed: Vec<Option<&Signal>> = dynamics.outputs.iter().map(|name| run.signal(name)).collect();
        let commands = dynamics.inputs.iter().filter_map(|(_, name)| run.signal(name));
        let time = grid(&observed, commands);
        if time.len() < 2 {
            return Err(TrackError::TooShort { run: run.name.clone(), samples: time.len() });
        }
        // a state is simulated over a gap of its sensor; a channel that the model reads as an input
        // is not
        let cuts = gaps_of(run, dynamics.inputs.iter().map(|(_, name)| name.as_str()));
        let starts = starts(&time, &cuts);
        affordable(run, &time, &starts, longest)?;
        let mut table = on_grid(&observed, &time);
        let left_out = first_samples::leave_out(&mut table, &time, &starts, &dynamics.outputs);
        let mut track = Track {
            name: run.name.clone(),
            run: index,
            observed: table,
            left_out,
            starts,
            substeps: Vec::new(),
            steps_to: Vec::new(),
            inputs: Vec::new(),
            inputs_at: Vec::new(),
            sources,
            longest: vec![longest; time.len()],
            parts: 1,
            time,
        };
        track.read_inputs(dynamics, theta);
        Ok(track)
    }

    /// Divides the intervals of the grid at the edges and corners of the commands, and the parts into steps
    /// that are short enough.
    fn divide(&mut self, theta: &[f64]) {
        let mut stops: Vec<f64> = self.sources.iter().flat_map(|source| source.stops(theta)).collect();
        stops.sort_unstable_by(f64::total_cmp);
        let mut stops = stops.into_iter().peekable();
        self.substeps.clear();
        self.steps_to.clear();
        self.steps_to.push(0);
        for k in 1..self.time.len() {
            self.steps_to.push(self.substeps.len());
            let (mut begin, end) = (self.time[k - 1], self.time[k]);
            let inside = self.starts.binary_search(&k).is_err();
            while let Some(stop) = stops.next_if(|stop| *stop < end - rounding(end)) {
                if inside && stop > begin + rounding(begin) {
                    self.step(begin, stop, self.longest[k - 1]);
                    begin = stop;
                }
            }
            if inside {
                self.step(begin, end, self.longest[k - 1]);
                let last = self.substeps.len() - 1;
                self.substeps[last].ends_at = Some(k);
            }
        }
        self.steps_to.push(self.substeps.len());
    }

    /// Steps of equal length, at most `longest` s, from one instant to another.
    fn step(&mut self, begin: f64, end: f64, longest: f64) {
        // a step that is longer by rounding alone is not divided
        let parts = ((end - begin) / longest * (1.0 - 1e-9)).ceil().max(1.0) as usize * self.parts;
        let step = (end - begin) / parts as f64;
        let substep = |i| Substep { time: begin + step * i as f64, step, ends_at: None };
        self.substeps.extend((0..parts).map(substep));
    }

    /// The longest step after each grid point, s.
    pub fn longest(&self) -> &[f64] {
        &self.longest
    }

    /// Changes the longest steps after the grid points to `steps`, s, where the present ones are
    /// more than 1.25 times as long or less than half as long. Returns whether any has changed; the
    /// inputs must then be read again.
    pub fn follow(&mut self, steps: impl Iterator<Item = f64>) -> bool {
        let mut any = false;
        for (own, step) in self.longest.iter_mut().zip(steps) {
            if step < 0.8 * *own || step > 2.0 * *own {
                (*own, any) = (step, true);
            }
        }
        any
    }

    /// Divides the run into steps and reads the inputs. Call it again whenever a delay among the
    /// parameters has changed.
    pub fn read_inputs(&mut self, dynamics: &Dynamics, theta: &[f64]) {
        self.divide(theta);
        let width = dynamics.inputs.len();
        let mut inputs = vec![0.0; self.substeps.len() * 3 * width];
        let mut at_grid = vec![0.0; self.time.len() * width];
        for (slot, source) in self.sources.iter().enumerate() {
            let (mut reader, late) = (source.reader(), source.late(theta));
            for (k, s) in self.substeps.iter().enumerate() {
                let (begin, middle, end) = (s.time, s.time + 0.5 * s.step, s.time + s.step);
                let row = &mut inputs[k * 3 * width..(k + 1) * 3 * width];
                row[slot] = reader.after(late.before(begin)) * source.weight(begin);
                row[width + slot] = reader.after(late.before(middle)) * source.weight(middle);
                row[2 * width + slot] = reader.before(late.before(end)) * source.weight(end);
            }
            let mut reader = source.reader();
            for (k, t) in self.time.iter().enumerate() {
                at_grid[k * width + slot] = reader.after(late.before(*t)) * source.weight(*t);
            }
        }
        self.inputs = inputs;
        self.inputs_at = at_grid;
    }
}

/// Returns an error if the run would take too many steps.
fn affordable(run: &Run, time: &[f64], starts: &[usize], longest: f64) -> Result<(), TrackError> {
    /// Limit of the mean number of steps between two instants: a sample every 20 s at the usual
    /// longest step shows no dynamics.
    const MOST: f64 = 200.0;
    /// Number of steps that any run may take.
    const ALWAYS: f64 = 1e4;
    let inside = |k: &usize| starts.binary_search(k).is_err();
    let seconds: f64 = (1..time.len()).filter(inside).map(|k| time[k] - time[k - 1]).sum();
    let (samples, steps) = (time.len(), seconds / longest);
    if steps <= ALWAYS + MOST * samples as f64 {
        return Ok(());
    }
    Err(TrackError::TooManySteps { run: run.name.clone(), samples, seconds, longest, steps })
}

/// Union of the time stamps of the observed channels, or of the commands if nothing is observed.
fn grid<'a>(observed: &[Option<&'a Signal>], commands: impl Iterator<Item = &'a Signal>) -> Vec<f64> {
    let mut stamps: Vec<&[f64]> = observed.iter().flatten().map(|s| s.time()).collect();
    if stamps.is_empty() {
        stamps.extend(commands.map(Signal::time));
    }
    let shared = stamps.windows(2).all(|w| std::ptr::eq(w[0], w[1]) || w[0] == w[1]);
    if let (true, Some(first)) = (shared, stamps.first()) {
        return first.to_vec();
    }
    let union: BTreeSet<u64> = stamps.iter().flat_map(|s| s.iter()).map(|t| ordered(*t)).collect();
    let mut time: Vec<f64> = union.into_iter().map(from_ordered).collect();
    time.dedup_by(|b, a| *b - *a <= rounding(*a));
    time
}

/// Bits that sort like the numbers.
fn ordered(x: f64) -> u64 {
    let bits = x.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

fn from_ordered(bits: u64) -> f64 {
    f64::from_bits(if bits >> 63 == 1 { bits & !(1 << 63) } else { !bits })
}

fn on_grid(observed: &[Option<&Signal>], time: &[f64]) -> Vec<f64> {
    let width = observed.len();
    let mut table = vec![NO_SAMPLE; time.len() * width];
    for (column, signal) in observed.iter().enumerate() {
        let Some(signal) = signal else { continue };
        let mut k = 0;
        for (t, x) in signal.time().iter().zip(signal.values()) {
            while k + 1 < time.len() && time[k + 1] <= t + rounding(*t) {
                k += 1;
            }
            table[k * width + column] = *x;
        }
    }
    table
}

/// Grid points at which a stretch begins: the first one, and the first at or after the end of each
/// gap.
fn starts(time: &[f64], gaps: &[f64]) -> Vec<usize> {
    let mut starts = vec![0];
    for gap in gaps {
        let k = time.partition_point(|t| t < gap);
        if k > 0 && k < time.len() {
            starts.push(k);
        }
    }
    starts.sort_unstable();
    starts.dedup();
    starts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grid_is_the_union_of_the_sensors_stamps() {
        let fast = Signal::new(vec![-0.1, 0.0, 0.1, 0.2].into(), vec![1.0; 4]);
        let slow = Signal::new(vec![0.05, 0.2 + 1e-12].into(), vec![2.0; 2]);
        let observed = [Some(&fast), Some(&slow)];
        let time = grid(&observed, std::iter::empty());
        assert_eq!(time, [-0.1, 0.0, 0.05, 0.1, 0.2]);
        let table = on_grid(&observed, &time);
        let slow_column: Vec<bool> = table.chunks(2).map(|row| row[1].is_nan()).collect();
        assert_eq!(slow_column, [true, true, false, true, false]);
    }

    #[test]
    fn a_gap_begins_a_stretch() {
        assert_eq!(starts(&[0.0, 0.1, 3600.0, 3600.1], &[3600.0]), [0, 2]);
    }
}
