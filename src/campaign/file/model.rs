//! The tables that define the model: `[model]`, `[[parameter]]`, `[[effect]]`, `[[observe]]`.

use serde::{Deserialize, Serialize};

use super::is_default;
use crate::effects::{Coriolis, EffectName};
use crate::frame::Dof;
use crate::model::Interpolation;
use crate::units::Dimension;

/// The `[model]` table: the baseline.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelTable {
    /// Degrees of freedom that are modelled.
    pub dofs: Vec<Dof>,
    /// Effects of the baseline; a plain id means every place where the effect applies.
    pub effects: Vec<EffectName>,
    /// Whether the Coriolis terms take their coefficients from the inertias. Tied by default: there
    /// are fewer parameters, and the terms then do no work.
    #[serde(default)]
    pub coriolis: Coriolis,
    /// Hold of the inputs between samples, unless a run says otherwise. Linear by default: logs
    /// mostly hold filtered or slowly changing commands, and the trapezoids of the integral
    /// regression assume the same.
    #[serde(default)]
    pub input: Interpolation,
    /// Degrees of freedom that nothing commands, such as the sway of a vessel with two thrusters:
    /// if a log has no force for them, the force is zero.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub undriven: Vec<Dof>,
}

/// A `[[parameter]]` table: start, bounds, held value or prior of one parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterTable {
    /// The effect it belongs to; a plain id means the parameter at every place of the effect.
    pub effect: EffectName,
    /// Its symbol, for an effect of several parameters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Start of the search, held value, or mean of the prior; SI.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Whether it is held at `value`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub fixed: bool,
    /// Standard deviation of a prior about `value`; SI.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std: Option<f64>,
    /// Least admissible value; SI.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// Greatest admissible value; SI.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
    /// Another effect of the model whose parameter this one equals: one unknown for both. For
    /// another place of the same effect it is the parameter of the same symbol, otherwise the first
    /// one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tie: Option<EffectName>,
}

/// Returns the first table whose tie leads, from effect to effect, back to itself.
pub(in crate::campaign) fn tie_cycle(tables: &[ParameterTable]) -> Option<usize> {
    let next = |name: &EffectName| tables.iter().position(|t| t.tie.is_some() && t.effect == *name);
    let leads_back = |start: usize| {
        let mut at = Some(start);
        // a chain without a cycle is no longer than the list
        (0..tables.len()).any(|_| {
            at = at.and_then(|at| next(tables[at].tie.as_ref()?));
            at == Some(start)
        })
    };
    (0..tables.len()).find(|start| leads_back(*start))
}

/// An `[[effect]]` table: a user's own effect, a force of `formula` times its one parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectTable {
    /// Id, different from every other.
    pub id: String,
    /// Degree of freedom in which it acts.
    pub dof: Dof,
    /// Formula over states, forces, channels of the log and `t`.
    pub formula: String,
    /// Unit of its parameter.
    pub unit: Dimension,
    /// Whether it is in the baseline from the start, or may be added by the discovery.
    #[serde(default)]
    pub role: EffectRole,
}

/// Role of a user's own effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EffectRole {
    /// In the model from the start.
    Baseline,
    /// Tried by the discovery. The default: the usual question about an own effect is whether it is
    /// there.
    #[default]
    Candidate,
}

/// An `[[observe]]` table: a logged signal that is a function of the states.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObserveTable {
    /// Name of the channel in the log.
    pub channel: String,
    /// Formula over states and channels.
    pub formula: String,
}
