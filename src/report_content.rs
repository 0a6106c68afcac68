//! The account of a campaign: results put into the words, tables and figures of a report.
//!
//! The first screen answers: the verdict, the gap, the worst run that took no part, parameters and noise. Then what is
//! missing, how well the model predicts, the model with its equations, the evidence, and at the end how it was made.

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

use crate::campaign::{self, Campaign, Comparison, EachRun, Error, Fit, FitOptions, Published, Simulation};
use crate::discover::Discovery;
use crate::finding::{Finding, Severity};
use crate::report::{Block, Check, Document, Light, Origin, Section, render};
use crate::run::Role;

/// Beside a deviation of a fit that did not converge, on the line where it stands.
const NOT_CONVERGED: &str = "not converged";

/// What a report is made from.
#[derive(Debug, Clone, Copy)]
pub struct Results<'a> {
    /// The campaign.
    pub campaign: &'a Campaign,
    /// Its fit.
    pub fit: &'a Fit,
    /// The fit held against all runs.
    pub comparison: &'a Comparison,
    /// The runs simulated with the fit.
    pub simulation: &'a Simulation,
    /// What each run says alone.
    pub each_run: &'a EachRun,
    /// What the model lacks, where it was asked.
    pub discovery: Option<&'a Discovery>,
    /// Published values of its parameters, where there are any.
    pub published: Option<&'a Published>,
}

/// Puts results into a document; `origin` says how they were made.
pub fn account(results: &Results<'_>, origin: Origin) -> Document {
    let name = match results.campaign.vehicle.name.as_str() {
        "" => "Vehicle",
        name => name,
    };
    let mut sections: Vec<Section> = results.discovery.map(discovery::section).into_iter().collect();
    sections.push(prediction::section(results));
    sections.extend(motion::sections(results));
    sections.push(model::section(results));
    sections.extend(force::section(results));
    let gap = results.discovery.filter(|found| found.gap.len() > 1).and_then(gap_figure);
    let figures = gap.into_iter().chain(motion::worst(results)).map(Block::Figure);
    let tables = std::iter::once(model::parameters(results)).chain(noise::tables(results)).map(Block::Table);
    Document {
        title: format!("{name}: identification"),
        subtitle: format!("{} runs, estimator {}", results.campaign.runs.len(), results.fit.estimator.name()),
        verdict: verdict(results),
        checks: checks(results),
        first_screen: figures.chain(tables).collect(),
        sections,
        origin,
    }
}

/// The report of a campaign as one HTML page: of the best model that there is, with what the discovery has added, beside
/// `published` values.
///
/// # Errors
/// [`Error`] where the campaign cannot be fitted or simulated.
pub fn page_of(
    campaign: &Campaign,
    found: Option<&Discovery>,
    published: Option<&Published>,
    origin: Origin,
) -> Result<String, Error> {
    let mut campaign = campaign.clone();
    if let Some(model) = found.filter(|d| !d.effects.is_empty()).and_then(Discovery::model) {
        campaign.model = model.clone();
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
    Ok(render(&account(&results, origin)))
}

/// Name of a run without the ending of its file.
fn stem(run: &str) -> &str {
    Path::new(run).file_stem().and_then(|s| s.to_str()).unwrap_or(run)
}

/// The sentence at the top.
fn verdict(results: &Results<'_>) -> String {
    let held: Vec<_> = results.comparison.runs.iter().filter(|r| r.role == Role::Validate).collect();
    let judged = if held.is_empty() { results.comparison.runs.iter().collect() } else { held.clone() };
    let worst = judged.iter().map(|r| r.rms / r.noise_floor.max(f64::MIN_POSITIVE)).fold(0.0, f64::max);
    let seen = if held.is_empty() { "the runs that it was fitted to" } else { "runs that took no part in the fit" };
    let first = format!("On {seen} the model's velocities are off by at most {worst:.1} times the sensor noise.");
    let second = match results.discovery {
        None => String::new(),
        Some(d) if d.effects.is_empty() => format!(" {}", d.sentence),
        Some(d) => format!(" {} This report is of the model with it.", d.sentence),
    };
    let fit = &results.fit.sentence;
    if fit.is_empty() { first + &second } else { format!("{fit} {first}{second}") }
}

fn checks(results: &Results<'_>) -> Vec<Check> {
    let told = results.discovery.map(|d| d.warnings.as_slice()).unwrap_or_default();
    let all = results.fit.warnings.iter().chain(&results.comparison.warnings).chain(told);
    // one line a code: what is said of every run need not be read for every run
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
        let text = "Nothing in the logs or the fit asks for attention.".to_string();
        checks.push(Check { light: Light::Green, code: String::new(), text });
    }
    checks
}
