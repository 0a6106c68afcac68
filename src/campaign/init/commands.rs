//! Columns of thruster commands: their kind, unit and neutral.

use super::units;
use super::words::{self, Words};
use crate::log::columns::Quantity;
use crate::log::options::{ColumnSource, LogOptions};
use crate::run::Signal;

/// Kind of a thruster's command, by the unit of its column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Force, N.
    Force,
    /// Pulse width, µs.
    Pulse,
    /// Part of the full command, −1 to 1.
    Part,
    /// Part of the full command, %.
    Percent,
    /// Control voltage, V.
    Volts,
    /// Turns a minute.
    Turns,
}

/// A column that may be a command of a thruster.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Header in the file.
    pub header: String,
    /// Label of the thruster: number or side.
    pub label: String,
    /// Order within its group.
    pub order: usize,
    /// Kind by name and unit; `None` if only the values can tell.
    pub kind: Option<Kind>,
    /// Words without the label: the same for all columns of one group.
    pub group: String,
}

const DRIVES: &[&str] = &[
    "pwm",
    "thruster",
    "thrusters",
    "thr",
    "thrust",
    "schub",
    "motor",
    "motors",
    "mot",
    "esc",
    "servo",
    "rcout",
    "rcou",
    "rpm",
    "throttle",
    "prop",
    "propeller",
    "actuator",
    "cmd",
    "command",
    "channels",
    "out",
    "output",
];
/// Words that mean a measured force (`FORCE`), or a command without a number (`COMMAND`).
pub const FORCE: &[&str] = &["force", "thrust", "load"];
pub const COMMAND: &[&str] = &["input", "command", "cmd", "pwm", "throttle", "volts"];

/// Whether one of these words is in a name.
pub fn names(words: &Words, wanted: &[&str]) -> bool {
    words.words.iter().any(|w| wanted.contains(&w.as_str()))
}

/// Single letters and words that mean a command only with a number: V1, F2, T3, M4, C5.
const LETTERS: &[&str] = &["v", "f", "t", "m", "c", "ch", "chan", "channel", "u", "volt", "voltage", "force"];
const SIDES: &[&str] = &[
    "left",
    "port",
    "links",
    "backbord",
    "l",
    "right",
    "starboard",
    "stbd",
    "rechts",
    "steuerbord",
    "r",
    "fl",
    "fr",
    "rl",
    "rr",
    "bl",
    "br",
    "front",
    "bow",
    "rear",
    "aft",
    "stern",
    "main",
    "vertical",
    "vert",
    "lateral",
    "up",
    "down",
    "center",
    "centre",
];
const NO_DRIVES: &[&str] = &[
    "temp",
    "temperature",
    "current",
    "amps",
    "amp",
    "power",
    "watt",
    "status",
    "mode",
    "error",
    "setpoint",
    "enabled",
    "armed",
    "in",
    "rcin",
    "input",
    "time",
    "stamp",
    "heading",
    "rudder",
    "elevator",
    "fin",
    "yaw",
    "surge",
    "sway",
    "heave",
    "roll",
    "pitch",
    "depth",
    "cov",
    "covariance",
];

/// Names of the command of a single thruster, as of a torpedo or a ship.
const ONE: &[&[&str]] = &[
    &["rpm"],
    &["pwm"],
    &["throttle"],
    &["n", "prop"],
    &["n", "propeller"],
    &["prop", "n"],
    &["thruster", "voltage"],
    &["volt", "thr"],
    &["thr", "volt"],
];

/// Names of the measured thrust of that thruster.
const PUSH: &[&[&str]] =
    &[&["thrust"], &["prop", "thrust"], &["propeller", "thrust"], &["thrust", "prop"], &["total", "thrust"]];

/// The column of the measured thrust of a single propeller; `None` if the header is another one.
pub fn push(header: &str, words: &Words) -> Option<Column> {
    let names: Vec<&str> = words.words.iter().map(String::as_str).collect();
    let unit = words.unit.as_deref().is_none_or(|unit| units::is_read(Quantity::Force, unit));
    (unit && PUSH.contains(&&names[..])).then(|| Column { kind: Some(Kind::Force), ..single(header, words) })
}

/// Reads a header as that of a thruster's command; `None` if it is not one.
pub fn of(header: &str, words: &Words) -> Option<Column> {
    let w: Vec<&str> = words.words.iter().map(String::as_str).collect();
    if w.iter().any(|word| NO_DRIVES.contains(word)) {
        return None;
    }
    let drive = w.iter().any(|word| DRIVES.contains(word));
    // the last number is that of the thruster; an earlier one belongs to a message
    let number = w.iter().rposition(|word| word.bytes().all(|b| b.is_ascii_digit()));
    let side = w.iter().position(|word| SIDES.contains(word) && (drive || word.len() > 1));
    let lettered = number.is_some() && w.len() == 2 && LETTERS.contains(&w[0]);
    // `u_left` of a paper, `field.data0` of an array that rostopic writes
    let sided = side.is_some() && w.len() == 2 && ["u", "f", "n"].contains(&w[0]);
    let is_number = |word: &&str| word.bytes().all(|b| b.is_ascii_digit());
    let arrayed =
        w.contains(&"data") && w.iter().all(|word| ["field", "msg", "data"].contains(word) || is_number(word));
    let turned = w.len() == 2 && w[0] == "n" && matches!(words.unit.as_deref(), Some("rad/s"));
    let by_unit = turned || matches!(words.unit.as_deref(), Some("us" | "rpm" | "rps" | "%"));
    let at = match (drive, lettered, number, side) {
        (true, _, Some(k), _) | (_, true, Some(k), _) => k,
        (false, _, Some(k), _) if arrayed => k,
        (false, _, None, Some(k)) if sided => k,
        (true, _, None, Some(k)) => k,
        (false, false, Some(k), _) if by_unit => k,
        (false, false, None, Some(k)) if by_unit => k,
        (true, false, None, None) if by_unit || ONE.contains(&&w[..]) => usize::MAX,
        (false, false, None, None) if by_unit && w == ["n"] => usize::MAX,
        _ => return None,
    };
    let label = w.get(at).copied().unwrap_or("main").to_string();
    let order = label.parse().unwrap_or_else(|_| SIDES.iter().position(|s| *s == label).unwrap_or(0));
    let rest: Vec<&str> = w.iter().enumerate().filter(|(k, _)| *k != at).map(|(_, word)| *word).collect();
    let kind = match words.unit.as_deref() {
        Some("us") => Some(Kind::Pulse),
        Some("rpm" | "rps" | "rad/s") => Some(Kind::Turns),
        Some("%") => Some(Kind::Percent),
        Some(unit) if units::is_read(Quantity::Force, unit) => Some(Kind::Force),
        Some("V") => Some(Kind::Volts),
        Some("1" | "-") => Some(Kind::Part),
        _ if rest.contains(&"rpm") || at == usize::MAX && rest.contains(&"n") => Some(Kind::Turns),
        _ if w[0] == "f" && (lettered || sided) || rest.contains(&"force") || rest == ["thrust"] => Some(Kind::Force),
        _ if rest.iter().any(|word| ["volt", "voltage"].contains(word)) => Some(Kind::Volts),
        _ => None,
    };
    Some(Column { header: header.to_string(), label, order, kind, group: rest.join(" ") })
}

/// Whether only the name says that a command is a force: `thrust_left` may also be a part of the
/// full thrust.
pub fn is_force_by_name(column: &Column) -> bool {
    let words = words::of(&column.header);
    let lettered = words.words.first().is_some_and(|w| w == "f") && column.label.bytes().all(|b| b.is_ascii_digit());
    column.kind == Some(Kind::Force) && words.unit.is_none() && !lettered
}

/// Commands whose columns the user has given: F1, F2, …, else V1, V2, …
pub fn given(options: &LogOptions) -> Vec<Column> {
    let of = |letter: char| -> Vec<Column> {
        let numbered = |(channel, source): (&String, &ColumnSource)| {
            let order: usize = channel.strip_prefix(letter)?.parse().ok()?;
            let kind = match (letter, source.unit.as_deref()) {
                ('F', _) => Some(Kind::Force),
                (_, Some("us")) => Some(Kind::Pulse),
                (_, Some("1")) => Some(Kind::Part),
                (_, Some("V")) => Some(Kind::Volts),
                _ => None,
            };
            Some(Column { header: source.name.clone(), label: order.to_string(), order, kind, group: String::new() })
        };
        let mut found: Vec<Column> = options.columns.iter().filter_map(numbered).collect();
        found.sort_by_key(|column| column.order);
        found
    };
    let forces = of('F');
    if forces.is_empty() { of('V') } else { forces }
}

/// The command of a single thruster, as on a bench.
pub fn single(header: &str, words: &Words) -> Column {
    let unit = words.unit.as_deref().unwrap_or("");
    let kind = [("us", Kind::Pulse), ("rpm", Kind::Turns), ("%", Kind::Percent), ("V", Kind::Volts)];
    let kind = kind.into_iter().find(|(name, _)| *name == unit).map(|(_, kind)| kind);
    Column { header: header.into(), label: "main".into(), order: 0, kind, group: String::new() }
}

/// The commands of the chosen group: the largest one; turns only if there is no other kind.
pub fn chosen(columns: &[Column]) -> Vec<Column> {
    let mut groups: Vec<Vec<Column>> = Vec::new();
    for column in columns {
        let same = |g: &&mut Vec<Column>| (&g[0].group, g[0].kind) == (&column.group, column.kind);
        match groups.iter_mut().find(same) {
            Some(group) => group.push(column.clone()),
            None => groups.push(vec![column.clone()]),
        }
    }
    // turns beside another command are a measurement: the command comes first
    groups.sort_by_key(|g| (g[0].kind == Some(Kind::Turns), std::cmp::Reverse(g.len())));
    let mut group = groups.into_iter().next().unwrap_or_default();
    group.sort_by_key(|c| c.order);
    group
}

/// Largest absolute value of commands that are called forces and are parts of the full command: no
/// thruster has a full thrust of 1.5 N.
pub const PARTS: f64 = 1.5;

/// Kind of commands by their values, for names that do not tell.
pub fn kind_of(values: &[&Signal]) -> Kind {
    let all = || values.iter().flat_map(|s| s.values()).copied();
    let (low, high) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    let most = high.abs().max(low.abs());
    match () {
        () if low >= 0.0
            && (800.0..=2300.0).contains(&high)
            && all().filter(|x| *x > 700.0).count() * 2 > all().count() =>
        {
            Kind::Pulse
        }
        () if most <= 1.05 => Kind::Part,
        () if most <= 12.5 => Kind::Volts,
        () if most <= 101.0 => Kind::Percent,
        () => Kind::Turns,
    }
}

/// Neutral pulse width and the change that makes a full command, µs, with the reason.
pub fn pulses(values: &[&Signal]) -> (f64, f64, String) {
    let mut counts: std::collections::BTreeMap<i64, usize> = std::collections::BTreeMap::new();
    for x in values.iter().flat_map(|s| s.values()).filter(|x| **x > 700.0) {
        *counts.entry(x.round() as i64).or_default() += 1;
    }
    let (low, high) = (counts.keys().next().copied().unwrap_or(1500), counts.keys().last().copied().unwrap_or(1500));
    let usual = counts.iter().max_by_key(|(_, n)| **n).map_or(1500, |(x, _)| *x);
    let seen = format!("they run from {low} to {high} us");
    if low >= 990 && usual <= 1010 && high > 1300 {
        return (1000.0, 1000.0, format!("{seen} and mostly rest at {usual}: a unidirectional drive"));
    }
    if (1450..=1550).contains(&usual) && counts[&usual] * 10 > counts.values().sum::<usize>() {
        return (usual as f64, 400.0, format!("{seen} and mostly rest at {usual}; 1100 to 1900 us is the usual range"));
    }
    (1500.0, 400.0, format!("{seen}; 1500 is the usual neutral and 1100 to 1900 us the usual range"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(header: &str) -> Option<Column> {
        of(header, &words::of(header))
    }

    #[test]
    fn commands_are_told_from_other_columns() {
        for (header, label, kind) in [
            ("pwm1", "1", None),
            ("thruster_3", "3", None),
            ("left_cmd [%]", "left", Some(Kind::Percent)),
            ("pwm_left_us", "left", Some(Kind::Pulse)),
            ("rpm_2", "2", Some(Kind::Turns)),
            ("V3 [us]", "3", Some(Kind::Pulse)),
            ("F1", "1", Some(Kind::Force)),
            ("servo4_raw", "4", None),
            ("thrust_1 [N]", "1", Some(Kind::Force)),
            ("u_left", "left", None),
            ("n1 [rad/s]", "1", Some(Kind::Turns)),
            ("n_left [rps]", "left", Some(Kind::Turns)),
            ("thruster_2 [kN]", "2", Some(Kind::Force)),
            ("f_left", "left", Some(Kind::Force)),
            ("field.data0", "0", None),
            ("Motor rechts [%]", "rechts", Some(Kind::Percent)),
            ("n [rps]", "main", Some(Kind::Turns)),
            ("n_prop", "main", Some(Kind::Turns)),
        ] {
            let found = column(header).unwrap_or_else(|| panic!("{header}"));
            assert_eq!((found.label.as_str(), found.kind), (label, kind), "{header}");
        }
        for other in [
            "motor1_temp",
            "yaw_cmd",
            "heading",
            "u",
            "t",
            "current_2",
            "x1",
            "field.data",
            "vel_left",
            "field.pose.covariance0",
            "gyro_1 [rad/s]",
        ] {
            assert_eq!(column(other), None, "{other}");
        }
    }

    #[test]
    fn of_two_groups_the_commanded_one_counts() {
        let columns: Vec<Column> = ["rpm_1", "rpm_2", "pwm_2", "pwm_1"].into_iter().filter_map(column).collect();
        let headers: Vec<String> = chosen(&columns).into_iter().map(|c| c.header).collect();
        assert_eq!(headers, ["pwm_1", "pwm_2"]);
        let sides: Vec<Column> = ["right_cmd", "left_cmd"].into_iter().filter_map(column).collect();
        assert_eq!(chosen(&sides)[0].label, "left");
    }

    #[test]
    fn values_tell_units_and_neutrals() {
        let signal = |values: &[f64]| {
            Signal::new((0..values.len()).map(|k| k as f64).collect::<Vec<_>>().into(), values.to_vec())
        };
        let pulse = signal(&[1500.0, 1500.0, 1600.0, 1600.0, 1500.0, 1400.0]);
        assert_eq!(kind_of(&[&pulse]), Kind::Pulse);
        assert_eq!(pulses(&[&pulse]).0, 1500.0);
        let one_way = signal(&[1000.0, 1000.0, 1000.0, 1700.0, 1200.0]);
        assert_eq!((pulses(&[&one_way]).0, pulses(&[&one_way]).1), (1000.0, 1000.0));
        assert_eq!(kind_of(&[&signal(&[0.0, -80.0, 100.0])]), Kind::Percent);
        assert_eq!(kind_of(&[&signal(&[0.0, -0.8, 1.0])]), Kind::Part);
        assert_eq!(kind_of(&[&signal(&[0.0, 900.0, 2400.0])]), Kind::Turns);
    }
}
