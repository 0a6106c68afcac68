//! A loss of thrust of every thruster with the speed of the water along its own axis.
//!
//! ```text
//! τ → τ − k Σ_T b_T F_T |s_T · (v + ω × p_T)|
//! ```
//!
//! k: s/m (s), the same for all; b_T, F_T: [`super::SingleThruster`]; s_T, p_T: axis and place of
//! thruster T. Avila et al. (2013), eq. 17. Port and starboard thrusters lose turning moment when
//! the vehicle moves ahead, which a loss by degree of freedom ([`super::thrust_advance_loss`]) does
//! not describe.

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, SingleThruster, Six};
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "thruster_advance_loss";

/// The loss of all thrusters of a vehicle in proportion to the speed along their axes.
#[derive(Debug)]
pub struct ThrusterAdvanceLoss {
    thrusters: Vec<SingleThruster>,
}

impl ThrusterAdvanceLoss {
    /// The effect for these thrusters, all that the vehicle has.
    pub fn of(thrusters: Vec<SingleThruster>) -> ThrusterAdvanceLoss {
        ThrusterAdvanceLoss { thrusters }
    }
}

impl Effect for ThrusterAdvanceLoss {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Actuator,
            scope: Scope::Thrusters,
            formula: "τ −= k Σ_T b_T F_T |s_T · (v + ω × p_T)|",
            meaning: "A loss of each thruster proportional to the speed along its axis.",
            source: "Avila, Donha and Adamowski, Ocean Engineering 60 (2013), eq. 17",
            shown_by: "turns under the same commands at rest and at speed, full command starting from rest",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear("k_advance", Dimension::ONE.over(Dimension::VELOCITY))]
    }

    fn channels(&self, _: Place) -> Vec<String> {
        self.thrusters.iter().map(|thruster| thruster.channel.clone()).collect()
    }

    fn actuate<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], tau: &mut Six<'g>) {
        for thruster in &self.thrusters {
            thruster.push(at, -theta[0] * thruster.advance(at).abs(), tau);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::chain::{Available, assemble};
    use crate::effects::Coriolis;
    use crate::frame::Dof;
    use crate::model::Model;
    use crate::symbolic::{Graph, Leaf};

    /// At 2 m/s ahead and 0.5 rad/s, a thruster one metre to port advances at 2.5 m/s, one to
    /// starboard at 1.5 m/s.
    #[test]
    fn each_thruster_loses_by_its_own_speed() {
        let side = |name: &str, y: f64| {
            let unit_wrench = [1.0, 0.0, 0.0, 0.0, 0.0, -y];
            SingleThruster { name: name.into(), channel: format!("F_{name}"), unit_wrench, wrench: unit_wrench }
        };
        let mut model = Model::with_effects(&[Dof::Surge, Dof::Yaw], Coriolis::Tied, &["inertia"]).unwrap();
        let effect = ThrusterAdvanceLoss::of(vec![side("port", -1.0), side("starboard", 1.0)]);
        let term = model.add(Arc::new(effect), Place::VEHICLE).unwrap();
        let k = model.terms[term].parameters[0];
        model.parameters[k].value = 0.1;
        let values = model.values();
        let channels = ["tau_u", "tau_r", "F_port", "F_starboard"].map(String::from).into();
        let graph = Graph::new();
        let equations = assemble(&graph, &model, &Available { channels, ..Available::default() });
        let read = |leaf| match leaf {
            Leaf::Parameter(p) => values[usize::from(p)],
            Leaf::Input(k) => match equations.inputs[usize::from(k)].as_str() {
                "tau_u" => 10.0,
                "tau_r" => -2.0,
                "F_port" => 4.0,
                _ => 6.0,
            },
            Leaf::State(0) => 2.0,
            Leaf::State(5) => 0.5,
            _ => 0.0,
        };
        let [surge, yaw] = [0, 5].map(|i| equations.force[i].evaluate(&read));
        let (port, starboard) = (4.0 * 0.1 * 2.5, 6.0 * 0.1 * 1.5);
        assert!((surge - (10.0 - port - starboard)).abs() < 1e-12, "{surge}");
        assert!((yaw - (-2.0 - port + starboard)).abs() < 1e-12, "{yaw}");
    }
}
