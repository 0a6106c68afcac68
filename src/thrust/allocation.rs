//! Allocation: conversion between the forces of n thrusters and the wrench of the vehicle.
//!
//! ```text
//! τ = B F,   B = [ sᵢ ; pᵢ × sᵢ ]  (6 × n)          F = B⁺ τ
//! ```
//!
//! F are the forces along the thrusters' axes (N), τ the wrench at the body origin (N, N·m), s and
//! p axis and position. B⁺ is the pseudo-inverse by singular values: of all forces that give the
//! wrench, those of least norm; if none give it, those with the nearest wrench (N and N·m have the
//! same weight). Source: Fossen, *Handbook of Marine Craft* (2011), section 12.3.

use faer::Mat;
use nalgebra::Vector6;
use thiserror::Error;

use super::curve::ThrustCurve;
use super::thruster::{Thruster, ThrusterError};

/// Ratio to the greatest singular value below which one counts as zero: a direction that only
/// rounding of the positions makes possible would need absurd forces.
const RANK_TOLERANCE: f64 = 1e-9;

/// The geometry of a set of thrusters, for both directions of the conversion.
#[derive(Debug, Clone)]
pub struct Allocation {
    columns: Vec<Vector6<f64>>,
    inverse_rows: Vec<Vector6<f64>>,
    curves: Vec<ThrustCurve>,
    rank: usize,
}

/// Forces and commands for a wanted wrench.
#[derive(Debug, Clone, PartialEq)]
pub struct Allocated {
    /// Force of each thruster, limited to its range, N.
    pub forces: Vec<f64>,
    /// Command of each thruster, as V.
    pub commands: Vec<f64>,
    /// Whether each thruster is at its limit.
    pub saturated: Vec<bool>,
    /// The wrench that these forces give, N and N·m.
    pub wrench: Vector6<f64>,
    /// Greatest part of the wanted wrench, 0 to 1, that this allocation gives with no thruster at
    /// its limit.
    pub part: f64,
}

/// The reason why no allocation is possible.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum AllocationError {
    /// There is no thruster.
    #[error("an allocation needs at least one thruster")]
    NoThruster,
    /// A thruster that cannot be used.
    #[error(transparent)]
    Thruster(#[from] ThrusterError),
    /// The singular value decomposition did not converge.
    #[error("the allocation of {thrusters} thrusters has no pseudo-inverse: check the size of the positions")]
    NoInverse {
        /// How many thrusters.
        thrusters: usize,
    },
}

impl Allocation {
    /// The allocation of any number of thrusters at any position and axis.
    ///
    /// # Errors
    /// No thruster, an unusable one, or two with one name.
    pub fn new(thrusters: &[Thruster]) -> Result<Allocation, AllocationError> {
        if thrusters.is_empty() {
            return Err(AllocationError::NoThruster);
        }
        for (i, thruster) in thrusters.iter().enumerate() {
            thruster.validate()?;
            if thrusters[..i].iter().any(|other| other.name == thruster.name) {
                return Err(ThrusterError::SameName { name: thruster.name.clone() }.into());
            }
        }
        let columns: Vec<_> = thrusters.iter().map(Thruster::unit_wrench).collect();
        let (inverse_rows, rank) =
            pseudo_inverse(&columns).ok_or(AllocationError::NoInverse { thrusters: thrusters.len() })?;
        Ok(Allocation { columns, inverse_rows, curves: thrusters.iter().map(Thruster::curve).collect(), rank })
    }

    /// Number of thrusters n.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Always false: an allocation has at least one thruster.
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// Rank of B: number of independent wrenches of the thrusters, up to 6.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Wrench τ = B F of the n thruster forces (N), in N and N·m.
    pub fn wrench(&self, forces: &[f64]) -> Vector6<f64> {
        self.columns.iter().zip(forces).map(|(column, force)| column * *force).sum()
    }

    /// Forces and commands for a wanted wrench (N, N·m): F = B⁺ τ, each limited to the range of its
    /// thruster.
    pub fn allocate(&self, wanted: &Vector6<f64>) -> Allocated {
        let asked: Vec<f64> = self.inverse_rows.iter().map(|row| row.dot(wanted)).collect();
        let found: Vec<_> = self.curves.iter().zip(&asked).map(|(curve, force)| curve.inverse(*force)).collect();
        let forces: Vec<f64> = found.iter().map(|command| command.force).collect();
        let part = found.iter().zip(&asked).filter(|(c, _)| c.saturated).map(|(c, asked)| c.force / asked);
        Allocated {
            part: part.fold(1.0, f64::min),
            commands: found.iter().map(|command| command.voltage).collect(),
            saturated: found.iter().map(|command| command.saturated).collect(),
            wrench: self.wrench(&forces),
            forces,
        }
    }
}

/// Rows of B⁺ = V Σ⁺ Uᵀ, and the rank of B; `None` if the decomposition fails.
fn pseudo_inverse(columns: &[Vector6<f64>]) -> Option<(Vec<Vector6<f64>>, usize)> {
    let b = Mat::from_fn(6, columns.len(), |row, column| columns[column][row]);
    let svd = b.thin_svd().ok()?;
    let (u, s, v) = (svd.U(), svd.S().column_vector(), svd.V());
    let rank = (0..s.nrows()).filter(|&k| s[k] > RANK_TOLERANCE * s[0]).count();
    let row = |thruster: usize| {
        Vector6::from_fn(|dof, _| (0..rank).map(|k| v[(thruster, k)] * u[(dof, k)] / s[k]).sum::<f64>())
    };
    Some(((0..columns.len()).map(row).collect(), rank))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thrust::curve::Coefficients;
    use proptest::prelude::*;

    fn thruster(name: &str, position: [f64; 3], axis: [f64; 3]) -> Thruster {
        let side = Coefficients { a: 11.53, b: 4.21 };
        Thruster {
            name: name.into(),
            position,
            axis,
            forward: side,
            reverse: side,
            deadband: 0.0,
            max: Some(5.0),
            neutral: None,
            span: None,
            supply: None,
            bollard: None,
        }
    }

    /// Four horizontal thrusters at 45° and four vertical ones: all six degrees of freedom.
    fn eight() -> Vec<Thruster> {
        let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        let horizontal = corners
            .iter()
            .enumerate()
            .map(|(i, &(x, y))| thruster(&format!("H{i}"), [0.5 * x, 0.4 * y, 0.0], [1.0, -x * y, 0.0]));
        let vertical = corners
            .iter()
            .enumerate()
            .map(|(i, &(x, y))| thruster(&format!("V{i}"), [0.3 * x, 0.2 * y, -0.1], [0.0, 0.0, 1.0]));
        horizontal.chain(vertical).collect()
    }

    proptest! {
        #[test]
        fn law_allocation_and_back_gives_the_wanted_wrench(w in prop::array::uniform6(-20.0..20.0_f64)) {
            let allocation = Allocation::new(&eight()).unwrap();
            prop_assert_eq!(allocation.rank(), 6);
            let wanted = Vector6::from(w);
            let out = allocation.allocate(&wanted);
            prop_assert!(!out.saturated.iter().any(|s| *s) && (out.part - 1.0).abs() <= 0.0);
            // condition of B about 5: rounding only
            prop_assert!((out.wrench - wanted).amax() < 1e-11);
            let pushed: Vec<f64> = allocation.curves.iter().zip(&out.commands).map(|(c, v)| c.force(*v)).collect();
            prop_assert!((allocation.wrench(&pushed) - wanted).amax() < 1e-11);
        }

        #[test]
        fn law_no_forces_with_the_same_wrench_are_smaller(f in prop::array::uniform8(-50.0..50.0_f64)) {
            let allocation = Allocation::new(&eight()).unwrap();
            let least = allocation.allocate(&allocation.wrench(&f)).forces;
            let size = |f: &[f64]| f.iter().map(|f| f * f).sum::<f64>();
            prop_assert!(size(&least) <= size(&f) * (1.0 + 1e-12));
        }
    }

    #[test]
    fn saturation_is_reported_with_what_is_left() {
        let allocation = Allocation::new(&eight()).unwrap();
        let most = allocation.curves[0].range().1;
        // four horizontal thrusters at 45° give 4·F/√2 of surge
        let limit = 4.0 * most / 2.0_f64.sqrt();
        let out = allocation.allocate(&Vector6::new(2.0 * limit, 0.0, 0.0, 0.0, 0.0, 0.0));
        assert_eq!(out.saturated, [true, true, true, true, false, false, false, false]);
        assert!((out.part - 0.5).abs() < 1e-12, "half of what is wanted: rounding only");
        assert!((out.wrench[0] - limit).abs() < 1e-9 * limit, "rounding only");
    }

    #[test]
    fn a_wrench_out_of_reach_comes_as_near_as_can_be() {
        // two thrusters side by side give surge and yaw, and nothing else
        let pair = [thruster("L", [0.0, -0.3, 0.0], [1.0, 0.0, 0.0]), thruster("R", [0.0, 0.3, 0.0], [1.0, 0.0, 0.0])];
        let allocation = Allocation::new(&pair).unwrap();
        assert_eq!(allocation.rank(), 2);
        let out = allocation.allocate(&Vector6::new(10.0, 5.0, 5.0, 0.0, 0.0, 3.0));
        // F = (10 ± 3/0.3)/2 by hand
        assert!((out.forces[0] - 10.0).abs() < 1e-12 && out.forces[1].abs() < 1e-12, "{out:?}");
        assert!((out.wrench - Vector6::new(10.0, 0.0, 0.0, 0.0, 0.0, 3.0)).amax() < 1e-12);
    }

    #[test]
    fn parallel_thrusters_on_one_spot_share_the_load() {
        let one = |name| thruster(name, [0.0; 3], [1.0, 0.0, 0.0]);
        let allocation = Allocation::new(&[one("A"), one("B"), one("C")]).unwrap();
        assert_eq!(allocation.rank(), 1);
        let out = allocation.allocate(&Vector6::new(30.0, 0.0, 0.0, 0.0, 0.0, 0.0));
        assert!(out.forces.iter().all(|f| (f - 10.0).abs() < 1e-12));
    }

    #[test]
    fn what_cannot_be_put_together_is_said() {
        assert_eq!(Allocation::new(&[]).unwrap_err(), AllocationError::NoThruster);
        let one = thruster("A", [0.0; 3], [1.0, 0.0, 0.0]);
        let same = Allocation::new(&[one.clone(), one.clone()]).unwrap_err();
        assert_eq!(same.to_string(), "two thrusters are called \"A\": each needs its own name");
        assert!(Allocation::new(&[Thruster { axis: [0.0; 3], ..one }]).is_err());
    }
}
