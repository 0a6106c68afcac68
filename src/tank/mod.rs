//! The virtual tank: vehicles whose truth is known, logged as real ones are.
//!
//! A [`Basin`] sails a [`Trial`] with a true [`Model`](crate::model::Model): the pilot's command goes through the
//! model's own actuators, body and sensors, so that the tank knows no physics that the regressor does not know. What
//! is random (noise, disturbance, a vehicle's figures) comes from one seed.
//!
//! [`blind()`] makes campaigns with an effect hidden, for judging whether it is found; [`paper_campaign`] sails the
//! campaign of the paper; [`captive`] holds a vehicle on load cells.

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
