//! A single thruster that is weak, dead, or wired the wrong way round.
//!
//! ```text
//! τ → τ − k b_T F_T
//! ```
//!
//! k: 1; 1 for a dead thruster, 2 for one that pushes the other way; b_T, F_T: [`super::SingleThruster`].

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, SingleThruster, Six};
use crate::symbolic::Expr;
use crate::units::Dimension;

/// The constant loss of a share of one thruster's force.
#[derive(Debug)]
pub struct ThrusterLoss {
    id: String,
    thruster: SingleThruster,
}

impl ThrusterLoss {
    /// Its id without a thruster.
    pub const ID: &'static str = "thruster_loss";

    /// The loss of this thruster.
    pub fn of(thruster: SingleThruster) -> ThrusterLoss {
        ThrusterLoss { id: format!("{}@{}", ThrusterLoss::ID, thruster.name), thruster }
    }

    /// The effect without a thruster, as the catalogue lists it.
    pub(super) fn of_none() -> ThrusterLoss {
        ThrusterLoss { id: ThrusterLoss::ID.into(), thruster: SingleThruster::default() }
    }
}

impl Effect for ThrusterLoss {
    fn about(&self) -> About<'_> {
        About {
            id: &self.id,
            family: Family::Actuator,
            scope: Scope::Thrusters,
            formula: "τ −= k b_T F_T",
            meaning: "A share of one thruster's force that is missing throughout.",
            source: "Alessandri, Caccia and Veruggio, Control Engineering Practice 7 (1999)",
            shown_by: "commands of that thruster that vary independently of those of the others",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear("k_loss", Dimension::ONE)]
    }

    fn channels(&self, _: Place) -> Vec<String> {
        vec![self.thruster.channel.clone()]
    }

    fn actuate<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], tau: &mut Six<'g>) {
        self.thruster.push(at, -theta[0], tau);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::chain::{Available, assemble};
    use crate::effects::{Coriolis, ThrusterSwap};
    use crate::frame::Dof;
    use crate::model::Model;
    use crate::symbolic::{Graph, Leaf};

    fn single(name: &str, wrench: [f64; 6]) -> SingleThruster {
        SingleThruster { name: name.into(), channel: format!("F_{name}"), unit_wrench: wrench, wrench }
    }

    /// τ of surge and yaw with T and U at 3 and 5 N, U half a metre to port, and with effects
    /// added; `late`: whether the command is delayed.
    fn force(effects: Vec<Arc<dyn Effect>>, k: f64, late: bool) -> [f64; 2] {
        let mut model = Model::with_effects(&[Dof::Surge, Dof::Yaw], Coriolis::Tied, &["inertia"]).unwrap();
        for effect in effects {
            let term = model.add(effect, Place::VEHICLE).unwrap();
            model.terms[term].parameters.clone().into_iter().for_each(|p| model.parameters[p].value = k);
        }
        if late {
            model.add_named("thrust_delay").unwrap();
        }
        let values = model.values();
        let channels = ["tau_u", "tau_r", "F_T", "F_U"].map(String::from).into();
        let graph = Graph::new();
        let equations = assemble(&graph, &model, &Available { channels, ..Available::default() });
        // the delayed command is a tenth of the present one
        let read = |leaf| {
            let (input, share) = match leaf {
                Leaf::Parameter(p) => return values[usize::from(p)],
                Leaf::Input(k) => (k, 1.0),
                Leaf::Delayed { input, .. } => (input, 0.1),
                _ => return 0.0,
            };
            let now = [("tau_u", 8.0), ("tau_r", 2.5), ("F_T", 3.0), ("F_U", 5.0)];
            let name = equations.inputs[usize::from(input)].as_str();
            now.iter().find(|(known, _)| *known == name).map_or(0.0, |(_, value)| value * share)
        };
        [0, 5].map(|i| equations.force[i].evaluate(&read))
    }

    const T: [f64; 6] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    const U: [f64; 6] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.5];

    #[test]
    fn a_dead_thruster_gives_nothing_and_one_wired_wrong_the_opposite() {
        let lost = || vec![Arc::new(ThrusterLoss::of(single("U", U))) as Arc<dyn Effect>];
        assert_eq!(force(lost(), 0.0, false), [8.0, 2.5]);
        assert_eq!(force(lost(), 1.0, false), [3.0, 0.0]);
        assert_eq!(force(lost(), 2.0, false), [-2.0, -2.5]);
    }

    #[test]
    fn exchanged_thrusters_give_each_others_force() {
        let swap = || vec![Arc::new(ThrusterSwap::of([single("T", T), single("U", U)])) as Arc<dyn Effect>];
        assert_eq!(force(swap(), 0.0, false), [8.0, 1.5]);
    }

    /// Forces of single thrusters are part of the command, and delayed with it.
    #[test]
    fn a_delay_is_of_single_thrusters_too() {
        let lost = vec![Arc::new(ThrusterLoss::of(single("U", U))) as Arc<dyn Effect>];
        let [surge, yaw] = force(lost, 1.0, true);
        assert!((surge - 0.3).abs() < 1e-12 && yaw.abs() < 1e-12, "{surge} {yaw}");
    }

    #[test]
    fn units_are_those_of_forces() {
        let graph = Graph::new();
        let mut model = Model::with_effects(&Dof::ALL, Coriolis::Tied, &["inertia"]).unwrap();
        let all = [0.8, 0.0, 0.6, 0.2, 0.3, 0.4];
        model.add(Arc::new(ThrusterLoss::of(single("T", all))), Place::VEHICLE).unwrap();
        let channels = ["tau_u", "F_T"].map(String::from).into();
        let equations = assemble(&graph, &model, &Available { channels, ..Available::default() });
        // in formulas the channel of a thruster has no unit, as every further channel
        for (dof, force) in Dof::ALL.into_iter().zip(equations.force) {
            let wanted = if dof.is_rotation() { Dimension::MOMENT } else { Dimension::FORCE };
            let found = force.dimension().unwrap();
            assert!(force.is_zero() || found == wanted, "{dof}: {found}");
        }
    }
}
