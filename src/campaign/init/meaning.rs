//! The meaning of a column by its name: phrases of pilots, autopilots and ROS for the channels of a
//! log.

use super::units;
use super::words::Words;
use crate::effects::id;
use crate::frame::Dof;
use crate::log::columns::{self, Quantity};

/// A channel that a name may mean.
#[derive(Debug, Clone, PartialEq)]
pub struct Meaning {
    /// Canonical name.
    pub channel: &'static str,
    /// −1 if the name says that the quantity counts the other way, as a height does.
    pub sign: i8,
    /// How well the name fits; 100: exactly.
    pub score: usize,
}

/// Channel, sign, phrases separated by commas.
type Phrases = (&'static str, i8, &'static str);

const PHRASES: &[Phrases] = &[
    (
        "t",
        1,
        "t, time, stamp, timestamp, time stamp, elapsed, elapsed time, clock, date time, date, utc, \
         time boot, header stamp, seconds, sec, zeit, 時刻, 時間",
    ),
    (
        "x",
        1,
        "x, eta x, x 0, north, northing, pos x, x pos, position x, x position, x carriage, carriage x, carriage position, pos n, pos north, position north, \
         pn",
    ),
    ("y", 1, "y, eta y, y 0, east, easting, pos y, y pos, position y, y position, pos e, pos east, position east, pe"),
    (
        "z",
        1,
        "z, eta z, z 0, depth, down, pos z, z pos, position z, z position, pos d, pos down, position down, pd, \
         tiefe, tauchtiefe, 深度, 水深",
    ),
    ("z", -1, "height, up, pos up, elevation"),
    ("phi", 1, "phi, roll, roll angle, bank, eta phi, orientation roll, euler roll, attitude roll, rollwinkel"),
    ("theta", 1, "theta, pitch, pitch angle, eta theta, orientation pitch, euler pitch, attitude pitch, nickwinkel"),
    (
        "psi",
        1,
        "psi, yaw, yaw angle, heading, heading angle, hdg, compass, compass heading, true heading, \
         kurs, kurswinkel, gierwinkel, 方位角, 船首方位, ヨー角, eta psi, orientation yaw, euler yaw, attitude yaw",
    ),
    (
        "u",
        1,
        "u, nu u, surge, surge vel, surge velocity, surge speed, vel surge, velocity surge, forward vel, \
         forward velocity, forward speed, vel forward, vx, v x, vel x, x vel, velocity x, x velocity, \
         speed x, linear x, linear velocity x, twist linear x, longitudinal velocity, longitudinal \
         speed, speed through water, velocity through water, u through water, stw, fwd vel, fwd velocity, fwd speed, vel fwd, \
         carriage speed, carriage velocity, tow speed, towing speed, geschwindigkeit x, laengsgeschwindigkeit, längsgeschwindigkeit, 前進速度",
    ),
    (
        "v",
        1,
        "v, nu v, vm, sway, sway vel, sway velocity, sway speed, vel sway, velocity sway, lateral vel, lateral \
         velocity, lateral speed, vy, v y, vel y, y vel, velocity y, y velocity, speed y, linear y, \
         linear velocity y, twist linear y, starboard velocity, lat vel, lat velocity, \
         lat speed, vel lat, geschwindigkeit y, vel stbd, stbd vel, stbd velocity, vel starboard, starboard vel, starboard speed, \
         vel right, right vel, right velocity, quergeschwindigkeit, 横速度",
    ),
    ("w", -1, "vel up, up vel, up velocity, up speed, velocity up, steiggeschwindigkeit"),
    ("v", -1, "vel left, left vel, left velocity, vel port, port velocity"),
    (
        "w",
        1,
        "w, nu w, heave, heave vel, heave velocity, heave speed, vel heave, velocity heave, vz, v z, vel z, \
         z vel, velocity z, z velocity, speed z, linear z, linear velocity z, twist linear z, down \
         velocity, down vel, vel down, velocity down, down speed, geschwindigkeit z, tauchgeschwindigkeit, sinkgeschwindigkeit, 上下速度",
    ),
    (
        "p",
        1,
        "p, nu p, roll rate, rollrate, roll speed, rollspeed, roll vel, gyro x, gyr x, gyrx, gx, wx, w x, omega \
         x, angular x, angular velocity x, angular rate x, rate x, twist angular x, phi dot, wankrate",
    ),
    (
        "q",
        1,
        "q, nu q, pitch rate, pitchrate, pitch speed, pitchspeed, pitch vel, gyro y, gyr y, gyry, gy, wy, w y, \
         omega y, angular y, angular velocity y, angular rate y, rate y, twist angular y, theta dot, nickrate",
    ),
    (
        "r",
        1,
        "r, nu r, yaw rate, yawrate, yaw speed, yawspeed, yaw vel, yaw velocity, heading rate, turn rate, \
         rate of turn, rot, gyro z, gyr z, gyrz, gz, drehrate, gierrate, giergeschwindigkeit, 角速度, 回頭角速度, ヨー角速度, wz, w z, omega z, angular z, angular velocity z, \
         angular rate z, rate z, twist angular z, psi dot",
    ),
    ("r", -1, "yaw rate ccw, yawrate ccw"),
    (
        "tau_u",
        1,
        "tau u, tau x, force x, fx, x force, surge force, force surge, tau surge, thrust x, surge \
         thrust, thrust surge, wrench force x, kraft x, schub x, x kraft, vortriebskraft, 推力 x, 推力x",
    ),
    (
        "tau_v",
        1,
        "tau v, tau y, force y, fy, y force, sway force, force sway, tau sway, thrust y, sway thrust, \
         thrust sway, wrench force y, kraft y, schub y, y kraft, querkraft, 推力 y, 推力y",
    ),
    (
        "tau_w",
        1,
        "tau w, tau z, force z, fz, z force, heave force, force heave, tau heave, thrust z, heave \
         thrust, thrust heave, wrench force z, kraft z, schub z, z kraft",
    ),
    (
        "tau_p",
        1,
        "tau p, tau k, tau phi, torque x, moment x, mx, roll moment, roll torque, moment roll, torque roll, tau roll, \
         wrench torque x, rollmoment, moment um x",
    ),
    (
        "tau_q",
        1,
        "tau q, tau m, tau theta, torque y, moment y, my, pitch moment, pitch torque, moment pitch, torque pitch, \
         tau pitch, wrench torque y, nickmoment, moment um y",
    ),
    (
        "tau_r",
        1,
        "tau r, tau n, tau psi, torque z, moment z, mz, yaw moment, yaw torque, moment yaw, torque yaw, tau yaw, \
         wrench torque z, nz, giermoment, moment um z, モーメント n, モーメントn, 回頭モーメント",
    ),
    (
        "load_u",
        1,
        "load u, load x, load surge, load cell x, load cell surge, loadcell x, tow force, towing force, tow resistance, bollard pull, \
         kraftmessdose x",
    ),
    ("load_v", 1, "load v, load y, load sway, load cell y, load cell sway, loadcell y, kraftmessdose y"),
    ("load_w", 1, "load w, load z, load heave, load cell z, load cell heave, loadcell z, kraftmessdose z"),
    ("load_r", 1, "load r, load n, load yaw, load cell n, load cell yaw, load moment z"),
    (
        "supply_V",
        1,
        "supply, supply v, supply voltage, voltage, battery, battery voltage, battery v, bat volt, \
         batt volt, batt v, batt voltage, vbat, volt, bus voltage",
    ),
    ("latitude", 1, "latitude, lat, breite"),
    ("longitude", 1, "longitude, lon, lng, laenge"),
    ("v_north", 1, "vel north, north vel, velocity north, north velocity, speed north, vn, v n, vel n, velocity n"),
    ("v_east", 1, "vel east, east vel, velocity east, east velocity, speed east, ve, v e, vel e, velocity e"),
    ("qw", 1, "qw, q w, quat w, quaternion w, orientation w, q 0, quat 0, quaternion 0"),
    ("qx", 1, "qx, q x, quat x, quaternion x, orientation x, q 1, quat 1, quaternion 1"),
    ("qy", 1, "qy, q y, quat y, quaternion y, orientation y, q 2, quat 2, quaternion 2"),
    ("qz", 1, "qz, q z, quat z, quaternion z, orientation z, q 3, quat 3, quaternion 3"),
    ("rudder", 1, "rudder, rudder angle, rudder deg, delta, delta r, delta rudder, rudder delta, helm, helm angle"),
    (
        "stern_plane",
        1,
        "stern plane, sternplane, stern plane angle, elevator, elevator angle, pitch fin, delta s, delta e",
    ),
    ("propeller_n", 1, "propeller n, prop n, propeller revolution, propeller revolutions, shaft speed"),
    (
        "apparent_wind_speed",
        1,
        "apparent wind speed, apparent wind, relative wind speed, relative wind, wind speed apparent, wind speed relative, \
         aws, u a",
    ),
    (
        "apparent_wind_angle",
        1,
        "apparent wind angle, apparent wind direction, apparent wind dir, relative wind angle, relative wind direction, \
         relative wind dir, wind angle, wind angle apparent, wind angle relative, awa, gamma a",
    ),
    (
        "wind_speed",
        1,
        "wind speed, true wind speed, wind, true wind, wind velocity, wind vel, tws, vw, v w, u t, windgeschwindigkeit",
    ),
    ("wind_dir", 1, "wind direction, wind dir, true wind direction, true wind dir, twd, gamma t, windrichtung"),
    ("wind_from", 1, "wind from, wind direction from, wind from direction"),
    ("wind_to", 1, "wind to, wind direction to, wind to direction, wind toward, wind towards"),
];

/// Names that may mean a channel or something else: used only if no better name is there.
const DOUBTFUL: &[Phrases] = &[
    ("u", 1, "speed, sog, speed over ground, ground speed, gps speed, velocity, log speed, geschwindigkeit, fahrt"),
    ("z", 1, PRESSURE),
    // a DVL's altitude is the height above the bottom
    ("z", -1, "altitude, alt"),
    ("psi", 1, "course, cog, course over ground, track"),
];

/// Names of the water pressure, which is a depth if its unit is stated.
const PRESSURE: &str = "pressure, water pressure, sea pressure, depth pressure, ctd pressure";
const PRESSURES: [&str; 6] = ["Pa", "hPa", "mbar", "kPa", "dbar", "bar"];

/// Words that say where a quantity comes from, not what it is.
const FILLERS: &str = "field data vehicle robot auv rov usv asv boat body imu ahrs dvl ekf ins nav odom odometry pose twist \
    state est estimated estimate meas measured filtered filt sensor value msg current actual log file gps \
    gnss mocap xkf att local wrench vector math";

/// Words of desired values, of quality, or of other quantities.
const OTHERS: &str = "setpoint sp desired des demand target ref reference goal cov covariance var variance std \
    error err status flag valid temp temperature accel acceleration acc mag bias seq id count nsecs nsec nanosec";

/// Words that mean a command.
const COMMANDED: &str = "cmd command commanded order ordered";

/// Symbols of forces and moments by SNAME, which count only with such a unit.
const SYMBOLS: [(&str, &str, &str); 6] = [
    ("x", "N", "tau_u"),
    ("y", "N", "tau_v"),
    ("z", "N", "tau_w"),
    ("k", "N*m", "tau_p"),
    ("m", "N*m", "tau_q"),
    ("n", "N*m", "tau_r"),
];

/// A force or moment by its symbol and unit, `X [N]`.
fn by_symbol(words: &Words) -> Option<Meaning> {
    let ([symbol], Some(unit)) = (&words.words[..], &words.unit) else { return None };
    let of = |usual: &str| units::is_read(if usual == "N" { Quantity::Force } else { Quantity::Moment }, unit);
    let (.., channel) = SYMBOLS.iter().find(|(name, usual, _)| name == symbol && of(usual))?;
    Some(Meaning { channel, sign: 1, score: 100 })
}

/// A force or moment by the degree of freedom that is commanded, `cmd_surge`.
fn by_degree_of_freedom(words: &[String], unit: Option<&str>) -> Option<Meaning> {
    let [word] = words else { return None };
    let dof = Dof::ALL.into_iter().find(|dof| dof.to_string() == *word)?;
    let quantity = columns::quantity(dof.force())?;
    let is_force = unit.is_none_or(|unit| units::is_read(quantity, unit) || units::is_part(unit));
    is_force.then_some(Meaning { channel: dof.force(), sign: 1, score: BY_DEGREE_OF_FREEDOM })
}

/// Score from which on a name is unambiguous.
pub const PLAIN: usize = 90;
/// Score of a command that is named by its degree of freedom.
pub const BY_DEGREE_OF_FREEDOM: usize = PLAIN - 1;

/// The possible meanings of a header's words, best first.
pub fn of(words: &Words) -> Vec<Meaning> {
    if let Some(force) = by_symbol(words) {
        return vec![force];
    }
    // a commanded force is the force of a model, and an ordered rudder is used if no log measures
    // its angle; any other command is a desired value, not a measurement
    if words.words.iter().any(|w| has(COMMANDED, w)) {
        let left: Vec<String> = words.words.iter().filter(|w| !has(COMMANDED, w)).cloned().collect();
        if let Some(force) = by_degree_of_freedom(&left, words.unit.as_deref()) {
            return vec![force];
        }
        let mut forces = of(&Words { words: left, unit: words.unit.clone() });
        forces.retain(|m| is_force(m) || is_fin(m));
        forces.iter_mut().filter(|m| is_fin(m)).for_each(|m| m.score = m.score.min(PLAIN - 1));
        return forces;
    }
    // the "lat" of a speed is lateral, not latitude
    let speed = words.words.iter().any(|w| ["speed", "vel", "velocity"].contains(&w.as_str()));
    if words.words.iter().any(|w| has(OTHERS, w) && !(speed && w == "lat")) {
        return Vec::new();
    }
    let whole = words.words.join(" ");
    let bare = bare(&words.words);
    let mut found: Vec<Meaning> = Vec::new();
    for (table, off) in [(PHRASES, 0), (DOUBTFUL, 40)] {
        for (channel, sign, phrases) in table {
            if *phrases == PRESSURE && !words.unit.as_deref().is_some_and(|unit| PRESSURES.contains(&unit)) {
                continue;
            }
            let best = phrases.split(", ").map(|phrase| fits(phrase, &whole, &bare)).max().unwrap_or(0);
            if best > off {
                found.push(Meaning { channel, sign: *sign, score: best - off });
            }
        }
    }
    // a Doppler log measures velocities along its axes
    if words.words.iter().any(|w| w == "dvl")
        && !is_length(words)
        && let Some((_, channel)) = ALONG_AXES.iter().find(|(axis, _)| bare == *axis)
    {
        found.clear();
        found.push(Meaning { channel, sign: 1, score: PLAIN });
    }
    found.sort_by_key(|m| std::cmp::Reverse(m.score));
    found
}

/// Velocities along the axes of the body.
const ALONG_AXES: [(&str, &str); 3] = [("x", "u"), ("y", "v"), ("z", "w")];

/// Whether the unit of a column says that it is a length.
fn is_length(words: &Words) -> bool {
    words.unit.as_deref().is_some_and(|unit| units::is_read(Quantity::Position, unit))
}

fn is_force(meaning: &Meaning) -> bool {
    meaning.channel.starts_with("tau_")
}

fn is_fin(meaning: &Meaning) -> bool {
    id::fins().iter().any(|fin| fin.channel == meaning.channel)
}

/// The words without those of the source and their numbers: `imu1_yaw` is a yaw.
fn bare(words: &[String]) -> String {
    let is_number = |word: &str| word.bytes().all(|b| b.is_ascii_digit());
    let mut kept: Vec<&str> = Vec::new();
    let mut after_source = false;
    for word in words.iter().map(String::as_str) {
        let source = is_filler(word);
        if !(source || after_source && is_number(word)) {
            kept.push(word);
        }
        after_source = source;
    }
    kept.join(" ")
}

/// Whether a word says where a quantity comes from, not what it is.
pub fn is_filler(word: &str) -> bool {
    has(FILLERS, word)
}

/// Whether a list of words holds this one.
fn has(list: &str, word: &str) -> bool {
    list.split(' ').any(|w| w == word)
}

/// The score of a phrase; 100: the phrase alone; 90: beside words of its source; 55 to 70: several
/// words, or one of more than three letters, among other words.
fn fits(phrase: &str, whole: &str, bare: &str) -> usize {
    if whole == phrase {
        return 100;
    }
    if bare == phrase {
        return 90;
    }
    let inside = format!(" {bare} ").contains(&format!(" {phrase} "));
    match (inside, phrase.split(' ').count(), phrase.len()) {
        (true, 1, ..=3) | (false, ..) => 0,
        (true, words, _) => 50 + 5 * words.min(4),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::init::words;

    #[test]
    fn names_of_pilots_and_programs_are_understood() {
        for (header, channel) in [
            ("time", "t"),
            ("%time", "t"),
            ("heading", "psi"),
            ("yaw_deg", "psi"),
            ("surge_vel", "u"),
            ("YawRate", "r"),
            ("north", "x"),
            ("depth_m", "z"),
            ("pressure_bar", "z"),
            ("cmd_force_x", "tau_u"),
            ("X [N]", "tau_u"),
            ("N (Nm)", "tau_r"),
            ("vel_north", "v_north"),
            ("CTD pressure [dbar]", "z"),
            ("field.twist.twist.linear.x", "u"),
            ("field.pose.pose.position.y", "y"),
            ("field.angular_velocity.z", "r"),
            ("imu_gyro_z", "r"),
            ("sog_mps", "u"),
            ("battery_voltage", "supply_V"),
            ("surge_force [N]", "tau_u"),
            ("Fwd speed (kn)", "u"),
            ("Lat speed (kn)", "v"),
            ("vel_left", "v"),
            ("gz", "r"),
            ("lat", "latitude"),
            ("GPS.Lng", "longitude"),
            ("lon_deg", "longitude"),
            ("pose.pose.orientation.w", "qw"),
            ("q0", "qw"),
            ("quat_z", "qz"),
            ("pos_n", "x"),
            ("Drehrate [°/s]", "r"),
            ("tau_N", "tau_r"),
            ("tauN", "tau_r"),
            ("TAU_N", "tau_r"),
            ("tau_psi", "tau_r"),
            ("torqueYaw", "tau_r"),
            ("tauX", "tau_u"),
            ("X [kN]", "tau_u"),
            ("nu_u", "u"),
            ("nu_v", "v"),
            ("nu_r", "r"),
            ("eta_x", "x"),
            ("eta_psi", "psi"),
            ("imu1_yaw", "psi"),
            ("imu.orientation.yaw", "psi"),
            ("v_n", "v_north"),
            ("x0", "x"),
            ("vm", "v"),
            ("delta [deg]", "rudder"),
            ("rudder_cmd", "rudder"),
            ("wind speed [m/s]", "wind_speed"),
            ("true_wind_direction", "wind_dir"),
            ("AWA", "apparent_wind_angle"),
            ("Apparent wind speed (m/s)", "apparent_wind_speed"),
            ("U_T", "wind_speed"),
            ("Schub_x", "tau_u"),
            ("Giermoment", "tau_r"),
            ("Geschwindigkeit_y", "v"),
            ("vel_stbd", "v"),
            ("推力X[N]", "tau_u"),
            ("角速度[deg/s]", "r"),
            ("cmd_surge", "tau_u"),
            ("cmd_yaw", "tau_r"),
            ("DVL_X", "u"),
            ("dvl_z [mm/s]", "w"),
            ("dvl_x [m]", "x"),
            ("dvl_pos_x", "x"),
        ] {
            assert_eq!(of(&words::of(header)).first().map(|m| m.channel), Some(channel), "{header}");
        }
        assert_eq!(of(&words::of("altitude"))[0].sign, -1);
        assert_eq!(of(&words::of("vel_left"))[0].sign, -1);
        for other in ["yaw_setpoint", "motor_temp", "pitch_cov", "seq", "cmd_surge [m/s]", "yaw_cmd [deg]"] {
            assert!(of(&words::of(other)).is_empty(), "{other}");
        }
    }
}
