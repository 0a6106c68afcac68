//! A vehicle file from bench runs: another vehicle with the measured curve, lag and dead time.
//!
//! ```text
//! extends = "bluerov2"    [[thruster]] forward = { a, b } …
//! [[parameter]] thrust_lag: T ± its scatter over the speeds
//! ```
//!
//! A lag or a dead time below [`QUICKEST`] is negligible beside the sample time of any log; it is
//! written as a comment only.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::bench::{Bench, BenchThruster};
use super::error::Error;
use super::vehicles::KnownVehicle;
use crate::effects::id;
use crate::simulate::QUICKEST;
use crate::thrust::bench::Value;

/// A vehicle file as text, with the assumptions in it.
#[derive(Debug, Clone, PartialEq)]
pub struct BenchVehicle {
    /// The file.
    pub text: String,
    /// Assumptions to check, one sentence each; the file has them as comments.
    pub guesses: Vec<String>,
}

/// Returns the vehicle file at `path` that extends `vehicle` by the results of `bench`. A curve
/// goes to the thruster of the same name. If the bench has a single thruster and the vehicle none
/// of its name, the curve goes to all thrusters.
///
/// # Errors
/// [`Error::Vehicle`] if the vehicle has no thruster for a curve.
pub fn bench_vehicle(bench: &Bench, vehicle: &KnownVehicle, path: &Path) -> Result<BenchVehicle, Error> {
    let mut guesses = Vec::new();
    let mut tables = String::new();
    for measured in &bench.thrusters {
        let names: Vec<&str> = vehicle.file.thrusters.iter().map(|t| t.name.as_str()).collect();
        let chosen: Vec<&str> = match names.iter().find(|name| **name == measured.name) {
            Some(own) => vec![*own],
            None if bench.thrusters.len() == 1 && !names.is_empty() => {
                guesses.push(format!(
                    "all {} thrusters of {} are assumed to be of the make that was measured",
                    names.len(),
                    vehicle.id
                ));
                names
            }
            None => {
                let message = format!(
                    "it has no thruster `{}` ({}): name the [[thruster]] of the bench as the vehicle does",
                    measured.name,
                    names.join(", ")
                );
                return Err(Error::Vehicle { name: vehicle.id.clone(), message });
            }
        };
        for name in chosen {
            let _ = write!(tables, "\n[[thruster]]\nname = {}\n{}", toml::Value::from(name), measured.tables);
        }
    }
    let supplied = vehicle.file.thrusters.iter().find_map(|t| t.supply);
    if let Some(supply) = supplied {
        guesses.push(format!(
            "the bench is assumed to have run at the {} V for which {} has its curve: otherwise, write \
             supply.reference",
            supply.reference, vehicle.id
        ));
    }
    let runs: Vec<&str> = bench.thrusters.iter().flat_map(|t| &t.runs).map(String::as_str).collect();
    let mut text = String::from("# A vehicle with thrusters as measured on a bench. SI units.\n");
    for guess in &guesses {
        let _ = writeln!(text, "# guessed: {guess}");
    }
    let _ = writeln!(text, "extends = {}", toml::Value::from(base(vehicle, path)));
    let source = format!("thrust: bench runs {}", runs.join(", "));
    let _ = writeln!(text, "sources = [{}]", toml::Value::from(source));
    let dynamics: Vec<(&str, Value)> = bench.thrusters.first().map(dynamics).unwrap_or_default();
    if !dynamics.is_empty() {
        let model = vehicle.file.model.clone().unwrap_or_default();
        let mut effects: Vec<String> = model.effects.iter().map(ToString::to_string).collect();
        effects.extend(dynamics.iter().map(|(effect, _)| (*effect).to_string()));
        let _ = writeln!(text, "\n[model]\neffects = {}", toml::Value::from(effects));
        for table in &vehicle.file.parameters {
            let table = toml::Value::try_from(table).map(|t| t.to_string()).unwrap_or_default();
            let _ = write!(text, "\n[[parameter]]\n{table}");
        }
        for (effect, Value { value, std }) in dynamics {
            let _ = writeln!(text, "\n[[parameter]]\neffect = \"{effect}\"\nvalue = {value:.4}\nstd = {std:.4}");
        }
    }
    Ok(BenchVehicle { text: text + &tables, guesses })
}

/// Returns the name of the vehicle as the file at `path` refers to it: its id, or the path of a
/// user's file.
fn base(vehicle: &KnownVehicle, path: &Path) -> String {
    let Some(_) = &vehicle.folder else { return vehicle.id.clone() };
    let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let folder =
        |path: &Path| path.parent().filter(|p| !p.as_os_str().is_empty()).map_or(PathBuf::from("."), Path::to_path_buf);
    let own = PathBuf::from(&vehicle.id);
    let beside = whole(&folder(&own)) == whole(&folder(path));
    let named = if beside { own.file_name().map_or(own.clone(), PathBuf::from) } else { whole(&own) };
    named.display().to_string()
}

/// Returns the lag and the dead time that a log can show, each with the name of its effect. The lag
/// T̄ is the mean of the lags T_k at the speeds of the runs; its standard deviation covers all of
/// them: max √((T_k − T̄)² + σ_k²).
fn dynamics(measured: &BenchThruster) -> Vec<(&'static str, Value)> {
    let lags: Vec<Value> = measured.fit.lag_at.iter().map(|(_, lag)| *lag).collect();
    let count = lags.len().max(1) as f64;
    let mean = lags.iter().map(|lag| lag.value).sum::<f64>() / count;
    let apart = lags.iter().map(|lag| (lag.value - mean).hypot(lag.std)).fold(0.0, f64::max);
    let lag = Value { value: mean, std: apart };
    let shown = |(_, v): &(&str, Value)| v.value >= QUICKEST && v.std > 0.0 && v.std.is_finite();
    [(id::THRUST_LAG, lag), (id::THRUST_DELAY, measured.fit.delay)].into_iter().filter(shown).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::vehicles::vehicle;
    use crate::thrust::bench::BenchFit;

    fn bench(name: &str, lag: f64) -> Bench {
        let value = |value| Value { value, std: 0.002 };
        let fit = BenchFit {
            forward: Some([value(40.0), value(1.0)]),
            reverse: Some([value(30.0), value(2.0)]),
            deadband: value(0.07),
            delay: value(0.006),
            lag: None,
            lag_slope: None,
            lag_at: vec![(0.2, value(lag)), (1.0, value(0.5 * lag))],
            ringing: None,
            offsets: Vec::new(),
            rms: 0.1,
            explained: 0.99,
            converged: true,
        };
        let tables = crate::campaign::bench::tables(&fit);
        Bench {
            thrusters: vec![BenchThruster { name: name.into(), runs: vec!["sweep.csv".into()], fit, tables }],
            warnings: Vec::new(),
        }
    }

    /// The written file reads as the vehicle with another curve, a prior on the lag, and everything
    /// else unchanged.
    #[test]
    fn the_file_is_the_vehicle_with_the_measured_thruster() {
        let folder = std::env::temp_dir().join(format!("hydrosysid-bench-vehicle-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("ours.toml");
        let known = vehicle("bluerov2").unwrap();
        let made = bench_vehicle(&bench("V1", 0.16), &known, &path).unwrap();
        assert_eq!(made.guesses.len(), 2, "{:?}", made.guesses);
        std::fs::write(&path, &made.text).unwrap();
        let own = vehicle(path.to_str().unwrap()).unwrap_or_else(|e| panic!("{e}\n{}", made.text));
        assert_eq!(own.file.thrusters.len(), 6);
        for (mine, theirs) in own.file.thrusters.iter().zip(&known.file.thrusters) {
            assert_eq!((mine.forward.a, mine.reverse.b, mine.deadband), (40.0, 2.0, 0.07));
            assert_eq!((mine.position, mine.axis, mine.supply), (theirs.position, theirs.axis, theirs.supply));
        }
        // 0.16 s and 0.08 s: their mean, with a deviation that covers both; the dead time of 6 ms
        // is a comment
        let [prior] = &own.file.parameters[..] else { panic!("{}", made.text) };
        assert_eq!((prior.effect.to_string().as_str(), prior.value), ("thrust_lag", Some(0.12)));
        assert!(prior.std.is_some_and(|std| (0.04..0.042).contains(&std)) && made.text.contains("# dead time 0.0060"));

        // a user's file in the same folder is referred to by its file name; a thruster is matched
        // by name
        let one = bench_vehicle(&bench("2", 0.01), &own, &folder.join("again.toml")).unwrap();
        assert!(one.text.contains("extends = \"ours.toml\"") && one.text.matches("[[thruster]]").count() == 1);
        assert!(!one.text.contains("[model]") && one.guesses.len() == 1, "{}", one.text);
        let two =
            Bench { thrusters: [bench("2", 0.1).thrusters, bench("V9", 0.1).thrusters].concat(), ..Bench::default() };
        let refused = bench_vehicle(&two, &known, &path).unwrap_err().to_string();
        assert!(refused.contains("no thruster `V9` (1, 2, 3, 4, 5, 6)"), "{refused}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
