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

use super::codes;
use super::factor::{Meaning, RATE, meaning};
use super::fit::{Fit, fit};
use super::lag::{self, Lag};
use super::report::{Agreement, FaultKind, Found};
use super::samples::{Samples, windows};
use crate::frame::Dof;
use crate::log::number::short;
use crate::run::Run;

/// Shortest window, s.
pub(super) const WINDOW: f64 = 0.5;
/// Least ratio of the variance of the integrated rate to that of its noise: below it noise would
/// bias c towards zero.
pub const CLEAR: f64 = 50.0;
/// Least share of the motion of the angle that the rate must explain.
const EXPLAINED: f64 = 0.7;

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
    let step = angle.step().max(rate.step());
    let width = WINDOW.max(2.0 * step);
    let level = level_windows(run);
    let still: Vec<_> = windows(&[&angle, &rate], width, 0.0).into_iter().filter(&level).collect();
    let column = |s: &Samples, w: &[(f64, f64)], late: f64| -> Vec<f64> {
        w.iter().map(|(a, b)| s.integral(a - late, b - late)).collect()
    };
    let at = |w: &[(f64, f64)], late: f64| -> Option<Fit> {
        let target: Vec<f64> = w.iter().map(|(a, b)| angle.at(*b) - angle.at(*a)).collect();
        let length: Vec<f64> = w.iter().map(|(a, b)| b - a).collect();
        let (mine, rest) = (column(&own, w, late), column(&others, w, late));
        let visible = rest.iter().map(|x| x * x).sum::<f64>() > 1e-4 * mine.iter().map(|x| x * x).sum::<f64>();
        if visible { fit(&[&mine, &length, &rest], &target) } else { fit(&[&mine, &length], &target) }
    };
    if !clear(&column(&own, &still, 0.0), rate.noise() * (rate.step() * width).sqrt()) {
        return None;
    }
    let inner: Vec<_> = windows(&[&angle, &rate], width, lag::REACH).into_iter().filter(&level).collect();
    // a positive lag of the angle: it shows at t what the rate showed at t − d
    let lag = lag::least(0.05, |d| at(&inner, d).map(|f| (f.cost, f.rows - f.theta.len())));
    let best = match lag {
        Some(Lag { seconds, .. }) if seconds.abs() > 0.5 * step => at(&inner, seconds)?,
        _ => at(&still, 0.0)?,
    };
    let c = best.theta[0];
    if best.explained < EXPLAINED || c == 0.0 {
        return None;
    }
    Some(Agreement {
        channel: dof.velocity().to_string(),
        against: format!("d({})/dt", dof.position()),
        factor: 1.0 / c,
        std: best.std[0] / (c * c),
        angle: None,
        lag: lag.filter(|l| l.std < 0.2),
    })
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

/// Whether the variance of a column is clearly above that of its noise.
pub fn clear(column: &[f64], noise: f64) -> bool {
    let mean = column.iter().sum::<f64>() / column.len().max(1) as f64;
    let variance = column.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / column.len().max(1) as f64;
    variance > CLEAR * noise * noise && variance > 0.0
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
        if let Some(lag) = a.lag.filter(|l| l.is_clear(5.0, (0.75 * slowest).max(0.05))) {
            let (late, early) = if lag.seconds > 0.0 { (angle, r) } else { (r, angle) };
            let seconds = lag.seconds.abs();
            let text = format!(
                "{late} lags {early} by {} ± {} s: latency of its sensor or its time stamps",
                short(seconds, 3),
                short(2.0 * lag.std, 2)
            );
            found.push(Found::new(&codes::LATENCY, &channels, text).fault(FaultKind::Delay, late, seconds));
        }
    }
    found
}
