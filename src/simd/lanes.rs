//! Lists of lanes that begin at a cache line: a vector across two lines is read twice.
//!
//! Each access makes the slice anew: a loop should take the slice `[..]` once, before it starts.

use std::ops::{Deref, DerefMut};

/// Size of a cache line, bytes.
const LINE: usize = 64;

/// A list of groups of `L` numbers side by side.
#[derive(Debug, Default)]
pub struct Lanes<const L: usize> {
    memory: Vec<f64>,
    begin: usize,
    /// Count of numbers: `L` times the number of groups.
    count: usize,
}

impl<const L: usize> Lanes<L> {
    /// `count` groups of zeros.
    pub fn zeros(count: usize) -> Lanes<L> {
        let (count, spare) = (count * L, LINE / size_of::<f64>());
        let memory = vec![0.0; count + spare];
        let begin = memory.as_ptr().align_offset(LINE);
        Lanes { begin: if begin <= spare { begin } else { 0 }, memory, count }
    }

    /// A copy of a list.
    pub fn of(values: &[[f64; L]]) -> Lanes<L> {
        let mut lanes = Lanes::zeros(values.len());
        lanes.copy_from_slice(values);
        lanes
    }
}

impl<const L: usize> Clone for Lanes<L> {
    fn clone(&self) -> Lanes<L> {
        Lanes::of(self)
    }
}

impl<const L: usize> Deref for Lanes<L> {
    type Target = [[f64; L]];
    #[inline(always)]
    fn deref(&self) -> &[[f64; L]] {
        self.memory[self.begin..self.begin + self.count].as_chunks().0
    }
}

impl<const L: usize> DerefMut for Lanes<L> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [[f64; L]] {
        self.memory[self.begin..self.begin + self.count].as_chunks_mut().0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_lanes_begin_on_a_line_and_copies_do_too() {
        let mut lanes = Lanes::<8>::zeros(3);
        lanes[2] = [4.0; 8];
        for list in [&lanes, &lanes.clone()] {
            assert_eq!((list.as_ptr().align_offset(LINE), list.len(), list[2]), (0, 3, [4.0; 8]));
        }
    }
}
