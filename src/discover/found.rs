//! Effects that were found, with their parameters, and the smallest size at which others would have shown.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;

use super::candidate::Candidate;
use super::searched::Search;
use crate::effects::{Effect, Place, common_name_at, named};
use crate::frame::Dof;
use crate::model::name_of;
use crate::wording::{by_run, digits, range};

/// A parameter of an effect that was added.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoundParameter {
    /// Symbol.
    pub name: String,
    /// Value, SI; the mean if each run has its own.
    pub value: f64,
    /// Standard deviation, SI; the greatest if each run has its own value.
    pub std: f64,
    /// Unit.
    pub unit: String,
    /// Values in each run, if each has its own.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub per_run: Vec<f64>,
}

impl FoundParameter {
    /// Least and greatest value of the runs, if each has its own.
    pub fn range(&self) -> Option<(f64, f64)> {
        range(self.per_run.iter().copied())
    }

    /// `least to greatest by run`, if each run has its own value; `told` formats a value.
    pub(crate) fn by_run(&self, told: impl Fn(f64) -> String) -> Option<String> {
        by_run(self.per_run.iter().copied(), told)
    }
}

/// An effect that was added.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoundEffect {
    /// `id`, `id@dof` or `id@dof:other`.
    pub id: String,
    /// Name that practitioners use.
    pub common_name: String,
    /// Degrees of freedom in which it acts.
    pub dofs: Vec<Dof>,
    /// Its parameters in the final fit.
    pub parameters: Vec<FoundParameter>,
    /// Probability of such a gain by chance, over all candidates.
    pub p_value: f64,
    /// Other names of its class, which this data allows as well.
    pub also_possible: Vec<String>,
    /// Evidence, in one sentence.
    pub evidence: String,
}

impl FoundEffect {
    /// Common name and id: `the Munk moment (coriolis_yaw)`.
    pub fn named(&self) -> String {
        format!("{} ({})", self.common_name, self.id)
    }
}

/// The smallest size of an effect that this data would have shown.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SmallestVisible {
    /// `id`, `id@dof` or `id@dof:other`.
    pub id: String,
    /// Size of its first parameter; the share of the effect if it has none.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Whether it has no parameter, as the whole row of −C(ν)ν with the coefficients of the inertias, or two
    /// thrusters that are swapped: `value` 1 is the whole effect.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub tied: bool,
}

impl SmallestVisible {
    /// Name, size and unit in words: an effect without a parameter counts as a whole, its size in per cent.
    pub fn told(&self) -> (String, f64, &str) {
        match self.tied {
            true => (format!("{}, as a whole", named(&self.id)), 100.0 * self.value, "% of it"),
            false => (named(&self.id), self.value, &self.unit),
        }
    }
}

/// Text in place of the value of an effect that has no parameter.
pub const AS_A_WHOLE: &str = "as a whole";

pub(super) fn found_effects(found: &Search) -> Vec<FoundEffect> {
    let model = &found.last_fit().model;
    found
        .added
        .iter()
        .map(|added| {
            let terms: Vec<String> = added.candidate.terms.iter().map(|(e, p)| name_of(e.about().id, *p)).collect();
            let mut indices: Vec<usize> =
                terms.iter().filter_map(|t| model.term(t)).flat_map(|t| model.terms[t].parameters.clone()).collect();
            indices.sort_unstable();
            indices.dedup();
            let parameters: Vec<FoundParameter> = indices
                .into_iter()
                .map(|p| {
                    let parameter = &model.parameters[p];
                    FoundParameter {
                        name: parameter.spec.name.clone(),
                        value: parameter.mean(),
                        std: parameter.std.unwrap_or(0.0),
                        unit: parameter.spec.dimension.to_string(),
                        per_run: parameter.per_run.clone(),
                    }
                })
                .collect();
            let id = added.candidate.name();
            FoundEffect {
                common_name: common_name_at(&id, parameters.first().map(|p| p.value)),
                id,
                dofs: added.candidate.dofs(model),
                parameters,
                p_value: added.p_value,
                also_possible: added.also_possible.clone(),
                evidence: format!(
                    "−2 ln L falls by {} on the runs of the fit and by {} on the held-out runs; after refitting the \
                     model, {:.0} % of its signal is explained by existing parameters",
                    digits(added.gain),
                    digits(added.held_out_gain),
                    100.0 * (1.0 - added.left.min(1.0)),
                ),
            }
        })
        .collect()
}

/// Names under which a campaign lists the added effects.
pub(super) fn names_to_list(found: &Search, own: &[(Arc<dyn Effect>, Place)]) -> Vec<String> {
    found.added.iter().flat_map(|a| listed(&a.candidate, own)).collect()
}

/// Names under which a campaign lists every term of a candidate; for a user's effect (`own`), which has one place,
/// its id.
fn listed(candidate: &Candidate, own: &[(Arc<dyn Effect>, Place)]) -> Vec<String> {
    let of_user = |id: &str| own.iter().any(|(effect, _)| effect.about().id == id);
    let name = |(effect, place): &(Arc<dyn Effect>, Place)| match effect.about().id {
        id if of_user(id) => id.to_string(),
        id => name_of(id, *place),
    };
    candidate.terms.iter().map(name).collect()
}

/// For each candidate the smallest size that this data would have shown in about half of the cases: its standard
/// deviation times the threshold of the search.
pub(super) fn smallest_visible(found: &Search) -> Vec<SmallestVisible> {
    // z at which a candidate of one parameter reaches the p-value of the threshold
    let z = (-2.0 * found.screen.threshold).max(1.0).sqrt();
    let mut best: BTreeMap<(String, bool), (f64, String)> = BTreeMap::new();
    for score in &found.screen.scores {
        let candidate = &found.candidates[score.candidate];
        let (effect, place) = &candidate.terms[0];
        let specs = effect.parameters(*place);
        let tied = specs.is_empty();
        let unit = match specs.iter().find(|s| s.is_linear()).or(specs.first()) {
            Some(spec) => spec.dimension.to_string(),
            None => crate::units::Dimension::ONE.to_string(),
        };
        let Some(std) = score.std.first() else { continue };
        let probe = candidate.probes.get(score.probe).and_then(|probe| probe.first().copied());
        // τ + α (effect(τ) − τ) is, for a small α, the effect at α times the probe
        let value = probe.filter(|_| candidate.blended).map_or(z * std, |at| z * std * at);
        let key = (candidate.name(), tied);
        if value.is_finite() && best.get(&key).is_none_or(|(known, _)| value < *known) {
            best.insert(key, (value, unit));
        }
    }
    best.into_iter().map(|((id, tied), (value, unit))| SmallestVisible { id, value, unit, tied }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The net weight acts in surge and heave by one parameter: without either term the model would be a different one.
    #[test]
    fn every_term_of_a_group_is_listed() {
        let effects = ["inertia", "linear_drag"];
        let model =
            crate::model::Model::with_effects(&[Dof::Surge, Dof::Heave], crate::effects::Coriolis::Tied, &effects);
        let mut run = crate::run::Run::default();
        for channel in ["u", "w", "tau_u", "theta", "phi"] {
            run.signals.insert(channel.into(), crate::run::Signal::new(vec![0.0, 1.0].into(), vec![0.0, 1.0]));
        }
        let candidates = crate::discover::candidates(&model.unwrap(), &[run], &[]);
        let of = |name: &str| candidates.iter().find(|c| c.name() == name).map(|c| listed(c, &[]));
        assert_eq!(of("restoring_surge").unwrap(), ["restoring_surge", "restoring_heave"]);
        assert_eq!(of("bias@heave").unwrap(), ["bias@heave"]);
    }

    #[test]
    fn a_whole_row_is_told_in_per_cent_and_a_coefficient_in_its_unit() {
        let product = SmallestVisible { id: "coriolis_yaw".into(), value: 4.0, unit: "kg".into(), tied: false };
        assert_eq!(product.told(), ("the Munk moment (coriolis_yaw)".into(), 4.0, "kg"));
        let row = SmallestVisible { value: 0.02, unit: "1".into(), tied: true, ..product.clone() };
        assert_eq!(row.told(), ("the Munk moment (coriolis_yaw), as a whole".into(), 2.0, "% of it"));
        assert!(serde_json::to_value(&product).unwrap().get("tied").is_none());
        assert_eq!(serde_json::to_value(&row).unwrap()["tied"], true);
    }
}
