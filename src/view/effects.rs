//! Effects that the model can contain, and the switch for each.

use serde::Serialize;

use super::answer::Refusal;
use super::edit::effects as edit;
use super::workspace::Workspace;
use crate::campaign::file::{CampaignFile, EffectRole};
use crate::effects::{EffectName, EffectNameError, Place, Scope, catalogue, common_name};
use crate::model::{name_of, places_of};

/// Effects that act at one place of the chain from the command to the log.
#[derive(Serialize)]
pub(super) struct Family {
    family: String,
    effects: Vec<Listed>,
}

/// An effect with its possible places.
#[derive(Serialize)]
struct Listed {
    id: String,
    common_name: String,
    formula: String,
    meaning: String,
    places: Vec<Listing>,
}

/// An effect at a place.
#[derive(Serialize)]
struct Listing {
    /// Name in a campaign: `id`, `id@dof`.
    name: String,
    /// The place in words; empty for the whole vehicle.
    place: String,
    on: bool,
}

/// Whether the model contains an effect at a place.
fn stands(listed: &[EffectName], id: &str, place: Place) -> bool {
    listed
        .iter()
        .any(|name| name.id == id && name.thrusters.is_empty() && (name.dof.is_none() || name.place() == place))
}

fn word(place: Place) -> String {
    match (place.dof, place.other) {
        (Some(dof), Some(other)) => format!("{dof} from {other}"),
        (Some(dof), None) => dof.to_string(),
        _ => String::new(),
    }
}

/// All effects of a campaign: those of the catalogue, those of single thrusters that it lists, and
/// its own.
pub(super) fn families(file: &CampaignFile) -> Vec<Family> {
    let listed = &file.model.effects;
    let mut families: Vec<Family> = Vec::new();
    for effect in catalogue(file.model.coriolis) {
        let about = effect.about();
        let mut places: Vec<Listing> = places_of(effect.as_ref(), &file.model.dofs)
            .into_iter()
            .map(|place| Listing {
                name: name_of(about.id, place),
                place: word(place),
                on: stands(listed, about.id, place),
            })
            .collect();
        if about.scope == Scope::Thrusters {
            let of = listed.iter().filter(|name| name.id == about.id);
            places = of
                .map(|name| Listing { name: name.to_string(), place: name.thrusters.join(" and "), on: true })
                .collect();
        }
        if places.is_empty() {
            continue;
        }
        let name = about.family.name();
        let effect = Listed {
            id: about.id.to_string(),
            common_name: common_name(about.id),
            formula: about.formula.to_string(),
            meaning: about.meaning.to_string(),
            places,
        };
        match families.iter_mut().find(|family| family.family == name) {
            Some(family) => family.effects.push(effect),
            None => families.push(Family { family: name.to_string(), effects: vec![effect] }),
        }
    }
    let own = file.effects.iter().map(|table| Listed {
        id: table.id.clone(),
        common_name: table.id.replace('_', " "),
        formula: table.formula.clone(),
        meaning: format!("Your own effect, in {}.", table.dof),
        places: vec![Listing {
            name: table.id.clone(),
            place: table.dof.to_string(),
            on: table.role == EffectRole::Baseline,
        }],
    });
    let own: Vec<Listed> = own.collect();
    if !own.is_empty() {
        families.push(Family { family: "your own".into(), effects: own });
    }
    families
}

/// Switches an effect on or off in the baseline.
pub(super) fn switch(workspace: &Workspace, name: &str, on: bool) -> Result<(), Refusal> {
    let file = workspace.campaign_file()?;
    if let Some(own) = file.effects.iter().find(|table| table.id == name) {
        let role = if on { "baseline" } else { "candidate" };
        return workspace.edit(|text| edit::own(text, &own.id, role));
    }
    let wanted: EffectName = name.parse().map_err(|e: EffectNameError| Refusal::bad(e.to_string()))?;
    if on {
        if wanted.thrusters.is_empty() && stands(&file.model.effects, &wanted.id, wanted.place()) {
            return Ok(());
        }
        return workspace.edit(|text| edit::with(text, name));
    }
    let others: Vec<String> = catalogue(file.model.coriolis)
        .iter()
        .filter(|effect| effect.about().id == wanted.id)
        .flat_map(|effect| places_of(effect.as_ref(), &file.model.dofs))
        .filter(|place| *place != wanted.place())
        .map(|place| name_of(&wanted.id, place))
        .collect();
    workspace.edit(|text| edit::without(text, name, &others))
}
