//! A steady current.
//!
//! ```text
//! M_RB ν̇ + C_RB(ν)ν + M_A ν̇_r + C_A(ν_r)ν_r + D(ν_r)ν_r + g(η) = τ
//! ν_r = ν − ν_c,   ν_c = (v_c, 0),   v_c = Rᵀ(V_N, V_E, 0)
//! ```
//!
//! V_N, V_E: velocity of the water north and east, m/s, constant in the earth frame. Fossen (2021), ch. 10.
//!
//! The dry mass need not be known separately. V is constant, so that v̇_c = −ω × v_c, and with the
//! centre of gravity at r_g
//!
//! ```text
//! M_RB ν̇_c          = (−m ω × v_c,  −m r_g × (ω × v_c))
//! C_RB(ν)ν           = ( m ω × (v + ω × r_g),  m r_g × (ω × v) + ω × I ω)  linear in v for a given ω, hence
//! C_RB(ν)ν           = C_RB(ν_r)ν_r + (m ω × v_c,  m r_g × (ω × v_c))
//! M_RB ν̇ + C_RB(ν)ν = M_RB ν̇_r + C_RB(ν_r)ν_r                          exactly, in six degrees of freedom
//! ```
//!
//! (Fossen's property 10.1; Galilean invariance). Dry and added inertia enter only as their sum
//! M = M_RB + M_A: M ν̇_r + C(ν_r)ν_r + D(ν_r)ν_r + g(η) = τ, ν̇ = ν̇_r + v̇_c. A vehicle that
//! drifts with the water stays at rest in it, however it turns. Forces of the water are formulas of
//! ν_r; an effect that is tied to the ground says so ([`Effect::tied_to_ground`]).

use super::{About, Effect, Family, Instant, ParameterSpec, Place, Scope};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Id, as in a campaign file.
pub const ID: &str = "current";

/// Water that moves over ground.
#[derive(Debug)]
pub struct Current;

impl Effect for Current {
    fn about(&self) -> About<'_> {
        About {
            id: ID,
            family: Family::Environment,
            scope: Scope::Vehicle(&[Dof::Surge]),
            formula: "M ν̇_r + C(ν_r)ν_r + D(ν_r)ν_r = τ, ν_r = ν − Rᵀ(V_N, V_E, 0)",
            meaning: "Water that moves over ground: inertia, drag and Coriolis terms depend on the velocity through \
                      the water.",
            source: "Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), ch. 10",
            shown_by: "several headings, or speeds both well above and below the current",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        ["V_N", "V_E"].map(|name| ParameterSpec::shape(name, Dimension::VELOCITY, &[0.0], -5.0, 5.0)).to_vec()
    }

    fn pose(&self) -> &'static [&'static str] {
        &["psi"]
    }

    fn water<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>]) -> Option<[Expr<'g>; 3]> {
        Some([theta[0], theta[1], at.graph.zero()])
    }
}
