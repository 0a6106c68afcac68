//! Logs that a campaign lists twice.
//!
//! A row is the same if its time stamp and everything that was sampled with it are equal bit for
//! bit. A log that takes part in the fit twice makes standard deviations too small by a factor of
//! √2, and one that also validates shows nothing about held-out runs.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use super::codes;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::run::{Role, Run};

/// Number of rows that are compared in a run; of a longer run, rows are selected by the hash of
/// their stamp.
const ROWS: usize = 50_000;

/// Share of the rows of the shorter run from which two runs are one log, and least number of shared
/// rows.
const SHARE: f64 = 0.2;
const LEAST: usize = 20;

/// Returns one finding for every two runs that share rows.
pub(super) fn findings(runs: &[Run]) -> Vec<Finding> {
    let mut seen: HashMap<u64, usize> = HashMap::new();
    let mut counts = vec![0; runs.len()];
    let mut shared: HashMap<(usize, usize), usize> = HashMap::new();
    for (k, run) in runs.iter().enumerate() {
        for row in rows(run) {
            counts[k] += 1;
            match seen.get(&row) {
                Some(first) if *first != k => *shared.entry((*first, k)).or_default() += 1,
                Some(_) => {}
                None => {
                    seen.insert(row, k);
                }
            }
        }
    }
    let mut pairs: Vec<((usize, usize), usize)> = shared.into_iter().collect();
    pairs.sort_unstable();
    let same = |((a, b), count): &((usize, usize), usize)| {
        *count >= LEAST && *count as f64 >= SHARE * counts[*a].min(counts[*b]) as f64
    };
    pairs
        .into_iter()
        .filter(same)
        .map(|((a, b), count)| told(&runs[a], &runs[b], count, counts[a].min(counts[b])))
        .collect()
}

fn told(a: &Run, b: &Run, count: usize, of: usize) -> Finding {
    let percent = 100.0 * count as f64 / of as f64;
    let what = match (a.role == b.role, a.role) {
        (false, _) => "one takes part in the fit and the other judges it, which flatters the model",
        (true, Role::Train) => "it counts twice in the fit, so its standard errors come out too small",
        (true, Role::Validate) => "it counts twice in the comparison",
    };
    let text = format!(
        "`{}` and `{}` share {percent:.0} % of the rows of the shorter one: {what}; leave one of them out, or separate \
         them with `from` and `to`",
        a.name, b.name
    );
    Finding::new(&codes::SAME_LOG, text).of_run(&b.name)
}

/// Returns hashes of the rows of a run: the time stamps of its first velocity, and every channel
/// with the same stamps. Rows in which that velocity is 0 are left out, because rows at rest are
/// alike in any log.
fn rows(run: &Run) -> Vec<u64> {
    let Some(first) = Dof::ALL.iter().find_map(|dof| run.signal(dof.velocity()).filter(|s| !s.is_empty())) else {
        return Vec::new();
    };
    let together: Vec<&[f64]> =
        run.signals.values().filter(|s| s.time() == first.time()).map(crate::run::Signal::values).collect();
    let one_of = (first.len() / ROWS + 1) as u64;
    let hash = |k: usize| {
        let mut hasher = DefaultHasher::new();
        first.time()[k].to_bits().hash(&mut hasher);
        // selected by stamp alone, so that the same rows are taken from every run
        let taken = hasher.finish().is_multiple_of(one_of);
        together.iter().for_each(|x| x[k].to_bits().hash(&mut hasher));
        (taken && first.values()[k] != 0.0).then(|| hasher.finish())
    };
    (0..first.len()).filter_map(hash).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Signal;

    fn run(name: &str, role: Role, phase: f64) -> Run {
        let time: std::sync::Arc<[f64]> = (0..200).map(|k| 0.1 * f64::from(k)).collect();
        let values = |scale: f64| time.iter().map(|t| scale * (t + phase).sin()).collect::<Vec<f64>>();
        let mut run = Run { name: name.into(), role, ..Run::default() };
        run.signals.insert("u".into(), Signal::new(time.clone(), values(0.4)));
        run.signals.insert("tau_u".into(), Signal::new(time.clone(), values(90.0)));
        run
    }

    #[test]
    fn a_log_that_is_listed_twice_is_found() {
        let runs = [run("a", Role::Train, 0.0), run("b", Role::Train, 0.3), run("copy of a", Role::Validate, 0.0)];
        let found = findings(&runs);
        assert_eq!(found.len(), 1);
        assert!(found[0].message.contains("`a` and `copy of a` share 100 %") && found[0].message.contains("flatters"));
        let early = runs[0].between(0.0, 9.0);
        let late = Run { name: "late".into(), ..runs[0].between(9.05, 30.0) };
        assert!(findings(&[early.clone(), late]).is_empty(), "two parts of one log are two runs");
        let overlapping = Run { name: "half".into(), ..runs[0].between(4.5, 13.0) };
        assert_eq!(findings(&[early, overlapping]).len(), 1);
    }
}
