//! Effects that the catalogue does not contain, to test the statements about a gap that nothing
//! explains.
//!
//! ```text
//! vortex_shedding   Y += c u² sin ϕ,   ϕ̇ = 2π St |u| / D                   St = 0.2
//! sloshing          X += m (ω² s + 2ζω ṡ),   ṡ = a − u,   ȧ = −ω² s − 2ζω (a − u)      ω = 2π/3 s, ζ = 0.05
//! power_drag@i      −d νᵢ √|νᵢ|                                            between linear and quadratic
//! ```
//!
//! u: surge; D: breadth; m and a: mass and velocity over ground of the water that sloshes along the
//! hull, s: its displacement from rest. Sources: Blevins, *Flow-Induced Vibration*, 2nd ed. (1990),
//! ch. 3; Ibrahim, *Liquid Sloshing Dynamics* (2005), ch. 5.

use std::f64::consts::TAU;

use crate::effects::{About, Effect, Family, Instant, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Strouhal number of a bluff body.
const STROUHAL: f64 = 0.2;
/// Period of the sloshing, s, and its damping ratio.
const SLOSHING: (f64, f64) = (3.0, 0.05);

/// A side force at the frequency of vortex shedding from the hull.
#[derive(Debug)]
pub struct VortexShedding;

impl Effect for VortexShedding {
    fn about(&self) -> About<'_> {
        About {
            id: "vortex_shedding",
            family: Family::Body,
            scope: Scope::Vehicle(&[Dof::Surge, Dof::Sway]),
            formula: "Y += c u² sin ϕ,   ϕ̇ = 2π St |u| / D",
            meaning: "A side force at the frequency at which vortices leave the hull.",
            source: "Blevins, Flow-Induced Vibration, 2nd ed. (1990), ch. 3",
            shown_by: "steady speed ahead",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        let per_length = Dimension::MASS.over(Dimension::LENGTH);
        vec![
            ParameterSpec::linear("c_vortex", per_length),
            ParameterSpec::shape("D_vortex", Dimension::LENGTH, &[0.5], 0.01, 10.0),
        ]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], memory: &[Expr<'g>], wrench: &mut Six<'g>) {
        let u = at.nu_r[Dof::Surge.index()];
        wrench[Dof::Sway.index()] += theta[0] * u * u * memory[0].sin();
    }

    fn memory<'g>(&self, at: &Instant<'g>, _: Place, _: &Six<'g>) -> Vec<Expr<'g>> {
        vec![at.graph.zero()]
    }

    fn memory_rate<'g>(
        &self,
        at: &Instant<'g>,
        _: Place,
        theta: &[Expr<'g>],
        _: &[Expr<'g>],
        _: &Six<'g>,
    ) -> Vec<Expr<'g>> {
        vec![at.nu_r[Dof::Surge.index()].abs() / theta[1] * (TAU * STROUHAL)]
    }
}

/// Water that sloshes in the hull along the surge axis.
#[derive(Debug)]
pub struct Sloshing;

impl Effect for Sloshing {
    fn about(&self) -> About<'_> {
        About {
            id: "sloshing",
            family: Family::Body,
            scope: Scope::Vehicle(&[Dof::Surge]),
            formula: "X += m (ω² s + 2ζω ṡ),   ṡ = a − u,   ȧ = −ω² s − 2ζω (a − u)",
            meaning: "Water that sloshes in the hull along the surge axis.",
            source: "Ibrahim, Liquid Sloshing Dynamics (2005), ch. 5",
            shown_by: "surge that changes near the period of the sloshing",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::linear("m_slosh", Dimension::MASS)]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, _: Place, theta: &[Expr<'g>], memory: &[Expr<'g>], wrench: &mut Six<'g>) {
        wrench[0] += -theta[0] * pull(at, memory);
    }

    fn memory<'g>(&self, at: &Instant<'g>, _: Place, _: &Six<'g>) -> Vec<Expr<'g>> {
        vec![at.unit(Dimension::LENGTH, 0.0), at.nu[0]]
    }

    fn memory_rate<'g>(
        &self,
        at: &Instant<'g>,
        _: Place,
        _: &[Expr<'g>],
        memory: &[Expr<'g>],
        _: &Six<'g>,
    ) -> Vec<Expr<'g>> {
        vec![memory[1] - at.nu[0], pull(at, memory)]
    }
}

/// Acceleration of the sloshing water, ȧ, m/s².
fn pull<'g>(at: &Instant<'g>, memory: &[Expr<'g>]) -> Expr<'g> {
    let (period, damping) = SLOSHING;
    let omega = at.unit(Dimension::RATE, TAU / period);
    -(omega * omega * memory[0]) - omega * (memory[1] - at.nu[0]) * (2.0 * damping)
}

/// Drag proportional to the power 1.5 of the speed.
#[derive(Debug)]
pub struct PowerDrag;

impl Effect for PowerDrag {
    fn about(&self) -> About<'_> {
        About {
            id: "power_drag",
            family: Family::Body,
            scope: Scope::Each(&Dof::ALL),
            formula: "−d νᵢ √|νᵢ|",
            meaning: "Drag in proportion to the power 1.5 of the speed.",
            source: "-",
            shown_by: "a wide range of speeds",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        // the unit of the power 1.5 has no integer exponents: the parameter is for speeds in m/s or
        // rad/s
        vec![ParameterSpec::linear("d_power", Dimension::ONE)]
    }

    fn wrench<'g>(&self, at: &Instant<'g>, place: Place, theta: &[Expr<'g>], _: &[Expr<'g>], wrench: &mut Six<'g>) {
        let i = place.here().index();
        let v = at.nu_r[i];
        wrench[i] -= theta[0] * v * v.abs().sqrt();
    }
}
