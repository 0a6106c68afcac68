//! Thruster curves from bollard tables: from the file to the standard deviations of the fit.

#![allow(clippy::unwrap_used)] // tests, and the small functions they share

use std::fmt::Write;
use std::path::{Path, PathBuf};

use hydrosysid::campaign::{Campaign, Estimator, Fit, FitOptions, LoadOptions, fit};

/// Forward and reverse a and b, N per command² and per command: the paper's equation (1) for a
/// normalised command.
const TRUTH: [[f64; 2]; 2] = [[30.0, 12.0], [20.0, 10.0]];
/// Mass, linear and quadratic drag in surge.
const BODY: [f64; 3] = [100.0, 20.0, 80.0];

fn force(command: f64) -> f64 {
    let [a, b] = TRUTH[usize::from(command < 0.0)];
    command.signum() * (a * command * command + b * command.abs())
}

/// Normal numbers by the Box-Muller method on a linear congruential generator, the same on every machine.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// Command of both thrusters over time.
fn command(t: f64) -> f64 {
    0.2 + 0.7 * (std::f64::consts::TAU * t / 15.0).sin()
}

/// A bollard table of twelve commands in each direction, with `std` N of noise.
fn table(std: f64, noise: &mut Noise) -> String {
    let mut text = String::from("V1,force\n");
    for k in (-12..=12).filter(|k| *k != 0) {
        let command = f64::from(k) / 12.0;
        writeln!(text, "{command},{}", force(command) + std * noise.normal()).unwrap();
    }
    text
}

/// Log of a motion ahead and astern with both thrusters: 60 s at 5 Hz, 1 mm/s of noise.
fn motion(noise: &mut Noise) -> String {
    let [m, linear, quadratic] = BODY;
    let slope = |t: f64, u: f64| (2.0 * force(command(t)) - linear * u - quadratic * u * u.abs()) / m;
    let (mut text, mut u, h) = (String::from("t,u,V1,V2\n"), 0.0, 0.01);
    for k in 0..=6000 {
        let t = h * f64::from(k);
        if k % 20 == 0 {
            writeln!(text, "{t:.2},{},{},{}", u + 1e-3 * noise.normal(), command(t), command(t)).unwrap();
        }
        let k1 = slope(t, u);
        let k2 = slope(t + h / 2.0, u + h / 2.0 * k1);
        let k3 = slope(t + h / 2.0, u + h / 2.0 * k2);
        let k4 = slope(t + h, u + h * k3);
        u += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    text
}

/// Log of a bollard pull of both thrusters on a load cell that reads 0.9 of their sum.
fn pull() -> String {
    let mut text = String::from("t,V1,V2,load_u\n");
    for k in 0..=600 {
        let t = 0.1 * f64::from(k);
        let command = command(t);
        writeln!(text, "{t:.1},{command},{command},{}", 0.9 * 2.0 * force(command)).unwrap();
    }
    text
}

const VEHICLE: &str = r#"
format = 1
[model]
dofs = ["surge"]
effects = ["inertia", "linear_drag", "quadratic_drag"]
[[thruster]]
name = "port"
position = [0, -0.3, 0]
axis = [1, 0, 0]
bollard = "t1.csv"
[[thruster]]
name = "starboard"
position = [0, 0.3, 0]
axis = [1, 0, 0]
bollard = "t1.csv"
[[run]]
file = "motion.csv"
kind = "oscillatory"
"#;

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("hydrosysid-bollard-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn write(folder: &Path, files: &[(&str, &str)]) {
    for (name, text) in files {
        std::fs::write(folder.join(name), text).unwrap();
    }
}

fn fitted(folder: &Path, estimator: Estimator) -> Fit {
    let campaign = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).unwrap();
    fit(&campaign, FitOptions { estimator: Some(estimator) }).unwrap()
}

fn mass(fit: &Fit) -> (f64, f64) {
    let found = fit.parameters.iter().find(|p| p.effect == "inertia").unwrap();
    (found.value, found.std.unwrap())
}

/// Mean, scatter, and mean reported standard deviation of the mass, over campaigns that differ in
/// the noise of their bollard tables only.
fn scatter(name: &str, estimator: Estimator, campaign: &str, more: &[(&str, &str)], std: f64) -> (f64, f64, f64) {
    let folder = folder(name);
    let motion = motion(&mut Noise(7));
    write(&folder, &[("campaign.toml", campaign), ("motion.csv", &motion)]);
    write(&folder, more);
    const DRAWS: usize = 30;
    let found: Vec<(f64, f64)> = (0..DRAWS)
        .map(|k| {
            write(&folder, &[("t1.csv", &table(std, &mut Noise(1000 + k as u64)))]);
            mass(&fitted(&folder, estimator))
        })
        .collect();
    std::fs::remove_dir_all(folder).unwrap();
    let mean = |of: fn(&(f64, f64)) -> f64| found.iter().map(of).sum::<f64>() / DRAWS as f64;
    let (value, reported) = (mean(|f| f.0), mean(|f| f.1));
    let spread = (found.iter().map(|f| (f.0 - value).powi(2)).sum::<f64>() / (DRAWS - 1) as f64).sqrt();
    (value, spread, reported)
}

#[test]
fn a_table_becomes_the_curve_of_its_thrusters() {
    let folder = folder("curve");
    write(&folder, &[("campaign.toml", VEHICLE), ("motion.csv", &motion(&mut Noise(7)))]);
    write(&folder, &[("t1.csv", &table(0.1, &mut Noise(3)))]);
    let fit = fitted(&folder, Estimator::OutputError);
    assert_eq!(fit.thrusters.len(), 1, "one table, one curve");
    let curve = &fit.thrusters[0];
    assert_eq!(
        (curve.thrusters.as_slice(), curve.file.as_str()),
        (["port".to_string(), "starboard".into()].as_slice(), "t1.csv")
    );
    for (side, [a, b]) in [curve.forward, curve.reverse].into_iter().zip(TRUTH) {
        assert_eq!(side.rows, 12);
        for (found, truth) in [(side.a, a), (side.b, b)] {
            assert!((found.value - truth).abs() < 4.0 * found.std && found.std < 0.05 * truth, "{found:?} {truth}");
        }
    }
    let (mass, std) = mass(&fit);
    assert!((mass - BODY[0]).abs() < 4.0 * std && std < 2.0, "{mass} ± {std}");
    assert!(fit.std_method.contains("thrusters' curves"), "{}", fit.std_method);
    let json = serde_json::to_value(&fit).unwrap();
    assert!(json["thrusters"][0]["forward"]["a"]["std"].as_f64().unwrap() > 0.0);
    std::fs::remove_dir_all(folder).unwrap();
}

/// Allowed ratio of reported to observed standard deviation. That of 30 draws has a standard error
/// of 13 %; the range is three of these, with a margin for the curvature of the thrust curve.
const AGREE: std::ops::Range<f64> = 0.6..1.5;

#[test]
fn law_deviations_of_the_curve_are_in_those_of_the_fit() {
    for estimator in [Estimator::Integral, Estimator::OutputError] {
        let (value, spread, reported) = scatter(estimator.name(), estimator, VEHICLE, &[], 0.4);
        assert!((value / BODY[0] - 1.0).abs() < 0.02, "{value}");
        assert!(AGREE.contains(&(reported / spread)), "{}: reported {reported}, scatter {spread}", estimator.name());
        // the noise of the motion alone would give a far smaller scatter
        assert!(spread > 0.1, "{spread}");
    }
}

#[test]
fn law_a_load_cell_takes_the_error_of_the_curve_away() {
    let held = r#"
[[parameter]]
effect = "linear_drag@surge"
value = 18.0
fixed = true
[[parameter]]
effect = "quadratic_drag@surge"
value = 72.0
fixed = true
"#;
    let with = format!("{VEHICLE}[[run]]\nfile = \"pull.csv\"\nkind = \"bollard\"\n{held}");
    // the motion is that of thrusters without interaction, so that mass and drag are 0.9 of the
    // true ones in both
    let without = format!("{VEHICLE}[efficiency]\neta_inter = {{ surge = 0.9 }}\n{held}");
    let cell = [("pull.csv", pull())];
    let cell: Vec<(&str, &str)> = cell.iter().map(|(name, text)| (*name, text.as_str())).collect();
    // standard deviation from the noise of the rows, the same in every draw
    let (_, _, own) = scatter("own", Estimator::Staged, &with, &cell, 1e-6);
    let (value, spread, reported) = scatter("cell", Estimator::Staged, &with, &cell, 0.4);
    let (_, alone, told) = scatter("alone", Estimator::Staged, &without, &[], 0.4);
    assert!((value / (0.9 * BODY[0]) - 1.0).abs() < 0.05, "{value}");
    let carried = |reported: f64| (reported.powi(2) - own.powi(2)).max(0.0).sqrt();
    assert!(spread < 0.8 * alone, "with a load cell {spread}, without {alone}");
    assert!(AGREE.contains(&(carried(told) / alone)), "{told} {own} {alone}");
    // if η_inter were taken as independent of the curve, the errors of both would add up
    assert!(AGREE.contains(&(carried(reported) / spread)), "{reported} {own} {spread}");
}

/// The table reaches twice the maximum command of the thruster; beyond the maximum it shows the
/// force at the maximum.
#[test]
fn a_thruster_with_a_limit_has_its_curve_below_it_and_saturates_there() {
    const MAX: f64 = 0.5;
    let folder = folder("limit");
    let limited = |command: f64| force(command.clamp(-MAX, MAX));
    let mut rows = String::from("V1,force\n");
    for k in (-12..=12).filter(|k| *k != 0) {
        let command = f64::from(k) / 12.0;
        writeln!(rows, "{command},{}", limited(command)).unwrap();
    }
    let text = VEHICLE.replace("bollard = \"t1.csv\"", "bollard = \"t1.csv\"\nmax = 0.5");
    write(&folder, &[("campaign.toml", &text), ("motion.csv", &motion(&mut Noise(7))), ("t1.csv", &rows)]);
    let campaign = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).unwrap();
    let fitted = campaign.curves[0].fit;
    for (side, [a, b]) in [fitted.forward, fitted.reverse].into_iter().zip(TRUTH) {
        assert!((side.a.value - a).abs() < 1e-9 && (side.b.value - b).abs() < 1e-9, "{side:?}");
    }
    // the fitted curve, the thruster that exports use, and the force of a run agree
    let thruster = campaign.file.thrusters[0].curve();
    let run = &campaign.runs[0];
    let total = run.signal("tau_u").unwrap();
    for (t, total) in total.time().iter().zip(total.values()) {
        let command = command(*t);
        for curve in [fitted.curve, thruster] {
            assert!((curve.force(command) - limited(command)).abs() < 1e-9, "{command}");
        }
        assert!((total - 2.0 * limited(command)).abs() < 1e-9, "{command}: {total}");
    }
    assert_eq!((fitted.curve.max, fitted.curve.range()), (MAX, thruster.range()));
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_table_without_a_curve_is_told() {
    let folder = folder("wrong");
    write(&folder, &[("campaign.toml", VEHICLE), ("motion.csv", &motion(&mut Noise(7)))]);
    let refused = |text: &str| {
        write(&folder, &[("t1.csv", text)]);
        Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).unwrap_err().to_string()
    };
    assert!(refused("V1,pull\n0.5,3\n").contains("no column `force`"));
    assert!(refused("speed,force\n0.5,3\n").contains("no column `V1`"));
    let few = refused("V1,force\n0.5,3\n-0.5,-3\n");
    assert!(few.contains("t1.csv") && few.contains("port") && few.contains("at least 3"), "{few}");
    std::fs::remove_file(folder.join("t1.csv")).unwrap();
    let absent = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).unwrap_err();
    assert!(absent.is_wrong_use() && absent.to_string().contains("thruster[0].bollard"), "{absent}");
    std::fs::remove_dir_all(folder).unwrap();
}
