//! Every exported file says between which speeds its model was fitted, and what the target will extrapolate is told.

use crate::exported::{codes, made, planar, text};
use hydrosysid::export::{ExportOptions, Target};

#[test]
fn every_file_says_where_the_model_was_fitted_and_a_target_that_knows_no_limits_is_named() {
    for target in
        [Target::Gazebo, Target::GazeboAddedMass, Target::Uuv, Target::Urdf, Target::FossenPython, Target::FossenMatlab]
    {
        let export = made(&planar(&[]), target, &ExportOptions::default());
        assert!(text(&export).contains("Fitted between (SI units): u -0.5 to 1"), "{target:?}");
        let told = export.warnings.iter().find(|w| w.code == "X017").unwrap_or_else(|| panic!("{target:?}"));
        assert!(told.message.contains("u -0.500 to 1.000"), "{}", told.message);
    }
    for target in [Target::Latex, Target::Csv] {
        let export = made(&planar(&[]), target, &ExportOptions::default());
        assert!(
            text(&export).contains("Fitted between") && !codes(&export).contains("X017"),
            "{target:?} moves nothing"
        );
    }
    let mut unknown = planar(&[]);
    unknown.envelope.clear();
    assert!(codes(&made(&unknown, Target::Uuv, &ExportOptions::default())).contains("X019"));
}

#[test]
fn a_model_of_one_amplitude_is_told_and_one_of_several_is_not() {
    let with = |low: f64, high: f64| {
        let mut file = planar(&[]);
        file.envelope.insert("KC_u".into(), [low, high]);
        made(&file, Target::Uuv, &ExportOptions::default())
    };
    let one = with(2.0, 2.5);
    let told = one.warnings.iter().find(|w| w.code == "X018").expect("it is told");
    assert!(told.message.contains("surge (KC 2.00 to 2.50)"), "{}", told.message);
    assert!(!codes(&with(0.55, 39.8)).contains("X018"));
    // runs that do not oscillate are among them: what amplitudes there are nobody knows
    assert!(!codes(&with(0.0, 2.5)).contains("X018"));
}

#[test]
fn an_operating_point_beyond_the_fit_is_told_by_speed_and_by_force() {
    let mut file = planar(&[]);
    file.envelope.insert("tau_u".into(), [-50.0, 100.0]);
    let at = |name: &str, value: f64| {
        let options = ExportOptions { at: [(name.to_string(), value)].into(), ..ExportOptions::default() };
        made(&file, Target::LinearJson, &options).warnings.into_iter().filter(|w| w.code == "X010").count()
    };
    assert_eq!((at("u", 0.5), at("u", 1.5), at("tau_u", 60.0), at("tau_u", 150.0)), (0, 1, 0, 1));
}
