//! Checks of whole logs: runs of the virtual tank with injected faults, clean runs, and the reference data.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_6;

use crate::swim::Swim;
use hydrosysid::check::{self, CheckOptions, CheckReport, FaultKind, Light, LogFault, Topic};
use hydrosysid::finding::Finding;
use hydrosysid::frame::Dof;
use hydrosysid::log::options::{Missing, Repeated};
use hydrosysid::log::{self, LogOptions, PLANAR};
use hydrosysid::run::{Run, Signal};
use hydrosysid::tank::{Blind, BlindOptions, CraftKind, Noise, blind};
use hydrosysid::thrust::thruster::Thruster;

use crate::shared;

fn codes(report: &CheckReport) -> Vec<&str> {
    report.findings.iter().map(|f| f.code).collect()
}

fn campaign(seed: u64, six: bool) -> Blind {
    let craft = if seed.is_multiple_of(2) { CraftKind::Large } else { CraftKind::Small };
    blind(&BlindOptions { seed, craft, six, ..BlindOptions::default() }).expect("a campaign without anything hidden")
}

/// A run with one channel changed.
fn with(run: &Run, channel: &str, change: impl Fn(f64, f64) -> (f64, f64)) -> Run {
    let signal = &run.signals[channel];
    let (time, values): (Vec<f64>, Vec<f64>) =
        signal.time().iter().zip(signal.values()).map(|(t, x)| change(*t, *x)).unzip();
    let mut changed = run.clone();
    changed.signals.insert(channel.to_string(), Signal::new(time.into(), values));
    changed
}

fn fault(report: &CheckReport, kind: FaultKind, channel: &str) -> Option<f64> {
    let is = |f: &&LogFault| f.kind == kind && f.channel == channel;
    report.log_findings.iter().find(is).map(|f| f.factor)
}

/// No fault is found in logs without one. Findings on excitation and control loops do not count:
/// runs that move one degree of freedom do not excite the others.
#[test]
fn clean_runs_raise_no_alarm() {
    let (mut runs, mut alarms) = (0, Vec::new());
    for seed in 0..12 {
        for run in &campaign(seed, seed % 3 == 0).runs {
            let report = check::run(run, &CheckOptions::default());
            runs += 1;
            alarms.extend(report.log_findings.iter().map(|f| format!("{seed} {}: {f:?}", run.name)));
            let of_values = ["K101", "K102", "K104", "K105", "K132"];
            // with six degrees of freedom the pilot really controls the depth
            let held = |f: &&Finding| f.column.as_deref() != Some("w");
            let alarm = report.findings.iter().filter(|f| of_values.contains(&f.code)).filter(held);
            alarms.extend(alarm.map(|f| format!("{seed} {f}")));
        }
    }
    assert!(runs >= 100, "{runs}");
    assert!(alarms.is_empty(), "{} alarms in {runs} runs:\n{}", alarms.len(), alarms.join("\n"));
}

/// Each fault is found in each of several campaigns, in a run that shows it, with the right factor or delay.
#[test]
fn faults_put_in_are_found() {
    type Change = fn(&Run) -> Run;
    let faults: [(&str, Change, FaultKind, &str, f64); 9] = [
        ("r in deg/s", |r| with(r, "r", |t, x| (t, x.to_degrees())), FaultKind::Unit, "r", 57.296),
        ("u in mm/s", |r| with(r, "u", |t, x| (t, 1e3 * x)), FaultKind::Unit, "u", 1e3),
        ("v in cm/s", |r| with(r, "v", |t, x| (t, 1e2 * x)), FaultKind::Unit, "v", 1e2),
        ("r reversed", |r| with(r, "r", |t, x| (t, -x)), FaultKind::Sign, "r", -1.0),
        ("v reversed", |r| with(r, "v", |t, x| (t, -x)), FaultKind::Sign, "v", -1.0),
        ("tau_r reversed", |r| with(r, "tau_r", |t, x| (t, -x)), FaultKind::Sign, "tau_r", -1.0),
        ("heading off by 30 deg", |r| with(r, "psi", |t, x| (t, x - FRAC_PI_6)), FaultKind::Frame, "psi", FRAC_PI_6),
        ("heading 0.4 s late", |r| with(r, "psi", |t, x| (t + 0.4, x)), FaultKind::Delay, "psi", 0.4),
        ("command 0.5 s early in the log", |r| with(r, "tau_r", |t, x| (t - 0.5, x)), FaultKind::Delay, "tau_r", 0.5),
    ];
    let mut missed = Vec::new();
    for seed in 20..24 {
        // all degrees of freedom move in run 5
        let run = &campaign(seed, false).runs[5];
        for (name, change, kind, channel, factor) in faults {
            let report = check::run(&change(run), &CheckOptions::default());
            // a delay is known to some hundredths of a second, a factor to some per cent
            let right =
                fault(&report, kind, channel).is_some_and(|f| (f - factor).abs() < (0.1 * factor.abs()).max(0.08));
            if !right {
                missed.push(format!("{seed} {name}: {:?}", report.log_findings));
            }
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

/// Without pose, a rate r that is reversed together with its moment tau_r is found; only the
/// Coriolis coupling shows it.
#[test]
fn a_frame_upside_down_is_seen_in_the_coupling() {
    for seed in 30..34 {
        let mut run = campaign(seed, false).runs[5].clone();
        for channel in ["r", "tau_r"] {
            run = with(&run, channel, |t, x| (t, -x));
        }
        run.signals.retain(|name, _| !["x", "y", "z", "phi", "theta", "psi"].contains(&name.as_str()));
        let report = check::run(&run, &CheckOptions::default());
        assert_eq!(fault(&report, FaultKind::Sign, "r"), Some(-1.0), "{seed}: {:?}", report.agreements);
    }
}

/// The check of a log of the tank that is written cell by cell: `change` gets row, channel and
/// value, and returns the new value, or `None` for an empty cell.
fn tampered(change: &dyn Fn(usize, &str, f64) -> Option<f64>) -> CheckReport {
    let made = campaign(22, false);
    let run = &made.runs[5];
    let time = run.signals["u"].time();
    let channels: Vec<&str> = run.signals.keys().map(String::as_str).collect();
    let mut text = format!("t,{}\n", channels.join(","));
    for (k, t) in time.iter().enumerate() {
        text += &format!("{:.4}", change(k, "t", *t).expect("a row has a time"));
        for name in &channels {
            let signal = &run.signals[*name];
            // all channels have the same time stamps
            let x = signal.values()[signal.time().partition_point(|s| s < t).min(signal.len() - 1)];
            text += &change(k, name, x).map_or(",".into(), |x| format!(",{x:.6}"));
        }
        text += "\n";
    }
    let options = LogOptions { missing: Missing::NoSample, ..LogOptions::default() };
    let log = log::read_from(text.as_bytes(), "tampered.csv", &options, &["t", "u"]).expect("it reads");
    check::log(&log, &CheckOptions::default())
}

#[test]
fn every_tampering_lights_its_lamp() {
    type Change<'a> = &'a dyn Fn(usize, &str, f64) -> Option<f64>;
    let largest = campaign(22, false).runs[5].signals["tau_u"].values().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let limited = |_: usize, c: &str, x: f64| Some(if c == "tau_u" { x.min(0.6 * largest) } else { x });
    let cases: [(&str, Change<'_>, &str, Topic, Light); 9] = [
        (
            "frozen",
            &|k, c, x| Some(if c == "r" && (300..360).contains(&k) { 0.1234 } else { x }),
            "K102",
            Topic::Values,
            Light::Amber,
        ),
        (
            "clock set",
            &|k, c, x| Some(if c == "t" && k >= 400 { x + 0.17 } else { x }),
            "K105",
            Topic::Clock,
            Light::Amber,
        ),
        ("gap", &|k, c, x| Some(if c == "t" && k >= 400 { x + 30.0 } else { x }), "L105", Topic::Clock, Light::Amber),
        ("silent", &|k, c, x| (c != "u" || !(300..400).contains(&k)).then_some(x), "L105", Topic::Clock, Light::Amber),
        ("spike", &|k, c, x| Some(if c == "v" && k == 222 { 9.0 } else { x }), "L108", Topic::Values, Light::Amber),
        (
            "sentinel",
            &|k, c, x| Some(if c == "u" && k % 50 == 7 { -32.768 } else { x }),
            "L107",
            Topic::Values,
            Light::Red,
        ),
        ("saturated", &limited, "L113", Topic::Values, Light::Amber),
        ("constant", &|_, c, x| Some(if c == "v" { 0.0 } else { x }), "L112", Topic::Values, Light::Amber),
        ("milliseconds", &|_, c, x| Some(if c == "t" { 1e3 * x } else { x }), "L106", Topic::Clock, Light::Red),
    ];
    let clean = tampered(&|_, _, x| Some(x));
    assert_eq!(clean.worst(), Light::Green, "{:#?}", clean.findings);
    let mut missed = Vec::new();
    for (name, change, code, topic, light) in cases {
        let report = tampered(change);
        if !codes(&report).contains(&code) || report.light(topic) < Some(light) {
            missed.push(format!("{name}: {:?} {:#?}", report.lights, report.findings));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

/// A code for a missing value is the only finding: it raises no consequential findings of sign,
/// unit, frame, delay or excitation.
#[test]
fn one_code_for_no_value_says_nothing_else() {
    for channel in ["u", "v", "r", "psi", "x", "y", "tau_u", "tau_r"] {
        for rows in [vec![222], vec![100, 222, 333, 444]] {
            let report = tampered(&|k, c, x| Some(if c == channel && rows.contains(&k) { -9999.0 } else { x }));
            assert_eq!(codes(&report), ["L107"], "{channel}: {:#?}", report.findings);
            assert!(report.log_findings.is_empty(), "{channel}: {:?}", report.log_findings);
        }
    }
    let outlier = tampered(&|k, c, x| Some(if c == "u" && k == 222 { x + 9.0 } else { x }));
    assert_eq!(codes(&outlier), ["L108"], "{:#?}", outlier.findings);
}

/// A dead gyro, with rates of 1e-7 rad/s, is found in every run whose heading turns by more than
/// 1.5 rad, and in none whose heading turns by less than 0.2 rad.
#[test]
fn dead_rates_are_told_in_every_run() {
    let (mut runs, mut alarms) = (0, Vec::new());
    for seed in 40..43 {
        for run in &campaign(seed, false).runs {
            runs += 1;
            let mut noise = Noise::new(seed, 9);
            let tiny: Vec<f64> = run.signals["r"].time().iter().map(|_| 1e-7 * noise.normal()).collect();
            let mut dead = run.clone();
            dead.signals.insert("r".into(), Signal::new(run.signals["r"].shared_time().clone(), tiny));
            let report = check::run(&dead, &CheckOptions::default());
            let psi = run.signals["psi"].values();
            let turned =
                psi.iter().fold(f64::NEG_INFINITY, |m, x| m.max(*x)) - psi.iter().fold(f64::INFINITY, |m, x| m.min(*x));
            let told = codes(&report).contains(&"K118");
            if told != (turned > 0.5) && !(0.2..1.5).contains(&turned) {
                alarms.push(format!("{seed} {} turned by {turned}: {told}", run.name));
            }
            // a dead channel must raise no finding of sign or unit
            alarms.extend(
                report.log_findings.iter().filter(|f| f.channel == "r").map(|f| format!("{seed} {}: {f:?}", run.name)),
            );
        }
    }
    assert!(runs >= 20 && alarms.is_empty(), "{runs} runs\n{}", alarms.join("\n"));
}

/// A run whose channels share their time stamps.
fn run_of(time: &[f64], channels: &[(&str, Vec<f64>)]) -> Run {
    let clock: std::sync::Arc<[f64]> = time.into();
    let signals = channels.iter().map(|(name, x)| ((*name).to_string(), Signal::new(clock.clone(), x.clone())));
    Run { signals: signals.collect(), ..Run::default() }
}

/// Of two thrusters 0.4 m to port and to starboard, the one whose voltage is logged with the wrong
/// sign is named.
#[test]
fn the_thruster_that_is_reversed_is_named() {
    let rows = Swim::new(20.0, 60.0, 1.0, 3).rows;
    let column = |f: &dyn Fn(&[f64; 7]) -> f64| rows.iter().map(f).collect::<Vec<f64>>();
    let thruster = |name: &str, y: f64| -> Thruster {
        let text = format!(
            "name = '{name}'\nposition = [0.0, {y}, 0.0]\naxis = [1.0, 0.0, 0.0]\nforward = {{ a = 10.0, b = 0.0 }}\n\
             reverse = {{ a = 10.0, b = 0.0 }}"
        );
        toml::from_str(&text).expect("a thruster")
    };
    let options =
        CheckOptions { thrusters: vec![thruster("port", -0.4), thruster("starboard", 0.4)], ..CheckOptions::default() };
    for wrong in [None, Some("V1"), Some("V2")] {
        let volts = |name: &str, side: f64| {
            let sign = if wrong == Some(name) { -1.0 } else { 1.0 };
            column(&|row| sign * 0.1 * (0.5 * row[4] + side * 0.5 * row[6] / 0.4))
        };
        let run = run_of(
            &column(&|row| row[0]),
            &[
                ("u", column(&|row| row[1])),
                ("v", column(&|row| row[2])),
                ("r", column(&|row| row[3])),
                ("V1", volts("V1", 1.0)),
                ("V2", volts("V2", -1.0)),
            ],
        );
        let report = check::run(&run, &options);
        let named: Vec<&str> =
            report.log_findings.iter().filter(|f| f.kind == FaultKind::Sign).map(|f| f.channel.as_str()).collect();
        assert_eq!(named, wrong.into_iter().collect::<Vec<_>>(), "{:#?}", report.findings);
        let light = if wrong.is_some() { Light::Red } else { Light::Green };
        assert_eq!(report.light(Topic::Commands), Some(light));
    }
}

/// A speed controller and a steady command are found, and a freely varied force raises nothing, for
/// a vehicle of 100 kg with quadratic drag under a gusty force.
#[test]
fn a_controller_and_a_steady_command_are_seen() {
    let surge = |force: &dyn Fn(f64, f64) -> f64| {
        let mut noise = Noise::new(5, 1);
        let (mut u, mut gust, mut rows) = (0.5, 0.0, Vec::new());
        for k in 0..2400 {
            let t = 0.05 * f64::from(k);
            let tau = force(t, u);
            rows.push((t, u + 0.001 * noise.normal(), tau));
            // a gust with a correlation time of 2 s
            gust += 0.05 * (-gust / 2.0) + 0.2 * noise.normal();
            u += 0.05 * (tau + gust - 60.0 * u * f64::abs(u)) / 100.0;
        }
        let column = |f: &dyn Fn(&(f64, f64, f64)) -> f64| rows.iter().map(f).collect::<Vec<f64>>();
        let channels = [("u", column(&|row| row.1)), ("tau_u", column(&|row| row.2))];
        let options = CheckOptions { dofs: vec![Dof::Surge], ..CheckOptions::default() };
        check::run(&run_of(&column(&|row| row.0), &channels), &options)
    };
    let free = surge(&|t, _| 40.0 * (0.3 * t).sin());
    assert!(free.findings.is_empty(), "{:#?}", free.findings);
    let held = surge(&|_, u| 15.0 + 400.0 * (0.5 - u));
    assert!(codes(&held).contains(&"K132"), "{:#?} {:?}", held.findings, held.loops);
    let steady = surge(&|_, _| 15.0);
    assert!(codes(&steady).contains(&"K131"), "{:#?}", steady.findings);
}

/// With `repeated = "no_sample"`, a log with held values has the same samples as the log without the repeats.
#[test]
fn a_held_log_is_read_as_its_slow_sensor() {
    let Some(folder) = shared::path("badlogs") else { return };
    let options = LogOptions { repeated: Repeated::NoSample, ..LogOptions::default() };
    let held = log::read(folder.join("multirate_held.csv"), &options, &PLANAR).expect("it reads");
    let sparse = LogOptions { missing: Missing::NoSample, ..LogOptions::default() };
    let sparse = log::read(folder.join("multirate_sparse.csv"), &sparse, &PLANAR).expect("it reads");
    assert_eq!([held.signals["u"].len(), held.signals["r"].len()], [41, 201]);
    assert_eq!(held.signals, sparse.signals);
    assert!(held.warnings.is_empty() && held.notes[0].code == "L204", "{:?} {:?}", held.warnings, held.notes);
}

/// Repeats are found between empty cells as well: commands at 10 Hz leave every second row of the
/// sensors empty, and a slower DVL is repeated in the others.
#[test]
fn what_is_repeated_between_empty_rows_is_no_sample_either() {
    let (sample, dvl) = (|k: usize| k.div_ceil(5), |sample: usize| (0.3 * sample as f64).sin());
    let row = |k: usize| match k % 2 {
        0 => format!("{:.1},5,{},{}\n", 0.1 * k as f64, dvl(sample(k)), (0.7 * k as f64).sin()),
        _ => format!("{:.1},6,,\n", 0.1 * k as f64),
    };
    let text: String =
        std::iter::once("t [s],tau_u [N],u [m/s],r [rad/s]\n".to_string()).chain((0..400).map(row)).collect();
    let options = LogOptions { missing: Missing::NoSample, ..LogOptions::default() };
    let read = |options: &LogOptions| log::read_from(text.as_bytes(), "held.csv", options, &["t"]).expect("it reads");
    let found = read(&options);
    let changes = (0..400).step_by(2).filter(|k| *k == 0 || sample(*k) != sample(k - 2));
    let expected: Vec<f64> = changes.map(|k| 0.1 * k as f64).collect();
    assert!(expected.len() > 75 && expected.len() < 85, "{}", expected.len());
    let times = found.signals["u"].time();
    assert!(
        times.len() == expected.len() && times.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9),
        "{times:?}"
    );
    assert_eq!([found.signals["r"].len(), found.signals["tau_u"].len()], [200, 400]);
    let said: Vec<&str> = found.warnings.iter().filter(|w| w.code == "L111").map(|w| w.message.as_str()).collect();
    assert!(said.len() == 1 && said[0].contains("of 200 values of u only repeat the previous one"), "{said:?}");
    // if the options say that repeats are measurements, all values are samples
    let all = read(&LogOptions { repeated: Repeated::Sample, ..options });
    assert_eq!(all.signals["u"].len(), 200);
}

fn badlog(name: &str) -> Option<CheckReport> {
    let path = shared::path("badlogs")?.join(name);
    let log = log::read(path, &LogOptions::default(), &PLANAR).expect("it reads with warnings");
    Some(check::log(&log, &CheckOptions::default()))
}

#[test]
fn bad_logs_of_units_and_frames_show_their_light() {
    let expected = [
        ("good.csv", None),
        ("yaw_rate_deg.csv", Some((Topic::Consistency, Light::Red))),
        ("velocity_mm.csv", Some((Topic::Consistency, Light::Red))),
        ("yaw_sign_flipped.csv", Some((Topic::Commands, Light::Red))),
        ("command_delay.csv", Some((Topic::Commands, Light::Amber))),
        ("multirate_held.csv", Some((Topic::Sampling, Light::Amber))),
    ];
    for (name, light) in expected {
        let Some(report) = badlog(name) else { return };
        match light {
            Some((topic, light)) => assert_eq!(report.light(topic), Some(light), "{name}: {:#?}", report.findings),
            None => assert_eq!(report.worst(), Light::Green, "{name}: {:#?}", report.findings),
        }
    }
    let Some(late) = badlog("command_delay.csv") else { return };
    let delay = fault(&late, FaultKind::Delay, "tau_r").unwrap();
    // the command is logged half a second late, so the motion comes first
    assert!((delay + 0.5).abs() < 0.08, "{delay}");
    let Some(held) = badlog("multirate_held.csv") else { return };
    let u = held.rates.iter().find(|r| r.channel == "u").unwrap();
    assert!((u.rate_hz - 2.0).abs() < 0.01 && (u.held - 1.0).abs() < 1e-12, "its samples and no repeats: {u:?}");
}

/// The field log of a small surface craft shows its three faults: positions 11.1 % too large, a
/// speed of 5 Hz repeated in a 9 Hz log, and a speed under control.
#[test]
fn the_field_log_shows_its_three_faults() {
    let Some(folder) = shared::path("realdata/usv-bad-log") else { return };
    let columns = r#"
        t = "time_s"
        x = "north_m_file"
        y = "east_m_file"
        psi = { name = "heading_deg", unit = "deg" }
        u = { name = "speed_over_ground_mps", unit = "m/s" }
        V1 = { name = "pwm_left_us", unit = "us" }
        V2 = { name = "pwm_right_us", unit = "us" }
    "#;
    let options = LogOptions { columns: toml::from_str(columns).unwrap(), ..LogOptions::default() };
    let mut scales = BTreeMap::new();
    for name in ["boat1_2_circle.csv", "boat1_2_sin.csv"] {
        let log = log::read(folder.join("derived").join(name), &options, &["t", "u", "x", "y", "psi"]).unwrap();
        let report = check::log(&log, &CheckOptions::default());
        for f in &report.findings {
            println!("{f}");
        }
        let found = codes(&report);
        for code in ["K117", "L111", "K132"] {
            assert!(found.contains(&code), "{name} {code}: {:#?}", report.findings);
        }
        let x = fault(&report, FaultKind::Unit, "x").unwrap();
        // 123 416 m per degree instead of 111 016 at this latitude
        assert!((x - 1.1117).abs() < 0.003, "{name}: {x}");
        let u = report.rates.iter().find(|r| r.channel == "u").unwrap();
        assert!((u.rate_hz - 5.0).abs() < 0.1 && (u.held - 1.0).abs() < 1e-12, "its samples and no repeats: {u:?}");
        scales.insert(name, x);
    }
    assert_eq!(scales.len(), 2);
}
