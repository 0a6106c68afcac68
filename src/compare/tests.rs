use super::*;
use crate::effects::Coriolis;
use crate::frame::Dof;
use crate::run::Signal;

fn surge(drag: f64) -> Model {
    let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
    model.set("inertia@surge", 100.0);
    model.set("linear_drag@surge", drag);
    model
}

/// From rest under a constant force F: u = F/d (1 − exp(−d t/m)); logged with an alternating error of ± `noise`.
fn logged(drag: f64, noise: f64) -> Run {
    let time: std::sync::Arc<[f64]> = (0..=400).map(|k| 0.1 * f64::from(k)).collect();
    let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    let speed = |t: f64| 50.0 / drag * (1.0 - (-drag * t / 100.0).exp());
    let u: Vec<f64> = time.iter().enumerate().map(|(k, t)| speed(*t) + noise * sign(k)).collect();
    let mut run = Run { name: "step".into(), role: Role::Validate, ..Run::default() };
    run.signals.insert("tau_u".into(), Signal::new(time.clone(), vec![50.0; 401]));
    run.signals.insert("u".into(), Signal::new(time, u));
    run
}

/// With the true model only the noise remains: an alternating error of ± a has mean a, no spread, and rms a. The
/// state from the first 5 s is off by some a/50.
#[test]
fn exact_true_model_leaves_the_noise() {
    let run = logged(40.0, 0.01);
    let found = compare(&surge(40.0), std::slice::from_ref(&run), &CompareOptions::default()).unwrap();
    assert_eq!(found.warnings, []);
    let [one] = found.runs.as_slice() else { panic!("one run in one degree of freedom") };
    assert!((one.mean_abs - 0.01).abs() < 2e-4 && one.std_abs < 1e-3 && (one.rms - 0.01).abs() < 2e-4, "{one:?}");
    assert!(one.fit_percent > 90.0 && one.unit == "m/s" && one.role == Role::Validate);
    // an alternating error is rougher than the white noise for which the estimate is made
    assert!(one.noise_floor > 0.005 && one.noise_floor < 0.03, "{one:?}");
    let noise = [("u".to_string(), 0.123)].into();
    let given = compare(&surge(40.0), &[run], &CompareOptions { noise, ..CompareOptions::default() }).unwrap();
    assert_eq!(given.runs[0].noise_floor, 0.123);
}

/// Steady speeds F/d of a wrong drag differ by 50/40 − 50/50 = 0.25 m/s.
#[test]
fn exact_wrong_drag_shows_in_the_steady_speed() {
    let found = compare(&surge(50.0), &[logged(40.0, 0.0)], &CompareOptions::default()).unwrap();
    assert!((found.runs[0].mean_abs - 0.22).abs() < 0.03, "{:?}", found.runs[0]);
    let json = serde_json::to_value(&found.runs[0]).unwrap();
    for key in ["run", "role", "dof", "mean_abs", "std_abs", "rms", "noise_floor", "fit_percent", "unit"] {
        assert!(json.get(key).is_some(), "{key}");
    }
    assert_eq!((json["dof"].as_str(), json["role"].as_str()), (Some("surge"), Some("validate")));
}

/// Negative damping: u = F/d (1 − e^{−dt/m}) with d < 0 grows e^{8} fold in 40 s.
#[test]
fn unstable_motion_is_compared_on_segments_and_said() {
    let run = logged(-20.0, 1e-4);
    let found = compare(&surge(-20.0), std::slice::from_ref(&run), &CompareOptions::default()).unwrap();
    assert_eq!(found.warnings.len(), 1);
    assert_eq!((found.warnings[0].code, found.warnings[0].run.as_deref()), ("C001", Some("step")));
    assert!(found.runs[0].rms < 2e-4, "{:?}", found.runs[0]);
}

#[test]
fn every_model_is_held_against_every_run() {
    let runs = [logged(40.0, 0.0), logged(50.0, 0.0)];
    let models = [("a".to_string(), surge(40.0)), ("b".to_string(), surge(50.0))];
    let matrix = cross_validate(&models, &runs, &CompareOptions::default()).unwrap();
    let cell = |row: usize, column: usize| matrix[row].comparison.runs[column].rms;
    assert!(cell(0, 0) < 1e-6 && cell(1, 1) < 1e-6, "{} {}", cell(0, 0), cell(1, 1));
    assert!(cell(0, 1) > 0.1 && cell(1, 0) > 0.1);
}

#[test]
fn a_run_without_what_the_model_reads_is_refused_by_name() {
    let mut run = logged(40.0, 0.0);
    run.signals.remove("u");
    let error = compare(&surge(40.0), &[run], &CompareOptions::default()).unwrap_err();
    assert!(error.to_string().starts_with("run `step`: "), "{error}");
}
