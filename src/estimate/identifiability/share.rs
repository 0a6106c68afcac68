//! The share of the force in a balance that each term carries.
//!
//! ```text
//! share_k = Σ|F_k| / Σ_j Σ|F_j|
//! over the samples of all runs; j: all terms but thrust, and M ν̇ for the inertia
//! ```
//!
//! An uncertain term that carries hardly any force is not resolved, and does no harm; one that
//! carries much force does.

use std::collections::BTreeMap;

use crate::effects::id;
use crate::estimate::force_components;
use crate::model::Model;
use crate::run::Run;

/// Name of the actuators among the components.
const THRUST: &str = "thrust";

/// Share of each term, by its name: the greatest over the degrees of freedom in which it acts. A
/// balance that depends on memory or reads what is not logged is left out.
pub fn shares(model: &Model, runs: &[Run]) -> BTreeMap<String, f64> {
    let mut greatest: BTreeMap<String, f64> = BTreeMap::new();
    for dof in &model.dofs {
        let mut sums: BTreeMap<String, f64> = BTreeMap::new();
        for (index, run) in runs.iter().enumerate() {
            let Ok(parts) = force_components(*dof, run, index, model) else { continue };
            let total = |values: &[f64]| values.iter().map(|f| f.abs()).sum::<f64>();
            *sums.entry(format!("{}@{dof}", id::INERTIA)).or_default() += total(&parts.total());
            for (name, values) in parts.terms.iter().filter(|(name, _)| name != THRUST) {
                *sums.entry(name.clone()).or_default() += total(values);
            }
        }
        let all: f64 = sums.values().sum();
        for (name, sum) in sums.into_iter().filter(|_| all > 0.0) {
            let share = greatest.entry(name).or_default();
            *share = share.max(sum / all);
        }
    }
    greatest
}
