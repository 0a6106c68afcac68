//! Simulation of an underwater vehicle, its pilot, its instruments and its log, written from the textbook.
//!
//! This crate imports nothing of `hydrosysid`. The results of `hydrosysid` on a campaign of this
//! plant are therefore checked against independent equations: a wrong equation in one of the two
//! shows as a disagreement. The equations are those of Fossen, *Handbook of Marine Craft
//! Hydrodynamics and Motion Control*, 2nd ed. (2021), in vector form. Formulas and signs of the
//! effects are those of the catalogue of `hydrosysid`; drag is positive where it dissipates.
//!
//! A [`Campaign`] describes the runs; [`Campaign::sail`] simulates them and returns the logs and
//! the [`Truth`]; [`Sailed::write`] writes the folder that `hydrosysid` reads.

pub mod actuation;
pub mod attitude;
pub mod body;
pub mod campaign;
pub mod commands;
pub mod disturbance;
pub mod dof;
mod folder;
pub mod hide;
pub mod hydrodynamics;
pub mod instrument;
pub mod integrate;
pub mod log;
mod naming;
pub mod outside;
pub mod pilot;
pub mod plant;
pub mod random;
mod run_number;
pub mod sail;
mod slots;
pub mod thruster;
pub mod trials;
pub mod truth;
pub mod vehicle;
pub mod water;

pub use campaign::{Campaign, Commands, Hidden, Pilots, PlantError, RandomForce, Suite};
pub use commands::Input;
pub use dof::Dof;
pub use log::{Log, Signal};
pub use sail::Sailed;
pub use trials::Manoeuvre;
pub use truth::Truth;
pub use vehicle::Vehicle;
