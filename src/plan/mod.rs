//! Experiment design: runs that bring chosen parameters to a wanted standard deviation, and the prediction of what
//! runs give.
//!
//! ```text
//! F = Σ_runs JᵀJ        J = ∂y/∂θ / σ of the run simulated with the model, initial states of the segments projected out
//! std θ_k = √(F⁻¹)_kk   what output error reaches with white noise of deviation σ (Cramér-Rao)
//! ```
//!
//! Candidate [`Manoeuvre`]s on a grid within the limits of thrust ([`grid()`]) are simulated without noise in the
//! virtual tank. Each is reduced to its triangular factor of information ([`Information`]), and a set is selected by
//! greedy choice and exchange ([`propose`]). [`rehearse`] fits simulated campaigns of the set and compares the
//! scatter of the estimates with the prediction. Fedorov, *Theory of Optimal Experiments* (1972), ch. 3; Jategaonkar,
//! *Flight Vehicle System Identification*, 2nd ed. (2015), ch. 2.

pub mod codes;
mod grid;
mod information;
mod instrument;
mod manoeuvre;
mod proposal;
mod rehearsal;
mod sail;
mod selection;

pub use grid::{GridOptions, grid};
pub use information::Information;
pub use instrument::{Instrument, Instruments, usual};
pub use manoeuvre::{Manoeuvre, ManoeuvreError, Push};
pub use proposal::{PlanError, PlanOptions, Predicted, Proposal, ProposedRun, Wish, predict, propose};
pub use rehearsal::{Rehearsal, RehearsedParameter, rehearse};
pub use sail::{Course, Sailed};
