//! Long work: without the interpreter's lock, its panics caught, Ctrl-C heeded when it is done.

use std::panic::{AssertUnwindSafe, catch_unwind};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// Runs `work` while other Python threads go on.
///
/// # Errors
/// `RuntimeError` for a panic, which is a defect of the library; `KeyboardInterrupt` where the user asked to stop.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    // nothing that the work has touched is seen again after a panic
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    py.check_signals()?;
    done.map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        PyRuntimeError::new_err(format!("defect of hydrosysid, please report it: {}", text.unwrap_or("panic")))
    })
}
