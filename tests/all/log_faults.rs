//! A wrong unit, sign or frame of a log, or a late sensor, is recognised as such and not taken for
//! a missing effect: the verdict on the tampered campaign is that on the sound one.

use std::f64::consts::PI;

use hydrosysid::campaign::{self, Campaign, LoadOptions};
use hydrosysid::discover::{Discovery, Verdict};
use hydrosysid::run::{Run, Signal};

use crate::shared;

fn sound() -> Option<Campaign> {
    let file = shared::path("example_campaigns/nothing_hidden/campaign.toml")?;
    Some(Campaign::load(&file, LoadOptions::default()).unwrap_or_else(|e| panic!("{e}")))
}

fn change(run: &mut Run, channel: &str, f: impl Fn(f64) -> f64) {
    let signal = &run.signals[channel];
    let changed = Signal::new(signal.shared_time().clone(), signal.values().iter().map(|x| f(*x)).collect::<Vec<_>>());
    run.signals.insert(channel.into(), changed);
}

fn swap(run: &mut Run, a: &str, b: &str) {
    let (x, y) = (run.signals[a].clone(), run.signals[b].clone());
    run.signals.insert(a.into(), y);
    run.signals.insert(b.into(), x);
}

fn discovered(tamper: impl Fn(&mut Run)) -> Option<Discovery> {
    let mut campaign = sound()?;
    campaign.runs.iter_mut().for_each(tamper);
    let found = campaign::discover(&campaign).unwrap_or_else(|e| panic!("{e}"));
    Some(found)
}

/// Asserts that the discovery names a fault of this kind on these channels, and no missing effect.
fn is_told(found: &Discovery, kind: &str, channels: &[&str]) {
    let told: Vec<&str> = found.log_findings.iter().map(|f| f.channel.as_str()).collect();
    assert_eq!(told, channels, "{:?}", found.log_findings);
    assert!(found.log_findings.iter().all(|f| f.kind == kind && !f.message.is_empty()), "{:?}", found.log_findings);
    assert!(found.warnings.iter().any(|w| w.code == "M110"));
    assert!(found.effects.is_empty(), "{:?}", found.effects);
    assert_eq!(found.verdict, Verdict::NothingMissing);
}

#[test]
fn a_sound_log_has_no_faults() {
    let Some(found) = discovered(|_| ()) else { return };
    assert!(found.log_findings.is_empty() && found.verdict == Verdict::NothingMissing, "{:?}", found.log_findings);
}

#[test]
fn a_rate_in_degrees() {
    let Some(found) = discovered(|run| change(run, "r", |x| x * 180.0 / PI)) else { return };
    is_told(&found, "unit", &["r"]);
    assert!((found.log_findings[0].factor / 57.3 - 1.0).abs() < 0.05);
}

#[test]
fn a_speed_in_millimetres() {
    let Some(found) = discovered(|run| change(run, "u", |x| 1e3 * x)) else { return };
    is_told(&found, "unit", &["u"]);
}

#[test]
fn a_rate_of_the_wrong_sign() {
    let Some(found) = discovered(|run| change(run, "r", |x| -x)) else { return };
    is_told(&found, "sign", &["r"]);
}

#[test]
fn a_moment_of_the_wrong_sign() {
    let Some(found) = discovered(|run| change(run, "tau_r", |x| -x)) else { return };
    is_told(&found, "sign", &["tau_r"]);
}

#[test]
fn body_axes_forward_port_up() {
    let flu = |run: &mut Run| {
        for channel in ["v", "r", "tau_v", "tau_r", "w", "q", "theta", "tau_w", "tau_q"] {
            change(run, channel, |x| -x);
        }
    };
    let Some(found) = discovered(flu) else { return };
    is_told(&found, "frame", &["psi"]);
}

#[test]
fn earth_axes_east_north_up() {
    let enu = |run: &mut Run| {
        swap(run, "x", "y");
        change(run, "psi", |psi| 0.5 * PI - psi);
    };
    let Some(found) = discovered(enu) else { return };
    is_told(&found, "frame", &["psi"]);
}

#[test]
fn north_and_east_exchanged() {
    let Some(found) = discovered(|run| swap(run, "x", "y")) else { return };
    is_told(&found, "frame", &["x", "y"]);
}

#[test]
fn surge_and_sway_exchanged() {
    let Some(found) = discovered(|run| swap(run, "u", "v")) else { return };
    is_told(&found, "frame", &["u", "v"]);
}

#[test]
fn a_late_compass() {
    let late = |run: &mut Run| {
        let psi = &run.signals["psi"];
        let stamps: Vec<f64> = psi.time().iter().map(|t| t + 0.4).collect();
        let late = Signal::new(stamps.into(), psi.values().to_vec());
        run.signals.insert("psi".into(), late);
    };
    let Some(found) = discovered(late) else { return };
    is_told(&found, "delay", &["psi"]);
    // half the step of the log
    assert!((found.log_findings[0].factor - 0.4).abs() < 0.05, "{:?}", found.log_findings);
}
