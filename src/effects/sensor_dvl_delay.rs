//! A delay of the DVL.
//!
//! ```text
//! (u, v, w)_log(t) = (u, v, w)(t − T)
//! ```
//!
//! T: s. A ping takes time, and its report is stamped when it arrives. A gyro without delay
//! separates it from a delay of the commands, which all sensors show. It is modelled by Padé's
//! approximation of e^(−sT) of order (1, 1): the amplitude is exact, and the phase error at the
//! angular frequency ω is (ωT)³/12, a fiftieth of a degree for 0.2 s at a period of 8 s:
//!
//! ```text
//! ν_log = 2 z − ν,    (T/2) ż = ν − z
//! ```

use super::{About, Effect, Family, Instant, Logged, ParameterSpec, Place, Scope, Six};
use crate::symbolic::Expr;
use crate::units::Dimension;

/// Velocity that is logged later than the turn rates.
#[derive(Debug)]
pub struct SensorDvlDelay;

impl Effect for SensorDvlDelay {
    fn about(&self) -> About<'_> {
        About {
            id: "sensor_dvl_delay",
            family: Family::Sensor,
            scope: Scope::MOVES_AND_TURNS,
            formula: "(u, v, w)_log(t) = (u, v, w)(t − T)",
            meaning: "Velocity that is logged later than the turn rates.",
            source: "Kinsey, Eustice and Whitcomb, IFAC MCMC (2006), underwater navigation",
            shown_by: "turns and changes of speed, and a gyro without delay",
        }
    }

    fn parameters(&self, _: Place) -> Vec<ParameterSpec> {
        vec![ParameterSpec::shape("T_dvl", Dimension::TIME, &[0.1, 0.2, 0.4, 0.8], 0.05, 5.0)]
    }

    fn sense<'g>(&self, at: &Instant<'g>, _: Place, _: &[Expr<'g>], memory: &[Expr<'g>], logged: &mut Logged<'g>) {
        for (i, z) in at.translations().zip(memory) {
            logged.nu[i] += (*z - at.nu_logged[i]) * 2.0;
        }
    }

    fn memory<'g>(&self, at: &Instant<'g>, _: Place, _: &Six<'g>) -> Vec<Expr<'g>> {
        at.translations().map(|i| at.nu_logged[i]).collect()
    }

    fn memory_rate<'g>(
        &self,
        at: &Instant<'g>,
        _: Place,
        theta: &[Expr<'g>],
        memory: &[Expr<'g>],
        _: &Six<'g>,
    ) -> Vec<Expr<'g>> {
        at.translations().zip(memory).map(|(i, z)| (at.nu_logged[i] - *z) * 2.0 / theta[0]).collect()
    }
}
