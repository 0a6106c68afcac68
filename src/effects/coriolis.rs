//! Coriolis and centripetal forces: the rows of −C(ν)ν, the Munk moment among them.
//!
//! ```text
//! −ν ×* π = −(ω × P, ω × L + v × P)      π = (P, L) the momentum, ν = (v, ω)
//! surge: + m_v v r      sway: − m_u u r      yaw: − (m_v − m_u) u v, the Munk moment      (planar, diagonal inertia)
//! ```
//!
//! *Tied*: the coefficients are those of the momentum, nothing is left to find, and the three terms together do no
//! work. *Free*: each row has one coefficient of its own for its leading product, as the paper's k_uv, identified apart
//! from m_v − m_u. Kirchhoff (1869); Fossen (2021), ch. 6; Avila et al. (2013), eq. 28.

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

/// Leading product νⱼ νₖ of each row, its sign, and the name of its coefficient.
const LEADING: [(f64, Dof, Dof, &str); 6] = [
    (1.0, Dof::Sway, Dof::Yaw, "k_vr"),
    (-1.0, Dof::Surge, Dof::Yaw, "k_ur"),
    (1.0, Dof::Surge, Dof::Pitch, "k_uq"),
    (-1.0, Dof::Sway, Dof::Heave, "k_vw"),
    (-1.0, Dof::Heave, Dof::Surge, "k_wu"),
    (-1.0, Dof::Surge, Dof::Sway, "k_uv"),
];

/// The products νⱼ νₖ in a row of −C(ν)ν with a diagonal inertia: ω × P in the rows of force, ω × L + v × P in those of
/// moment.
pub fn products(row: Dof) -> [[Dof; 2]; 2] {
    let i = row.index() % 3;
    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
    let (v, omega) = (&Dof::ALL[..3], &Dof::ALL[3..]);
    if row.is_rotation() { [[v[j], v[k]], [omega[j], omega[k]]] } else { [[omega[j], v[k]], [omega[k], v[j]]] }
}

impl Effect for CoriolisRow {
    fn about(&self) -> About<'_> {
        const IDS: [&str; 6] =
            ["coriolis_surge", "coriolis_sway", "coriolis_heave", "coriolis_roll", "coriolis_pitch", "coriolis_yaw"];
        const FORMULAS: [&str; 6] = [
            "+ m_v v r",
            "− m_u u r",
            "+ m_u u q",
            "− (m_w − m_v) v w",
            "− (m_u − m_w) w u",
            "− k_uv u v, k_uv = m_v − m_u",
        ];
        const SCOPES: [&[Dof]; 6] = [
            &[Dof::Surge, Dof::Sway, Dof::Yaw],
            &[Dof::Surge, Dof::Sway, Dof::Yaw],
            &[Dof::Surge, Dof::Heave, Dof::Pitch],
            &[Dof::Sway, Dof::Heave, Dof::Roll],
            &[Dof::Surge, Dof::Heave, Dof::Pitch],
            &[Dof::Surge, Dof::Sway, Dof::Yaw],
        ];
        About {
            id: IDS[self.row.index()],
            family: Family::Body,
            scope: Scope::Vehicle(SCOPES[self.row.index()]),
            formula: FORMULAS[self.row.index()],
            meaning: "A row of −C(ν)ν: force from the turning of the axes in which momentum is counted.",
            source: "Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 6",
            shown_by: "turns with speed, as in a zig-zag",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        if self.coriolis == Coriolis::Tied {
            return Vec::new();
        }
        let (sign, j, k, name) = LEADING[self.row.index()];
        let product = velocity(j).times(velocity(k));
        let sname = format!("{}_{}", self.row.sname(), &name[2..]);
        let spec = ParameterSpec::linear(name, force(self.row).over(product));
        // lift and Munk moment are one regressor: SNAME's name of it; it has the other sign where the row has a minus
        vec![if sign > 0.0 { spec } else { spec.sname(sname) }]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let row = self.row.index();
        match theta {
            [] => wrench[row] -= row_of_coriolis(row, &at.nu_r, &at.momentum),
            [coefficient, ..] => {
                let (sign, j, k, _) = LEADING[row];
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

    #[test]
    fn the_leading_product_is_one_of_the_row() {
        for row in Dof::ALL {
            let (_, j, k, _) = LEADING[row.index()];
            let of_row = products(row);
            assert!(of_row.contains(&[j, k]) || of_row.contains(&[k, j]), "{row}: {of_row:?}");
        }
        assert_eq!(products(Dof::Surge), [[Dof::Pitch, Dof::Heave], [Dof::Yaw, Dof::Sway]]);
        assert_eq!(products(Dof::Yaw), [[Dof::Surge, Dof::Sway], [Dof::Roll, Dof::Pitch]]);
    }
}
