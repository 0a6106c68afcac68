//! Experimental identification of underwater vehicles.
//!
//! One vehicle, one balance of momentum, in body axes:
//!
//! ```text
//! dπ/dt + ν ×* π = w          π = M ν   (momentum of vehicle and water),   w = drag, restoring, thrust, …
//! ```
//!
//! From logs of bollard-pull, constant-velocity, oscillatory and zig-zag runs the crate estimates what stands in
//! it, simulates it, compares the simulation with the measurement, and names what is missing. The method is that of
//! Avila, Donha and Adamowski, *Ocean Engineering* 60 (2013) 81-94.

//! # A first fit
//!
//! A campaign folder with its logs is read, fitted and searched by the verbs of [`campaign`]: see `examples/fit.rs` and
//! `examples/discover.rs`. Without files, from arrays of one's own, here a vehicle of 10 kg that is driven ahead and astern:
//!
//! ```
//! use hydrosysid::effects::Coriolis;
//! use hydrosysid::estimate::filter_error::{FilterErrorOptions, filter_error};
//! use hydrosysid::frame::Dof;
//! use hydrosysid::model::Model;
//! use hydrosysid::run::{Run, Signal};
//!
//! // 40 s at 20 Hz: thrust in N, speed in m/s
//! let time: Vec<f64> = (0..800).map(|k| 0.05 * f64::from(k)).collect();
//! let thrust: Vec<f64> = time.iter().map(|t| 12.0 * (0.5 * t).sin() + 6.0 * (1.3 * t).cos()).collect();
//! let mut u = 0.0;
//! let speed: Vec<f64> = thrust.iter().map(|tau| { let now = u; u += 0.05 * (tau - 8.0 * u) / 10.0; now }).collect();
//!
//! let mut run = Run::default();
//! run.signals.insert("u".into(), Signal::new(time.clone().into(), speed));
//! run.signals.insert("tau_u".into(), Signal::new(time.into(), thrust));
//!
//! let model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"])?;
//! let fit = filter_error(&model, &[run], &FilterErrorOptions::default())?;
//! let mass = fit.model.value("inertia@surge").unwrap();
//! // the data were made by steps of 0.05 s, which the fit does not know
//! assert!((mass - 10.0).abs() < 0.5, "{mass}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Rooms
//!
//! What a user names stands below. Data: [`run`], [`log`], [`frame`], [`units`], [`vehicle`], [`thrust`]. Models:
//! [`model`], [`effects`], [`symbolic`]. Methods: [`estimate`], [`procedure`], [`least_squares`], [`simulate`], [`compare`],
//! [`discover`], [`plan`], [`monitor`]. The whole: [`campaign`], [`export`], [`report`], [`tank`], [`finding`]. Modules that
//! are not listed are the machine inside: open to the Python package, the tests and the benchmarks, and free to change.

// exact comparisons in tests are meant: bits are promised there
#![cfg_attr(test, allow(clippy::float_cmp))]

mod atomic_file;
pub mod campaign;
#[doc(hidden)]
pub mod chain;
#[doc(hidden)]
pub mod check;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
pub mod compare;
#[doc(hidden)]
pub mod demo;
pub mod discover;
#[doc(hidden)]
pub mod dynamics;
pub mod effects;
mod eigenvalues;
#[doc(hidden)]
pub mod envelope;
pub mod estimate;
pub mod export;
#[doc(hidden)]
pub mod filter;
pub mod finding;
#[doc(hidden)]
pub mod formula;
pub mod frame;
pub mod least_squares;
pub mod log;
pub mod model;
pub mod monitor;
#[doc(hidden)]
pub mod navigation;
#[doc(hidden)]
pub mod nearest;
#[doc(hidden)]
pub mod noise;
pub mod plan;
pub mod procedure;
#[doc(hidden)]
pub mod progress;
pub mod report;
#[doc(hidden)]
pub mod report_content;
pub mod run;
#[doc(hidden)]
pub mod simd;
pub mod simulate;
mod spreadsheet;
pub mod symbolic;
pub mod tank;
mod text_file;
pub mod thrust;
pub mod units;
pub mod vehicle;
#[cfg(feature = "view")]
#[doc(hidden)]
pub mod view;
mod wording;
