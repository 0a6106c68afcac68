//! Euler angles against 25-digit references.

use hydrosysid::navigation::euler_angles;
use nalgebra::{UnitQuaternion, Vector3};
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

/// The closed form of the attitude at constant rates, converted to Euler angles; the tolerance is
/// for rounding only.
#[test]
fn exact_euler_angles_at_constant_rates() {
    let Some(problem) = problem("euler_zyx_constant_rate") else { return };
    let (omega, times) = (rates(&problem), numbers(&problem["t_ref"]));
    for (t, exact) in times.iter().zip(problem["y_ref"].as_array().unwrap()) {
        let attitude = UnitQuaternion::new(omega * *t);
        assert!((Vector3::from(euler_angles(&attitude)) - Vector3::from_column_slice(&numbers(exact))).amax() < 1e-14);
    }
}
