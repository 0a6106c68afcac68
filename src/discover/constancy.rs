//! Step 7, second half: a physical parameter is constant in time.
//!
//! ```text
//! S = Σ Gᵀe,  A = Σ GᵀG over a part of the log,   C = A_jj − A_j· (Σ A)⁻¹ A·j       G = ∂e/∂θ /√s at the estimate
//! z² = S_j²/C,   δ = −S_j/C                        what θ_j is more there than elsewhere; δ ± 1/√C
//! ```
//!
//! A part is everything after an instant (weed, a payload, a motor that fails), or one run (a wrong sign, another
//! trim); for a per-run value, everything after an instant of that run (a current that turns with the tide). Over the
//! whole log S is zero, because the estimate maximises the likelihood. The greatest z² of all parts and parameters is
//! compared with the greatest one by chance, drawn from N(0, A) of every block. A name that stands in for something
//! else may follow the whole log on average, but not every part of it. If one parameter changes once, nothing remains
//! beside that change when it is an unknown of its own. If the equations have the wrong form, every part requires
//! other values, and none of them is reported as a change. Nyblom, *Journal of the American Statistical Association*
//! 84 (1989) 223-230; Hansen, *Journal of Policy Modeling* 14 (1992) 517-533.

use serde::Serialize;

use super::parts::{BLOCK, LEVEL, Log, beyond, divided};
use crate::effects::common_name_at;
use crate::estimate::filter_error::FilterErrorFit;
use crate::run::Run;
use crate::wording::{digits, measured};

/// An instant of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunInstant {
    /// Run.
    pub run: String,
    /// Instant, s.
    pub at: f64,
}

/// A parameter that changes with time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChangedParameter {
    /// Effect and symbol, or a property of the vehicle: `drag`, `thrust`, `mass`.
    pub parameter: String,
    /// Run in which it differs, or in which the change begins.
    pub run: String,
    /// Instant from which it differs, s of the run, to a block of samples, of an event to a sample; `None` if it differs in
    /// this run alone.
    pub from: Option<f64>,
    /// Earliest and latest instant of an event that the data do not tell from `from`, to a block of samples; empty if
    /// they tell it.
    pub between: Vec<RunInstant>,
    /// Difference of the value there from the value elsewhere.
    pub change: f64,
    /// Standard deviation of the difference.
    pub std: f64,
    /// Its unit.
    pub unit: String,
    /// Probability of such a change by chance, over all parameters and parts.
    pub p_value: f64,
    /// Fall of −2 ln L, beyond chance, if all parameters have values of their own in that part; of an event, with it.
    pub gain: f64,
    /// Whether this change explains everything: beside it no other parameter or part requires another value, and no
    /// stand-in effect raises the likelihood by more. If not, no value has changed, but the equations have the wrong
    /// form. For an event (an effect that begins, a property that changes), false means that something remains beside
    /// it, less than a tenth of its gain.
    pub alone: bool,
    /// Whether the effect is not in the model: elsewhere it is zero.
    pub absent: bool,
    /// Whether `change` is a share of the value elsewhere: of all parameters of the drag, or of all thrust.
    pub relative: bool,
    /// Value at which its effect vanishes, 1 for a scale.
    #[serde(skip)]
    pub(super) neutral: f64,
}

impl ChangedParameter {
    /// `Not constant: k_r of linear_drag@yaw is 0.83 ± 0.03 kg*m2/s more from 31 s of run04 on.`, or, if
    /// no one value fits, the part of the log where this shows most.
    pub fn told(&self) -> String {
        if self.is_event() {
            return format!("Not constant: {}.", self.event_in_words());
        }
        if self.alone {
            return format!("Not constant: {}.", self.change_in_words());
        }
        let (effect, symbol) = self.parameter.split_once(' ').unwrap_or((&self.parameter, ""));
        let at = self.from.map_or(format!("in {}", self.run), |from| format!("from {from:.0} s of {} on", self.run));
        format!(
            "The parameters compensate for it with different values in different parts of the log, {symbol} of \
             {effect} most, {at}."
        )
    }

    /// Marks a change as not alone if some stand-in gains more; `gains`: fall of −2 ln L with each stand-in.
    pub(super) fn stand_beside(&mut self, gains: impl Iterator<Item = f64>) {
        self.alone &= gains.fold(0.0, f64::max) < self.gain;
    }

    /// Whether it is a property of the vehicle rather than one parameter: its drag, its thrust, its mass.
    pub(super) fn is_of_vehicle(&self) -> bool {
        !self.parameter.contains(' ')
    }

    /// Whether it is an event: an effect that begins, or a property of the vehicle that changes.
    pub(super) fn is_event(&self) -> bool {
        self.absent || self.is_of_vehicle()
    }

    /// Description of an event: `from 36 s of run04 on there is a weak thruster, T2 (thruster_loss@T2), k_loss = 0.70 ±
    /// 0.0037`, or `from 36 s of run04 on, the drag is 1.402 ± 0.012 times what it was before`.
    pub(super) fn event_in_words(&self) -> String {
        let when = self.when();
        if self.is_of_vehicle() {
            let what = &self.parameter;
            let (when, was, then) = match &when {
                Some(when) => (format!("{when} on, the {what} is"), "was", "before"),
                None => (format!("in {} alone the {what} is", self.run), "is", "in the other runs"),
            };
            if self.relative {
                return format!("{when} {} times what it {was} {then}", measured(1.0 + self.change, self.std));
            }
            let (size, more) = (measured(self.change.abs(), self.std), if self.change < 0.0 { "less" } else { "more" });
            return format!("{when} {size} {} {more} than {then}", self.unit);
        }
        let (effect, symbol) = self.parameter.split_once(' ').unwrap_or((&self.parameter, ""));
        let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
        let value = self.neutral + self.change;
        let what = format!(
            "{} ({effect}), {symbol} = {} ± {}{unit}",
            common_name_at(effect, Some(value)),
            digits(value),
            digits(self.std)
        );
        match when {
            Some(when) => format!("{when} on there is {what}"),
            None => format!("in {}, and nowhere else, there is {what}", self.run),
        }
    }

    /// `from 36 s of run04`, or the range of instants that the data do not tell apart; `None` for a single run.
    fn when(&self) -> Option<String> {
        let from = self.from?;
        Some(match &self.between[..] {
            [] => format!("from {from:.0} s of {}", self.run),
            _ => format!("from some instant {}", self.range_in_words()?),
        })
    }

    /// `between 12 s and 36 s of run04`; `None` if the data tell the instant.
    pub(super) fn range_in_words(&self) -> Option<String> {
        let [earliest, latest] = &self.between[..] else { return None };
        let is_one = earliest.run == latest.run;
        let of = if is_one { String::new() } else { format!(" of {}", earliest.run) };
        Some(format!("between {:.0} s{of} and {:.0} s of {}", earliest.at, latest.at, latest.run))
    }

    fn change_in_words(&self) -> String {
        let (effect, symbol) = self.parameter.split_once(' ').unwrap_or((&self.parameter, ""));
        let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
        let more = if self.change < 0.0 { "less" } else { "more" };
        let size = format!("{} ± {}{unit} {more}", digits(self.change.abs()), digits(self.std));
        match self.from {
            Some(from) => format!("{symbol} of {effect} is {size} from {from:.0} s of {} on", self.run),
            None => format!("{symbol} of {effect} is {size} in {} than elsewhere", self.run),
        }
    }
}

/// The one of two events that explains more.
pub(super) fn likelier(one: Option<ChangedParameter>, other: Option<ChangedParameter>) -> Option<ChangedParameter> {
    one.into_iter().chain(other).max_by(|a, b| a.gain.total_cmp(&b.gain))
}

/// The most significant change of a parameter of `fit` in the terms that satisfy `asked`; `None` if none is
/// significant.
pub(super) fn changed(
    fit: &FilterErrorFit,
    runs: &[Run],
    seed: u64,
    asked: impl Fn(&str) -> bool,
) -> Option<ChangedParameter> {
    most_changed(fit, runs, seed, asked).filter(|found| found.p_value < LEVEL)
}

/// The parameter of `fit` that changes most between parts of `runs`, with the p-value of the change.
fn most_changed(
    fit: &FilterErrorFit,
    runs: &[Run],
    seed: u64,
    asked: impl Fn(&str) -> bool,
) -> Option<ChangedParameter> {
    let unknowns = &fit.filtered.problem.unknowns;
    let parameter = |unknown: usize| &fit.model.parameters[unknowns[unknown].parameter];
    let products = fit.filtered.products_in_blocks(&fit.model, &fit.noise, fit.limit, BLOCK);
    let (blocks, parts) = divided(fit, runs, &products, 0);
    let all: Vec<usize> = (0..unknowns.len()).collect();
    let asked = all.iter().copied().filter(|unknown| asked(&parameter(*unknown).term)).collect();
    let log = Log::of(blocks, parts, (all, asked), fit.priors().collect())?;
    let found = log.own()?;
    let p_value = beyond(found.z2, &log.drawn(log.by_chance(seed)));
    let apart = if p_value < LEVEL { log.apart(&found) } else { None };
    let (part, of) = (&log.parts[found.part], parameter(found.unknown));
    Some(ChangedParameter {
        parameter: format!("{} {}", of.term, of.spec.name),
        run: runs[part.run].name.clone(),
        from: part.from,
        between: Vec::new(),
        change: -found.s / found.c,
        std: 1.0 / found.c.sqrt(),
        unit: of.spec.dimension.to_string(),
        p_value,
        gain: apart.as_ref().map_or(found.z2, |apart| apart.gain),
        alone: apart.as_ref().and_then(|apart| apart.is_alone(&log, seed)).unwrap_or(false),
        absent: false,
        neutral: of.spec.neutral,
        relative: false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::estimate::filter_error::{FilterErrorOptions, filter_error};
    use crate::frame::Dof;
    use crate::model::Model;
    use crate::noise::Noise;
    use crate::run::Signal;

    /// Two runs of 10 u̇ + 8 u = τ by Euler's rule at 20 Hz under white noise, the drag `share` times as large from 20 s of
    /// the second run on, and fitted with one drag.
    fn fitted(share: f64, seed: u64) -> (FilterErrorFit, Vec<Run>) {
        let mut noise = Noise::new(seed, 1);
        let mut runs = Vec::new();
        for run in 0..2 {
            let time: Vec<f64> = (0..800).map(|k| 0.05 * f64::from(k)).collect();
            let tau: Vec<f64> = time.iter().map(|t| 12.0 * (0.5 * t).sin() + 6.0 * (1.3 * t).cos()).collect();
            let mut u = 0.0;
            let logged = time.iter().zip(&tau).map(|(t, tau)| {
                let now = u;
                let drag = if run == 1 && *t >= 20.0 { 8.0 * share } else { 8.0 };
                (0..50).for_each(|_| u += 0.001 * (tau - drag * u) / 10.0);
                now + 0.01 * noise.normal()
            });
            let logged: Vec<f64> = logged.collect();
            let mut made = Run { name: format!("run{run}"), ..Run::default() };
            made.signals.insert("u".into(), Signal::new(time.clone().into(), logged));
            made.signals.insert("tau_u".into(), Signal::new(time.into(), tau));
            runs.push(made);
        }
        let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        model.input = crate::model::Interpolation::Hold;
        model.parameters.iter_mut().for_each(|p| p.value = 9.0);
        (filter_error(&model, &runs, &FilterErrorOptions::default()).unwrap(), runs)
    }

    /// Finds the drag, the instant to a block (256 samples, 12.8 s), and the change to three standard deviations.
    #[test]
    fn a_drag_that_changes_at_an_instant_is_told_with_the_instant() {
        let (fit, runs) = fitted(1.2, 5);
        let found = changed(&fit, &runs, 1, |_| true).unwrap();
        assert_eq!((found.parameter.as_str(), found.run.as_str()), ("linear_drag@surge k_u", "run1"));
        assert!((found.from.unwrap() - 20.0).abs() < 12.8, "{found:?}");
        assert!(found.p_value < 1e-6 && found.change > 0.8 && found.change < 2.4, "{found:?}");
        let beside = |gain: f64| {
            let mut found = found.clone();
            found.stand_beside(std::iter::once(gain));
            found.alone
        };
        // two parameters, and the other one is not involved: the gain is less by its one of chance
        assert!(found.gain > (found.change / found.std).powi(2) - 2.0, "{found:?}");
        assert!(beside(0.9 * found.gain) && !beside(1.1 * found.gain));
        assert!(found.alone && found.told().contains(": k_u of linear_drag@surge is 1."), "{}", found.told());
    }

    /// A thrust scale that is 0.3 less is reported with its value.
    #[test]
    fn what_begins_is_told_by_its_value() {
        let (fit, runs) = fitted(1.2, 5);
        let parameter = "thrust_interaction_loss@surge eta_u".to_string();
        let (run, from, unit) = ("b".to_string(), Some(36.2), "1".to_string());
        let found = changed(&fit, &runs, 1, |_| true).unwrap();
        let begun = ChangedParameter {
            parameter,
            run,
            from,
            unit,
            change: -0.3,
            std: 0.01,
            absent: true,
            neutral: 1.0,
            ..found
        };
        assert_eq!(
            begun.told(),
            "Not constant: from 36 s of b on there is loss of thrust between thruster and hull in surge \
             (thrust_interaction_loss@surge), eta_u = 0.70 ± 0.010."
        );
    }

    #[test]
    fn a_property_of_the_vehicle_is_told_in_its_own_words() {
        let (fit, runs) = fitted(1.2, 5);
        let found = changed(&fit, &runs, 1, |_| true).unwrap();
        let (run, std, unit) = ("run1".to_string(), 0.0123, "kg".to_string());
        let mass = ChangedParameter { parameter: "mass".into(), run, from: None, change: -2.5, std, unit, ..found };
        assert!(mass.is_event() && !mass.absent);
        assert_eq!(
            mass.told(),
            "Not constant: in run1 alone the mass is 2.500 ± 0.012 kg less than in the other runs."
        );
        let drag = ChangedParameter { parameter: "drag".into(), from: Some(36.2), change: 0.4, relative: true, ..mass };
        assert_eq!(
            drag.told(),
            "Not constant: from 36 s of run1 on, the drag is 1.400 ± 0.012 times what it was before."
        );
        let between = [("run0", 12.0), ("run1", 36.2)].map(|(run, at)| RunInstant { run: run.into(), at }).to_vec();
        let told = ChangedParameter { between, ..drag.clone() }.told();
        assert!(told.contains("from some instant between 12 s of run0 and 36 s of run1 on, the drag is"), "{told}");
        let between = [12.0, 36.2].map(|at| RunInstant { run: "run1".into(), at }).to_vec();
        let told = ChangedParameter { between, ..drag }.told();
        assert!(told.contains("from some instant between 12 s and 36 s of run1 on, the drag is"), "{told}");
    }

    #[test]
    fn what_is_not_alone_is_told_as_no_change() {
        let (fit, runs) = fitted(1.2, 5);
        let told = ChangedParameter { alone: false, ..changed(&fit, &runs, 1, |_| true).unwrap() };
        assert!(told.told().contains("compensate for it with different values"), "{}", told.told());
    }

    /// Ten campaigns without a change: their p are spread over (0, 1), and none is small enough to be reported.
    #[test]
    fn where_nothing_changes_p_is_spread() {
        let p: Vec<f64> = (0..10)
            .map(|seed| {
                let (fit, runs) = fitted(1.0, seed);
                most_changed(&fit, &runs, 1, |_| true).unwrap().p_value
            })
            .collect();
        assert!(p.iter().all(|p| *p >= LEVEL), "{p:?}");
        let mean = p.iter().sum::<f64>() / 10.0;
        // mean of ten uniform numbers: 0.5 ± 0.09, to three standard deviations
        assert!((mean - 0.5).abs() < 0.27, "{p:?}");
    }
}
