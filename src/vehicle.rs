//! The vehicle and its water: properties that are weighed or measured, not identified.
//!
//! All are optional, because no value is guessed: a function that needs an absent value has to
//! report that. Weight W and buoyancy B are separate inputs, because W − B is the small difference
//! of two large numbers. Source: the vehicle section of Avila, Donha and Adamowski, *Ocean
//! Engineering* 60 (2013) 81-94.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::frame::Dof;

/// The `[vehicle]` table of a campaign.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Vehicle {
    /// Name shown to people.
    pub name: String,
    /// Dry mass m, kg.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Displaced volume ∇, m³.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume: Option<f64>,
    /// Weight W in air, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
    /// Buoyancy B, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub buoyancy: Option<f64>,
    /// Characteristic length as given, m; use [`Vehicle::characteristic_length`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// Centre of gravity in body axes, m; the body origin if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cg: Option<[f64; 3]>,
    /// Centre of buoyancy in body axes, m; the body origin if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cb: Option<[f64; 3]>,
}

/// The `[water]` table of a campaign; fresh water at 20 °C if absent.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Water {
    /// Density ρ, kg/m³.
    pub density: f64,
    /// Kinematic viscosity, m²/s.
    pub kinematic_viscosity: f64,
}

impl Default for Water {
    fn default() -> Water {
        Water { density: 1000.0, kinematic_viscosity: 1.004e-6 }
    }
}

/// Error of a property of the vehicle or the water.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum VehicleError {
    /// A quantity that must be positive is not.
    #[error("[{table}] {key} = {value}: must be a positive number of {unit}")]
    NotPositive {
        /// Table of the campaign: `vehicle` or `water`.
        table: &'static str,
        /// Key in that table.
        key: &'static str,
        /// Its value.
        value: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// A position is not finite.
    #[error("[vehicle] {key} = {value:?}: must be three finite numbers of metres in body axes")]
    BadPosition {
        /// Key in the table.
        key: &'static str,
        /// Its value, m.
        value: [f64; 3],
    },
}

fn positive(table: &'static str, key: &'static str, unit: &'static str, value: f64) -> Result<(), VehicleError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(VehicleError::NotPositive { table, key, value, unit })
}

impl Vehicle {
    /// Characteristic length L_c, m: the given one, otherwise ∇^(1/3); `None` if neither length nor
    /// volume is known.
    pub fn characteristic_length(&self) -> Option<f64> {
        self.length.or_else(|| self.volume.map(f64::cbrt))
    }

    /// W − B, N (positive: the vehicle sinks); `None` unless both are known.
    pub fn net_weight(&self) -> Option<f64> {
        Some(self.weight? - self.buoyancy?)
    }

    /// The entry of the dry mass matrix that couples two motions: ∓m r_g between a force and a
    /// rotation, kg·m. It is 0 elsewhere, because products of inertia about the body origin are
    /// assumed to be 0; `None` if it depends on an unknown mass.
    pub fn dry_coupling(&self, row: Dof, column: Dof) -> Option<f64> {
        if row.is_rotation() == column.is_rotation() {
            return Some(0.0);
        }
        let [x, y, z] = self.cg.unwrap_or([0.0; 3]);
        // S(r_g); M_RB has −m S above the diagonal and m S below
        let skew = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
        let sign = if row.is_rotation() { 1.0 } else { -1.0 };
        let entry = skew[row.index() % 3][column.index() % 3];
        self.mass.map(|mass| sign * mass * entry)
    }

    /// Refuses impossible values.
    ///
    /// # Errors
    /// A mass, volume, weight, buoyancy or length that is not positive and finite; a centre that is
    /// not finite.
    pub fn validate(&self) -> Result<(), VehicleError> {
        let figures = [
            ("mass", "kg", self.mass),
            ("volume", "m3", self.volume),
            ("weight", "N", self.weight),
            ("buoyancy", "N", self.buoyancy),
            ("length", "m", self.length),
        ];
        for (key, unit, value) in figures {
            value.map_or(Ok(()), |value| positive("vehicle", key, unit, value))?;
        }
        for (key, centre) in [("cg", self.cg), ("cb", self.cb)] {
            if let Some(value) = centre.filter(|c| c.iter().any(|x| !x.is_finite())) {
                return Err(VehicleError::BadPosition { key, value });
            }
        }
        Ok(())
    }
}

impl Water {
    /// Refuses impossible values.
    ///
    /// # Errors
    /// A density or viscosity that is not positive and finite.
    pub fn validate(&self) -> Result<(), VehicleError> {
        positive("water", "density", "kg/m3", self.density)?;
        positive("water", "kinematic_viscosity", "m2/s", self.kinematic_viscosity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAURS: &str = "name = 'LAURS'\nmass = 189.0\nvolume = 0.19\nweight = 1854.1\nbuoyancy = 1887.5\n";

    #[test]
    fn paper_length_and_net_weight() {
        let vehicle: Vehicle = toml::from_str(LAURS).unwrap();
        vehicle.validate().unwrap();
        // printed with four digits
        assert!((vehicle.characteristic_length().unwrap() - 0.5749).abs() < 5e-5);
        // 1854.1 − 1887.5 in floating point
        assert!((vehicle.net_weight().unwrap() + 33.4).abs() < 1e-9);
        let given = Vehicle { length: Some(0.6), ..vehicle };
        assert_eq!(given.characteristic_length(), Some(0.6));
    }

    #[test]
    fn figures_that_cannot_be_are_named() {
        let negative = Vehicle { mass: Some(-189.0), ..Vehicle::default() };
        let message = negative.validate().unwrap_err().to_string();
        assert_eq!(message, "[vehicle] mass = -189: must be a positive number of kg");
        assert!(Vehicle { cg: Some([0.0, f64::NAN, 0.0]), ..Vehicle::default() }.validate().is_err());
        assert!(Water { density: 0.0, ..Water::default() }.validate().is_err());
        assert!(Water { kinematic_viscosity: f64::INFINITY, ..Water::default() }.validate().is_err());
    }

    #[test]
    fn unknown_keys_are_refused_and_absent_ones_stay_absent() {
        assert!(toml::from_str::<Vehicle>("mas = 189.0").is_err());
        let empty: Vehicle = toml::from_str("").unwrap();
        assert_eq!(empty, Vehicle::default());
        assert_eq!(empty.characteristic_length(), None);
        assert_eq!(empty.net_weight(), None);
        assert_eq!(toml::from_str::<Water>("").unwrap(), Water::default());
    }

    #[test]
    fn what_is_written_is_read_back() {
        let vehicle: Vehicle = toml::from_str(LAURS).unwrap();
        assert_eq!(toml::from_str::<Vehicle>(&toml::to_string(&vehicle).unwrap()).unwrap(), vehicle);
    }
}
