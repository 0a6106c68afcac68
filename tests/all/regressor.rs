//! Integral regressors compared with closed forms and with the references of the integrator.

#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use hydrosysid::effects::Coriolis;
use hydrosysid::estimate::{
    Columns, LeastSquaresOptions, Nodes, Refinement, RegressorOptions, Span, folded, least_squares_with, regressors_of,
};
use hydrosysid::frame::Dof;
use hydrosysid::model::{Interpolation, Model};
use hydrosysid::run::{Run, Signal};
use nalgebra::{DMatrix, DVector};

use crate::shared;

fn run(signals: &[(&str, &[f64], Vec<f64>)]) -> Run {
    let mut run = Run { name: "run".into(), ..Run::default() };
    for (name, time, values) in signals {
        run.signals.insert((*name).into(), Signal::new(Arc::from(*time), values.clone()));
    }
    run
}

fn surge(effects: &[&str]) -> Model {
    Model::with_effects(&[Dof::Surge], Coriolis::Tied, effects).unwrap()
}

fn solve(columns: &Columns) -> Vec<f64> {
    let h = DMatrix::from_fn(columns.rows(), columns.columns.len(), |i, j| columns.columns[j][i]);
    let y = DVector::from_column_slice(&columns.rhs);
    let qr = h.qr();
    let right = qr.q().transpose() * y;
    qr.r().solve_upper_triangular(&right).unwrap().iter().copied().collect()
}

/// The paper's form, equation (4): Δu = Σ αⱼ (…), with α of thrust 1/m; returns m and the forces'
/// coefficients.
fn solve_per_unit_inertia(columns: &Columns) -> Vec<f64> {
    let mut swapped = columns.clone();
    swapped.rhs = std::mem::replace(&mut swapped.columns[0], columns.rhs.clone());
    let alpha = solve(&swapped);
    std::iter::once(1.0 / alpha[0]).chain(alpha[1..].iter().map(|a| -a / alpha[0])).collect()
}

fn options(span: Span) -> RegressorOptions {
    RegressorOptions { span, ..RegressorOptions::default() }
}

/// Time, u and τ of 841.93 u̇ = 145.3 sin(2πt/28) + 185.7 − 82.3 u − 309.07 u|u| from rest, on `n`
/// steps of `dt`. With 64 Runge-Kutta steps in each, the error is below 1e-12.
fn paper_surge(n: usize, dt: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let tau = |t: f64| 145.3 * (std::f64::consts::TAU * t / 28.0).sin() + 185.7;
    let rate = |t: f64, u: f64| (tau(t) - 82.3 * u - 309.07 * u * u.abs()) / 841.93;
    let time: Vec<f64> = (0..=n).map(|k| k as f64 * dt).collect();
    let (mut u, mut x, h) = (vec![0.0], 0.0, dt / 64.0);
    for t in &time[..n] {
        for i in 0..64 {
            let t = t + f64::from(i) * h;
            let k1 = rate(t, x);
            let k2 = rate(t + h / 2.0, x + h / 2.0 * k1);
            let k3 = rate(t + h / 2.0, x + h / 2.0 * k2);
            let k4 = rate(t + h, x + h * k3);
            x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        }
        u.push(x);
    }
    let tau = time.iter().map(|t| tau(*t)).collect();
    (time, u, tau)
}

/// Without noise, the bias of estimates by the trapezoid is that of the reference, which has five
/// digits: 1e-4 relative covers its rounding.
#[test]
fn regress_bias_of_the_trapezoid_without_noise() {
    let Some(path) = shared::path("ode_ref/input_reference.json") else { return };
    let json: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let table = &json["identification_bias_noise_free"]["table"];
    let model = surge(&["inertia", "linear_drag", "quadratic_drag"]);
    for (form, span) in [("integral_step", Span::Samples(1)), ("integral_cum", Span::FromStart)] {
        for k in 0..5 {
            let dt = table[form]["dt"][k].as_f64().unwrap();
            let (time, u, tau) = paper_surge((56.0 / dt).round() as usize, dt);
            let run = run(&[("u", &time, u), ("tau_u", &time, tau)]);
            let columns = regressors_of(Dof::Surge, &[&run], &model, options(span)).unwrap();
            let theta = solve_per_unit_inertia(&columns);
            for (j, truth) in [841.93, 82.3, 309.07].into_iter().enumerate() {
                let expected = table[form]["rel_error_m_a_b"][k][j].as_f64().unwrap();
                let error = theta[j] / truth - 1.0;
                println!("{form} dt {dt} parameter {j}: {error:e}, reference {expected:e}");
                assert!((error - expected).abs() < 1e-4 * expected.abs() + 1e-9, "{form} {dt} {j}: {error} {expected}");
            }
        }
    }
}

/// ∫u and ∫u|u| of u = U tanh(t/T) by the trapezoid have the error that the reference gives with six digits.
#[test]
fn exact_trapezoid_error_of_a_closed_form() {
    let Some(path) = shared::path("ode_ref/input_reference.json") else { return };
    let json: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let trapezoid = &json["trapezoid"];
    let number = |key: &str| trapezoid["reference"][key].as_str().unwrap().parse::<f64>().unwrap();
    let (scale, period) = (number("U"), number("T"));
    let model = surge(&["linear_drag", "quadratic_drag"]);
    for row in trapezoid["table"].as_array().unwrap() {
        let n = row["n"].as_u64().unwrap() as usize;
        let time: Vec<f64> = (0..=n).map(|k| 10.0 * k as f64 / n as f64).collect();
        let u: Vec<f64> = time.iter().map(|t| scale * (t / period).tanh()).collect();
        let run = run(&[("u", &time, u), ("tau_u", &time, vec![1.0; n + 1])]);
        let columns = regressors_of(Dof::Surge, &[&run], &model, options(Span::FromStart)).unwrap();
        for (j, (integral, error)) in [("I_u", "err_int_u"), ("I_uabsu", "err_int_uabsu")].into_iter().enumerate() {
            let found = (columns.columns[j].last().unwrap() - number(integral)).abs();
            let printed = row[error].as_f64().unwrap();
            assert!((found - printed).abs() < 1e-5 * printed + 1e-12, "n {n} {integral}: {found} {printed}");
        }
    }
}

/// For piecewise linear signals on uneven time stamps, the trapezoid of linear terms is exact, for
/// any division into rows.
#[test]
fn exact_rows_add_up_on_uneven_time_of_two_sensors() {
    let model = surge(&["inertia", "linear_drag", "bias"]);
    let own = [0.0, 0.4, 0.9, 1.1, 2.0, 2.2];
    let command = [-0.3, 0.25, 0.9, 1.6, 1.7, 2.5];
    let u = [0.0, 0.3, 0.2, 0.5, 0.4, 0.1];
    let tau = [10.0, 20.0, 5.0, -5.0, 40.0, 0.0];
    let run = run(&[("u", &own, u.to_vec()), ("tau_u", &command, tau.to_vec())]);
    let total = |span, nodes| {
        let columns = regressors_of(Dof::Surge, &[&run], &model, RegressorOptions { span, nodes }).unwrap();
        let sums: Vec<f64> = columns.columns.iter().map(|c| c.iter().sum()).collect();
        (columns.rows(), sums, columns.rhs.iter().sum::<f64>())
    };
    // by hand: Δu, ∫u dt, Δt, and ∫τ over the nodes of both channels
    let corners = [0.0, 0.25, 0.4, 0.9, 1.1, 1.6, 1.7, 2.0, 2.2];
    let at = |t: f64| {
        let k = command.iter().rposition(|c| *c <= t).unwrap();
        tau[k] + (tau[k + 1] - tau[k]) * (t - command[k]) / (command[k + 1] - command[k])
    };
    let thrust: f64 = corners.windows(2).map(|c| 0.5 * (at(c[0]) + at(c[1])) * (c[1] - c[0])).sum();
    let way: f64 = (1..6).map(|k| 0.5 * (u[k] + u[k - 1]) * (own[k] - own[k - 1])).sum();
    for (span, rows) in [(Span::Samples(1), 5), (Span::Samples(2), 3), (Span::Samples(9), 1)] {
        let (n, sums, rhs) = total(span, Nodes::Every);
        assert_eq!(n, rows);
        for (found, hand) in sums.iter().chain([&rhs]).zip([0.1, way, 2.2, thrust]) {
            assert!((found - hand).abs() < 1e-12, "rounding only: {found} {hand}");
        }
        let (_, sums, coarse) = total(span, Nodes::Own);
        assert!((sums[1] - way).abs() < 1e-12 && (coarse - thrust).abs() > 0.1, "the command's own corners are lost");
    }
}

/// A held command changes at its own sample, so ∫τ is exact with a step inside a row.
#[test]
fn exact_held_commands() {
    let mut model = surge(&["inertia"]);
    model.input = Interpolation::Hold;
    let run = run(&[("u", &[0.0, 1.0, 2.0], vec![0.0; 3]), ("tau_u", &[0.0, 0.5, 1.0], vec![1.0, 3.0, 7.0])]);
    let columns = regressors_of(Dof::Surge, &[&run], &model, RegressorOptions::default()).unwrap();
    assert_eq!(columns.rhs, [2.0, 7.0]);
}

/// A parameter with a value for each run has a column for each run, which is zero in the rows of
/// the other runs.
#[test]
fn columns_of_several_runs() {
    let mut model = surge(&["inertia", "wave@surge"]);
    let period = model.parameter("wave@surge", "T_waveu").unwrap();
    model.parameters[period].fixed = true;
    let time = [0.0, 1.0, 2.0, 3.0];
    let one = run(&[("u", &time, vec![0.0, 0.1, 0.3, 0.2]), ("tau_u", &time, vec![1.0; 4])]);
    let two = Run { name: "second".into(), ..one.clone() };
    let columns = regressors_of(Dof::Surge, &[&one, &two], &model, RegressorOptions::default()).unwrap();
    let names: Vec<&str> = columns.parameters.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["m_u", "a_waveu [run]", "b_waveu [run]", "a_waveu [second]", "b_waveu [second]"]);
    assert_eq!(columns.blocks.len(), 2);
    assert!(columns.columns[1][3..].iter().all(|x| *x == 0.0) && columns.columns[3][..3].iter().all(|x| *x == 0.0));
    assert!(columns.columns.iter().all(|c| c.len() == columns.rows()));
}

#[test]
fn a_balance_without_a_known_force_is_refused() {
    let model = surge(&["inertia", "linear_drag", "thrust_interaction_loss"]);
    let (time, u, tau) = paper_surge(20, 0.5);
    let run = run(&[("u", &time, u), ("tau_u", &time, tau)]);
    let error = regressors_of(Dof::Surge, &[&run], &model, RegressorOptions::default()).unwrap_err();
    assert!(error.to_string().contains("no known force"), "{error}");
}

/// A run of `n` samples at 10 Hz with varying u, and the command at `rate` Hz.
fn lively(n: usize, rate: f64) -> Run {
    let time: Vec<f64> = (0..n).map(|k| 0.1 * k as f64).collect();
    let stamps: Vec<f64> = (0..(n as f64 * rate / 10.0) as usize).map(|k| k as f64 / rate).collect();
    let u = time.iter().map(|t| 0.5 + 0.3 * (0.21 * t).sin() + 0.05 * (1.7 * t).cos()).collect();
    let tau = stamps.iter().map(|t| 180.0 + 140.0 * (0.22 * t).sin() + 20.0 * (1.9 * t).sin()).collect();
    run(&[("u", &time, u), ("tau_u", &stamps, tau)])
}

/// Least squares on folded rows gives the result of the same rows kept in memory; the sums differ
/// in their order only, so the tolerance is 1e-10.
#[test]
fn folded_rows_are_the_rows_that_are_kept() {
    let model = surge(&["inertia", "linear_drag", "quadratic_drag", "bias"]);
    let always = LeastSquaresOptions { refinement: Refinement::Always, ..LeastSquaresOptions::default() };
    for (rate, span) in [(10.0, 1), (7.0, 1), (10.0, 3)] {
        let (run, options) = (lively(40_000, rate), options(Span::Samples(span)));
        let columns = regressors_of(Dof::Surge, &[&run], &model, options).unwrap();
        let kept = least_squares_with(&columns.slices(), &columns.rhs, &always).unwrap();
        let rows = folded(Dof::Surge, &run, &model, options).unwrap();
        let fit = rows.tall.fit().unwrap();
        assert_eq!((fit.rows, rows.parameters), (columns.rows(), columns.parameters));
        assert!(!fit.refined);
        for k in 0..4 {
            let close = |a: f64, b: f64, to: f64| assert!((a / b - 1.0).abs() < to, "{rate} {span} {k}: {a} {b}");
            close(fit.coefficients[k], kept.coefficients[k], 1e-10);
            close(fit.standard_errors[k], kept.standard_errors[k], 1e-10);
        }
    }
}

#[test]
fn law_folded_rows_do_not_depend_on_threads() {
    let model = surge(&["inertia", "linear_drag", "quadratic_drag", "bias"]);
    let (run, options) = (lively(60_000, 10.0), RegressorOptions::default());
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| folded(Dof::Surge, &run, &model, options).unwrap().tall.fit().unwrap())
    };
    assert_eq!(with(1), with(2));
}
