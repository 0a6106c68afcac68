//! Conversion from the axes of a file to forward-starboard-down and north-east-down.
//!
//! Forward-port-up is forward-starboard-down turned by π about the forward axis: the second and
//! third components of every vector change sign. East-north-up is north-east-down with x and y
//! exchanged and z reversed. With R = R_z(ψ) R_y(θ) R_x(φ) from body to earth axes, turning the
//! body axes adds π to φ; turning the earth axes gives ψ → π/2 − ψ, θ → −θ and adds π to φ. Both
//! together leave φ unchanged (ROS REP 103 to Fossen 2011).

use std::f64::consts::{FRAC_PI_2, PI};

use super::options::{BodyFrame, EarthFrame};
use crate::frame::Dof;

/// Change of one channel: `sign · x + offset`, and another name where axes are exchanged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn<'a> {
    /// Canonical name after the turn.
    pub name: &'a str,
    /// 1 or −1.
    pub sign: f64,
    /// Added after the sign, rad; 0 except for angles.
    pub offset: f64,
}

/// Returns the change of the channel of this canonical name.
pub fn turn(name: &str, body: BodyFrame, earth: EarthFrame) -> Turn<'_> {
    let (flu, enu) = (body == BodyFrame::Flu, earth == EarthFrame::Enu);
    let mut turn = Turn { name, sign: 1.0, offset: 0.0 };
    let in_body = |dof: &Dof| [dof.velocity(), dof.force(), dof.load()].contains(&name);
    if flu && Dof::ALL.iter().any(|dof| in_body(dof) && !matches!(dof, Dof::Surge | Dof::Roll)) {
        turn.sign = -1.0;
    }
    match name {
        "phi" if flu != enu => turn.offset = PI,
        "x" if enu => turn.name = "y",
        "y" if enu => turn.name = "x",
        "z" | "theta" if enu => turn.sign = -1.0,
        "psi" if enu => (turn.sign, turn.offset) = (-1.0, FRAC_PI_2),
        _ => {}
    }
    turn
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Rotation3};

    #[test]
    fn law_angles_turn_as_their_matrices_do() {
        let flip = Matrix3::from_diagonal(&[1.0, -1.0, -1.0].into());
        let swap = Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0);
        for (body, b) in [(BodyFrame::Frd, Matrix3::identity()), (BodyFrame::Flu, flip)] {
            for (earth, e) in [(EarthFrame::Ned, Matrix3::identity()), (EarthFrame::Enu, swap)] {
                let angle = |name, x: f64| {
                    let t = turn(name, body, earth);
                    t.sign * x + t.offset
                };
                let (phi, theta, psi) = (0.3, -0.4, 1.2);
                let given = Rotation3::from_euler_angles(phi, theta, psi).into_inner();
                let turned = Rotation3::from_euler_angles(angle("phi", phi), angle("theta", theta), angle("psi", psi));
                // two roundings per term
                assert!((e * given * b - turned.into_inner()).norm() < 1e-14);
            }
        }
    }

    #[test]
    fn vectors_turn_component_by_component() {
        let sign = |name| turn(name, BodyFrame::Flu, EarthFrame::Ned).sign;
        for name in ["v", "w", "q", "r", "tau_v", "tau_r", "load_w"] {
            assert!(sign(name) < 0.0, "{name}");
        }
        for name in ["u", "p", "tau_u", "x", "V1", "depth"] {
            assert!(sign(name) > 0.0, "{name}");
        }
        assert_eq!(turn("x", BodyFrame::Frd, EarthFrame::Enu).name, "y");
    }
}
