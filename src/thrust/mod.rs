//! From a command to the force on the vehicle.
//!
//! ```text
//! command → curve → force of each thruster → allocation → τ_nom → efficiency → τ = η_inter η_adv τ_nom
//! ```
//!
//! Each step is a file: [`curve`] is equation (1) of Avila, Donha and Adamowski, *Ocean
//! Engineering* 60 (2013) 81-94, [`fit`] fits it to a bollard table, [`measured`] propagates its
//! uncertainty to the thrust, [`thruster`] and [`allocation`] are the geometry, [`interaction`],
//! [`advance`] (17) and [`efficiency`] (16) the losses; [`mod@bench`] fits curve and lag of one
//! thruster to command and force over time; `laurs`, for tests, is the paper's vehicle.

pub mod advance;
pub mod allocation;
pub mod bench;
pub mod bollard;
pub mod curve;
pub mod efficiency;
pub mod fit;
pub mod interaction;
#[cfg(test)]
mod laurs;
pub mod measured;
#[cfg(test)]
mod noise;
pub mod thruster;
