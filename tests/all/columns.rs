//! A log column whose force has a standard form, such as wind, becomes a candidate by itself, and
//! is found if it acts.

use std::path::Path;

use crate::surge::surge;
use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{self, Campaign};
use hydrosysid::run::{Role, Run, Signal};
use hydrosysid::tank::Noise;

/// Log of surge of a vehicle at the surface: 100 u̇ = τ − 80 u|u| − k A (u + W cos γ),
/// γ = ψ_W − ψ, A² = (u + W cos γ)² + W² sin² γ, with the wind W from ψ_W.
fn run(name: &str, role: Role, seed: u64, k: f64) -> Run {
    let samples = 600;
    let phase = seed as f64;
    let tau = |t: f64| 40.0 * (0.5 * t + phase).sin() + 25.0 * (0.17 * t).cos();
    let wind = |t: f64| 6.0 + 2.0 * (0.11 * t + phase).sin();
    let direction = 1.0;
    let psi = |t: f64| 0.1 * t + phase;
    let blows = |t: f64, u: f64| {
        let (ahead, across) = (u + wind(t) * (direction - psi(t)).cos(), wind(t) * (direction - psi(t)).sin());
        -k * ahead.hypot(across) * ahead
    };
    let rate = |t: f64, u: f64| (tau(t) - 80.0 * u * u.abs() + blows(t, u)) / 100.0;
    let (time, speed) = surge(samples, rate);
    let white = Noise::new(seed, 3).coloured(samples, 0.0);
    let clock: std::sync::Arc<[f64]> = time.clone().into();
    let of = |f: &dyn Fn(usize) -> f64| Signal::new(clock.clone(), (0..samples).map(f).collect::<Vec<_>>());
    let mut run = Run { name: name.into(), role, ..Run::default() };
    run.signals.insert("tau_u".into(), of(&|k| tau(time[k])));
    run.signals.insert("u".into(), of(&|k| speed[k] + 0.005 * white[k]));
    run.signals.insert("psi".into(), of(&|k| psi(time[k])));
    run.signals.insert("wind_speed".into(), of(&|k| wind(time[k])));
    run.signals.insert("wind_dir".into(), of(&|_| direction));
    run
}

fn campaign(k: f64) -> Campaign {
    with_effects(k, "'inertia', 'quadratic_drag'")
}

fn with_effects(k: f64, effects: &str) -> Campaign {
    let text = format!("format = 1\n[model]\ndofs = ['surge']\neffects = [{effects}]\n[[run]]\nfile = 'a.csv'\n");
    let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let file = CampaignFile::from_bytes(text.as_bytes(), Path::new("wind.toml"), &options);
    let role = |n: u64| if n < 5 { Role::Train } else { Role::Validate };
    let runs = (1..=6).map(|n| run(&format!("run{n}"), role(n), n, k)).collect();
    Campaign::from_runs(file.unwrap_or_else(|e| panic!("{e}")), runs).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn wind_is_found_by_its_columns() {
    let found = campaign::discover(&campaign(0.4)).unwrap();
    let names: Vec<&str> = found.effects.iter().map(|e| e.id.as_str()).collect();
    assert_eq!(names, ["wind_surge@surge"], "{:?}", found.warnings);
    let parameter = &found.effects[0].parameters[0];
    // within four of its own standard deviations
    assert!((parameter.value - 0.4).abs() < 4.0 * parameter.std && parameter.std < 0.04, "{parameter:?}");
    assert!(
        found.warnings.iter().any(|w| w.code == "M206" && w.message.contains("wind_surge")),
        "{:?}",
        found.warnings
    );
}

#[test]
fn wind_that_does_not_act_is_not_named() {
    let found = campaign::discover(&campaign(0.0)).unwrap();
    assert!(found.effects.is_empty(), "{:?}", found.effects);
}

/// An adopted effect of wind is estimated as a part of the model, within four of its standard
/// deviations, and is no longer a candidate.
#[test]
fn wind_that_was_adopted_is_in_the_model() {
    let blown = with_effects(0.4, "'inertia', 'quadratic_drag', 'wind_surge'");
    let fit = campaign::fit(&blown, campaign::FitOptions::default()).unwrap();
    let wind = fit.parameters.iter().find(|p| p.effect.starts_with("wind_surge")).expect("it is in the model");
    assert!((wind.value - 0.4).abs() < 4.0 * wind.std.unwrap() && wind.std.unwrap() < 0.04, "{wind:?}");
    let ids: Vec<String> = blown.candidates.iter().map(|(effect, _)| effect.about().id.to_string()).collect();
    assert_eq!(ids, ["wind_to_surge"]);
}
