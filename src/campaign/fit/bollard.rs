//! Losses of thrust that bollard runs show, for the estimators of free motion, which cannot read load cells.
//!
//! ```text
//! τ = η_inter η_adv τ_nom      η_inter of stage (i), held
//! ```

use super::super::codes;
use super::super::load::Campaign;
use crate::effects::id;
use crate::finding::Finding;
use crate::log::number::short;
use crate::procedure::interaction_losses;
use crate::run::{Role, RunKind};
use crate::thrust::interaction::Interaction;

/// Returns the campaign with the losses that its bollard runs show in addition to those it states,
/// and the finding; `None` if they show none, or if the model estimates a loss itself.
pub(super) fn losses(campaign: &Campaign) -> Option<(Campaign, Finding)> {
    let bollard = campaign.runs.iter().any(|run| run.role == Role::Train && run.kind == RunKind::Bollard);
    let free = |p: &usize| campaign.model.parameters[*p].effect == id::THRUST_INTERACTION_LOSS;
    if !bollard || campaign.model.free().iter().any(free) {
        return None;
    }
    let options = &campaign.file.stage;
    // what the bollard runs lack is reported where they are left out
    let losses = interaction_losses(&campaign.nominal_runs(), &campaign.model, campaign.bench(), options).ok()?;
    let stated = &campaign.file.efficiency.eta_inter.0;
    let found: Vec<String> = losses.eta_inter.0.iter().filter(|entry| !stated.contains(entry)).map(told).collect();
    if found.is_empty() {
        return None;
    }
    let text = format!("the bollard runs give {}: held fixed, with its uncertainty propagated", found.join(", "));
    Some((campaign.under(&losses), Finding::new(&codes::LOSSES_OF_BOLLARD, text)))
}

/// Describes one loss with its deviation.
fn told(entry: &Interaction) -> String {
    let std = entry.std.map(|std| format!(" ± {}", short(std, 2))).unwrap_or_default();
    format!("η_inter = {:.3}{std} in {}", entry.value, entry.dof)
}
