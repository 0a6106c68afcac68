//! Degrees of freedom, frames and attitude.
//!
//! Body axes are forward, starboard, down; earth axes are north, east, down (SNAME 1950, Fossen 2011).
//! The velocity ν = (u, v, w, p, q, r) is in body axes, the position η = (x, y, z, φ, θ, ψ) in
//! earth axes, with roll φ, pitch θ and yaw ψ the z-y-x Euler angles: `R(φ, θ, ψ)` turns a vector
//! from body to earth axes, v_earth = R v_body.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// One of the six degrees of freedom of a rigid vehicle, in the order of ν.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Dof {
    /// Translation forward: velocity u, force X.
    Surge,
    /// Translation to starboard: velocity v, force Y.
    Sway,
    /// Translation down: velocity w, force Z.
    Heave,
    /// Rotation about the forward axis: rate p, moment K.
    Roll,
    /// Rotation about the starboard axis: rate q, moment M.
    Pitch,
    /// Rotation about the down axis: rate r, moment N.
    Yaw,
}

impl Dof {
    /// All six, in the order of ν.
    pub const ALL: [Dof; 6] = [Dof::Surge, Dof::Sway, Dof::Heave, Dof::Roll, Dof::Pitch, Dof::Yaw];

    /// Index in ν, 0 to 5.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Name as in a campaign file: `surge` … `yaw`.
    pub const fn name(self) -> &'static str {
        ["surge", "sway", "heave", "roll", "pitch", "yaw"][self as usize]
    }

    /// Symbol of the velocity: `u` … `r`. Also the name of its column in a log.
    pub const fn velocity(self) -> &'static str {
        ["u", "v", "w", "p", "q", "r"][self as usize]
    }

    /// Name of the column of the nominal force: `tau_u` … `tau_r`.
    pub const fn force(self) -> &'static str {
        ["tau_u", "tau_v", "tau_w", "tau_p", "tau_q", "tau_r"][self as usize]
    }

    /// Name of the column of the position or angle: `x`, `y`, `z`, `phi`, `theta`, `psi`.
    pub const fn position(self) -> &'static str {
        ["x", "y", "z", "phi", "theta", "psi"][self as usize]
    }

    /// Name of the column of the force measured by load cells: `load_u` … `load_r`.
    pub const fn load(self) -> &'static str {
        ["load_u", "load_v", "load_w", "load_p", "load_q", "load_r"][self as usize]
    }

    /// SNAME letter of the force or moment: `X`, `Y`, `Z`, `K`, `M`, `N`.
    pub const fn sname(self) -> &'static str {
        ["X", "Y", "Z", "K", "M", "N"][self as usize]
    }

    /// Whether the degree of freedom is a rotation (roll, pitch, yaw).
    pub const fn is_rotation(self) -> bool {
        self as usize >= 3
    }

    /// The degree of freedom with this name, `None` for an unknown one.
    pub fn from_name(name: &str) -> Option<Dof> {
        Dof::ALL.into_iter().find(|dof| dof.name() == name)
    }
}

impl std::fmt::Display for Dof {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// The measured quantity with which a simulation is compared: the velocity in a degree of freedom,
/// or a logged function of the states. Written as the name of the degree of freedom or the channel.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Measured {
    /// Velocity or rate in a degree of freedom.
    Velocity(Dof),
    /// Log channel with a function of the states.
    Function(Arc<str>),
}

impl Measured {
    /// Name of the column of the log.
    pub fn channel(&self) -> &str {
        match self {
            Measured::Velocity(dof) => dof.velocity(),
            Measured::Function(channel) => channel,
        }
    }

    /// The degree of freedom; `None` for a function of the states.
    pub const fn dof(&self) -> Option<Dof> {
        match self {
            Measured::Velocity(dof) => Some(*dof),
            Measured::Function(_) => None,
        }
    }

    /// The degree of freedom whose velocity, position or angle this is; `None` for another function
    /// of the states.
    pub fn along(&self) -> Option<Dof> {
        self.dof().or_else(|| Dof::ALL.into_iter().find(|dof| dof.position() == self.channel()))
    }

    /// Unit, SI: m/s, rad/s, m, rad; empty for a function of the states other than a position or an angle.
    pub fn unit(&self) -> &'static str {
        match (self.dof(), self.along()) {
            (Some(dof), _) if dof.is_rotation() => "rad/s",
            (Some(_), _) => "m/s",
            (None, Some(dof)) if dof.is_rotation() => "rad",
            (None, Some(_)) => "m",
            (None, None) => "",
        }
    }
}

impl std::fmt::Display for Measured {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Measured::Velocity(dof) => dof.fmt(f),
            Measured::Function(channel) => f.write_str(channel),
        }
    }
}

impl Serialize for Measured {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl From<Dof> for Measured {
    fn from(dof: Dof) -> Measured {
        Measured::Velocity(dof)
    }
}

impl PartialEq<Dof> for Measured {
    fn eq(&self, dof: &Dof) -> bool {
        self.dof() == Some(*dof)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_order_agree() {
        for (i, dof) in Dof::ALL.into_iter().enumerate() {
            assert_eq!(dof.index(), i);
            assert_eq!(Dof::from_name(dof.name()), Some(dof));
        }
        assert_eq!(Dof::from_name("drift"), None);
    }
}
