//! Tied Coriolis terms by integral least squares: an inertia that stands in several balances is not pulled towards zero
//! by the noise of the velocities.

use std::path::Path;

use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{self, Campaign, Estimator, FitOptions, LoadOptions};
use hydrosysid::effects::Coriolis;
use hydrosysid::frame::Dof;
use hydrosysid::model::Model;
use hydrosysid::run::Run;
use hydrosysid::tank::{Basin, BlindOptions, Law, Measured, Noise, Pilot, Sensor, Sine, Trial, write_blind};

const DOFS: [Dof; 3] = [Dof::Surge, Dof::Sway, Dof::Yaw];
const CORIOLIS: [&str; 3] = ["coriolis_surge", "coriolis_sway", "coriolis_yaw"];
const TRUTH: [(&str, f64); 6] = [
    ("inertia@surge", 300.0),
    ("inertia@sway", 420.0),
    ("inertia@yaw", 60.0),
    ("linear_drag@surge", 90.0),
    ("linear_drag@sway", 150.0),
    ("linear_drag@yaw", 50.0),
];

/// Three runs of 120 s at 10 Hz, all three degrees of freedom driven, with this noise in m/s and rad/s.
fn runs(noise: f64, seed: u64) -> Vec<Run> {
    let effects = [&["inertia", "linear_drag"], &CORIOLIS[..]].concat();
    let mut model = Model::with_effects(&DOFS, Coriolis::Tied, &effects).expect("a model");
    for (name, value) in TRUTH {
        assert!(model.set(name, value), "{name}");
    }
    let sensors = DOFS.map(|dof| Sensor::new(dof.velocity(), 10.0, noise)).into();
    let basin = Basin { sensors, ..Basin::default() };
    let mut draw = Noise::new(3, 1);
    (0..3)
        .map(|k| {
            let laws = DOFS.map(|dof| {
                let size = if dof == Dof::Yaw { 0.4 } else { 1.0 };
                let mut sine =
                    || Sine { amplitude: size * draw.between(30.0, 70.0), period: draw.between(6.0, 18.0), phase: 0.0 };
                (dof, Law::Sines(0.0, vec![sine(), sine()]))
            });
            let (pilot, start) = (Pilot::new(laws.to_vec()), Measured::default());
            let trial = Trial { name: format!("run{k}"), duration: 120.0, pilot, start, ..Trial::default() };
            basin.sail(&model, &trial, k, seed).expect("it sails")
        })
        .collect()
}

/// Value and deviation of each parameter of the truth, in its order.
fn fitted(runs: Vec<Run>) -> Vec<(f64, f64)> {
    let text = "format = 1\n[model]\ndofs = ['surge', 'sway', 'yaw']\ncoriolis = 'tied'\n\
                effects = ['inertia', 'linear_drag', 'coriolis_surge', 'coriolis_sway', 'coriolis_yaw']\n\
                [[run]]\nfile = 'a.csv'\n";
    let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let file = CampaignFile::from_bytes(text.as_bytes(), Path::new("tied.toml"), &options);
    let campaign = Campaign::from_runs(file.unwrap_or_else(|e| panic!("{e}")), runs).unwrap_or_else(|e| panic!("{e}"));
    let options = FitOptions { estimator: Some(Estimator::Integral) };
    let fit = campaign::fit(&campaign, options).unwrap_or_else(|e| panic!("{e}"));
    let found = |(name, _): (&str, f64)| {
        let p = &fit.model.parameters[fit.model.parameter_of(name).unwrap_or_else(|| panic!("no {name}"))];
        (p.value, p.std.unwrap_or_else(|| panic!("{name} has no deviation")))
    };
    TRUTH.map(found).into()
}

#[test]
fn exact_without_noise() {
    for ((value, _), (name, truth)) in fitted(runs(0.0, 1)).into_iter().zip(TRUTH) {
        // the trapezoid of 0.1 s under sines of 6 s and slower
        assert!((value / truth - 1.0).abs() < 5e-3, "{name}: {value} for {truth}");
    }
}

/// 20 mm/s and 20 mrad/s on samples 0.1 s apart: an increment is mostly noise, and a column of increments pulled the
/// inertias to a fraction of themselves.
#[test]
fn law_noise_does_not_pull_shared_inertias_towards_zero() {
    const DRAWS: usize = 8;
    let all: Vec<Vec<(f64, f64)>> = (0..DRAWS).map(|k| fitted(runs(0.02, 100 + k as u64))).collect();
    for (j, (name, truth)) in TRUTH.into_iter().enumerate() {
        let mean = all.iter().map(|found| found[j].0).sum::<f64>() / DRAWS as f64;
        let std = all.iter().map(|found| found[j].1).sum::<f64>() / DRAWS as f64;
        println!("{name}: mean {mean:.2} of {truth}, deviation {std:.2}");
        let off = |found: &Vec<(f64, f64)>| (found[j].0 - truth).abs() / found[j].1;
        assert!(all.iter().all(|found| off(found) < 4.0), "{name}: {:?}", all.iter().map(|f| f[j]).collect::<Vec<_>>());
        assert!((mean / truth - 1.0).abs() < 0.03, "{name}: {mean} for {truth}");
    }
}

/// Read piece by piece the rows are gone when the inertias are sought: refused, not pulled towards zero.
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
