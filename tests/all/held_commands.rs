//! Commands that are held between samples, and their delay: comparison with the exact solution and
//! with differences.

// a failing fixture fails the test
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::sync::Arc;

use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{Campaign, FitOptions, fit};
use hydrosysid::chain::Available;
use hydrosysid::dynamics::Dynamics;
use hydrosysid::effects::Coriolis;
use hydrosysid::estimate::output_error::{OutputErrorOptions, output_error};
use hydrosysid::estimate::{IntegralOptions, integral_least_squares};
use hydrosysid::frame::Dof;
use hydrosysid::model::{Interpolation, Model};
use hydrosysid::noise::Noise;
use hydrosysid::run::{Run, Signal};
use hydrosysid::simulate::{Emission, Stretch, Track, free_run, integrate_fast};

const MASS: f64 = 300.0;
const DRAG: f64 = 90.0;

/// Steps of the command: an instant, s, and the force from then on, N. All intervals differ.
const STEPS: [(f64, f64); 9] = [
    (0.0, 0.0),
    (2.03, 80.0),
    (5.4, -40.0),
    (7.77, 120.0),
    (13.1, 0.0),
    (16.0, -90.0),
    (21.25, 60.0),
    (26.6, 110.0),
    (31.9, -20.0),
];

/// u of m u̇ + d u = τ(t − late) at `t`, from rest: one exponential for each step.
fn exact(t: f64, late: f64) -> f64 {
    let mut u = 0.0;
    for (k, (begin, force)) in STEPS.iter().enumerate() {
        let begin = begin + late;
        let end = STEPS.get(k + 1).map_or(f64::INFINITY, |(end, _)| end + late).min(t);
        if end > begin {
            let decay = (-DRAG / MASS * (end - begin)).exp();
            u = u * decay + force / DRAG * (1.0 - decay);
        }
    }
    u
}

fn held(t: f64) -> f64 {
    STEPS.iter().rev().find(|(begin, _)| *begin <= t).map_or(0.0, |(_, force)| *force)
}

fn stamps(from: f64, step: f64, count: usize) -> Arc<[f64]> {
    (0..count).map(|k| from + step * k as f64).collect()
}

/// A log of the speed at 10 Hz and of the command at the instants of its steps; its time begins at `epoch`.
fn run(late: f64, noise: f64, epoch: f64) -> Run {
    let mut run = Run::default();
    let time = stamps(0.0, 0.1, 400);
    let mut random = Noise::new(5, 0);
    let u: Vec<f64> = time.iter().map(|t| exact(*t, late) + noise * random.normal()).collect();
    let shifted = |time: &[f64]| time.iter().map(|t| t + epoch).collect::<Arc<[f64]>>();
    run.signals.insert("u".into(), Signal::new(shifted(&time), u));
    let (begins, forces): (Vec<f64>, Vec<f64>) = STEPS.iter().copied().unzip();
    run.signals.insert("tau_u".into(), Signal::new(shifted(&begins), forces));
    run
}

fn model(effects: &[&str]) -> Model {
    let all = [&["inertia", "linear_drag"], effects].concat();
    let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &all).unwrap();
    model.input = Interpolation::Hold;
    model.set("inertia@surge", MASS);
    model.set("linear_drag@surge", DRAG);
    model
}

fn compile(model: &Model, run: &Run, directions: &[usize]) -> Dynamics {
    let available = Available { channels: run.signals.keys().cloned().collect(), ..Available::default() };
    Dynamics::compile(model, &available, &["u".to_string()].into(), directions)
}

fn simulate(model: &Model, run: &Run, longest: f64) -> Vec<f64> {
    let (dynamics, theta) = (compile(model, run, &[]), model.values());
    let track = Track::new(run, 0, &dynamics, &theta, model.input, longest).unwrap();
    free_run(&dynamics, &track, &theta, &[0.0], 0, track.time.len() - 1).outputs
}

/// Steps of the command lie between the samples of the speed, with and without a delay. For any
/// longest step the only error is that of the integration scheme, about 1e-9 at λh = 0.03.
#[test]
fn a_step_of_the_integrator_ends_where_the_command_steps() {
    for late in [0.0, 0.3, 0.137] {
        let mut late_model = model(&["thrust_delay"]);
        late_model.set("thrust_delay", late);
        for longest in [0.1, 0.02] {
            let found = simulate(&late_model, &run(late, 0.0, 0.0), longest);
            for (k, u) in found.iter().enumerate() {
                let exact = exact(0.1 * k as f64, late);
                assert!((u - exact).abs() < 5e-9, "{late}, {longest}: {u} for {exact} at sample {k}");
            }
        }
    }
}

/// The same steps, written as a linear command with edges of 1 µs as in campaigns of held and
/// linear runs, give the same motion.
#[test]
fn an_edge_written_as_a_line_is_one() {
    let mut run = run(0.3, 0.0, 0.0);
    let (mut time, mut values) = (vec![0.0], vec![0.0]);
    for (begin, force) in &STEPS[1..] {
        time.extend([begin - 1e-6, *begin]);
        values.extend([held(begin - 1e-3), *force]);
    }
    run.signals.insert("tau_u".into(), Signal::new(time.into(), values));
    let mut line = model(&["thrust_delay"]);
    line.input = Interpolation::Linear;
    line.set("thrust_delay", 0.3);
    for (k, u) in simulate(&line, &run, 0.1).iter().enumerate() {
        // the command is half a microsecond early, at up to 0.5 m/s²
        assert!((u - exact(0.1 * k as f64, 0.3)).abs() < 1e-6);
    }
}

/// ∂u/∂T of held commands agrees with central differences of simulations, also with a lag.
#[test]
fn law_sensitivity_to_the_delay_of_held_commands() {
    let run = run(0.0, 0.0, 0.0);
    let end = |model: &Model, dynamics: &Dynamics, late: f64| -> Vec<f64> {
        let mut model = model.clone();
        model.set("thrust_delay", late);
        let theta = model.values();
        let track = Track::new(&run, 0, dynamics, &theta, model.input, 0.02).unwrap();
        free_run(dynamics, &track, &theta, &[0.0], 0, track.time.len() - 1).outputs
    };
    for (effects, late) in
        [(&["thrust_delay"][..], 0.3), (&["thrust_delay"], 0.137), (&["thrust_delay", "thrust_lag"], 0.234)]
    {
        let mut model = model(effects);
        model.set("thrust_delay", late);
        model.set("thrust_lag", 0.4);
        let delay = model.parameter_of("thrust_delay").unwrap();
        let dynamics = compile(&model, &run, &[delay]);
        let theta = model.values();
        let track = [Track::new(&run, 0, &dynamics, &theta, model.input, 0.02).unwrap()];
        let last = track[0].time.len() - 1;
        let stretch = [Some(Stretch { track: 0, first: 0, last }); 1];
        let lanes: Vec<[f64; 1]> = theta.iter().map(|v| [*v]).collect();
        let start = vec![[0.0]; dynamics.states.len()];
        let states = dynamics.states.len();
        let mut found = Vec::new();
        integrate_fast(&dynamics, &track, &stretch, &lanes, &start, true, &mut |at: &Emission<'_, 1>| {
            if at.grid[0].is_some() {
                found.push(at.jacobian[states][0]);
            }
        });
        let h = 1e-4;
        let [up, down] = [late + h, late - h].map(|late| end(&model, &dynamics, late));
        let largest = found.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        assert!(largest > 0.1, "a delay shows: {largest}");
        let inside_an_edge = |t: f64| STEPS.iter().any(|(begin, _)| (begin + late - t).abs() < 1.1e-3);
        for (k, found) in found.iter().enumerate().filter(|(k, _)| !inside_an_edge(0.1 * *k as f64)) {
            let numeric = (up[k] - down[k]) / (2.0 * h);
            // the scheme and the difference both have errors of about 1e-6 of the jump in acceleration
            assert!((found - numeric).abs() < 2e-6, "{effects:?} {late}, sample {k}: {found} against {numeric}");
        }
    }
}

fn options() -> OutputErrorOptions {
    OutputErrorOptions { sigma: Some([("u".to_string(), 0.005)].into()), ..OutputErrorOptions::default() }
}

/// A pure delay of 0.30 s is estimated within three standard deviations at 5 mm/s of noise, from
/// starts of 0.1 s, 0 s and 0.8 s.
#[test]
fn a_delay_of_held_commands_is_found() {
    for start in [0.1, 0.0, 0.8] {
        let mut model = model(&["thrust_delay"]);
        model.set("thrust_delay", start);
        model.set("inertia@surge", 400.0);
        model.set("linear_drag@surge", 70.0);
        let fit = output_error(&model, &[run(0.3, 0.005, 0.0)], &options()).unwrap();
        let p = fit.model.parameter_of("thrust_delay").unwrap();
        let found = &fit.model.parameters[p];
        let std = found.std.unwrap();
        assert!(fit.converged && std > 1e-4 && std < 0.01, "{std}");
        assert!((found.value - 0.3).abs() < 3.0 * std, "{} ± {std} from {start}", found.value);
    }
}

/// If the commands are in a log of their own with a clock offset, the offset is estimated as a
/// delay, and the mass is right.
#[test]
fn a_clock_offset_of_the_commands_is_a_delay() {
    let mut run = run(0.0, 0.0, 0.0);
    let signal = &run.signals["tau_u"];
    let early: Vec<f64> = signal.time().iter().map(|t| t - 0.22).collect();
    let signal = Signal::new(early.into(), signal.values().to_vec());
    run.signals.insert("tau_u".into(), signal);
    let fit = output_error(&model(&["thrust_delay"]), &[run], &options()).unwrap();
    assert!((fit.model.value("thrust_delay").unwrap() - 0.22).abs() < 1e-5);
    assert!((fit.model.value("inertia@surge").unwrap() - MASS).abs() < 1e-2);
}

/// Time stamps in seconds since 1970, which have a resolution of 0.24 µs, change every estimate by
/// less than a twentieth of its standard deviation, which is where the iteration stops. This holds
/// for held and linear commands at their own instants.
#[test]
fn a_wall_clock_changes_nothing() {
    for input in [Interpolation::Hold, Interpolation::Linear] {
        let fit = |epoch: f64| {
            let mut model = model(&["thrust_delay"]);
            model.input = input;
            model.set("inertia@surge", 400.0);
            model.set("linear_drag@surge", 70.0);
            output_error(&model, &[run(0.3, 0.005, epoch)], &options()).unwrap().model
        };
        let here = fit(0.0);
        for epoch in [1e5, 1e8, 1.7e9] {
            for (near, far) in here.parameters.iter().zip(fit(epoch).parameters) {
                let std = near.std.unwrap();
                assert!((near.value - far.value).abs() < 5e-2 * std, "{epoch}: {} {}", near.value, far.value);
                assert!((far.std.unwrap() / std - 1.0).abs() < 5e-2, "{epoch}: {std} {:?}", far.std);
            }
        }
    }
}

/// The same for integral least squares and for a force that depends on the time of the run.
#[test]
fn a_wall_clock_changes_no_regression() {
    let fit = |epoch: f64| {
        let mut model = model(&["wave@surge"]);
        let period = model.parameter("wave@surge", "T_waveu").unwrap();
        model.parameters[period].value = 3.1;
        model.parameters[period].fixed = true;
        integral_least_squares(&[&run(0.0, 0.005, epoch)], &model, IntegralOptions::default()).unwrap().1.remove(0)
    };
    let (here, far) = (fit(0.0), fit(1.7e9));
    assert_eq!((here.rows, here.values.len()), (far.rows, far.values.len()));
    for k in 0..here.values.len() {
        assert!((here.values[k] - far.values[k]).abs() < 1e-2 * here.std(k), "{:?} {:?}", here.values, far.values);
    }
}

/// u of m u̇ + d u = z, T ż = τ − z from rest, by the closed form over each step of the command.
fn exact_lagged(t: f64, lag: f64) -> f64 {
    let (rate, fast) = (DRAG / MASS, 1.0 / lag);
    let (mut u, mut z) = (0.0, 0.0);
    for (k, (begin, force)) in STEPS.iter().enumerate() {
        let end = STEPS.get(k + 1).map_or(f64::INFINITY, |(end, _)| *end).min(t);
        if end > *begin {
            let (slow, quick) = ((-rate * (end - begin)).exp(), (-fast * (end - begin)).exp());
            let share = (z - force) / MASS / (rate - fast);
            u = force / DRAG + (u - force / DRAG - share) * slow + share * quick;
            z = force + (z - force) * quick;
        }
    }
    u
}

fn lagged_run(lag: f64, noise: f64) -> Run {
    let mut run = run(0.0, 0.0, 0.0);
    let mut random = Noise::new(8, 0);
    let signal = &run.signals["u"];
    let u: Vec<f64> = signal.time().iter().map(|t| exact_lagged(*t, lag) + noise * random.normal()).collect();
    run.signals.insert("u".into(), Signal::new(signal.shared_time().clone(), u));
    run
}

/// A lag is estimated from a start far above it, since the steps follow the time constant; 0.05 s
/// is half a sample.
#[test]
fn a_quick_lag_is_found_whatever_the_step() {
    for lag in [0.05, 0.2] {
        let mut values = Vec::new();
        for longest_step in [0.1, 0.03] {
            let mut model = model(&["thrust_lag"]);
            model.set("thrust_lag", 0.6);
            let options = OutputErrorOptions { longest_step: Some(longest_step), ..options() };
            let fit = output_error(&model, &[lagged_run(lag, 1e-4)], &options).unwrap();
            values.push(fit.model.value("thrust_lag").unwrap());
        }
        // 1e-4 m/s of noise causes an error of about 1e-3 s; the error of the scheme is (h/T)⁴/120,
        // and h is only shortened when it is a quarter longer than T/2: 1.3e-3 of T
        assert!(values.iter().all(|t| (t - lag).abs() < 2e-3), "{values:?} for {lag}");
        assert!((values[0] - values[1]).abs() < 2e-3 * lag, "{values:?} hang on the step");
    }
}

/// A lag of 1e-5 s counts as none: the estimate goes to its bound, whatever the step.
#[test]
fn a_lag_of_no_time_goes_to_its_bound() {
    for longest_step in [0.1, 0.03] {
        let mut model = model(&["thrust_lag"]);
        model.set("thrust_lag", 0.3);
        let p = model.parameter_of("thrust_lag").unwrap();
        let options = OutputErrorOptions { longest_step: Some(longest_step), ..options() };
        let fit = output_error(&model, &[lagged_run(1e-5, 1e-4)], &options).unwrap();
        let found = &fit.model.parameters[p];
        assert!(found.value <= found.min, "{} at steps of {longest_step} s", found.value);
    }
}

/// If a log begins 0.23 s after a step whose effect is still delayed, the samples before the
/// command is known take no part in the fit.
#[test]
fn a_fit_leaves_out_what_commands_of_before_the_log_do() {
    let whole = run(0.5, 0.002, 0.0);
    let mut part = Run { name: "late.csv".into(), ..whole.between(8.0, 39.9) };
    let since = |t: f64| STEPS.iter().map(|(begin, _)| *begin).filter(move |begin| *begin > t);
    let instants: Vec<f64> = std::iter::once(8.0).chain(since(8.0)).collect();
    let forces: Vec<f64> = instants.iter().map(|t| held(*t)).collect();
    part.signals.insert("tau_u".into(), Signal::new(instants.into(), forces));
    let text = "format = 1\n[vehicle]\nmass = 250.0\n[model]\ndofs = ['surge']\ninput = 'hold'\n\
                effects = ['inertia', 'linear_drag', 'thrust_delay']\n[[run]]\nfile = 'late.csv'\n";
    let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let file = CampaignFile::from_bytes(text.as_bytes(), Path::new("late.toml"), &options).unwrap();
    let found = fit(&Campaign::from_runs(file, vec![part]).unwrap(), FitOptions::default()).unwrap();
    for (parameter, truth) in found.parameters.iter().zip([MASS, DRAG, 0.5]) {
        let std = parameter.std.unwrap();
        // three standard deviations; half a second of a wrong force would shift the mass by about fifty
        assert!((parameter.value - truth).abs() < 3.0 * std, "{}: {} ± {std}", parameter.name, parameter.value);
    }
}
