//! Tied Coriolis terms by integral least squares: the noise of the velocities does not bias an
//! inertia that is in several balances towards zero.

use std::path::PathBuf;

use hydrosysid::campaign::{self, Campaign, Estimator, FitOptions, LoadOptions};
use hydrosysid::tank::{BlindOptions, write_blind};
use hydrosysid_plant::{Campaign as Sea, Dof, Suite, Vehicle};

const FREE: [&str; 6] =
    ["inertia@surge", "inertia@sway", "inertia@yaw", "linear_drag@surge", "linear_drag@sway", "linear_drag@yaw"];

/// Value, standard deviation and true value of the parameters of [`FREE`], from planar runs of the
/// independent plant by integral least squares; `noise` is in units of the ordinary noise (5 mm/s
/// and 3 mrad/s).
fn fitted(noise: f64, seed: u64) -> Vec<(f64, f64, f64)> {
    let mut sea = Sea::new(Vehicle::named("laurs").expect("it exists"), &Dof::PLANE);
    (sea.seed, sea.spread) = (seed, 0.0);
    sea.instruments = Suite { noise, ..Suite::default() }.instruments(&Dof::PLANE);
    found_in(&sea, &format!("tied_{seed}"))
}

/// The same for the campaign `sea`.
fn found_in(sea: &Sea, name: &str) -> Vec<(f64, f64, f64)> {
    let sailed = sea.sail().expect("it sails");
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    sailed.write(&folder).expect("the folder can be written");
    let campaign =
        Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let options = FitOptions { estimator: Some(Estimator::Integral) };
    let fit = campaign::fit(&campaign, options).unwrap_or_else(|e| panic!("{e}"));
    let found = |name: &str| {
        let p = &fit.model.parameters[fit.model.parameter_of(name).unwrap_or_else(|| panic!("no {name}"))];
        let truth =
            sailed.truth.values.iter().find(|v| v.effect == name).unwrap_or_else(|| panic!("no truth of {name}"));
        (p.value, p.std.unwrap_or_else(|| panic!("{name} has no deviation")), truth.value)
    };
    FREE.map(found).into()
}

#[test]
fn exact_without_noise() {
    for ((value, _, truth), name) in fitted(0.0, 1).into_iter().zip(FREE) {
        // the error of the trapezoid of 0.1 s with held commands
        assert!((value / truth - 1.0).abs() < 1e-2, "{name}: {value} for {truth}");
    }
}

/// With noise of 20 mm/s and 12 mrad/s on samples 0.1 s apart, an increment of the velocity is
/// mostly noise, and a column of increments biased the inertias to a fraction of their values.
/// Estimates are within four standard deviations.
#[test]
fn law_noise_does_not_pull_shared_inertias_towards_zero() {
    const DRAWS: usize = 6;
    let all: Vec<Vec<(f64, f64, f64)>> = (0..DRAWS).map(|k| fitted(4.0, 100 + k as u64)).collect();
    for (j, name) in FREE.into_iter().enumerate() {
        let mean =
            |of: &dyn Fn(&(f64, f64, f64)) -> f64| all.iter().map(|found| of(&found[j])).sum::<f64>() / DRAWS as f64;
        let (value, std, truth) = (mean(&|f| f.0), mean(&|f| f.1), mean(&|f| f.2));
        println!("{name}: mean {value:.2} of {truth:.2}, deviation {std:.2}");
        let off = |found: &Vec<(f64, f64, f64)>| (found[j].0 - truth).abs() / found[j].1;
        assert!(all.iter().all(|found| off(found) < 4.0), "{name}: {:?}", all.iter().map(|f| f[j]).collect::<Vec<_>>());
        // the mean of six draws is known to 0.4 standard deviations
        assert!((value - truth).abs() < 0.03 * truth + 1.3 * std, "{name}: {value} for {truth}");
    }
}

/// If a small vehicle moves one degree of freedom at a time, the product of two velocities contains
/// the noise of one of them, and m_v − m_u was estimated as 0.3 instead of 4.9 kg. The logs have
/// 50 Hz, because the trapezoid of 0.1 s is too coarse for the yaw of this vehicle.
#[test]
fn law_a_product_of_noise_draws_no_inertia() {
    for seed in 1..4 {
        let mut sea = Sea::new(Vehicle::named("small").expect("it exists"), &Dof::PLANE);
        (sea.seed, sea.runs, sea.duration) = (seed, 5, 60.0);
        sea.instruments = Suite { rate: 50.0, ..Suite::default() }.instruments(&Dof::PLANE);
        for ((value, std, truth), name) in found_in(&sea, &format!("tied_small_{seed}")).into_iter().zip(FREE) {
            println!("{name}: {value:.3} ± {std:.3} for {truth:.3}");
            assert!((value - truth).abs() < 3.5 * std, "seed {seed}, {name}: {value} ± {std} for {truth}");
        }
    }
}

/// In a fit that reads its logs piece by piece, the rows are no longer available when the inertias
/// are estimated. Such a fit is refused, instead of a result that is biased towards zero.
#[test]
fn shared_inertias_of_a_stream_are_refused() {
    let folder = std::env::temp_dir().join(format!("hydrosysid-tied-{}", std::process::id()));
    let options = BlindOptions { duration: 30.0, ..BlindOptions::default() };
    write_blind(&folder, &options).unwrap_or_else(|e| panic!("{e}"));
    let path = folder.join("campaign.toml");
    let kept = Campaign::load(&path, LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    campaign::fit(&kept, FitOptions { estimator: Some(Estimator::Integral) }).unwrap_or_else(|e| panic!("{e}"));
    let error = campaign::fit_streamed(&path, LoadOptions::default()).expect_err("tied Coriolis");
    assert_eq!(error.findings()[0].code, campaign::codes::SHARED_INERTIAS.code, "{error}");
    assert!(error.to_string().contains("coriolis = \"free\""), "{error}");
    let _ = std::fs::remove_dir_all(folder);
}
