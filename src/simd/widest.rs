//! Work on lanes, compiled for the vector units of the machine, found at run time.

/// Runs `work` in the widest instruction set that this machine has (AVX-512, AVX2 with FMA, or the
/// plain one).
///
/// `work` must be an `#[inline(always)]` closure around `#[inline(always)]` functions: functions
/// that are not inlined use the plain instructions. The results do not depend on the choice,
/// because products and sums are never contracted. So builds with debug assertions compile only the
/// plain version, which builds three times as fast.
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
