//! Estimation: from runs to parameters with what is needed to believe them or not.

mod balance;
mod nodes;
pub mod output_error;
mod regressor;

pub use balance::RegressorError;
pub use nodes::{Nodes, Span};
pub use regressor::{Block, Column, Columns, RegressorOptions, regressors, regressors_of};
