//! The virtual tank: vehicles with a known true model, logged like real ones.
//!
//! A [`Basin`] runs a [`Trial`] with a true [`Model`](crate::model::Model): the pilot's command
//! goes through the model's own actuators, body and sensors, so the tank contains no physics that
//! the regressor does not. All randomness (noise, disturbance, the properties of a vehicle) comes
//! from one seed.
//!
//! [`blind()`] makes campaigns with a hidden effect, to test whether it is found;
//! [`paper_campaign`] simulates the campaign of the paper; [`captive`] holds a vehicle on load
//! cells.

mod basin;
mod blind;
mod captive;
mod craft;
mod disturbance;
mod hidden;
mod laurs;
pub mod outside;
mod paper;
mod pilot;
mod plant;
mod sensor;
mod trials;
mod write;

pub use crate::noise::Noise;
pub use basin::{Basin, TankError, Trial, derived};
pub(crate) use blind::amplitudes;
pub use blind::{Blind, BlindOptions, blind};
pub use captive::captive;
pub use craft::{Craft, CraftKind};
pub use disturbance::Disturbance;
pub use hidden::Hidden;
pub use paper::{PaperCampaign, paper_campaign};
pub use pilot::{Law, Measured, Pilot, Profile, Sine};
pub use sensor::Sensor;
pub use write::{FolderError, WriteBlindError, write_blind};
