//! The acting force from the nominal force, equation (16).
//!
//! ```text
//! τ = η_inter η_adv τ_nom
//! ```
//!
//! τ_nom is the force of the thrusters at bollard pull, each alone (N, N·m); η_inter the loss by
//! interaction ([`super::interaction`]), η_adv the loss by advance ([`super::advance`]). The paper
//! uses the speed of the vehicle as the advance speed of every thruster, and names this as a source
//! of error: its front thrusters stand 36° off the axis. The alternative is the speed along each
//! thruster's own axis. Source: Avila, Donha and Adamowski, *Ocean Engineering* 60 (2013) 81-94,
//! eq. (16).

use nalgebra::{Vector3, Vector6};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::advance::{Advance, AdvanceLoss, Coverage};
use super::interaction::InteractionTable;
use super::thruster::Thruster;
use crate::frame::Dof;

/// Definition of a thruster's advance speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AdvanceSpeed {
    /// The speed of the vehicle, |(u, v, w)|, as in the paper.
    #[default]
    Vehicle,
    /// The speed of the thruster through the water along its own axis, s·(v + ω × p).
    ThrusterAxis,
}

/// The `[efficiency]` table of a campaign; without it there is no loss.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Efficiency {
    /// Loss by interaction.
    pub eta_inter: InteractionTable,
    /// Loss by advance; none if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eta_adv: Option<AdvanceLoss>,
    /// Definition of a thruster's advance speed.
    pub advance_speed: AdvanceSpeed,
}

/// An acting force, and the coverage of its efficiency by measurements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Delivered<T> {
    /// Force or wrench, N and N·m.
    pub force: T,
    /// Coverage of η_adv at this advance speed; the worst of several thrusters.
    pub coverage: Coverage,
}

/// The reason why efficiencies are impossible or cannot be fitted.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum EfficiencyError {
    /// η_inter is not positive and finite.
    #[error("eta_inter of {dof} = {value}: must be a positive number, near 1")]
    BadInteraction {
        /// Degree of freedom.
        dof: Dof,
        /// The given value.
        value: f64,
    },
    /// A group of thrusters has two efficiencies.
    #[error("eta_inter of {dof} with thrusters {thrusters:?} is given twice")]
    SameGroup {
        /// Degree of freedom.
        dof: Dof,
        /// The group.
        thrusters: Vec<String>,
    },
    /// η_adv is not finite, or has no positive intercept or no valid range.
    #[error("eta_adv {{ slope = {}, intercept = {}, valid = {:?} }}: needs a positive intercept and a range of speeds from 0 or above", .loss.slope, .loss.intercept, .loss.valid)]
    BadAdvance {
        /// The given value.
        loss: AdvanceLoss,
    },
    /// Two lists have different lengths.
    #[error("one {second} per {first} is needed, but there are {rows} and {others} values")]
    Lengths {
        /// First list.
        first: &'static str,
        /// Second list.
        second: &'static str,
        /// Length of the first.
        rows: usize,
        /// Length of the second.
        others: usize,
    },
    /// A value is not finite.
    #[error("{column}, row {row} (counted from 1) = {value}: must be finite")]
    NotFinite {
        /// Which list.
        column: &'static str,
        /// Which row, counted from 1.
        row: usize,
        /// The value.
        value: f64,
    },
    /// There are too few rows.
    #[error("{rows} rows: an efficiency with its standard deviation needs at least {needed}")]
    TooFewRows {
        /// How many there are.
        rows: usize,
        /// How many are needed.
        needed: usize,
    },
    /// The data does not determine the efficiency.
    #[error("the data does not determine the efficiency: it needs {needs}")]
    NotIdentifiable {
        /// What is missing.
        needs: &'static str,
    },
}

impl EfficiencyError {
    /// Checks that two lists have the same length, enough rows and finite values.
    pub(super) fn check(a: (&'static str, &[f64]), b: (&'static str, &[f64]), needed: usize) -> Result<(), Self> {
        let (rows, others) = (a.1.len(), b.1.len());
        if rows != others {
            return Err(EfficiencyError::Lengths { first: a.0, second: b.0, rows, others });
        }
        for (column, values) in [a, b] {
            if let Some(row) = values.iter().position(|v| !v.is_finite()) {
                return Err(EfficiencyError::NotFinite { column, row: row + 1, value: values[row] });
            }
        }
        if rows < needed {
            return Err(EfficiencyError::TooFewRows { rows, needed });
        }
        Ok(())
    }
}

impl Efficiency {
    /// The acting force in one degree of freedom, N or N·m, at an advance speed v_a (m/s, positive
    /// if thrust is along the motion), while the named thrusters run.
    pub fn force(&self, dof: Dof, running: &[&str], nominal: f64, v_a: f64) -> Delivered<f64> {
        let advance = self.advance(v_a);
        let eta = self.eta_inter.value(dof, running) * advance.efficiency;
        Delivered { force: eta * nominal, coverage: advance.coverage }
    }

    /// The acting wrench, N and N·m, for the nominal force (N) of each thruster while the vehicle
    /// moves with ν relative to the water (m/s, rad/s): η_adv on each thruster, η_inter on each
    /// degree of freedom of the sum.
    pub fn wrench(&self, thrusters: &[Thruster], forces: &[f64], nu: &Vector6<f64>) -> Delivered<Vector6<f64>> {
        let mut total = Delivered { force: Vector6::zeros(), coverage: Coverage::Covered };
        let mut running = vec![];
        for (thruster, &force) in thrusters.iter().zip(forces).filter(|(_, force)| force.abs() > 0.0) {
            running.push(thruster);
            let advance = self.advance(self.advance_of(thruster, force, nu));
            total.force += thruster.unit_wrench() * (advance.efficiency * force);
            total.coverage = total.coverage.max(advance.coverage);
        }
        for dof in Dof::ALL {
            // the group of a degree of freedom consists of the running thrusters that push in it
            let pushes = |t: &&&Thruster| t.pushes(dof);
            let group: Vec<&str> = running.iter().filter(pushes).map(|t| t.name.as_str()).collect();
            total.force[dof.index()] *= self.eta_inter.value(dof, &group);
        }
        total
    }

    /// Advance speed of one thruster, m/s: positive where it moves in the direction in which it
    /// pushes.
    pub fn advance_of(&self, thruster: &Thruster, force: f64, nu: &Vector6<f64>) -> f64 {
        let velocity = Vector3::new(nu[0], nu[1], nu[2]);
        let omega = Vector3::new(nu[3], nu[4], nu[5]);
        let push = thruster.direction() * force.signum();
        match self.advance_speed {
            // thrust at right angles to the motion is not against it
            AdvanceSpeed::Vehicle if push.dot(&velocity) < 0.0 => -velocity.norm(),
            AdvanceSpeed::Vehicle => velocity.norm(),
            AdvanceSpeed::ThrusterAxis => push.dot(&(velocity + omega.cross(&Vector3::from(thruster.position)))),
        }
    }

    /// η_adv at an advance speed v_a, m/s; 1 if no loss is given.
    pub fn advance(&self, v_a: f64) -> Advance {
        self.eta_adv.map_or(Advance { efficiency: 1.0, coverage: Coverage::Covered }, |loss| loss.at(v_a))
    }

    /// Checks the efficiencies.
    ///
    /// # Errors
    /// As [`InteractionTable::validate`] and [`AdvanceLoss::validate`].
    pub fn validate(&self) -> Result<(), EfficiencyError> {
        self.eta_inter.validate()?;
        self.eta_adv.map_or(Ok(()), |loss| loss.validate())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thrust::laurs;

    const TEXT: &str =
        "eta_inter = { surge = 0.97 }\neta_adv = { slope = -0.1946, intercept = 0.9967, valid = [0, 1] }";

    #[test]
    fn paper_force_in_surge() {
        let efficiency: Efficiency = toml::from_str(TEXT).unwrap();
        efficiency.validate().unwrap();
        // 0.97 (−0.1946·0.5 + 0.9967)·200, by hand
        let acting = efficiency.force(Dof::Surge, &["T5", "T6"], 200.0, 0.5);
        assert!((acting.force - 0.97 * 0.8994 * 200.0).abs() < 1e-12 && acting.coverage == Coverage::Covered);
        assert_eq!(efficiency.force(Dof::Surge, &[], 200.0, 1.5).coverage, Coverage::OutOfRange);
        assert!((Efficiency::default().force(Dof::Surge, &[], 200.0, 1.5).force - 200.0).abs() <= 0.0);
        assert!(toml::from_str::<Efficiency>("eta_advance = 1").is_err());
    }

    #[test]
    fn law_by_thruster_and_by_degree_of_freedom_agree_in_straight_surge() {
        let thrusters = laurs::thrusters();
        let efficiency: Efficiency = toml::from_str(TEXT).unwrap();
        let forces: Vec<f64> =
            thrusters.iter().map(|t| if ["T5", "T6"].contains(&t.name.as_str()) { 100.0 } else { 0.0 }).collect();
        let nu = Vector6::new(0.6, 0.0, 0.0, 0.0, 0.0, 0.0);
        let acting = efficiency.wrench(&thrusters, &forces, &nu);
        let nominal = 200.0 * 36.0_f64.to_radians().cos();
        let whole = efficiency.force(Dof::Surge, &["T5", "T6"], nominal, 0.6);
        assert!((acting.force[0] - whole.force).abs() < 1e-10, "rounding only");
        assert_eq!(acting.coverage, whole.coverage);
    }

    #[test]
    fn the_thrusters_own_axis_sees_less_speed() {
        let thrusters = laurs::thrusters();
        let front = thrusters.iter().find(|t| t.name == "T5").unwrap();
        let own = Efficiency { advance_speed: AdvanceSpeed::ThrusterAxis, ..Efficiency::default() };
        let nu = Vector6::new(0.6, 0.0, 0.0, 0.0, 0.0, 0.0);
        let along = 0.6 * 36.0_f64.to_radians().cos();
        // rounding only; a push astern moves against itself
        assert!((own.advance_of(front, 50.0, &nu) - along).abs() < 1e-14);
        assert!((own.advance_of(front, -50.0, &nu) + along).abs() < 1e-14);
        assert!((Efficiency::default().advance_of(front, -50.0, &nu) + 0.6).abs() < 1e-15);
        // turning alone moves a thruster through the water too
        let turn = Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.4);
        assert!((own.advance_of(front, 50.0, &turn) - 0.4 * front.unit_wrench()[5]).abs() < 1e-14);
        assert!(Efficiency::default().advance_of(front, 50.0, &turn).abs() <= 0.0);
    }
}
