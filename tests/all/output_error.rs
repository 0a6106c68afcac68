//! Output error on segments: estimates and standard deviations on data with a known truth.

// a failing fixture fails the test, and values that are set are returned bit for bit
#![allow(clippy::unwrap_used, clippy::float_cmp)]

use hydrosysid::effects::Coriolis;
use hydrosysid::estimate::filter_error::{FilterErrorOptions, filter_error};
use hydrosysid::estimate::output_error::{
    Loss, OutputErrorError, OutputErrorFit, OutputErrorOptions, StdMethod, cramer_rao, output_error,
};
use hydrosysid::estimate::started;
use hydrosysid::frame::Dof;
use hydrosysid::model::{Interpolation, Model};
use hydrosysid::run::{Role, Run, Signal};
use hydrosysid::tank::{BlindOptions, blind};

fn options() -> OutputErrorOptions {
    OutputErrorOptions { position: true, ..OutputErrorOptions::default() }
}

fn train(runs: &[Run]) -> Vec<Run> {
    runs.iter().filter(|r| r.role == Role::Train).cloned().collect()
}

/// The tank integrates in steps of 0.01 s and the fit in steps of 0.1 s. With a millionth of the
/// ordinary noise, only the error of the integrator remains, about 1e-5.
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

/// Quadratic drag with a time constant shorter than the sample time is found: u = U tanh(t/T) after
/// a command of F, U tan(t/T − π/4) while braking, with T = m/√(kF) = 0.08 s and samples every
/// 0.1 s. Steps of half the time constant have an error of 0.05 % in the rate, those of a sample some
/// per cent.
#[test]
fn quick_drag_is_found_from_slow_samples() {
    let (m, k, force) = (0.4, 1.25, 20.0_f64);
    let (top, constant) = ((force / k).sqrt(), m / (k * force).sqrt());
    let time: std::sync::Arc<[f64]> = (0..400).map(|k| 0.1 * f64::from(k)).collect();
    // one second in each direction; the first is from rest, and the final speed is reached in each
    let u = |t: f64| {
        let (since, way) = (t % 1.0, if (t as u64).is_multiple_of(2) { 1.0 } else { -1.0 });
        let phase = if t < 1.0 { since / constant } else { since / constant - 0.25 * std::f64::consts::PI };
        way * top * if phase < 0.0 { phase.tan() } else { phase.tanh() }
    };
    let mut noise = hydrosysid::tank::Noise::new(5, 1);
    let mut run = Run { name: "steps".into(), ..Run::default() };
    let measured: Vec<f64> = time.iter().map(|t| u(*t) + 1e-4 * noise.normal()).collect();
    let command: Vec<f64> = time.iter().map(|t| if (*t as u64).is_multiple_of(2) { force } else { -force }).collect();
    run.signals.insert("u".into(), Signal::new(time.clone(), measured));
    run.signals.insert("tau_u".into(), Signal::new(time.clone(), command));
    let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "quadratic_drag"]).unwrap();
    model.input = Interpolation::Hold;
    let start = started(&model, std::slice::from_ref(&run));
    let by_output = output_error(&start, std::slice::from_ref(&run), &options()).unwrap().model;
    let options = FilterErrorOptions { base: options(), ..FilterErrorOptions::default() };
    let by_filter = filter_error(&start, &[run], &options).unwrap().model;
    for (name, fitted) in [("output error", by_output), ("filter error", by_filter)] {
        for (term, truth) in [("inertia@surge", m), ("quadratic_drag@surge", k)] {
            let found = fitted.value(term).unwrap();
            assert!((found / truth - 1.0).abs() < 2e-3, "{name}: {term} {found} for {truth}");
        }
    }
}

#[test]
fn what_the_data_cannot_tell_is_named() {
    // a vehicle that never moves sideways does not show its sway drag
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
        matches!(&refused, OutputErrorError::NotIdentified { parameters, .. } if parameters.iter().any(|p| p.contains("sway"))),
        "{refused}"
    );
    let nothing = output_error(&model, &[Run::default()], &options()).unwrap_err();
    assert_eq!(nothing, OutputErrorError::NothingObserved);
}

/// The runs with every 29th sample of each velocity wrong by 30 times the noise, all in one direction.
fn with_outliers(runs: &[Run]) -> Vec<Run> {
    let mut runs = runs.to_vec();
    for run in &mut runs {
        for (channel, size) in [("u", 0.15), ("v", 0.15), ("r", 0.09)] {
            let signal = &run.signals[channel];
            let wrong = |(k, x): (usize, &f64)| if k % 29 == 7 { x + size } else { *x };
            let values: Vec<f64> = signal.values().iter().enumerate().map(wrong).collect();
            let signal = Signal::new(signal.shared_time().clone(), values);
            run.signals.insert(channel.into(), signal);
        }
    }
    runs
}

/// Maximum change of a parameter against the fit without outliers, in units of its standard deviation there.
fn worst(fit: &OutputErrorFit, clean: &OutputErrorFit) -> f64 {
    let pairs = fit.model.parameters.iter().zip(&clean.model.parameters);
    pairs.map(|(a, b)| ((a.value - b.value) / b.std.unwrap()).abs()).fold(0.0, f64::max)
}

#[test]
fn robust_losses_hold_outliers_back() {
    let campaign = blind(&BlindOptions { seed: 221, ..BlindOptions::default() }).unwrap();
    let clean = train(&campaign.runs);
    let broken = with_outliers(&clean);
    let start = started(&campaign.model().unwrap(), &clean);
    let by = |loss, runs: &[Run]| output_error(&start, runs, &OutputErrorOptions { loss, ..options() }).unwrap();
    let reference = by(Loss::Squares, &clean);
    let carried = worst(&by(Loss::Squares, &broken), &reference);
    for loss in [Loss::Huber, Loss::Student] {
        // without outliers both differ little from squares: less than 1.5 standard deviations in
        // any parameter
        assert!(worst(&by(loss, &clean), &reference) < 1.5, "{loss:?}");
        let fit = by(loss, &broken);
        let held = worst(&fit, &reference);
        assert!(fit.converged && held < 0.5 * carried && held < 4.0, "{loss:?}: {held}, squares {carried}");
        assert_eq!(fit.std_method, StdMethod::Clusters);
    }
}

/// Residuals of a disturbed motion are correlated, and two clusters are too few for a sandwich
/// covariance of all parameters. Standard deviations are then increased, not reduced, and have the
/// size that many clusters give.
#[test]
fn few_clusters_widen_the_deviations() {
    let campaign = blind(&BlindOptions { seed: 223, disturbance: 0.1, ..BlindOptions::default() }).unwrap();
    let runs: Vec<Run> = train(&campaign.runs).into_iter().take(2).collect();
    let model = started(&campaign.model().unwrap(), &runs);
    let by = |cluster: f64| {
        output_error(&model, &runs, &OutputErrorOptions { cluster, join: false, loss: Loss::Huber, ..options() })
            .unwrap()
    };
    let (few, many) = (by(1e6), by(1.0));
    assert_eq!((few.std_method, many.std_method), (StdMethod::FewClusters, StdMethod::Clusters));
    let ratios = few.model.parameters.iter().zip(&many.model.parameters).map(|(a, b)| a.std.unwrap() / b.std.unwrap());
    let mut ratios: Vec<f64> = ratios.collect();
    ratios.sort_by(f64::total_cmp);
    // two clusters estimate the inflation of the variance from as many squares as there are parameters
    let median = ratios[ratios.len() / 2];
    assert!((0.5..4.0).contains(&median) && ratios[0] > 0.3, "{ratios:?}");
}

#[test]
fn joined_segments_know_more_and_disturbed_ones_stay_apart() {
    let by = |disturbance: f64, join: bool| {
        let campaign = blind(&BlindOptions { seed: 222, disturbance, ..BlindOptions::default() }).unwrap();
        let runs = train(&campaign.runs);
        output_error(&started(&campaign.model().unwrap(), &runs), &runs, &OutputErrorOptions { join, ..options() })
            .unwrap()
    };
    let (apart, joined) = (by(0.0, false), by(0.0, true));
    assert_eq!((apart.problem.segments.len(), joined.problem.segments.len()), (66, 6));
    for (a, b) in apart.model.parameters.iter().zip(&joined.model.parameters) {
        assert!(b.std.unwrap() < a.std.unwrap(), "{}", a.term);
    }
    // segments are not joined if a random force that the model lacks moves the state between them
    assert_eq!(by(0.05, true).problem.segments.len(), 66);
}

/// One short campaign, its fit, and the Cramér-Rao bound.
fn short_campaign() -> (Model, Vec<Run>, OutputErrorFit) {
    let campaign = blind(&BlindOptions { seed: 223, rate: 3.0, duration: 48.0, ..BlindOptions::default() }).unwrap();
    let runs = train(&campaign.runs);
    let start = started(&campaign.model().unwrap(), &runs);
    let fit = output_error(&start, &runs, &options()).unwrap();
    (start, runs, fit)
}

/// With white noise, information, bootstrap and Monte Carlo give the same standard deviations,
/// within three times the scatter of 12 clusters (20 %) and of 40 refits (11 %).
#[test]
fn law_bootstrap_and_monte_carlo_scatter_as_the_information_says() {
    let (_, _, fit) = short_campaign();
    let boot = fit.bootstrap(0..500, 1, 24.0).unwrap();
    let monte = fit.monte_carlo_under(&options(), 0..40, 1, |_| None);
    assert_eq!((boot.values.len(), monte.values.len(), monte.failed), (500, 40, 0));
    for (k, parameter) in fit.model.parameters.iter().enumerate() {
        let std = parameter.std.unwrap();
        assert!((boot.std(k) / std).ln().abs() < 0.8, "{}: {} {std}", parameter.term, boot.std(k));
        assert!((monte.std(k) / std).ln().abs() < 0.4, "{}: {} {std}", parameter.term, monte.std(k));
        assert!((boot.mean(k) - parameter.value).abs() < std && (monte.mean(k) - parameter.value).abs() < std);
    }
    let none = fit.bootstrap(0..10, 1, f64::INFINITY);
    assert!(none.is_ok(), "six runs are six clusters");
}

#[test]
fn held_bounded_and_known_parameters_are_respected() {
    let (start, runs, free) = short_campaign();
    let name = "quadratic_drag@surge";
    let index = start.parameter_of(name).unwrap();
    let (value, std) = (free.model.parameters[index].value, free.model.parameters[index].std.unwrap());
    let fit = |change: &dyn Fn(&mut hydrosysid::model::Parameter)| {
        let mut model = start.clone();
        change(&mut model.parameters[index]);
        output_error(&model, &runs, &options()).unwrap()
    };
    let held = fit(&|p| (p.value, p.fixed) = (value + 5.0 * std, true));
    assert_eq!(held.model.parameters[index].value, value + 5.0 * std);
    assert!(held.cost > free.cost && held.problem.unknowns.len() + 1 == free.problem.unknowns.len());
    let bounded = fit(&|p| (p.value, p.max) = (value - 3.0 * std, value - 2.0 * std));
    assert_eq!(bounded.model.parameters[index].value, value - 2.0 * std);
    // a prior as good as the data and three standard deviations away: the estimate moves half of
    // the way, and its standard deviation decreases by √2
    let known = fit(&|p| p.prior = Some((value + 3.0 * std, std)));
    let moved = (known.model.parameters[index].value - value) / std;
    // information scales with the size of the residuals, a prior does not, about 5 % here; and the
    // model is not quite linear
    assert!((moved - 1.5).abs() < 0.2, "{moved}");
    assert!((known.model.parameters[index].std.unwrap() / std - 0.5_f64.sqrt()).abs() < 0.1);
}

#[test]
fn no_estimate_is_promised_below_the_bound() {
    let quiet = BlindOptions { seed: 223, rate: 3.0, duration: 48.0, noise: 0.0, ..BlindOptions::default() };
    let campaign = blind(&quiet).unwrap();
    let noise = [("u", 0.005), ("v", 0.005), ("r", 0.003), ("x", 0.05), ("y", 0.05), ("psi", 0.5_f64.to_radians())];
    let sigma = Some(noise.into_iter().map(|(name, s)| (name.to_string(), s)).collect());
    let bound =
        cramer_rao(&campaign.truth, &train(&campaign.runs), &OutputErrorOptions { sigma, ..options() }).unwrap();
    let (_, _, fit) = short_campaign();
    let p = fit.problem.unknowns.len();
    for (k, parameter) in fit.model.parameters.iter().enumerate() {
        // the noise that the fit estimates has an error of some per cent
        assert!(parameter.std.unwrap() > 0.93 * bound[k * p + k].sqrt(), "{}", parameter.term);
    }
}

/// The noise of a channel is estimated better from the residuals of a fit with joined segments than
/// from third differences of the samples, which at 3 Hz and 1 mm/s of noise take a part of the
/// motion for noise.
#[test]
fn joined_fits_weigh_channels_by_what_they_leave() {
    let campaign = blind(&BlindOptions { seed: 220, rate: 3.0, noise: 0.2, ..BlindOptions::default() }).unwrap();
    let runs = train(&campaign.runs);
    let start = started(&campaign.model().unwrap(), &runs);
    let apart = output_error(&start, &runs, &options()).unwrap();
    let joined = output_error(&start, &runs, &OutputErrorOptions { join: true, ..options() }).unwrap();
    let sigma = |fit: &OutputErrorFit, channel: &str| {
        let k = fit.problem.dynamics.outputs.iter().position(|o| o == channel).unwrap();
        fit.problem.sigma[k]
    };
    assert!(joined.problem.segments.len() < apart.problem.segments.len());
    for (channel, noise) in [("u", 1e-3), ("v", 1e-3), ("r", 6e-4), ("x", 1e-2), ("y", 1e-2)] {
        let (before, after) = (sigma(&apart, channel) / noise, sigma(&joined, channel) / noise);
        // with some 1600 samples a standard deviation is known to 2 %
        assert!((after - 1.0).abs() < 0.08, "{channel}: {before} {after}");
        assert!((after - 1.0).abs() < (before - 1.0).abs() + 0.03, "{channel}: {before} {after}");
    }
    assert!(sigma(&apart, "u") > 1.08 * sigma(&joined, "u"), "{} {}", sigma(&apart, "u"), sigma(&joined, "u"));
}
