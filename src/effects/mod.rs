//! The catalogue of effects on the chain command → actuator → body → sensor → log.
//!
//! The equation of motion in one degree of freedom i, with the momentum π and the wrench w, the
//! sums over the effects of the model, is
//!
//! ```text
//! dπᵢ/dt = wᵢ + τᵢ          πᵢ = Σ θ pᵢ(ν),   wᵢ = Σ θ wᵢ(ν, η, …)
//!                           τ: force of the actuators under the command
//! ```
//!
//! An effect is one file with its formula, its parameters with their units, and its source. It is
//! written once, as formulas on the symbols of an [`Instant`]; the regressor integrates it, the
//! simulator applies it, the discovery tries it. A new effect is a new file here and one line in
//! [`catalogue`].

mod added_mass_amplitude;
mod added_mass_coupling;
mod bias;
mod common_name;
mod coriolis;
mod coulomb_friction;
mod cross_drag;
mod cubic_drag;
mod current;
mod drag_asymmetry;
mod each_run;
mod earth_force;
mod effect;
mod even_drag;
mod fin_drag;
mod fin_lift;
mod fluid_memory;
mod formula_effect;
pub mod id;
mod inertia;
mod instant;
mod lift_moment;
mod linear_cross_damping;
mod linear_drag;
mod look_alikes;
mod mixed_drag;
mod name;
mod observer;
mod parameter;
mod propeller_advance;
mod quadratic_drag;
mod restoring_force;
mod restoring_moment;
mod search;
mod sensor_clock_drift;
mod sensor_compass_deviation;
mod sensor_compass_magnetic;
mod sensor_delay;
mod sensor_dvl_delay;
mod sensor_dvl_lever_arm;
mod sensor_dvl_misalignment;
mod sensor_dvl_scale;
mod sensor_gyro_bias;
mod sensor_gyro_lag;
mod sensor_gyro_scale;
mod sensor_heading_offset;
mod sensor_position_delay;
mod sensor_position_lever_arm;
mod sensor_tilt_offset;
mod since;
mod single_thruster;
mod supply_voltage;
mod tether_drag;
mod tether_spring;
mod thrust_advance_loss;
mod thrust_crosstalk;
mod thrust_deadband;
mod thrust_delay;
mod thrust_interaction_loss;
mod thrust_lag;
mod thrust_reverse_loss;
mod thrust_saturation;
mod thruster_advance_loss;
mod thruster_fault;
mod thruster_loss;
mod thruster_swap;
mod trim_offset;
mod wave;

use std::sync::Arc;

pub use common_name::{common_name, common_name_at, named};
pub use coriolis::{Coriolis, CoriolisRow, leading_is_all};
pub use effect::{About, CommandDelay, Effect, Family, Place, Scope};
pub use formula_effect::FormulaEffect;
pub use instant::{Instant, Logged, Six, channel};
pub use look_alikes::separating;
pub use name::{EffectName, EffectNameError};
pub use observer::Observer;
pub use parameter::{GridUnit, ParameterKind, ParameterSpec};
pub use search::{meant, search};
pub use since::{Event, Since};
pub use single_thruster::SingleThruster;
pub use thruster_advance_loss::ThrusterAdvanceLoss;
pub use thruster_loss::ThrusterLoss;
pub use thruster_swap::ThrusterSwap;

use crate::frame::Dof;

/// The effect of a gyro behind a low pass on the turn rates.
pub fn gyro_lag() -> Arc<dyn Effect> {
    Arc::new(sensor_gyro_lag::SensorGyroLag)
}

/// The list of all effects, in the order of the chain: body, actuator, environment, sensor.
/// `coriolis` says whether the Coriolis terms take their coefficients from the inertias or have
/// their own.
pub fn catalogue(coriolis: Coriolis) -> Vec<Arc<dyn Effect>> {
    let mut list: Vec<Arc<dyn Effect>> = vec![
        Arc::new(inertia::Inertia),
        Arc::new(added_mass_coupling::AddedMassCoupling),
        Arc::new(added_mass_amplitude::AddedMassAmplitude),
        Arc::new(fluid_memory::FluidMemory),
    ];
    list.extend(Dof::ALL.map(|row| Arc::new(CoriolisRow { row, coriolis }) as Arc<dyn Effect>));
    list.extend([
        Arc::new(linear_drag::LinearDrag) as Arc<dyn Effect>,
        Arc::new(quadratic_drag::QuadraticDrag),
        Arc::new(cubic_drag::CubicDrag),
        Arc::new(drag_asymmetry::DragAsymmetry),
        Arc::new(coulomb_friction::CoulombFriction),
        Arc::new(linear_cross_damping::LinearCrossDamping),
        Arc::new(cross_drag::CrossDrag),
        Arc::new(even_drag::EvenDrag),
        Arc::new(mixed_drag::MixedDrag),
        Arc::new(lift_moment::LiftMoment),
        Arc::new(restoring_force::RestoringForce(Dof::Surge)),
        Arc::new(restoring_force::RestoringForce(Dof::Sway)),
        Arc::new(restoring_force::RestoringForce(Dof::Heave)),
        Arc::new(restoring_moment::RestoringMoment(Dof::Roll)),
        Arc::new(restoring_moment::RestoringMoment(Dof::Pitch)),
        Arc::new(bias::Bias),
        Arc::new(each_run::EachRun::WEIGHT),
        Arc::new(each_run::EachRun::BIAS),
        Arc::new(trim_offset::TrimOffset),
        Arc::new(thrust_delay::ThrustDelay),
        Arc::new(thrust_lag::ThrustLag),
        Arc::new(thrust_deadband::ThrustDeadband),
        Arc::new(thrust_saturation::ThrustSaturation),
        Arc::new(supply_voltage::SupplyVoltage),
        Arc::new(thrust_interaction_loss::ThrustInteractionLoss),
        Arc::new(thrust_reverse_loss::ThrustReverseLoss),
        Arc::new(thruster_fault::ThrusterFault),
        Arc::new(ThrusterLoss::of_none()),
        Arc::new(ThrusterSwap::of_none()),
        Arc::new(thrust_advance_loss::ThrustAdvanceLoss),
        Arc::new(ThrusterAdvanceLoss::of(Vec::new())),
        Arc::new(thrust_crosstalk::ThrustCrosstalk),
        Arc::new(propeller_advance::PropellerAdvance),
        Arc::new(fin_lift::FinLift(fin_lift::Fin::Rudder)),
        Arc::new(fin_lift::FinLift(fin_lift::Fin::SternPlane)),
        Arc::new(fin_drag::FinDrag(fin_lift::Fin::Rudder)),
        Arc::new(fin_drag::FinDrag(fin_lift::Fin::SternPlane)),
        Arc::new(current::Current),
        Arc::new(earth_force::EarthForce),
        Arc::new(each_run::EachRun::CURRENT),
        Arc::new(each_run::EachRun::EARTH_FORCE),
        Arc::new(tether_spring::TetherSpring),
        Arc::new(tether_drag::TetherDrag),
        Arc::new(wave::Wave),
        Arc::new(sensor_gyro_bias::SensorGyroBias),
        Arc::new(sensor_gyro_scale::SensorGyroScale),
        Arc::new(sensor_heading_offset::SensorHeadingOffset),
        Arc::new(sensor_tilt_offset::SensorTiltOffset),
        Arc::new(sensor_compass_magnetic::SensorCompassMagnetic),
        Arc::new(sensor_compass_deviation::SensorCompassDeviation),
        Arc::new(sensor_dvl_lever_arm::SensorDvlLeverArm),
        Arc::new(sensor_dvl_misalignment::SensorDvlMisalignment),
        Arc::new(sensor_dvl_scale::SensorDvlScale),
        Arc::new(sensor_dvl_delay::SensorDvlDelay),
        Arc::new(sensor_gyro_lag::SensorGyroLag),
        Arc::new(sensor_position_delay::SensorPositionDelay),
        Arc::new(sensor_position_lever_arm::SensorPositionLeverArm),
        Arc::new(sensor_delay::SensorDelay),
        Arc::new(sensor_clock_drift::SensorClockDrift),
    ]);
    list
}
