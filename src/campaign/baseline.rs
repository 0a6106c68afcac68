//! Construction of the baseline model and of the user's own candidates from the tables of a
//! campaign file.

use std::sync::Arc;

use super::error::Error;
use super::file::{CampaignErrors, CampaignFile, EffectRole, EffectTable, ObserveTable, ParameterTable, Problem};
use super::single_thrusters;
use super::single_thrusters::Own;
use crate::chain::{acts_in, memory_count};
use crate::effects::{
    Effect, EffectName, FormulaEffect, Observer, ParameterKind, Place,
    id::{self, FinIds},
};
use crate::formula::{Formula, FormulaError};
use crate::frame::Dof;
use crate::model::{Model, Parameter, Term, name_of};
use crate::simulate::QUICKEST;
use crate::symbolic::Graph;
use crate::units::Dimension;

/// Returns the baseline with the known values of its parameters, and the user's own candidates.
///
/// W − B starts from the weight and buoyancy of the vehicle. It is estimated unless a
/// `[[parameter]]` table fixes it, because it is the small difference of two large numbers.
///
/// # Errors
/// [`Error::File`] with the place in the campaign file.
pub(super) fn build(file: &CampaignFile) -> Result<(Model, Vec<Own>), Error> {
    let mut model = Model::new(&file.model.dofs, file.model.coriolis);
    model.input = file.model.input;
    model.weight = file.vehicle.weight.unwrap_or(0.0);
    model.length = file.vehicle.characteristic_length().unwrap_or(model.length);
    let mut candidates = Vec::new();
    let tables = file.effects.iter().enumerate();
    let own = tables.map(|(i, table)| {
        let (effect, _) = own(table).map_err(|e| wrong(file, &format!("effect[{i}].formula"), &e))?;
        Ok((table, effect))
    });
    let own = own.collect::<Result<Vec<_>, Error>>()?;
    let single = single_thrusters::effects(file);
    for (i, name) in file.model.effects.iter().enumerate() {
        let at = format!("model.effects[{i}]");
        let of_table = own.iter().find(|(table, _)| table.id == name.id);
        let of_thruster = single.iter().find(|(effect, _)| is_called(effect.as_ref(), name));
        let added = match (of_table, of_thruster) {
            (Some((table, effect)), _) => model.add(effect.clone(), Place::at(table.dof)).map(|_| ()),
            (None, Some((effect, place))) if acts_in(effect.as_ref(), *place, &model).is_empty() => {
                return Err(wrong(file, &at, &single_thrusters::IDLE));
            }
            (None, Some((effect, place))) => model.add(effect.clone(), *place).map(|_| ()),
            (None, None) if !name.thrusters.is_empty() => return Err(wrong(file, &at, &single_thrusters::UNLIKE)),
            (None, None) => model.add_named(&name.to_string()).map(|_| ()),
        };
        added.map_err(|e| wrong(file, &at, &e))?;
    }
    for (i, (table, effect)) in own.into_iter().enumerate() {
        let place = Place::at(table.dof);
        let there = model.term(&name_of(&table.id, place)).is_some();
        match table.role {
            EffectRole::Baseline if !there => {
                model.add(effect, place).map_err(|e| wrong(file, &format!("effect[{i}].id"), &e))?;
            }
            EffectRole::Candidate if !there => candidates.push((effect, place)),
            _ => {}
        }
    }
    let moves = |(effect, place): &Own| !acts_in(effect.as_ref(), *place, &model).is_empty();
    let absent = |(effect, place): &Own| model.term(&name_of(effect.about().id, *place)).is_none();
    candidates.extend(single.into_iter().filter(|own| moves(own) && absent(own)));
    model.check().map_err(|e| wrong(file, "model.effects", &e))?;
    known(file, &mut model)?;
    model.observers = observers(file, &model)?;
    Ok((model, candidates))
}

/// Returns the observed functions of the states. A channel must not be predicted twice, nor from
/// itself.
fn observers(file: &CampaignFile, model: &Model) -> Result<Vec<Observer>, Error> {
    let table = |(i, table): (usize, &ObserveTable)| {
        let formula = Formula::parse(&table.formula).map_err(|e| wrong(file, &format!("observe[{i}].formula"), &e))?;
        let predicted = |dof: &Dof| [Some(dof.velocity()), dof.is_rotation().then(|| dof.position())];
        let channel = table.channel.as_str();
        if model.dofs.iter().flat_map(predicted).flatten().any(|known| known == channel) {
            let text = format!("the model predicts `{channel}` itself; name another channel of the log");
            return Err(wrong(file, &format!("observe[{i}].channel"), &text));
        }
        if formula.names().contains(channel) {
            let text =
                format!("`{channel}` would be predicted from itself; write the formula in other states and channels");
            return Err(wrong(file, &format!("observe[{i}].formula"), &text));
        }
        Ok(Observer::new(channel, formula))
    };
    file.observed.iter().enumerate().map(table).collect()
}

/// Returns the velocities that need no column of their own, because an observed function of the
/// states contains them.
pub(super) fn told_by_functions(file: &CampaignFile) -> Vec<Dof> {
    let formulas: Vec<Formula> = file.observed.iter().filter_map(|o| Formula::parse(&o.formula).ok()).collect();
    let told = |dof: &Dof| formulas.iter().any(|f| f.names().contains(dof.velocity()));
    file.model.dofs.iter().copied().filter(told).collect()
}

/// Returns the degrees of freedom that need no nominal force, because a baseline effect of the user
/// or a fin of the model drives them.
pub(super) fn driven_beside_thrust(file: &CampaignFile) -> Vec<Dof> {
    driven_by_fins(file).into_iter().chain(driven_by_formulas(file)).collect()
}

/// Those among them that a fin of the model drives, by the moment or the lateral force of its lift.
pub(super) fn driven_by_fins(file: &CampaignFile) -> Vec<Dof> {
    let stands = |fin: &FinIds| file.model.effects.iter().any(|name| name.id == fin.lift);
    id::fins().into_iter().filter(stands).flat_map(|fin| [fin.turns, fin.across]).collect()
}

/// Those among them that a baseline effect of the user drives.
pub(super) fn driven_by_formulas(file: &CampaignFile) -> Vec<Dof> {
    let stands =
        |e: &&EffectTable| e.role == EffectRole::Baseline || file.model.effects.iter().any(|name| name.id == e.id);
    file.effects.iter().filter(stands).map(|e| e.dof).collect()
}

/// Returns the effect of an `[[effect]]` table with its place.
///
/// # Errors
/// [`FormulaError`] where the formula cannot be read.
pub(super) fn own(table: &EffectTable) -> Result<Own, FormulaError> {
    let formula = Formula::parse(&table.formula)?;
    Ok((Arc::new(FormulaEffect::new(&table.id, table.dof, formula, table.unit)), Place::at(table.dof)))
}

/// Radius of gyration of a hull in pitch and yaw, added inertia included, divided by its length:
/// 0.32 for the Mariner ship, 0.39 for a REMUS 100.
const GYRATION: f64 = 0.33;

/// Writes what the vehicle and the `[[parameter]]` tables state about the parameters into the
/// model.
fn known(file: &CampaignFile, model: &mut Model) -> Result<(), Error> {
    if let Some(net) = file.vehicle.net_weight() {
        for p in model.parameters.iter_mut().filter(|p| p.spec.shared == Some("net_weight")) {
            p.value = net;
        }
    }
    // the dry mass is a better start value than none if the log gives no acceleration
    let translation = |p: &&mut Parameter| p.place.dof.is_some_and(|dof| !dof.is_rotation());
    for p in model.parameters.iter_mut().filter(|p| p.effect == id::INERTIA).filter(translation) {
        p.value = file.vehicle.mass.unwrap_or(p.value);
    }
    // likewise the moment of inertia of a hull of this length, added inertia included; only a
    // stated length counts, because the cube root of the volume is no length
    let turns = |p: &&mut Parameter| p.place.dof.is_some_and(|dof| matches!(dof, Dof::Pitch | Dof::Yaw));
    for p in model.parameters.iter_mut().filter(|p| p.effect == id::INERTIA).filter(turns) {
        let Some((mass, length)) = file.vehicle.mass.zip(file.vehicle.length) else { continue };
        p.value = mass * (GYRATION * length).powi(2);
    }
    for (i, table) in file.parameters.iter().enumerate().filter(|(_, table)| table.tie.is_none()) {
        let mut found = false;
        for k in 0..model.parameters.len() {
            let reads = |term: &Term| meant(table, term) && term.parameters.contains(&k);
            let read = model.terms.iter().any(reads);
            let parameter = &mut model.parameters[k];
            if !read || table.name.as_ref().is_some_and(|name| *name != parameter.spec.name) {
                continue;
            }
            found = true;
            parameter.fixed = table.fixed;
            let remembers = model.terms.iter().any(|term| reads(term) && remembers(model, term));
            let parameter = &mut model.parameters[k];
            if let Some(min) =
                table.min.filter(|min| remembers && parameter.spec.dimension == Dimension::TIME && *min < QUICKEST)
            {
                let text = format!("{min} s: the integrator cannot resolve a memory shorter than {QUICKEST} s");
                return Err(wrong(file, &format!("parameter[{i}].min"), &text));
            }
            parameter.min = table.min.unwrap_or(parameter.min);
            parameter.max = table.max.unwrap_or(parameter.max);
            if let Some(value) = table.value {
                parameter.value = value;
                parameter.given = true;
                parameter.prior = table.std.map(|std| (value, std));
                if !(parameter.min..=parameter.max).contains(&value) {
                    let what = outside(parameter, value);
                    return Err(wrong(file, &format!("parameter[{i}].value"), &what));
                }
            }
            parameter.value = parameter.value.clamp(parameter.min, parameter.max);
        }
        if !found {
            return Err(not_there(file, i));
        }
    }
    ties(file, model)
}

/// Returns why a value outside the bounds of its parameter is refused, and what to do.
fn outside(parameter: &Parameter, value: f64) -> String {
    let (symbol, term, unit) = (&parameter.spec.name, &parameter.term, parameter.spec.dimension);
    let what = format!(
        "{symbol} of `{term}` = {value} {unit} lies outside its bounds, {} to {}",
        parameter.min, parameter.max
    );
    let quick = parameter.spec.dimension == Dimension::TIME && value < QUICKEST;
    match (&parameter.spec.kind, quick) {
        (ParameterKind::Shape { .. }, true) => {
            format!("{what}: so short a memory acts at once, and the integrator cannot resolve it; leave `{term}` out")
        }
        (ParameterKind::Linear, _) if parameter.min >= 0.0 => {
            format!("{what}: inertia must be above 0 and dissipation must not be negative; write `min` to allow it")
        }
        _ => format!("{what}; write `min` or `max` to allow it"),
    }
}

/// Merges parameters that a `tie` connects: each parameter of a term with its counterpart if both
/// terms are of one effect, otherwise with the first parameter of the other term.
fn ties(file: &CampaignFile, model: &mut Model) -> Result<(), Error> {
    for (i, table) in file.parameters.iter().enumerate() {
        let Some(tie) = &table.tie else { continue };
        let at = format!("parameter[{i}].tie");
        let Some(to) = model.term(&tie.to_string()) else {
            let text =
                format!("the model has no such parameter: {tie} does not name one effect at one place of the model");
            return Err(wrong(file, &at, &text));
        };
        let mut found = false;
        for term in (0..model.terms.len()).filter(|term| *term != to) {
            if !meant(table, &model.terms[term]) {
                continue;
            }
            for j in 0..model.terms[term].parameters.len() {
                let k = model.terms[term].parameters[j];
                if table.name.as_ref().is_some_and(|name| *name != model.parameters[k].spec.name) {
                    continue;
                }
                let alike = model.terms[term].effect.about().id == model.terms[to].effect.about().id;
                let Some(other) = model.terms[to].parameters.get(if alike { j } else { 0 }).copied() else { continue };
                let (own, its) = (&model.parameters[k].spec, &model.parameters[other].spec);
                if own.dimension != its.dimension || own.per_run != its.per_run {
                    let text = format!(
                        "{} of `{}` is in {}, {} of `{tie}` in {}: they cannot be tied",
                        own.name, model.parameters[k].term, own.dimension, its.name, its.dimension
                    );
                    return Err(wrong(file, &at, &text));
                }
                model.tie(k, other);
                found = true;
            }
        }
        if !found {
            return Err(not_there(file, i));
        }
    }
    Ok(())
}

/// Whether a `[[parameter]]` table means this term.
fn meant(table: &ParameterTable, term: &Term) -> bool {
    let place = table.effect.dof.is_none() || table.effect.place() == term.place;
    is_called(term.effect.as_ref(), &table.effect) && place
}

/// Whether a name, whatever its place, is that of this effect.
fn is_called(effect: &dyn Effect, name: &EffectName) -> bool {
    effect.about().id.parse().is_ok_and(|own: EffectName| own.overlaps(&EffectName { dof: None, ..name.clone() }))
}

/// Whether an effect has a state with a time constant.
fn remembers(model: &Model, term: &Term) -> bool {
    memory_count(&Graph::new(), model, term.effect.as_ref(), term.place) > 0
}

/// Returns the error for a table that matches no parameter of the model.
fn not_there(file: &CampaignFile, i: usize) -> Error {
    let table = &file.parameters[i];
    let text = format!(
        "the model has no such parameter: it has no effect {}{}",
        table.effect,
        match &table.name {
            Some(name) => format!(", or that has no parameter `{name}`"),
            None => String::new(),
        }
    );
    wrong(file, &format!("parameter[{i}].effect"), &text)
}

/// Returns the error for a wrong value of a key, with its place in the file.
pub(super) fn wrong(file: &CampaignFile, path: &str, what: &dyn std::fmt::Display) -> Error {
    let problem = Problem::Unreadable { message: what.to_string() };
    let (name, text, error) = match &file.source {
        Some(source) => (source.file.clone(), source.text.clone(), source.error_at(path, problem)),
        None => {
            let error = super::file::CampaignError {
                file: "campaign".into(),
                location: None,
                key: path.into(),
                value: None,
                problem,
            };
            ("campaign".into(), "".into(), error)
        }
    };
    Error::File(CampaignErrors { file: name, text, errors: vec![error], more: false })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::campaign::file::ReadOptions;

    fn read(text: &str) -> CampaignFile {
        let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
        let text = format!("format = 1\n{text}\n[[run]]\nfile = 'a.csv'\n");
        CampaignFile::from_bytes(text.as_bytes(), Path::new("c.toml"), &options).unwrap()
    }

    const MODEL: &str = "[vehicle]\nweight = 100.0\nbuoyancy = 90.0\n[model]\ndofs = ['surge']\neffects = ['inertia', 'linear_drag', 'restoring_surge']\n";

    #[test]
    fn parameters_are_written_where_they_are_meant() {
        let text = format!(
            "{MODEL}[[parameter]]\neffect = 'linear_drag@surge'\nvalue = 3.0\nfixed = true\n[[parameter]]\neffect = 'inertia'\nvalue = 20.0\nstd = 1.0\nmin = 5.0\n"
        );
        let (model, _) = build(&read(&text)).unwrap();
        let drag = &model.parameters[model.parameter_of("linear_drag@surge").unwrap()];
        assert!(drag.fixed && drag.value == 3.0);
        let inertia = &model.parameters[model.parameter_of("inertia@surge").unwrap()];
        assert_eq!((inertia.prior, inertia.min), (Some((20.0, 1.0)), 5.0));
        assert_eq!(model.value("restoring_surge"), Some(10.0));
        assert_eq!(model.weight, 100.0);
    }

    /// Start values and fixed values are taken as given; an impossible value is refused, not moved.
    #[test]
    fn values_outside_their_bounds_are_refused() {
        let refused = |lines: &str| {
            let model = MODEL.replace("'linear_drag'", "'linear_drag', 'thrust_lag', 'fluid_memory'");
            match build(&read(&format!("{model}[[parameter]]\n{lines}\n"))) {
                Err(error) => error.to_string(),
                Ok((model, _)) => {
                    let p = model.parameters.iter().find(|p| p.given).unwrap();
                    format!("{} {}", p.spec.name, p.value)
                }
            }
        };
        let lag = refused("effect = 'thrust_lag'\nvalue = 1e-5\nfixed = true");
        assert!(lag.contains("T_lag") && lag.contains("acts at once"), "{lag}");
        assert!(refused("effect = 'thrust_lag'\nvalue = 1e-5\nmin = 1e-6").contains("the integrator cannot resolve"));
        assert!(refused("effect = 'inertia@surge'\nvalue = 0.0").contains("inertia must be above 0"));
        assert!(refused("effect = 'linear_drag'\nvalue = -3.0\nfixed = true").contains("write `min` to allow it"));
        assert_eq!(refused("effect = 'linear_drag'\nvalue = -3.0\nmin = -10.0"), "k_u -3");
        assert_eq!(refused("effect = 'thrust_lag'\nvalue = 0.05"), "T_lag 0.05");
    }

    #[test]
    fn tied_parameters_are_one() {
        let model = "[model]\ndofs = ['surge', 'sway', 'heave', 'yaw']\neffects = ['inertia', 'linear_drag', 'quadratic_drag']\n";
        let text = format!(
            "{model}[[parameter]]\neffect = 'quadratic_drag@heave'\ntie = 'quadratic_drag@sway'\n[[parameter]]\neffect = \
             'quadratic_drag@sway'\nvalue = 7.0\nmin = 0.0\n"
        );
        let (tied, _) = build(&read(&text)).unwrap();
        assert_eq!(tied.parameters.len(), 11, "one of twelve less");
        let of = |name: &str| tied.parameter_of(name).unwrap();
        assert_eq!(of("quadratic_drag@heave"), of("quadratic_drag@sway"));
        assert_eq!((tied.value("quadratic_drag@heave"), tied.value("linear_drag@heave")), (Some(7.0), Some(0.0)));
        for (term, parameter) in
            tied.terms.iter().filter(|t| t.name() != "quadratic_drag@heave").map(|t| (t, t.parameters[0]))
        {
            assert_eq!(tied.parameters[parameter].term, term.name(), "the others stay");
        }
        let refused = |lines: &str| {
            let Err(error) = build(&read(&format!("{model}[[parameter]]\n{lines}\n"))) else { panic!("{lines}") };
            error.to_string()
        };
        assert!(refused("effect = 'linear_drag@yaw'\ntie = 'linear_drag@sway'").contains("they cannot be tied"));
        assert!(refused("effect = 'linear_drag@sway'\ntie = 'cubic_drag@sway'").contains("does not name one effect"));
        assert!(refused("effect = 'linear_drag@sway'\ntie = 'linear_drag'").contains("at one place"));
    }

    #[test]
    fn own_effects_are_baseline_or_candidates() {
        let effect = |role: &str| {
            format!("{MODEL}[[effect]]\nid = 'wind'\ndof = 'surge'\nformula = 'W^2'\nunit = 'kg/m'\nrole = '{role}'\n")
        };
        let (model, own) = build(&read(&effect("candidate"))).unwrap();
        assert!(model.term("wind@surge").is_none() && own.len() == 1);
        let (model, own) = build(&read(&effect("baseline"))).unwrap();
        assert!(model.term("wind@surge").is_some() && own.is_empty());
    }

    #[test]
    fn what_cannot_stand_is_told_with_its_line() {
        let text = MODEL.replace("'restoring_surge'", "'coriolis_yaw'");
        let message = build(&read(&text)).unwrap_err().to_string();
        assert!(message.starts_with("c.toml:7:") && message.contains("coriolis_yaw"), "{message}");
        let text = format!("{MODEL}[[parameter]]\neffect = 'quadratic_drag@surge'\nvalue = 3.0\n");
        assert!(build(&read(&text)).unwrap_err().to_string().contains("no such parameter"));
    }
}
