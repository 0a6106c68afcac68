//! An effect that begins or changes at an instant: a thruster that fails, a payload that is dropped, weed on the hull.
//!
//! ```text
//! θ → θ_neutral + 1(t ≥ t₀) (θ − θ_neutral)     it begins
//! θ → (1 + 1(t ≥ t₀) s) θ                       it changes in proportion
//! θ → θ + 1(t ≥ t₀) s                           it changes by an amount
//! ```
//!
//! 1(t ≥ t₀): a channel of every run, 0 before the instant and 1 after it. For effects without memory, whose parameters
//! are linear.

use std::sync::Arc;

use super::{About, Effect, Instant, Logged, ParameterSpec, Place, Six};
use crate::symbolic::Expr;
use crate::units::Dimension;

/// What happens to an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// It begins.
    Begins,
    /// It changes by a share of its parameters, s.
    Share,
    /// It changes by an amount s of its parameters.
    Amount,
}

/// An effect that begins or changes where a channel is 1. The share or the amount is its last parameter.
#[derive(Debug)]
pub struct Since {
    effect: Arc<dyn Effect>,
    channel: String,
    event: Event,
    /// Its id, if it is not that of the effect.
    id: Option<String>,
    /// Key of the parameter that is one for several effects: of what begins all, of what changes s.
    tie: Option<&'static str>,
}

impl Since {
    /// `effect`, under its id, as it is where `channel` is 0, and after the event where it is 1.
    pub fn of(effect: Arc<dyn Effect>, event: Event, channel: &str) -> Since {
        Since { effect, channel: channel.into(), event, id: None, tie: None }
    }

    /// The same with one parameter for all effects of this key. What begins has an id of its own, to stand beside the
    /// effect itself.
    pub fn tied(self, key: &'static str) -> Since {
        let id = (self.event == Event::Begins).then(|| format!("{}_since", self.effect.about().id));
        Since { id, tie: Some(key), ..self }
    }

    fn here<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>]) -> Vec<Expr<'g>> {
        let acts = at.channel(&self.channel);
        let specs = self.effect.parameters(place);
        let change = |value: &Expr<'g>| match (self.event, theta.last()) {
            (Event::Share, Some(s)) => *value + acts * *s * *value,
            (Event::Amount, Some(s)) => *value + acts * *s,
            _ => *value,
        };
        let begin = |(value, spec): (&Expr<'g>, &ParameterSpec)| {
            let neutral = at.unit(spec.dimension, spec.neutral);
            neutral + acts * (*value - neutral)
        };
        match self.event {
            Event::Begins => theta.iter().zip(&specs).map(begin).collect(),
            Event::Share | Event::Amount => theta[..specs.len()].iter().map(change).collect(),
        }
    }
}

impl Effect for Since {
    fn about(&self) -> About<'_> {
        let about = self.effect.about();
        About { id: self.id.as_deref().unwrap_or(about.id), ..about }
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        let mut specs = self.effect.parameters(place);
        let dimension = match (self.event, specs.first()) {
            (Event::Amount, Some(spec)) => spec.dimension,
            _ => Dimension::ONE,
        };
        match self.event {
            Event::Begins => specs.iter_mut().for_each(|spec| spec.shared = self.tie.or(spec.shared)),
            _ => specs.push(ParameterSpec { shared: self.tie, ..ParameterSpec::linear("s", dimension) }),
        }
        specs
    }

    fn channels(&self, place: Place) -> Vec<String> {
        let mut channels = self.effect.channels(place);
        channels.push(self.channel.clone());
        channels
    }

    fn pose(&self) -> &'static [&'static str] {
        self.effect.pose()
    }

    fn tied_to_ground(&self) -> bool {
        self.effect.tied_to_ground()
    }

    fn momentum<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], momentum: &mut Six<'g>) {
        self.effect.momentum(at, place, &self.here(at, place, theta), momentum);
    }

    fn wrench<'g>(
        &self,
        at: &Instant<'g>,
        place: Place,
        theta: &[Expr<'g>],
        memory: &[Expr<'g>],
        wrench: &mut Six<'g>,
    ) {
        self.effect.wrench(at, place, &self.here(at, place, theta), memory, wrench);
    }

    fn actuate<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], memory: &[Expr<'g>], tau: &mut Six<'g>) {
        self.effect.actuate(at, place, &self.here(at, place, theta), memory, tau);
    }

    fn sense<'g>(
        &self,
        at: &Instant<'g>,
        place: Place,
        theta: &[Expr<'g>],
        memory: &[Expr<'g>],
        logged: &mut Logged<'g>,
    ) {
        self.effect.sense(at, place, &self.here(at, place, theta), memory, logged);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::{Available, assemble};
    use crate::effects::Coriolis;
    use crate::effects::linear_drag::LinearDrag;
    use crate::effects::thrust_interaction_loss::ThrustInteractionLoss;
    use crate::frame::Dof;
    use crate::model::Model;
    use crate::symbolic::{Graph, Leaf};

    fn surge(effects: &[&str]) -> Model {
        Model::with_effects(&[Dof::Surge], Coriolis::Tied, effects).unwrap()
    }

    /// The force in surge at 2 m/s under 10 N, before the event and after it.
    fn force(model: &Model) -> [f64; 2] {
        let values = model.values();
        let channels = ["tau_u", "since"].map(String::from).into();
        let graph = Graph::new();
        let equations = assemble(&graph, model, &Available { channels, ..Available::default() });
        [0.0, 1.0].map(|since| {
            equations.force[0].evaluate(&|leaf| match leaf {
                Leaf::Parameter(p) => values[usize::from(p)],
                Leaf::Input(k) if equations.inputs[usize::from(k)] == "tau_u" => 10.0,
                Leaf::Input(_) => since,
                Leaf::State(0) => 2.0,
                _ => 0.0,
            })
        })
    }

    /// Of 10 N a scale of 0.7 leaves 7 from the instant on, and 10 before.
    #[test]
    fn before_the_instant_an_effect_is_nothing() {
        let mut model = surge(&["inertia"]);
        let effect = Since::of(Arc::new(ThrustInteractionLoss), Event::Begins, "since");
        model.add(Arc::new(effect), Place::at(Dof::Surge)).unwrap();
        let scale = model.parameter("thrust_interaction_loss@surge", "eta_u").unwrap();
        model.parameters[scale].value = 0.7;
        assert_eq!(force(&model), [10.0, 7.0]);
    }

    /// A drag of 3 N s/m at 2 m/s takes 6 N; half as much more, or 1.5 N s/m more, takes 9 N.
    #[test]
    fn a_drag_changes_by_a_share_or_by_an_amount() {
        for (event, s) in [(Event::Share, 0.5), (Event::Amount, 1.5)] {
            let mut model = surge(&["inertia"]);
            let effect = Since::of(Arc::new(LinearDrag), event, "since").tied("drag");
            model.add(Arc::new(effect), Place::at(Dof::Surge)).unwrap();
            let of = |name| model.parameter("linear_drag@surge", name).unwrap();
            let (drag, change) = (of("k_u"), of("s"));
            model.parameters[drag].value = 3.0;
            model.parameters[change].value = s;
            assert_eq!(force(&model), [4.0, 1.0], "{event:?}");
        }
    }
}
