//! Numbers side by side: how they lie in memory, how they are calculated with, and on which units of the machine.
//!
//! ```text
//! sum ← sum + a∘b        ∘: lane by lane, L lanes at once
//! ```
//!
//! A lane is a trajectory, a segment or an instant; work on [`Lanes`] is written once for any [`Wide`] and done with the
//! widest registers that the machine turns out to have ([`Work`]). The results do not depend on the choice.

mod arithmetic;
mod four;
mod lanes;
mod widest;

pub use arithmetic::{Machine, Plain, Wide, Widths, Work};
pub use four::{Four, Turn};
pub use lanes::Lanes;
pub use widest::widest;
