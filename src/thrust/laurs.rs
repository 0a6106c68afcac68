//! LAURS, the paper's vehicle, for the tests of this module: dry figures, eight thrusters,
//! efficiencies.
//!
//! They are in `vehicles/laurs.toml`, where values that the paper does not give (positions, rear
//! angles, limits) are marked as assumed. Source: Avila, Donha and Adamowski, *Ocean Engineering*
//! 60 (2013) 81-94.

use nalgebra::Vector6;

use super::advance::AdvanceLoss;
use super::allocation::Allocation;
use super::efficiency::Efficiency;
use super::thruster::Thruster;
use crate::vehicle::{Vehicle, Water};

fn table() -> toml::Table {
    toml::from_str(include_str!("../../vehicles/laurs.toml")).unwrap()
}

/// The eight thrusters.
pub(super) fn thrusters() -> Vec<Thruster> {
    table().remove("thruster").unwrap().try_into().unwrap()
}

/// Wrench of 100 N from each named thruster.
fn push(names: &[&str]) -> Vector6<f64> {
    let thrusters = thrusters();
    let force = |t: &Thruster| if names.contains(&t.name.as_str()) { 100.0 } else { 0.0 };
    let forces: Vec<f64> = thrusters.iter().map(force).collect();
    Allocation::new(&thrusters).unwrap().wrench(&forces)
}

#[test]
fn the_file_is_valid() {
    let table = table();
    let vehicle: Vehicle = table["vehicle"].clone().try_into().unwrap();
    vehicle.validate().unwrap();
    table["water"].clone().try_into::<Water>().unwrap().validate().unwrap();
    let efficiency: Efficiency = table["efficiency"].clone().try_into().unwrap();
    efficiency.validate().unwrap();
    assert_eq!(efficiency.eta_adv, Some(AdvanceLoss::PAPER));
    assert!((vehicle.net_weight().unwrap() + 33.4).abs() < 1e-9);
    assert_eq!(thrusters().len(), 8);
    assert_eq!(Allocation::new(&thrusters()).unwrap().rank(), 6);
}

#[test]
fn paper_groups_do_what_the_paper_does_with_them() {
    let (cos, sin) = (36.0_f64.to_radians().cos(), 36.0_f64.to_radians().sin());
    let only = |wrench: Vector6<f64>, dof: usize, value: f64| {
        let mut wanted = Vector6::zeros();
        wanted[dof] = value;
        // axes are written with 16 digits
        assert!((wrench - wanted).amax() < 1e-10, "{wrench}");
    };
    only(push(&["T5", "T6"]), 0, 200.0 * cos);
    let turn = 200.0 * (0.5 * sin + 0.45 * cos);
    only(push(&["T5", "T8"]), 5, turn);
    only(push(&["T2", "T6"]), 5, -turn);
    only(push(&["T5", "T2"]), 1, 200.0 * sin);
    only(push(&["T6", "T8"]), 1, -200.0 * sin);
    only(push(&["T1", "T3"]), 2, 200.0);
    only(push(&["T4", "T7"]), 2, 200.0);
}

#[test]
fn paper_surge_profile_is_within_reach_of_the_front_thrusters() {
    // T5 and T6 alone give the greatest force of the oscillation runs in surge, 145.3 + 185.7 N
    let front = thrusters()[0].curve();
    let each = (145.3 + 185.7) / (2.0 * 36.0_f64.to_radians().cos());
    let command = front.inverse(each);
    assert!(!command.saturated && command.voltage < 5.0, "{command:?}");
}
