//! Inputs, step lengths and grid points of several stretches that are integrated side by side.
//!
//! ```text
//! step k:   inputs at t_k, t_k + h/2, t_k + h        h = 0 and inputs as they were for a lane that is done
//! ```
//!
//! If all lanes integrate the same stretch, its table is read in place. Else each number is written
//! to its lane one step ahead: reading a register right after one of its numbers was written has to
//! wait.

use super::Track;
use crate::simd::{Lanes, Wide};

/// A stretch of a track: grid points `first` to `last`, both included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stretch {
    /// Index of the track.
    pub track: usize,
    /// First grid point.
    pub first: usize,
    /// Last grid point.
    pub last: usize,
}

/// Instants of a step: its beginning, middle and end.
const INSTANTS: usize = 3;

/// The lanes' inputs, step by step.
#[derive(Clone)]
pub(crate) struct Feed<'a, const L: usize> {
    /// Length of this step, s.
    pub h: [f64; L],
    /// Grid point of each lane; `None` for a lane between grid points or at its end.
    pub grid: [Option<usize>; L],
    tracks: &'a [Track],
    stretches: &'a [Option<Stretch>; L],
    /// Range of steps of each lane, as its track counts them.
    ranges: [(usize, usize); L],
    /// Number of inputs of the model.
    slots: usize,
    /// Inputs of this step in the track's table if all lanes have the same stretch; before the
    /// first step those of the first grid point.
    shared: Option<&'a [f64]>,
    /// Inputs of this step.
    now: Lanes<L>,
    /// Those of the next.
    next: Lanes<L>,
}

impl<'a, const L: usize> Feed<'a, L> {
    /// The feed at the beginning of the stretches, before any step.
    pub fn new(tracks: &'a [Track], stretches: &'a [Option<Stretch>; L], slots: usize) -> Feed<'a, L> {
        let range = |stretch: Stretch| {
            let steps_to = &tracks[stretch.track].steps_to;
            (steps_to[stretch.first + 1], steps_to[stretch.last + 1])
        };
        let ranges = std::array::from_fn(|lane| stretches[lane].map_or((0, 0), range));
        let at_first = |s: Stretch| &tracks[s.track].inputs_at[s.first * slots..(s.first + 1) * slots];
        let alike = stretches.iter().all(|s| *s == stretches[0]);
        let shared = stretches[0].filter(|_| alike).map(at_first);
        let mut feed = Feed {
            h: [0.0; L],
            grid: stretches.map(|stretch| stretch.map(|s| s.first)),
            tracks,
            stretches,
            ranges,
            slots,
            shared,
            now: Lanes::zeros(INSTANTS * slots),
            next: Lanes::zeros(INSTANTS * slots),
        };
        for (lane, stretch) in stretches.iter().enumerate() {
            for (slot, value) in feed.now.iter_mut().zip(stretch.map(at_first).unwrap_or_default()) {
                slot[lane] = *value;
            }
        }
        feed.read(0);
        feed
    }

    /// Steps of the longest stretch.
    pub fn steps(&self) -> usize {
        self.ranges.iter().map(|(begin, end)| end - begin).max().unwrap_or(0)
    }

    /// Writes the inputs of one of the three instants of this step; before the first step only the
    /// first instant exists.
    #[inline(always)]
    pub fn put<W: Wide<L>>(&self, wide: W, instant: usize, to: &mut [[f64; L]]) {
        let here = instant * self.slots..(instant + 1) * self.slots;
        match self.shared {
            Some(table) => {
                to.iter_mut().zip(&table[here]).for_each(|(to, value)| *to = wide.store(wide.splat(*value)));
            }
            None => to.iter_mut().zip(&self.now[here]).for_each(|(to, from)| *to = *from),
        }
    }

    /// Moves to the step `step`.
    #[inline(always)]
    pub fn go_on(&mut self, step: usize) {
        if let (Some(table), Some(stretch)) = (&mut self.shared, self.stretches[0]) {
            let (track, at) = (&self.tracks[stretch.track], self.ranges[0].0 + step);
            let row = at * INSTANTS * self.slots;
            *table = &track.inputs[row..row + INSTANTS * self.slots];
            (self.h, self.grid) = ([track.substeps[at].step; L], [track.substeps[at].ends_at; L]);
            return;
        }
        for lane in 0..L {
            let (begin, end) = self.ranges[lane];
            let substep = self.stretches[lane].filter(|_| begin + step < end).map(|s| {
                let substep = &self.tracks[s.track].substeps[begin + step];
                (substep.step, substep.ends_at)
            });
            (self.h[lane], self.grid[lane]) = substep.unwrap_or((0.0, None));
        }
        std::mem::swap(&mut self.now, &mut self.next);
        self.read(step + 1);
    }

    /// Reads the inputs of the step `step` of every lane ahead; those of lanes at their end stay.
    #[inline(always)]
    fn read(&mut self, step: usize) {
        if self.shared.is_some() {
            return;
        }
        for lane in 0..L {
            let (begin, end) = self.ranges[lane];
            if let (Some(stretch), true) = (self.stretches[lane], begin + step < end) {
                let row = (begin + step) * INSTANTS * self.slots;
                let table = &self.tracks[stretch.track].inputs[row..row + INSTANTS * self.slots];
                for (slot, value) in self.next.iter_mut().zip(table) {
                    slot[lane] = *value;
                }
            }
        }
    }
}
