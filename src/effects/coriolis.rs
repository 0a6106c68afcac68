//! Coriolis and centripetal forces: the rows of −C(ν)ν, the Munk moment among them.
//!
//! ```text
//! −ν ×* π = −(ω × P, ω × L + v × P)      π = (P, L) the momentum, ν = (v, ω)
//! surge: + m_v v r − m_w w q      sway: − m_u u r + m_w w p      yaw: − (m_v − m_u) u v − …, the Munk moment
//!                                                                                     (diagonal inertia)
//! ```
//!
//! *Tied*: the coefficients are those of the momentum; there is no parameter to identify, and the
//! terms together do no work. *Free*: each row has one coefficient of its own for its leading
//! product, as the paper's k_uv, identified separately from m_v − m_u. Kirchhoff (1869); Fossen
//! (2021), ch. 6; Avila et al. (2013), eq. 28.

use super::parameter::{force, velocity};
use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use serde::{Deserialize, Serialize};

/// Where the coefficients of the Coriolis terms come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Coriolis {
    /// From the inertias.
    #[default]
    Tied,
    /// Each row has its own.
    Free,
}

/// One row of −C(ν)ν.
#[derive(Debug)]
pub struct CoriolisRow {
    /// The degree of freedom of the row.
    pub row: Dof,
    /// Tied or free.
    pub coriolis: Coriolis,
}

/// A row of −C(ν)ν with a diagonal inertia.
struct Row {
    id: &'static str,
    /// The row's own degree of freedom and those of each of its two products, the leading one
    /// first. A model has the row if it has one of its products: in the vertical plane as in the
    /// horizontal one.
    sets: [&'static [Dof]; 2],
    /// The products as text: of ω × P in the rows of force, of v × P and ω × L in those of moment.
    parts: [&'static str; 2],
    whole: &'static str,
    /// The leading product with a coefficient of its own.
    free: &'static str,
}

macro_rules! row {
    ($id:literal, $own:ident; $j:ident, $k:ident, $first:literal; $l:ident, $m:ident, $second:literal; $free:literal) => {
        Row {
            id: concat!("coriolis_", $id),
            sets: [&[Dof::$own, Dof::$j, Dof::$k], &[Dof::$own, Dof::$l, Dof::$m]],
            parts: [$first, $second],
            whole: concat!($first, " ", $second),
            free: $free,
        }
    };
}

#[rustfmt::skip]
const ROWS: [Row; 6] = [
    row!("surge", Surge; Sway, Yaw, "+ m_v v r"; Heave, Pitch, "− m_w w q"; "+ k_vr v r, k_vr = m_v"),
    row!("sway", Sway; Surge, Yaw, "− m_u u r"; Heave, Roll, "+ m_w w p"; "− k_ur u r, k_ur = m_u"),
    row!("heave", Heave; Surge, Pitch, "+ m_u u q"; Sway, Roll, "− m_v v p"; "+ k_uq u q, k_uq = m_u"),
    row!("roll", Roll; Sway, Heave, "− (m_w − m_v) v w"; Pitch, Yaw, "− (I_r − I_q) q r"; "− k_vw v w, k_vw = m_w − m_v"),
    row!("pitch", Pitch; Heave, Surge, "− (m_u − m_w) w u"; Yaw, Roll, "− (I_p − I_r) r p"; "− k_wu w u, k_wu = m_u − m_w"),
    row!("yaw", Yaw; Surge, Sway, "− (m_v − m_u) u v"; Roll, Pitch, "− (I_q − I_p) p q"; "− k_uv u v, k_uv = m_v − m_u"),
];

impl Row {
    /// Indices of its products in a model of these degrees of freedom.
    fn standing(&self, dofs: &[Dof]) -> impl Iterator<Item = usize> {
        (0..2).filter(|k| self.sets[*k].iter().all(|d| dofs.contains(d)))
    }

    /// Sign and factors of the leading product.
    fn leading(&self) -> (f64, Dof, Dof) {
        (if self.free.starts_with('−') { -1.0 } else { 1.0 }, self.sets[0][1], self.sets[0][2])
    }
}

/// Whether the leading product is the only product of a row in a model of these degrees of freedom:
/// its coefficient is then that of the whole row.
pub fn leading_is_all(row: Dof, dofs: &[Dof]) -> bool {
    ROWS[row.index()].standing(dofs).eq([0])
}

impl Effect for CoriolisRow {
    fn about(&self) -> About<'_> {
        let row = &ROWS[self.row.index()];
        let (formula, scope) = match self.coriolis {
            Coriolis::Tied => (row.whole, Scope::VehicleAny(&row.sets)),
            Coriolis::Free => (row.free, Scope::Vehicle(row.sets[0])),
        };
        About {
            id: row.id,
            family: Family::Body,
            scope,
            formula,
            meaning: "A row of −C(ν)ν: force from the rotation of the axes in which momentum is expressed.",
            source: "Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 6",
            shown_by: "turns with speed, as in a zig-zag",
        }
    }

    fn formula_in(&self, dofs: &[Dof]) -> String {
        let row = &ROWS[self.row.index()];
        match self.coriolis {
            Coriolis::Tied => row.standing(dofs).map(|k| row.parts[k]).collect::<Vec<_>>().join(" "),
            Coriolis::Free => row.free.into(),
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        if self.coriolis == Coriolis::Tied {
            return Vec::new();
        }
        let (sign, j, k) = ROWS[self.row.index()].leading();
        let letters = format!("{}{}", j.velocity(), k.velocity());
        let product = velocity(j).times(velocity(k));
        let spec = ParameterSpec::linear(format!("k_{letters}"), force(self.row).over(product));
        let sname = format!("{}_{letters}", self.row.sname());
        // lift and Munk moment are one regressor, which has a name by SNAME; a value under that
        // name has the opposite sign, which is right only for a row with a minus
        vec![if sign > 0.0 { spec } else { spec.sname(sname) }]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let row = self.row.index();
        match theta {
            [] => wrench[row] -= row_of_coriolis(row, &at.nu_r, &at.momentum),
            [coefficient, ..] => {
                let (sign, j, k) = ROWS[row].leading();
                wrench[row] += *coefficient * at.nu_r[j.index()] * at.nu_r[k.index()] * sign;
            }
        }
    }
}

/// Row of ν ×* π = (ω × P, ω × L + v × P).
fn row_of_coriolis<'g>(row: usize, nu: &Six<'g>, pi: &Six<'g>) -> Expr<'g> {
    let cross = |a: &[Expr<'g>], b: &[Expr<'g>], i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    };
    let (v, omega, p, l) = (&nu[..3], &nu[3..], &pi[..3], &pi[3..]);
    if row < 3 { cross(omega, p, row) } else { cross(omega, l, row - 3) + cross(v, p, row - 3) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Row i of ω × P holds ωⱼ vₖ and ωₖ vⱼ; of v × P and ω × L it holds vⱼ vₖ and ωⱼ ωₖ: i, j, k in turn.
    #[test]
    fn the_products_of_a_row_are_those_of_the_cross_product() {
        for dof in Dof::ALL {
            let i = dof.index() % 3;
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let products = if dof.is_rotation() { [[j, k], [j + 3, k + 3]] } else { [[j + 3, k], [k + 3, j]] };
            let sorted = |set: &[Dof]| {
                let mut pair: Vec<usize> = set[1..].iter().map(|d| d.index()).collect();
                pair.sort_unstable();
                pair
            };
            let row = &ROWS[dof.index()];
            assert!(row.sets.iter().all(|set| set[0] == dof));
            for product in products {
                let mut product = product.to_vec();
                product.sort_unstable();
                assert!(row.sets.iter().any(|set| sorted(set) == product), "{dof}: {product:?}");
            }
            let (sign, j, k) = row.leading();
            assert!(row.free.contains(&format!("k_{}{} ", j.velocity(), k.velocity())), "{dof}");
            assert_eq!(sign < 0.0, row.parts[0].starts_with('−'), "{dof}");
        }
    }

    #[test]
    fn a_row_stands_wherever_one_of_its_products_does() {
        let vertical = [Dof::Surge, Dof::Heave, Dof::Pitch];
        let written = |row, dofs: &[Dof]| CoriolisRow { row, coriolis: Coriolis::Tied }.formula_in(dofs);
        assert_eq!(written(Dof::Surge, &vertical), "− m_w w q");
        assert_eq!(written(Dof::Surge, &[Dof::Surge, Dof::Sway, Dof::Yaw]), "+ m_v v r");
        assert_eq!(written(Dof::Yaw, &vertical), "");
        let of = |row, coriolis| crate::model::places_of(&CoriolisRow { row, coriolis }, &vertical).len();
        assert_eq!((of(Dof::Surge, Coriolis::Tied), of(Dof::Surge, Coriolis::Free)), (1, 0));
        assert_eq!((of(Dof::Pitch, Coriolis::Tied), of(Dof::Pitch, Coriolis::Free)), (1, 1));
        assert_eq!(of(Dof::Sway, Coriolis::Tied), 0);
        assert!(!leading_is_all(Dof::Surge, &vertical) && leading_is_all(Dof::Pitch, &vertical));
        assert!(!leading_is_all(Dof::Pitch, &Dof::ALL));
    }
}
