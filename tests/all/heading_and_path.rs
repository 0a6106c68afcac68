//! A heading that contradicts the way over x and y, told by the turn of the velocity; what a current does is no contradiction.

use hydrosysid::check::{self, CheckOptions, Light, Topic};
use hydrosysid::run::{Run, Signal};

/// A vehicle that wanders for two minutes in a current (m/s), its heading in error by `wrong`.
fn swum(current: [f64; 2], wrong: impl Fn(f64, f64) -> f64) -> Run {
    let (mut time, mut columns) = (Vec::new(), vec![Vec::new(); 5]);
    let (mut x, mut y) = (0.0, 0.0);
    for k in 0..12_000 {
        let t = 0.01 * f64::from(k);
        let psi = 3.0 * (0.11 * t).sin() + 0.12 * t;
        let (u, v) = (0.5 + 0.3 * (0.21 * t).sin(), 0.25 * (0.17 * t).cos());
        // over ground, in body axes
        let (s, c) = psi.sin_cos();
        let (north, east) = (u * c - v * s + current[0], u * s + v * c + current[1]);
        if k % 10 == 0 {
            time.push(t);
            let noise = 1e-4 * f64::from(k % 7);
            let row = [x + noise, y - noise, wrong(t, psi), north * c + east * s, east * c - north * s];
            columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        }
        x += 0.01 * north;
        y += 0.01 * east;
    }
    let time: std::sync::Arc<[f64]> = time.into();
    let signals = ["x", "y", "psi", "u", "v"].into_iter().zip(columns);
    Run {
        signals: signals.map(|(name, values)| (name.to_string(), Signal::new(time.clone(), values))).collect(),
        ..Run::default()
    }
}

/// Codes of findings, and the light of consistency.
fn judged(run: &Run) -> (Vec<&'static str>, bool) {
    let report = check::run(run, &CheckOptions::default());
    let light = report.lights.iter().find(|l| l.topic == Topic::Consistency).and_then(|l| l.light);
    (report.findings.iter().map(|f| f.code).collect(), light == Some(Light::Red))
}

#[test]
fn a_heading_in_another_unit_turns_too_little_or_too_far() {
    for current in [[0.0, 0.0], [0.12, -0.08]] {
        for factor in [1.0_f64.to_radians(), 1.0_f64.to_degrees()] {
            let (codes, is_red) = judged(&swum(current, |_, psi| factor * psi));
            assert!(is_red && codes.contains(&"K111"), "{current:?} {factor}: {codes:?}");
        }
    }
}

#[test]
fn a_heading_that_has_nothing_of_the_way_contradicts_it() {
    let (codes, is_red) = judged(&swum([0.0, 0.0], |t, _| 2.0 * (0.31 * t).cos() - 0.2 * t));
    assert!(is_red && codes.contains(&"K114"), "{codes:?}");
}

#[test]
fn a_right_heading_contradicts_nothing_in_any_current() {
    for current in [[0.0, 0.0], [0.12, -0.08], [0.6, 0.5]] {
        let (codes, is_red) = judged(&swum(current, |_, psi| psi));
        assert!(!is_red, "{current:?}: {codes:?}");
    }
}
