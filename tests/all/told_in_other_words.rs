//! Logs with channels in other forms, as written by trackers, autopilots and bridges: `init`
//! recognises them, and the campaign reads the same values as from the plain log of the plant.
#![cfg(feature = "cli")]

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use hydrosysid::campaign::{Campaign, LoadOptions};
use hydrosysid::run::Signal;
use hydrosysid_plant::{Campaign as Sea, Dof as Axis, Vehicle};

/// Columns of a run by name.
type Columns = BTreeMap<String, Vec<f64>>;

/// A header, and the cells below it.
type Column<'a> = (&'a str, Cell);

/// The text of a cell in a row.
type Cell = Box<dyn Fn(&Columns, usize) -> String>;

/// The runs of a campaign of the plant, as plain columns at the time stamps of the heading.
fn plain(folder: &Path) -> Vec<Columns> {
    let mut sea = Sea::new(Vehicle::named("laurs").expect("it exists"), &Axis::PLANE);
    (sea.runs, sea.duration, sea.seed) = (6, 40.0, 31);
    sea.sail().expect("it sails").write(folder).expect("the folder can be written");
    let campaign = Campaign::load(&folder.join("campaign.toml"), LoadOptions::default()).expect("it is a campaign");
    let columns = |run: &hydrosysid::run::Run| {
        let time = run.signal("psi").expect("a heading").time().to_vec();
        let at = |signal: &Signal| time.iter().map(|t| signal.at(*t)).collect::<Vec<f64>>();
        let mut columns: Columns = run.signals.iter().map(|(name, s)| (name.clone(), at(s))).collect();
        columns.insert("t".into(), time.clone());
        columns
    };
    campaign.runs.iter().map(columns).collect()
}

/// The campaign that `init` makes from logs with these columns, the plain runs, and the text of the campaign.
fn scaffolded(name: &str, columns: &[Column<'_>]) -> (Campaign, Vec<Columns>, String) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("told_{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    let runs = plain(&folder.join("plain"));
    let logs: Vec<PathBuf> = runs
        .iter()
        .enumerate()
        .map(|(k, run)| {
            let mut text = columns.iter().map(|(header, _)| *header).collect::<Vec<_>>().join(",") + "\n";
            for row in 0..run["t"].len() {
                // the part of a cell before a NUL belongs to a separate line above the first row
                let cells: Vec<String> = columns.iter().map(|(_, cell)| cell(run, row)).collect();
                let units: Vec<&str> = cells.iter().filter_map(|c| Some(c.split_once('\u{0}')?.0)).collect();
                if !units.is_empty() {
                    writeln!(text, "{}", units.join(",")).expect("a string");
                }
                let cells: Vec<&str> = cells.iter().map(|c| c.split_once('\u{0}').map_or(&c[..], |(_, c)| c)).collect();
                writeln!(text, "{}", cells.join(",")).expect("a string");
            }
            let log = folder.join(format!("dive{k}.csv"));
            std::fs::write(&log, text).expect("it can be written");
            log
        })
        .collect();
    let made = folder.join("made");
    let command = Path::new(env!("CARGO_BIN_EXE_hydrosysid"));
    let run = Command::new(command).arg("init").args(&logs).args(["--mass", "189", "-o"]).arg(&made).output();
    let run = run.expect("the command runs");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let file = made.join("campaign.toml");
    let text = std::fs::read_to_string(&file).expect("it was written");
    let campaign = Campaign::load(&file, LoadOptions::default());
    (campaign.unwrap_or_else(|e| panic!("{e}\n{text}")), runs, text)
}

fn plainly<'a>(header: &'a str, channel: &'static str, factor: f64) -> Column<'a> {
    (header, Box::new(move |run, k| format!("{}", factor * run[channel][k])))
}

/// Maximum difference of a channel from the plain log; if `relative`, the difference of the first
/// sample is subtracted.
fn off(campaign: &Campaign, runs: &[Columns], channel: &str, relative: bool) -> f64 {
    let mut off = 0.0_f64;
    for (run, plain) in campaign.runs.iter().zip(runs) {
        let signal = run.signal(channel).unwrap_or_else(|| panic!("{channel} is told"));
        assert_eq!(signal.len(), plain["t"].len(), "{channel}");
        let turn =
            |x: f64| if channel == "psi" { x - std::f64::consts::TAU * (x / std::f64::consts::TAU).round() } else { x };
        let difference = |k: usize| turn(signal.values()[k] - plain[channel][k]);
        let first = if relative { difference(0) } else { 0.0 };
        off = (0..signal.len()).map(|k| (difference(k) - first).abs()).fold(off, f64::max);
    }
    off
}

#[test]
fn latitude_and_longitude_of_an_autopilot() {
    // metres per degree at 59.4 degrees north, by the series of the WGS 84 in multiples of the latitude
    let cos = |multiple: f64| (multiple * 59.4_f64.to_radians()).cos();
    let north = 111_132.954 - 559.822 * cos(2.0) + 1.175 * cos(4.0);
    let east = 111_412.84 * cos(1.0) - 93.5 * cos(3.0) + 0.118 * cos(5.0);
    let degrees = |channel: &'static str, from: f64, metres: f64| {
        move |run: &Columns, k: usize| format!("{:.0}", 1e7 * (from + run[channel][k] / metres))
    };
    let columns: Vec<Column<'_>> = vec![
        ("timestamp_ms", Box::new(|run, k| format!("{:.0}", 1.7e12 + 1e3 * run["t"][k]))),
        plainly("force_x", "tau_u", 1.0),
        plainly("force_y", "tau_v", 1.0),
        plainly("torque_z", "tau_r", 1.0),
        plainly("heading_deg", "psi", 180.0 / std::f64::consts::PI),
        ("GPS.Lat", Box::new(degrees("x", 59.4, north))),
        ("GPS.Lng", Box::new(degrees("y", 18.05, east))),
    ];
    let (campaign, runs, text) = scaffolded("gps", &columns);
    assert!(text.contains("latitude = { name = \"GPS.Lat\", scale = 1e-7 }"), "{text}");
    assert!(text.contains("position_source = \"independent\""), "{text}");
    for channel in ["x", "y"] {
        // 1e-7 degrees are 1.1 cm, half of which is the rounding of each fix; the digits of the
        // series are good to a metre per degree
        let off = off(&campaign, &runs, channel, true);
        assert!(off < 0.012, "{channel}: {off}");
    }
    assert!(campaign.model.dofs.len() == 3, "{:?}", campaign.model.dofs);
}

#[test]
fn a_quaternion_of_a_robot() {
    let half = |of: fn(f64) -> f64| move |run: &Columns, k: usize| format!("{}", of(0.5 * run["psi"][k]));
    let columns: Vec<Column<'_>> = vec![
        plainly("time", "t", 1.0),
        plainly("wrench.force.x", "tau_u", 1.0),
        plainly("wrench.force.y", "tau_v", 1.0),
        plainly("wrench.torque.z", "tau_r", 1.0),
        plainly("dvl.vx", "u", 1.0),
        plainly("dvl.vy", "v", 1.0),
        plainly("imu.angular_velocity.z", "r", 1.0),
        ("pose.orientation.x", Box::new(|_, _| "0".into())),
        ("pose.orientation.y", Box::new(|_, _| "0".into())),
        ("pose.orientation.z", Box::new(half(f64::sin))),
        ("pose.orientation.w", Box::new(half(f64::cos))),
    ];
    let (campaign, runs, text) = scaffolded("quaternion", &columns);
    assert!(text.contains("qw = \"pose.orientation.w\""), "{text}");
    for channel in ["psi", "u", "v", "r"] {
        // written with all digits; the tolerance is for the rounding of a sine and its inverse
        let off = off(&campaign, &runs, channel, false);
        assert!(off < 1e-12, "{channel}: {off}");
    }
}

#[test]
fn a_track_with_a_date_and_a_time_of_day() {
    let columns: Vec<Column<'_>> = vec![
        ("Date", Box::new(|_, _| "2024-05-03".into())),
        (
            "Time",
            Box::new(|run, k| {
                let t = run["t"][k];
                format!("23:{:02.0}:{:06.3}", (t / 60.0).floor(), t % 60.0)
            }),
        ),
        plainly("Fx", "tau_u", 1.0),
        plainly("Fy", "tau_v", 1.0),
        plainly("Mz", "tau_r", 1.0),
        plainly("HDG", "psi", 180.0 / std::f64::consts::PI),
        ("SOG (kn)", Box::new(|run, k| format!("{}", run["u"][k].hypot(run["v"][k]) * 3600.0 / 1852.0))),
        (
            "COG",
            Box::new(|run, k| {
                let course = run["psi"][k] + run["v"][k].atan2(run["u"][k]);
                format!("{}", course.to_degrees().rem_euclid(360.0))
            }),
        ),
        plainly("ROT [deg/s]", "r", 180.0 / std::f64::consts::PI),
    ];
    let (campaign, runs, text) = scaffolded("track", &columns);
    for said in ["date = \"Date\"", "t = \"Time\"", "sog = { name = \"SOG (kn)\"", "cog = \"COG\"", "psi = "] {
        assert!(text.contains(said), "{said}\n{text}");
    }
    for (channel, most) in [("u", 1e-9), ("v", 1e-9), ("psi", 1e-12), ("r", 1e-12)] {
        // the heading is interpolated to the time stamps of the speed, which are its own to a
        // billionth of a second
        let off = off(&campaign, &runs, channel, false);
        assert!(off < most, "{channel}: {off}");
    }
    let time = campaign.runs[0].signal("u").expect("it is told").time().to_vec();
    // to the milliseconds of the column
    assert!(time.iter().zip(&runs[0]["t"]).all(|(a, b)| (a - b).abs() < 1e-3), "{:?}", &time[..3]);
}

/// A spreadsheet table with durations as MATLAB writes them, units in a separate line, symbols of
/// SNAME, and velocities north and east.
#[test]
fn a_table_with_its_units_below_the_header() {
    let over_ground = |north: bool| {
        move |run: &Columns, k: usize| {
            let (sin, cos) = run["psi"][k].sin_cos();
            let (u, v) = (run["u"][k], run["v"][k]);
            format!("{}", if north { u * cos - v * sin } else { u * sin + v * cos })
        }
    };
    // the line of units is the first row of the file
    let below = |unit: &'static str, cell: Cell| {
        let cell = move |run: &Columns, k: usize| match k {
            0 => format!("{unit}\u{0}{}", cell(run, 0)),
            k => cell(run, k),
        };
        Box::new(cell) as Cell
    };
    let number = |channel: &'static str, factor: f64| -> Cell {
        Box::new(move |run: &Columns, k: usize| format!("{}", factor * run[channel][k]))
    };
    let degrees = 180.0 / std::f64::consts::PI;
    let columns: Vec<Column<'_>> = vec![
        ("Time", below("", Box::new(|run: &Columns, k: usize| format!("{:.1} sec", run["t"][k])))),
        ("Vel North", below("m/s", Box::new(over_ground(true)))),
        ("Vel East", below("m/s", Box::new(over_ground(false)))),
        ("Yaw rate", below("deg/s", number("r", degrees))),
        ("Heading", below("deg", number("psi", degrees))),
        ("X", below("N", number("tau_u", 1.0))),
        ("Y", below("N", number("tau_v", 1.0))),
        ("N", below("Nm", number("tau_r", 1.0))),
    ];
    let (campaign, runs, text) = scaffolded("units", &columns);
    for said in ["unit_row = true", "time_format = \"duration\"", "v_north = ", "tau_r = "] {
        assert!(text.contains(said), "{said}\n{text}");
    }
    for channel in ["u", "v", "psi", "r", "tau_u", "tau_v", "tau_r"] {
        // the tolerance is for the rounding of conversions of forces and of rotations
        let off = off(&campaign, &runs, channel, false);
        assert!(off < 1e-9, "{channel}: {off}");
    }
}
