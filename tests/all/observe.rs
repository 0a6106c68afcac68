//! A logged function of the states is used in the fit, the comparison and the discovery, even if
//! the state itself is not logged.

use std::path::Path;

use crate::surge::surge;
use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{self, Campaign, FitOptions, LoadOptions};
use hydrosysid::run::{Role, Run, Signal};
use hydrosysid::tank::Noise;

const MASS: f64 = 300.0;
const DRAG: f64 = 250.0;
const RATE: f64 = 10.0;

/// Log of a vehicle that is driven ahead and astern while it pitches: m u̇ = τ − d u|u| − c sin θ
/// with c = `offset`, simulated independently of the library.
fn run(name: &str, role: Role, (seed, speed_noise): (u64, f64), offset: f64) -> Run {
    let samples = 900;
    let phase = seed as f64;
    let tau = |t: f64| 60.0 * (0.7 * t + phase).sin() + 40.0 * (0.19 * t).sin();
    let theta = |t: f64| 0.5 * (0.23 * t + 2.0 * phase).sin();
    let rate = |t: f64, u: f64| (tau(t) - offset * theta(t).sin() - DRAG * u * u.abs()) / MASS;
    let (time, speed) = surge(samples, rate);
    let mut noise = Noise::new(seed, 7);
    let (white, own) = (noise.coloured(samples, 0.0), noise.coloured(samples, 0.0));
    let clock: std::sync::Arc<[f64]> = time.clone().into();
    let of = |f: &dyn Fn(usize) -> f64| Signal::new(clock.clone(), (0..samples).map(f).collect::<Vec<_>>());
    let mut run = Run { name: name.into(), role, ..Run::default() };
    run.signals.insert("tau_u".into(), of(&|k| tau(time[k])));
    run.signals.insert("theta".into(), of(&|k| theta(time[k])));
    run.signals.insert("depth_rate".into(), of(&|k| -speed[k] * theta(time[k]).sin() + 0.002 * white[k]));
    if speed_noise > 0.0 {
        run.signals.insert("u".into(), of(&|k| speed[k] + speed_noise * own[k]));
    }
    assert!((time[1] - 1.0 / RATE).abs() < 1e-12);
    run
}

const OBSERVE: &str = "[[observe]]\nchannel = 'depth_rate'\nformula = '-u*sin(theta)'\n";
const MODEL: &str =
    "format = 1\n[vehicle]\nmass = 200.0\n[model]\ndofs = ['surge']\neffects = ['inertia', 'quadratic_drag']\n";

fn file(text: &str) -> CampaignFile {
    let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let text = format!("{text}[[run]]\nfile = 'a.csv'\n");
    CampaignFile::from_bytes(text.as_bytes(), Path::new("observe.toml"), &options).unwrap_or_else(|e| panic!("{e}"))
}

fn campaign(text: &str, speed_noise: f64, offset: f64) -> Campaign {
    let runs = (1..=4)
        .map(|k| run(&format!("run{k}"), if k < 4 { Role::Train } else { Role::Validate }, (k, speed_noise), offset))
        .collect();
    Campaign::from_runs(file(text), runs).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_speed_that_is_not_logged_is_told_by_the_depth_rate() {
    let campaign = campaign(&format!("{MODEL}{OBSERVE}"), 0.0, 0.0);
    let fit = campaign::fit(&campaign, FitOptions::default()).unwrap();
    for (parameter, truth) in fit.parameters.iter().zip([MASS, DRAG]) {
        let std = parameter.std.unwrap();
        // within four of its own standard deviations, which are some tenths of a per cent here
        assert!((parameter.value - truth).abs() < 4.0 * std && std < 0.01 * truth, "{parameter:?}");
    }
    let comparison = campaign::compare(&campaign, &fit.model, &fit.envelope).unwrap();
    let rows: Vec<_> = comparison.runs.iter().map(|r| (r.dof.to_string(), r.unit.clone())).collect();
    assert!(
        rows.iter().all(|row| *row == ("depth_rate".to_string(), "m/s".to_string())) && rows.len() == 4,
        "{rows:?}"
    );
    // only the noise of the sensor remains
    assert!(comparison.runs.iter().all(|r| r.rms < 1.1 * 0.002), "{:?}", comparison.runs);
}

#[test]
fn a_function_adds_to_what_the_speed_itself_tells() {
    let std = |text: &str| {
        let fit = campaign::fit(&campaign(text, 0.02, 0.0), FitOptions::default()).unwrap();
        fit.parameters[0].std.unwrap()
    };
    let (with, without) = (std(&format!("{MODEL}{OBSERVE}")), std(MODEL));
    // a sensor with a tenth of the noise, which sees at most half of the speed
    assert!(with < 0.5 * without, "{with} {without}");
}

#[test]
fn what_is_missing_shows_in_the_function_alone() {
    let text =
        format!("{MODEL}{OBSERVE}[[effect]]\nid = 'ballast'\ndof = 'surge'\nformula = '-sin(theta)'\nunit = 'N'\n");
    let found = campaign::discover(&campaign(&text, 0.0, 30.0)).unwrap();
    let names: Vec<&str> = found.effects.iter().map(|e| e.id.as_str()).collect();
    assert!(names.iter().any(|n| *n == "ballast@surge" || *n == "restoring_surge"), "{names:?}");
    assert!((found.effects[0].parameters[0].value.abs() - 30.0).abs() < 3.0, "{:?}", found.effects[0]);
    let depth_rate = |k: usize| found.gap[k].held_out_rms.iter().find(|(m, _)| m.channel() == "depth_rate").unwrap().1;
    assert!(*depth_rate(0) > 5.0 * depth_rate(1), "{:?}", found.gap);
    assert!(found.places.iter().any(|p| p.dof.channel() == "depth_rate"));
}

#[test]
fn what_cannot_be_observed_is_told() {
    let runs = || vec![run("run1", Role::Train, (1, 0.0), 0.0)];
    let refuse = |text: &str| Campaign::from_runs(file(&format!("{MODEL}{text}")), runs()).unwrap_err().to_string();
    let observe = |channel: &str, formula: &str| format!("[[observe]]\nchannel = '{channel}'\nformula = '{formula}'\n");
    assert!(refuse(&observe("depth_rate", "-u*sin(theat)")).contains("did you mean `theta`"));
    assert!(refuse(&observe("depth_rate", "depth_rate + u")).contains("predicted from itself"));
    assert!(refuse(&observe("u", "sin(theta)")).contains("the model predicts `u`"));
    let absent = Campaign::from_runs(file(&format!("{MODEL}{}", observe("climb", "u"))), runs()).unwrap_err();
    assert_eq!(absent.findings()[0].column.as_deref(), Some("climb"));
}

/// A formula must have the unit of its column; a number in the formula may have a unit.
#[test]
fn a_formula_in_another_unit_than_its_column_is_refused() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("observed_units");
    std::fs::create_dir_all(&folder).unwrap();
    let load = |unit: &str, formula: &str| {
        let rows: String = (0..50).map(|k| format!("{},0.1,20,{},0.01\n", 0.1 * f64::from(k), 0.2 + 0.01)).collect();
        std::fs::write(folder.join("a.csv"), format!("t,theta,tau_u,u,depth_rate{unit}\n{rows}")).unwrap();
        let observe = format!("[[observe]]\nchannel = 'depth_rate'\nformula = '{formula}'\n");
        let file = folder.join("campaign.toml");
        std::fs::write(&file, format!("{MODEL}{observe}[[run]]\nfile = 'a.csv'\n")).unwrap();
        Campaign::load(&file, LoadOptions::default()).map(|_| ()).map_err(|e| e.to_string())
    };
    let told = load(" [rad/s]", "-u*sin(theta)").unwrap_err();
    assert!(told.contains("`-u*sin(theta)` is in m/s, but run `a.csv` has `depth_rate` in rad/s"), "{told}");
    assert!(told.contains("campaign.toml:9"), "{told}");
    let told = load(" [cm/s]", "u^2").unwrap_err();
    assert!(told.contains("is in m2/s2, but run `a.csv` has `depth_rate` in m/s"), "{told}");
    for (unit, formula) in
        [("", "u^2"), (" [cm/s]", "-u*sin(theta)"), (" [rad/s]", "0.3*u"), (" [Pa]", "u^2"), (" [deg]", "theta*u/u")]
    {
        assert_eq!(load(unit, formula), Ok(()), "{unit} {formula}");
    }
}
