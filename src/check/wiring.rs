//! Wiring of the thrusters: whether one of them is reversed, or two are exchanged.
//!
//! ```text
//! ν(b) − ν(a) = g Σ bₖ ∫ Fₖ dt + other terms        reversed k: bₖ → −bₖ,   exchanged j, k: bⱼ ↔ bₖ
//! ```
//!
//! for each degree of freedom, over the windows of all runs of the fit together; bₖ is the force or moment of thruster k
//! per N, g one gain for all of them, the other terms are those of a [`Balance`]. Thrusters that always push together
//! in one run, as four vertical ones in heave, do so in another pattern in the next one. A wiring is told if with it the
//! thrusters explain far more of at least one degree of freedom, and less of none.

use super::balance::{Balance, Term};
use super::codes;
use super::fit::fit;
use super::report::Found;
use crate::frame::Dof;
use crate::log::number::short;
use crate::run::{Run, thruster_command};
use crate::thrust::thruster::Thruster;

/// Least share of the motion in a degree of freedom that the thrusters must explain more of if wired otherwise.
const MORE: f64 = 0.3;
/// Largest share of the motion in any degree of freedom that they may then explain less of.
const LESS: f64 = 0.1;
/// Least share of the motion that they must then explain where they explain far more.
const WELL: f64 = 0.5;
/// Difference in the sum of the shares over the degrees of freedom below which two wirings are not told apart.
const ALIKE: f64 = 0.05;

/// Number of wirings that are named where the runs do not tell them apart.
const MOST_NAMED: usize = 3;

/// Another wiring of the thrusters, by index.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wiring {
    AsGiven,
    Reversed(usize),
    Exchanged(usize, usize),
}

impl Wiring {
    /// All of `count` thrusters.
    fn all(count: usize) -> Vec<Wiring> {
        let reversed = (0..count).map(Wiring::Reversed);
        let exchanged = (0..count).flat_map(|j| (j + 1..count).map(move |k| Wiring::Exchanged(j, k)));
        reversed.chain(exchanged).collect()
    }

    /// The shares of the forces with this wiring.
    fn of(self, given: &[f64]) -> Vec<f64> {
        let mut shares = given.to_vec();
        match self {
            Wiring::AsGiven => {}
            Wiring::Reversed(k) => shares[k] = -shares[k],
            Wiring::Exchanged(j, k) => shares.swap(j, k),
        }
        shares
    }

    fn channels(self) -> Vec<String> {
        match self {
            Wiring::AsGiven => Vec::new(),
            Wiring::Reversed(k) => vec![thruster_command(k)],
            Wiring::Exchanged(j, k) => vec![thruster_command(j), thruster_command(k)],
        }
    }

    fn told(self) -> String {
        match self.channels().as_slice() {
            [one] => format!("{one} reversed"),
            [one, other] => format!("{one} and {other} exchanged"),
            _ => String::new(),
        }
    }
}

/// The windows of one degree of freedom in all runs, after a fit of the other terms to each column.
struct Rows {
    dof: Dof,
    /// Share bₖ of each thruster's force, as given.
    shares: Vec<f64>,
    /// Products of the impulses of each two thrusters, FᵀF.
    products: Vec<Vec<f64>>,
    /// Products of the impulses with the changes of velocity, Fᵀy.
    with_change: Vec<f64>,
    /// Sum of squares of the changes of velocity, yᵀy.
    change: f64,
}

impl Rows {
    /// The windows of the runs whose thrusters push `dof`; `None` without any.
    fn of(runs: &[&Run], dof: Dof, thrusters: &[Thruster]) -> Option<Rows> {
        let of_run = |run: &&Run| {
            let balance = Balance::new(run, dof)?;
            let impulses = (0..thrusters.len()).map(|k| balance.impulse(run, k)).collect::<Option<Vec<_>>>()?;
            Some((balance, impulses))
        };
        let balances: Vec<(Balance, Vec<Vec<f64>>)> = runs.iter().filter_map(of_run).collect();
        let mut terms: Vec<&Term> = Vec::new();
        for term in balances.iter().flat_map(|(balance, _)| balance.other_terms()) {
            if !terms.contains(&term) {
                terms.push(term);
            }
        }
        let (mut impulses, mut target) = (vec![Vec::new(); thrusters.len()], Vec::new());
        let mut others = vec![Vec::new(); terms.len()];
        for (balance, own) in &balances {
            impulses.iter_mut().zip(own).for_each(|(all, own): (&mut Vec<f64>, _)| all.extend(own));
            for (all, term) in others.iter_mut().zip(&terms) {
                match balance.other_terms().iter().position(|other| other == *term) {
                    Some(k) => all.extend(&balance.other_columns()[k]),
                    // what does not move in a run adds nothing there
                    None => all.extend(std::iter::repeat_n(0.0, balance.target().len())),
                }
            }
            target.extend(balance.target());
        }
        let others: Vec<&[f64]> = others.iter().map(Vec::as_slice).collect();
        let left = |column: &[f64]| -> Option<Vec<f64>> {
            let theta = fit(&others, column)?.theta;
            let said = |k: usize| others.iter().zip(&theta).map(|(other, factor)| factor * other[k]).sum::<f64>();
            Some(column.iter().enumerate().map(|(k, x)| x - said(k)).collect())
        };
        let change = left(&target)?;
        // a thruster at rest has no impulse to explain
        let at_rest = |column: &Vec<f64>| column.iter().all(|x| x.abs() <= 0.0);
        let impulses: Vec<Vec<f64>> = impulses
            .into_iter()
            .map(|column| if at_rest(&column) { Some(column) } else { left(&column) })
            .collect::<Option<_>>()?;
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        Some(Rows {
            dof,
            shares: thrusters.iter().map(|thruster| thruster.unit_wrench()[dof.index()]).collect(),
            products: impulses.iter().map(|a| impulses.iter().map(|b| product(a, b)).collect()).collect(),
            with_change: impulses.iter().map(|a| product(a, &change)).collect(),
            change: product(&change, &change),
        })
    }

    /// Share of the changes of velocity, after the other terms, that the thrusters explain with this wiring, with the
    /// opposite sign if they push the wrong way:
    ///
    /// ```text
    /// (bᵀFᵀy) |bᵀFᵀy|/(bᵀFᵀF b · yᵀy)
    /// ```
    fn explained(&self, wiring: Wiring) -> f64 {
        let shares = wiring.of(&self.shares);
        let weighted = |column: &[f64]| column.iter().zip(&shares).map(|(x, share)| x * share).sum::<f64>();
        let (along, size) =
            (weighted(&self.with_change), weighted(&self.products.iter().map(|row| weighted(row)).collect::<Vec<_>>()));
        if size > 0.0 && self.change > 0.0 { along * along.abs() / (size * self.change) } else { 0.0 }
    }
}

/// Wirings that explain the motion far better than the given one.
struct Otherwise {
    /// Those that the runs do not tell apart, the best first.
    alike: Vec<Wiring>,
    /// What the best one explains more of.
    gained: String,
}

/// Returns the wirings that explain far more of the motion in `runs`, if there are any.
fn otherwise(runs: &[&Run], dofs: &[Dof], thrusters: &[Thruster]) -> Option<Otherwise> {
    if thrusters.iter().any(|thruster| thruster.validate().is_err()) {
        return None;
    }
    let rows: Vec<Rows> = dofs.iter().filter_map(|dof| Rows::of(runs, *dof, thrusters)).collect();
    let explained = |wiring: Wiring| rows.iter().map(|rows| rows.explained(wiring)).collect::<Vec<f64>>();
    // thrusters that push the wrong way altogether are no matter of their wiring
    let given: Vec<f64> = explained(Wiring::AsGiven).into_iter().map(f64::abs).collect();
    let better = |shares: &[f64]| {
        let pairs = || shares.iter().zip(&given);
        pairs().all(|(other, given)| *other > given - LESS)
            && pairs().any(|(other, given)| *other > given + MORE && *other > WELL)
    };
    let wirings = Wiring::all(thrusters.len()).into_iter();
    let total = |shares: &[f64]| shares.iter().sum::<f64>();
    let mut fitted: Vec<(Wiring, Vec<f64>)> =
        wirings.map(|wiring| (wiring, explained(wiring))).filter(|(_, shares)| better(shares)).collect();
    fitted.sort_by(|a, b| total(&b.1).total_cmp(&total(&a.1)));
    let (_, best) = fitted.first()?;
    let alike = fitted.iter().filter(|(_, shares)| total(shares) > total(best) - ALIKE).map(|(wiring, _)| *wiring);
    let changed = rows.iter().zip(best).zip(&given).filter(|((_, best), given)| **best > **given + MORE);
    let told = changed.map(|((rows, best), given)| {
        format!("{} % of {} instead of {} %", short(100.0 * best, 2), rows.dof, short(100.0 * given, 2))
    });
    Some(Otherwise { alike: alike.collect(), gained: told.collect::<Vec<_>>().join(", ") })
}

/// Returns the finding of a thruster that is reversed, or of two that are exchanged, if the runs of the fit show it. `runs`
/// hold the forces of the thrusters and the totals of these; `dofs` are those of the model.
pub fn judge(runs: &[&Run], dofs: &[Dof], thrusters: &[Thruster]) -> Option<Found> {
    let Otherwise { alike, gained } = otherwise(runs, dofs, thrusters)?;
    let named: Vec<String> = alike.iter().take(MOST_NAMED).map(|wiring| wiring.told()).collect();
    let more = if alike.len() > MOST_NAMED { ", or other wirings," } else { "" };
    let text = format!(
        "with {}{more} the thrusters explain {gained}: correct the [[thruster]] table (turn its axis), set sign = -1 for the column, \
         or exchange the two columns",
        named.join(", or "),
    );
    let channels: Vec<String> = if let [one] = alike[..] { one.channels() } else { Vec::new() };
    Some(Found::new(&codes::COMMAND_SIGN, &channels.iter().map(String::as_str).collect::<Vec<_>>(), text))
}

/// Returns the sum over `dofs` of the shares of the motion in `runs` that the thrusters explain as they are given.
pub fn explained(runs: &[&Run], dofs: &[Dof], thrusters: &[Thruster]) -> f64 {
    let rows = dofs.iter().filter_map(|dof| Rows::of(runs, *dof, thrusters));
    rows.map(|rows| rows.explained(Wiring::AsGiven)).sum()
}

/// Returns the thruster that is reversed, by index, and what the thrusters explain with it turned, in words; `None` if the
/// runs show no wrong wiring, or allow another one.
pub fn reversed(runs: &[&Run], dofs: &[Dof], thrusters: &[Thruster]) -> Option<(usize, String)> {
    let Otherwise { alike, gained } = otherwise(runs, dofs, thrusters)?;
    match alike[..] {
        [Wiring::Reversed(thruster)] => Some((thruster, gained)),
        _ => None,
    }
}
