//! Four numbers side by side, by name: where the compiler would have to find them, it shuffles.
//!
//! The same operations in the same order on every machine, so that results do not depend on it. A product and a sum in one
//! round once, on machines without such an instruction too.

/// From which lane of four each of four is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(32))]
pub struct Turn([u32; 8]);

impl Default for Turn {
    /// Each from the first.
    fn default() -> Turn {
        Turn([0, 1, 0, 1, 0, 1, 0, 1])
    }
}

impl Turn {
    /// Lane `to` is taken from lane `from`. A number is two halves, as the instruction counts them.
    pub fn set(&mut self, to: usize, from: usize) {
        let half = 2 * (from % 4) as u32;
        (self.0[2 * to], self.0[2 * to + 1]) = (half, half + 1);
    }
}

/// How four numbers are kept and calculated with.
pub trait Four: Copy {
    /// Four numbers.
    type Value: Copy;
    /// Four times the same.
    fn splat(self, x: f64) -> Self::Value;
    /// From an array.
    fn load(self, x: &[f64; 4]) -> Self::Value;
    /// To an array.
    fn store(self, x: Self::Value) -> [f64; 4];
    /// a + b
    fn add(self, a: Self::Value, b: Self::Value) -> Self::Value;
    /// a·b
    fn mul(self, a: Self::Value, b: Self::Value) -> Self::Value;
    /// a·b + c, rounded once
    fn fused(self, a: Self::Value, b: Self::Value, c: Self::Value) -> Self::Value;
    /// |a|
    fn abs(self, a: Self::Value) -> Self::Value;
    /// a with its lanes in other places
    fn turn(self, a: Self::Value, turn: &Turn) -> Self::Value;
}

/// Four numbers on any machine.
#[derive(Debug, Clone, Copy)]
pub struct Plain;

impl Four for Plain {
    type Value = [f64; 4];
    #[inline(always)]
    fn splat(self, x: f64) -> [f64; 4] {
        [x; 4]
    }
    #[inline(always)]
    fn load(self, x: &[f64; 4]) -> [f64; 4] {
        *x
    }
    #[inline(always)]
    fn store(self, x: [f64; 4]) -> [f64; 4] {
        x
    }
    #[inline(always)]
    fn add(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| a[i] + b[i])
    }
    #[inline(always)]
    fn mul(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| a[i] * b[i])
    }
    #[inline(always)]
    fn fused(self, a: [f64; 4], b: [f64; 4], c: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| a[i].mul_add(b[i], c[i]))
    }
    #[inline(always)]
    fn abs(self, a: [f64; 4]) -> [f64; 4] {
        a.map(f64::abs)
    }
    #[inline(always)]
    fn turn(self, a: [f64; 4], turn: &Turn) -> [f64; 4] {
        std::array::from_fn(|i| a[(turn.0[2 * i] / 2) as usize % 4])
    }
}

#[cfg(target_arch = "x86_64")]
impl Four for pulp::x86::V3 {
    type Value = pulp::f64x4;
    #[inline(always)]
    fn splat(self, x: f64) -> pulp::f64x4 {
        self.splat_f64x4(x)
    }
    #[inline(always)]
    fn load(self, x: &[f64; 4]) -> pulp::f64x4 {
        pulp::cast(*x)
    }
    #[inline(always)]
    fn store(self, x: pulp::f64x4) -> [f64; 4] {
        pulp::cast(x)
    }
    #[inline(always)]
    fn add(self, a: pulp::f64x4, b: pulp::f64x4) -> pulp::f64x4 {
        self.add_f64x4(a, b)
    }
    #[inline(always)]
    fn mul(self, a: pulp::f64x4, b: pulp::f64x4) -> pulp::f64x4 {
        self.mul_f64x4(a, b)
    }
    #[inline(always)]
    fn fused(self, a: pulp::f64x4, b: pulp::f64x4, c: pulp::f64x4) -> pulp::f64x4 {
        self.mul_add_f64x4(a, b, c)
    }
    #[inline(always)]
    fn abs(self, a: pulp::f64x4) -> pulp::f64x4 {
        self.abs_f64x4(a)
    }
    #[inline(always)]
    fn turn(self, a: pulp::f64x4, turn: &Turn) -> pulp::f64x4 {
        pulp::cast(self.avx2._mm256_permutevar8x32_ps(pulp::cast(a), pulp::cast(turn.0)))
    }
}
