//! Assumed places and thrust of thrusters of which only the number is known.

use std::fmt::Write;

use super::commands::{Column, Kind};
use super::quoted;
use crate::campaign::vehicles::known_vehicles;
use crate::thrust::thruster::Thruster;

/// Places and axes for these commands, with the reason.
#[allow(clippy::type_complexity)] // position and axis of each thruster, and why
fn placed(commands: &[Column]) -> (Vec<([f64; 3], [f64; 3])>, String) {
    let of = |id: &str| -> Vec<([f64; 3], [f64; 3])> {
        let vehicle = known_vehicles().into_iter().find(|v| v.id == id);
        vehicle.map_or_else(Vec::new, |v| v.file.thrusters.iter().map(|t| (t.position, t.axis)).collect())
    };
    let ahead = [1.0, 0.0, 0.0];
    let side = |c: &Column| match c.label.as_str() {
        "left" | "port" | "links" | "backbord" | "l" => Some(-0.2),
        "right" | "starboard" | "stbd" | "rechts" | "steuerbord" | "r" => Some(0.2),
        _ => None,
    };
    match commands.len() {
        1 => (vec![([-0.5, 0.0, 0.0], ahead)], "one thruster: assumed to push ahead on the centre line".into()),
        2 if commands.iter().all(|c| side(c).is_some()) => {
            let place = |c: &Column| ([-0.3, side(c).unwrap_or(0.0), 0.0], ahead);
            (commands.iter().map(place).collect(), "sides as in the names; 0.2 m off the centre line is assumed".into())
        }
        2 => (
            vec![([-0.3, -0.2, 0.0], ahead), ([-0.3, 0.2, 0.0], ahead)],
            "two thrusters: the first assumed to be the port one, both push ahead, 0.2 m off the centre line".into(),
        ),
        3 => (
            vec![([-0.15, -0.15, 0.0], ahead), ([-0.15, 0.15, 0.0], ahead), ([0.0; 3], [0.0, 0.0, 1.0])],
            "three thrusters: assumed to be port, starboard and vertical".into(),
        ),
        4 => (of("bluerov2")[..4].to_vec(), "four thrusters: assumed to be the horizontal ones of a BlueROV2".into()),
        6 => (of("bluerov2"), "six thrusters: assumed to be those of a BlueROV2".into()),
        8 => (of("bluerov2-heavy"), "eight thrusters: assumed to be those of a BlueROV2 Heavy".into()),
        n => (
            vec![([0.0; 3], ahead); n],
            format!("{n} thrusters: nothing is known of them, all are assumed to push ahead"),
        ),
    }
}

/// Assumed thrust of a thruster of unknown make at the greatest command, N.
#[derive(Debug, Clone, PartialEq)]
pub enum Full {
    /// The thrust of a T200 at 16 V.
    T200,
    /// The drag of a hull at the speed that it reached.
    Hull(f64),
}

impl Full {
    /// Drag of a streamlined hull over ½ ρ ∇^(2/3) u²: 0.037 of the Mariner ship, 0.03 to 0.05 of a
    /// REMUS 100.
    const STREAMLINED: f64 = 0.04;

    /// The thrust of each of `thrusters` that drive a hull of `mass`, kg, at `speed`, m/s, in water
    /// of `density`, kg/m³.
    pub fn of_hull(mass: f64, speed: f64, density: f64, thrusters: usize) -> Full {
        let drag = 0.5 * density * Full::STREAMLINED * (mass / density).powf(2.0 / 3.0) * speed * speed;
        Full::Hull(drag / thrusters.max(1) as f64)
    }

    /// Ahead and astern, N.
    fn forces(&self) -> [f64; 2] {
        match self {
            Full::T200 => [52.7, 40.6],
            Full::Hull(force) => [*force; 2],
        }
    }

    fn why(&self) -> &'static str {
        match self {
            Full::T200 => "that of a T200 at 16 V",
            Full::Hull(_) => {
                "the drag of a streamlined hull of this mass at the highest speed of the logs, correct within a factor \
                 of two"
            }
        }
    }
}

/// The thrust curve that reaches `full` at the `greatest` command, in the unit of the command, with
/// the reason.
fn curve(kind: Kind, greatest: f64, full: &Full) -> (String, String) {
    let of = |what: &str| format!("thrust grows with the square of {what}; at the largest of this log {}", full.why());
    let lines = |[ahead, astern]: [String; 2]| {
        format!("forward = {{ a = {ahead}, b = 0.0 }}\nreverse = {{ a = {astern}, b = 0.0 }}\n")
    };
    match (kind, full) {
        (Kind::Turns, _) => (lines(full.forces().map(|force| format!("{force:.1}"))), of("the turns")),
        (Kind::Volts, _) => {
            let a = |force: f64| format!("{:.4}", force / greatest.max(1e-9).powi(2));
            (lines(full.forces().map(a)), of("the voltage"))
        }
        (_, Full::Hull(force)) => (lines([*force; 2].map(|force| format!("{force:.1}"))), of("the command")),
        (_, Full::T200) => (
            "forward = { a = 36.3, b = 23.3 }\nreverse = { a = 25.0, b = 20.7 }\ndeadband = 0.074\n".into(),
            "a T200 at 16 V; enter those of your thrusters, or bollard = \"table.csv\" of a bollard-pull test".into(),
        ),
    }
}

/// The `[[thruster]]` tables for commands of unknown thrusters. The `greatest` command gives the
/// thrust `full`; `pulse`: neutral, span and their reason.
#[allow(clippy::needless_pass_by_value)] // made for this call
pub fn tables(
    commands: &[Column],
    kind: Kind,
    greatest: f64,
    full: &Full,
    pulse: Option<(f64, f64, String)>,
) -> String {
    let (places, why) = placed(commands);
    let mut text = format!(
        "\n# guessed: where the thrusters sit and point ({why}).\n# Masses and drags scale with the thrust that is \
         given here: measure positions (m, body axes), axes and thrust, and\n# correct them, or give the vehicle with \
         --vehicle.\n"
    );
    if kind == Kind::Force {
        text += "# The log has forces; the curves below are not used.\n";
    }
    let (curve, of) = curve(kind, greatest, full);
    let _ = writeln!(text, "# guessed: the curve: {of}");
    if let Some((.., why)) = &pulse {
        let _ = writeln!(text, "# guessed: neutral and span of the pulses: {why}");
    }
    for (command, (position, axis)) in commands.iter().zip(places) {
        let _ = write!(
            text,
            "[[thruster]]\nname = {}\nposition = {position:?}\naxis = {axis:?}\n{curve}",
            quoted(&command.label)
        );
        if let Some((neutral, span, _)) = &pulse {
            let _ = writeln!(text, "neutral = {neutral:?}\nspan = {span:?}");
        }
        text.push('\n');
    }
    text
}

/// The thrusters of a text of tables.
pub fn read(text: &str) -> Vec<Thruster> {
    #[derive(serde::Deserialize)]
    struct Tables {
        #[serde(default)]
        thruster: Vec<Thruster>,
    }
    toml::from_str::<Tables>(text).map(|tables| tables.thruster).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::init::{commands, words};

    #[test]
    fn guessed_thrusters_are_ones_that_can_be_read() {
        for n in 1..=9 {
            let columns: Vec<Column> =
                (1..=n).filter_map(|k| commands::of(&format!("pwm{k}"), &words::of(&format!("pwm{k}")))).collect();
            let pulse = Some((1500.0, 400.0, "usual".to_string()));
            let text = tables(&columns, Kind::Pulse, 1900.0, &Full::T200, pulse);
            let thrusters = read(&text);
            assert_eq!(thrusters.len(), n);
            thrusters.iter().for_each(|t| t.validate().unwrap());
        }
        let sides: Vec<Column> =
            ["left_cmd", "right_cmd"].iter().filter_map(|h| commands::of(h, &words::of(h))).collect();
        let thrusters = read(&tables(&sides, Kind::Volts, 10.0, &Full::T200, None));
        assert!(thrusters[0].position[1] < 0.0 && thrusters[1].position[1] > 0.0);
        // full command gives the thrust that is assumed
        assert!((thrusters[0].curve().force(10.0) - 52.7).abs() < 0.1);
    }

    /// A REMUS 100 of 30.5 kg makes 3.6 to 10 N at 1.5 m/s, the Mariner of 17 000 t about 700 kN at 15 knots.
    #[test]
    fn a_hull_needs_the_thrust_of_its_drag() {
        let within = |full: Full, least: f64, most: f64| (least..most).contains(&full.forces()[0]);
        assert!(within(Full::of_hull(30.48, 1.5, 1030.0, 1), 3.6, 10.0));
        assert!(within(Full::of_hull(17e6, 7.7, 1025.0, 1), 600e3, 850e3));
    }
}
