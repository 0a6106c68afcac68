//! Linear least squares: one solver for all modules.
//!
//! ```text
//! θ̂ = argmin |y − H θ|²        σ_θ by (14) and (15), or from the correlation of the residuals
//! ```
//!
//! [`least_squares`] solves a system and reports what is needed to judge the result;
//! [`Fit::covariance_by`] gives the covariance for residuals that are correlated along a run.

pub(crate) mod clusters;
mod column_monitor;
mod double_double;
mod factor;
mod pivoted;
mod refine;
mod resample;
mod sandwich;
mod scale;
mod singular;
mod solve;
mod streaming_qr;
mod student;
mod system;
mod triangle;
mod whitened;

pub use resample::{Blocks, Draws};
pub(crate) use resample::{REFITTING, resample};
pub use sandwich::StdMethod;
pub(crate) use singular::singular_ratio;
pub use solve::{
    Fit, LeastSquaresOptions, RSquared, Refinement, least_squares, least_squares_filled, least_squares_rows,
    least_squares_with,
};
pub use streaming_qr::StreamingQr;
pub use student::student_quantile;
pub use system::{LeastSquaresError, Names};
pub(crate) use triangle::Triangle;
