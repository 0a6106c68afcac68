//! The logs of a campaign show what its settings ask for.

use hydrosysid_plant::log::Log;
use hydrosysid_plant::{Campaign, Dof, Manoeuvre, Pilots, RandomForce, Sailed, Suite, Vehicle};

fn campaign(vehicle: &str, dofs: &[Dof]) -> Campaign {
    let mut campaign = Campaign::new(Vehicle::named(vehicle).expect("it exists"), dofs);
    (campaign.duration, campaign.runs) = (30.0, 4);
    campaign
}

fn sail(campaign: &Campaign) -> Sailed {
    campaign.sail().expect("it sails")
}

fn values(log: &Log, name: &str) -> Vec<f64> {
    log.signal(name).unwrap_or_else(|| panic!("{} logs {name}", log.name)).values.clone()
}

fn deviation(x: &[f64]) -> f64 {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    (x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / x.len() as f64).sqrt()
}

/// The package does not depend on `hydrosysid`, so that its results are an independent reference.
#[test]
fn no_code_is_shared() {
    let manifest = include_str!("../Cargo.toml");
    let dependencies = manifest.split("dependencies]").skip(1).flat_map(|table| {
        let end = table.find("\n[").unwrap_or(table.len());
        table[..end].lines().filter_map(|line| line.split_once('=')).map(|(name, _)| name.trim()).collect::<Vec<_>>()
    });
    let dependencies: Vec<&str> = dependencies.collect();
    assert!(dependencies.contains(&"nalgebra"), "{dependencies:?}");
    assert!(dependencies.iter().all(|name| !name.starts_with("hydrosysid")), "{dependencies:?}");
}

/// The commands of a closed loop depend on the measurement noise, those of an open loop on time only.
#[test]
fn a_closed_loop_feeds_the_noise_back() {
    let commands = |pilots: Pilots, noise: f64| {
        let mut campaign = campaign("laurs", &Dof::PLANE);
        campaign.pilots = pilots;
        campaign.instruments = Suite { noise, ..Suite::default() }.instruments(&Dof::PLANE);
        // a zig-zag depends on the measured heading even in an open-loop run
        let logs = sail(&campaign).logs;
        logs.iter().filter(|log| log.kind != "zigzag").map(|log| values(log, "tau_u")).collect::<Vec<_>>()
    };
    let bits = |lists: &[Vec<f64>]| lists.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&commands(Pilots::Open, 0.0)), bits(&commands(Pilots::Open, 1.0)));
    let (clean, noisy) = (commands(Pilots::Closed, 0.0), commands(Pilots::Closed, 1.0));
    let apart = clean.iter().zip(&noisy).any(|(a, b)| {
        let off: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        deviation(&off) > 1e-3 * deviation(a)
    });
    assert!(apart, "5 mm/s at the controller's gain are more than a thousandth of its command");
}

/// PID control keeps the depth near its set points against the net buoyancy: its standard deviation
/// in a run is below 1.5 m.
#[test]
fn a_closed_loop_reaches_its_set_points() {
    let mut campaign = campaign("heavy", &Dof::ALL);
    campaign.pilots = Pilots::Closed;
    campaign.instruments = Suite { noise: 0.0, ..Suite::default() }.instruments(&Dof::ALL);
    let logs = sail(&campaign).logs;
    let depth = |log: &Log| deviation(&values(log, "z"));
    let closed: Vec<f64> = logs.iter().map(depth).collect();
    // set points are within 1 m of the start; 0.5 m is for overshoot
    assert!(closed.iter().all(|d| *d < 1.5) && closed.iter().any(|d| *d > 0.05), "{closed:?}");
}

/// The attitude outside the model is logged with noise. If `moves` has more degrees of freedom than
/// the model, the vehicle really pitches.
#[test]
fn attitude_that_is_given_has_noise() {
    let mut campaign = campaign("heavy", &[Dof::Surge, Dof::Sway, Dof::Yaw]);
    campaign.instruments = Suite { attitude: true, ..Suite::default() }.instruments(&campaign.moves);
    let still = sail(&campaign);
    for name in ["phi", "theta"] {
        let noise = deviation(&values(&still.logs[0], name)).to_degrees();
        // 300 samples of 0.5°: the standard error is 4 %
        assert!((0.4..0.6).contains(&noise), "{name}: {noise}");
    }
    campaign.moves = Dof::ALL.to_vec();
    campaign.instruments = Suite { attitude: true, ..Suite::default() }.instruments(&campaign.moves);
    let moving = sail(&campaign);
    let true_pitch = |sailed: &Sailed| {
        let rates: Vec<f64> = sailed.logs.iter().flat_map(|log| log.truth.iter().map(|(_, x)| x[11])).collect();
        deviation(&rates)
    };
    assert!(true_pitch(&still) < 1e-12 && true_pitch(&moving) > 1e-4, "{} {}", true_pitch(&still), true_pitch(&moving));
}

/// A degree of freedom with its own random force has that root mean square and correlation time;
/// the others keep theirs.
#[test]
fn each_degree_of_freedom_may_have_its_own_force() {
    let mut campaign = campaign("laurs", &Dof::PLANE);
    campaign.force = RandomForce { share: 0.02, correlation: 1.0 };
    let alike = sail(&campaign);
    campaign.own_forces = vec![(Dof::Yaw, RandomForce { share: 0.08, correlation: 0.25 })];
    let own = sail(&campaign);
    for (a, b) in alike.truth.force.iter().zip(&own.truth.force) {
        let (times, time) = if a.dof == Dof::Yaw { (4.0, 0.25) } else { (1.0, 1.0) };
        assert!((b.rms / a.rms - times).abs() < 1e-12, "{:?}: {} and {}", a.dof, a.rms, b.rms);
        assert!((b.correlation - time).abs() < 1e-12, "{:?}: {}", a.dof, b.correlation);
    }
    let rate = |sailed: &Sailed| sailed.logs[0].truth.iter().map(|(_, x)| x[12]).collect::<Vec<_>>();
    let apart: Vec<f64> = rate(&alike).iter().zip(&rate(&own)).map(|(a, b)| a - b).collect();
    assert!(deviation(&apart) > 0.0, "the motion is another");
}

#[test]
fn forces_that_are_given_are_commanded() {
    let mut campaign = campaign("laurs", &Dof::PLANE);
    let ramp: Vec<f64> = (0..200).map(f64::from).collect();
    (campaign.given, campaign.runs, campaign.duration) = (vec![vec![(Dof::Sway, ramp.clone())]], 1, 20.0);
    let sailed = sail(&campaign);
    assert!(!sailed.logs[0].validates);
    let logged = values(&sailed.logs[0], "tau_v");
    assert!(logged.iter().zip(&ramp).all(|(a, b)| (a - b).abs() < 1e-12) && logged.len() >= ramp.len(), "{logged:?}");
    assert!(values(&sailed.logs[0], "tau_u").iter().all(|f| f.abs() < 1e-12));
}

/// The name of a constant force gives its degree of freedom and share, and the vehicle ends at the
/// speed at which drag balances the force.
#[test]
fn a_constant_force_in_any_degree_of_freedom() {
    assert_eq!(Manoeuvre::named("constant"), Some(Manoeuvre::Constant(Dof::Surge, 0.6)));
    assert_eq!(Manoeuvre::named("constant:yaw=-0.4"), Some(Manoeuvre::Constant(Dof::Yaw, -0.4)));
    for wrong in ["constant:up=1", "constant:yaw=fast", "constant:yaw"] {
        assert_eq!(Manoeuvre::named(wrong), None, "{wrong}");
    }
    let mut sea = Campaign::new(Vehicle::named("laurs").expect("it exists"), &Dof::PLANE);
    (sea.runs, sea.spread, sea.duration) = (1, 0.0, 120.0);
    sea.manoeuvres = vec![Manoeuvre::Constant(Dof::Yaw, -0.4)];
    sea.instruments = Suite { noise: 0.0, ..Suite::default() }.instruments(&Dof::PLANE);
    let sailed = sea.sail().expect("it sails");
    let last =
        |channel: &str| *sailed.logs[0].signal(channel).expect("it is logged").values.last().expect("it has samples");
    let of = |effect: &str| sailed.truth.values.iter().find(|v| v.effect == effect).expect("it is known").value;
    let (moment, rate) = (last("tau_r"), last("r"));
    assert!(moment < 0.0 && rate < 0.0, "{moment} {rate}");
    // τ = k r + k |r| r, as nothing else moves
    let balance = of("linear_drag@yaw") * rate + of("quadratic_drag@yaw") * rate * rate.abs();
    assert!((balance / moment - 1.0).abs() < 1e-6, "{balance} for {moment}");
}
