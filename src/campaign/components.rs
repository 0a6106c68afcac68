//! Forces over time, term by term: Fig. 11 of Avila et al. (2013).
//!
//! ```text
//! m ν̇ = Σ fⱼ        fⱼ: thrust, drag, bias, … as a force on the vehicle, N or N·m, of the logged motion
//! ```

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;

use super::codes;
use super::load::{Campaign, moves};
use crate::estimate::force_components;
use crate::finding::Finding;
use crate::frame::Dof;
use crate::model::Model;
use crate::progress::Count;
use crate::run::{Run, Signal};

/// Forces of all runs.
#[derive(Debug, Clone, Serialize)]
pub struct Components {
    /// Format of the result: 1.
    pub format: u32,
    /// One entry per run and degree of freedom.
    pub runs: Vec<RunComponents>,
    /// Findings for the user.
    pub warnings: Vec<Finding>,
}

/// Forces in one degree of freedom of one run.
#[derive(Debug, Clone, Serialize)]
pub struct RunComponents {
    /// Name of the run.
    pub run: String,
    /// Degree of freedom.
    pub dof: Dof,
    /// Time stamps, s: those of the velocity.
    pub time: Vec<f64>,
    /// Velocity, m/s or rad/s.
    pub velocity: Vec<f64>,
    /// Force of each term, in `unit`.
    pub terms: BTreeMap<String, Vec<f64>>,
    /// Sum of the terms, which accelerates the vehicle, in `unit`.
    pub total: Vec<f64>,
    /// `N` or `N*m`.
    pub unit: &'static str,
}

impl RunComponents {
    /// Returns velocity and forces as signals, by the name of the term; `total` is the sum of the
    /// forces.
    pub fn signals(&self) -> BTreeMap<String, Signal> {
        let time: Arc<[f64]> = self.time.clone().into();
        let own = (self.dof.velocity().to_string(), Signal::new(time.clone(), self.velocity.clone()));
        let terms = self.terms.iter().map(|(name, force)| (name.clone(), Signal::new(time.clone(), force.clone())));
        let total = ("total".to_string(), Signal::new(time.clone(), self.total.clone()));
        [own, total].into_iter().chain(terms).collect()
    }
}

/// Returns the forces of `model` in the runs of free motion, at the logged states. If a balance
/// depends on a quantity that no sensor logs, there is a finding instead.
pub fn components(campaign: &Campaign, model: &Model) -> Components {
    let mut result = Components { format: 1, runs: Vec::new(), warnings: Vec::new() };
    let moving: Vec<(usize, &Run)> = campaign.runs.iter().enumerate().filter(|(_, run)| moves(run.kind)).collect();
    let count = Count::begun("forces of runs", moving.len());
    for (k, run) in moving {
        for dof in &model.dofs {
            match force_components(*dof, run, k, model) {
                Ok(parts) if parts.time.is_empty() => {}
                Ok(parts) => result.runs.push(RunComponents {
                    run: run.name.clone(),
                    dof: *dof,
                    total: parts.total(),
                    time: parts.time,
                    velocity: parts.velocity,
                    terms: parts.terms.into_iter().collect(),
                    unit: if dof.is_rotation() { "N*m" } else { "N" },
                }),
                Err(error) => {
                    let text = format!("run `{}`, {dof}: {error}", run.name);
                    result.warnings.push(Finding::new(&codes::NO_COMPONENTS, text).of_run(&run.name));
                }
            }
        }
        count.one_done();
    }
    result
}
