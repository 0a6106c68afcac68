//! The form of a log does not change the estimates: neither the order of rows and columns, nor line
//! ends, nor units.

#![allow(clippy::unwrap_used)] // tests, and the small functions they share

use std::path::Path;

use crate::swim::{CAMPAIGN, Swim};
use hydrosysid::campaign::file::{CampaignFile, ReadOptions};
use hydrosysid::campaign::{self, Campaign, Estimator, FitOptions};
use hydrosysid::log::{LogOptions, PLANAR, read_from};
use hydrosysid::run::Run;
use proptest::prelude::*;

/// Values of the parameters by each estimator in turn.
fn estimates(bytes: &[u8], options: &str) -> Vec<f64> {
    let options: LogOptions = toml::from_str(options).unwrap();
    let log = read_from(bytes, "f.csv", &options, &PLANAR).unwrap();
    let run = Run { name: "f.csv".into(), gaps: log.gaps, signals: log.signals, ..Run::default() };
    let read = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let text = format!("{CAMPAIGN}[[run]]\nfile = \"f.csv\"\n");
    let file = CampaignFile::from_bytes(text.as_bytes(), Path::new("c.toml"), &read).unwrap();
    let campaign = Campaign::from_runs(file, vec![run]).unwrap();
    [Estimator::Integral, Estimator::OutputError]
        .into_iter()
        .flat_map(|e| campaign::fit(&campaign, FitOptions { estimator: Some(e) }).unwrap().parameters)
        .map(|p| p.value)
        .collect()
}

/// A unit of a column: its name in the header, and how many of it make one default unit of the column.
type Unit = (&'static str, f64);

const VELOCITY: &[Unit] = &[("", 1.0), (" [m/s]", 1.0), (" [mm/s]", 1e3), (" [cm/s]", 1e2), (" [kn]", 3600.0 / 1852.0)];
const RATE: &[Unit] = &[("", 1.0), (" [rad/s]", 1.0), (" [deg/s]", 180.0 / std::f64::consts::PI)];
const FORCE: &[Unit] = &[("", 1.0), (" [N]", 1.0), (" [kgf]", 1.0 / 9.80665), (" [lbf]", 1.0 / 4.448_221_615_260_5)];
const MOMENT: &[Unit] = &[("", 1.0), (" [N*m]", 1.0)];
const TIME: &[Unit] = &[("", 1.0), (" [s]", 1.0), (" [ms]", 1e3), (" [us]", 1e6), (" [ns]", 1e9)];
const UNITS: [&[Unit]; 7] = [TIME, VELOCITY, VELOCITY, RATE, FORCE, FORCE, MOMENT];

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn law_the_dress_leaves_the_estimates(
        columns in Just((0..7).collect::<Vec<usize>>()).prop_shuffle(),
        rows in Just((1..302).collect::<Vec<usize>>()).prop_shuffle(),
        end in 0usize..3,
        units in prop::array::uniform7(0usize..60),
    ) {
        let swim = Swim::new(10.0, 30.0, 1.0, 11);
        let plain: Vec<Vec<f64>> =
            swim.lines()[1..].iter().map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect();
        let unit = |c: usize| UNITS[c][units[c] % UNITS[c].len()];
        let mut lines = vec![columns.iter().map(|c| format!("{}{}", PLANAR[*c], unit(*c).0)).collect::<Vec<_>>().join(",")];
        for row in &rows {
            // written with all digits, so that only the last digit of a converted value is rounded
            let cell = |c: &usize| (plain[row - 1][*c] * unit(*c).1).to_string();
            lines.push(columns.iter().map(cell).collect::<Vec<_>>().join(","));
        }
        let text = lines.join(["\n", "\r\n", "\r"][end]);
        let (dressed, plain) = (estimates(text.as_bytes(), "sort = true"), estimates(&join(&swim.lines()), ""));
        for (a, b) in dressed.iter().zip(&plain) {
            prop_assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} {b}: {:e}", (a - b).abs() / b.abs());
        }
    }
}

fn join(lines: &[String]) -> Vec<u8> {
    (lines.join("\n") + "\n").into_bytes()
}
