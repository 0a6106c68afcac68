//! Which runs show the motion of a free vehicle.

use crate::run::RunKind;

/// Whether a vehicle moves freely in a run of this kind.
pub(super) fn moves(kind: RunKind) -> bool {
    !matches!(kind, RunKind::Bollard | RunKind::Towing | RunKind::Bench)
}
