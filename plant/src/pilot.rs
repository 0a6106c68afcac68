//! Pilot: commanded forces as functions of time and of the measurements.
//!
//! ```text
//! sines      τ = B + Σ A sin(2πt/P + φ)               zig-zag   τ = ± M, turns when |ψ − ψ₀| ≥ ψ_max
//! given      τ = a list, held
//! steps      τ = levels in turn                       random    τ = ± M by coin at every hold (as a PRBS)
//! PID        τ = k_p e + k_i ∫e dt − k_d ν            on heading, depth (any position) or speed, as measured
//! ```

use std::f64::consts::TAU;

use crate::attitude::wrapped;
use crate::dof::Dof;
use crate::random::Random;

/// One sine of a force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sine {
    /// Amplitude, N or N·m.
    pub amplitude: f64,
    /// Period, s.
    pub period: f64,
    /// Phase, rad.
    pub phase: f64,
}

/// Quantity that a PID controller controls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holds {
    /// Position or angle.
    Position,
    /// Velocity or rate.
    Velocity,
}

/// Force of the pilot in one degree of freedom.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// Offset and sines.
    Sines(f64, Vec<Sine>),
    /// Zig-zag of heading.
    Zigzag {
        /// Moment M, N·m; the first turn has its sign.
        moment: f64,
        /// Bound ψ_max, rad.
        bound: f64,
    },
    /// Levels, N or N·m, and the time for which each is held, s; they repeat.
    Steps(Vec<f64>, f64),
    /// An offset plus or minus the amplitude; the sign is random and held for some time.
    Random {
        /// Offset, N or N·m.
        offset: f64,
        /// Amplitude, N or N·m.
        amplitude: f64,
        /// Hold, s.
        hold: f64,
    },
    /// Forces from the first time stamp on, one for each command period, N or N·m; zero before and
    /// after them.
    Given(Vec<f64>),
    /// PID control of a measured quantity.
    Pid {
        /// Position or velocity.
        holds: Holds,
        /// Set points, each after the time from which on it holds, s. Angles and positions are
        /// relative to the first ones measured.
        targets: Vec<(f64, f64)>,
        /// k_p, k_i, k_d.
        gains: [f64; 3],
        /// Maximum force, N or N·m.
        limit: f64,
    },
}

/// Measurements that the pilot has: the latest sample of each channel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Seen {
    /// ν.
    pub nu: [f64; 6],
    /// η.
    pub pose: [f64; 6],
}

/// The laws of a run, with their internal states.
#[derive(Debug, Clone)]
pub struct Pilot {
    laws: Vec<(Dof, Law)>,
    memory: Vec<f64>,
    start: Option<Seen>,
    random: Random,
}

impl Pilot {
    /// A pilot with these laws; the forces of several laws in one degree of freedom are added.
    pub fn new(laws: Vec<(Dof, Law)>, random: Random) -> Pilot {
        let memory = laws.iter().map(|(_, law)| if matches!(law, Law::Pid { .. }) { 0.0 } else { 1.0 }).collect();
        Pilot { laws, memory, start: None, random }
    }

    /// Wanted wrench at the time `t`, s; it is asked for every `period` s.
    pub fn command(&mut self, t: f64, period: f64, seen: &Seen) -> [f64; 6] {
        let start = *self.start.get_or_insert(*seen);
        let mut wrench = [0.0; 6];
        for ((dof, law), memory) in self.laws.iter().zip(&mut self.memory) {
            let i = dof.index();
            let turned = |angle: f64| if dof.is_rotation() { wrapped(angle) } else { angle };
            wrench[i] += match law {
                Law::Sines(offset, sines) => {
                    offset + sines.iter().map(|s| s.amplitude * (TAU * t / s.period + s.phase).sin()).sum::<f64>()
                }
                Law::Zigzag { moment, bound } => {
                    let off = turned(seen.pose[i] - start.pose[i]);
                    if off.abs() >= *bound {
                        *memory = -off.signum() * moment.signum();
                    }
                    *memory * moment
                }
                Law::Steps(levels, hold) => {
                    let k = (t / hold + 1e-9).floor().max(0.0) as usize;
                    levels[k % levels.len()]
                }
                Law::Given(forces) => {
                    let k = (t / period + 1e-6).floor();
                    if k < 0.0 { 0.0 } else { forces.get(k as usize).copied().unwrap_or(0.0) }
                }
                Law::Random { offset, amplitude, hold } => {
                    let cell = |t: f64| (t / hold + 1e-9).floor();
                    if cell(t) > cell(t - period) {
                        *memory = if self.random.uniform() < 0.5 { -1.0 } else { 1.0 };
                    }
                    offset + *memory * amplitude
                }
                Law::Pid { holds, targets, gains: [p, integral, d], limit } => {
                    let target = targets.iter().rev().find(|(from, _)| t >= *from).map_or(0.0, |(_, value)| *value);
                    let error = match holds {
                        Holds::Position => turned(start.pose[i] + target - seen.pose[i]),
                        Holds::Velocity => target - seen.nu[i],
                    };
                    let damping = if *holds == Holds::Position { d * seen.nu[i] } else { 0.0 };
                    let wanted = p * error + *memory - damping;
                    // anti-windup: the integral stays as it is while the limit is reached
                    if wanted.abs() < *limit {
                        *memory += integral * error * period;
                    }
                    wanted.clamp(-limit, *limit)
                }
            };
        }
        wrench
    }
}

// values that are set are returned bit for bit
#[cfg(test)]
#[allow(clippy::float_cmp)]
mod tests {
    use super::*;

    fn one(law: Law, dof: Dof) -> Pilot {
        Pilot::new(vec![(dof, law)], Random::new(1, 1))
    }

    fn heading(psi: f64) -> Seen {
        Seen { pose: [0.0, 0.0, 0.0, 0.0, 0.0, psi], ..Seen::default() }
    }

    #[test]
    fn zigzag_turns_at_the_bound_across_the_wrap() {
        let mut pilot = one(Law::Zigzag { moment: 70.0, bound: 1.0 }, Dof::Yaw);
        let mut at = |psi| pilot.command(0.0, 0.1, &heading(psi))[5];
        assert_eq!([at(3.0), at(-2.4), at(-2.2), at(3.0), at(2.1), at(1.9)], [70.0, 70.0, -70.0, -70.0, -70.0, 70.0]);
    }

    #[test]
    fn pid_pulls_towards_its_target_within_its_limit() {
        let law = |limit| Law::Pid {
            holds: Holds::Position,
            targets: vec![(0.0, 0.0), (5.0, 1.0)],
            gains: [10.0, 1.0, 2.0],
            limit,
        };
        let mut pilot = one(law(100.0), Dof::Yaw);
        assert!(pilot.command(0.0, 0.1, &heading(0.5))[5].abs() < 1e-12);
        assert!((pilot.command(5.0, 0.1, &heading(0.5))[5] - 10.0).abs() < 1e-12);
        assert!((pilot.command(5.1, 0.1, &heading(0.5))[5] - 10.1).abs() < 1e-12);
        assert!((one(law(0.3), Dof::Yaw).command(6.0, 0.1, &heading(0.0))[5] - 0.3).abs() < 1e-12);
    }

    #[test]
    fn steps_and_coins_hold_their_levels() {
        let mut steps = one(Law::Steps(vec![1.0, -2.0], 3.0), Dof::Surge);
        let seen = Seen::default();
        assert_eq!([0.0, 2.9, 3.0, 6.0].map(|t| steps.command(t, 0.1, &seen)[0]), [1.0, 1.0, -2.0, 1.0]);
        let mut coin = one(Law::Random { offset: 5.0, amplitude: 2.0, hold: 1.0 }, Dof::Surge);
        let list: Vec<f64> = (0..400).map(|k| coin.command(0.1 * f64::from(k), 0.1, &seen)[0]).collect();
        assert!(list.iter().all(|x| (x - 7.0).abs() < 1e-12 || (x - 3.0).abs() < 1e-12));
        let ups = list.iter().filter(|x| **x > 5.0).count();
        assert!((100..300).contains(&ups));
    }
}
