//! Simulation by the classical Runge-Kutta scheme of fourth order, with sensitivities integrated along.
//!
//! ```text
//! ẋ = f(x, θ, inputs)        Ṡ = A S + B,   S = ∂x/∂(x₀, θ)
//! ```
//!
//! A [`Track`] is a prepared run: its inputs at every stage of every step, its observations at
//! every sample. [`integrate`] integrates `L` stretches of tracks side by side. [`rk4()`] is the
//! plain scheme for any function.

mod edges;
mod evaluator;
mod feed;
mod first_samples;
mod free_run;
mod ode;
mod reader;
mod rk4;
mod single;
mod time_constant;
mod track;
mod trajectory;

pub(crate) use evaluator::{Evaluator, prepared};
pub(crate) use feed::Feed;
pub use feed::Stretch;
pub use first_samples::FirstSample;
pub(crate) use first_samples::{nearest_turn, quantile};
pub use free_run::{free_run, in_reach, memory_start, values_at, values_in_run};
pub use ode::{OdeError, rk4};
pub use rk4::{Emission, integrate, integrate_fast};
pub use time_constant::quickest_time_constants;
pub use track::{NO_SAMPLE, Substep, Track, TrackError};
pub use trajectory::Trajectory;

/// Shortest time constant of a memory of the model, s. The scheme follows it in steps of half of
/// it; compared with the sample time of any log, a quicker memory acts at once.
pub const QUICKEST: f64 = 0.02;
