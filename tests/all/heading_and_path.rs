//! A heading that contradicts the path over x and y is found by the rotation of the velocity; a
//! current is no contradiction.

use hydrosysid::check::{self, CheckOptions, Light, Topic};
use hydrosysid::run::{Run, Signal};

/// Log of a vehicle that moves about for two minutes in a current (m/s), with the logged heading
/// `wrong(t, ψ)`.
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

/// Codes of the findings, and whether the light of consistency is red.
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

/// An antenna 1 m ahead of the DVL and 0.4 m to port swings about it. The finding gives this lever
/// arm, within 1 cm ahead, and no axis, scale or clock is reported as wrong.
#[test]
fn an_antenna_with_a_lever_arm_is_told_as_that() {
    let mut run = swum([0.1, 0.05], |_, psi| psi);
    let psi: Vec<f64> = run.signals["psi"].values().to_vec();
    for (name, quarter) in [("x", 0.0), ("y", 0.5 * std::f64::consts::PI)] {
        let signal = run.signals.get_mut(name).expect("it is logged");
        let arm = |psi: f64| (psi - quarter).cos() + 0.4 * (psi - quarter).sin();
        let moved = signal.values().iter().zip(&psi).map(|(x, psi)| x + arm(*psi)).collect::<Vec<_>>();
        *signal = Signal::new(signal.shared_time().clone(), moved);
    }
    let report = check::run(&run, &CheckOptions::default());
    let codes: Vec<&str> = report.findings.iter().map(|f| f.code).collect();
    let arm = report.findings.iter().find(|f| f.code == "K119").unwrap_or_else(|| panic!("{codes:?}"));
    // the tolerance is for the velocity, which is linear between its samples
    let ahead = arm.message.split(' ').nth(4).and_then(|metres| metres.parse::<f64>().ok());
    assert!(ahead.is_some_and(|metres| (metres - 1.0).abs() < 0.01), "{}", arm.message);
    assert!(arm.message.contains("-0.4 ± "), "{}", arm.message);
    for false_word in ["K111", "K112", "K113", "K114", "K115", "K116"] {
        assert!(!codes.contains(&false_word), "{:?}", report.findings);
    }
    // a lever arm that the model has is not reported
    let known = CheckOptions { arm_is_known: true, ..CheckOptions::default() };
    assert!(check::run(&run, &known).findings.iter().all(|f| f.code != "K119"));
}

/// A reversed axis of the position is reported as a sign, and exchanged x and y, or u and v, as an exchange.
#[test]
fn an_axis_that_is_turned_round_is_no_swap() {
    let told = |run: &Run| {
        let report = check::run(run, &CheckOptions::default());
        report.findings.iter().map(|f| f.message.clone()).collect::<Vec<_>>().concat()
    };
    for axis in ["x", "y"] {
        let mut run = swum([0.0, 0.0], |_, psi| psi);
        let signal = run.signals.get_mut(axis).expect("it is logged");
        *signal = Signal::new(signal.shared_time().clone(), signal.values().iter().map(|x| -x).collect::<Vec<_>>());
        let said = told(&run);
        assert!(said.contains(&format!("set columns.{axis}.sign = -1")) && !said.contains("swapped"), "{axis}: {said}");
    }
    for (one, other, word) in [("x", "y", "only when they are swapped"), ("u", "v", "only when they are exchanged")] {
        let mut run = swum([0.0, 0.0], |_, psi| psi);
        let (a, b) = (run.signals[one].clone(), run.signals[other].clone());
        run.signals.insert(one.into(), b);
        run.signals.insert(other.into(), a);
        let said = told(&run);
        assert!(said.contains(word) && !said.contains("sign = -1"), "{one} {other}: {said}");
    }
}
