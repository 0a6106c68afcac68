//! Effects of the single thrusters of a campaign.
//!
//! ```text
//! b_T = η_inter (s, p × s)
//!       of thruster_loss@T, thruster_swap@T:U and thruster_advance_loss, on F_T η_adv
//! ```
//!
//! η_inter is the value for all thrusters together that push in that direction; η_adv is in the
//! channel of the force.

use std::sync::Arc;

use super::file::CampaignFile;
use crate::effects::{Effect, Place, SingleThruster, ThrusterAdvanceLoss, ThrusterLoss, ThrusterSwap};
use crate::frame::Dof;
use crate::procedure::acting_thruster_force;
use crate::run::thruster_force;
use crate::thrust::thruster::Thruster;

/// An effect with its place, as the discovery tries it.
pub type Own = (Arc<dyn Effect>, Place);

/// Reason why two existing thrusters cannot be exchanged.
pub(super) const UNLIKE: &str =
    "these two have different curves: exchanging their commands does not exchange their forces";

/// Reason why an effect of an existing thruster cannot be in the model.
pub(super) const IDLE: &str = "it does not change the force in any modelled degree of freedom";

/// Returns every effect of a single thruster, of every two thrusters with the same curve, and of
/// all thrusters.
pub(super) fn effects(file: &CampaignFile) -> Vec<Own> {
    let all: Vec<SingleThruster> = (0..file.thrusters.len()).map(|k| single(file, k)).collect();
    // exchanged with a thruster that moves nothing, a thruster is as good as lost
    let moves = |k: usize| file.model.dofs.iter().any(|dof| file.thrusters[k].pushes(*dof));
    let mut list: Vec<Own> = Vec::new();
    let mut push = |effect: Arc<dyn Effect>| list.push((effect, Place::VEHICLE));
    all.iter().for_each(|one| push(Arc::new(ThrusterLoss::of(one.clone()))));
    for (k, one) in all.iter().enumerate() {
        for (j, other) in all.iter().enumerate().skip(k + 1) {
            if alike(&file.thrusters[k], &file.thrusters[j]) && moves(k) && moves(j) {
                push(Arc::new(ThrusterSwap::of([one.clone(), other.clone()])));
            }
        }
    }
    if !all.is_empty() {
        push(Arc::new(ThrusterAdvanceLoss::of(all.clone())));
    }
    list
}

/// Returns thruster `k` in the form that effects take.
fn single(file: &CampaignFile, k: usize) -> SingleThruster {
    let (thruster, efficiency) = (&file.thrusters[k], &file.efficiency);
    let unit_wrench = Dof::ALL.map(|dof| if thruster.pushes(dof) { thruster.unit_wrench()[dof.index()] } else { 0.0 });
    let wrench = Dof::ALL.map(|dof| {
        let group: Vec<&str> = file.thrusters.iter().filter(|t| t.pushes(dof)).map(|t| t.name.as_str()).collect();
        unit_wrench[dof.index()] * efficiency.eta_inter.value(dof, &group)
    });
    let channel = if efficiency.eta_adv.is_some() { acting_thruster_force(k) } else { thruster_force(k) };
    SingleThruster { name: thruster.name.clone(), channel, unit_wrench, wrench }
}

/// Whether a command gives the same force in both thrusters.
fn alike(a: &Thruster, b: &Thruster) -> bool {
    let curve = |t: &Thruster| (t.forward, t.reverse, t.deadband, t.max, t.supply, t.bollard.clone());
    curve(a) == curve(b)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::baseline;
    use super::super::file::ReadOptions;
    use super::*;

    /// Two thrusters ahead with one curve, one athwart with another, one downward; `more` is added
    /// to the campaign.
    fn file(effect: &str, more: &str) -> Result<CampaignFile, String> {
        let table = |name: &str, y: f64, axis: &str, a: f64| {
            format!(
                "[[thruster]]\nname = '{name}'\nposition = [0, {y}, 0]\naxis = {axis}\nforward = {{ a = {a}, b = 0 }}\n\
                 reverse = {{ a = {a}, b = 0 }}\n"
            )
        };
        let tables = [
            table("port", -0.5, "[1, 0, 0]", 2.0),
            table("starboard", 0.5, "[1, 0, 0]", 2.0),
            table("bow", 0.0, "[0, 1, 0]", 1.0),
            table("lift", 0.0, "[0, 0, 1]", 2.0),
        ];
        let text = format!(
            "format = 1\n[model]\ndofs = ['surge', 'sway', 'yaw']\neffects = ['inertia'{effect}]\n{}{more}[[run]]\n\
             file = 'a.csv'\n",
            tables.concat()
        );
        let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
        CampaignFile::from_bytes(text.as_bytes(), Path::new("c.toml"), &options).map_err(|e| e.to_string())
    }

    fn candidates(effect: &str, more: &str) -> Vec<String> {
        let (_, own) = baseline::build(&file(effect, more).unwrap()).unwrap();
        own.iter().map(|(effect, _)| effect.about().id.to_string()).collect()
    }

    #[test]
    fn each_thruster_that_moves_the_model_and_each_like_pair_is_asked() {
        let all = [
            "thruster_loss@port",
            "thruster_loss@starboard",
            "thruster_loss@bow",
            "thruster_swap@port:starboard",
            "thruster_advance_loss",
        ];
        let mut found = candidates("", "");
        found.sort_unstable();
        let mut wanted = all.to_vec();
        wanted.sort_unstable();
        assert_eq!(found, wanted, "lift moves nothing in the plane, bow has another curve");
        assert_eq!(candidates(", 'thruster_loss@bow'", "").len(), 4, "what stands in the model is not asked");
        assert_eq!(candidates(", 'thruster_swap@starboard:port'", "").len(), 4, "in either order");
    }

    #[test]
    fn thrusters_that_are_not_there_or_cannot_be_exchanged_are_refused() {
        let refused = |effect: &str| match file(effect, "") {
            Err(text) => text,
            Ok(file) => baseline::build(&file).unwrap_err().to_string(),
        };
        let near = refused(", 'thruster_loss@prot'");
        assert!(near.starts_with("c.toml:") && near.contains("`port`"), "{near}");
        assert!(refused(", 'thruster_loss'").contains("one thruster, `@T6`"));
        assert!(refused(", 'thruster_swap@port:bow'").contains("different curves"));
        assert!(refused(", 'thruster_loss@lift'").contains("in any modelled degree of freedom"));
    }

    /// η_inter is in the wrench of a thruster, η_adv in the channel that is read.
    #[test]
    fn losses_that_are_known_are_in_a_thruster() {
        let more =
            "[efficiency]\neta_inter = { surge = 0.9 }\neta_adv = { slope = -0.2, intercept = 1.0, valid = [0, 1] }\n";
        let one = single(&file("", more).unwrap(), 0);
        assert_eq!((one.wrench, one.channel.as_str()), ([0.9, 0.0, 0.0, 0.0, 0.0, 0.5], "acting_F1"));
        assert_eq!(single(&file("", "").unwrap(), 0).channel, "F1");
    }
}
