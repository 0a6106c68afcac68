//! Estimation: from runs to parameters, with what is needed to judge whether to believe them.

mod at_samples;
mod balance;
mod coupling_noise;
pub mod filter_error;
mod folded;
pub mod identifiability;
mod integral;
mod joint;
mod nodes;
pub mod output_error;
mod pose_velocity;
mod regressor;
mod row_fit;
mod shared;
mod shared_stamps;
mod start;
mod steady;
mod streamed;
mod sums;
mod window;

pub use at_samples::{Components, DirectError, direct_columns, force_components};
pub use balance::RegressorError;
pub use folded::{Folded, folded};
pub use integral::{IntegralError, integral_least_squares};
pub use nodes::{Nodes, Span};
pub use pose_velocity::velocities_from_poses;
pub use regressor::{Block, Column, Columns, RegressorOptions, regressors_of};
pub use row_fit::{AtBound, IntegralOptions, RowFit, Together, fit_rows};
pub(crate) use start::samples_in;
pub(crate) use start::tame;
pub use start::{moved_by_thrust, started};
pub use steady::{Mean, SteadyOptions, SteadyWindow, mean_of, noise_of_mean, steady_windows};
pub use streamed::Streamed;

pub use crate::least_squares::{
    Blocks, Draws, Fit, LeastSquaresError, LeastSquaresOptions, Names, RSquared, Refinement, StdMethod, StreamingQr,
    least_squares, least_squares_filled, least_squares_rows, least_squares_with,
};
