//! Campaigns in which the seed draws everything: vehicle, runs, rates, random force, instruments,
//! commands and hidden effects.
//!
//! The search was developed with the fixed rows, so these can be too favourable; drawn campaigns
//! are not. They showed faults with held samples between empty rows, with a baseline that diverges
//! on held-out runs, and with a wave without a random force.

use hydrosysid_plant::random::Random;
use hydrosysid_plant::{Campaign, Commands, Dof, Pilots, Suite, hide};

use super::cells::of_vehicle;

/// The stream of the seed from which campaigns are drawn.
const STREAM: u64 = 0xd4a3;

/// Hidden effects.
#[derive(Clone, Copy)]
pub enum Drawn {
    Nothing,
    /// This many effects of the catalogue.
    Effects(usize),
    /// Two thrusters exchanged.
    Exchange,
    /// One thruster without thrust.
    Loss,
    /// One effect outside the catalogue.
    Outside,
}

/// The campaign of a seed.
pub fn drawn(what: Drawn, seed: u64) -> Campaign {
    let mut random = Random::new(seed, STREAM);
    let mut one_of = |values: &[f64]| values[((random.uniform() * values.len() as f64) as usize).min(values.len() - 1)];
    // faults of single thrusters are hidden in the small vehicle, which has four thrusters in its plane
    let of_thrusters = matches!(what, Drawn::Exchange | Drawn::Loss);
    let vehicle = if of_thrusters || one_of(&[0.0, 1.0]) > 0.0 { "small" } else { "laurs" };
    let mut suite = Suite { rate: one_of(&[4.0, 5.0, 10.0, 20.0]), ..Suite::default() };
    match one_of(&[0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0]) as usize {
        1 => suite.position = false,
        2 => (suite.held, suite.dvl_rate) = (true, Some(2.0)),
        3 => suite.outliers = 0.01,
        4 => suite.dropouts = 0.1,
        5 => suite.noise = 4.0,
        _ => {}
    }
    let noise = (one_of(&[0.0, 2.0, 5.0]), one_of(&[0.5, 1.0, 3.0]));
    let (runs, duration) = (one_of(&[4.0, 6.0, 9.0]) as usize, one_of(&[30.0, 60.0, 100.0]));
    let pilots = if one_of(&[0.0, 0.0, 1.0]) > 0.0 { Pilots::Mixed } else { Pilots::Open };
    let singly = of_thrusters || vehicle == "small" && one_of(&[0.0, 0.0, 0.0, 0.0, 1.0]) > 0.0;
    let mut drawn_of = |names: &[String]| {
        let places: Vec<f64> = (0..names.len()).map(|k| k as f64).collect();
        names[one_of(&places) as usize].clone()
    };
    let of_catalogue = hide::catalogue(&Dof::PLANE, &[]);
    let numbers: Vec<String> = (1..=4).map(|k| k.to_string()).collect();
    let mut apart = |names: &[String], count: usize| {
        let mut all = Vec::new();
        while all.len() < count {
            let next = drawn_of(names);
            if !all.contains(&next) {
                all.push(next);
            }
        }
        all.sort();
        all
    };
    let hidden: Vec<String> = match what {
        Drawn::Nothing => Vec::new(),
        Drawn::Effects(count) => apart(&of_catalogue, count),
        Drawn::Exchange => {
            let two = apart(&numbers, 2);
            vec![format!("thruster_swap@T{}:T{}", two[0], two[1])]
        }
        Drawn::Loss => vec![format!("thruster_loss@T{}", apart(&numbers, 1)[0])],
        Drawn::Outside => {
            // effects of single thrusters have rows of their own
            let others = hide::OUTSIDE.iter().filter(|name| !name.starts_with("thruster"));
            let named = |name: &str| if name == "power_drag" { "power_drag@surge" } else { name }.to_string();
            apart(&others.map(|name| named(name)).collect::<Vec<_>>(), 1)
        }
    };
    let commands = if singly { Commands::Thrusters } else { Commands::Wrench };
    Campaign { runs, duration, pilots, commands, ..of_vehicle(vehicle, &suite, noise, &hidden, seed) }
}
