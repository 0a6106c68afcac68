//! A delay of the position.
//!
//! ```text
//! (x, y)_log(t) = (x, y)(t − T)
//! ```
//!
//! T: s. An acoustic fix travels to the ship and back before it is logged, and a GPS receiver
//! computes. The position must be measured independently of the velocities: one that is integrated
//! from them is as late as they are. With the velocity over ground ẋ known, the delay is modelled by
//! Padé's approximation of e^(−sT) of order (2, 2), whose phase error is (ωT)⁵/720:
//!
//! ```text
//! x_log = x − T c,    T ė = ẋ − c,    T ċ = 12 e − 6 c            c = ẋ and e = ẋ/2 in steady motion
//! ```

use super::{About, Effect, Family, Instant, Logged, ParameterSpec, Place, Scope, Six};
use crate::frame::Dof;
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Position that is logged later than velocities and angles.
#[derive(Debug)]
pub struct SensorPositionDelay;

impl Effect for SensorPositionDelay {
    fn about(&self) -> About<'_> {
        About {
            id: "sensor_position_delay",
            family: Family::Sensor,
            scope: Scope::VehicleAny(&[&[Dof::Surge], &[Dof::Sway]]),
            formula: "(x, y)_log(t) = (x, y)(t − T)",
            meaning: "Position that is logged later than velocities and angles.",
            source: "Kinsey, Eustice and Whitcomb, IFAC MCMC (2006), underwater navigation",
            shown_by: "a position that is independent of the DVL, and changes of speed or course",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::shape("T_xy", Dimension::TIME, &[0.2, 0.5, 1.0, 2.0], 0.05, 10.0)]
    }

    fn pose(&self) -> &'static [&'static str] {
        &["x", "y"]
    }

    fn sense<'g>(&self, _: &Instant<'g>, _: Place, theta: &[Expr<'g>], memory: &[Expr<'g>], logged: &mut Logged<'g>) {
        for (position, state) in logged.position.iter_mut().zip(memory.chunks_exact(2)) {
            *position -= theta[0] * state[1];
        }
    }

    fn memory<'g>(&self, at: &Instant<'g>, _: Place, _: &Six<'g>) -> Vec<Expr<'g>> {
        at.over_ground()[..2].iter().flat_map(|rate| [*rate * 0.5, *rate]).collect()
    }

    fn memory_rate<'g>(
        &self,
        at: &Instant<'g>,
        _: Place,
        theta: &[Expr<'g>],
        memory: &[Expr<'g>],
        _: &Six<'g>,
    ) -> Vec<Expr<'g>> {
        let one = |(rate, state): (&Expr<'g>, &[Expr<'g>])| {
            [(*rate - state[1]) / theta[0], (state[0] * 12.0 - state[1] * 6.0) / theta[0]]
        };
        at.over_ground()[..2].iter().zip(memory.chunks_exact(2)).flat_map(one).collect()
    }
}
