//! Work on lanes, compiled for the vector units that the machine turns out to have.

/// Runs `work` in the widest instruction set that this machine has (AVX-512, AVX2 with FMA, or the plain one).
///
/// `work` has to be an `#[inline(always)]` closure around `#[inline(always)]` functions: what is not inlined keeps the
/// plain instructions. The results do not depend on the choice, because products and sums are never contracted. Builds
/// with debug assertions therefore compile the plain version alone, which builds three times as fast.
#[inline(always)]
pub fn widest<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(debug_assertions)]
    {
        work()
    }
    #[cfg(not(debug_assertions))]
    {
        pulp::Arch::new().dispatch(work)
    }
}
