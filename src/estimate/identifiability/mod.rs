//! Identifiability: what the data of a fit can determine, and what they cannot.
//!
//! ```text
//! collinearity   which parameters this data cannot distinguish (Belsley's variance proportions)
//! share          how much of the force in a balance a term carries
//! halves         whether the first and the second half of the runs agree
//! run by run     whether an inertia follows the amplitude of the runs
//! profile        how the likelihood falls when a parameter is held aside and all others are refitted
//! ```
//!
//! The first three need no further fit. Values run by run are one fit more, a profile is several.

mod amplitude;
mod collinearity;
mod halves;
mod profile;
mod share;

pub use amplitude::{RunByRun, Trend, run_by_run, trend};
pub use collinearity::{Collinearity, ConditionIndex, SAME, collinearity, factor_of};
pub use halves::{Halves, halves};
pub use profile::{Profile, ProfilePoint, profile};
pub use share::shares;
