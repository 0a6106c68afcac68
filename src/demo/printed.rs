//! Printed values of the paper for the stages that a demo repeats: value and standard deviation,
//! SI.
//!
//! Avila, Donha and Adamowski, *Ocean Engineering* 60 (2013): Table 3 (surge drag), Table 7 (yaw drag).

use crate::frame::Dof;

/// Printed value and standard deviation of `name` in a stage of the paper; `None` if there is none.
pub(super) fn of(stage: &str, dof: Dof, name: &str) -> Option<(f64, f64)> {
    let table: &[(&str, f64, f64)] = match (stage, dof) {
        ("towing", Dof::Surge) => &[("k_u|u|", 368.48, 3.81), ("k_u", 10.84, 3.48), ("b_u", -0.23, 0.71)],
        ("steady", Dof::Surge) => &[("k_u|u|", 309.07, 18.80), ("k_u", 82.30, 16.61), ("b_u", -3.66, 3.26)],
        ("steady clockwise", Dof::Yaw) => &[("k_r|r|", 95.32, 5.93), ("k_r", 12.78, 7.79), ("b_r", -1.10, 2.35)],
        ("steady anticlockwise", Dof::Yaw) => &[("k_r|r|", 94.72, 5.31), ("k_r", 18.21, 7.15), ("b_r", -2.53, 2.24)],
        _ => return None,
    };
    table.iter().find(|(n, ..)| *n == name).map(|(_, value, std)| (*value, *std))
}
