//! The report of a campaign: results as text, tables and figures.
//!
//! The first screen gives the answer: the verdict, the gap, the worst held-out run, parameters and
//! noise. Then follow the missing effects, the quality of prediction, the model with its equations,
//! the evidence, and at the end how the report was made.

mod belief;
mod discovery;
mod drag;
mod force;
mod model;
mod motion;
mod noise;
#[cfg(feature = "view")]
mod origin;
mod prediction;

use std::path::Path;

pub use discovery::gap_figure;
pub use motion::motion_figure;
#[cfg(feature = "view")]
pub use origin::{Unhashed, origin};

use crate::campaign::codes::LACKING;
use crate::campaign::{self, Campaign, Comparison, EachRun, Error, Fit, FitOptions, Noise, Published, Simulation};
use crate::discover::{Discovery, NO_NAME, Verdict};
use crate::finding::{Finding, Severity};
use crate::frame::Measured;
use crate::report::{Block, Check, Document, Light, Origin, Section, render};
use crate::run::Role;
use crate::wording::listed;

/// Number of standard deviations to either side that contain 95 % of a normal distribution.
const COVER: f64 = 1.96;

/// Note beside a standard deviation of a fit that did not converge.
const NOT_CONVERGED: &str = "not converged";

/// Input of a report.
#[derive(Debug, Clone, Copy)]
pub struct Results<'a> {
    /// The campaign.
    pub campaign: &'a Campaign,
    /// Its fit.
    pub fit: &'a Fit,
    /// The comparison of the fit with all runs.
    pub comparison: &'a Comparison,
    /// The runs simulated with the fit.
    pub simulation: &'a Simulation,
    /// The models and estimates of each run alone.
    pub each_run: &'a EachRun,
    /// The search for missing effects, if there was one.
    pub discovery: Option<&'a Discovery>,
    /// Published values of its parameters, if there are any.
    pub published: Option<&'a Published>,
}

/// Makes a document from results; `origin` says how they were made.
pub fn document(results: &Results<'_>, origin: Origin) -> Document {
    let name = match results.campaign.vehicle.name.as_str() {
        "" => "Vehicle",
        name => name,
    };
    let mut sections: Vec<Section> = results.discovery.map(discovery::section).into_iter().collect();
    sections.push(prediction::section(results));
    sections.extend(motion::sections(results));
    sections.push(model::section(results));
    sections.extend(force::section(results));
    let gap = results.discovery.and_then(gap_figure);
    let figures = gap.into_iter().chain(motion::worst(results)).map(Block::Figure);
    // the small table first: it fits beside the worst run
    let tables = [noise::of_forces(results), Some(model::parameters(results)), noise::of_sensors(results)];
    Document {
        title: format!("{name}: identification"),
        subtitle: format!("{} runs, estimator {}", results.campaign.runs.len(), results.fit.estimator.name()),
        verdict: verdict(results),
        checks: checks(results),
        first_screen: figures.chain(tables.into_iter().flatten().map(Block::Table)).collect(),
        sections,
        origin,
    }
}

/// The report of a campaign with the best available model: the one with the effects that the
/// discovery added, fitted to the runs that the discovery used, beside `published` values.
///
/// # Errors
/// [`Error`] if the campaign cannot be fitted or simulated.
pub fn document_of(
    campaign: &Campaign,
    found: Option<&Discovery>,
    published: Option<&Published>,
    origin: Origin,
) -> Result<Document, Error> {
    let mut campaign = campaign.clone();
    if let Some(model) = found.filter(|d| !d.effects.is_empty()).and_then(Discovery::model) {
        campaign.model = model.clone();
    }
    campaign.model.input = found.and_then(|d| d.input).unwrap_or(campaign.model.input);
    // runs that the discovery needed also take part in the fit
    let took_part = found.map_or(&[][..], |d| &d.took_part);
    for run in campaign.runs.iter_mut().filter(|run| took_part.contains(&run.name)) {
        run.role = Role::Train;
    }
    let campaign = &campaign;
    let fitted = campaign::fit(campaign, FitOptions::default())?;
    let under = campaign.under(&fitted.efficiency).with_noise(fitted.model_noise());
    let comparison = campaign::compare(&under, &fitted.model, &fitted.envelope)?;
    let simulation = campaign::simulate(&under, &fitted.model, &fitted.envelope)?;
    let each_run = campaign::each_run(campaign, &fitted);
    let results = Results {
        campaign,
        fit: &fitted,
        comparison: &comparison,
        simulation: &simulation,
        each_run: &each_run,
        discovery: found,
        published,
    };
    Ok(document(&results, origin))
}

/// [`document_of`] as one HTML page.
///
/// # Errors
/// As [`document_of`].
pub fn page_of(
    campaign: &Campaign,
    found: Option<&Discovery>,
    published: Option<&Published>,
    origin: Origin,
) -> Result<String, Error> {
    Ok(render(&document_of(campaign, found, published, origin)?))
}

/// Name of a run without its file extension.
fn stem(run: &str) -> &str {
    Path::new(run).file_stem().and_then(|s| s.to_str()).unwrap_or(run)
}

/// The sentence at the top.
fn verdict(results: &Results<'_>) -> String {
    let held: Vec<_> = results.comparison.runs.iter().filter(|r| r.role == Role::Validate).collect();
    let judged = if held.is_empty() { results.comparison.runs.iter().collect() } else { held.clone() };
    let worst = judged.iter().map(|r| r.rms / r.noise_floor.max(f64::MIN_POSITIVE)).fold(0.0, f64::max);
    let (what, is_one) = compared(judged.iter().map(|r| &r.dof));
    let verb = if is_one { "is" } else { "are" };
    let seen = if held.is_empty() { "the runs that it was fitted to" } else { "runs that took no part in the fit" };
    let first = format!("On {seen} the {what} of the model {verb} off by at most {worst:.1} times the sensor noise.");
    let forces = results.fit.noise.as_ref().filter(|noise| !noise.force.is_empty());
    let found = results.discovery.map(|d| Searched {
        sentence: &d.sentence,
        has_names: !d.effects.is_empty(),
        is_closed: is_closed(d),
    });
    spoken(results.fit.converged, &results.fit.sentence, &first, found, forces.map(Noise::sentence).as_deref())
}

/// The compared quantities in words, and whether the verb is singular: velocities, and the
/// positions and angles (`z`, `psi`) of runs that log no velocity.
fn compared<'a>(all: impl Iterator<Item = &'a Measured>) -> (String, bool) {
    let mut named: Vec<&str> = Vec::new();
    for one in all {
        let name = one.dof().map_or(one.channel(), |_| "velocities");
        if !named.contains(&name) {
            named.push(name);
        }
    }
    (listed(&named), matches!(named[..], [one] if one != "velocities"))
}

/// Whether the search leaves nothing but noise.
fn is_closed(found: &Discovery) -> bool {
    matches!(found.verdict, Verdict::NothingMissing | Verdict::Explained)
}

/// Result of a search, for the verdict.
#[derive(Clone, Copy)]
struct Searched<'a> {
    sentence: &'a str,
    has_names: bool,
    /// Whether it leaves nothing but noise.
    is_closed: bool,
}

/// The verdict of fit and search together. If there was a search after a converged fit, its
/// sentence replaces that of the fit: the statement that the model predicts as well as it says
/// would contradict a search that has found a remaining gap. The random force is named once.
fn spoken(converged: bool, fit: &str, errors: &str, found: Option<Searched<'_>>, force: Option<&str>) -> String {
    let mut parts: Vec<&str> = Vec::new();
    match found {
        Some(found) if converged => {
            parts.push(found.sentence);
            parts.extend(found.has_names.then_some("This report describes the model with it."));
            // a search that closes the gap names the force itself
            parts.extend(force.filter(|_| !found.is_closed));
        }
        _ => parts.extend(Some(fit).filter(|fit| !fit.is_empty())),
    }
    parts.push(errors);
    parts.join(" ")
}

fn checks(results: &Results<'_>) -> Vec<Check> {
    let told = results.discovery.map(|d| d.warnings.as_slice()).unwrap_or_default();
    // the search goes further than the scores that suggested it; and the verdict of a converged fit
    // already says that no name was found
    let is_said = |f: &&Finding| match results.discovery {
        Some(_) => f.code == LACKING.code || f.code == NO_NAME.code && results.fit.converged,
        None => false,
    };
    let all = results.fit.warnings.iter().chain(&results.comparison.warnings).chain(told).filter(|f| !is_said(f));
    // one line per code: a finding that holds for every run is shown once
    let mut seen: Vec<Vec<&Finding>> = Vec::new();
    for finding in all.filter(|f| f.severity != Severity::Note) {
        match seen.iter_mut().find(|same| same[0].code == finding.code) {
            Some(same) if same.contains(&finding) => {}
            Some(same) => same.push(finding),
            None => seen.push(vec![finding]),
        }
    }
    let mut checks: Vec<Check> = seen
        .iter()
        .map(|same| Check {
            light: if same[0].severity == Severity::Error { Light::Red } else { Light::Amber },
            code: same[0].code.to_string(),
            text: match same.len() - 1 {
                0 => same[0].message.clone(),
                more => format!("{} (and {more} more of this kind)", same[0].message),
            },
        })
        .collect();
    if checks.is_empty() {
        let text = "Nothing in the logs or the fit needs attention.".to_string();
        checks.push(Check { light: Light::Green, code: String::new(), text });
    }
    checks
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIT: &str = "The fit converged, and the model predicts 8 s ahead as well as it says. The vehicle is pushed by a random force of 1 N.";
    const FORCE: &str = "The vehicle is pushed by a random force of 1 N.";

    #[test]
    fn the_verdict_names_what_was_compared() {
        let (z, psi) = (Measured::Function("z".into()), Measured::Function("psi".into()));
        let yaw = Measured::Velocity(crate::frame::Dof::Yaw);
        assert_eq!(compared([&z, &psi, &z].into_iter()), ("z and psi".to_string(), false));
        assert_eq!(compared([&yaw, &z].into_iter()), ("velocities and z".to_string(), false));
        assert_eq!(compared([&yaw].into_iter()), ("velocities".to_string(), false));
        assert_eq!(compared([&psi].into_iter()), ("psi".to_string(), true));
    }

    #[test]
    fn nothing_contradicts_the_verdict_of_the_search() {
        let partly = Searched { sentence: "Partly explained: something is left.", has_names: true, is_closed: false };
        let text = spoken(true, FIT, "Errors.", Some(partly), Some(FORCE));
        assert!(text.starts_with("Partly explained") && !text.contains("as well as it says"), "{text}");
        assert_eq!(text.matches("random force").count(), 1, "{text}");
        let closed = Searched {
            sentence: "Nothing is missing beyond a random force of 1 N.",
            has_names: false,
            is_closed: true,
        };
        let text = spoken(true, FIT, "Errors.", Some(closed), Some(FORCE));
        assert_eq!(text, "Nothing is missing beyond a random force of 1 N. Errors.");
        assert_eq!(spoken(true, FIT, "Errors.", None, Some(FORCE)), format!("{FIT} Errors."));
        // a fit that did not converge comes first, whatever was found
        assert!(spoken(false, "Do not use these numbers.", "Errors.", Some(partly), None).starts_with("Do not use"));
    }
}
