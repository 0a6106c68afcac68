//! The symbols that a formula may read: the quantities at one instant of the chain.

use std::collections::BTreeMap;

use crate::frame::Dof;
use crate::symbolic::{Expr, Graph};
use crate::units::Dimension;

/// Six formulas, one for each degree of freedom, in the order of ν.
pub type Six<'g> = [Expr<'g>; 6];

/// Names of channels that are derived from a run rather than logged.
pub mod channel {
    use crate::frame::Dof;

    /// Supply voltage over its mean in the campaign, 1.
    pub const SUPPLY_RATIO: &str = "supply_voltage_ratio";
    /// Position north at the start of the run, m.
    pub const ANCHOR_NORTH: &str = "anchor_north";
    /// Position east at the start of the run, m.
    pub const ANCHOR_EAST: &str = "anchor_east";
    /// Name of the channel with the Keulegan-Carpenter number of a run in `dof`, 1; constant over a run.
    pub fn keulegan_carpenter(dof: Dof) -> String {
        format!("KC_{}", dof.velocity())
    }
}

/// Symbols of one instant. Velocities and forces are in body axes, SI.
#[derive(Debug, Clone)]
pub struct Instant<'g> {
    /// Graph that holds the formulas.
    pub graph: &'g Graph,
    /// Time of the run, s.
    pub time: Expr<'g>,
    /// ν: velocity over ground, m/s and rad/s.
    pub nu: Six<'g>,
    /// ν_r: velocity through the water, m/s and rad/s; ν where no current is modelled.
    pub nu_r: Six<'g>,
    /// Velocity that the log measures: ν_r if against the water, else ν.
    pub nu_logged: Six<'g>,
    /// Position north, east, down, m.
    pub position: [Expr<'g>; 3],
    /// φ, θ, ψ, rad.
    pub attitude: [Expr<'g>; 3],
    /// R if the attitude is described by something other than angles.
    pub turned: Option<[[Expr<'g>; 3]; 3]>,
    /// τ: nominal force, as commanded, N and N·m.
    pub command: Six<'g>,
    /// π: total momentum, for the Coriolis terms; kg·m/s and kg·m²/s.
    pub momentum: Six<'g>,
    /// Degrees of freedom that the model simulates.
    pub dofs: Vec<Dof>,
    /// Weight of the vehicle, N.
    pub weight: f64,
    /// Further channels by name.
    pub channels: BTreeMap<String, Expr<'g>>,
}

impl<'g> Instant<'g> {
    /// A channel that the effect has declared; 0 if it has not declared it.
    pub fn channel(&self, name: &str) -> Expr<'g> {
        self.channels.get(name).copied().unwrap_or(self.graph.zero())
    }

    /// The symbol of a name in a user's formula: a state, a command, the time `t`, else a declared
    /// channel.
    pub fn named(&self, name: &str) -> Expr<'g> {
        let of = |dof: Dof| {
            let i = dof.index();
            let pose = if dof.is_rotation() { self.attitude[i - 3] } else { self.position[i] };
            [(dof.velocity(), self.nu[i]), (dof.position(), pose), (dof.force(), self.command[i])]
        };
        let known = Dof::ALL.into_iter().flat_map(of).find(|(known, _)| *known == name);
        match known {
            Some((_, symbol)) => symbol,
            None if name == "t" => self.time,
            None => self.channel(name),
        }
    }

    /// A known number with a unit.
    pub fn unit(&self, dimension: Dimension, value: f64) -> Expr<'g> {
        self.graph.quantity(value, dimension)
    }

    /// Whether the model simulates this degree of freedom.
    pub fn models(&self, dof: Dof) -> bool {
        self.dofs.contains(&dof)
    }

    /// A vector of earth axes in body axes, Rᵀ x.
    pub fn to_body(&self, x: [Expr<'g>; 3]) -> [Expr<'g>; 3] {
        let r = self.rotation();
        std::array::from_fn(|i| r[0][i] * x[0] + r[1][i] * x[1] + r[2][i] * x[2])
    }

    /// A vector of body axes in earth axes, R x. A planar model is taken as level.
    pub fn to_earth(&self, x: [Expr<'g>; 3]) -> [Expr<'g>; 3] {
        let zero = self.graph.zero();
        let attitude = if self.is_planar() { [zero, zero, self.attitude[2]] } else { self.attitude };
        let r = Instant { attitude, ..self.clone() }.rotation();
        std::array::from_fn(|i| r[i][0] * x[0] + r[i][1] * x[1] + r[i][2] * x[2])
    }

    /// Velocity over ground, north, east and down, R (u, v, w). A planar model has a vertical
    /// velocity only if it models heave.
    pub fn over_ground(&self) -> [Expr<'g>; 3] {
        let [u, v, w, ..] = self.nu;
        let sinks = !self.is_planar() || self.models(Dof::Heave);
        self.to_earth([u, v, if sinks { w } else { self.graph.zero() }])
    }

    /// Indices in ν of the turn rates that the model simulates.
    pub fn rotations(&self) -> impl Iterator<Item = usize> {
        self.dofs.iter().filter(|dof| dof.is_rotation()).map(|dof| dof.index())
    }

    /// Indices in ν of the velocities that the model simulates, without the turn rates.
    pub fn translations(&self) -> impl Iterator<Item = usize> {
        self.dofs.iter().filter(|dof| !dof.is_rotation()).map(|dof| dof.index())
    }

    /// Whether the model neither rolls nor pitches.
    pub fn is_planar(&self) -> bool {
        !self.models(Dof::Roll) && !self.models(Dof::Pitch)
    }

    /// R, from body to earth axes: R(φ, θ, ψ) of z-y-x Euler angles.
    pub fn rotation(&self) -> [[Expr<'g>; 3]; 3] {
        if let Some(turned) = self.turned {
            return turned;
        }
        let [phi, theta, psi] = self.attitude;
        let (sf, cf, st, ct, sp, cp) = (phi.sin(), phi.cos(), theta.sin(), theta.cos(), psi.sin(), psi.cos());
        [
            [cp * ct, cp * st * sf - sp * cf, cp * st * cf + sp * sf],
            [sp * ct, sp * st * sf + cp * cf, sp * st * cf - cp * sf],
            [-st, ct * sf, ct * cf],
        ]
    }

    /// Direction of gravity in body axes, (−sin θ, cos θ sin φ, cos θ cos φ).
    pub fn down(&self) -> [Expr<'g>; 3] {
        self.rotation()[2]
    }
}

/// Whether a user's formula reads this name from the log's further channels.
pub(super) fn is_channel(name: &str) -> bool {
    let known = |dof: &Dof| [dof.velocity(), dof.position(), dof.force()].contains(&name);
    name != "t" && !Dof::ALL.iter().any(known)
}

/// The values that the sensors log at an instant.
#[derive(Debug, Clone)]
pub struct Logged<'g> {
    /// Velocities and rates, m/s and rad/s.
    pub nu: Six<'g>,
    /// Position, m.
    pub position: [Expr<'g>; 3],
    /// φ, θ, ψ, rad.
    pub attitude: [Expr<'g>; 3],
}

impl<'g> Logged<'g> {
    /// The blend of `share` of this and 1 − `share` of `other`.
    pub(crate) fn blended(&self, other: &Logged<'g>, share: Expr<'g>) -> Logged<'g> {
        let mixed = |own: Expr<'g>, other: Expr<'g>| other + share * (own - other);
        Logged {
            nu: std::array::from_fn(|i| mixed(self.nu[i], other.nu[i])),
            position: std::array::from_fn(|i| mixed(self.position[i], other.position[i])),
            attitude: std::array::from_fn(|i| mixed(self.attitude[i], other.attitude[i])),
        }
    }
}
