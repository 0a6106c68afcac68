//! Ids of effects that other modules need by name. Each is defined only in the file of its effect.
//!
//! The kind of an effect (an inertia, a drag, a righting moment) is derived from its formulas
//! ([`crate::chain::nature`]). An id is for what concerns one effect alone: the masses of a stage,
//! the columns of a table, a format that has a field for it.

use super::restoring_force::RestoringForce;
use super::restoring_moment::RestoringMoment;
use super::{CoriolisRow, Effect, coriolis::Coriolis, fin_drag::FinDrag, fin_lift::Fin, fin_lift::FinLift};
use crate::frame::Dof;

pub use super::added_mass_amplitude::ID as ADDED_MASS_AMPLITUDE;
pub use super::added_mass_coupling::ID as ADDED_MASS_COUPLING;
pub use super::bias::ID as BIAS;
pub use super::drag_asymmetry::ID as DRAG_ASYMMETRY;
pub use super::inertia::ID as INERTIA;
pub use super::linear_drag::ID as LINEAR_DRAG;
pub use super::mixed_drag::ID as MIXED_DRAG;
pub use super::quadratic_drag::ID as QUADRATIC_DRAG;
pub use super::sensor_delay::ID as SENSOR_DELAY;
pub use super::thrust_advance_loss::ID as THRUST_ADVANCE_LOSS;
pub use super::thrust_delay::ID as THRUST_DELAY;
pub use super::thrust_interaction_loss::ID as THRUST_INTERACTION_LOSS;
pub use super::thrust_lag::ID as THRUST_LAG;
pub use super::trim_offset::ID as TRIM_OFFSET;

/// Effects of every model: the equation of one motion, (3) of Avila et al. (2013).
pub const BALANCE: [&str; 3] = [INERTIA, LINEAR_DRAG, QUADRATIC_DRAG];

/// Effects that are used most, in the order of the chain.
pub const ASKED_FOR: [&str; 8] = [
    "coriolis_yaw",
    super::cubic_drag::ID,
    BIAS,
    THRUST_INTERACTION_LOSS,
    THRUST_LAG,
    super::current::ID,
    super::tether_spring::ID,
    super::sensor_gyro_bias::ID,
];

/// Id of the row of −C(ν)ν in `dof`: `coriolis_yaw`.
pub fn coriolis(dof: Dof) -> String {
    CoriolisRow { row: dof, coriolis: Coriolis::Tied }.about().id.to_string()
}

/// Id of the restoring effect in `dof`: `restoring_heave` is the net weight, `restoring_roll` the
/// righting moment; yaw has none.
pub fn restoring(dof: Dof) -> Option<String> {
    match dof {
        Dof::Surge | Dof::Sway | Dof::Heave => Some(RestoringForce(dof).about().id.to_string()),
        Dof::Roll | Dof::Pitch => Some(RestoringMoment(dof).about().id.to_string()),
        Dof::Yaw => None,
    }
}

/// The fins, each with its effects and the channel of its angle.
pub fn fins() -> [FinIds; 2] {
    let id = |effect: &dyn Effect| effect.about().id.to_string();
    [Fin::Rudder, Fin::SternPlane].map(|fin| {
        let [turns, across] = fin.moves();
        FinIds { channel: fin.channel(), turns, across, lift: id(&FinLift(fin)), drag: id(&FinDrag(fin)) }
    })
}

/// Ids and channel of a fin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FinIds {
    /// Channel of its angle, rad.
    pub channel: &'static str,
    /// Degree of freedom in which it turns the vehicle: yaw or pitch.
    pub turns: Dof,
    /// Degree of freedom in which it pushes the vehicle: sway or heave.
    pub across: Dof,
    /// Id of its lift.
    pub lift: String,
    /// Id of its drag.
    pub drag: String,
}
