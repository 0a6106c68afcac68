//! Runs with the forces that other coefficients of a measured thruster curve would give.

use super::effective_thrust::acting_forces;
use crate::run::{Run, Signal, thruster_command, thruster_force};
use crate::thrust::efficiency::Efficiency;
use crate::thrust::measured::{MeasuredCurve, Moves, reshaped};
use crate::thrust::thruster::Thruster;

/// The run with the nominal forces that its commands would give if the coefficients of `measured`
/// were greater by `by`. A thruster whose command is not logged keeps its forces: they come from
/// elsewhere.
pub fn with_curve_moved(run: &Run, thrusters: &[Thruster], measured: &MeasuredCurve, by: &Moves) -> Run {
    let mut other = run.clone();
    let volts = run.supply_voltage();
    for k in &measured.thrusters {
        let name = thruster_force(*k);
        let (Some(force), true) = (run.signal(&name), run.signal(&thruster_command(*k)).is_some()) else { continue };
        let curve = thrusters[*k].curve();
        let moved = force.time().iter().zip(force.values());
        let moved = moved.map(|(t, f)| reshaped(&curve, by, *f, volts.map(|v| v.at(*t)))).collect::<Vec<_>>();
        other.signals.insert(name, Signal::new(force.shared_time().clone(), moved));
    }
    acting_forces(&other, &Efficiency::default(), thrusters).0
}
