//! Calls of the library: without the interpreter's lock, with panics caught, progress reported, and
//! Ctrl-C respected.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use hydrosysid::progress::{Step, Watch, watched};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// Interval at which Python's signals are checked.
const LOOK: Duration = Duration::from_millis(50);

/// A caught panic as an ordinary exception.
fn defect(panic: &(dyn std::any::Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
    PyRuntimeError::new_err(format!("internal error of hydrosysid, please report it: {}", text.unwrap_or("panic")))
}

/// Runs `work` that needs the interpreter.
///
/// # Errors
/// `RuntimeError` for a panic, which is a defect of the library; the exceptions of `work`.
pub fn attended<T>(work: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(defect(&*panic)))
}

/// Panics like an internal error of the library, within one of the three functions of this file; for tests. No
/// published wheel has it.
#[cfg(feature = "panics")]
#[pyfunction]
pub fn fail(py: Python<'_>, door: &str) -> PyResult<()> {
    match door {
        "attended" => attended(|| {
            asked_for();
            Ok(())
        }),
        "detached" => detached(py, asked_for),
        _ => interruptible(py, None, asked_for),
    }
}

#[cfg(feature = "panics")]
fn asked_for() {
    panic!("asked for")
}

/// Runs short `work` while other Python threads go on.
///
/// # Errors
/// `RuntimeError` for a panic, which is a defect of the library; `KeyboardInterrupt` if the user
/// pressed Ctrl-C.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    // unwind-safe: nothing that the work has changed is used again after a panic
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    py.check_signals()?;
    done.map_err(|panic| defect(&*panic))
}

/// Message of the working thread to the waiting one.
enum Event {
    Step(Step),
    Done,
}

/// Runs long `work` on a separate thread while other Python threads go on; calls
/// `progress(what, done, of)` for every step. Ctrl-C, which is noticed within 50 ms, and an
/// exception of `progress` stop the work.
///
/// # Errors
/// As [`detached`], and the exceptions of `progress`.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    py.detach(|| {
        let (say, hear) = channel();
        let steps = say.clone();
        // sending fails if the waiting thread has stopped listening, which is no error
        let watch = Watch::new(move |step| drop(steps.send(Event::Step(step))));
        let told = |step: &Step| match &progress {
            Some(call) => Python::attach(|py| call.call1(py, (&step.what, step.done, step.of)).map(drop)),
            None => Ok(()),
        };
        thread::scope(|scope| {
            let worker = scope.spawn(|| {
                let done = catch_unwind(AssertUnwindSafe(|| watched(&watch, work)));
                drop(say.send(Event::Done));
                done
            });
            let mut failed = None;
            loop {
                let told = match hear.recv_timeout(LOOK) {
                    Ok(Event::Step(step)) => told(&step),
                    Ok(Event::Done) | Err(RecvTimeoutError::Disconnected) => break,
                    Err(RecvTimeoutError::Timeout) => Ok(()),
                };
                if let Err(error) = told.and_then(|()| Python::attach(|py| py.check_signals())) {
                    watch.stop();
                    failed = Some(error);
                    break;
                }
            }
            let done = worker.join().and_then(|done| done);
            match (failed, done) {
                (Some(error), _) => Err(error),
                (None, Ok(Ok(result))) => Ok(result),
                (None, Ok(Err(stopped))) => Err(PyRuntimeError::new_err(stopped.to_string())),
                (None, Err(panic)) => Err(defect(&*panic)),
            }
        })
    })
}
