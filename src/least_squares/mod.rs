//! Linear least squares: one solver for every room.
//!
//! ```text
//! θ̂ = argmin |y − H θ|²        σ_θ by (14) and (15), or by what correlated residuals leave
//! ```
//!
//! [`least_squares`] solves and says what is needed to believe the answer or not; [`Fit::covariance_by`] gives the
//! covariance where residuals are correlated along a run.

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
