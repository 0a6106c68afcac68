//! A model: effects at their places, with the values of their parameters and the uncertainty of
//! these.
//!
//! ```text
//! model = degrees of freedom + terms (effect @ place) + parameters θ ± σ
//! ```
//!
//! Known or unknown, fixed or free is a property of the parameter in this model, never of the effect.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::effects::{Coriolis, Effect, GridUnit, Observer, ParameterSpec, Place, Scope, catalogue, id};
use crate::frame::{Dof, Measured};

/// Behaviour of an input between two samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Interpolation {
    /// A straight line from sample to sample.
    #[default]
    Linear,
    /// Each sample is held until the next.
    Hold,
}

impl Interpolation {
    /// Both.
    pub const ALL: [Interpolation; 2] = [Interpolation::Linear, Interpolation::Hold];

    /// Name, as in a campaign file.
    pub fn name(self) -> &'static str {
        match self {
            Interpolation::Linear => "linear",
            Interpolation::Hold => "hold",
        }
    }
}

/// An effect at its place, with the indices of its parameters in [`Model::parameters`].
#[derive(Debug, Clone)]
pub struct Term {
    /// The effect.
    pub effect: Arc<dyn Effect>,
    /// Its place.
    pub place: Place,
    /// Indices of its parameters.
    pub parameters: Vec<usize>,
    /// Parameter α that blends an effect in: τ + α (effect(τ) − τ) of an actuator, α τ of a force;
    /// 0: without the effect, 1: with all of it. Discovery scores candidates by it; `None` in an
    /// ordinary model.
    pub blend: Option<usize>,
    /// Channels with the memory of the effect, computed beforehand; `None` if the memory is
    /// simulated.
    pub memory_from: Option<Vec<String>>,
}

impl Term {
    /// `id`, `id@dof` or `id@dof:other`.
    pub fn name(&self) -> String {
        name_of(self.effect.about().id, self.place)
    }
}

/// `id`, `id@dof` or `id@dof:other`.
pub fn name_of(id: &str, place: Place) -> String {
    match (place.dof, place.other) {
        (Some(dof), Some(other)) => format!("{id}@{dof}:{other}"),
        (Some(dof), None) => format!("{id}@{dof}"),
        _ => id.to_string(),
    }
}

/// A parameter of a model. A parameter with a value in each run has a list as long as the runs.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// Name of the first term that reads it.
    pub term: String,
    /// Id of that term's effect.
    pub effect: String,
    /// Place of that term.
    pub place: Place,
    /// Symbol, unit, kind.
    pub spec: ParameterSpec,
    /// Value, SI; for a parameter per run the value of a run that is not listed.
    pub value: f64,
    /// Values per run, by the index of the run; empty for a common one.
    pub per_run: Vec<f64>,
    /// Standard deviation, SI; `None` if none was estimated.
    pub std: Option<f64>,
    /// Whether it is held at its value.
    pub fixed: bool,
    /// Whether its value is a start that the user gave: a search begins there and nowhere else.
    pub given: bool,
    /// Lower bound.
    pub min: f64,
    /// Upper bound.
    pub max: f64,
    /// Mean and standard deviation of a Gaussian prior.
    pub prior: Option<(f64, f64)>,
}

impl Parameter {
    /// `k_u|u| of quadratic_drag@surge`.
    pub fn full_name(&self) -> String {
        format!("{} of {}", self.spec.name, self.term)
    }

    /// Its value; the mean if each run has its own.
    pub fn mean(&self) -> f64 {
        match self.per_run.len() {
            0 => self.value,
            runs => self.per_run.iter().sum::<f64>() / runs as f64,
        }
    }
}

/// A model of a vehicle.
#[derive(Debug, Clone)]
pub struct Model {
    /// Degrees of freedom that are simulated, in the order of ν.
    pub dofs: Vec<Dof>,
    /// Tied or free Coriolis coefficients.
    pub coriolis: Coriolis,
    /// Behaviour of inputs between samples.
    pub input: Interpolation,
    /// Weight of the vehicle, N, which acts at a centre of gravity off the axis.
    pub weight: f64,
    /// Length of the vehicle, m, the unit of the search for a position on it; 1 if it is not known.
    pub length: f64,
    /// Effects at their places, in the order in which they were added.
    pub terms: Vec<Term>,
    /// Their parameters.
    pub parameters: Vec<Parameter>,
    /// Logged functions of the states that the model predicts besides velocities and angles.
    pub observers: Vec<Observer>,
    /// Whether the logged u, v, w are velocities through the water, ν_r, and not over ground.
    pub through_water: bool,
}

/// The reason why a model cannot be built.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ModelError {
    /// No effect has this id.
    #[error("no effect is called `{id}`")]
    UnknownEffect {
        /// The id asked for.
        id: String,
    },
    /// The effect cannot stand there.
    #[error("`{name}` cannot stand in this model: {reason}")]
    WrongPlace {
        /// Effect and place asked for.
        name: String,
        /// Why.
        reason: String,
    },
    /// The term is already in the model.
    #[error("`{name}` is in the model already")]
    Twice {
        /// The term.
        name: String,
    },
    /// A simulated degree of freedom has no inertia.
    #[error("`{dof}` has no inertia: add the effect `inertia@{dof}`")]
    NoInertia {
        /// The degree of freedom.
        dof: Dof,
    },
}

impl Model {
    /// A model without effects.
    pub fn new(dofs: &[Dof], coriolis: Coriolis) -> Model {
        let mut dofs = dofs.to_vec();
        dofs.sort_unstable();
        dofs.dedup();
        Model {
            dofs,
            coriolis,
            input: Interpolation::Linear,
            weight: 0.0,
            length: 1.0,
            terms: Vec::new(),
            parameters: Vec::new(),
            observers: Vec::new(),
            through_water: false,
        }
    }

    /// A model with these catalogue effects: `id`, wherever it applies, or `id@dof`, or `id@dof:other`.
    ///
    /// # Errors
    /// [`ModelError`] for an unknown id or a place where the effect cannot stand.
    pub fn with_effects(dofs: &[Dof], coriolis: Coriolis, effects: &[&str]) -> Result<Model, ModelError> {
        let mut model = Model::new(dofs, coriolis);
        for name in effects {
            model.add_named(name)?;
        }
        Ok(model)
    }

    /// Adds a catalogue effect by name, a plain id at every place where it applies. Returns the new
    /// terms' indices.
    ///
    /// # Errors
    /// As [`Model::with_effects`].
    pub fn add_named(&mut self, name: &str) -> Result<Vec<usize>, ModelError> {
        let (id, place) = match name.split_once('@') {
            None => (name, None),
            Some((id, place)) => (id, Some(place)),
        };
        let effect = catalogue(self.coriolis)
            .into_iter()
            .find(|e| e.about().id == id)
            .ok_or_else(|| ModelError::UnknownEffect { id: id.to_string() })?;
        let wrong = |reason: &str| ModelError::WrongPlace { name: name.to_string(), reason: reason.to_string() };
        let dof_of = |text: &str| Dof::from_name(text).ok_or_else(|| wrong("no such degree of freedom"));
        let places = match place {
            None => places_of(effect.as_ref(), &self.dofs),
            Some(text) => vec![match text.split_once(':') {
                None => Place::at(dof_of(text)?),
                Some((dof, other)) => Place::pair(dof_of(dof)?, dof_of(other)?),
            }],
        };
        if places.is_empty() {
            return Err(wrong("it applies to none of the modelled degrees of freedom"));
        }
        places.into_iter().map(|place| self.add(effect.clone(), place)).collect()
    }

    /// Adds an effect at a place. Linear parameters start at their neutral value, shape parameters
    /// at the first value of their grid. Returns the index of the term. If the model has the same
    /// effect both with a value in every run and with one value for all, it keeps the first alone,
    /// which includes the second.
    ///
    /// # Errors
    /// [`ModelError`] if it cannot stand there or is already there.
    pub fn add(&mut self, effect: Arc<dyn Effect>, place: Place) -> Result<usize, ModelError> {
        let name = name_of(effect.about().id, place);
        if self.terms.iter().any(|t| t.name() == name) {
            return Err(ModelError::Twice { name });
        }
        if let Some(reason) = misplaced(effect.as_ref(), place, &self.dofs) {
            return Err(ModelError::WrongPlace { name, reason });
        }
        let is_wider = |t: &Term| t.place == place && t.effect.same_in_all_runs() == Some(effect.about().id);
        if let Some(wider) = self.terms.iter().position(is_wider) {
            return Ok(wider);
        }
        if let Some(narrower) = effect.same_in_all_runs().and_then(|id| self.term(&name_of(id, place))) {
            self.remove(narrower);
        }
        let specs = effect.parameters(place).into_iter();
        let parameters = specs.map(|spec| self.parameter_for(&name, effect.about().id, place, spec)).collect();
        self.terms.push(Term { effect, place, parameters, blend: None, memory_from: None });
        Ok(self.terms.len() - 1)
    }

    /// Replaces the effect of a term by `effect`, whose first parameters are those of the term, and adds its others.
    pub(crate) fn change(&mut self, term: usize, effect: Arc<dyn Effect>) {
        let Term { place, ref parameters, .. } = self.terms[term];
        let (name, known) = (self.terms[term].name(), parameters.len());
        for spec in effect.parameters(place).into_iter().skip(known) {
            let added = self.parameter_for(&name, effect.about().id, place, spec);
            self.terms[term].parameters.push(added);
        }
        self.terms[term].effect = effect;
    }

    /// The parameter that others share with the term `name`, or a new one.
    fn parameter_for(&mut self, name: &str, effect: &str, place: Place, spec: ParameterSpec) -> usize {
        let known = self.parameters.iter().position(|p| spec.shared.is_some() && p.spec.shared == spec.shared);
        known.unwrap_or_else(|| self.push_parameter(name, effect, place, spec))
    }

    /// Adds a parameter that belongs to the term `name`; returns its index.
    pub(crate) fn push_parameter(&mut self, name: &str, effect: &str, place: Place, spec: ParameterSpec) -> usize {
        let (value, min, max) = match &spec.kind {
            crate::effects::ParameterKind::Linear => (spec.neutral, spec.least, f64::INFINITY),
            crate::effects::ParameterKind::Shape { grid, min, max } => {
                let scale = if spec.grid_in == GridUnit::Length { self.length } else { 1.0 };
                (grid.first().map_or(spec.neutral, |at| (at * scale).clamp(*min, *max)), *min, *max)
            }
        };
        self.parameters.push(Parameter {
            term: name.to_string(),
            effect: effect.to_string(),
            place,
            spec,
            value,
            per_run: Vec::new(),
            std: None,
            fixed: false,
            given: false,
            min,
            max,
            prior: None,
        });
        self.parameters.len() - 1
    }

    /// Removes a term, with the parameters that no other term reads.
    pub fn remove(&mut self, term: usize) {
        let removed = self.terms.remove(term);
        let mut gone: Vec<usize> = removed.parameters.into_iter().chain(removed.blend).collect();
        gone.sort_unstable_by(|a, b| b.cmp(a));
        for index in gone {
            if self.terms.iter().any(|t| t.parameters.contains(&index) || t.blend == Some(index)) {
                continue;
            }
            self.parameters.remove(index);
            for t in &mut self.terms {
                for p in t.parameters.iter_mut().chain(t.blend.as_mut()) {
                    *p -= usize::from(*p > index);
                }
            }
        }
    }

    /// Replaces the parameter `of` by `to` in all terms that read it.
    pub fn tie(&mut self, of: usize, to: usize) {
        if of == to {
            return;
        }
        self.parameters.remove(of);
        let place = |p: usize| if p == of { to } else { p };
        for term in &mut self.terms {
            for p in term.parameters.iter_mut().chain(term.blend.as_mut()) {
                *p = place(*p);
                *p -= usize::from(*p > of);
            }
        }
    }

    /// Index of the term with this name.
    pub fn term(&self, name: &str) -> Option<usize> {
        self.terms.iter().position(|t| t.name() == name)
    }

    /// Index of the parameter `symbol` of the term `name`.
    pub fn parameter(&self, name: &str, symbol: &str) -> Option<usize> {
        let term = &self.terms[self.term(name)?];
        term.parameters.iter().copied().find(|p| self.parameters[*p].spec.name == symbol)
    }

    /// Index of the first parameter of the term `name`.
    pub fn parameter_of(&self, name: &str) -> Option<usize> {
        self.terms[self.term(name)?].parameters.first().copied()
    }

    /// The term to which the parameter `index` belongs.
    pub fn term_of(&self, index: usize) -> Option<&Term> {
        self.terms.iter().find(|term| term.parameters.contains(&index))
    }

    /// Index of the virtual mass or moment of inertia in `dof`.
    pub fn inertia(&self, dof: Dof) -> Option<usize> {
        self.at(id::INERTIA, dof)
    }

    /// Index of the first parameter of the effect `id` in `dof`.
    pub fn at(&self, id: &str, dof: Dof) -> Option<usize> {
        self.parameter_of(&format!("{id}@{dof}"))
    }

    /// Value of the first parameter of the effect `id` in `dof`.
    pub fn value_at(&self, id: &str, dof: Dof) -> Option<f64> {
        self.at(id, dof).map(|p| self.parameters[p].value)
    }

    /// Sets the value of the first parameter of the term `name`; returns whether there is one.
    pub fn set(&mut self, name: &str, value: f64) -> bool {
        self.parameter_of(name).map(|p| self.parameters[p].value = value).is_some()
    }

    /// Value of the first parameter of the term `name`.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.parameter_of(name).map(|p| self.parameters[p].value)
    }

    /// Values of all parameters, in order.
    pub fn values(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.value).collect()
    }

    /// Indices of the parameters that are not fixed.
    pub fn free(&self) -> Vec<usize> {
        (0..self.parameters.len()).filter(|i| !self.parameters[*i].fixed).collect()
    }

    /// The quantities with which a simulation is compared: the modelled velocities, then the
    /// observed functions.
    pub fn measured(&self) -> Vec<Measured> {
        let functions = self.observers.iter().map(|observer| Measured::Function(observer.channel().into()));
        self.dofs.iter().copied().map(Measured::Velocity).chain(functions).collect()
    }

    /// Checks that the model can be simulated.
    ///
    /// # Errors
    /// [`ModelError::NoInertia`].
    pub fn check(&self) -> Result<(), ModelError> {
        for dof in &self.dofs {
            if self.inertia(*dof).is_none() {
                return Err(ModelError::NoInertia { dof: *dof });
            }
        }
        Ok(())
    }
}

/// Every place at which an effect may stand in a model of these degrees of freedom.
pub fn places_of(effect: &dyn Effect, dofs: &[Dof]) -> Vec<Place> {
    let all = match effect.about().scope {
        Scope::Each(list) => list.iter().map(|d| Place::at(*d)).collect(),
        Scope::Pairs => Dof::ALL.iter().flat_map(|i| Dof::ALL.iter().map(|j| Place::pair(*i, *j))).collect(),
        Scope::Couples(list) => list.iter().map(|(i, j)| Place::pair(*i, *j)).collect(),
        Scope::Vehicle(_) | Scope::VehicleAny(_) | Scope::Everywhere | Scope::Thrusters => vec![Place::VEHICLE],
    };
    let modelled = |place: &Place| place.other.is_none_or(|other| dofs.contains(&other));
    all.into_iter().filter(|p| modelled(p) && misplaced(effect, *p, dofs).is_none()).collect()
}

/// The reason why an effect cannot stand at a place; `None` if it can.
fn misplaced(effect: &dyn Effect, place: Place, dofs: &[Dof]) -> Option<String> {
    let absent =
        |dof: Dof| (!dofs.contains(&dof)).then(|| format!("{dof} is not among the modelled degrees of freedom"));
    match (effect.about().scope, place.dof, place.other) {
        (Scope::Each(list), Some(dof), None) if list.contains(&dof) => absent(dof),
        (Scope::Pairs, Some(dof), Some(other)) if dof != other => absent(dof),
        (Scope::Couples(list), Some(dof), Some(other)) if list.contains(&(dof, other)) => absent(dof),
        (Scope::Vehicle(needed), None, None) => needed.iter().find_map(|dof| absent(*dof)),
        (Scope::VehicleAny(sets), None, None) => {
            let lacking: Option<Vec<_>> = sets.iter().map(|set| set.iter().find_map(|dof| absent(*dof))).collect();
            lacking.and_then(|reasons| reasons.into_iter().next())
        }
        (Scope::Everywhere, None, None) => None,
        // the entry of the catalogue, without a thruster
        (Scope::Thrusters, ..) if effect.channels(place).iter().all(String::is_empty) => Some(
            "it is of thrusters that [[thruster]] describes; of single ones it is written with their names, as `@T6` or \
             `@T2:T5`"
                .into(),
        ),
        (Scope::Thrusters, None, None) => None,
        (Scope::Each(_), ..) => Some("it is written id@dof".into()),
        (Scope::Pairs, ..) => Some("it is written id@dof:other, with two different degrees of freedom".into()),
        (Scope::Couples(list), ..) => {
            let of: Vec<String> = list.iter().map(|(i, j)| format!("{i}:{j}")).collect();
            Some(format!("it is written id@dof:other, with one of {}", of.join(", ")))
        }
        _ => Some("it belongs to the whole vehicle and is written without a degree of freedom".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLANAR: [Dof; 3] = [Dof::Surge, Dof::Sway, Dof::Yaw];

    #[test]
    fn a_plain_id_stands_wherever_it_applies() {
        let model = Model::with_effects(&PLANAR, Coriolis::Tied, &["inertia", "coriolis_yaw"]).unwrap();
        let names: Vec<_> = model.terms.iter().map(Term::name).collect();
        assert_eq!(names, ["inertia@surge", "inertia@sway", "inertia@yaw", "coriolis_yaw"]);
        assert_eq!(model.parameters.len(), 3);
        assert_eq!(model.check(), Ok(()));
    }

    #[test]
    fn what_each_run_has_for_itself_stands_in_the_stead_of_one_value_for_all() {
        for listed in [["bias", "bias_each_run@sway"], ["bias_each_run@sway", "bias"]] {
            let model = Model::with_effects(&PLANAR, Coriolis::Tied, &listed).unwrap();
            let mut names: Vec<_> = model.terms.iter().map(Term::name).collect();
            names.sort();
            assert_eq!(names, ["bias@surge", "bias@yaw", "bias_each_run@sway"]);
            assert_eq!(model.parameters.len(), 3);
            assert!(model.parameters.iter().all(|p| p.spec.per_run == (p.term == "bias_each_run@sway")));
        }
    }

    #[test]
    fn misplaced_effects_are_refused_with_the_reason() {
        let refuse = |name: &str| Model::with_effects(&PLANAR, Coriolis::Tied, &[name]).unwrap_err().to_string();
        assert!(refuse("inertia@heave").contains("heave is not among"));
        assert!(refuse("inertia@down").contains("no such degree"));
        assert!(refuse("drag").contains("no effect is called `drag`"));
        assert!(refuse("coriolis_pitch").contains("applies to none"));
        assert!(refuse("cross_drag@yaw").contains("id@dof:other"));
        let twice = Model::with_effects(&PLANAR, Coriolis::Tied, &["inertia", "inertia@yaw"]);
        assert!(matches!(twice, Err(ModelError::Twice { .. })));
        let none = Model::with_effects(&PLANAR, Coriolis::Tied, &["linear_drag"]).unwrap();
        assert_eq!(none.check(), Err(ModelError::NoInertia { dof: Dof::Surge }));
    }

    #[test]
    fn net_weight_is_one_parameter_and_outlives_one_of_its_terms() {
        let mut model = Model::with_effects(
            &PLANAR,
            Coriolis::Free,
            &["restoring_surge", "bias@yaw", "restoring_sway", "coriolis_yaw"],
        )
        .unwrap();
        assert_eq!(model.parameters.len(), 3);
        model.remove(0);
        assert_eq!(model.parameters.len(), 3);
        model.remove(model.term("restoring_sway").unwrap());
        assert_eq!(model.parameters.iter().map(|p| p.spec.name.as_str()).collect::<Vec<_>>(), ["b_r", "k_uv"]);
        assert_eq!(model.parameter("coriolis_yaw", "k_uv"), Some(1));
    }
}
