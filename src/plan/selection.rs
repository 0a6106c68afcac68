//! Selection of runs from the candidates: greedy choice, then exchange.
//!
//! ```text
//! min over sets of runs of   Σ_k max(0, ln std_k/wanted_k)          while a wish is open
//!                            ε Σ_k min(0, ln std_k/wanted_k)        once all are fulfilled
//! ```
//!
//! The second cost, which is negative, prefers the better of two sets that fulfil every wish. Runs are added one at a
//! time, the best first; then each is exchanged for a better one, and dropped if the wishes are fulfilled without it.
//! A run may be selected twice: its noise is new. Fedorov, *Theory of Optimal Experiments* (1972), ch. 3. Nothing is
//! random: the same candidates give the same set.

use super::information::Information;

/// Weight ε of accuracy beyond the wishes.
const BEYOND: f64 = 1e-3;
/// Prior standard deviation of the parameters during the selection, in units of the wanted one: weak enough not to
/// matter at the end, it makes the first runs comparable.
const VAGUE: f64 = 1e4;
/// Maximum number of sweeps of exchange; a sweep that changes nothing is the last.
const SWEEPS: usize = 4;

/// Wanted standard deviations, in the order of the parameters of the information; `None` without a wish.
pub(super) type Wanted = [Option<f64>];

/// A set of candidates and its cost.
#[derive(Debug, Clone)]
struct Set {
    chosen: Vec<usize>,
    cost: f64,
}

/// Indices of at most `most` chosen candidates, the most valuable first; `known` is the information available without
/// any run.
pub(super) fn select(candidates: &[Information], known: &Information, wanted: &Wanted, most: usize) -> Vec<usize> {
    let vague = vague(known, wanted);
    let cost = |chosen: &[usize]| {
        let parts = chosen.iter().map(|k| &candidates[*k]).chain([known, &vague]);
        cost_of(&Information::together(parts, &known.parameters), wanted)
    };
    let mut set = Set { cost: cost(&[]), chosen: Vec::new() };
    while !fulfilled(set.cost) && set.chosen.len() < most {
        let Some(better) = best(candidates.len(), |k| [set.chosen.as_slice(), &[k]].concat(), &cost) else { break };
        if better.cost >= set.cost - 1e-9 {
            break;
        }
        set = better;
    }
    exchange(&mut set, candidates.len(), &cost);
    while fulfilled(set.cost) && !set.chosen.is_empty() {
        // one run less, and the others exchanged
        let Some(mut less) = best(set.chosen.len(), |k| without(&set.chosen, k), &cost) else { break };
        exchange(&mut less, candidates.len(), &cost);
        if !fulfilled(less.cost) {
            break;
        }
        set = less;
    }
    in_order(&set.chosen, &cost)
}

/// Whether the cost is that of a set that fulfils all wishes: only the negative part remains.
fn fulfilled(cost: f64) -> bool {
    cost <= 0.0
}

fn cost_of(information: &Information, wanted: &Wanted) -> f64 {
    let Some(std) = information.deviations() else { return f64::INFINITY };
    let ratios = std.iter().zip(wanted).filter_map(|(std, wanted)| wanted.map(|w| (std / w).ln()));
    let (mut open, mut beyond) = (0.0, 0.0);
    for ratio in ratios {
        open += ratio.max(0.0);
        beyond += ratio.min(0.0);
    }
    if open > 0.0 { open } else { BEYOND * beyond }
}

/// Weak prior information: for each parameter far less accurate than wanted.
fn vague(known: &Information, wanted: &Wanted) -> Information {
    let fallback = wanted.iter().flatten().fold(1.0, |m: f64, w| m.max(*w));
    let std: Vec<f64> = wanted.iter().map(|w| VAGUE * w.unwrap_or(fallback)).collect();
    Information::of_deviations(known.parameters.clone(), &std)
}

/// The cheapest of `count` sets; the first of equal ones.
fn best(
    count: usize,
    set: impl Fn(usize) -> Vec<usize> + Sync,
    cost: &(impl Fn(&[usize]) -> f64 + Sync),
) -> Option<Set> {
    use rayon::prelude::*;
    let costs: Vec<f64> = (0..count).into_par_iter().map(|k| cost(&set(k))).collect();
    let k = (0..count).min_by(|a, b| costs[*a].total_cmp(&costs[*b]))?;
    Some(Set { chosen: set(k), cost: costs[k] })
}

fn without(chosen: &[usize], k: usize) -> Vec<usize> {
    chosen.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, c)| *c).collect()
}

/// Exchanges runs one at a time while that helps.
fn exchange(set: &mut Set, candidates: usize, cost: &(impl Fn(&[usize]) -> f64 + Sync)) {
    for _ in 0..SWEEPS {
        let before = set.cost;
        for place in 0..set.chosen.len() {
            let exchanged = |k: usize| {
                let mut chosen = set.chosen.clone();
                chosen[place] = k;
                chosen
            };
            if let Some(better) = best(candidates, exchanged, cost).filter(|b| b.cost < set.cost - 1e-9) {
                *set = better;
            }
        }
        if set.cost >= before - 1e-6 {
            break;
        }
    }
}

/// The same runs, the most valuable first.
fn in_order(chosen: &[usize], cost: &(impl Fn(&[usize]) -> f64 + Sync)) -> Vec<usize> {
    let mut left = chosen.to_vec();
    let mut order: Vec<usize> = Vec::new();
    while !left.is_empty() {
        let Some(next) = best(left.len(), |k| [order.as_slice(), &[left[k]]].concat(), cost) else { break };
        let run = next.chosen[order.len()];
        left.remove(left.iter().position(|k| *k == run).unwrap_or(0));
        order.push(run);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each run identifies one parameter with deviation 1: for half of it four runs are needed, for 1 of the other
    /// one run.
    #[test]
    fn exact_number_of_runs_for_independent_parameters() {
        let of = |a: f64, b: f64| Information::of_deviations(vec![0, 1], &[a, b]);
        let candidates = [of(1.0, 1e9), of(1e9, 1.0), of(5.0, 5.0)];
        let none = Information::none(vec![0, 1]);
        // (0.51)² is just above 1/4
        let chosen = select(&candidates, &none, &[Some(0.51), Some(1.01)], 12);
        assert_eq!(chosen.iter().filter(|k| **k == 0).count(), 4, "{chosen:?}");
        assert_eq!(chosen.iter().filter(|k| **k == 1).count(), 1, "{chosen:?}");
        assert_eq!(chosen.len(), 5);
        assert_eq!(chosen, select(&candidates, &none, &[Some(0.51), Some(1.01)], 12), "nothing is random");
        let known = of(0.4, 0.9);
        assert!(select(&candidates, &known, &[Some(0.51), Some(1.01)], 12).is_empty(), "everything is known");
        assert_eq!(select(&candidates, &none, &[Some(0.51), None], 2), [0, 0], "as many as there may be");
    }
}
