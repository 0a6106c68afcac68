//! Velocity compared with position: units, signs, axes and lag of the velocity sensor.
//!
//! ```text
//! Δ(x, y) = ∫ R(±ψ) G (u, v) dt + c (b − a) + ΔR(±ψ) l    G = [ g₁₁ g₁₂ ]   = [ a_u cos α_u   −a_v sin α_v ]
//!                                                             [ g₂₁ g₂₂ ]     [ a_u sin α_u    a_v cos α_v ]
//! ```
//!
//! over windows [a, b]. c is the current (m/s) if the velocity is measured relative to the water. l
//! is the lever arm from the velocity sensor to the position sensor, m; it is part of the fit if
//! the vehicle turns and the fit is far better with it: an antenna ahead of the origin swings
//! sideways, which otherwise looks like a wrong sign or a turned sensor. G = 1 if all agree: a_u,
//! a_v are scales, α_u, α_v the angles (rad) by which each axis is turned. A misalignment of the
//! sensor and an offset of the heading cannot be distinguished here. −ψ with det G < 0 means that x
//! and y are swapped or one of them is reversed, −ψ with det G > 0 that the heading has the wrong
//! sense. ±57.3 ψ or ±ψ/57.3, if only that fits, means a heading in another unit. Roll and pitch,
//! if logged, are used to project the velocity on the horizontal plane first.
//!
//! If no sense of ψ fits although the speeds are alike, |Δ(x, y)| ≈ |∫ R(ψ) (u, v) dt|, the heading
//! contradicts the path. A current is part of every fit and therefore no contradiction.

use std::f64::consts::PI;

use super::change::clear;
use super::codes;
use super::factor::{Meaning, VELOCITY, meaning};
use super::fit::{Fit, fit};
use super::lag;
use super::report::{Agreement, FaultKind, Found};
use super::samples::{Samples, windows};
use crate::log::number::short;
use crate::run::Run;

/// Shortest window, s: long compared with the noise of a position, short compared with the motion.
const WINDOW: f64 = 2.0;
/// Least range of the heading, rad, for a test of its sense and unit and of a lever arm.
const TURNED: f64 = 0.5;
/// Least share of the displacement that must be explained.
const EXPLAINED: f64 = 0.5;
/// Share of the displacement explained above which the unit of the heading is not questioned.
const WELL_EXPLAINED: f64 = 0.9;
/// Least share of the distance covered (sum of squares) that velocities of the same size explain:
/// pure noise about a slow path gives 0.79.
const ALIKE: f64 = 0.9;
/// Largest ratio of the cost with a lever arm to that without, at which there is an arm: the arm then
/// explains as much as remains unexplained.
const ARM: f64 = 0.5;
/// Longest lever arm that a vehicle has, m.
const LONGEST_ARM: f64 = 30.0;
/// Degrees in a radian.
const DEGREES: f64 = 180.0 / PI;

/// Result of comparing velocity, heading and position.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Scale and angle of each velocity that moves enough: u, v.
    pub agreements: Vec<Agreement>,
    /// Whether the position fits the heading with its sense reversed.
    pub mirrored: bool,
    /// Factor by which the heading turns too far: 57.3 if degrees are taken for radians, 1/57.3 in
    /// the opposite case, else 1.
    pub turns: f64,
    /// Whether the velocities are as fast as the position, but no sense of the heading turns them
    /// into its direction.
    pub contradicted: bool,
    /// Names of the two channels of the position.
    pub position: [String; 2],
    /// Place of the position sensor ahead and to starboard of the velocity sensor, m, each with its
    /// standard deviation; `None` without a lever arm.
    pub arm: Option<[(f64, f64); 2]>,
}

/// Velocities turned to earth axes by the heading: north and east of each.
struct ToEarth {
    moving: Vec<[Samples; 2]>,
    still: Option<[Samples; 2]>,
}

/// A fit with the heading multiplied by a factor.
struct Sense {
    factor: f64,
    fit: Fit,
    earth: ToEarth,
    /// Whether the fit has a lever arm.
    armed: bool,
}

/// Compares velocity, heading and position; `None` without heading, position or motion.
pub fn measure(run: &Run, position: [&str; 2]) -> Option<Path> {
    let psi = Samples::of_angle(run.signal("psi")?)?;
    let x = Samples::of(run.signal(position[0])?)?;
    let y = Samples::of(run.signal(position[1])?)?;
    let get = |name: &str| run.signal(name).and_then(Samples::of);
    let angle = |name: &str| run.signal(name).and_then(Samples::of_angle);
    let [u, v, w] = ["u", "v", "w"].map(get);
    let (phi, theta) = (angle("phi"), angle("theta"));
    let at = |s: &Option<Samples>, t: f64| s.as_ref().map_or(0.0, |s| s.at(t));
    let step = [Some(&x), Some(&psi), u.as_ref(), v.as_ref()].into_iter().flatten().map(Samples::step);
    let width = WINDOW.max(4.0 * step.fold(0.0, f64::max));
    let mut all = vec![&x, &y, &psi];
    all.extend(u.iter().chain(&v));
    // velocities projected on the horizontal plane by roll and pitch; forward includes its share of heave
    let forward = u.as_ref().map(|u| {
        u.map(|t, u| {
            let ((sp, cp), (st, ct)) = (at(&phi, t).sin_cos(), at(&theta, t).sin_cos());
            u * ct + if v.is_some() { at(&v, t) * sp * st } else { 0.0 } + at(&w, t) * cp * st
        })
    });
    let starboard = v.as_ref().map(|v| v.map(|t, v| v * at(&phi, t).cos() - at(&w, t) * at(&phi, t).sin()));
    let inner = windows(&all, width, 0.0);
    let (from, _) = *inner.first()?;
    let (low, high) =
        psi.values().iter().map(|p| p - psi.at(from)).fold((0.0f64, 0.0f64), |r, p| (r.0.min(p), r.1.max(p)));
    let moves = |s: &Samples| {
        let column: Vec<f64> = inner.iter().flat_map(|(a, b)| [s.integral(*a, *b), 0.0]).collect();
        clear(&column, s.noise() * (s.step() * width).sqrt())
    };
    let moving: Vec<(&str, &Samples, f64)> = [("u", forward.as_ref(), 0.0), ("v", starboard.as_ref(), PI / 2.0)]
        .into_iter()
        .filter_map(|(name, s, turn)| Some((name, s.filter(|s| moves(s))?, turn)))
        .collect();
    let first = moving.first()?;
    let quiet = if moving.len() == 2 { None } else { [&forward, &starboard][usize::from(first.0 == "u")].as_ref() };
    let quiet_turn = if first.0 == "u" { PI / 2.0 } else { 0.0 };

    // velocity `s` turned to earth axes, (north, east), for the columns of its two coefficients;
    // the same for every lag
    let turned = |sense: f64| {
        let earth = |s: &Samples, turn: f64| {
            let along = s.map(|t, s| s * (sense * psi.at(t) + turn).cos());
            let across = s.map(|t, s| s * (sense * psi.at(t) + turn).sin());
            [along, across]
        };
        let moving = moving.iter().map(|(_, s, turn)| earth(s, *turn)).collect();
        ToEarth { moving, still: quiet.map(|s| earth(s, quiet_turn)) }
    };
    // `arm`: factor of the heading in the columns of the lever arm; `None` for a fit without them
    let fit_armed = |ToEarth { moving, still }: &ToEarth, late: f64, windows: &[(f64, f64)], arm: Option<f64>| {
        let width = 2 * moving.len() + 2 + if arm.is_some() { 2 } else { 0 };
        let (mut target, mut columns) = (Vec::new(), vec![Vec::new(); width]);
        for (a, b) in windows {
            let (from, to) = (a - late, b - late);
            let over = |[along, across]: &[Samples; 2]| [along.integral(from, to), across.integral(from, to)];
            let carried = still.as_ref().map_or([0.0; 2], over);
            let areas: Vec<[f64; 2]> = moving.iter().map(over).collect();
            let turned = arm.map(|sense| {
                let ((sa, ca), (sb, cb)) = ((sense * psi.at(*a)).sin_cos(), (sense * psi.at(*b)).sin_cos());
                [cb - ca, sb - sa]
            });
            for (axis, p) in [&x, &y].into_iter().enumerate() {
                target.push(p.at(*b) - p.at(*a) - carried[axis]);
                for (k, [c, s]) in areas.iter().enumerate() {
                    columns[2 * k].push(if axis == 0 { *c } else { *s });
                    columns[2 * k + 1].push(if axis == 0 { -s } else { *c });
                }
                let n = 2 * moving.len();
                columns[n].push(if axis == 0 { b - a } else { 0.0 });
                columns[n + 1].push(if axis == 1 { b - a } else { 0.0 });
                if let Some([c, s]) = turned {
                    columns[n + 2].push(if axis == 0 { c } else { s });
                    columns[n + 3].push(if axis == 0 { -s } else { c });
                }
            }
        }
        fit(&columns.iter().map(Vec::as_slice).collect::<Vec<_>>(), &target)
    };
    let turns_by = |factor: f64| (high - low) * f64::abs(factor);
    // the fit, and whether it has a lever arm
    let fit_with = |earth: &ToEarth, factor: f64| -> Option<(Fit, bool)> {
        let plain = fit_armed(earth, 0.0, &inner, None);
        let armed = (turns_by(factor) > TURNED).then(|| fit_armed(earth, 0.0, &inner, Some(factor))).flatten();
        let n = 2 * moving.len() + 2;
        let is_arm = |armed: &Fit| {
            let length = armed.theta[n].hypot(armed.theta[n + 1]);
            let known = (n..n + 2).any(|k| armed.theta[k].abs() > 5.0 * armed.std[k]);
            known && length < LONGEST_ARM && plain.as_ref().is_none_or(|plain| armed.cost < ARM * plain.cost)
        };
        match armed.filter(is_arm) {
            Some(armed) => Some((armed, true)),
            None => plain.map(|plain| (plain, false)),
        }
    };
    let ahead = turned(1.0);
    let (straight, armed) = fit_with(&ahead, 1.0)?;
    let as_it_is = Sense { factor: 1.0, fit: straight, earth: ahead, armed };
    let senses = [-1.0, DEGREES, -DEGREES, 1.0 / DEGREES, -1.0 / DEGREES];
    let asked = if as_it_is.fit.explained > WELL_EXPLAINED { &senses[..1] } else { &senses };
    let others = asked.iter().copied().filter(|factor| turns_by(*factor) > TURNED);
    let fitted = others.filter_map(|factor| {
        let earth = turned(factor);
        let (fit, armed) = fit_with(&earth, factor)?;
        Some(Sense { factor, fit, earth, armed })
    });
    let fits_better = |sense: &Sense| sense.fit.cost < 0.25 * as_it_is.fit.cost && sense.fit.explained > EXPLAINED;
    let better = fitted.filter(fits_better).min_by(|a, b| a.fit.cost.total_cmp(&b.fit.cost));
    let Sense { factor, fit: best, earth, armed } = better.unwrap_or(as_it_is);
    let (mirrored, turns) = (factor < 0.0, 1.0 / factor.abs());
    let position = position.map(str::to_string);
    if best.explained < EXPLAINED {
        let ways = |(a, b): &(f64, f64)| {
            let way = (x.at(*b) - x.at(*a)).hypot(y.at(*b) - y.at(*a));
            let mut swum = [0.0; 2];
            for part in earth.moving.iter().chain(&earth.still) {
                swum.iter_mut().zip(part).for_each(|(sum, axis)| *sum += axis.integral(*a, *b));
            }
            (swum[0].hypot(swum[1]), way)
        };
        let both = u.is_some() && v.is_some();
        let contradicted = both && are_alike(&inner.iter().map(ways).collect::<Vec<_>>());
        return contradicted.then(|| Path {
            agreements: Vec::new(),
            mirrored,
            turns,
            contradicted,
            position,
            arm: None,
        });
    }
    let shorter = windows(&all, WINDOW.min(1.0).max(0.5 * width), lag::REACH);
    let lag = lag::least(0.05, |d| {
        fit_armed(&earth, d, &shorter, armed.then_some(factor)).map(|f| (f.cost, f.rows - f.theta.len()))
    });
    // scales and angles of a position that comes late are those at its lag
    let step = x.step().max(moving.iter().fold(0.0, |most: f64, (_, s, _)| most.max(s.step())));
    let late = lag.filter(|lag| lag.std < 0.2 && lag.is_clear(5.0, step.max(0.1))).map(|lag| lag.seconds);
    let margined = windows(&all, width, lag::REACH);
    let at_lag = late.and_then(|late| fit_armed(&earth, late, &margined, armed.then_some(factor)));
    let best = at_lag.unwrap_or(best);
    let agreements = moving.iter().enumerate().map(|(k, (name, ..))| {
        let (g, h) = (best.theta[2 * k], best.theta[2 * k + 1]);
        let size = g.hypot(h);
        let std = best.std[2 * k].max(best.std[2 * k + 1]);
        Agreement {
            channel: (*name).to_string(),
            against: format!("d({}, {})/dt", position[0], position[1]),
            factor: 1.0 / size,
            std: std / (size * size),
            angle: Some(h.atan2(g)),
            lag: lag.filter(|l| l.std < 0.2),
        }
    });
    let agreements = agreements.collect();
    let n = 2 * moving.len() + 2;
    let arm = armed.then(|| [n, n + 1].map(|k| (best.theta[k], best.std[k])));
    Some(Path { agreements, mirrored, turns, contradicted: false, position, arm })
}

/// Whether the distances from the velocities and from the positions are alike throughout.
fn are_alike(ways: &[(f64, f64)]) -> bool {
    let sum = |f: fn(&(f64, f64)) -> f64| ways.iter().map(f).sum::<f64>();
    let (swum, both, covered) = (sum(|w| w.0 * w.0), sum(|w| w.0 * w.1), sum(|w| w.1 * w.1));
    let (scale, explained) = (both / swum, both * both / (swum * covered));
    (0.5..2.0).contains(&scale) && explained > ALIKE
}

/// Returns the findings. `steps` gives the usual step of a channel, s.
pub fn judge(path: &Path, steps: impl Fn(&str) -> f64) -> Vec<Found> {
    let [x, y] = path.position.each_ref().map(String::as_str);
    if path.contradicted {
        let text = format!(
            "u and v are as fast as the motion over {x}, {y}, but rotated by psi they do not point along it: psi is \
             another heading, or in another unit; check columns.psi"
        );
        return vec![Found::new(&codes::FRAME, &["psi", x, y], text)];
    }
    let mut found = axes(path);
    if (path.turns - 1.0).abs() > 0.1 {
        let (is, read) = if path.turns > 1.0 { ("deg", "rad") } else { ("rad", "deg") };
        let text = format!(
            "the velocity over {x}, {y} turns {} times as far as psi: most likely psi is in {is} and read as {read}; \
             set columns.psi.unit, and check that of r",
            short(1.0 / path.turns, 3)
        );
        found.push(Found::new(&codes::UNIT, &["psi", x, y], text));
    }
    if let Some([ahead, starboard]) = path.arm {
        let told = |(metres, std): (f64, f64)| format!("{} ± {} m", short(metres, 3), short(std, 2));
        let text = format!(
            "{x}, {y} are measured {} ahead and {} to starboard of the velocity: an antenna, a beacon or a DVL with a \
             lever arm; `hydrosysid discover` finds it as an effect, or refer both to the body origin where the log is \
             made",
            told(ahead),
            told(starboard)
        );
        found.push(Found::new(&codes::LEVER_ARM, &[x, y], text));
    }
    for a in &path.agreements {
        let c = a.channel.as_str();
        let text = |rest: String| {
            format!("{c} is {} ± {} times the speed over {x}, {y}: {rest}", short(a.factor, 4), short(a.std, 2))
        };
        match meaning(a.factor, a.std, 0.05, VELOCITY) {
            Meaning::Unit(name, factor, _) => {
                let text = text(format!("most likely {c} is in {name}; set columns.{c}.unit"));
                found.push(Found::new(&codes::UNIT, &[c, x, y], text).fault(FaultKind::Unit, c, factor));
            }
            Meaning::Scale => {
                let text = text(format!("the scale of {c} or of {x}, {y} is wrong"));
                found.push(Found::new(&codes::SCALE, &[c, x, y], text).fault(FaultKind::Unit, c, a.factor));
            }
            Meaning::Agrees | Meaning::Reversed | Meaning::Unknown => {}
        }
    }
    let Some(a) = path.agreements.first() else { return found };
    let slowest = steps(&a.channel).max(steps(x)).max(steps("psi"));
    found.extend(lag::latency(a.lag, [&a.channel, x], slowest.max(0.1), &[&a.channel, x, y]));
    found
}

/// Finds wrong signs and directions of the axes.
fn axes(path: &Path) -> Vec<Found> {
    let [x, y] = path.position.each_ref().map(String::as_str);
    let angle = |name: &str| {
        let a = path.agreements.iter().find(|a| a.channel == name)?;
        Some((a.angle?, a.std / a.factor)).filter(|(_, std)| 3.0 * std < 0.25 * PI)
    };
    let (u, v) = (angle("u"), angle("v"));
    let back = |a: Option<(f64, f64)>| a.map(|(angle, _)| angle.abs() > 0.75 * PI);
    let both = u.is_some() && v.is_some();
    let handed = u.zip(v).is_none_or(|(u, v)| (u.0 - v.0).cos() > 0.0);
    let sign = |c: &str| {
        let text = format!(
            "{c} points opposite to the motion of the position: its sign is reversed; check body_frame, or set \
             columns.{c}.sign = -1"
        );
        Found::new(&codes::SIGN, &[c], text).fault(FaultKind::Sign, c, -1.0)
    };
    if path.mirrored {
        // a reversed axis of the position leaves forward where it was, or reverses it; a swap turns
        // it to the side
        let turned_round = u.filter(|_| both && !handed).and_then(|(angle, _)| match angle.abs() {
            ..0.5 => Some(y),
            a if a > PI - 0.5 => Some(x),
            _ => None,
        });
        if let Some(c) = turned_round {
            let text = format!(
                "the path over {x}, {y} fits heading and velocity only with {c} reversed: set columns.{c}.sign = -1"
            );
            return vec![Found::new(&codes::SIGN, &[c], text).fault(FaultKind::Sign, c, -1.0)];
        }
        let text = if both && !handed {
            format!(
                "{x} and {y} fit heading and velocity only when they are swapped: check earth_frame (enu instead of ned)"
            )
        } else {
            format!(
                "the path over {x}, {y} turns opposite to psi: psi has the opposite sign convention, or {y} has the \
                 opposite sign; check earth_frame"
            )
        };
        return vec![Found::new(&codes::FRAME, &["psi", x, y], text).fault(FaultKind::Frame, "psi", PI)];
    }
    match (back(u), back(v)) {
        (Some(true), Some(true)) => {
            let text = format!(
                "u and v point opposite to the motion over {x}, {y}: the heading is off by 180°, or both have the \
                 opposite sign"
            );
            return vec![Found::new(&codes::FRAME, &["u", "v", "psi"], text).fault(FaultKind::Frame, "psi", PI)];
        }
        (Some(true), _) if !handed || !both => return vec![sign("u")],
        (_, Some(true)) if !handed || !both => return vec![sign("v")],
        _ => {}
    }
    let Some((offset, std)) = u.or(v) else { return Vec::new() };
    // a few degrees come from the mounting, a right angle from the axes
    if offset.abs() < (5.0 * std).max(0.05) {
        return Vec::new();
    }
    let code = if offset.abs() > 0.35 { &codes::FRAME } else { &codes::MISALIGNED };
    // two axes that are turned in opposite senses cannot come from the mounting
    if both && !handed {
        let text = format!(
            "u and v fit the heading and the path over {x}, {y} only when they are exchanged: correct their names in \
             [log.columns]"
        );
        return vec![Found::new(code, &["u", "v"], text).fault(FaultKind::Frame, "psi", offset)];
    }
    let text = format!(
        "velocity rotated by psi points {} deg off the path over {x}, {y}: the sensor is mounted at this angle, or psi \
         has this offset",
        short(offset.to_degrees(), 3)
    );
    vec![Found::new(code, &["u", "v", "psi"], text).fault(FaultKind::Frame, "psi", offset)]
}
