//! Galilean invariance: relative to the water, a vehicle moves in a current as it does in still water.

use std::sync::Arc;

use hydrosysid::chain::{Available, assemble};
use hydrosysid::effects::{Coriolis, Effect, Family, Place, catalogue};
use hydrosysid::frame::Dof;
use hydrosysid::model::{Model, name_of, places_of};
use hydrosysid::symbolic::{Graph, Leaf};
use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;

use super::{INPUT, some_value};

/// Rates of the states of a model of a body with one more effect, in a current `water`, m/s north and east.
fn rates_of(
    (effect, place, coriolis): (&Arc<dyn Effect>, Place, Coriolis),
    water: [f64; 2],
    (nu, eta): (&[f64; 6], &[f64; 6]),
    memory: f64,
) -> Vec<f64> {
    let rows = ["coriolis_surge", "coriolis_sway", "coriolis_heave", "coriolis_roll", "coriolis_pitch", "coriolis_yaw"];
    let body = [&["inertia", "added_mass_coupling@sway:yaw", "current"][..], &rows[..]].concat();
    let mut model = Model::with_effects(&Dof::ALL, coriolis, &body).expect("ids of the catalogue");
    model.weight = 1854.1;
    // an effect that the body already has is not added again
    let _ = model.add(effect.clone(), place);
    for p in &mut model.parameters {
        p.value = match p.spec.name.as_str() {
            "V_N" => water[0],
            "V_E" => water[1],
            name if name.starts_with("m_") || name.starts_with("I_") => 300.0 + 10.0 * name.len() as f64,
            _ => some_value(&p.spec),
        };
    }
    let channels = Dof::ALL.iter().map(|dof| dof.force().to_string()).chain(effect.channels(place)).collect();
    let graph = Graph::new();
    let equations = assemble(&graph, &model, &Available { channels, position: true, ..Available::default() });
    let read = |leaf: Leaf| match leaf {
        Leaf::State(k) if k < 6 => nu[usize::from(k)],
        Leaf::State(k) if k < 12 => eta[usize::from(k) - 6],
        Leaf::State(_) => memory,
        Leaf::Parameter(p) => model.parameters[usize::from(p)].value,
        Leaf::Input(k) | Leaf::Delayed { input: k, .. } => INPUT[usize::from(k) % INPUT.len()],
        Leaf::Rate(_) | Leaf::DelayedRate { .. } => panic!("everything that moves is simulated"),
    };
    equations.states.iter().map(|state| state.rate.evaluate(&read)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// Relative to the water, a vehicle in a current moves as in still water; over ground,
    /// v̇ = v̇_r − ω × Rᵀ V, and the position drifts with the current. This holds in six degrees of
    /// freedom, for any attitude, and for every effect except sensors and those that are tied to the
    /// ground. The tolerance of 1e-8 of the size is for the rounding of the elimination.
    #[test]
    fn law_galilei(
        nu in prop::array::uniform6(-1.5f64..1.5),
        angles in (-3.0f64..3.0, -1.4f64..1.4, -3.0f64..3.0),
        water in prop::array::uniform2(-1.0f64..1.0),
        memory in -1.0f64..1.0,
    ) {
        let eta = [3.0, -2.0, 5.0, angles.0, angles.1, angles.2];
        let velocity_of_water = Vector3::new(water[0], water[1], 0.0);
        let drift = Rotation3::from_euler_angles(angles.0, angles.1, angles.2).inverse() * velocity_of_water;
        let turning = -Vector3::new(nu[3], nu[4], nu[5]).cross(&drift);
        let nu_r: [f64; 6] = std::array::from_fn(|i| if i < 3 { nu[i] - drift[i] } else { nu[i] });
        for coriolis in [Coriolis::Tied, Coriolis::Free] {
            let in_water = |e: &Arc<dyn Effect>| e.about().family != Family::Sensor && !e.tied_to_ground();
            for effect in catalogue(coriolis).into_iter().filter(in_water) {
                for place in places_of(effect.as_ref(), &Dof::ALL) {
                    let found = rates_of((&effect, place, coriolis), water, (&nu, &eta), memory);
                    let still = rates_of((&effect, place, coriolis), [0.0; 2], (&nu_r, &eta), memory);
                    let size = still.iter().fold(1.0, |size: f64, x| size.max(x.abs()));
                    for (k, (found, still)) in found.into_iter().zip(still).enumerate() {
                        let expected = match k {
                            0..3 => still + turning[k],
                            6..9 => still + velocity_of_water[k - 6],
                            _ => still,
                        };
                        let name = name_of(effect.about().id, place);
                        prop_assert!((found - expected).abs() < 1e-8 * size, "{name}, state {k}: {found}, {expected}");
                    }
                }
            }
        }
    }
}

/// Only the spring of a tether is tied to the ground, as its anchor moves relative to the water.
#[test]
fn what_is_tied_to_the_ground_says_so() {
    let tied: Vec<String> =
        catalogue(Coriolis::Tied).iter().filter(|e| e.tied_to_ground()).map(|e| e.about().id.to_string()).collect();
    assert_eq!(tied, ["tether_spring"]);
}
