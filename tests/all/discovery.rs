//! Discovery on campaigns in which an effect is hidden, and on campaigns in which nothing is.
//!
//! Seeds here were never looked at while the method was made; the statistics over many of them are in `docs/blind.md`.

use hydrosysid::campaign::{self, Campaign, LoadOptions};
use hydrosysid::discover::{Discovery, SearchOptions, Verdict, discover};
use hydrosysid::estimate::output_error::OutputErrorOptions;
use hydrosysid::tank::{Blind, BlindOptions, CraftKind, Hidden, blind};

use crate::shared;

fn answer(options: &BlindOptions) -> (Blind, Discovery) {
    let campaign = blind(options).expect("the tank sails");
    let model = campaign.model().expect("the baseline is a model");
    let fitting = OutputErrorOptions { position: true, ..OutputErrorOptions::default() };
    let found = discover(&model, &campaign.runs, &[], &fitting, &SearchOptions::default()).expect("a fit");
    (campaign, found)
}

fn hiding(name: &str, craft: CraftKind, seed: u64) -> (Blind, Discovery) {
    answer(&BlindOptions { seed, craft, hidden: vec![Hidden::new(name, 1.0)], ..BlindOptions::default() })
}

/// The largest held-out gap over the noise after step `k`.
fn gap(found: &Discovery, k: usize) -> f64 {
    let step = &found.gap[k];
    step.held_out_rms.iter().map(|(dof, rms)| rms / step.noise_floor[dof]).fold(0.0, f64::max)
}

#[test]
fn blind_nothing_hidden_is_nothing_missing() {
    let (_, found) = answer(&BlindOptions { seed: 101, ..BlindOptions::default() });
    assert_eq!(found.verdict, Verdict::NothingMissing);
    assert!(found.effects.is_empty() && found.gap.len() == 1);
    assert!(!found.smallest_visible.is_empty(), "a null says what it could have shown");
}

#[test]
fn blind_coloured_noise_is_no_effect() {
    for craft in [CraftKind::Large, CraftKind::Small] {
        let (_, found) = answer(&BlindOptions { seed: 102, colour: 0.8, craft, ..BlindOptions::default() });
        assert_eq!(found.verdict, Verdict::NothingMissing, "{:?} {}", found.effects, gap(&found, 0));
    }
}

/// Slow noise gives a memory something to follow at the beginning of every segment, and what it leaves open of an unstable
/// run grows to three times the noise: neither is an effect.
#[test]
fn blind_coloured_noise_is_no_memory_and_no_gap() {
    for seed in [9, 111] {
        let small = BlindOptions { seed, colour: 0.8, craft: CraftKind::Small, ..BlindOptions::default() };
        let (_, found) = answer(&small);
        assert_eq!(found.verdict, Verdict::NothingMissing, "seed {seed}: {:?} {}", found.effects, gap(&found, 0));
    }
}

/// The noise of the tank is 5 mm/s and 3 mrad/s. Two seconds hold one sample: a floor of nothing would be read from
/// them. What the command does between samples comes on top of the noise.
#[test]
fn blind_a_slow_log_has_a_noise_floor() {
    let slow = BlindOptions { seed: 112, rate: 0.5, duration: 300.0, ..BlindOptions::default() };
    let (_, found) = answer(&slow);
    assert_eq!(found.verdict, Verdict::NothingMissing, "{:?} {}", found.effects, gap(&found, 0));
    for (measured, floor) in &found.gap[0].noise_floor {
        let noise = if measured.channel() == "r" { 3e-3 } else { 5e-3 };
        assert!(*floor > 0.8 * noise, "{}: {floor}", measured.channel());
    }
}

/// One effect of each family, on the large vehicle and on the small one, whose motion is unstable in yaw: named, with a
/// value within four of its standard deviations, and the gap closed.
#[test]
fn blind_one_hidden_effect_of_each_family_is_named() {
    for (name, craft, seed) in [
        ("coriolis_yaw", CraftKind::Large, 103),
        ("thrust_reverse_loss@surge", CraftKind::Large, 104),
        ("current", CraftKind::Large, 105),
        ("sensor_dvl_misalignment", CraftKind::Large, 106),
        ("thrust_reverse_loss@surge", CraftKind::Small, 104),
        ("thrust_deadband@surge", CraftKind::Small, 104),
        ("sensor_dvl_misalignment", CraftKind::Small, 106),
    ] {
        let (campaign, found) = hiding(name, craft, seed);
        let names: Vec<&str> = found.effects.iter().map(|e| e.id.as_str()).collect();
        assert_eq!(names, [name]);
        assert_eq!(found.verdict, Verdict::Explained, "{name}: {}", gap(&found, 1));
        let (before, after) = (gap(&found, 0), gap(&found, 1));
        assert!(before > 1.5 && after < 1.2, "{name}: from {before} to {after} times the noise");
        let index = campaign.truth.term(name).unwrap();
        for (p, q) in campaign.truth.terms[index].parameters.iter().zip(&found.effects[0].parameters) {
            let truth = campaign.truth.parameters[*p].value;
            assert!((q.value - truth).abs() < 4.0 * q.std, "{name} {}: {} ± {}, true {truth}", q.name, q.value, q.std);
        }
    }
}

#[test]
fn blind_a_delay_lists_what_no_data_can_tell_from_it() {
    let (_, found) = hiding("sensor_delay", CraftKind::Large, 107);
    assert_eq!(found.effects[0].id, "thrust_delay");
    assert!(found.effects[0].also_possible.contains(&"sensor_delay".to_string()));
    assert!(found.next_experiment.is_some());
}

/// Two effects of different families: at the baseline, far from the data, the friction in surge looks like a cubic drag.
#[test]
fn blind_two_effects_are_both_named() {
    let hidden = vec![Hidden::new("coulomb_friction@surge", 1.0), Hidden::new("sensor_gyro_bias", 1.0)];
    let (_, found) = answer(&BlindOptions { seed: 108, hidden, ..BlindOptions::default() });
    let mut names: Vec<&str> = found.effects.iter().map(|e| e.id.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["coulomb_friction@surge", "sensor_gyro_bias"]);
    assert_eq!(found.verdict, Verdict::Explained);
    let last = found.gap.len() - 1;
    assert!(gap(&found, 0) > 3.0 && gap(&found, last) < 1.2, "{} to {}", gap(&found, 0), gap(&found, last));
}

/// Under its commands the small vehicle is unstable: a whole run cannot be simulated, which is said, and the gap is that
/// of segments.
#[test]
fn blind_unstable_runs_are_compared_in_segments() {
    let (_, found) = answer(&BlindOptions { seed: 104, craft: CraftKind::Small, ..BlindOptions::default() });
    assert!(found.effects.is_empty(), "{:?}", found.effects);
    assert_eq!(found.verdict, Verdict::NothingMissing);
    assert!(found.warnings.iter().any(|w| w.code == "D102"), "{:?}", found.warnings);
    assert!(gap(&found, 0) < 1.15, "{}", gap(&found, 0));
}

/// At a fifth of the noise the error of steps that are long for the small vehicle's yaw would show, and be named.
#[test]
fn blind_little_noise_on_a_quick_vehicle_shows_no_step_of_the_integrator() {
    let little = BlindOptions { seed: 111, craft: CraftKind::Small, noise: 0.2, ..BlindOptions::default() };
    let (_, found) = answer(&little);
    assert_eq!(found.verdict, Verdict::NothingMissing, "{:?}", found.effects);
}

/// Every step of the gap says whether its effect stays.
#[test]
fn blind_steps_that_were_dropped_say_so() {
    let (_, found) = hiding("coriolis_yaw", CraftKind::Small, 101);
    let kept: Vec<&str> = found.gap.iter().filter(|s| !s.dropped).filter_map(|s| s.added.as_deref()).collect();
    assert_eq!(kept, ["coriolis_yaw"]);
    for step in found.gap.iter().filter(|s| s.dropped) {
        assert!(found.removed.contains(step.added.as_ref().unwrap()), "{step:?}");
    }
}

/// What no catalogue holds may get a neighbour's name, but not the verdict that it is explained by a stranger.
#[test]
fn blind_an_effect_outside_the_catalogue_is_not_explained_by_a_stranger() {
    let (_, found) = hiding("vortex_shedding", CraftKind::Large, 109);
    assert_ne!(found.verdict, Verdict::Explained, "{:?}", found.effects);
}

/// Sloshing water looks like memories and waves on other runs, and leaves more than the noise where it was fitted.
#[test]
fn blind_names_that_leave_more_than_the_noise_are_no_explanation() {
    let (_, found) = hiding("sloshing", CraftKind::Large, 7);
    assert!(found.warnings.iter().any(|w| w.code == "D105"), "{:?} {:?}", found.effects, found.warnings);
    assert_eq!(found.verdict, Verdict::PartlyExplained, "{:?}", found.effects);
}

#[test]
fn example_campaigns_have_their_verdicts() {
    let Some(folder) = shared::path("example_campaigns") else { return };
    let verdict = |name: &str| {
        let loaded = Campaign::load(&folder.join(name).join("campaign.toml"), LoadOptions::default()).unwrap();
        campaign::discover(&loaded).unwrap()
    };
    let munk = verdict("munk_hidden");
    assert_eq!(munk.effects.iter().map(|e| e.id.as_str()).collect::<Vec<_>>(), ["coriolis_yaw"]);
    assert_eq!(munk.verdict, Verdict::Explained);
    // k_uv of the truth: 19.2734 − 17.0003 kg
    let k = &munk.effects[0].parameters[0];
    assert!((k.value - 2.2731).abs() < 4.0 * k.std, "{} ± {}", k.value, k.std);
    assert_eq!(verdict("nothing_hidden").verdict, Verdict::NothingMissing);
}

/// A yaw rate in degrees is a wrong unit and no physics: it is said, and nothing else is found.
#[test]
fn a_wrong_unit_is_recognised_before_physics_is_blamed() {
    let Some(folder) = shared::path("example_campaigns") else { return };
    let mut loaded =
        Campaign::load(&folder.join("nothing_hidden").join("campaign.toml"), LoadOptions::default()).unwrap();
    for run in &mut loaded.runs {
        let r = &run.signals["r"];
        let degrees: Vec<f64> = r.values().iter().map(|x| x.to_degrees()).collect();
        let signal = hydrosysid::run::Signal::new(r.shared_time().clone(), degrees);
        run.signals.insert("r".into(), signal);
    }
    let found = campaign::discover(&loaded).unwrap();
    let [fault] = found.log_findings.as_slice() else { panic!("{:?}", found.log_findings) };
    assert_eq!((fault.kind.as_str(), fault.channel.as_str()), ("unit", "r"));
    // the factor is estimated from the heading, whose noise leaves some tenths of a percent
    assert!((fault.factor / 57.2958 - 1.0).abs() < 0.02, "{}", fault.factor);
    assert!(found.effects.iter().all(|e| e.id == "sensor_gyro_scale"), "{:?}", found.effects);
}
