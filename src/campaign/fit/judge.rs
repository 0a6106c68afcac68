//! Findings about estimates.

use super::super::codes;
use crate::effects::id;
use crate::finding::Finding;
use crate::model::{Model, Parameter};
use crate::vehicle::Vehicle;
use crate::wording::measured;

/// Ratio of virtual to dry mass that no vehicle exceeds: a flat plate that moves broadside has an
/// added mass of about four times its own mass.
const MOST_TIMES_DRY: f64 = 6.0;

/// Returns the dry mass, kg, if `p` is an inertia of a translation, which cannot be below it: added
/// mass is not negative.
pub(in crate::campaign) fn dry_mass(p: &Parameter, vehicle: &Vehicle) -> Option<f64> {
    vehicle.mass.filter(|_| p.effect == id::INERTIA && p.place.dof.is_some_and(|dof| !dof.is_rotation()))
}

/// Whether an estimate lies below `least` by more than two standard deviations.
pub(in crate::campaign) fn is_below(p: &Parameter, least: f64) -> bool {
    p.value < least - 2.0 * p.std.unwrap_or(0.0)
}

/// Adds findings about estimates that are impossible, at a bound, or hardly determined. If the fit
/// did not converge, the text says so.
pub(super) fn judge(model: &Model, vehicle: &Vehicle, converged: bool, warnings: &mut Vec<Finding>) {
    let mark = if converged { "" } else { " (not converged)" };
    for p in model.parameters.iter().filter(|p| !p.fixed) {
        let std = p.std.unwrap_or(0.0);
        let shown = format!("{} of `{}` = {} {}{mark}", p.spec.name, p.term, measured(p.value, std), p.spec.dimension);
        let dry = dry_mass(p, vehicle);
        let zero = p.spec.least >= 0.0;
        let least = dry.map(|mass| (mass, "the dry mass")).or(zero.then_some((0.0, "0")));
        if let Some((least, words)) = least.filter(|(least, _)| is_below(p, *least)) {
            let text = format!(
                "{shown} lies below {words} ({least}): a sign, a frame or the scale of thrust is wrong, or this data \
                 does not determine it"
            );
            warnings.push(Finding::new(&codes::UNPHYSICAL, text));
        }
        if let Some(mass) = dry.filter(|mass| p.value - 2.0 * std > MOST_TIMES_DRY * mass) {
            let text = format!(
                "{shown} is {:.0} times the dry mass ({mass}): the scale of thrust is wrong, or this data does not \
                 determine it",
                p.value / mass
            );
            warnings.push(Finding::new(&codes::UNPHYSICAL, text));
        }
        if p.value <= p.min || p.value >= p.max {
            warnings.push(Finding::new(&codes::AT_BOUND, format!("{shown} stands at its bound")));
        } else if std > p.per_run.iter().fold(p.value.abs(), |most, x| most.max(x.abs())) && p.effect != id::BIAS {
            warnings.push(Finding::new(&codes::LOOSE, format!("{shown}: this data hardly determines it")));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::frame::Dof;

    fn said(value: f64, std: f64, converged: bool) -> Vec<Finding> {
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        model.set("linear_drag@surge", 20.0);
        let inertia = model.parameter_of("inertia@surge").unwrap();
        (model.parameters[inertia].value, model.parameters[inertia].std) = (value, Some(std));
        let mut warnings = Vec::new();
        let vehicle = Vehicle { mass: Some(100.0), ..Vehicle::default() };
        judge(&model, &vehicle, converged, &mut warnings);
        warnings
    }

    #[test]
    fn a_mass_below_the_dry_one_or_many_times_it_is_told() {
        assert_eq!(said(180.0, 5.0, true), [], "nearly the dry mass again as added mass");
        let below = said(60.0, 5.0, true);
        assert!(below[0].code == "M102" && below[0].message.contains("lies below the dry mass (100)"), "{below:?}");
        let above = said(1900.0, 50.0, true);
        assert!(above[0].code == "M102" && above[0].message.contains("is 19 times the dry mass (100)"), "{above:?}");
        assert_eq!(said(95.0, 5.0, true), [], "below it by chance");
    }

    #[test]
    fn a_deviation_of_a_fit_that_did_not_converge_is_marked() {
        let marked = said(1900.0, 50.0, false);
        assert!(marked[0].message.contains("± 50 kg (not converged)"), "{marked:?}");
        assert!(!said(1900.0, 50.0, true)[0].message.contains("not converged"));
    }
}
