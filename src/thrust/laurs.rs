//! LAURS, the paper's vehicle: dry figures, eight thrusters, efficiencies.
//!
//! They stand in `vehicles/laurs.toml`, where what the paper does not say (positions, rear angles, limits) is marked as
//! assumed. Source: Avila, Donha and Adamowski, *Ocean Engineering* 60 (2013) 81-94.

use serde::Deserialize;

use super::efficiency::Efficiency;
use super::thruster::Thruster;
use crate::vehicle::{Vehicle, Water};

/// The tables of a campaign that describe a vehicle apart from its model.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Outfit {
    /// Dry figures.
    pub vehicle: Vehicle,
    /// The water of the tank.
    #[serde(default)]
    pub water: Water,
    /// Where the figures come from, one source a line.
    #[serde(default)]
    pub sources: Vec<String>,
    /// Thrusters, in the order of the file.
    #[serde(default, rename = "thruster")]
    pub thrusters: Vec<Thruster>,
    /// Losses of thrust.
    #[serde(default)]
    pub efficiency: Efficiency,
}

/// The text of `vehicles/laurs.toml`: tables that can be pasted into a campaign.
pub const LAURS: &str = include_str!("../../vehicles/laurs.toml");

/// The vehicle of the paper.
pub fn laurs() -> Outfit {
    toml::from_str(LAURS).expect("the text is part of the crate and read by its tests")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thrust::advance::AdvanceLoss;
    use crate::thrust::allocation::Allocation;
    use nalgebra::Vector6;

    /// Wrench of 100 N from each thruster named.
    fn push(names: &[&str]) -> Vector6<f64> {
        let outfit = laurs();
        let force = |t: &Thruster| if names.contains(&t.name.as_str()) { 100.0 } else { 0.0 };
        let forces: Vec<f64> = outfit.thrusters.iter().map(force).collect();
        Allocation::new(&outfit.thrusters).unwrap().wrench(&forces)
    }

    #[test]
    fn the_file_is_valid() {
        let outfit = laurs();
        outfit.vehicle.validate().unwrap();
        outfit.water.validate().unwrap();
        outfit.efficiency.validate().unwrap();
        assert_eq!(outfit.thrusters.len(), 8);
        assert_eq!(outfit.efficiency.eta_adv, Some(AdvanceLoss::PAPER));
        assert!((outfit.vehicle.net_weight().unwrap() + 33.4).abs() < 1e-9);
        assert_eq!(Allocation::new(&outfit.thrusters).unwrap().rank(), 6);
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
        // 145.3 + 185.7 N of T5 and T6 alone, the greatest of the oscillation runs, and W − B besides
        let front = laurs().thrusters[0].curve();
        let each = (145.3 + 185.7) / (2.0 * 36.0_f64.to_radians().cos());
        let command = front.inverse(each);
        assert!(!command.saturated && command.voltage < 5.0, "{command:?}");
    }
}
