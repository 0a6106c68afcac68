//! Velocities that all thrusters push the wrong way: more likely the velocity has the opposite sign.
//!
//! ```text
//! wrong in one degree of freedom, right in the others      the column of that velocity
//! wrong in sway, heave, pitch or yaw, right in surge       the frame: forward-port-up (flu)
//! wrong in all, or both ways in one                        the commands, or the places of the thrusters
//! ```
//!
//! A thruster acts in several degrees of freedom at once, and a wrong sign of its command shows in
//! all of them. A velocity with the opposite sign shows in one alone, but so does an axis that is
//! reversed in the placement of the thrusters. Other channels distinguish the two: a rate is compared
//! with its angle, w with the slope of the depth, and the Coriolis force depends on the velocities,
//! whatever the thrusters do.
//!
//! ```text
//! u̇ = … + (m_v/m_u) v r,      v̇ = … − (m_u/m_v) u r,      ẇ = … + (m_u/m_w) u q
//! ```
//!
//! If one of them confirms the column, the finding is about the thrusters. Source: Fossen (2011), (6.53).

use super::balance::{Balance, Term};
use super::codes;
use super::report::{Agreement, FaultKind, Found};
use crate::frame::Dof;

/// Standard deviations from zero at which a Coriolis term is significant.
const CERTAIN: f64 = 5.0;

/// Explanation other than the thrusters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Instead {
    /// The column of this velocity.
    Column(Dof),
    /// The body axes, shown by these velocities.
    Frame(Vec<Dof>),
}

/// Returns what explains `answers` more simply than the thrusters do. `answers`: degrees of
/// freedom, and whether a thruster pushes each the right way; `holds` tells whether other channels
/// confirm the sign of a velocity.
pub fn instead(answers: &[(Dof, bool)], holds: impl Fn(Dof) -> bool) -> Option<Instead> {
    let any = |dof: Dof, right: bool| answers.contains(&(dof, right));
    let wrong: Vec<Dof> = Dof::ALL.into_iter().filter(|dof| any(*dof, false)).collect();
    let right: Vec<Dof> = Dof::ALL.into_iter().filter(|dof| any(*dof, true)).collect();
    if right.is_empty() || wrong.iter().any(|dof| right.contains(dof)) {
        return None;
    }
    let mirrored = |dof: &Dof| !matches!(dof, Dof::Surge | Dof::Roll);
    match &wrong[..] {
        [only] => (!holds(*only)).then_some(Instead::Column(*only)),
        [_, _, ..] if wrong.iter().all(mirrored) && !right.iter().any(mirrored) => Some(Instead::Frame(wrong)),
        _ => None,
    }
}

/// Returns the finding about this explanation; `answers` as in [`instead`].
pub fn judge(instead: &Instead, answers: &[(Dof, bool)]) -> Found {
    let right: Vec<&str> =
        Dof::ALL.into_iter().filter(|dof| answers.contains(&(*dof, true))).map(Dof::velocity).collect();
    let right = right.join(", ");
    match instead {
        Instead::Column(dof) => {
            let v = dof.velocity();
            let text = format!(
                "{v} opposes all thrusters that push {dof}, while {right} agree: most likely {v} has the opposite \
                 sign; set columns.{v}.sign = -1"
            );
            Found::new(&codes::COMMAND_SIGN, &[v], text).fault(FaultKind::Sign, v, -1.0)
        }
        Instead::Frame(dofs) => {
            let wrong: Vec<&str> = dofs.iter().map(|dof| dof.velocity()).collect();
            let text = format!(
                "{} oppose all thrusters, while {right} agree: most likely the body axes are forward-port-up; set \
                 body_frame = \"flu\"",
                wrong.join(", ")
            );
            Found::new(&codes::COMMAND_SIGN, &wrong, text)
        }
    }
}

/// Whether other channels confirm the sign of the column of this velocity; `agreements`
/// are those with angles, positions and depth.
pub fn holds(dof: Dof, agreements: &[Agreement], balances: &[Balance]) -> bool {
    let compared = |a: &Agreement| a.angle.map_or(a.factor, |angle| a.factor.abs() * angle.cos());
    let agrees = agreements.iter().any(|a| a.channel == dof.velocity() && compared(a) > 0.0);
    agrees || balances.iter().find(|b| b.dof == dof).and_then(coriolis).is_some_and(|c| c > 0.0)
}

/// Returns the Coriolis term of a balance, positive if it has the right sign; `None` if it is not
/// significant.
fn coriolis(balance: &Balance) -> Option<f64> {
    let (of, sign) = match balance.dof {
        Dof::Surge => (("v", "r"), 1.0),
        Dof::Sway => (("u", "r"), -1.0),
        Dof::Heave => (("u", "q"), 1.0),
        _ => return None,
    };
    let k = balance.terms.iter().position(|term| *term == Term::Product(of.0, of.1))?;
    let fit = balance.fit(0.0)?;
    (fit.theta[k].abs() > CERTAIN * fit.std[k]).then_some(sign * fit.theta[k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use Dof::{Heave, Pitch, Roll, Surge, Sway, Yaw};

    #[test]
    fn one_velocity_that_all_thrusters_accuse_is_its_column() {
        let free = |_: Dof| false;
        let answers = [(Surge, true), (Sway, false), (Sway, false), (Yaw, true)];
        assert_eq!(instead(&answers, free), Some(Instead::Column(Sway)));
        let said = judge(&Instead::Column(Sway), &answers);
        assert!(said.text.starts_with("v opposes all thrusters that push sway, while u, r agree"), "{}", said.text);
        assert_eq!(instead(&answers, |dof| dof == Sway), None, "other channels say that v is right");
        assert_eq!(instead(&[(Sway, false)], free), None, "nothing else answers");
        assert_eq!(instead(&[(Sway, false), (Sway, true), (Surge, true)], free), None, "one thruster of two");
        assert_eq!(instead(&[(Surge, false), (Sway, false)], free), None, "all");
        assert_eq!(instead(&[(Surge, true), (Sway, true)], free), None, "none");
    }

    #[test]
    fn all_velocities_but_surge_are_the_frame() {
        let free = |_: Dof| false;
        let flu = [(Surge, true), (Sway, false), (Heave, false), (Yaw, false), (Roll, true)];
        assert_eq!(instead(&flu, free), Some(Instead::Frame(vec![Sway, Heave, Yaw])));
        assert_eq!(instead(&[(Surge, true), (Sway, false), (Yaw, false), (Heave, true)], free), None);
        assert_eq!(instead(&[(Pitch, false), (Surge, false), (Sway, true)], free), None);
    }
}
