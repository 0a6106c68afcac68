//! Output error on segments: what it recovers from data whose truth is known.

use hydrosysid::effects::Coriolis;
use hydrosysid::estimate::output_error::{OutputErrorError, OutputErrorOptions, output_error};
use hydrosysid::estimate::started;
use hydrosysid::frame::Dof;
use hydrosysid::model::Model;
use hydrosysid::run::{Role, Run, Signal};
use hydrosysid::tank::{BlindOptions, blind};

fn options() -> OutputErrorOptions {
    OutputErrorOptions { position: true, ..OutputErrorOptions::default() }
}

fn train(runs: &[Run]) -> Vec<Run> {
    runs.iter().filter(|r| r.role == Role::Train).cloned().collect()
}

/// The tank integrates at a hundredth of a second and the fit at a tenth: with noise a millionth of the ordinary one
/// what is left is the integrator's own error, some 1e-5.
#[test]
fn exact_parameters_from_data_all_but_free_of_noise() {
    let campaign = blind(&BlindOptions { seed: 201, noise: 1e-6, ..BlindOptions::default() }).unwrap();
    let runs = train(&campaign.runs);
    let fit = output_error(&started(&campaign.model().unwrap(), &runs), &runs, &options()).unwrap();
    assert!(fit.converged);
    for parameter in &fit.model.parameters {
        let truth = campaign.truth.value(&parameter.term).unwrap();
        let error = (parameter.value / truth - 1.0).abs();
        assert!(error < 1e-3, "{}: {} for {truth}", parameter.term, parameter.value);
    }
}

/// Of 9 parameters in 6 campaigns 95 % should lie within 1.96 standard deviations: 51 of 54 on average, and fewer than
/// 45 less than once in a thousand tries.
#[test]
fn law_intervals_cover_the_truth() {
    let mut inside = 0;
    for seed in 210..216 {
        let campaign = blind(&BlindOptions { seed, ..BlindOptions::default() }).unwrap();
        let runs = train(&campaign.runs);
        let fit = output_error(&started(&campaign.model().unwrap(), &runs), &runs, &options()).unwrap();
        for parameter in &fit.model.parameters {
            let truth = campaign.truth.value(&parameter.term).unwrap();
            inside += usize::from((parameter.value - truth).abs() < 1.96 * parameter.std.unwrap());
        }
    }
    assert!(inside >= 45, "{inside} of 54");
}

#[test]
fn what_the_data_cannot_tell_is_named() {
    // a vehicle that never moves sideways says nothing of its sway drag
    let time: std::sync::Arc<[f64]> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
    let mut run = Run::default();
    let signal = |f: &dyn Fn(f64) -> f64| Signal::new(time.clone(), time.iter().map(|t| f(*t)).collect::<Vec<f64>>());
    run.signals.insert("u".into(), signal(&|t| 0.3 * (0.4 * t).sin()));
    run.signals.insert("v".into(), signal(&|_| 0.0));
    run.signals.insert("tau_u".into(), signal(&|t| 60.0 * (0.4 * t).cos() + 10.0 * (0.4 * t).sin()));
    run.signals.insert("tau_v".into(), signal(&|_| 0.0));
    let mut model = Model::with_effects(&[Dof::Surge, Dof::Sway], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
    model.set("inertia@surge", 400.0);
    model.set("inertia@sway", 400.0);
    let refused = output_error(&model, &[run.clone()], &options()).unwrap_err();
    assert!(
        matches!(&refused, OutputErrorError::NotIdentified { parameters } if parameters.contains("sway")),
        "{refused}"
    );
    let nothing = output_error(&model, &[Run::default()], &options()).unwrap_err();
    assert_eq!(nothing, OutputErrorError::NothingObserved);
}
