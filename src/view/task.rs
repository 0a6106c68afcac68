//! Long work on a thread of its own, with its progress: one job at a time; a newer job replaces the
//! running one.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use serde::Serialize;

use super::answer::Refusal;
use crate::progress::{Step, Watch, watched};

/// One kind of work with its last result.
pub(super) struct Task<T> {
    state: Arc<Mutex<State<T>>>,
}

struct State<T> {
    /// Number of the last started job.
    number: u64,
    running: Option<Running>,
    result: Option<Arc<T>>,
    /// Number of results so far.
    results: u64,
    refusal: Option<Refusal>,
}

struct Running {
    watch: Arc<Watch>,
    step: Arc<Mutex<Step>>,
    begun: Instant,
}

/// Progress of the work, serialised for the page.
#[derive(Debug, Serialize)]
pub(super) struct Progress {
    /// Number of the last started job; 0 if there was none.
    pub number: u64,
    /// Whether it is running.
    pub running: bool,
    /// Current step.
    pub step: String,
    /// Parts done.
    pub done: usize,
    /// Total number of parts; 0 if unknown.
    pub of: usize,
    /// Time since its start, s.
    pub seconds: f64,
    /// Whether there is a result.
    pub has_result: bool,
    /// Number of results so far: a different number means a new result.
    pub results: u64,
    /// Why there is no result.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refusal: Option<Refusal>,
}

/// Publishes a result before the work is done.
pub(super) struct Early<'a, T> {
    state: &'a Mutex<State<T>>,
    number: u64,
}

impl<T> Early<'_, T> {
    /// Shows `result` until a better one is ready.
    pub fn show(&self, result: T) {
        let mut state = lock(self.state);
        if state.number == self.number {
            state.keep(result);
        }
    }
}

impl<T> State<T> {
    fn keep(&mut self, result: T) {
        (self.result, self.refusal) = (Some(Arc::new(result)), None);
        self.results += 1;
    }
}

/// Locks a mutex even if a thread panicked while holding it: the guarded data is consistent at any
/// time.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<T: Send + Sync + 'static> Task<T> {
    pub fn new() -> Task<T> {
        let state = State { number: 0, running: None, result: None, results: 0, refusal: None };
        Task { state: Arc::new(Mutex::new(state)) }
    }

    /// Starts `work` and stops the running job. Returns its number.
    pub fn begin(&self, work: impl FnOnce(&Early<'_, T>) -> Result<T, Refusal> + Send + 'static) -> u64 {
        let step = Arc::new(Mutex::new(Step { what: "beginning".into(), done: 0, of: 0 }));
        let heard = step.clone();
        let watch = Watch::new(move |step| *lock(&heard) = step);
        let mut state = lock(&self.state);
        if let Some(before) = state.running.take() {
            before.watch.stop();
        }
        state.number += 1;
        let number = state.number;
        state.running = Some(Running { watch: watch.clone(), step, begun: Instant::now() });
        drop(state);
        let shared = self.state.clone();
        std::thread::spawn(move || {
            let early = Early { state: &shared, number };
            let done = catch_unwind(AssertUnwindSafe(|| watched(&watch, || work(&early))));
            let mut state = lock(&shared);
            if state.number != number {
                return;
            }
            state.running = None;
            match done {
                Ok(Ok(Ok(result))) => state.keep(result),
                Ok(Ok(Err(refusal))) => (state.result, state.refusal) = (None, Some(refusal)),
                // stopped on demand: the earlier result stays
                Ok(Err(_)) => {}
                Err(_) => state.refusal = Some(Refusal::failed("internal error: this task ended in a panic")),
            }
        });
        number
    }

    /// Stops the running job.
    pub fn stop(&self) {
        let mut state = lock(&self.state);
        if let Some(running) = state.running.take() {
            running.watch.stop();
            // results that it still delivers are ignored
            state.number += 1;
        }
    }

    /// The last result.
    pub fn result(&self) -> Option<Arc<T>> {
        lock(&self.state).result.clone()
    }

    pub fn progress(&self) -> Progress {
        let state = lock(&self.state);
        let step = state.running.as_ref().map(|running| lock(&running.step).clone());
        let step = step.unwrap_or(Step { what: String::new(), done: 0, of: 0 });
        Progress {
            number: state.number,
            running: state.running.is_some(),
            step: step.what,
            done: step.done,
            of: step.of,
            seconds: state.running.as_ref().map_or(0.0, |running| running.begun.elapsed().as_secs_f64()),
            has_result: state.result.is_some(),
            results: state.results,
            refusal: state.refusal.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::progress;

    fn wait(task: &Task<i32>) -> Progress {
        while task.progress().running {
            std::thread::sleep(Duration::from_millis(2));
        }
        task.progress()
    }

    #[test]
    fn newer_work_takes_the_place_of_older_and_a_panic_is_a_refusal() {
        let task = Task::new();
        task.begin(|_| {
            progress::tell("endless", 1, 2);
            loop {
                progress::look();
            }
        });
        while task.progress().step != "endless" {
            std::thread::sleep(Duration::from_millis(2));
        }
        assert_eq!((task.progress().done, task.progress().of), (1, 2));
        task.begin(|early| {
            early.show(6);
            Ok(7)
        });
        assert!(wait(&task).refusal.is_none());
        assert_eq!(task.result().as_deref(), Some(&7));
        task.begin(|_| Err(Refusal::bad("no")));
        assert_eq!(wait(&task).refusal.map(|r| r.message).as_deref(), Some("no"));
        assert!(task.result().is_none());
        task.begin(|_| panic!("a fault"));
        assert_eq!(wait(&task).refusal.map(|r| r.status), Some(500));
    }

    #[test]
    fn stopped_work_keeps_what_was_known() {
        let task = Task::new();
        task.begin(|early| {
            early.show(1);
            loop {
                progress::look();
            }
        });
        while task.result().is_none() {
            std::thread::sleep(Duration::from_millis(2));
        }
        task.stop();
        assert!(!task.progress().running);
        assert_eq!(task.result().as_deref(), Some(&1));
    }
}
