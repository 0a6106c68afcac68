//! Properties of the vehicle that change at an instant, or in one run alone: its drag, its thrust, its mass.
//!
//! ```text
//! D → (1 + s) D      τ → (1 + s) τ      m_u, m_v, m_w → m_u + s, m_v + s, m_w + s          from t₀ on
//! ```
//!
//! Weed, a lost fairing, a weak battery or a payload changes many parameters at once, and all by one number s. A payload
//! also changes the moments of inertia and their couplings, each by a number of its own. The property that explains most
//! is reported if it explains more than any effect present throughout, and if nothing or little remains beside it
//! ([`super::begun`]): a change of one parameter leaves the others of its property behind.

use std::sync::Arc;

use super::appeared::LEFT;
use super::begun::{Beginning, Begun, What};
use super::candidate::{Candidate, candidates};
use super::columns::{InBlocks, in_blocks};
use super::constancy::{ChangedParameter, changed};
use super::parts::{BLOCK, Direction, LEVEL, Log, divided};
use super::task::{TIE, Task};
use crate::chain::{Nature, nature};
use crate::effects::{Effect, Event, Place, id};
use crate::estimate::filter_error::FilterErrorFit;
use crate::estimate::output_error::OutputErrorError;
use crate::model::{Model, Term};

/// Number of standard deviations by which a property must change.
const DEVIATIONS: f64 = 3.0;

/// Key of the parameter s.
const S: &str = "s since t₀";

/// A property of the vehicle: what changes by s, and what changes with it by numbers of its own.
struct Property {
    name: &'static str,
    /// Whether s is a share.
    relative: bool,
    tied: Vec<Changing>,
    own: Vec<Changing>,
}

/// A term of the model that changes, or a candidate that begins.
enum Changing {
    Term(usize, Event),
    Candidate(usize),
}

/// The property of the vehicle that has changed, with a gain beyond `least`.
///
/// # Errors
/// [`OutputErrorError`] when a run lacks what a candidate reads.
pub(super) fn stepped(
    fit: &FilterErrorFit,
    task: &Task<'_>,
    least: f64,
) -> Result<Option<ChangedParameter>, OutputErrorError> {
    let Some(any) = changed(fit, task.train, task.options.seed, |_| true) else { return Ok(None) };
    let model = &fit.model;
    let list = candidates(model, task.train, &[]);
    let list: Vec<Candidate> = list.into_iter().filter(|c| is_scale(c) || is_coupling(c, model)).collect();
    let properties = properties(model, &list);
    let InBlocks { probes, products } = in_blocks(fit.into(), task.train, &list, &task.fitting.base, BLOCK)?;
    let (blocks, parts) = divided(fit, task.train, &products, probes.len());
    let unknowns = &fit.filtered.problem.unknowns;
    let estimated = unknowns.len();
    let tried = (parts.len() * properties.len()) as f64;
    let Some(log) = Log::of(blocks, parts, ((0..estimated).collect(), Vec::new()), fit.priors().collect()) else {
        return Ok(None);
    };
    // the unknown of the scores, and how much it changes with s
    let along = |changing: &Changing| match changing {
        Changing::Term(k, event) => {
            let p = model.terms[*k].parameters[0];
            let weight = if *event == Event::Share { model.parameters[p].value } else { 1.0 };
            Some((unknowns.iter().position(|u| u.parameter == p)?, weight))
        }
        Changing::Candidate(k) => Some((estimated + probes.iter().position(|probe| probe.candidate == *k)?, 1.0)),
    };
    let mut fitted: Vec<(f64, &Property, Begun)> = Vec::new();
    for property in &properties {
        let own: Vec<(&Changing, Direction)> =
            property.own.iter().filter_map(|own| Some((own, vec![along(own)?]))).collect();
        let tied: Direction = property.tied.iter().filter_map(along).collect();
        let directions: Vec<Direction> = [tied].into_iter().chain(own.iter().map(|(_, along)| along.clone())).collect();
        let Some(found) = log.together(&directions) else { continue };
        if found.gain < by_chance(found.changes.len(), tried) {
            continue;
        }
        let begins = |changing: &Changing, start, tie| Beginning { what: what(changing, &list), start, tie };
        let mut beginnings = Vec::new();
        for (direction, start) in found.changes {
            match direction.checked_sub(1) {
                None => beginnings.extend(property.tied.iter().map(|tied| begins(tied, start, Some(S)))),
                Some(k) => beginnings.push(begins(own[k].0, start, None)),
            }
        }
        if let Some(begun) = Begun::at(log.parts[found.part].clone(), &beginnings, fit, task) {
            let count = begun.fit.model.parameters.len() - begun.parameter;
            fitted.push((begun.fit.cost + count as f64, property, begun));
        }
    }
    fitted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut fitted = fitted.into_iter();
    let Some((cost, property, begun)) = fitted.next() else { return Ok(None) };
    // if two properties explain it equally well, neither is the answer
    if fitted.next().is_some_and(|(second, ..)| second < cost + TIE) {
        return Ok(None);
    }
    let (begun, between) = begun.likeliest(&log.parts, task);
    let gain = fit.cost - begun.fit.cost;
    let count = begun.fit.model.parameters.len() - begun.parameter;
    // twice the limit of chance: near to it any change absorbs a little of another effect
    if gain < least.max(2.0 * by_chance(count, tried)) {
        return Ok(None);
    }
    let s = &begun.fit.model.parameters[begun.parameter];
    let (change, std) = (s.value - s.spec.neutral, s.std.unwrap_or(f64::INFINITY));
    if change.abs() < DEVIATIONS * std {
        return Ok(None);
    }
    let left = begun.left(task)?;
    if left > LEFT * gain {
        return Ok(None);
    }
    Ok(Some(ChangedParameter {
        parameter: property.name.into(),
        run: task.train[begun.part.run].name.clone(),
        from: begun.part.from,
        between,
        change,
        std,
        unit: s.spec.dimension.to_string(),
        p_value: any.p_value,
        gain,
        alone: left <= 0.0,
        absent: false,
        neutral: 0.0,
        relative: property.relative,
    }))
}

/// Fall of −2 ln L by chance with `count` parameters, in the best of `tried` parts and properties.
fn by_chance(count: usize, tried: f64) -> f64 {
    count as f64 + 2.0 * (tried / LEVEL).ln()
}

/// The drag, the thrust and the mass of `model`, as far as it has them; `list`: scales of the thrust and couplings of
/// inertia that are not in it.
fn properties(model: &Model, list: &[Candidate]) -> Vec<Property> {
    let of = |wanted: &[Nature], event: Event| -> Vec<(Place, Changing)> {
        let terms = model.terms.iter().enumerate();
        let terms = terms.filter(|(_, term)| wanted.contains(&nature(model, term)) && is_changeable(model, term));
        terms.map(|(k, term)| (term.place, Changing::Term(k, event))).collect()
    };
    let absent = |scale: bool| -> Vec<Changing> {
        (0..list.len()).filter(|k| is_scale(&list[*k]) == scale).map(Changing::Candidate).collect()
    };
    let drag = of(&[Nature::Drag, Nature::CrossDrag], Event::Share).into_iter().map(|(_, term)| term).collect();
    let is_mass = |place: &Place| place.other.is_none() && place.dof.is_some_and(|dof| !dof.is_rotation());
    let (mass, turning): (Vec<_>, Vec<_>) =
        of(&[Nature::Inertia], Event::Amount).into_iter().partition(|(place, _)| is_mass(place));
    let own = turning.into_iter().map(|(_, term)| term).chain(absent(false)).collect();
    let mass = mass.into_iter().map(|(_, term)| term).collect();
    let all = [
        Property { name: "drag", relative: true, tied: drag, own: Vec::new() },
        Property { name: "thrust", relative: true, tied: absent(true), own: Vec::new() },
        Property { name: "mass", relative: false, tied: mass, own },
    ];
    all.into_iter().filter(|property| !property.tied.is_empty()).collect()
}

/// Whether the only parameter of a term is free, linear and the same in all runs.
fn is_changeable(model: &Model, term: &Term) -> bool {
    let [p] = term.parameters[..] else { return false };
    let (spec, fixed) = (&model.parameters[p].spec, model.parameters[p].fixed);
    spec.is_linear() && !spec.per_run && spec.shared.is_none() && !fixed
}

/// What begins or changes.
fn what(changing: &Changing, list: &[Candidate]) -> What {
    match changing {
        Changing::Term(k, event) => What::Term(*k, *event),
        Changing::Candidate(k) => {
            let (effect, place): (Arc<dyn Effect>, Place) = list[*k].terms[0].clone();
            What::Effect(effect, place)
        }
    }
}

/// Whether a candidate is a scale of the thrust in one degree of freedom.
fn is_scale(candidate: &Candidate) -> bool {
    matches!(&candidate.terms[..], [(effect, _)] if effect.about().id == id::THRUST_INTERACTION_LOSS)
}

/// Whether a candidate is what a payload off the origin adds to the inertia: a coupling of a translation and a rotation
/// that are both in the model.
fn is_coupling(candidate: &Candidate, model: &Model) -> bool {
    let [(effect, Place { dof: Some(i), other: Some(j), .. })] = &candidate.terms[..] else { return false };
    let both = model.dofs.contains(i) && model.dofs.contains(j);
    effect.about().id == id::ADDED_MASS_COUPLING && both && i.is_rotation() != j.is_rotation()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::frame::Dof;
    use crate::run::{Run, Signal};

    /// Surge, sway and yaw with drag, of which one is fixed: it takes no part; the masses change by one number, the moment of
    /// inertia and its couplings by their own; forces scale the thrust.
    #[test]
    fn a_property_holds_what_changes_with_it() {
        let mut model = Model::with_effects(
            &[Dof::Surge, Dof::Sway, Dof::Yaw],
            Coriolis::Tied,
            &["inertia", "linear_drag", "quadratic_drag"],
        )
        .unwrap();
        let fixed = model.parameter("quadratic_drag@yaw", "k_r|r|").unwrap();
        model.parameters[fixed].fixed = true;
        let mut run = Run::default();
        for channel in ["u", "v", "r", "psi", "tau_u", "tau_v", "tau_r"] {
            run.signals.insert(channel.into(), Signal::new(vec![0.0, 5.0, 10.0].into(), vec![0.0, 1.0, 0.0]));
        }
        let list = candidates(&model, &[run], &[]);
        let list: Vec<Candidate> = list.into_iter().filter(|c| is_scale(c) || is_coupling(c, &model)).collect();
        let of = |changing: &Changing| match changing {
            Changing::Term(k, _) => model.terms[*k].name(),
            Changing::Candidate(k) => list[*k].name(),
        };
        let held = |property: &Property| {
            let names = |of_all: &[Changing]| of_all.iter().map(of).collect::<Vec<String>>();
            (property.name, names(&property.tied), names(&property.own))
        };
        let [drag, thrust, mass] = &properties(&model, &list)[..] else { panic!("three properties") };
        let (name, tied, own) = held(drag);
        assert!(name == "drag" && tied.len() == 5 && !tied.contains(&"quadratic_drag@yaw".into()) && own.is_empty());
        let (name, tied, own) = held(thrust);
        assert!(name == "thrust" && tied.len() == 3 && own.is_empty(), "{tied:?}");
        let (name, tied, own) = held(mass);
        assert_eq!((name, tied), ("mass", vec!["inertia@surge".to_string(), "inertia@sway".to_string()]));
        let own_of = ["inertia@yaw", "added_mass_coupling@surge:yaw", "added_mass_coupling@sway:yaw"];
        assert_eq!(own, own_of.map(String::from));
    }
}
