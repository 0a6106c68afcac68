//! Every exported file states the range of speeds of the fit, and a target that extrapolates is
//! named in a warning.

use std::path::Path;

use crate::exported::{PLANAR, codes, made, noise, planar, text, thrusters};
use hydrosysid::campaign::ModelFile;
use hydrosysid::export::{Export, ExportOptions, Target, export};

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

/// The export to any target, from a planar model with noise or from a campaign with thrusters.
fn of(target: Target) -> Export {
    if target.takes_campaign() {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("bounds-{}", target.name()));
        return export(&thrusters(&folder, "boat", ""), target, &ExportOptions::default()).expect("it can be exported");
    }
    let file = ModelFile { noise: Some(noise(&PLANAR)), ..planar(&[]) };
    made(&file, target, &ExportOptions::default())
}

#[test]
fn every_file_of_every_target_says_its_limits_and_what_is_stable() {
    for target in Target::ALL {
        let export = of(target);
        // UTF-16 in a MAT file
        let text = String::from_utf8_lossy(&export.bytes).replace('\0', "");
        for (word, least) in [("Limits: ", 20), ("Stability: ", 20)] {
            let told = text.split_once(word).unwrap_or_else(|| panic!("{target:?} says no {word}")).1;
            assert!(told.chars().take_while(|c| !matches!(c, '\n' | '"')).count() > least, "{target:?}: {word}");
        }
        assert_eq!(text.contains("Fitted between"), !target.takes_campaign(), "{target:?}");
    }
}

#[test]
fn stability_is_counted_from_the_model() {
    let stability = |target: Target, file: &ModelFile| {
        let text = text(&made(file, target, &ExportOptions::default()));
        text.split_once("Stability: ").expect("it is told").1.split(['\n', '"']).next().expect("a line").to_string()
    };
    let rest = ModelFile { noise: Some(noise(&PLANAR)), ..planar(&[]) };
    // −20/250, −35/320, −15/60 and the heading; the noise at −1/0.8 and −1/3
    let linear = "eigenvalues of A (1/s) -0.25, -0.109, -0.08, 0: 1 stay constant, the others decay";
    assert_eq!(stability(Target::LinearJson, &rest), linear);
    assert_eq!(stability(Target::LinearPython, &rest), linear);
    let kalman = stability(Target::KalmanPython, &rest);
    assert!(kalman.contains("-1.25, -1.25, -1.25, -0.333, -0.25, -0.109, -0.08, 0: 1 stay"), "{kalman}");
    assert!(kalman.ends_with("exact for dt = 0.1 s"), "{kalman}");
    let mut driven = planar(&[]);
    driven.parameters.iter_mut().filter(|p| p.effect == "linear_drag@yaw").for_each(|p| p.value = -15.0);
    assert!(stability(Target::LinearJson, &driven).ends_with("UNSTABLE at this point: 1 grow"));
    // 120/200 of sway; 2 m_r (1 − 0.6)/(d + 2 d_q v) against 2 (m_r + m_a)/(d + 2 d_q v)
    let [whole, late] = [Target::GazeboAddedMass, Target::Gazebo].map(|target| {
        let told = stability(target, &rest);
        told.split_once("below ")
            .map(|_| told.clone())
            .expect("a step")
            .rsplit_once("steps below ")
            .expect("a step")
            .1
            .split(' ')
            .next()
            .expect("a number")
            .parse::<f64>()
            .expect("a number")
    });
    assert!((late / whole - 0.4 / 1.6).abs() < 5e-3, "three digits are written: {late} {whole}");
    assert!(stability(Target::Gazebo, &rest).starts_with("added mass is 0.60 times the rigid one"));
    let heavy = ExportOptions { mass: Some(100.0), ..ExportOptions::default() };
    assert!(text(&made(&rest, Target::Gazebo, &heavy)).contains("Stability: UNSTABLE however short the step"));
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
    // a lower bound of 0 means that some runs do not oscillate, so that the amplitudes are not known
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
