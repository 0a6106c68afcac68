//! What there is to say about estimates.

use super::super::codes;
use crate::finding::Finding;
use crate::model::{Model, Parameter};
use crate::vehicle::Vehicle;

/// Virtual mass over dry mass that no vehicle has: a flat plate that moves broadside drags some four times its own along.
const MOST_TIMES_DRY: f64 = 6.0;

/// The dry mass, kg, where `p` is an inertia of a translation, which cannot be below it: added mass is not negative.
pub(in crate::campaign) fn dry_mass(p: &Parameter, vehicle: &Vehicle) -> Option<f64> {
    vehicle.mass.filter(|_| p.effect == "inertia" && p.place.dof.is_some_and(|dof| !dof.is_rotation()))
}

/// Whether an estimate lies below `least` by more than two deviations.
pub(in crate::campaign) fn is_below(p: &Parameter, least: f64) -> bool {
    p.value < least - 2.0 * p.std.unwrap_or(0.0)
}

/// Says what cannot be, stands at a bound, or is hardly seen.
pub(super) fn judge(model: &Model, vehicle: &Vehicle, warnings: &mut Vec<Finding>) {
    for p in model.parameters.iter().filter(|p| !p.fixed) {
        let std = p.std.unwrap_or(0.0);
        let shown = format!("{} of `{}` = {:.4} ± {:.2} {}", p.spec.name, p.term, p.value, std, p.spec.dimension);
        let dry = dry_mass(p, vehicle);
        let zero = matches!(p.effect.as_str(), "inertia" | "linear_drag" | "quadratic_drag" | "cubic_drag");
        let least = dry.map(|mass| (mass, "the dry mass")).or(zero.then_some((0.0, "0")));
        if let Some((least, words)) = least.filter(|(least, _)| is_below(p, *least)) {
            let text = format!(
                "{shown} lies below {words} ({least}): a sign, a frame or the scale of thrust is wrong, or this data does not show it"
            );
            warnings.push(Finding::new(&codes::UNPHYSICAL, text));
        }
        if let Some(mass) = dry.filter(|mass| p.value - 2.0 * std > MOST_TIMES_DRY * mass) {
            let text = format!(
                "{shown} is {:.0} times the dry mass ({mass}): the scale of thrust is wrong, or this data does not show it",
                p.value / mass
            );
            warnings.push(Finding::new(&codes::UNPHYSICAL, text));
        }
        if p.value <= p.min || p.value >= p.max {
            warnings.push(Finding::new(&codes::AT_BOUND, format!("{shown} stands at its bound")));
        } else if std > p.value.abs() && !p.spec.name.starts_with("b_") {
            warnings.push(Finding::new(&codes::LOOSE, format!("{shown}: this data hardly shows it")));
        }
    }
}
