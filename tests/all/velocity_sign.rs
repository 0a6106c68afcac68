//! A velocity whose column has the opposite sign is distinguished from thrusters that push the other way.

use crate::swim::Swim;
use hydrosysid::check::{self, CheckOptions, CheckReport};
use hydrosysid::run::{Run, Signal};
use hydrosysid::thrust::thruster::Thruster;

/// A channel, and its value as a function of a row of the swim.
type Column<'a> = (&'a str, &'a dyn Fn(&[f64; 7]) -> f64);

/// Check of the swim as driven by two thrusters along surge, 0.4 m to port and to starboard, and
/// one along sway, `ahead` m in front of the origin. The channels of `turned` are logged with the
/// opposite sign.
fn checked(ahead: f64, turned: &[&str]) -> CheckReport {
    let rows = Swim::new(20.0, 60.0, 1.0, 3).rows;
    let clock: std::sync::Arc<[f64]> = rows.iter().map(|row| row[0]).collect();
    let side = |row: &[f64; 7]| 0.5 * (row[6] - ahead * row[5]) / 0.4;
    let channels: [Column<'_>; 6] = [
        ("u", &|row| row[1]),
        ("v", &|row| row[2]),
        ("r", &|row| row[3]),
        ("F1", &|row| 0.5 * row[4] + side(row)),
        ("F2", &|row| 0.5 * row[4] - side(row)),
        ("F3", &|row| row[5]),
    ];
    let signal = |(name, of): Column<'_>| {
        let sign = if turned.contains(&name) { -1.0 } else { 1.0 };
        let values: Vec<f64> = rows.iter().map(|row| sign * of(row)).collect();
        (name.to_string(), Signal::new(clock.clone(), values))
    };
    let run = Run { signals: channels.into_iter().map(signal).collect(), ..Run::default() };
    let thruster = |position: [f64; 3], axis: [f64; 3]| -> Thruster {
        let text = format!(
            "name = 'one'\nposition = {position:?}\naxis = {axis:?}\nforward = {{ a = 10.0, b = 0.0 }}\n\
             reverse = {{ a = 10.0, b = 0.0 }}"
        );
        toml::from_str(&text).expect("a thruster")
    };
    let thrusters = vec![
        thruster([0.0, -0.4, 0.0], [1.0, 0.0, 0.0]),
        thruster([0.0, 0.4, 0.0], [1.0, 0.0, 0.0]),
        thruster([ahead, 0.0, 0.0], [0.0, 1.0, 0.0]),
    ];
    check::run(&run, &CheckOptions { thrusters, ..CheckOptions::default() })
}

fn accused(report: &CheckReport) -> Vec<&str> {
    report.log_findings.iter().map(|fault| fault.channel.as_str()).collect()
}

#[test]
fn a_velocity_of_the_opposite_sign_is_named_and_its_thrusters_are_not() {
    for ahead in [0.0, 0.3] {
        let report = checked(ahead, &["v"]);
        assert_eq!(accused(&report), ["v"], "{:#?}", report.findings);
        let said = report.findings.iter().find(|f| f.code == "K121").expect("told");
        assert!(said.message.contains("set columns.v.sign = -1"), "{said}");
        assert!(accused(&checked(ahead, &[])).is_empty());
    }
}

/// A thruster with the opposite sign that acts in sway only is distinguished from the velocity
/// column by the Coriolis force.
#[test]
fn a_thruster_of_the_opposite_sign_stays_accused() {
    for ahead in [0.0, 0.3] {
        let report = checked(ahead, &["F3"]);
        assert_eq!(accused(&report), ["F3"], "{:#?}", report.findings);
    }
}

#[test]
fn velocities_of_a_body_frame_that_is_forward_port_up_are_the_frame() {
    let report = checked(0.3, &["v", "r"]);
    let said = report.findings.iter().find(|f| f.code == "K121").expect("told");
    assert!(said.message.contains("body_frame = \"flu\""), "{said}");
}
