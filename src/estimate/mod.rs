//! Estimation: from runs to parameters with what is needed to believe them or not.

mod at_samples;
mod balance;
mod double_double;
mod integral;
mod least_squares;
mod linear;
mod nodes;
pub mod output_error;
mod pivoted;
mod refine;
mod regressor;
mod scale;
mod singular;
mod start;
mod steady;
mod system;

pub use at_samples::{Components, DirectError, direct_columns, force_components};
pub use balance::RegressorError;
pub use integral::{IntegralError, IntegralOptions, RowFit, fit_rows, integral_least_squares};
pub use least_squares::{
    Fit, LeastSquaresOptions, RSquared, Refinement, least_squares, least_squares_rows, least_squares_with,
};
pub use linear::{LinearError, LinearFit, StdMethod, solve};
pub use nodes::{Nodes, Span};
pub use regressor::{Block, Column, Columns, RegressorOptions, regressors, regressors_of};
pub use start::started;
pub use steady::{Mean, SteadyOptions, SteadyWindow, mean_of, steady_windows};
pub use system::{LeastSquaresError, Names};
