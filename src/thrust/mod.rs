//! From a command to the force on the vehicle.
//!
//! ```text
//! command → curve → force of each thruster → allocation → τ_nom → efficiency → τ = η_inter η_adv τ_nom
//! ```
//!
//! Each step stands in its own file: [`curve`] is equation (1) of Avila, Donha and Adamowski, *Ocean Engineering* 60
//! (2013) 81-94, [`allocation`] the geometry, [`efficiency`] equations (16) and (17).

pub mod allocation;
pub mod bollard;
pub mod curve;
pub mod fit;
#[cfg(test)]
mod noise;
mod regression;
pub mod thruster;
