//! The Runge-Kutta scheme on 42 reference problems: its errors and order agree with a reference of
//! many digits.

use std::convert::Infallible;
use std::f64::consts::{PI, TAU};

use crate::ode_reference::{Problem, problems};
use hydrosysid::simulate::rk4;

/// The rate of each problem. The middle of the step tells on which side of a jump a stage lies.
fn rate(problem: &Problem, middle: f64, t: f64, y: &[f64], out: &mut [f64]) {
    let p = |name: &str| problem.p(name);
    let square = |x: f64| x * x.abs();
    match problem.id.as_str() {
        "surge_quadratic_from_rest" | "surge_quadratic_coastdown" | "surge_quadratic_reversal" => {
            let force = if problem.id.ends_with("coastdown") { 0.0 } else { p("F") };
            out[0] = (force - p("k") * square(y[0])) / p("m");
            if let [_, x] = out {
                *x = y[0];
            }
        }
        "surge_linquad_from_rest" | "surge_linquad_coastdown" | "surge_linquad_reversal" => {
            let force = if problem.id.ends_with("coastdown") { 0.0 } else { p("F") };
            out[0] = (force - p("a") * y[0] - p("b") * square(y[0])) / p("m");
        }
        "yaw_linear_sinusoid" => {
            out[0] = (p("A") * (TAU * t / p("P")).sin() + p("B") - p("kr") * y[0]) / p("I");
        }
        "surge_laurs_sinusoid" => {
            let force = p("A") * (TAU * t / p("P")).sin() + p("B");
            out[0] = (force - p("a") * y[0] - p("b") * square(y[0])) / p("m");
        }
        "munk_libration" | "munk_rotation" => {
            let (mu, mv) = (p("mu"), p("mv"));
            (out[0], out[1]) = (mv * y[1] * y[2] / mu, -mu * y[0] * y[2] / mv);
            out[2] = (mu - mv) * y[0] * y[1] / p("I");
        }
        "planar3_sinusoid_smooth" | "planar3_sinusoid_reversing" | "planar3_zigzag" => {
            let (mu, mv) = (p("mu"), p("mv"));
            let tau = match problem.id.trim_start_matches("planar3_") {
                "zigzag" if (middle / 6.0).floor() as i64 % 2 == 0 => [140.0, 0.0, 67.8],
                "zigzag" => [140.0, 0.0, -67.8],
                "sinusoid_reversing" => {
                    [100.0 + 60.0 * (0.5 * t).sin(), 40.0 * (0.3 * t + 1.0).sin(), 50.0 * (0.8 * t).sin()]
                }
                _ => [
                    400.0 + 145.3 * (TAU * t / 28.0).sin(),
                    -30.0 + 10.0 * (TAU * t / 20.0).cos(),
                    15.0 + 5.0 * (TAU * t / 16.0).sin(),
                ],
            };
            out[0] = (mv * y[1] * y[2] - p("ku") * y[0] - p("kuu") * square(y[0]) + tau[0]) / mu;
            out[1] = (-mu * y[0] * y[2] - p("kv") * y[1] - p("kvv") * square(y[1]) + tau[1]) / mv;
            out[2] = ((mu - mv) * y[0] * y[1] - p("kr") * y[2] - p("krr") * square(y[2]) + tau[2]) / p("Ir");
        }
        "quaternion_constant_rate" => turn(y, [p("p"), p("q"), p("r")], out),
        "euler_zyx_constant_rate" => {
            let (sin, cos) = y[0].sin_cos();
            let about_down = p("q") * sin + p("r") * cos;
            out[0] = p("p") + about_down * y[1].tan();
            out[1] = p("q") * cos - p("r") * sin;
            out[2] = about_down / y[1].cos();
        }
        "rigid_body_euler_detest_b5" => out.copy_from_slice(&[y[1] * y[2], -y[0] * y[2], -0.51 * y[0] * y[1]]),
        "rigid_body_euler_general" => {
            let [a, b, c] = [p("I1"), p("I2"), p("I3")];
            out.copy_from_slice(&[(b - c) * y[1] * y[2] / a, (c - a) * y[2] * y[0] / b, (a - b) * y[0] * y[1] / c]);
        }
        "roll_restoring_undamped" => out.copy_from_slice(&[y[1], -p("w2") * y[0].sin()]),
        "roll_restoring_quadratic_damping" => {
            out.copy_from_slice(&[y[1], -p("w2") * y[0].sin() - p("d1") * y[1] - p("d2") * square(y[1])]);
        }
        "six_dof_drag_restoring" => six_dof(problem, y, out),
        id => detest(id, middle, t, y, out),
    }
}

/// q̇ = ½ q ⊗ (0, ω).
fn turn(q: &[f64], w: [f64; 3], out: &mut [f64]) {
    out[0] = 0.5 * (-q[1] * w[0] - q[2] * w[1] - q[3] * w[2]);
    out[1] = 0.5 * (q[0] * w[0] + q[2] * w[2] - q[3] * w[1]);
    out[2] = 0.5 * (q[0] * w[1] + q[3] * w[0] - q[1] * w[2]);
    out[3] = 0.5 * (q[0] * w[2] + q[1] * w[1] - q[2] * w[0]);
}

fn six_dof(problem: &Problem, y: &[f64], out: &mut [f64]) {
    let list = |name: &str| &problem.parameters[name];
    let (m, d1, d2, tau) = (list("m"), list("d1"), list("d2"), list("tau"));
    let (net, righting) = (problem.p("WB"), problem.p("zgW"));
    let pi: Vec<f64> = m.iter().zip(y).map(|(m, v)| m * v).collect();
    let cross = |a: &[f64], b: &[f64], i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    };
    let q = &y[6..];
    let down =
        [2.0 * (q[1] * q[3] - q[0] * q[2]), 2.0 * (q[2] * q[3] + q[0] * q[1]), 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2])];
    let gravity = [net * down[0], net * down[1], net * down[2], righting * -down[1], righting * down[0], 0.0];
    for i in 0..6 {
        let coriolis = if i < 3 {
            cross(&pi[..3], &y[3..6], i)
        } else {
            cross(&pi[..3], &y[..3], i - 3) + cross(&pi[3..], &y[3..6], i - 3)
        };
        out[i] = (coriolis - d1[i] * y[i] - d2[i] * y[i] * y[i].abs() + gravity[i] + tau[i]) / m[i];
    }
    turn(q, [y[3], y[4], y[5]], &mut out[6..]);
}

/// DETEST, Hull et al., *SIAM Journal on Numerical Analysis* 9 (1972) 603-637.
fn detest(id: &str, middle: f64, t: f64, y: &[f64], out: &mut [f64]) {
    let odd = middle.floor() as i64 % 2 == 1;
    match id {
        "detest_a1" => out[0] = -y[0],
        "detest_a2" => out[0] = -y[0].powi(3) / 2.0,
        "detest_a3" => out[0] = y[0] * t.cos(),
        "detest_a4" => out[0] = y[0] / 4.0 * (1.0 - y[0] / 20.0),
        "detest_a5" => out[0] = (y[0] - t) / (y[0] + t),
        "detest_b1" => out.copy_from_slice(&[2.0 * (y[0] - y[0] * y[1]), -(y[1] - y[0] * y[1])]),
        "detest_b2" => out.copy_from_slice(&[-y[0] + y[1], y[0] - 2.0 * y[1] + y[2], y[1] - y[2]]),
        "detest_b3" => out.copy_from_slice(&[-y[0], y[0] - y[1] * y[1], y[1] * y[1]]),
        "detest_b4" => {
            let d = y[0].hypot(y[1]);
            out.copy_from_slice(&[-y[1] - y[0] * y[2] / d, y[0] - y[1] * y[2] / d, y[0] / d]);
        }
        "detest_c1" => {
            out[0] = -y[0];
            for i in 1..9 {
                out[i] = y[i - 1] - y[i];
            }
            out[9] = y[8];
        }
        "detest_d1" | "detest_d2" | "detest_d3" | "detest_d4" | "detest_d5" => {
            let cube = y[0].hypot(y[1]).powi(3);
            out.copy_from_slice(&[y[2], y[3], -y[0] / cube, -y[1] / cube]);
        }
        "detest_e1" => {
            let s = t + 1.0;
            out.copy_from_slice(&[y[1], -(y[1] / s + (1.0 - 0.25 / (s * s)) * y[0])]);
        }
        "detest_e2" => out.copy_from_slice(&[y[1], (1.0 - y[0] * y[0]) * y[1] - y[0]]),
        "detest_e3" => out.copy_from_slice(&[y[1], y[0].powi(3) / 6.0 - y[0] + 2.0 * (2.78535 * t).sin()]),
        "detest_e4" => out.copy_from_slice(&[y[1], 0.032 - 0.4 * y[1] * y[1]]),
        "detest_e5" => out.copy_from_slice(&[y[1], (1.0 + y[1] * y[1]).sqrt() / (25.0 - t)]),
        "detest_f1" => {
            let force = if odd { -1.0 } else { 1.0 };
            out.copy_from_slice(&[y[1], 0.2 * y[1] - (PI * PI + 0.01) * y[0] + force]);
        }
        "detest_f2" => out[0] = 55.0 - if odd { 0.5 } else { 1.5 } * y[0],
        other => panic!("the problem {other} has no rate here"),
    }
}

/// The solution at the instants `time`, by one step from each to the next.
fn solve(problem: &Problem, time: &[f64]) -> Vec<f64> {
    let mut rows = problem.y0.clone();
    for pair in time.windows(2) {
        let middle = 0.5 * (pair[0] + pair[1]);
        let f = |t: f64, y: &[f64], out: &mut [f64]| -> Result<(), Infallible> {
            rate(problem, middle, t, y, out);
            Ok(())
        };
        let y = &rows[rows.len() - problem.y0.len()..];
        let step = rk4(f, pair, y, 1).expect("the solution is finite");
        rows.extend_from_slice(&step[problem.y0.len()..]);
    }
    rows
}

#[test]
fn exact_orders_and_errors_on_every_reference_problem() {
    let problems = problems();
    if problems.is_empty() {
        return;
    }
    assert_eq!(problems.len(), 42);
    for problem in &problems {
        problem.hold_against_the_table(&mut |time| solve(problem, time));
    }
}
