//! What every fuzz target shares: no more than 64 MiB may be allocated beyond what stands when an input arrives.

#![forbid(unsafe_code)]

use std::alloc::System;

use cap::Cap;

#[global_allocator]
static ALLOCATED: Cap<System> = Cap::new(System, usize::MAX);

/// Memory that an input of any content may take beyond itself, bytes.
const BEYOND: usize = 64 << 20;

/// Runs `work` under the limit; going beyond it fails an allocation, which ends the process as a crash does.
pub fn within_memory<T>(work: impl FnOnce() -> T) -> T {
    // no limit is narrower than what the last input has left to be freed
    let _ = ALLOCATED.set_limit(ALLOCATED.allocated().saturating_add(BEYOND));
    let done = work();
    let _ = ALLOCATED.set_limit(usize::MAX);
    done
}
