//! Numbers side by side: their layout in memory, arithmetic on them, and the vector units of the
//! machine.
//!
//! ```text
//! sum ← sum + a∘b        ∘: lane by lane, L lanes at once
//! ```
//!
//! A lane is a trajectory, a segment or an instant. Work on [`Lanes`] is written once for any
//! [`Wide`] and done with the widest registers of the machine, found at run time ([`Work`]). The
//! results do not depend on the choice.

mod arithmetic;
mod four;
mod lanes;
mod widest;

pub use arithmetic::{Machine, Plain, Wide, Widths, Work};
pub use four::{Four, Turn};
pub use lanes::Lanes;
pub use widest::widest;
