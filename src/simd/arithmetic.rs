//! Arithmetic on `L` numbers side by side, with named operations: automatic vectorisation would add
//! shuffles.
//!
//! The same operations are done in the same order on every machine, so that results do not depend
//! on it.

/// Storage of `L` numbers and operations on them.
pub trait Wide<const L: usize>: Copy {
    /// `L` numbers.
    type Value: Copy;
    /// `L` copies of `x`.
    fn splat(self, x: f64) -> Self::Value;
    /// From an array.
    fn load(self, x: &[f64; L]) -> Self::Value;
    /// To an array.
    fn store(self, x: Self::Value) -> [f64; L];
    /// a + b
    fn add(self, a: Self::Value, b: Self::Value) -> Self::Value;
    /// a − b
    fn sub(self, a: Self::Value, b: Self::Value) -> Self::Value;
    /// a·b
    fn mul(self, a: Self::Value, b: Self::Value) -> Self::Value;
    /// a/b
    fn div(self, a: Self::Value, b: Self::Value) -> Self::Value;
    /// |a|
    fn abs(self, a: Self::Value) -> Self::Value;
    /// √a
    fn sqrt(self, a: Self::Value) -> Self::Value;
    /// a if b is not 0, otherwise 0, whatever the value of a.
    fn only_where(self, a: Self::Value, b: Self::Value) -> Self::Value;
    /// a·b + c, rounded once, also on machines without such an instruction.
    fn fused(self, a: Self::Value, b: Self::Value, c: Self::Value) -> Self::Value;

    /// a
    #[inline(always)]
    fn same(self, a: Self::Value) -> Self::Value {
        a
    }

    /// −a
    #[inline(always)]
    fn neg(self, a: Self::Value) -> Self::Value {
        self.mul(a, self.splat(-1.0))
    }

    /// Sets all to zero; `fill` of a slice would stay a call without vector registers.
    #[inline(always)]
    fn clear(self, to: &mut [[f64; L]]) {
        for to in to {
            *to = self.store(self.splat(0.0));
        }
    }

    /// sum + a·b, rounded twice: the same number on every machine, without a function call.
    #[inline(always)]
    fn plus(self, sum: Self::Value, a: Self::Value, b: Self::Value) -> Self::Value {
        self.add(sum, self.mul(a, b))
    }
}

/// Numbers side by side with plain arithmetic, for any machine.
#[derive(Debug, Clone, Copy)]
pub struct Plain;

// loops, not `array::from_fn`, whose closures stay calls in builds with debug assertions
impl<const L: usize> Wide<L> for Plain {
    type Value = [f64; L];
    #[inline(always)]
    fn splat(self, x: f64) -> [f64; L] {
        [x; L]
    }
    #[inline(always)]
    fn load(self, x: &[f64; L]) -> [f64; L] {
        *x
    }
    #[inline(always)]
    fn store(self, x: [f64; L]) -> [f64; L] {
        x
    }
    #[inline(always)]
    fn add(self, mut a: [f64; L], b: [f64; L]) -> [f64; L] {
        for i in 0..L {
            a[i] += b[i];
        }
        a
    }
    #[inline(always)]
    fn sub(self, mut a: [f64; L], b: [f64; L]) -> [f64; L] {
        for i in 0..L {
            a[i] -= b[i];
        }
        a
    }
    #[inline(always)]
    fn mul(self, mut a: [f64; L], b: [f64; L]) -> [f64; L] {
        for i in 0..L {
            a[i] *= b[i];
        }
        a
    }
    #[inline(always)]
    fn div(self, mut a: [f64; L], b: [f64; L]) -> [f64; L] {
        for i in 0..L {
            a[i] /= b[i];
        }
        a
    }
    #[inline(always)]
    fn abs(self, mut a: [f64; L]) -> [f64; L] {
        for i in 0..L {
            a[i] = a[i].abs();
        }
        a
    }
    #[inline(always)]
    fn sqrt(self, mut a: [f64; L]) -> [f64; L] {
        for i in 0..L {
            a[i] = a[i].sqrt();
        }
        a
    }
    #[inline(always)]
    fn only_where(self, mut a: [f64; L], b: [f64; L]) -> [f64; L] {
        for i in 0..L {
            a[i] = if b[i] == 0.0 { 0.0 } else { a[i] };
        }
        a
    }
    #[inline(always)]
    fn fused(self, mut a: [f64; L], b: [f64; L], c: [f64; L]) -> [f64; L] {
        for i in 0..L {
            a[i] = a[i].mul_add(b[i], c[i]);
        }
        a
    }
}

/// Implements `Wide` for a machine whose registers hold `$lanes / $count` numbers.
#[cfg(target_arch = "x86_64")]
macro_rules! in_registers {
    ($machine:ty, $lanes:literal, $count:literal) => {
        impl Wide<$lanes> for $machine {
            type Value = [<$machine as pulp::Simd>::f64s; $count];
            #[inline(always)]
            fn splat(self, x: f64) -> Self::Value {
                [pulp::Simd::splat_f64s(self, x); $count]
            }
            #[inline(always)]
            fn load(self, x: &[f64; $lanes]) -> Self::Value {
                pulp::cast(*x)
            }
            #[inline(always)]
            fn store(self, x: Self::Value) -> [f64; $lanes] {
                pulp::cast(x)
            }
            #[inline(always)]
            fn add(self, mut a: Self::Value, b: Self::Value) -> Self::Value {
                for k in 0..$count {
                    a[k] = pulp::Simd::add_f64s(self, a[k], b[k]);
                }
                a
            }
            #[inline(always)]
            fn sub(self, mut a: Self::Value, b: Self::Value) -> Self::Value {
                for k in 0..$count {
                    a[k] = pulp::Simd::sub_f64s(self, a[k], b[k]);
                }
                a
            }
            #[inline(always)]
            fn mul(self, mut a: Self::Value, b: Self::Value) -> Self::Value {
                for k in 0..$count {
                    a[k] = pulp::Simd::mul_f64s(self, a[k], b[k]);
                }
                a
            }
            #[inline(always)]
            fn div(self, mut a: Self::Value, b: Self::Value) -> Self::Value {
                for k in 0..$count {
                    a[k] = pulp::Simd::div_f64s(self, a[k], b[k]);
                }
                a
            }
            #[inline(always)]
            fn abs(self, mut a: Self::Value) -> Self::Value {
                for k in 0..$count {
                    a[k] = pulp::Simd::abs_f64s(self, a[k]);
                }
                a
            }
            #[inline(always)]
            fn sqrt(self, mut a: Self::Value) -> Self::Value {
                for k in 0..$count {
                    a[k] = pulp::Simd::sqrt_f64s(self, a[k]);
                }
                a
            }
            #[inline(always)]
            fn only_where(self, mut a: Self::Value, b: Self::Value) -> Self::Value {
                let zero = pulp::Simd::splat_f64s(self, 0.0);
                for k in 0..$count {
                    let none = pulp::Simd::equal_f64s(self, b[k], zero);
                    a[k] = pulp::Simd::select_f64s(self, none, zero, a[k]);
                }
                a
            }
            #[inline(always)]
            fn fused(self, mut a: Self::Value, b: Self::Value, c: Self::Value) -> Self::Value {
                for k in 0..$count {
                    a[k] = pulp::Simd::mul_add_f64s(self, a[k], b[k], c[k]);
                }
                a
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
in_registers!(pulp::x86::V3, 4, 1);
#[cfg(target_arch = "x86_64")]
in_registers!(pulp::x86::V3, 8, 2);
#[cfg(target_arch = "x86_64")]
in_registers!(pulp::x86::V3, 16, 4);
#[cfg(target_arch = "x86_64")]
in_registers!(pulp::x86::V4, 8, 1);
#[cfg(target_arch = "x86_64")]
in_registers!(pulp::x86::V4, 16, 2);

/// Work on `L` lanes. The functions that it calls must be `#[inline(always)]`; others use the plain
/// instructions.
pub trait Work<const L: usize> {
    /// Result of the work.
    type Output;
    /// Does the work with these registers.
    fn with<W: Wide<L>>(self, wide: W) -> Self::Output;
}

/// Numbers of lanes for which a machine has registers.
pub trait Widths<const L: usize> {
    /// Does `work` with the widest registers of this machine, found at run time.
    fn widest<T: Work<L>>(work: T) -> T::Output;
}

/// The machine on which the program runs.
#[derive(Debug, Clone, Copy)]
pub struct Machine;

macro_rules! widths {
    (plain $($lanes:literal)*) => {$(
        impl Widths<$lanes> for Machine {
            #[inline(always)]
            fn widest<T: Work<$lanes>>(work: T) -> T::Output {
                work.with(Plain)
            }
        }
    )*};
    (wide $($lanes:literal)*) => {$(
        impl Widths<$lanes> for Machine {
            // builds with debug assertions compile only the plain version, which builds three times
            // as fast
            fn widest<T: Work<$lanes>>(work: T) -> T::Output {
                #[cfg(all(target_arch = "x86_64", not(debug_assertions)))]
                {
                    if let Some(machine) = pulp::x86::V4::try_new() {
                        return machine.vectorize(#[inline(always)] || work.with(machine));
                    }
                    if let Some(machine) = pulp::x86::V3::try_new() {
                        return machine.vectorize(#[inline(always)] || work.with(machine));
                    }
                }
                work.with(Plain)
            }
        }
    )*};
}
widths!(plain 1 2 4);
widths!(wide 8 16);

#[cfg(test)]
mod tests {
    use super::*;

    /// All operations of a machine on eight numbers.
    struct All([f64; 8], [f64; 8], [f64; 8]);

    impl Work<8> for All {
        type Output = Vec<u64>;
        fn with<W: Wide<8>>(self, wide: W) -> Vec<u64> {
            let [a, b, c] = [&self.0, &self.1, &self.2].map(|x| wide.load(x));
            let all = [
                wide.add(a, b),
                wide.sub(a, b),
                wide.mul(a, b),
                wide.div(a, b),
                wide.abs(a),
                wide.sqrt(wide.abs(b)),
                wide.only_where(c, b),
                wide.fused(a, b, b),
                wide.plus(a, b, b),
                wide.splat(0.1),
            ];
            all.iter().flat_map(|x| wide.store(*x)).map(f64::to_bits).collect()
        }
    }

    /// The results agree bit by bit on the machine of the test.
    #[test]
    fn law_registers_do_as_plain_arithmetic_does() {
        let a = [1.0, -0.1, 3.3, 1e200, -7.7, 0.3, -0.0, 5e-324];
        let b = [0.3, 0.0, -2.2, 1e-200, 7.7, 1.0 / 3.0, 4.0, 9.0];
        let c = [f64::INFINITY, f64::NAN, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let plain = All(a, b, c).with(Plain);
        assert_eq!(plain[6 * 8 + 1], 0, "0 where the weight is 0, whatever the value");
        assert_eq!(<Machine as Widths<8>>::widest(All(a, b, c)), plain);
        #[cfg(target_arch = "x86_64")]
        {
            if let Some(machine) = pulp::x86::V3::try_new() {
                assert_eq!(All(a, b, c).with(machine), plain);
            }
            if let Some(machine) = pulp::x86::V4::try_new() {
                assert_eq!(All(a, b, c).with(machine), plain);
            }
        }
    }
}
