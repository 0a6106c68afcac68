//! What a fit's data can tell, and what it cannot: beside each estimate, whether to believe it.
//!
//! ```text
//! collinearity   which parameters this data cannot tell apart (Belsley's variance proportions)
//! share          how much of the force in a balance a term carries
//! halves         whether the first and the second half of the runs tell the same
//! run by run     whether an inertia follows the amplitude of the runs
//! profile        how the likelihood falls when a parameter is held aside and all others follow
//! ```
//!
//! The first three cost nothing beside the fit: they read its triangular factors. Values run by run are one fit more, a
//! profile is made of several.

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
