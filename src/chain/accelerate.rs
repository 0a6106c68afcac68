//! The accelerations, from the rate of change of momentum.
//!
//! ```text
//! d π(ν_r, …)/dt = f      ⇒      M ν̇ = f − Σ (∂π/∂s) ṡ,     M = ∂π/∂ν
//! ```
//!
//! s: the other changing quantities on which the momentum depends: the attitude, where the water
//! moves over ground (ν_r = ν − RᵀV), and channels that are logged instead of simulated, whose rate
//! is that of their interpolation.

use super::State;
use crate::effects::{Instant, Six};
use crate::frame::Dof;
use crate::symbolic::{Expr, Leaf};
use crate::units::Dimension;

/// ν̇ in the modelled degrees of freedom, in their order. `moving`: simulated states besides the
/// velocities; `inputs`: names of the input channels. The elimination has no pivoting: M is
/// symmetric and positive definite in any physical model.
pub(super) fn accelerations<'g>(
    at: &Instant<'g>,
    force: &Six<'g>,
    moving: &[State<'g>],
    inputs: &[String],
) -> Vec<Expr<'g>> {
    let n = at.dofs.len();
    let momentum: Vec<Expr<'g>> = at.dofs.iter().map(|dof| at.momentum[dof.index()]).collect();
    let by_velocity =
        |pi: &Expr<'g>| at.dofs.iter().map(|dof| pi.derivative(Leaf::State(dof.index() as u16))).collect();
    let mut m: Vec<Vec<Expr<'g>>> = momentum.iter().map(by_velocity).collect();
    let drift = |(dof, pi): (&Dof, &Expr<'g>)| force[dof.index()] - not_by_acceleration(at, *pi, moving, inputs);
    let mut f: Vec<Expr<'g>> = at.dofs.iter().zip(&momentum).map(drift).collect();
    for k in 0..n {
        for i in k + 1..n {
            if m[i][k].is_zero() {
                continue;
            }
            let factor = m[i][k] / m[k][k];
            for j in k..n {
                m[i][j] = m[i][j] - factor * m[k][j];
            }
            f[i] = f[i] - factor * f[k];
        }
    }
    for i in (0..n).rev() {
        for j in i + 1..n {
            f[i] = f[i] - m[i][j] * f[j];
        }
        f[i] = f[i] * (at.graph.constant(1.0) / m[i][i]);
    }
    f
}

/// Σ (∂π/∂s) ṡ.
fn not_by_acceleration<'g>(at: &Instant<'g>, pi: Expr<'g>, moving: &[State<'g>], inputs: &[String]) -> Expr<'g> {
    let mut sum = at.graph.zero();
    for leaf in pi.leaves() {
        let rate = match leaf {
            Leaf::Input(k) => logged_rate(&inputs[usize::from(k)]).map(|unit| at.graph.leaf(Leaf::Rate(k), unit)),
            _ => moving.iter().find(|state| state.leaf == leaf).map(|state| state.rate),
        };
        if let Some(rate) = rate {
            sum += pi.derivative(leaf) * rate;
        }
    }
    sum
}

/// Unit of the rate of a logged velocity or angle; `None` for a channel that is constant over a
/// run, such as a KC number.
fn logged_rate(channel: &str) -> Option<Dimension> {
    let velocity = Dof::ALL.into_iter().find(|dof| dof.velocity() == channel);
    let angle = Dof::ALL.into_iter().any(|dof| dof.is_rotation() && dof.position() == channel);
    match velocity {
        Some(dof) => Some(super::velocity_dimension(dof).over(Dimension::TIME)),
        None => angle.then_some(Dimension::RATE),
    }
}
