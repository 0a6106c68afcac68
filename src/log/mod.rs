//! Logs: a CSV file of a vehicle becomes a run in SI units and is checked when it is read.
//!
//! The file has one header line and one row per time stamp; a header is `name` or `name [unit]`. A
//! file that is not plain CSV in SI units is refused, and the message names file, line, column,
//! value and the option that would allow it; nothing is guessed. Steps of reading a file:
//! [`encoding`] recognises it by its first bytes, [`records`] cuts it into lines and fields,
//! [`header`] names the columns, [`rows`] turns cells into numbers (plain rows many at a time),
//! [`read()`] keeps them as signals, [`derived`] computes channels from others, and [`check`] tests
//! whether the values are plausible. [`write()`] writes a run as CSV.

mod cells;
pub mod check;
pub mod clock;
pub mod codes;
pub mod columns;
pub mod derived;
pub mod earth_velocity;
pub mod encoding;
mod error;
mod fast_rows;
pub mod faults;
pub mod frames;
pub mod header;
pub mod iso8601;
pub mod number;
pub mod options;
mod pieces;
mod read;
pub mod records;
pub mod rows;
mod valid_options;
mod write;

pub use error::LogError;
pub use fast_rows::Row;
pub use options::LogOptions;
pub use pieces::{Piece, Pieces};
pub use read::{LogFile, read, read_from};
pub use rows::{Passage, Rows};
pub use valid_options::OptionsError;
pub use write::{WriteError, write, write_log, write_signals, write_to, write_wall_clock};

use crate::frame::Dof;

/// Returns the columns that a campaign of these degrees of freedom needs: `t`, the velocities, the forces.
pub fn required(dofs: &[Dof]) -> Vec<&'static str> {
    let velocities = dofs.iter().map(|d| d.velocity());
    std::iter::once("t").chain(velocities).chain(dofs.iter().map(|d| d.force())).collect()
}

/// The columns of a planar log: `t`, `u`, `v`, `r`, `tau_u`, `tau_v`, `tau_r`.
pub const PLANAR: [&str; 7] = ["t", "u", "v", "r", "tau_u", "tau_v", "tau_r"];
