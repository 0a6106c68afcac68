//! Body rates compared with angles: unit, sign, scale and lag of the gyros.
//!
//! ```text
//! ψ(b) − ψ(a) = c ∫ (r cos φ + q sin φ)/cos θ dt + β (b − a)        f = 1/c = logged rate over dψ/dt
//! φ(b) − φ(a) = c ∫ (p + tan θ (q sin φ + r cos φ)) dt + β (b − a)
//! θ(b) − θ(a) = c ∫ (q cos φ − r sin φ) dt + β (b − a)
//! ```
//!
//! over windows [a, b]; β is a constant bias of the gyro, rad/s. Missing angles and rates count as
//! zero. Source: Fossen, *Handbook of Marine Craft Hydrodynamics and Motion Control* (2011),
//! (2.28). In the fit of an angle the integral of its own rate is one column; the contribution of
//! the other two rates is a second column with its own coefficient.

use super::change::Change;
use super::codes;
use super::factor::{Meaning, RATE, meaning};
use super::lag;
use super::report::{Agreement, FaultKind, Found};
use super::samples::Samples;
use crate::frame::Dof;
use crate::log::number::short;
use crate::run::Run;

/// Shortest window, s.
pub(super) const WINDOW: f64 = 0.5;
/// |sin θ| of 60°, from which on rates and Euler angles can hardly be compared.
const STEEP: f64 = 0.866;

/// Returns the agreement of each rate with its angle.
pub fn measure(run: &Run) -> Vec<Agreement> {
    [Dof::Roll, Dof::Pitch, Dof::Yaw].into_iter().filter_map(|dof| agreement(run, dof)).collect()
}

fn agreement(run: &Run, dof: Dof) -> Option<Agreement> {
    let angle = Samples::of_angle(run.signal(dof.position())?)?;
    let rate = Samples::of(run.signal(dof.velocity())?)?;
    let (own, others) = kinematics(run, dof, &rate);
    let (velocity, position) = ((dof.velocity(), &rate), (dof.position(), &angle));
    Change { velocity, position, own, others, window: WINDOW }.agreement(level_windows(run))
}

/// Returns a test whether the pitch stays away from the vertical in and near a window: near it φ
/// and ψ jump, and their rates become infinite.
pub(super) fn level_windows(run: &Run) -> impl Fn(&(f64, f64)) -> bool {
    let theta = run.signal("theta").and_then(Samples::of_angle);
    // a pitch in degrees cannot be used here
    let theta = theta.filter(|theta| theta.values().iter().all(|x| x.abs() < 1.6));
    move |(a, b)| {
        let Some(theta) = &theta else { return true };
        let (from, to) = (a - lag::REACH, b + lag::REACH);
        let samples = theta.time().iter().zip(theta.values());
        let mut inside = samples.skip_while(|(t, _)| **t < from).take_while(|(t, _)| **t <= to);
        inside.all(|(_, x)| x.sin().abs() < STEEP)
    }
}

/// Returns the rate of the angle due to its own body rate, and due to the other two, at the
/// instants of the own rate.
pub(super) fn kinematics(run: &Run, dof: Dof, rate: &Samples) -> (Samples, Samples) {
    let angle = |name: &str| run.signal(name).and_then(Samples::of_angle);
    let other = |name: &str| run.signal(name).and_then(Samples::of);
    let (phi, theta) = (angle("phi"), angle("theta"));
    let (q, r) = (other("q"), other("r"));
    let get = |s: &Option<Samples>, t: f64| s.as_ref().map_or(0.0, |s| s.at(t));
    let roll = |t: f64| get(&phi, t).sin_cos();
    // the yaw rate is undefined at a pitch of 90°; this check means nothing near it
    let level = |t: f64| get(&theta, t).cos().abs().max(0.1);
    let own = rate.map(|t, x| match dof {
        Dof::Yaw => x * roll(t).1 / level(t),
        Dof::Pitch => x * roll(t).1,
        _ => x,
    });
    let others = rate.map(|t, _| match dof {
        Dof::Yaw => get(&q, t) * roll(t).0 / level(t),
        Dof::Pitch => -get(&r, t) * roll(t).0,
        _ => get(&theta, t).sin() / level(t) * (get(&q, t) * roll(t).0 + get(&r, t) * roll(t).1),
    });
    (own, others)
}

/// Returns the findings; a wrong unit is that of the rate or of the angle. `steps` gives the usual
/// step of a channel, s.
pub fn judge(agreements: &[Agreement], steps: impl Fn(&str) -> f64) -> Vec<Found> {
    let mut found = Vec::new();
    for a in agreements {
        let (r, rate) = (a.channel.as_str(), format!("{} ± {}", short(a.factor, 4), short(a.std, 2)));
        let angle = a.against.trim_start_matches("d(").trim_end_matches(")/dt");
        let channels = [r, angle];
        match meaning(a.factor, a.std, 0.1, RATE) {
            Meaning::Agrees | Meaning::Unknown => {}
            Meaning::Reversed => {
                let text = format!(
                    "{r} is {rate} times {}: one of the two has the opposite sign; check body_frame and earth_frame, \
                     or set columns.{r}.sign = -1",
                    a.against
                );
                found.push(Found::new(&codes::SIGN, &channels, text).fault(FaultKind::Sign, r, -1.0));
            }
            // the angle is in degrees: no unit of the rate makes the ratio this small
            Meaning::Unit(_, factor, reversed) if factor.abs() < 1.0 => {
                let sign = if reversed { ", and one of the two has the opposite sign" } else { "" };
                let text = format!(
                    "{r} is {rate} times {}: most likely {angle} is in deg{sign}; set columns.{angle}.unit = \"deg\"",
                    a.against
                );
                found.push(Found::new(&codes::UNIT, &channels, text).fault(FaultKind::Unit, angle, 1.0 / factor));
            }
            Meaning::Unit(name, factor, reversed) => {
                let sign = if reversed { ", and its sign is opposite" } else { "" };
                let text = format!(
                    "{r} is {rate} times {}: most likely {r} is in {name}{sign}; set columns.{r}.unit",
                    a.against
                );
                found.push(Found::new(&codes::UNIT, &channels, text).fault(FaultKind::Unit, r, factor));
            }
            Meaning::Scale => {
                let text =
                    format!("{r} is {rate} times {}: no unit explains this factor; check the calibration", a.against);
                found.push(Found::new(&codes::SCALE, &channels, text).fault(FaultKind::Unit, r, a.factor));
            }
        }
        let slowest = steps(r).max(steps(angle));
        found.extend(lag::latency(a.lag, [r, angle], (0.75 * slowest).max(0.05), &channels));
    }
    found
}
