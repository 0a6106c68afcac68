//! Diagnostics of a fit: parameters that the data cannot distinguish, halves of the data that
//! differ, terms without effect, and an inertia that depends on the amplitude.

use std::path::Path;

use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{self, Campaign, Estimator, Fit, FitOptions, PlanRequest, PlanSource, Resampler};
use hydrosysid::run::{Role, Run};
use hydrosysid::tank::{Blind, BlindOptions, Hidden, blind};

/// A campaign of tank runs with this model.
fn campaign(runs: Vec<Run>, model: &str) -> Campaign {
    let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let text = format!(
        "format = 1\n[vehicle]\nmass = 189.0\nvolume = 0.19\nlength = 0.575\n[model]\ndofs = ['surge', 'sway', 'yaw']\n{model}\n[[run]]\nfile = 'a.csv'\n"
    );
    let file =
        CampaignFile::from_bytes(text.as_bytes(), Path::new("it.toml"), &options).unwrap_or_else(|e| panic!("{e}"));
    Campaign::from_runs(file, runs).unwrap_or_else(|e| panic!("{e}"))
}

fn sailed(hidden: &[Hidden], seed: u64) -> Blind {
    let options = BlindOptions { seed, duration: 60.0, hidden: hidden.to_vec(), ..BlindOptions::default() };
    blind(&options).expect("the tank sails")
}

fn train(made: &Blind) -> Vec<Run> {
    made.runs.iter().filter(|run| run.role == Role::Train).cloned().collect()
}

fn fitted(campaign: &Campaign) -> Fit {
    campaign::fit(campaign, FitOptions { estimator: Some(Estimator::OutputError) }).unwrap_or_else(|e| panic!("{e}"))
}

fn codes(fit: &Fit) -> Vec<&str> {
    fit.warnings.iter().map(|f| f.code).collect()
}

const BASELINE: &str =
    "effects = ['inertia', 'linear_drag', 'quadratic_drag', 'coriolis_surge', 'coriolis_sway', 'coriolis_yaw']";

#[test]
fn a_good_campaign_gives_no_reason_to_doubt() {
    let fit = fitted(&campaign(train(&sailed(&[], 4)), BASELINE));
    let known = fit.identifiability.as_ref().expect("output error tells it");
    assert!(known.groups.is_empty(), "{:?}", known.groups);
    for code in ["M121", "M122", "M124", "M125"] {
        assert!(!codes(&fit).contains(&code), "{:?}", fit.warnings);
    }
    assert_eq!(known.parameters.len(), 9);
    // the shares of one balance; surge has its own three terms and the Coriolis term
    let surge: f64 = known.parameters.iter().filter(|p| p.term.ends_with("@surge")).filter_map(|p| p.force_share).sum();
    assert!((0.5..=1.0 + 1e-9).contains(&surge), "{surge}");
    for p in &known.parameters {
        assert!(
            p.inflation >= 1.0 - 1e-9 && p.first_half.is_some() && p.halves_z.is_some_and(|z| z.abs() < 4.0),
            "{p:?}"
        );
    }
    let json = serde_json::to_value(&fit).expect("a fit is JSON");
    assert_eq!(json["identifiability"]["parameters"][0]["term"], "inertia@surge");
}

/// A run with thrust of one sign covers a narrow range of speeds, in which laws of drag cannot be
/// distinguished: at least two of the three are named as a group.
#[test]
fn laws_of_drag_at_nearly_one_speed_are_named_as_a_group() {
    let made = sailed(&[], 4);
    let mut runs = train(&made);
    runs.truncate(1);
    let model = "effects = ['inertia', 'linear_drag', 'quadratic_drag', 'cubic_drag@surge']\n[[parameter]]\neffect = 'inertia@sway'\nvalue = 600.0\nfixed = true\n[[parameter]]\neffect = 'inertia@yaw'\nvalue = 180.0\nfixed = true\n[[parameter]]\neffect = 'linear_drag@sway'\nvalue = 100.0\nfixed = true\n[[parameter]]\neffect = 'linear_drag@yaw'\nvalue = 15.0\nfixed = true\n[[parameter]]\neffect = 'quadratic_drag@sway'\nvalue = 500.0\nfixed = true\n[[parameter]]\neffect = 'quadratic_drag@yaw'\nvalue = 100.0\nfixed = true";
    let loaded = campaign(runs, model);
    let mut fit = fitted(&loaded);
    let known = fit.identifiability.clone().expect("output error tells it");
    let drags = |terms: &[String]| terms.iter().filter(|t| t.contains("drag@surge")).count();
    assert!(known.groups.iter().any(|g| drags(&g.terms) >= 2), "{:?}", known.condition_indices);
    assert!(codes(&fit).contains(&"M121"));
    assert!(known.correlations.iter().any(|c| c.correlation.abs() > 0.9));
    campaign::examine(&loaded, &mut fit).unwrap_or_else(|e| panic!("{e}"));
    let known = fit.identifiability.expect("it is still there");
    assert_eq!(known.segment_lengths.len(), 2);
    assert!(!known.profiles.is_empty());
    for one in &known.profiles {
        assert!(one.values.len() == one.rise.len() && one.rise.contains(&0.0), "{one:?}");
        let p = fit.parameters.iter().find(|p| p.name == one.name).expect("it was fitted");
        if let [Some(low), Some(high)] = one.interval {
            assert!(low < p.value && p.value < high, "{one:?}");
        }
    }
    assert!(known.groups.iter().all(|g| g.run.contains("would reduce their standard errors")), "{:?}", known.groups);
}

#[test]
fn a_thruster_that_fails_makes_the_halves_differ() {
    let made = sailed(&[Hidden::new("thruster_fault@surge", 1.0)], 4);
    let fit = fitted(&campaign(train(&made), BASELINE));
    let halves: Vec<_> = fit.warnings.iter().filter(|f| f.code == "M122").collect();
    assert!(halves.iter().any(|f| f.message.contains("surge")), "{:?}", fit.warnings);
}

/// If the runs have a Munk moment and the model does not, the warning that something is missing
/// comes first, and a finding on the inertia does not propose an effect of its own.
#[test]
fn a_model_far_from_the_data_is_told_so_before_anything_else() {
    let lame = BASELINE.replace(", 'coriolis_yaw'", "");
    let good = codes(&fitted(&campaign(train(&sailed(&[], 4)), BASELINE))).contains(&"M128");
    assert!(!good, "a model down to the noise");
    let mut blamed = 0;
    for seed in [4, 5, 6] {
        let runs = sailed(&[], seed).runs.into_iter().map(|run| Run { role: Role::Train, ..run }).collect();
        let fit = fitted(&campaign(runs, &lame));
        let first = fit.warnings.iter().find(|f| f.code == "M128").expect("it is far above the noise");
        assert!(first.message.contains("r by ") && first.message.contains("discover"), "{}", first.message);
        let of = |code| fit.warnings.iter().position(|f| f.code == code);
        if let Some(told) = of("M125") {
            blamed += 1;
            assert!(of("M128") < Some(told), "what leads the reader comes first");
            let message = &fit.warnings[told].message;
            assert!(message.contains("something else is missing") && !message.contains("add the effect"), "{message}");
        }
    }
    assert!(blamed > 0, "no campaign in which the inertia makes up for Munk's moment: the test shows nothing");
}

#[test]
fn a_closer_look_at_a_model_that_runs_away_leaves_the_fit_as_it_is() {
    let lame = BASELINE.replace(", 'coriolis_yaw'", "");
    let made = campaign(train(&sailed(&[], 4)), &lame);
    let mut fit = fitted(&made);
    // a negative drag in yaw, with which the model diverges
    let drag = fit.model.parameter("quadratic_drag@yaw", "k_r|r|").expect("it is in the model");
    fit.model.parameters[drag].value = -1e5;
    campaign::examine(&made, &mut fit).expect("the fit stands");
    assert!(codes(&fit).contains(&"M129"), "{:?}", fit.warnings);
    assert!(fit.identifiability.is_some(), "what was known of it stays");
}

#[test]
fn a_term_without_force_is_not_resolved_and_harmless() {
    let model = format!("{}\n", BASELINE.replace("]", ", 'coulomb_friction@surge', 'mixed_drag@sway:yaw']"));
    let fit = fitted(&campaign(train(&sailed(&[], 4)), &model));
    let told: Vec<_> = fit.warnings.iter().filter(|f| f.code == "M211").collect();
    assert!(told.iter().any(|f| f.message.contains("coulomb_friction@surge")), "{:?}", fit.warnings);
}

#[test]
fn free_coriolis_terms_are_shown_beside_the_masses_and_do_no_work() {
    let fit = fitted(&campaign(train(&sailed(&[], 4)), &format!("coriolis = 'free'\n{BASELINE}")));
    let told = fit.warnings.iter().find(|f| f.code == "M212").expect("it is shown");
    assert!(told.message.contains("m_v − m_u"), "{}", told.message);
    assert!(!codes(&fit).contains(&"M124"), "{:?}", fit.warnings);
}

#[test]
fn inertia_that_grows_with_the_amplitude_is_found_and_the_effect_proposed() {
    let hidden = Hidden::new("added_mass_amplitude@surge", 1.0);
    let made = sailed(&[hidden], 6);
    // all nine runs, for several amplitudes
    let runs: Vec<Run> = made.runs.iter().map(|run| Run { role: Role::Train, ..run.clone() }).collect();
    let fit = fitted(&campaign(runs.clone(), BASELINE));
    let known = fit.identifiability.as_ref().expect("output error tells it");
    let surge = known.inertia_against_amplitude.iter().find(|a| a.dof.name() == "surge").expect("surge oscillates");
    assert!(surge.runs.len() >= 3 && surge.p_value < 1e-3, "{surge:?}");
    assert!(surge.runs.iter().all(|r| r.std > 0.0 && r.added_mass_coefficient.is_some()));
    let truth = made.truth.value("added_mass_amplitude@surge").expect("it is hidden there");
    // the slope of a line through the estimates of the runs, within four of its standard deviations
    assert!((surge.slope - truth).abs() < 4.0 * surge.slope_std, "{} ± {}, {truth}", surge.slope, surge.slope_std);
    let told = fit.warnings.iter().find(|f| f.code == "M125").expect("it is said");
    assert!(told.message.contains("added_mass_amplitude@surge"), "{}", told.message);
    let better = fitted(&campaign(runs, &BASELINE.replace("]", ", 'added_mass_amplitude@surge']")));
    assert!(!codes(&better).contains(&"M125"), "{:?}", better.warnings);
    // using the model at another amplitude raises a warning
    let mut wide = campaign(train(&made), BASELINE);
    for signal in ["KC_u"] {
        for run in &mut wide.runs {
            let old = run.signals[signal].clone();
            let values: Vec<f64> = old.values().iter().map(|x| 5.0 * x).collect();
            run.signals.insert(signal.into(), hydrosysid::run::Signal::new(old.shared_time().clone(), values));
        }
    }
    let compared = campaign::compare(&wide, &fit.model, &fit.envelope).unwrap_or_else(|e| panic!("{e}"));
    assert!(compared.warnings.iter().any(|f| f.code == "E102"), "{:?}", compared.warnings);
}

#[test]
fn a_campaign_plans_its_own_next_runs() {
    let loaded = campaign(train(&sailed(&[], 4)), BASELINE);
    let fit = fitted(&loaded);
    let request = PlanRequest {
        length: 40.0,
        most: 3,
        wants: vec!["2%".parse().expect("it is a wish")],
        without_known: true,
        ..PlanRequest::default()
    };
    let plan = campaign::plan(&PlanSource::of_fit(&loaded, &fit), &request, &|| {}).unwrap_or_else(|e| panic!("{e}"));
    assert!(!plan.runs.is_empty());
    assert!(plan.warnings.iter().any(|f| f.code == "P201"), "limits are those of the runs: {:?}", plan.warnings);
    // the noise of the sensors is the one that the fit estimated: 5 mm/s
    assert!((plan.sensors["u"].noise / 0.005 - 1.0).abs() < 0.1 && (plan.sensors["u"].rate - 10.0).abs() < 1e-6);
}

/// For integral least squares on windows of 1 s, identifiability follows from the covariance;
/// halves of the data and longer windows follow from the further fits of `examine`.
#[test]
fn a_fit_by_rows_says_what_its_data_can_tell() {
    let mut loaded = campaign(train(&sailed(&[], 4)), BASELINE);
    loaded.file.stage.oscillatory.window = 10;
    let options = FitOptions { estimator: Some(Estimator::Integral) };
    let mut fit = campaign::fit(&loaded, options).unwrap_or_else(|e| panic!("{e}"));
    let known = fit.identifiability.as_ref().expect("its covariance tells it");
    assert_eq!(known.parameters.len(), 9);
    for p in &known.parameters {
        assert!(p.inflation >= 1.0 - 1e-9 && p.force_share.is_some() && p.first_half.is_none(), "{p:?}");
    }
    // linear and quadratic drag of one degree of freedom are correlated, the inertia in yaw is not
    let inflation = |term: &str| known.parameters.iter().find(|p| p.term == term).map_or(0.0, |p| p.inflation);
    assert!(inflation("linear_drag@surge") > 2.0 && inflation("inertia@yaw") < 2.0, "{:?}", known.parameters);
    campaign::examine(&loaded, &mut fit).unwrap_or_else(|e| panic!("{e}"));
    let known = fit.identifiability.expect("it is still there");
    assert_eq!(known.windows.iter().map(|w| w.times).collect::<Vec<_>>(), [2, 4]);
    assert!(known.windows.iter().all(|w| w.change.len() == 9 && w.change.values().any(|c| *c != 0.0)));
    for p in &known.parameters {
        let (first, second) = (p.first_half.expect("two halves"), p.second_half.expect("two halves"));
        let whole = fit.parameters.iter().find(|q| q.name == p.name).expect("it was fitted").value;
        assert!((0.5..2.0).contains(&(first / whole)) && (0.5..2.0).contains(&(second / whole)), "{p:?} {whole}");
    }
}

#[test]
fn halves_of_rows_differ_where_a_thruster_fails() {
    let mut loaded = campaign(train(&sailed(&[Hidden::new("thruster_fault@surge", 1.0)], 4)), BASELINE);
    loaded.file.stage.oscillatory.window = 10;
    let options = FitOptions { estimator: Some(Estimator::Integral) };
    let mut fit = campaign::fit(&loaded, options).unwrap_or_else(|e| panic!("{e}"));
    assert!(!codes(&fit).contains(&"M122"));
    campaign::examine(&loaded, &mut fit).unwrap_or_else(|e| panic!("{e}"));
    let halves: Vec<_> = fit.warnings.iter().filter(|f| f.code == "M122").collect();
    assert!(halves.iter().any(|f| f.message.contains("surge")), "{:?}", fit.warnings);
}

#[test]
fn refits_are_those_of_the_estimator_that_was_asked() {
    let mut loaded = campaign(train(&sailed(&[], 4)), BASELINE);
    loaded.file.stage.oscillatory.window = 10;
    let options = FitOptions { estimator: Some(Estimator::Integral) };
    let fit = campaign::fit(&loaded, options).unwrap_or_else(|e| panic!("{e}"));
    let drawn = |draws| {
        campaign::resample(&loaded, Estimator::Integral, Resampler::Bootstrap, draws).unwrap_or_else(|e| panic!("{e}"))
    };
    let found = drawn(60);
    // a draw without the stretches that excite a parameter has no solution
    assert!(found.draws >= 55 && found.draws + found.failed == 60 && found.parameters.len() == 9, "{found:?}");
    for one in &found.parameters {
        let told = fit.parameters.iter().find(|p| p.name == one.name).expect("it was fitted");
        assert_eq!(one.value.to_bits(), told.value.to_bits(), "{}", one.name);
        // with a dozen stretches and 60 draws, each of the two standard deviations is known to about 30 %
        let ratio = one.std / told.std.expect("it has one");
        assert!((0.3..3.0).contains(&ratio), "{}: {ratio}", one.name);
        assert!(one.interval[0] < one.mean && one.mean < one.interval[1], "{one:?}");
    }
    assert_eq!(drawn(5), drawn(5), "the same seed");
    // data from the fitted model: white noise, which rows of ten samples average, and no missing effect
    let made =
        campaign::resample(&loaded, Estimator::Integral, Resampler::MonteCarlo, 60).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((made.draws, made.failed, made.parameters.len()), (60, 0, 9));
    for one in &made.parameters {
        let told = fit.parameters.iter().find(|p| p.name == one.name).expect("it was fitted");
        let ratio = one.std / told.std.expect("it has one");
        assert!((0.3..3.0).contains(&ratio), "{}: {ratio}", one.name);
        // noise in the regressors biases the estimates, which this method is meant to show
        assert!((one.mean - one.value).abs() < 5.0 * one.std + 0.1 * one.value.abs(), "{one:?}");
    }
}
