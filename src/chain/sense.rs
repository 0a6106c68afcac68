//! The logged values as functions of the states: the last link of the chain.

use super::attitude::turn;
use crate::effects::{Instant, Logged, Six};
use crate::frame::Dof;
use crate::model::Model;
use crate::navigation::upright;
use crate::symbolic::{Expr, Leaf};

/// The logged values by column. `memory`: states of each term; `quaternion`: the attitude and the
/// logged one, if the attitude is a quaternion.
pub(super) fn sense<'g>(
    at: &Instant<'g>,
    model: &Model,
    (theta, parameters): (&dyn Fn(usize) -> Vec<Expr<'g>>, &[Expr<'g>]),
    memory: &[Vec<Expr<'g>>],
    pose: &Six<'g>,
    quaternion: Option<([Expr<'g>; 4], [Expr<'g>; 4])>,
) -> Vec<(String, Expr<'g>)> {
    let mut log = Logged { nu: at.nu_logged, position: at.position, attitude: at.attitude };
    for (k, term) in model.terms.iter().enumerate() {
        let before = log.clone();
        term.effect.sense(at, term.place, &theta(k), &memory[k], &mut log);
        if let Some(blend) = term.blend {
            log = log.blended(&before, parameters[blend]);
        }
    }
    let velocities = model.dofs.iter().map(|dof| (dof.velocity().to_string(), log.nu[dof.index()]));
    let carried = |dof: &Dof| {
        let own = pose[dof.index()].leaves() == [Leaf::State(6 + dof.index() as u16)];
        own || (dof.is_rotation() && at.turned.is_some())
    };
    let positions = Dof::ALL.into_iter().filter(carried);
    let logged_pose = |dof: Dof| {
        if dof.is_rotation() { log.attitude[dof.index() - 3] } else { log.position[dof.index()] }
    };
    let observed = model.observers.iter().map(|observer| (observer.channel().to_string(), observer.express(at)));
    let turns = quaternion.map(|(own, logged)| {
        let errs = (0..3).any(|k| !(log.attitude[k] - at.attitude[k]).is_zero());
        turn(own, errs.then_some(log.attitude), logged)
    });
    let turns = turns.into_iter().flat_map(|turns| upright::TURNS.map(str::to_string).into_iter().zip(turns));
    velocities
        .chain(positions.map(|dof| (dof.position().to_string(), logged_pose(dof))))
        .chain(turns)
        .chain(observed)
        .collect()
}
