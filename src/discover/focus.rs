//! Where a refit begins: shapes from a grid eight times as fine about their best probe.
//!
//! ```text
//! probe ← argmin p(probe)   on the grid, then between its neighbours        under Q, and under Q with forces at a tenth
//! ```
//!
//! An instant, a time constant or a threshold that starts a mesh away from the truth may end on another hill of the
//! likelihood. A random force that has taken up what is missing blurs the hills, so they are seen under a small one, too,
//! and where that tells otherwise there are two starts.

use super::candidate::Candidate;
use super::screen::{Score, screen};
use super::task::Task;
use crate::estimate::filter_error::FilterErrorFit;

/// Share of the forces under which the hills are seen a second time, a hundredth of their power. Chosen in simulation: the
/// instant at which a thruster fails stood out under it where the whole force hid it.
const QUIET: f64 = 0.1;

/// A candidate, and the score of the probe at which it starts.
#[derive(Debug, Clone)]
pub(super) struct Start {
    pub candidate: Candidate,
    pub score: Score,
}

impl Start {
    /// Value of its one shape parameter.
    fn shape(&self) -> f64 {
        self.candidate.probes[self.score.probe][0]
    }

    /// Length between two neighbours on the grid before it was made finer: the finer one spans two.
    fn mesh(&self) -> f64 {
        let ends = self.candidate.probes.first().zip(self.candidate.probes.last());
        ends.map_or(0.0, |(first, last)| 0.5 * (last[0] - first[0]).abs())
    }

    /// The better one of itself and another start of the same candidate.
    fn or_better(self, other: Option<Start>) -> Start {
        match other {
            Some(other) if other.score.log_p < self.score.log_p => other,
            _ => self,
        }
    }
}

/// Starts of the candidates that `best` scores (indices are those of `list`), in its order; a shape may have two.
pub(super) fn starts(here: &FilterErrorFit, best: &[Score], list: &[Candidate], task: &Task<'_>) -> Vec<Start> {
    let start = |score: &Score| Start { candidate: list[score.candidate].clone(), score: score.clone() };
    let usual: Vec<Start> = best.iter().map(start).collect();
    let has_grid = |s: &Start| s.candidate.nearer(s.score.probe).is_some();
    let shaped: Vec<Start> = usual.iter().filter(|s| has_grid(s)).cloned().collect();
    let mut quiet = here.clone();
    quiet.noise.forces.iter_mut().for_each(|f| f.rms *= QUIET);
    let coarse = scored(&quiet, shaped.iter().map(|s| s.candidate.clone()).collect(), task);
    let coarse: Vec<Start> = shaped.iter().zip(coarse).map(|(s, found)| found.unwrap_or_else(|| s.clone())).collect();
    let mut fine = finer(here, &shaped, task).into_iter().zip(finer(&quiet, &coarse, task));
    let mut all = Vec::new();
    for one in usual {
        let index = one.score.candidate;
        let mut of_list = |mut start: Start| {
            start.score.candidate = index;
            all.push(start);
        };
        match has_grid(&one).then(|| fine.next()).flatten() {
            Some((loud, mut quiet)) => {
                // closer than half a mesh they lead to one hill
                let differs = (quiet.shape() - loud.shape()).abs() > 0.5 * quiet.mesh();
                // under a tenth of the forces a score says where the hill is, and not how high
                (quiet.score.statistic, quiet.score.log_p) = (loud.score.statistic, loud.score.log_p);
                of_list(loud);
                if differs {
                    of_list(quiet);
                }
            }
            None => of_list(one),
        }
    }
    all
}

/// The best probe of each candidate under a fit.
fn scored(fit: &FilterErrorFit, candidates: Vec<Candidate>, task: &Task<'_>) -> Vec<Option<Start>> {
    if candidates.is_empty() {
        return Vec::new();
    }
    let (options, base) = (task.options, &task.fitting.base);
    let scores = screen(fit, task.train, &candidates, base, (options.level, options.seed)).map(|s| s.scores);
    // of each candidate the first score is the best one
    let scores = scores.unwrap_or_default();
    let of = |(k, candidate)| Some(Start { candidate, score: scores.iter().find(|s| s.candidate == k)?.clone() });
    candidates.into_iter().enumerate().map(of).collect()
}

/// The same starts on the finer grid.
fn finer(fit: &FilterErrorFit, starts: &[Start], task: &Task<'_>) -> Vec<Start> {
    let near = |s: &Start| s.candidate.nearer(s.score.probe).unwrap_or_else(|| s.candidate.clone());
    let found = scored(fit, starts.iter().map(near).collect(), task);
    starts.iter().cloned().zip(found).map(|(start, found)| start.or_better(found)).collect()
}
