//! Excitation: what a run shows of each degree of freedom.
//!
//! ```text
//! smallest visible share of term j = 3 σ_j rms(column j)/max(rms(Δν), rms(column of the commands))
//! ```
//!
//! The commands count as one term, that of the inertia; σ_j is the standard deviation of its
//! coefficient in the quick [`Balance`](super::balance), which grows with the noise and with the
//! correlation of the columns. A share below 0.2 is shown well; above 1 the term could be as large
//! as the whole motion and not be seen. If drag balances the commands, these are the largest part
//! of the motion, and the change of velocity is a small difference. Short windows follow a fast
//! motion, long ones raise a slow motion above the noise: the length that shows most is used.

use serde::Serialize;

use super::balance::{Balance, Term, WINDOW};
use super::codes;
use super::commands::is_command;
use super::fins;
use super::motion::{self, Moved};
use super::options::CheckOptions;
use super::report::Found;
use crate::frame::Dof;
use crate::log::number::short;
use crate::run::Run;

/// Largest share at which a term counts as shown.
const SHOWN: f64 = 0.5;
/// Least share of the changes of velocity, after the other terms, that the commands must explain.
const OWED: f64 = 0.2;
/// Standard deviations by which the gain of the commands must differ from zero if a righting
/// moment, known from the angle, explains most of the motion.
const CERTAIN: f64 = 8.0;
/// Lengths of windows that are tried, relative to the shortest.
const WINDOWS: [f64; 3] = [1.0, 2.0, 4.0];

/// What a run shows of one term.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Visible {
    /// `inertia`, `linear drag`, `quadratic drag`, `Coriolis v r`, `restoring`.
    pub term: String,
    /// Smallest share of the motion at which this term would still be seen.
    pub smallest_share: f64,
}

/// What a run shows of one degree of freedom.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Excitation {
    /// Degree of freedom.
    pub dof: Dof,
    /// Its commands.
    pub commands: Vec<String>,
    /// Change of velocity over a window, relative to the noise of such a change.
    pub signal_to_noise: f64,
    /// Mean of the velocity, and standard deviation about it, SI.
    pub speed: [f64; 2],
    /// Share of the changes of velocity, after the other terms, that the commands explain.
    pub explained: f64,
    /// Condition number of the scaled columns.
    pub condition: f64,
    /// Figures of each term.
    pub terms: Vec<Visible>,
    /// One plain sentence.
    pub sentence: String,
    /// Whether inertia and drag can be estimated from this run.
    pub enough: bool,
    /// Whether the velocity is known from positions only, whose noise hides the effect of a varying
    /// command: a filter may still see it.
    #[serde(skip)]
    pub hidden_by_noise: bool,
}

/// Returns what a run shows of `dof`, with windows of the length that shows most.
pub fn of_run(run: &Run, dof: Dof) -> Option<Excitation> {
    let over = |times: f64| measure(&Balance::over(run, dof, times * WINDOW)?);
    let hidden = |e: &Excitation| {
        let drag = e.terms[1].smallest_share.min(e.terms[2].smallest_share);
        (e.terms[0].smallest_share / SHOWN).max(drag / (2.0 * SHOWN))
    };
    let better = |a: &Excitation, b: &Excitation| b.enough.cmp(&a.enough).then(hidden(a).total_cmp(&hidden(b)));
    let mut found = WINDOWS.into_iter().filter_map(over).min_by(better)?;
    if !found.enough && run.signal(dof.velocity()).is_none() {
        found.hidden_by_noise = true;
        found.sentence = format!(
            "{dof} has no velocity sensor, and the position noise hides the effect of its commands from this quick \
             check: a fit, which filters, may still see it"
        );
    }
    Some(found)
}

/// Returns what a balance shows.
pub fn measure(balance: &Balance) -> Option<Excitation> {
    let each = balance.fit(0.0)?;
    let (fit, sizes) = balance.with_commands_as_one(&each)?;
    let (change, noise) = (balance.change(), balance.nu.noise());
    if change <= 0.0 {
        return None;
    }
    let others = balance.terms.iter().filter(|term| !is_command(term));
    let named = others.filter_map(|term| match term {
        Term::Command(_) | Term::Constant => None,
        Term::Linear => Some("linear drag".to_string()),
        Term::Quadratic => Some("quadratic drag".to_string()),
        Term::Product(a, b) => Some(format!("Coriolis {a} {b}")),
        Term::Restoring => Some("restoring".to_string()),
    });
    // the constant, which has no name here, is the last column
    let visible = |(k, term)| Visible { term, smallest_share: 3.0 * fit.std[k] * sizes[k] / change.max(sizes[0]) };
    let terms: Vec<Visible> = std::iter::once("inertia".to_string()).chain(named).enumerate().map(visible).collect();
    let explained = balance.owed_to_commands(&each);
    let values = balance.nu.values();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let spread = (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt();
    let drag = terms[1].smallest_share.min(terms[2].smallest_share);
    let righted = balance.terms.contains(&Term::Restoring) && fit.theta[0] > CERTAIN * fit.std[0];
    let enough = (explained >= OWED || righted) && terms[0].smallest_share <= SHOWN && drag <= 2.0 * SHOWN;
    let dof = balance.dof;
    let sentence = sentence(dof, [mean, spread], explained, &terms, enough);
    Some(Excitation {
        dof,
        commands: balance.channels().iter().map(ToString::to_string).collect(),
        signal_to_noise: if noise > 0.0 { change / (noise * 2f64.sqrt()) } else { f64::INFINITY },
        speed: [mean, spread],
        explained,
        condition: fit.condition,
        terms,
        sentence,
        enough,
        hidden_by_noise: false,
    })
}

fn sentence(dof: Dof, [mean, spread]: [f64; 2], explained: f64, terms: &[Visible], enough: bool) -> String {
    let list =
        |f: &dyn Fn(&&Visible) -> bool| terms.iter().filter(f).map(|t| t.term.as_str()).collect::<Vec<_>>().join(", ");
    if enough {
        let (well, weak) = (list(&|t| t.smallest_share <= SHOWN), list(&|t| t.smallest_share > SHOWN));
        let rest = if weak.is_empty() { String::new() } else { format!("; not {weak}") };
        return format!("{dof}: this run can show {well}{rest}");
    }
    let held = if mean.abs() > 3.0 * spread {
        format!("{} stays at {} ± {}", dof.velocity(), short(mean, 2), short(spread, 2))
    } else {
        format!("{} moves by {} about {}", dof.velocity(), short(spread, 2), short(mean, 2))
    };
    let share = |x: f64| short(100.0 * x.max(0.0), 2);
    if explained < OWED {
        return format!(
            "{dof} is not excited enough: {held} and its commands explain {} % of its changes, so inertia and drag \
             cannot be identified from this run; vary the command of {dof} (a sine or steps) without a controller",
            share(explained)
        );
    }
    let hidden = terms.iter().take(3).max_by(|a, b| a.smallest_share.total_cmp(&b.smallest_share));
    let (term, least) = hidden.map_or(("inertia", 0.0), |t| (t.term.as_str(), t.smallest_share));
    let much = match least < 1.0 {
        true => format!("{} % of the motion", share(least)),
        false => "as much as the motion itself".to_string(),
    };
    format!(
        "{dof} does not separate its inertia from its drag: {held} and its commands explain {} % of its changes, but \
         {term} could be {much} without being visible; run longer, vary amplitude and frequency of the command, or log \
         faster",
        share(explained)
    )
}

/// Finds degrees of freedom that were asked for but that the run cannot show. If none was asked for,
/// those of the model are checked whose own command varies, or which move without a command of their
/// own. Not checked then are those without a command of their own that a fin drives, and surge if the
/// angle of a fin varies: turns slow the vehicle whatever the thruster does.
pub fn judge(run: &Run, excitation: &[Excitation], options: &CheckOptions) -> Vec<Found> {
    let asked = &options.dofs;
    let moves = |dof: Dof| motion::of(&run.signals, dof) == Moved::Moves;
    let steered = fins::steered(run);
    let is_asked = |e: &&Excitation| match asked.is_empty() {
        true if run.signal(e.dof.force()).is_none() && steered.contains(&e.dof) => false,
        true if e.dof == Dof::Surge && !steered.is_empty() => false,
        true if !options.model.is_empty() && !options.model.contains(&e.dof) => false,
        true => e.commands.iter().any(|c| c == e.dof.force()) || run.signal(e.dof.force()).is_none() && moves(e.dof),
        false => asked.contains(&e.dof),
    };
    let short_of = excitation.iter().filter(is_asked).filter(|e| !e.enough && !e.hidden_by_noise);
    let mut found: Vec<Found> =
        short_of.map(|e| Found::new(&codes::EXCITATION, &[e.dof.velocity()], e.sentence.clone())).collect();
    for dof in asked.iter().filter(|d| excitation.iter().all(|e| e.dof != **d)) {
        let text = format!(
            "{dof} is requested, but this run has no velocity {} with a command that varies: it shows nothing of it",
            dof.velocity()
        );
        found.push(Found::new(&codes::EXCITATION, &[dof.velocity()], text));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;
    use crate::run::Signal;

    /// Two thrusters that are always driven against each other act as one: their separate effects
    /// need not be known.
    #[test]
    fn thrusters_that_push_together_show_what_one_would() {
        let time: std::sync::Arc<[f64]> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
        let mut noise = Noise::new(1, 1);
        // random steps, which ṙ = V₁ − r follows
        let (mut force, mut rate) = (0.0, 0.0);
        let (mut first, mut second, mut r) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..time.len() {
            if k % 15 == 0 {
                force = noise.normal();
            }
            first.push(force + 1e-3 * noise.normal());
            second.push(-force + 1e-3 * noise.normal());
            r.push(rate + 2e-3 * noise.normal());
            rate += 0.1 * (force - rate);
        }
        let mut run = Run::default();
        for (name, values) in [("V1", first), ("V2", second), ("r", r)] {
            run.signals.insert(name.into(), Signal::new(time.clone(), values));
        }
        let found = measure(&Balance::new(&run, Dof::Yaw).unwrap()).unwrap();
        assert_eq!(found.commands, ["V1", "V2"]);
        assert!(found.enough && found.terms[0].smallest_share < 0.1, "{found:?}");
    }

    /// If commands explain the motion but noise hides a term, the message gives its size, not a
    /// lack of commands.
    #[test]
    fn the_reason_is_told() {
        let of = |inertia: f64| Visible { term: "inertia".into(), smallest_share: inertia };
        let drag = ["linear drag", "quadratic drag"].map(|term| Visible { term: term.into(), smallest_share: 1.4 });
        let terms: Vec<Visible> = std::iter::once(of(0.1)).chain(drag).collect();
        let told = sentence(Dof::Yaw, [0.0, 0.3], 0.98, &terms, false);
        assert!(
            told.contains("explain 98 %") && told.contains("quadratic drag could be as much as the motion itself"),
            "{told}"
        );
        let told = sentence(Dof::Yaw, [0.0, 0.3], 0.05, &terms, false);
        assert!(told.contains("not excited enough") && told.contains("explain 5 %"), "{told}");
    }
}
