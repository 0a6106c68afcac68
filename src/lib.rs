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

// exact comparisons in tests are meant: bits are promised there
#![cfg_attr(test, allow(clippy::float_cmp))]

mod atomic_file;
pub mod campaign;
pub mod chain;
pub mod check;
#[cfg(feature = "cli")]
pub mod cli;
pub mod compare;
pub mod demo;
pub mod discover;
pub mod dynamics;
pub mod effects;
pub mod envelope;
pub mod estimate;
pub mod export;
pub mod filter;
pub mod finding;
pub mod formula;
pub mod frame;
pub mod least_squares;
pub mod log;
pub mod model;
pub mod monitor;
pub mod navigation;
pub mod nearest;
pub mod noise;
pub mod plan;
pub mod procedure;
pub mod progress;
pub mod report;
pub mod report_content;
pub mod run;
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
pub mod view;
mod wording;
