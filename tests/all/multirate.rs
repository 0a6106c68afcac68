//! Sensors at their own rates, in one file or in several: no channel is resampled, and no gap is bridged.

#![allow(clippy::unwrap_used)] // tests, and the small functions they share

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use crate::swim::{CAMPAIGN, Swim, TRUTH};
use hydrosysid::campaign::{self, Campaign, Check, Estimator, Fit, FitOptions, LoadOptions, check_campaign};
use hydrosysid::estimate::{RegressorOptions, regressors_of};
use hydrosysid::frame::Dof;
use hydrosysid::log;
use hydrosysid::run::{Run, Signal};
use hydrosysid::tank::{BlindOptions, blind};

/// Options for sensors with their own rates in one file, and for position and speed that are
/// measured independently.
const LOG: &str = r#"[log]
missing = "no_sample"
position_source = "independent"
velocity_reference = "ground"
"#;

/// An empty folder for one test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("multirate_{name}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Rows of a log at 100 Hz that a sensor samples: every `step`-th from `first`, but none from
/// `silent.0` to `silent.1` s.
#[derive(Clone, Copy)]
struct Sensor {
    columns: &'static [usize],
    step: usize,
    first: usize,
    silent: (f64, f64),
}

const NEVER: (f64, f64) = (1.0, 0.0);
const ALL: [Sensor; 1] = [Sensor { columns: &[1, 2, 3, 4, 5, 6], step: 5, first: 0, silent: NEVER }];
const DVL: Sensor = Sensor { columns: &[1, 2], step: 20, first: 3, silent: NEVER };
const GYRO: Sensor = Sensor { columns: &[3], step: 5, first: 1, silent: NEVER };
/// At 25 Hz, straight lines between the samples of the fastest command differ from its sine by one
/// in ten thousand.
const COMMAND: Sensor = Sensor { columns: &[4, 5, 6], step: 4, first: 0, silent: NEVER };

/// The log of these sensors on one clock that is `ahead` s fast; cells are empty where a sensor has
/// no sample.
fn file(rows: &[[f64; 7]], sensors: &[Sensor], ahead: f64) -> String {
    let names = log::PLANAR;
    let columns: Vec<usize> = sensors.iter().flat_map(|s| s.columns).copied().collect();
    let mut text = "t".to_string();
    columns.iter().for_each(|c| write!(text, ",{}", names[*c]).unwrap());
    for (k, row) in rows.iter().enumerate() {
        let speaks = |s: &Sensor| {
            let silent = row[0] > s.silent.0 && row[0] < s.silent.1;
            k % s.step == s.first && !silent
        };
        if !sensors.iter().any(speaks) {
            continue;
        }
        write!(text, "\n{:.2}", row[0] + ahead).unwrap();
        for sensor in sensors {
            for column in sensor.columns {
                if speaks(sensor) { write!(text, ",{:.6}", row[*column]).unwrap() } else { text.push(',') }
            }
        }
    }
    text + "\n"
}

fn load(folder: &Path, run: &str) -> Campaign {
    let path = folder.join("campaign.toml");
    fs::write(&path, format!("{CAMPAIGN}{LOG}[[run]]\nfile = {run}\n")).unwrap();
    Campaign::load(&path, LoadOptions::default()).unwrap()
}

fn fit(campaign: &Campaign, estimator: Estimator) -> Fit {
    campaign::fit(campaign, FitOptions { estimator: Some(estimator) }).unwrap()
}

/// Estimates in the order of `TRUTH`, with standard deviations.
fn estimates(fit: &Fit) -> Vec<(f64, f64)> {
    let one = |dof: Dof, effect: &str| {
        let p = fit.parameters.iter().find(|p| p.dof == Some(dof) && p.effect == effect).unwrap();
        (p.value, p.std.unwrap())
    };
    [Dof::Surge, Dof::Sway, Dof::Yaw]
        .into_iter()
        .flat_map(|dof| ["inertia", "linear_drag", "quadratic_drag"].map(|effect| one(dof, effect)))
        .collect()
}

#[test]
fn own_rates_give_the_parameters_of_one_rate() {
    let folder = folder("rates");
    let rows = Swim::new(100.0, 60.0, 1.0, 5).rows;
    fs::write(folder.join("one.csv"), file(&rows, &ALL, 0.0)).unwrap();
    fs::write(folder.join("many.csv"), file(&rows, &[DVL, GYRO, COMMAND], 0.0)).unwrap();
    let (one, many) = (load(&folder, "'one.csv'"), load(&folder, "'many.csv'"));
    let samples = |name: &str| many.runs[0].signals[name].len();
    assert_eq!([samples("u"), samples("r"), samples("tau_u")], [300, 1200, 1501]);
    let [a, b] = [&one, &many].map(|c| estimates(&fit(c, Estimator::OutputError)));
    for (k, (a, b)) in a.iter().zip(&b).enumerate() {
        // three standard deviations of the difference for nine parameters: by chance this fails
        // once in forty cases
        let within = 3.0 * a.1.hypot(b.1);
        assert!((a.0 - b.0).abs() < within, "parameter {k}: {a:?} at one rate, {b:?} at own rates");
        assert!((b.0 - TRUTH[k]).abs() < 4.0 * b.1, "parameter {k}: {b:?}, truth {}", TRUTH[k]);
    }
}

/// The rows of integral least squares begin and end at the samples of their own sensor. The log has
/// no noise, which would bias the estimates; only the error of the trapezoid remains.
#[test]
fn integral_rows_stand_on_the_stamps_of_their_own_sensor() {
    let folder = folder("integral");
    let rows = Swim::quiet(100.0, 60.0).rows;
    fs::write(folder.join("many.csv"), file(&rows, &[DVL, GYRO, COMMAND], 0.0)).unwrap();
    let many = load(&folder, "'many.csv'");
    for (dof, rows) in [(Dof::Surge, 299), (Dof::Yaw, 1199)] {
        let columns = regressors_of(dof, &[&many.runs[0]], &many.model, RegressorOptions::default()).unwrap();
        assert_eq!(columns.rows(), rows, "{dof}");
    }
    for (k, (value, _)) in estimates(&fit(&many, Estimator::Integral)).into_iter().enumerate() {
        // steps of 0.2 s with motion up to 1.3 rad/s: (ωh)²/12 = 0.6 % of the balance, and more of
        // the drag, which is a small part of the balance
        assert!((value / TRUTH[k] - 1.0).abs() < 0.02, "parameter {k}: {value}, truth {}", TRUTH[k]);
    }
}

#[test]
fn several_files_with_their_clocks_are_one_run() {
    let folder = folder("files");
    let rows = Swim::new(100.0, 30.0, 1.0, 6).rows;
    fs::write(folder.join("together.csv"), file(&rows, &[DVL, GYRO, COMMAND], 0.0)).unwrap();
    fs::write(folder.join("dvl.csv"), file(&rows, &[DVL], 0.37)).unwrap();
    fs::write(folder.join("rest.csv"), file(&rows, &[GYRO, COMMAND], 0.0)).unwrap();
    let together = load(&folder, "'together.csv'");
    let apart = load(&folder, "['rest.csv', { file = 'dvl.csv', clock_offset = -0.37 }]");
    for (name, signal) in &together.runs[0].signals {
        let other = &apart.runs[0].signals[name];
        assert_eq!(signal.values(), other.values(), "{name}");
        // adding the offset rounds a time stamp: one unit in the last place of 30 s
        let close = |(a, b): (&f64, &f64)| (a - b).abs() < 4e-15 * 30.0;
        assert!(signal.time().iter().zip(other.time()).all(close), "{name}");
    }
    for estimator in [Estimator::OutputError, Estimator::Integral] {
        let (a, b) = (estimates(&fit(&together, estimator)), estimates(&fit(&apart, estimator)));
        // the rounding of the time stamps, times the condition of the fit
        assert!(a.iter().zip(&b).all(|(a, b)| (a.0 - b.0).abs() < 1e-8 * a.0.abs()), "{a:?} {b:?}");
    }
}

/// Logs with a wall clock and a log with a local clock are joined by the offset of the local clock,
/// in any order of the files. Without the offset a finding reports the two clocks.
#[test]
fn a_wall_clock_and_a_local_clock_are_joined_by_an_offset() {
    let folder = folder("walls");
    let rows = Swim::new(100.0, 20.0, 1.0, 9).rows;
    let wall = 1_719_830_400.0;
    fs::write(folder.join("together.csv"), file(&rows, &[DVL, GYRO, COMMAND], 0.0)).unwrap();
    fs::write(folder.join("dvl.csv"), file(&rows, &[DVL], wall)).unwrap();
    fs::write(folder.join("gyro.csv"), file(&rows, &[GYRO], wall)).unwrap();
    // its clock begins 1.5 s after that of the others
    fs::write(folder.join("command.csv"), file(&rows, &[COMMAND], -1.5)).unwrap();
    let together = &load(&folder, "'together.csv'").runs[0];
    let local = format!("{{ file = 'command.csv', clock_offset = {:?} }}", wall + 1.5);
    for (files, first) in [
        (format!("['dvl.csv', {local}, 'gyro.csv']"), "u"),
        (format!("['gyro.csv', 'dvl.csv', {local}]"), "r"),
        (format!("[{local}, 'gyro.csv', 'dvl.csv']"), "tau_u"),
    ] {
        let apart = load(&folder, &files);
        assert!(apart.findings.iter().all(|f| f.code != "M222"), "{files}: {:?}", apart.findings);
        let run = &apart.runs[0];
        // the run begins with its first log: zero is the first stamp of a log with a wall clock, or
        // the zero of a local clock
        let zero = if first == "tau_u" { 1.5 } else { together.signals[first].time()[0] };
        for (name, signal) in &together.signals {
            let stamps = signal.time().iter().zip(run.signals[name].time());
            // stamps of a wall clock in seconds, as floating-point numbers, have a resolution of 0.24 us
            assert!(stamps.clone().count() == signal.len(), "{name}");
            stamps.for_each(|(a, b)| assert!((a - zero - b).abs() < 1e-6, "{files}, {name}: {} and {b}", a - zero));
        }
    }
    let told = load(&folder, "['dvl.csv', 'command.csv', 'gyro.csv']");
    assert!(told.findings.iter().any(|f| f.code == "M222"), "{:?}", told.findings);
}

#[test]
fn a_silent_sensor_is_not_bridged() {
    let folder = folder("silent");
    let rows = Swim::new(100.0, 60.0, 1.0, 7).rows;
    let dvl = Sensor { silent: (20.0, 31.0), ..DVL };
    fs::write(folder.join("log.csv"), file(&rows, &[dvl, GYRO, COMMAND], 0.0)).unwrap();
    let loaded = load(&folder, "'log.csv'");
    let gap = loaded.findings.iter().find(|f| f.code == "L105").unwrap();
    assert!(gap.message.contains("u, v has no sample for 11.2 s"), "{gap}");
    assert!(loaded.runs[0].gaps.is_empty(), "the gyro goes on: {:?}", loaded.runs[0].gaps);
    for dof in [Dof::Surge, Dof::Sway] {
        let columns = regressors_of(dof, &[&loaded.runs[0]], &loaded.model, RegressorOptions::default()).unwrap();
        assert!(columns.span.iter().all(|(a, b)| b - a < 0.21), "{dof}");
    }
    for (k, (value, std)) in estimates(&fit(&loaded, Estimator::OutputError)).into_iter().enumerate() {
        // nine estimates within four standard deviations: by chance this fails once in two thousand cases
        assert!((value - TRUTH[k]).abs() < 4.0 * std, "parameter {k}: {value} ± {std}, truth {}", TRUTH[k]);
    }
}

/// Short pauses of the log and one sensor that is silent for 2 s do not divide the run for the
/// filter: it remains one segment, with the estimates of the undisturbed run.
#[test]
fn pauses_and_one_silent_sensor_cut_no_run_of_the_filter() {
    let folder = folder("pauses");
    // a short pause in every half second of the log: rows 47 and 48 of 50 are missing
    let mut rows = Swim::new(100.0, 60.0, 1.0, 9).rows;
    rows.retain(|row| !matches!((100.0 * row[0]).round() as i64 % 50, 47 | 48));
    let slower = Sensor { step: 4, ..GYRO };
    let command = Sensor { step: 3, ..COMMAND };
    for (name, silent) in [("whole.csv", NEVER), ("silent.csv", (21.0, 23.0))] {
        let dvl = Sensor { silent, ..DVL };
        fs::write(folder.join(name), file(&rows, &[dvl, slower, command], 0.0)).unwrap();
    }
    let [whole, silent] = ["'whole.csv'", "'silent.csv'"].map(|name| load(&folder, name));
    assert!(silent.findings.iter().any(|f| f.code == "L105" && f.message.contains("u, v has no sample for 2")));
    let checked = check_campaign(&folder.join("campaign.toml"), LoadOptions::default()).unwrap();
    assert_eq!(checked.logs[0].segments, 1, "{:#?}", checked.warnings);
    let [a, b] = [&whole, &silent].map(|c| estimates(&fit(c, Estimator::FilterError)));
    for k in [0, 3, 6] {
        // the two logs differ in 2 s of samples only, so the estimates differ by less than one
        // standard deviation
        assert!((a[k].0 - b[k].0).abs() < a[k].1, "inertia {k}: {:?} undisturbed, {:?} with the silence", a[k], b[k]);
        assert!((b[k].0 - TRUTH[k]).abs() < 3.0 * b[k].1, "inertia {k}: {:?}, truth {}", b[k], TRUTH[k]);
    }
}

/// A compass that is logged 0.4 s late in a file of its own is found with its delay, and not found
/// once the offset is given.
#[test]
fn the_latency_between_files_is_estimated() {
    let folder = folder("latency");
    let made = blind(&BlindOptions { seed: 21, ..BlindOptions::default() }).unwrap();
    let run = &made.runs[5];
    let compass = |name: &String| name == "psi";
    let part = |keep: &dyn Fn(&String) -> bool, ahead: f64| {
        let later = |s: &Signal| {
            let time: Vec<f64> = s.time().iter().map(|t| t + ahead).collect();
            Signal::new(time.into(), s.values())
        };
        let signals = run.signals.iter().filter(|(name, _)| keep(name)).map(|(name, s)| (name.clone(), later(s)));
        Run { signals: signals.collect(), ..Run::default() }
    };
    log::write(&part(&|name| !compass(name), 0.0), folder.join("imu.csv")).unwrap();
    log::write(&part(&compass, 0.4), folder.join("compass.csv")).unwrap();
    let check = |file: &str| -> Check {
        let path = folder.join("campaign.toml");
        fs::write(&path, format!("{CAMPAIGN}{LOG}[[run]]\nfile = {file}\n")).unwrap();
        check_campaign(&path, LoadOptions::default()).unwrap()
    };
    let lag = |check: &Check| {
        let of_yaw = check.logs[0].agreements.iter().find(|a| a.channel == "r").unwrap();
        of_yaw.lag.unwrap().seconds
    };
    let late = check("['imu.csv', 'compass.csv']");
    // the estimate is good to some hundredths of a second
    assert!((lag(&late) - 0.4).abs() < 0.05, "{}", lag(&late));
    assert!(late.warnings.iter().any(|f| f.code == "K116"), "{:#?}", late.warnings);
    let json = serde_json::to_value(&late).unwrap();
    let agreements = json["logs"][0]["agreements"].as_array().unwrap();
    assert!(agreements.iter().any(|a| a["channel"] == "r" && a["lag"]["seconds"].as_f64().is_some()), "{json}");
    let right = check("['imu.csv', { file = 'compass.csv', clock_offset = -0.4 }]");
    assert!(lag(&right).abs() < 0.05, "{}", lag(&right));
    assert!(right.warnings.iter().all(|f| f.code != "K116"), "{:#?}", right.warnings);
}

/// Time stamps in nanoseconds that are read as seconds are refused with a message; an integrator
/// would not end.
#[test]
fn stamps_that_are_no_seconds_do_not_hang() {
    let folder = folder("nanoseconds");
    let mut rows = Swim::new(100.0, 2.0, 1.0, 8).rows;
    rows.iter_mut().for_each(|row| row[0] = (1e9 * row[0]).round());
    fs::write(folder.join("log.csv"), file(&rows, &ALL, 0.0)).unwrap();
    let loaded = load(&folder, "'log.csv'");
    assert!(loaded.findings.iter().any(|f| f.code == "L106"));
    let error = campaign::fit(&loaded, FitOptions { estimator: Some(Estimator::OutputError) }).unwrap_err().to_string();
    assert!(error.contains("time_unit") && error.contains("2.0000e9 s"), "{error}");
    let path = folder.join("campaign.toml");
    fs::write(&path, format!("{CAMPAIGN}{LOG}[[run]]\nfile = 'log.csv'\nresample = 4.0\n")).unwrap();
    let error = Campaign::load(&path, LoadOptions::default()).unwrap_err();
    assert_eq!(error.findings()[0].code, "M009", "{error}");
}
