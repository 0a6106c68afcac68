//! A quick balance of one degree of freedom: its velocity as a function of its commands.
//!
//! ```text
//! ν(b) − ν(a) = Σ gⱼ ∫ τⱼ(t − d) dt − k ∫ ν dt − k₂ ∫ ν|ν| dt + Σ c ∫ (product of two velocities) dt
//!               + s ∫ sin(angle) dt + β (b − a)
//! ```
//!
//! over windows [a, b] by the trapezoidal rule; all terms are accelerations: g = 1/m for a force.
//! The noise of the velocity enters the left-hand side, where it does no harm; the integrals on the
//! right-hand side average it. The curve of a thruster is not known here: the force of a control
//! voltage is modelled by the power that fits best, V |V|ᵖ⁻¹ with p = 1, 1.5 or 2, scaled to V at
//! the largest V, and a delay d is estimated with a free curve a V + b V |V| + c V² of each
//! voltage. The balance shows signs, lags and the excitation of a run; its estimates are too rough
//! for other uses. If commands always vary together, such as those of two vertical thrusters, one
//! stands for all.

use super::fit::{Fit, fit};
use super::lag;
use super::pose_velocity::velocity;
use super::rates::number_of;
use super::samples::{Samples, windows};
use crate::frame::Dof;
use crate::run::{Run, Signal, greatest, is_commanded, rounding_of, thruster_force};

/// Shortest window, s.
pub const WINDOW: f64 = 0.5;
/// Exponents of the thrust as a function of the control voltage that are tried besides 1.
const POWERS: [f64; 2] = [1.5, 2.0];

/// Unexplained share of the sum of squares of a command, below which it is a combination of others.
const SAME: f64 = 1e-10;
/// Share of the root mean square of such a command that another one must contribute to stand for it.
const SHARE: f64 = 0.01;

/// Meaning of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Term {
    /// A command, by its channel.
    Command(String),
    /// ∫ν.
    Linear,
    /// ∫ν|ν|.
    Quadratic,
    /// ∫ of the product of these two velocities.
    Product(&'static str, &'static str),
    /// ∫ sin of the angle.
    Restoring,
    /// The length of the window.
    Constant,
}

/// The balance of one degree of freedom.
#[derive(Debug, Clone)]
pub struct Balance {
    /// Degree of freedom.
    pub dof: Dof,
    /// Terms, in the order of the columns.
    pub terms: Vec<Term>,
    /// The velocity.
    pub nu: Samples,
    commands: Vec<Samples>,
    /// The commands with which the delay is estimated: for a voltage V, V |V| and V², whose sum
    /// approximates any curve.
    curves: Vec<Samples>,
    /// Whether each command stands for others that always vary with it.
    together: Vec<bool>,
    windows: Vec<(f64, f64)>,
    others: Vec<Vec<f64>>,
    target: Vec<f64>,
}

/// Products of velocities in the strongest Coriolis terms of each degree of freedom.
fn products(dof: Dof) -> &'static [(&'static str, &'static str)] {
    match dof {
        Dof::Surge => &[("v", "r"), ("w", "q")],
        Dof::Sway => &[("u", "r")],
        Dof::Heave => &[("u", "q")],
        Dof::Roll => &[],
        Dof::Pitch => &[("u", "w")],
        Dof::Yaw => &[("u", "v")],
    }
}

/// Returns the varying commands of a degree of freedom: its nominal force if that is logged, or else
/// the forces of all thrusters, or else their voltages. What is rounding of the allocation to thrusters commands nothing.
pub fn commands(run: &Run, dof: Dof) -> Vec<String> {
    let run_alone = std::slice::from_ref(run);
    let varies = |name: &str| run.signal(name).is_some_and(Signal::varies);
    if run.signal(dof.force()).is_some() {
        let own = varies(dof.force()) && is_commanded(run_alone, dof);
        return if own { vec![dof.force().to_string()] } else { Vec::new() };
    }
    for letter in ['F', 'V'] {
        let of_thrusters: Vec<&String> =
            run.signals.keys().filter(|n| n.starts_with(letter) && number_of(n).is_some()).collect();
        let most = |name: &str| greatest(run_alone, name);
        let rounding = rounding_of(of_thrusters.iter().map(|n| most(n)));
        let commanded = of_thrusters.into_iter().filter(|n| varies(n) && most(n) > rounding);
        let names: Vec<String> = commanded.cloned().collect();
        if !names.is_empty() {
            return names;
        }
    }
    Vec::new()
}

impl Balance {
    /// Returns the balance of `dof` in this run; `None` without velocity, command or enough windows.
    pub fn new(run: &Run, dof: Dof) -> Option<Balance> {
        Balance::over(run, dof, WINDOW)
    }

    /// The same over windows of `width` s, or of two steps of the slowest channel if that is longer.
    pub fn over(run: &Run, dof: Dof, width: f64) -> Option<Balance> {
        let straight = Balance::by_power(run, dof, width, 1.0)?;
        if !straight.commands_are_voltages() {
            return Some(straight);
        }
        let curves = straight.powers_of_commands();
        let curved = POWERS.into_iter().filter_map(|power| Balance::by_power(run, dof, width, power));
        let cost = |b: &Balance| b.fit(0.0).map_or(f64::INFINITY, |f| f.cost);
        let best = std::iter::once(straight).chain(curved).min_by(|a, b| cost(a).total_cmp(&cost(b)))?;
        Some(Balance { curves, ..best })
    }

    /// Returns V, V |V| and V² of each command, without those that are linear combinations of the
    /// others: a command that steps between two values shows no curve.
    fn powers_of_commands(&self) -> Vec<Samples> {
        let powers: [fn(f64) -> f64; 3] = [|v| v, |v| v * v.abs(), |v| v * v];
        let all = powers.iter().flat_map(|power| self.commands.iter().map(|c| c.map(|_, v| power(v))));
        let all: Vec<Samples> = all.collect();
        let columns: Vec<Vec<f64>> = all.iter().map(|s| self.late(s, 0.0)).collect();
        let (kept, _) = independent(&columns);
        kept.into_iter().map(|k| all[k].clone()).collect()
    }

    /// Whether the commands are voltages or normalised commands, all below 100 in magnitude: pulse
    /// widths, which have their zero elsewhere, are not.
    fn commands_are_voltages(&self) -> bool {
        let voltages = self.channels().iter().all(|n| n.starts_with('V') && number_of(n).is_some());
        voltages && self.commands.iter().all(|c| c.values().iter().all(|x| x.abs() < 100.0))
    }

    fn by_power(run: &Run, dof: Dof, width: f64, power: f64) -> Option<Balance> {
        let nu = velocity(run, dof)?;
        let names = commands(run, dof);
        let of_command = |n: &String| {
            let samples = run.signal(n).and_then(|s| Samples::new(s.time().to_vec(), s.values().to_vec()))?;
            let most = samples.values().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            let straight = power.to_bits() == 1f64.to_bits() || most <= 0.0;
            Some(if straight { samples } else { samples.map(|_, x| x * (x.abs() / most).powf(power - 1.0)) })
        };
        let commands: Vec<Samples> = names.iter().filter_map(of_command).collect();
        if commands.is_empty() || commands.len() != names.len() {
            return None;
        }
        let step = commands.iter().map(Samples::step).fold(nu.step(), f64::max);
        let mut all: Vec<&Samples> = commands.iter().collect();
        all.push(&nu);
        let windows = windows(&all, width.max(2.0 * step), lag::REACH);
        let over = |s: &Samples| -> Vec<f64> { windows.iter().map(|(a, b)| s.integral(*a, *b)).collect() };
        let (kept, together) = independent(&commands.iter().map(over).collect::<Vec<_>>());
        let mut terms: Vec<Term> = kept.iter().map(|k| Term::Command(names[*k].clone())).collect();
        let commands: Vec<Samples> = kept.iter().map(|k| commands[*k].clone()).collect();
        terms.extend([Term::Linear, Term::Quadratic]);
        let mut others = vec![over(&nu), over(&nu.map(|_, x| x * x.abs()))];
        let other = |name: &str| velocity(run, Dof::ALL.into_iter().find(|other| other.velocity() == name)?);
        for (a, b) in products(dof) {
            let (Some(x), Some(y)) = (other(a), other(b)) else { continue };
            let column = over(&nu.map(|t, _| x.at(t) * y.at(t)));
            // a rate at rest adds no term
            if rms(&column) > 0.0 {
                terms.push(Term::Product(a, b));
                others.push(column);
            }
        }
        if matches!(dof, Dof::Roll | Dof::Pitch)
            && let Some(angle) = run.signal(dof.position()).and_then(Samples::of_angle)
        {
            let column = over(&nu.map(|t, _| angle.at(t).sin()));
            if rms(&column) > 0.0 {
                terms.push(Term::Restoring);
                others.push(column);
            }
        }
        terms.push(Term::Constant);
        others.push(windows.iter().map(|(a, b)| b - a).collect());
        let target = windows.iter().map(|(a, b)| nu.at(*b) - nu.at(*a)).collect();
        Some(Balance { dof, terms, nu, curves: commands.clone(), commands, together, windows, others, target })
    }

    /// Returns the columns of `commands`, delayed by `delay` s, and those of the other terms.
    fn columns(&self, commands: &[Samples], delay: f64) -> Vec<Vec<f64>> {
        commands.iter().map(|s| self.late(s, delay)).chain(self.others.iter().cloned()).collect()
    }

    /// Returns the integrals of `samples`, delayed by `delay` s.
    fn late(&self, samples: &Samples, delay: f64) -> Vec<f64> {
        self.windows.iter().map(|(a, b)| samples.integral(a - delay, b - delay)).collect()
    }

    /// Returns the fit with the commands delayed by `delay` s.
    pub fn fit(&self, delay: f64) -> Option<Fit> {
        self.fit_to(&self.commands, delay)
    }

    /// The same with a free curve a V + b V |V| + c V² for each voltage: together with drag, an
    /// error of the curve looks like a delay.
    pub fn fit_with_any_curve(&self, delay: f64) -> Option<Fit> {
        self.fit_to(&self.curves, delay)
    }

    fn fit_to(&self, commands: &[Samples], delay: f64) -> Option<Fit> {
        let columns = self.columns(commands, delay);
        fit(&columns.iter().map(Vec::as_slice).collect::<Vec<_>>(), &self.target)
    }

    /// Returns the fit with all commands combined into one, weighted with their gains in `each`,
    /// and the root mean square of every column, of which the first is that of the commands. A run
    /// need not show the separate effects of thrusters that push together.
    pub fn with_commands_as_one(&self, each: &Fit) -> Option<(Fit, Vec<f64>)> {
        let columns = self.columns(&self.commands, 0.0);
        let (commands, others) = columns.split_at(self.commands.len());
        let push = |k: usize| commands.iter().zip(&each.theta).map(|(column, gain)| gain * column[k]).sum();
        let together: Vec<f64> = (0..self.windows.len()).map(push).collect();
        let all: Vec<&[f64]> = std::iter::once(&together).chain(others).map(Vec::as_slice).collect();
        Some((fit(&all, &self.target)?, all.iter().map(|column| rms(column)).collect()))
    }

    /// 1 − SSE(all terms)/SSE(without the commands): the share of the changes of velocity, after the
    /// other terms, that the commands explain.
    pub fn owed_to_commands(&self, full: &Fit) -> f64 {
        let others: Vec<&[f64]> = self.others.iter().map(Vec::as_slice).collect();
        let without = fit(&others, &self.target).map_or(self.target.iter().map(|x| x * x).sum(), |f| f.cost);
        if without > 0.0 { 1.0 - full.cost / without } else { 0.0 }
    }

    /// Root mean square of the changes of velocity.
    pub fn change(&self) -> f64 {
        rms(&self.target)
    }

    /// Usual step of the slowest of velocity and commands, s.
    pub fn step(&self) -> f64 {
        self.commands.iter().map(Samples::step).fold(self.nu.step(), f64::max)
    }

    /// Number of times that command `k` goes from the lowest quarter of its range to the highest, or back.
    pub fn swings(&self, k: usize) -> usize {
        let values = self.commands[k].values();
        let (low, high) =
            values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (x.min(low), x.max(high)));
        let quarter = 0.25 * (high - low);
        let side = |x: &f64| match x {
            x if *x < low + quarter => Some(false),
            x if *x > high - quarter => Some(true),
            _ => None,
        };
        let mut sides: Vec<bool> = values.iter().filter_map(side).collect();
        sides.dedup();
        sides.len().saturating_sub(1)
    }

    /// Whether command `k` stands for others that always vary with it: its gain is that of all of them.
    pub fn is_joined(&self, k: usize) -> bool {
        self.together[k]
    }

    /// Terms other than the commands.
    pub fn other_terms(&self) -> &[Term] {
        &self.terms[self.commands.len()..]
    }

    /// Their columns.
    pub fn other_columns(&self) -> &[Vec<f64>] {
        &self.others
    }

    /// Changes of velocity, one a window.
    pub fn target(&self) -> &[f64] {
        &self.target
    }

    /// Integrals over the windows of the force of the thruster with this index, which counts from 0; `None` if `run` does
    /// not hold it.
    pub fn impulse(&self, run: &Run, index: usize) -> Option<Vec<f64>> {
        let signal = run.signal(&thruster_force(index))?;
        Some(self.late(&Samples::new(signal.time().to_vec(), signal.values().to_vec())?, 0.0))
    }

    /// Channels of the commands.
    pub fn channels(&self) -> Vec<&str> {
        self.terms.iter().filter_map(|t| if let Term::Command(name) = t { Some(name.as_str()) } else { None }).collect()
    }
}

/// Returns the columns that are independent of those before, and whether each of them stands for others.
fn independent(columns: &[Vec<f64>]) -> (Vec<usize>, Vec<bool>) {
    let (mut kept, mut together): (Vec<usize>, Vec<bool>) = (Vec::new(), Vec::new());
    for (k, column) in columns.iter().enumerate() {
        let others: Vec<&[f64]> = kept.iter().map(|j| columns[*j].as_slice()).collect();
        match fit(&others, column).filter(|f| 1.0 - f.explained < SAME) {
            Some(same) => {
                for ((part, other), joined) in same.theta.iter().zip(&others).zip(&mut together) {
                    *joined |= part.abs() * rms(other) > SHARE * rms(column);
                }
            }
            None => {
                kept.push(k);
                together.push(false);
            }
        }
    }
    (kept, together)
}

fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|x| x * x).sum::<f64>() / x.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;
    use crate::run::Signal;

    /// ẇ = V₁ + V₂ − w, the two thrusters always driven alike; `late` samples of 0.1 s after their
    /// commands.
    fn hovering(late: usize) -> Run {
        let time: std::sync::Arc<[f64]> = (0..900).map(|k| 0.1 * f64::from(k)).collect();
        let mut noise = Noise::new(3, 1);
        let steps: Vec<f64> = (0..60).map(|_| noise.normal()).collect();
        let command: Vec<f64> = (0..time.len()).map(|k| steps[k / 15]).collect();
        let (mut w, mut speed) = (Vec::new(), 0.0);
        for k in 0..time.len() {
            w.push(speed + 2e-3 * noise.normal());
            speed += 0.1 * (2.0 * command[k.saturating_sub(late)] - speed);
        }
        let mut run = Run::default();
        let still = vec![0.0; time.len()];
        for (name, values) in
            [("V1", command.clone()), ("V2", command), ("w", w), ("phi", still.clone()), ("theta", still)]
        {
            run.signals.insert(name.into(), Signal::new(time.clone(), values));
        }
        run
    }

    /// Two identical commands, and rates and angles at rest, leave a balance that can be solved.
    #[test]
    fn commands_that_always_go_together_are_asked_as_one() {
        let balance = Balance::new(&hovering(0), Dof::Heave).expect("velocity and commands");
        assert_eq!((balance.channels(), balance.is_joined(0)), (vec!["V1"], true));
        let fit = balance.fit(0.0).expect("independent columns");
        // ẇ is integrated in steps of a tenth of the time constant
        assert!((fit.theta[0] - 2.0).abs() < 0.2, "{fit:?}");
    }

    /// One step, one step and back, and sixty random steps.
    #[test]
    fn a_step_swings_once() {
        let swings = |command: &dyn Fn(usize, f64) -> f64| {
            let mut run = hovering(0);
            for name in ["V1", "V2"] {
                let signal = run.signals.get_mut(name).expect("it is commanded");
                let values: Vec<f64> = signal.values().iter().enumerate().map(|(k, x)| command(k, *x)).collect();
                *signal = Signal::new(signal.shared_time().clone(), values);
            }
            Balance::new(&run, Dof::Heave).expect("a balance").swings(0)
        };
        assert_eq!(swings(&|k, _| if k < 400 { 0.0 } else { 1.0 }), 1);
        assert_eq!(swings(&|k, _| if (300..600).contains(&k) { 1.0 } else { 0.0 }), 2);
        assert!(swings(&|_, x| x) > 5);
    }

    /// u̇ = F(V) − 0.2 u − 0.5 u|u| with a dead band and weaker thrust astern, `late` s after the voltages.
    fn driven_by_a_curve(late: f64) -> Option<lag::Lag> {
        let ahead = |v: f64| if v > 0.0 { 1.0 } else { 0.75 };
        let force = |v: f64| if v.abs() < 0.1 { 0.0 } else { ahead(v) * (v * v.abs() + 0.3 * v) };
        let command = |t: f64| 0.8 * (0.3 * t).sin();
        let time: std::sync::Arc<[f64]> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
        let mut noise = Noise::new(4, 1);
        let (mut u, mut speed) = (Vec::new(), 0.0);
        for t in time.iter() {
            u.push(speed + 2e-3 * noise.normal());
            for k in 0..100 {
                let push = force(command(t + 1e-3 * f64::from(k) - late));
                speed += 1e-3 * (push - 0.2 * speed - 0.5 * speed * speed.abs());
            }
        }
        let mut run = Run::default();
        let voltages = |sign: f64| time.iter().map(|t| sign * command(*t)).collect::<Vec<_>>();
        for (name, values) in [("V1", voltages(1.0)), ("V2", voltages(-1.0)), ("u", u)] {
            run.signals.insert(name.into(), Signal::new(time.clone(), values));
        }
        super::super::commands::measure(&Balance::new(&run, Dof::Surge).expect("a balance")).first()?.delay
    }

    /// An unknown curve is not taken for a delay, and a delay is found in spite of it.
    #[test]
    fn a_curve_with_a_dead_band_is_no_delay() {
        let told = |late| driven_by_a_curve(late).filter(|lag| lag.is_clear(8.0, 0.15));
        assert_eq!(told(0.0), None);
        let found = told(0.4).expect("a delay").seconds;
        assert!((found - 0.4).abs() < 0.1, "{found}");
    }

    #[test]
    fn commands_that_always_go_together_show_that_they_are_late() {
        let late = super::super::commands::measure(&Balance::new(&hovering(5), Dof::Heave).expect("a balance"));
        let delay = late[0].delay.expect("a delay").seconds;
        assert!((delay - 0.5).abs() < 0.1, "{delay}");
        assert!(late[0].joined);
    }
}
