//! Progress of long work, and its stop on request of the user.
//!
//! Work reports its steps with [`tell`] and checks every few milliseconds with [`look`] whether it
//! was stopped. The caller runs it with [`watched`], in a pool of threads of its own that all know
//! the watch: so nothing has to be passed down to the loops, and two jobs side by side do not mix.
//! Unwatched work costs one read of a thread-local variable per call and is never stopped.
//!
//! After [`Watch::stop`] the next [`look`] unwinds to [`watched`], which returns [`Stopped`]. This
//! is no panic: no hook sees it, and no message is printed.

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use thiserror::Error;

/// A step that work reports when it begins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// Its description: `judging 120 candidates`.
    pub what: String,
    /// Number of parts done.
    pub done: usize,
    /// Total number of parts; 0 if unknown.
    pub of: usize,
}

/// The work was stopped before it was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("stopped")]
pub struct Stopped;

/// A watch over one job, shared by all its threads.
pub struct Watch {
    stopped: AtomicBool,
    hear: Box<dyn Fn(Step) + Send + Sync>,
}

impl Watch {
    /// A watch that passes every step to `hear`, on the thread that reports it.
    pub fn new(hear: impl Fn(Step) + Send + Sync + 'static) -> Arc<Watch> {
        Arc::new(Watch { stopped: AtomicBool::new(false), hear: Box::new(hear) })
    }

    /// Stops the work at its next [`look`].
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }
}

thread_local! {
    static WATCH: RefCell<Option<Arc<Watch>>> = const { RefCell::new(None) };
}

fn current() -> Option<Arc<Watch>> {
    WATCH.with_borrow(Clone::clone)
}

/// Reports a step with `done` of `of` parts done; `of` is 0 if the total is unknown.
pub fn tell(what: impl Into<String>, done: usize, of: usize) {
    if let Some(watch) = current() {
        look();
        (watch.hear)(Step { what: what.into(), done, of });
    }
}

/// Whether the work of this thread runs under [`watched`].
pub fn is_watched() -> bool {
    WATCH.with_borrow(Option::is_some)
}

/// Counts parts of one kind that are done on any thread, and reports each.
pub struct Count {
    what: &'static str,
    done: AtomicUsize,
    of: usize,
}

impl Count {
    /// Reports that `of` parts begin.
    pub fn begun(what: &'static str, of: usize) -> Count {
        tell(what, 0, of);
        Count { what, done: AtomicUsize::new(0), of }
    }

    /// Reports that one more part is done.
    pub fn one_done(&self) {
        tell(self.what, self.done.fetch_add(1, Ordering::Relaxed) + 1, self.of);
    }
}

/// Returns if the work is not stopped; otherwise unwinds to [`watched`].
#[inline]
pub fn look() {
    let stopped = WATCH.with_borrow(|watch| watch.as_ref().is_some_and(|w| w.stopped.load(Ordering::Relaxed)));
    if stopped {
        resume_unwind(Box::new(Stopped));
    }
}

/// Runs `work` under `watch`, with the number of threads of the current pool.
///
/// # Errors
/// [`Stopped`] if the watch was stopped before the work was done.
///
/// # Panics
/// Passes on a panic of `work`.
pub fn watched<R: Send>(watch: &Arc<Watch>, work: impl FnOnce() -> R + Send) -> Result<R, Stopped> {
    let known = watch.clone();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(rayon::current_num_threads())
        .start_handler(move |_| WATCH.set(Some(known.clone())))
        .build();
    let done = catch_unwind(AssertUnwindSafe(|| match pool {
        Ok(pool) => pool.install(work),
        // no further threads available: only this thread knows the watch
        Err(_) => {
            WATCH.set(Some(watch.clone()));
            work()
        }
    }));
    WATCH.set(None);
    done.map_err(|payload| match payload.downcast::<Stopped>() {
        Ok(stopped) => *stopped,
        Err(panic) => resume_unwind(panic),
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use rayon::prelude::*;

    use super::*;

    #[test]
    fn steps_of_all_threads_are_heard() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let into = heard.clone();
        let watch = Watch::new(move |step| into.lock().unwrap().push(step.done));
        let sum: usize = watched(&watch, || (0..50).into_par_iter().inspect(|k| tell("part", *k, 50)).sum()).unwrap();
        assert_eq!(sum, 1225);
        let mut heard = heard.lock().unwrap().clone();
        heard.sort_unstable();
        assert_eq!(heard, (0..50).collect::<Vec<_>>());
    }

    #[test]
    fn parts_are_counted_over_all_threads() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let into = heard.clone();
        let watch = Watch::new(move |step| into.lock().unwrap().push((step.what, step.done, step.of)));
        let seen = watched(&watch, || {
            let count = Count::begun("runs", 9);
            (0..9).into_par_iter().for_each(|_: i32| count.one_done());
            is_watched()
        });
        assert_eq!((seen, is_watched()), (Ok(true), false));
        let mut heard = heard.lock().unwrap().clone();
        heard.sort_unstable();
        assert_eq!(heard, (0..10).map(|k| ("runs".to_string(), k, 9)).collect::<Vec<_>>());
    }

    #[test]
    fn stopped_work_leaves_every_thread_and_the_next_is_not_stopped() {
        let watch = Watch::new(|_| {});
        let endless = || {
            watch.stop();
            (0..4).into_par_iter().for_each(|_| {
                loop {
                    look();
                }
            });
        };
        assert_eq!(watched(&watch, endless), Err(Stopped));
        assert_eq!(
            watched(&Watch::new(|_| {}), || (0..4)
                .into_par_iter()
                .map(|k| {
                    look();
                    k
                })
                .sum::<i32>()),
            Ok(6)
        );
    }

    #[test]
    fn two_pieces_of_work_do_not_hear_each_other() {
        let (one, other) = (Watch::new(|_| {}), Watch::new(|_| {}));
        one.stop();
        assert_eq!(
            watched(&other, || {
                look();
                7
            }),
            Ok(7)
        );
        assert_eq!(
            watched(&one, || {
                look();
                7
            }),
            Err(Stopped)
        );
        look();
    }

    #[test]
    #[should_panic(expected = "mine")]
    fn a_panic_passes() {
        let _ = watched(&Watch::new(|_| {}), || panic!("mine"));
    }
}
