//! Rearrangement of four numbers within one register.

use super::arithmetic::{Plain, Wide};

/// A rearrangement: for each of four lanes the lane from which its value is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(32))]
pub struct Turn([u32; 8]);

impl Default for Turn {
    /// All lanes are taken from the first.
    fn default() -> Turn {
        Turn([0, 1, 0, 1, 0, 1, 0, 1])
    }
}

impl Turn {
    /// Takes lane `to` from lane `from`. A number counts as two halves, as in the instruction.
    pub fn set(&mut self, to: usize, from: usize) {
        let half = 2 * (from % 4) as u32;
        (self.0[2 * to], self.0[2 * to + 1]) = (half, half + 1);
    }
}

/// [`Wide`] with four lanes that can be rearranged.
pub trait Four: Wide<4> {
    /// The lanes of a, rearranged by `turn`.
    fn turn(self, a: Self::Value, turn: &Turn) -> Self::Value;
}

impl Four for Plain {
    #[inline(always)]
    fn turn(self, a: [f64; 4], turn: &Turn) -> [f64; 4] {
        std::array::from_fn(|i| a[(turn.0[2 * i] / 2) as usize % 4])
    }
}

#[cfg(target_arch = "x86_64")]
impl Four for pulp::x86::V3 {
    #[inline(always)]
    fn turn(self, a: Self::Value, turn: &Turn) -> Self::Value {
        pulp::cast(self.avx2._mm256_permutevar8x32_ps(pulp::cast(a), pulp::cast(turn.0)))
    }
}
