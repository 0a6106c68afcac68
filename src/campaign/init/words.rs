//! Splitting of a header into words and the unit written with them: `yaw_rate_deg_s` → yaw, rate;
//! deg/s.

use crate::log::columns::split_header;

/// Words and unit of a header.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Words {
    /// Words in lower case, numbers apart.
    pub words: Vec<String>,
    /// Unit in brackets or as the last words, in the reader's spelling if the reader knows it.
    pub unit: Option<String>,
}

/// Units as the last words of a header, longest first.
const TRAILING: &[(&[&str], &str)] = &[
    (&["rad", "per", "s"], "rad/s"),
    (&["deg", "per", "s"], "deg/s"),
    (&["m", "per", "s"], "m/s"),
    (&["deg", "per", "min"], "deg/min"),
    (&["k", "n", "m"], "kN*m"),
    (&["k", "n"], "kN"),
    (&["m", "n"], "mN"),
    (&["rad", "s"], "rad/s"),
    (&["deg", "s"], "deg/s"),
    (&["mm", "s"], "mm/s"),
    (&["cm", "s"], "cm/s"),
    (&["km", "h"], "km/h"),
    (&["m", "s"], "m/s"),
    (&["rads"], "rad/s"),
    (&["radps"], "rad/s"),
    (&["dps"], "deg/s"),
    (&["degps"], "deg/s"),
    (&["degs"], "deg/s"),
    (&["mps"], "m/s"),
    (&["kmh"], "km/h"),
    (&["knots"], "kn"),
    (&["kts"], "kn"),
    (&["kn"], "kn"),
    (&["degrees"], "deg"),
    (&["degree"], "deg"),
    (&["deg"], "deg"),
    (&["radians"], "rad"),
    (&["rad"], "rad"),
    (&["percent"], "%"),
    (&["pct"], "%"),
    (&["rpm"], "rpm"),
    (&["rps"], "rps"),
    (&["volts"], "V"),
    (&["newton"], "N"),
    (&["nm"], "N*m"),
    (&["knm"], "kN*m"),
    (&["kgf"], "kgf"),
    (&["lbf"], "lbf"),
    (&["usec"], "us"),
    (&["msec"], "ms"),
    (&["sec"], "s"),
    (&["seconds"], "s"),
    (&["secs"], "s"),
    (&["us"], "us"),
    (&["ms"], "ms"),
    (&["ns"], "ns"),
    (&["mbar"], "mbar"),
    (&["hpa"], "hPa"),
    (&["dbar"], "dbar"),
    (&["bar"], "bar"),
    (&["kpa"], "kPa"),
    (&["pa"], "Pa"),
    (&["mm"], "mm"),
    (&["cm"], "cm"),
    (&["ft"], "ft"),
    (&["m"], "m"),
    (&["n"], "N"),
    (&["s"], "s"),
];

/// Words after which a last letter is a direction or a symbol: `pos_n` is north, `tau_N` a moment.
const SYMBOLS: &[(&str, &str)] =
    &[("pos", "n"), ("position", "n"), ("vel", "n"), ("velocity", "n"), ("v", "n"), ("tau", "n"), ("tau", "m")];

/// Splits a header into words and unit.
pub fn of(header: &str) -> Words {
    let (name, bracketed) = split_header(header);
    let round = header.trim().strip_suffix(')').and_then(|h| h.rsplit_once('('));
    let (name, unit) = match (bracketed, round) {
        (Some(unit), _) => (name, Some(unit)),
        (None, Some((name, unit))) if !name.trim().is_empty() => (name, Some(unit)),
        _ => (name, None),
    };
    let mut words = split(name);
    let unit = unit.filter(|u| !u.is_empty()).map(spelled).or_else(|| {
        if let [.., before, last] = &words[..]
            && SYMBOLS.contains(&(before.as_str(), last.as_str()))
        {
            return None;
        }
        let found = TRAILING.iter().find(|(last, _)| words.len() > last.len() && ends(&words, last))?;
        words.truncate(words.len() - found.0.len());
        Some(found.1.to_string())
    });
    Words { words, unit }
}

fn ends(words: &[String], last: &[&str]) -> bool {
    words[words.len() - last.len()..].iter().zip(last).all(|(a, b)| a == b)
}

/// A unit in the spelling of the reader.
pub fn spelled(unit: &str) -> String {
    let plain: String = unit.chars().filter(|c| !c.is_whitespace()).collect();
    let small = plain.to_lowercase();
    let known = match small.as_str() {
        "degrees" | "degree" | "°" | "deg." => "deg",
        "radians" | "radian" => "rad",
        "°/s" | "deg/sec" | "dps" | "degs" | "deg*s-1" => "deg/s",
        "rad/sec" | "rads" | "rad*s-1" => "rad/s",
        "°/min" => "deg/min",
        "m/sec" | "mps" | "m*s-1" | "ms-1" => "m/s",
        "km/hr" | "kmh" | "kph" => "km/h",
        "knots" | "kts" | "knot" => "kn",
        "sec" | "seconds" | "second" => "s",
        "msec" | "milliseconds" => "ms",
        "µs" | "μs" | "usec" | "microseconds" => "us",
        "nsec" | "nanoseconds" => "ns",
        "percent" | "pct" => "%",
        "lb" | "lbs" => "lbf",
        "kg" | "kgf" => "kgf",
        "volt" | "volts" | "v" => "V",
        "pa" => "Pa",
        "kpa" => "kPa",
        "hpa" => "hPa",
        "bar" | "mbar" | "dbar" => return small,
        "n" | "newton" => "N",
        "nm" | "n*m" | "n.m" | "n·m" => "N*m",
        "knm" | "kn*m" | "kn.m" | "kn·m" => "kN*m",
        // the case tells milli from mega
        "mnm" | "mn*m" | "mn.m" | "mn·m" if plain.starts_with('m') => "mN*m",
        "norm" | "normalized" | "normalised" => "1",
        "metre" | "meter" | "metres" | "meters" => "m",
        "rpm" | "rev/min" | "1/min" => "rpm",
        "rps" | "rev/s" | "rev/sec" => "rps",
        _ => return plain,
    };
    known.to_string()
}

/// Lower-case words: split at signs, at a capital after a small letter, and between letters and digits.
fn split(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for c in name.chars() {
        let camel = before.is_lowercase() && c.is_uppercase();
        let digit = before.is_alphanumeric() && c.is_alphanumeric() && before.is_ascii_digit() != c.is_ascii_digit();
        if camel || digit || !c.is_alphanumeric() {
            words.push(String::new());
        }
        if c.is_alphanumeric() {
            words.last_mut().expect("there is one").extend(c.to_lowercase());
        }
        before = c;
    }
    words.retain(|word| !word.is_empty());
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_fall_into_words_and_units() {
        for (header, words, unit) in [
            ("yaw_deg", "yaw", Some("deg")),
            ("YawRate [deg/s]", "yaw rate", Some("deg/s")),
            ("left_cmd [%]", "left cmd", Some("%")),
            ("pwm_left_us", "pwm left", Some("us")),
            ("thruster_3", "thruster 3", None),
            ("pwm1", "pwm 1", None),
            ("rpm_2", "rpm 2", None),
            ("speed_over_ground_mps", "speed over ground", Some("m/s")),
            ("input (us)", "input", Some("us")),
            ("force (lb)", "force", Some("lbf")),
            ("time_s", "time", Some("s")),
            ("depth_m", "depth", Some("m")),
            ("s", "s", None),
            ("tau_N", "tau n", None),
            ("tauN", "tau n", None),
            ("tau_m", "tau m", None),
            ("pos_n", "pos n", None),
            ("x_pos_m", "x pos", Some("m")),
            ("tau_u_kN", "tau u", Some("kN")),
            ("Mz [kNm]", "mz", Some("kN*m")),
            ("Mz [kN*m]", "mz", Some("kN*m")),
            ("n1 [rev/s]", "n 1", Some("rps")),
            ("field.twist.twist.linear.x", "field twist twist linear x", None),
        ] {
            let found = of(header);
            assert_eq!((found.words.join(" ").as_str(), found.unit.as_deref()), (words, unit), "{header}");
        }
    }
}
