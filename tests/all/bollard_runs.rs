//! Bollard runs together with runs of free motion, but none at constant speed, on the plant.

use std::path::Path;

use hydrosysid::campaign::{self, Campaign, Estimator, FitOptions, LoadOptions, codes};
use hydrosysid_plant::{Campaign as Sea, Dof, Manoeuvre, Vehicle};

const INERTIAS: [&str; 3] = ["inertia@surge", "inertia@sway", "inertia@yaw"];

/// The staged procedure estimates an inertia with the drag of earlier stages. Without such stages,
/// as here, it gave 1100 ± 92 kg for 789. By default the fit estimates inertia and drag from the
/// motion, with the loss of thrust from the load cell, and the inertias are within 3.5 standard
/// deviations. The staged procedure, if asked for, warns against its numbers.
#[test]
fn without_runs_at_constant_speed_the_motion_tells_the_drag() {
    let mut sea = Sea::new(Vehicle::named("laurs").expect("it exists"), &Dof::PLANE);
    (sea.runs, sea.duration, sea.seed) = (6, 40.0, 5);
    let alone = |dof| Manoeuvre::Alone(dof, 0.6, 0.0);
    sea.manoeuvres = vec![Manoeuvre::Bollard, alone(Dof::Surge), alone(Dof::Sway), alone(Dof::Yaw)];
    let sailed = sea.sail().expect("it sails");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bollard_runs");
    sailed.write(&folder).expect("the folder can be written");
    let campaign = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).expect("it is a campaign");

    let fit = campaign::fit(&campaign, FitOptions::default()).expect("it can be fitted");
    assert_eq!(fit.estimator, Estimator::FilterError);
    let told = |code: &str| fit.warnings.iter().any(|w| w.code == code);
    assert!(told(codes::LOSSES_OF_BOLLARD.code) && !told(codes::LEFT_OUT.code), "{:?}", fit.warnings);
    assert!(!fit.efficiency.eta_inter.0.is_empty(), "the loss goes with the model");
    for name in INERTIAS {
        let p = &fit.model.parameters[fit.model.parameter_of(name).expect("it is there")];
        let (truth, std) = (sailed.truth.value(name).expect("the truth knows it"), p.std.expect("it is estimated"));
        assert!((p.value - truth).abs() < 3.5 * std, "{name}: {} ± {std} for {truth}", p.value);
    }

    let staged = FitOptions { estimator: Some(Estimator::Staged) };
    let sentence = campaign::fit(&campaign, staged).expect("it can be fitted").sentence;
    assert!(
        sentence.starts_with("Do not use these numbers for surge, sway and yaw: no run at constant speed"),
        "{sentence}"
    );
}
