//! From logs to parameters.

mod balance;
mod nodes;
mod regressor;

pub use balance::RegressorError;
pub use nodes::{Nodes, Span};
pub use regressor::{Block, Column, Columns, RegressorOptions, regressors, regressors_of};
