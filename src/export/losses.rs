//! Losses of thrust that belong to a model: transferred to a target, or refused.
//!
//! ```text
//! τᵢ = η_inter,i η_adv(|νᵢ|) τ_nom,i     (moments: |u|),     η_adv = max(slope |ν| + intercept, 0)
//! ```
//!
//! A model is fitted with effective forces, τ; commands are nominal forces, τ_nom. A target that is
//! code or a matrix applies the losses itself, so that its input is the command. A target of
//! coefficients alone has no place for them. The rule is that of
//! [`crate::procedure::acting_forces`] for runs that log forces of the vehicle.

use super::number::number;
use super::{ExportError, ExportOptions, Target};
use crate::campaign::file::CampaignFile;
use crate::frame::Dof;
use crate::thrust::advance::AdvanceLoss;
use crate::thrust::efficiency::{AdvanceSpeed, Efficiency};
use crate::thrust::thruster::Thruster;

/// Losses in body axes: factors between nominal and effective force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Losses {
    /// η_inter of each degree of freedom, 1.
    pub interaction: [f64; 6],
    /// Slope and intercept of η_adv; 0 and 1 without a loss.
    pub advance: [f64; 2],
    /// Whether the forces of the target are effective forces although the model has losses.
    pub acting: bool,
}

impl Losses {
    const NONE: Losses = Losses { interaction: [1.0; 6], advance: [0.0, 1.0], acting: false };

    /// Whether there are losses to transfer.
    pub fn any(&self) -> bool {
        *self != Losses { acting: self.acting, ..Losses::NONE }
    }

    /// Index of the velocity that is the advance speed of a degree of freedom.
    pub fn speed(row: usize) -> usize {
        if row < 3 { row } else { Dof::Surge.index() }
    }

    /// η of a row at its advance velocity, and ∂η/∂ν.
    pub fn at(&self, row: usize, velocity: f64) -> [f64; 2] {
        let [slope, intercept] = self.advance;
        let advance = slope * velocity.abs() + intercept;
        let rate = if advance > 0.0 { slope * velocity.signum() } else { 0.0 };
        [self.interaction[row] * advance.max(0.0), self.interaction[row] * rate]
    }

    /// The line about losses in the heading.
    pub fn told(&self) -> Option<String> {
        if self.acting {
            return Some(
                "Forces here are effective ones: whatever computes them must include the losses of thrust".into(),
            );
        }
        self.any().then(|| {
            let [slope, intercept] = self.advance;
            let inter = self.interaction.map(number).join(", ");
            format!(
                "Forces here are nominal: effective = eta_inter ({inter}) x eta_adv ({} |v| + {}) x nominal",
                number(slope),
                number(intercept)
            )
        })
    }
}

/// The losses of a model in the form of a target.
///
/// # Errors
/// [`ExportError::Losses`] if the target has no place for them.
pub(super) fn of(efficiency: &Efficiency, target: Target, options: &ExportOptions) -> Result<Losses, ExportError> {
    let lossless = efficiency.eta_adv.is_none_or(is_one) && efficiency.eta_inter.0.iter().all(|e| is(e.value, 1.0));
    if lossless {
        return Ok(Losses::NONE);
    }
    if options.acting || matches!(target, Target::Latex | Target::Csv) {
        return Ok(Losses { acting: options.acting, ..Losses::NONE });
    }
    let refused = |reason: String| Err(ExportError::Losses { losses: named(efficiency), reason });
    if !target.computes() {
        return refused(format!("`{}` cannot represent them", target.name()));
    }
    if let Some(entry) = efficiency.eta_inter.0.iter().find(|e| !e.thrusters.is_empty()) {
        return refused(format!(
            "eta_inter of {} depends on which thrusters run, which a force on the whole vehicle does not tell",
            entry.dof
        ));
    }
    if efficiency.eta_adv.is_some() && efficiency.advance_speed == AdvanceSpeed::ThrusterAxis {
        return refused(
            "eta_adv refers to the axis of each thruster, which a force on the whole vehicle does not tell".into(),
        );
    }
    let advance = efficiency.eta_adv.map_or([0.0, 1.0], |line| [line.slope, line.intercept]);
    Ok(Losses { interaction: Dof::ALL.map(|dof| efficiency.eta_inter.value(dof, &[])), advance, acting: false })
}

/// The factor by which a thruster of a campaign pushes less than at bollard pull, if it is the same
/// at any speed.
///
/// It is that of the degrees of freedom of the model: a small lever about another one is in no
/// force of the fit. For a thruster that pushes in none of them, such as a vertical one in a
/// horizontal-plane model, it is that of the degrees of freedom that eta_inter names.
///
/// # Errors
/// [`ExportError::Losses`] if there is no such factor.
pub(super) fn gain(campaign: &CampaignFile, of: &Thruster, options: &ExportOptions) -> Result<f64, ExportError> {
    if options.acting {
        return Ok(1.0);
    }
    let (efficiency, model) = (&campaign.efficiency, &campaign.model);
    let refused = |reason: String| Err(ExportError::Losses { losses: named(efficiency), reason });
    if efficiency.eta_adv.is_some_and(|line| !is(line.slope, 0.0)) {
        return refused("eta_adv falls with the speed, which the thruster of the target cannot represent".into());
    }
    let pushes = |t: &Thruster, dof: Dof| t.unit_wrench()[dof.index()].abs() > 1e-12;
    let where_it_pushes = |counts: &dyn Fn(Dof) -> bool| -> Vec<Dof> {
        Dof::ALL.into_iter().filter(|dof| pushes(of, *dof) && counts(*dof)).collect()
    };
    let mut dofs = where_it_pushes(&|dof| model.dofs.contains(&dof) && !model.undriven.contains(&dof));
    if dofs.is_empty() {
        dofs = where_it_pushes(&|dof| efficiency.eta_inter.0.iter().any(|entry| entry.dof == dof));
    }
    let values: Vec<(Dof, f64)> = dofs
        .into_iter()
        .map(|dof| {
            let running = campaign.thrusters.iter().filter(|t| pushes(t, dof));
            let group: Vec<&str> = running.map(|t| t.name.as_str()).collect();
            (dof, efficiency.eta_inter.value(dof, &group))
        })
        .collect();
    let first = values.first().map_or(1.0, |(_, value)| *value);
    if values.iter().any(|(_, value)| !is(*value, first)) {
        let each: Vec<String> = values.iter().map(|(dof, value)| format!("{dof} {}", number(*value))).collect();
        return refused(format!(
            "eta_inter differs between the degrees of freedom that thruster {:?} pushes in ({}), so it is not one \
             factor of its thrust",
            of.name,
            each.join(", ")
        ));
    }
    Ok(first * efficiency.eta_adv.map_or(1.0, |line| line.intercept))
}

/// The losses in words: `eta_inter of surge 0.97, eta_adv -0.1946 |v| + 0.9967`.
pub(super) fn named(efficiency: &Efficiency) -> String {
    let inter = efficiency.eta_inter.0.iter().map(|e| match e.thrusters.as_slice() {
        [] => format!("eta_inter of {} {}", e.dof, number(e.value)),
        names => format!("eta_inter of {} with {} {}", e.dof, names.join("+"), number(e.value)),
    });
    let advance = efficiency.eta_adv.map(|a| format!("eta_adv {} |v| + {}", number(a.slope), number(a.intercept)));
    inter.chain(advance).collect::<Vec<_>>().join(", ")
}

fn is_one(line: AdvanceLoss) -> bool {
    is(line.slope, 0.0) && is(line.intercept, 1.0)
}

fn is(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-12
}

#[cfg(test)]
mod tests {
    use super::*;

    fn efficiency(text: &str) -> Efficiency {
        toml::from_str(text).unwrap()
    }

    #[test]
    fn a_target_that_computes_carries_what_one_of_coefficients_refuses() {
        let given =
            efficiency("eta_inter = { surge = 0.9 }\neta_adv = { slope = -0.2, intercept = 1.0, valid = [0, 1] }");
        let carried = of(&given, Target::FossenPython, &ExportOptions::default()).unwrap();
        // 0.9 (1 − 0.2·0.5) and its slope; for a moment the speed ahead counts
        let [eta, rate] = carried.at(0, -0.5);
        assert!((eta - 0.81).abs() < 1e-12 && (rate - 0.18).abs() < 1e-12);
        assert_eq!((Losses::speed(1), Losses::speed(5)), (1, 0));
        let refused = of(&given, Target::Gazebo, &ExportOptions::default()).unwrap_err().to_string();
        assert!(refused.contains("eta_inter of surge 0.9") && refused.contains("--acting"), "{refused}");
        let options = ExportOptions { acting: true, ..ExportOptions::default() };
        let acting = of(&given, Target::Gazebo, &options).unwrap();
        assert!(!acting.any() && acting.told().unwrap().contains("effective"));
        assert_eq!(of(&Efficiency::default(), Target::Gazebo, &ExportOptions::default()).unwrap(), Losses::NONE);
    }

    #[test]
    fn losses_of_single_thrusters_are_no_force_of_the_vehicle() {
        let groups = efficiency("eta_inter = [{ dof = \"surge\", thrusters = [\"a\", \"b\"], value = 0.9 }]");
        assert!(of(&groups, Target::FossenMatlab, &ExportOptions::default()).is_err());
        let axis = efficiency(
            "eta_adv = { slope = -0.2, intercept = 1.0, valid = [0, 1] }\nadvance_speed = \"thruster_axis\"",
        );
        assert!(of(&axis, Target::FossenMatlab, &ExportOptions::default()).is_err());
    }
}
