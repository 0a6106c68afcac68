//! An effect that begins at an instant: a thruster that fails, a payload that is dropped.
//!
//! ```text
//! θ → θ_neutral + 1(t ≥ t₀) (θ − θ_neutral)        1(t ≥ t₀): a channel of every run, 0 before the instant and 1 after it
//! ```
//!
//! For effects without memory, whose parameters are linear: elsewhere they are nothing.

use std::sync::Arc;

use super::{About, Effect, Instant, Logged, ParameterSpec, Place, Six};
use crate::symbolic::Expr;

/// An effect of the catalogue, under its id, that acts as far as a channel says.
#[derive(Debug)]
pub struct Since {
    effect: Arc<dyn Effect>,
    channel: String,
}

impl Since {
    /// `effect` where `channel` is 1, and nothing where it is 0.
    pub fn of(effect: Arc<dyn Effect>, channel: &str) -> Since {
        Since { effect, channel: channel.into() }
    }

    fn here<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>]) -> Vec<Expr<'g>> {
        let acts = at.channel(&self.channel);
        let of = |(value, spec): (&Expr<'g>, ParameterSpec)| {
            let neutral = at.unit(spec.dimension, spec.neutral);
            neutral + acts * (*value - neutral)
        };
        theta.iter().zip(self.effect.parameters(place)).map(of).collect()
    }
}

impl Effect for Since {
    fn about(&self) -> About<'_> {
        self.effect.about()
    }

    fn parameters(&self, place: Place) -> Vec<ParameterSpec> {
        self.effect.parameters(place)
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
    use crate::effects::thrust_interaction_loss::ThrustInteractionLoss;
    use crate::frame::Dof;
    use crate::model::Model;
    use crate::symbolic::{Graph, Leaf};

    /// Of 10 N a scale of 0.7 leaves 7 from the instant on, and 10 before.
    #[test]
    fn before_the_instant_an_effect_is_nothing() {
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia"]).unwrap();
        let effect = Since::of(Arc::new(ThrustInteractionLoss), "since");
        model.add(Arc::new(effect), Place::at(Dof::Surge)).unwrap();
        let scale = model.parameter("thrust_interaction_loss@surge", "eta_u").unwrap();
        model.parameters[scale].value = 0.7;
        let values = model.values();
        let channels = ["tau_u", "since"].map(String::from).into();
        let graph = Graph::new();
        let equations = assemble(&graph, &model, &Available { channels, ..Available::default() });
        let force = |since: f64| {
            equations.force[0].evaluate(&|leaf| match leaf {
                Leaf::Parameter(p) => values[usize::from(p)],
                Leaf::Input(k) if equations.inputs[usize::from(k)] == "tau_u" => 10.0,
                Leaf::Input(_) => since,
                _ => 0.0,
            })
        };
        assert_eq!([force(0.0), force(1.0)], [10.0, 7.0]);
    }
}
