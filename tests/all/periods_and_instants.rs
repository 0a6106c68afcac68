//! A model with a period or an instant as a parameter is fitted without a starting value for it, on
//! the plant.

use std::path::PathBuf;

use hydrosysid::campaign::{self, Adoption, Campaign, Estimator, Fit, FitOptions, LoadOptions};
use hydrosysid::discover::Verdict;
use hydrosysid_plant::{Campaign as Sea, Dof as Axis, Hidden, RandomForce, Suite, Vehicle};

/// The campaign of `sea` after `name` has been adopted into its model.
fn adopted(name: &str, sea: &Sea) -> Campaign {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("timed_{}", name.replace('@', "_")));
    let _ = std::fs::remove_dir_all(&folder);
    sea.sail().expect("it sails").write(&folder).expect("the folder can be written");
    let what = Adoption { names: &[name.to_string()], ..Adoption::default() };
    campaign::adopt(&folder, None, &what).expect("it is a campaign");
    Campaign::load(&folder, LoadOptions::default()).expect("a campaign")
}

fn sea(name: &str, seed: u64) -> Sea {
    let small = Vehicle::named("small").expect("it exists");
    let instruments = Suite { rate: 5.0, ..Suite::default() }.instruments(&Axis::PLANE);
    let force = RandomForce { share: 0.0, correlation: 1.0 };
    Sea {
        force,
        hidden: vec![Hidden::new(name)],
        instruments,
        seed,
        runs: 4,
        duration: 40.0,
        ..Sea::new(small, &Axis::PLANE)
    }
}

fn value(fit: &Fit, name: &str) -> (f64, f64) {
    let found = fit.parameters.iter().find(|p| p.name == name).expect("it is in the model");
    (found.value, found.std.expect("it was estimated"))
}

/// A wave of 1.8 N with a period of 5 s is found. From the first period of the grid, the fit would
/// end without a wave and with a random force of that size. The held-out run has its own phase,
/// estimated from its first half, and is predicted.
#[test]
fn the_period_of_a_wave_is_found_by_the_fit() {
    let campaign = adopted("wave@sway", &sea("wave@sway", 94_101));
    let fit = campaign::fit(&campaign, FitOptions::default()).expect("a fit");
    let (period, std) = value(&fit, "T_wavev");
    assert!((period - 5.0).abs() < 4.0 * std && std < 0.01, "{period} ± {std}");
    assert!(fit.sentence.contains("No random force is found"), "{}", fit.sentence);
    assert!(!fit.warnings.iter().any(|w| ["M128", "M144"].contains(&w.code)), "{:?}", fit.warnings);
    let told = fit.warnings.iter().find(|w| w.code == "M225").expect("where the values of a held-out run come from");
    assert!(told.message.starts_with("a_wavev, b_wavev: in a run that took no part"), "{}", told.message);
    let of =
        |name: &str| &fit.model.parameters.iter().find(|p| p.spec.name == name).expect("it is in the model").per_run;
    let (a, b) = (of("a_wavev"), of("b_wavev"));
    assert_eq!(a.len(), 4, "the run that took no part has values, too");
    for (a, b) in a.iter().zip(b) {
        assert!((a.hypot(*b) - 1.8).abs() < 0.15, "{a} {b}");
    }
    let compared = campaign::compare(&campaign, &fit.model, &fit.envelope).expect("it is compared");
    for run in &compared.runs {
        let times = run.rms / run.noise_floor;
        assert!(times < 2.0, "{} in {}: {times:.1} times the noise", run.run, run.dof);
    }
    let found = campaign::discover(&campaign).expect("a search");
    assert_eq!((found.effects.len(), found.verdict), (0, Verdict::NothingMissing), "{}", found.sentence);
}

/// A part of the thrust in surge is lost from 45 % of each run on: the loss and the instant are
/// found. From a start near another optimum, half the loss from another instant on would be
/// estimated.
#[test]
fn the_instant_of_a_failure_is_found_by_the_fit() {
    let campaign = adopted("thruster_fault@surge", &Sea { runs: 6, ..sea("thruster_fault@surge", 94_102) });
    for estimator in [Estimator::FilterError, Estimator::OutputError] {
        let fit = campaign::fit(&campaign, FitOptions { estimator: Some(estimator) }).expect("a fit");
        let ((lost, lost_std), (instant, std)) = (value(&fit, "k_faultu"), value(&fit, "t_faultu"));
        assert!((lost - 0.4).abs() < 4.0 * lost_std && lost_std < 0.02, "{lost} ± {lost_std}");
        assert!((instant - 18.0).abs() < 0.3, "{instant} ± {std}");
    }
}
