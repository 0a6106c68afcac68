//! Attitude kinematics against 25-digit references.

use hydrosysid::navigation::{euler_angles, euler_rates, quaternion_rate};
use nalgebra::{Quaternion, SVector, UnitQuaternion, Vector3};
use serde_json::Value;

use crate::shared;

fn number(value: &Value) -> f64 {
    value.as_str().and_then(|s| s.parse().ok()).expect("a decimal in quotes")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(number).collect()
}

fn problem(id: &str) -> Option<Value> {
    let text = std::fs::read_to_string(shared::path("ode_ref/ode_reference.json")?).expect("as its README says");
    let all: Value = serde_json::from_str(&text).expect("as its README says");
    all["problems"].as_array().expect("as its README says").iter().find(|p| p["id"] == id).cloned()
}

fn rates(problem: &Value) -> Vector3<f64> {
    let p = &problem["params"];
    Vector3::new(number(&p["p"]), number(&p["q"]), number(&p["r"]))
}

/// Classical RK4 from 0 through all reference times with n steps in all; the states at those times.
fn rk4<const N: usize>(
    f: impl Fn(&SVector<f64, N>) -> SVector<f64, N>,
    mut y: SVector<f64, N>,
    times: &[f64],
    n: usize,
) -> Vec<SVector<f64, N>> {
    let step = times[times.len() - 1] / n as f64;
    let mut before = 0.0;
    let mut states = vec![];
    for &t in times {
        let steps = ((t - before) / step).round();
        let h = (t - before) / steps;
        for _ in 0..steps as usize {
            let k1 = f(&y);
            let k2 = f(&(y + k1 * (h / 2.0)));
            let k3 = f(&(y + k2 * (h / 2.0)));
            let k4 = f(&(y + k3 * h));
            y += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0);
        }
        before = t;
        states.push(y);
    }
    states
}

#[test]
fn exact_euler_angles_at_constant_rates() {
    let Some(problem) = problem("euler_zyx_constant_rate") else { return };
    let (omega, times) = (rates(&problem), numbers(&problem["t_ref"]));
    let exact: Vec<Vec<f64>> = problem["y_ref"].as_array().unwrap().iter().map(numbers).collect();
    let states = rk4(|y: &Vector3<f64>| euler_rates(y.x, y.y, &omega), Vector3::zeros(), &times, 1280);
    for ((state, exact), &t) in states.iter().zip(&exact).zip(&times) {
        // the reference's own table: 7.5e-13 at 1280 steps
        assert!((state - Vector3::from_column_slice(exact)).amax() < 1e-12, "t = {t}");
        // and straight from the closed form of the quaternion: rounding only
        let attitude = UnitQuaternion::new(omega * t);
        assert!((Vector3::from(euler_angles(&attitude)) - Vector3::from_column_slice(exact)).amax() < 1e-14);
    }
}

#[test]
fn exact_quaternion_at_constant_rates() {
    let Some(problem) = problem("quaternion_constant_rate") else { return };
    let (omega, times) = (rates(&problem), numbers(&problem["t_ref"]));
    let f = |y: &SVector<f64, 4>| {
        let rate = quaternion_rate(&Quaternion::new(y[0], y[1], y[2], y[3]), &omega);
        SVector::from([rate.w, rate.i, rate.j, rate.k])
    };
    let states = rk4(f, SVector::from([1.0, 0.0, 0.0, 0.0]), &times, 1280);
    for (state, exact) in states.iter().zip(problem["y_ref"].as_array().unwrap()) {
        // the reference's own table: 2.2246e-11 at 1280 steps
        assert!((state - SVector::<f64, 4>::from_column_slice(&numbers(exact))).amax() < 2.3e-11);
    }
}
