//! A user's own effect: a force or moment in proportion to a formula of states, commands, channels
//! and time.
//!
//! ```text
//! wᵢ += k f(u, v, …, psi, tau_u, …, t, channels)
//! ```
//!
//! k: the only parameter, in the unit that makes the product a force (N) or a moment (N·m).

use super::instant::is_channel;
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::formula::Formula;
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// A force in one degree of freedom by a user's formula.
#[derive(Debug, Clone)]
pub struct FormulaEffect {
    id: String,
    dof: Dof,
    formula: Formula,
    unit: Dimension,
}

/// The places of [`FormulaEffect`], one list for each degree of freedom.
const ONLY: [[Dof; 1]; 6] = [[Dof::Surge], [Dof::Sway], [Dof::Heave], [Dof::Roll], [Dof::Pitch], [Dof::Yaw]];

impl FormulaEffect {
    /// The effect `id` in the balance of `dof`; `unit` is that of its parameter.
    pub fn new(id: &str, dof: Dof, formula: Formula, unit: Dimension) -> FormulaEffect {
        FormulaEffect { id: id.to_string(), dof, formula, unit }
    }
}

impl Effect for FormulaEffect {
    fn about(&self) -> About<'_> {
        About {
            id: &self.id,
            family: Family::Body,
            scope: Scope::Each(&ONLY[self.dof.index()]),
            formula: self.formula.text(),
            meaning: "A user's own effect.",
            source: "the campaign",
            shown_by: "a formula that varies differently from those of the other effects",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear(format!("k_{}", self.id), self.unit)]
    }

    fn channels(&self, _: Place) -> Vec<String> {
        self.formula.names().into_iter().filter(|name| is_channel(name)).map(str::to_string).collect()
    }

    fn wrench<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        wrench[self.dof.index()] += theta[0] * self.formula.lower(at.graph, &|name| at.named(name));
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::sync::Arc;

    use super::*;
    use crate::chain::{Available, assemble};
    use crate::effects::Coriolis;
    use crate::model::Model;
    use crate::symbolic::{Graph, Leaf};

    #[test]
    fn a_formula_is_an_effect_like_any_other() {
        let formula = Formula::parse("wind_speed^2 * cos(wind_dir - psi) + 0*tau_r*u").unwrap();
        let sail = FormulaEffect::new("sail", Dof::Surge, formula, Dimension::new(1, -1, 0));
        assert_eq!(sail.channels(Place::at(Dof::Surge)), ["wind_dir", "wind_speed"]);
        let mut model = Model::with_effects(&[Dof::Surge, Dof::Yaw], Coriolis::Tied, &["inertia"]).unwrap();
        assert!(model.add(Arc::new(sail.clone()), Place::at(Dof::Yaw)).is_err());
        let term = model.add(Arc::new(sail), Place::at(Dof::Surge)).unwrap();
        assert_eq!(model.terms[term].name(), "sail@surge");
        let channels: BTreeSet<String> = ["wind_speed", "wind_dir", "tau_u"].map(String::from).into();
        let graph = Graph::new();
        let equations = assemble(&graph, &model, &Available { channels, ..Available::default() });
        let values = [("wind_speed", 3.0), ("wind_dir", 0.7), ("tau_u", 5.0)];
        let read = |leaf| match leaf {
            Leaf::State(11) => 0.2,
            Leaf::Parameter(2) => 0.4,
            Leaf::Input(k) => {
                let name = equations.inputs[usize::from(k)].as_str();
                values.iter().find(|(known, _)| *known == name).map_or(0.0, |(_, value)| *value)
            }
            _ => 0.0,
        };
        let force = equations.force[0].evaluate(&read);
        assert!((force - (5.0 + 0.4 * 9.0 * f64::cos(0.5))).abs() < 1e-14);
    }

    #[test]
    fn a_command_of_a_degree_of_freedom_that_is_not_modelled_is_read() {
        let effect = FormulaEffect::new("leak", Dof::Surge, Formula::parse("tau_r").unwrap(), Dimension::RATE);
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia"]).unwrap();
        model.add(Arc::new(effect), Place::at(Dof::Surge)).unwrap();
        let channels: BTreeSet<String> = ["tau_r".to_string()].into();
        let graph = Graph::new();
        let equations = assemble(&graph, &model, &Available { channels, ..Available::default() });
        assert_eq!(equations.force[0].evaluate(&|_| 3.0), 9.0);
    }
}
