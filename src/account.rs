//! The account of a campaign: results put into the words, tables and figures of a report.
//!
//! First what a reader wants to know (does the model predict runs that took no part, and what is missing), then the
//! model with its numbers, then the evidence, at the end how it was made.

mod discovery;

use std::collections::BTreeMap;

pub use discovery::gap_figure;

use crate::campaign::{self, Campaign, Comparison, Error, Fit, FitOptions, Simulation};
use crate::discover::{Discovery, Verdict};
use crate::finding::{Finding, Severity};
use crate::frame::Dof;
use crate::report::{
    Axis, Block, Cell, Chart, Check, Column, Curves, Document, Equation, Figure, Label, Light, Origin, Panel, Section,
    Series, Table, render,
};
use crate::run::Role;
use crate::thrust::fit::Estimate;

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
    /// What the model lacks, where it was asked.
    pub discovery: Option<&'a Discovery>,
}

/// Puts results into a document; `origin` says how they were made.
pub fn account(results: &Results<'_>, origin: Origin) -> Document {
    let name = match results.campaign.vehicle.name.as_str() {
        "" => "Vehicle",
        name => name,
    };
    let mut sections = vec![model_section(results), comparison_section(results), motion_section(results)];
    sections.extend(force_section(results));
    sections.extend(results.discovery.map(|d| discovery::section(results, d)));
    Document {
        title: format!("{name}: identification"),
        subtitle: format!("{} runs, estimator {}", results.campaign.runs.len(), results.fit.estimator.name()),
        verdict: verdict(results),
        checks: checks(results),
        sections,
        origin,
    }
}

/// The report of a campaign as one HTML page: of the best model that there is, with what the discovery has added.
///
/// # Errors
/// [`Error`] where the campaign cannot be fitted or simulated.
pub fn page_of(campaign: &Campaign, found: Option<&Discovery>, origin: Origin) -> Result<String, Error> {
    let mut campaign = campaign.clone();
    if let Some(model) = found.filter(|d| !d.effects.is_empty()).and_then(Discovery::model) {
        campaign.model = model.clone();
    }
    let campaign = &campaign;
    let fitted = campaign::fit(campaign, FitOptions::default())?;
    let under = campaign.under(&fitted.efficiency);
    let comparison = campaign::compare(&under, &fitted.model, &fitted.envelope)?;
    let simulation = campaign::simulate(&under, &fitted.model, &fitted.envelope)?;
    let results =
        Results { campaign, fit: &fitted, comparison: &comparison, simulation: &simulation, discovery: found };
    Ok(render(&account(&results, origin)))
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
        Some(d) => {
            let names: Vec<&str> = d.effects.iter().map(|e| e.id.as_str()).collect();
            match d.verdict {
                Verdict::NothingMissing => " Nothing is missing from the model that this data could show.".to_string(),
                Verdict::Explained => {
                    format!(" What it lacks is {}: with it the gap closes to the noise.", names.join(" and "))
                }
                Verdict::PartlyExplained => {
                    format!(
                        " Part of what it lacks is {}; something is left that no known effect explains.",
                        names.join(" and ")
                    )
                }
                Verdict::Unexplained => " Something is missing that no known effect explains.".to_string(),
            }
        }
    };
    first + &second
}

fn checks(results: &Results<'_>) -> Vec<Check> {
    let told = results.discovery.map(|d| d.warnings.as_slice()).unwrap_or_default();
    let all = results.fit.warnings.iter().chain(&results.comparison.warnings).chain(told);
    let mut seen: Vec<&Finding> = Vec::new();
    for finding in all.filter(|f| f.severity != Severity::Note) {
        if !seen.contains(&finding) {
            seen.push(finding);
        }
    }
    let mut checks: Vec<Check> = seen
        .iter()
        .map(|f| Check {
            light: if f.severity == Severity::Error { Light::Red } else { Light::Amber },
            code: f.code.to_string(),
            text: f.message.clone(),
        })
        .collect();
    if checks.is_empty() {
        let text = "Nothing in the logs or the fit asks for attention.".to_string();
        checks.push(Check { light: Light::Green, code: String::new(), text });
    }
    checks
}

fn model_section(results: &Results<'_>) -> Section {
    let rows = results
        .fit
        .parameters
        .iter()
        .map(|p| {
            let place = [p.dof, p.other].iter().flatten().map(|d| d.name()).collect::<Vec<_>>().join(":");
            vec![
                Cell::from(p.effect.as_str()),
                Cell::from(place.as_str()),
                Cell::Text(Label::symbol(&p.name)),
                Cell::Estimate { value: p.value, std: p.std.filter(|_| !p.fixed) },
                Cell::from(crate::report::unit(&p.unit).as_str()),
                p.sname.as_ref().map_or(Cell::Empty, |s| Cell::Text(Label::symbol(s))),
                p.sname_value.map_or(Cell::Empty, |value| Cell::Number { value, digits: 5 }),
            ]
        })
        .collect();
    let columns = ["effect", "degree of freedom", "symbol", "value ± std", "unit", "SNAME", "value"];
    let table = Table {
        title: "Parameters".into(),
        columns: columns.into_iter().map(|c| Column::new(c, "")).collect(),
        rows,
        note: format!(
            "Standard deviations: {}. SNAME's values have the opposite sign; an inertia's is its added part.",
            results.fit.std_method
        ),
    };
    let equations = results.fit.model.dofs.iter().map(|dof| equation(results, *dof)).collect();
    Section {
        heading: "The model".into(),
        paragraphs: vec![
            "Balance of momentum in body axes, forward-starboard-down; drag and bias stand with a minus.".into(),
        ],
        blocks: [Block::Equations(equations), Block::Table(table)]
            .into_iter()
            .chain(thrust_curves(results))
            .chain(belief(results))
            .collect(),
    }
}

/// Curves of thrusters that were found from bollard tables, equation (1).
fn thrust_curves(results: &Results<'_>) -> Option<Block> {
    let curves = &results.fit.thrusters;
    let rows = curves.iter().flat_map(|curve| {
        [("forward", curve.forward), ("reverse", curve.reverse)].map(|(way, side)| {
            let estimate = |e: Estimate| Cell::Estimate { value: e.value, std: Some(e.std).filter(|std| *std > 0.0) };
            vec![
                Cell::from(curve.thrusters.join(", ").as_str()),
                Cell::from(curve.file.as_str()),
                Cell::from(way),
                estimate(side.a),
                estimate(side.b),
                estimate(curve.deadband),
                curve.supply_exponent.map_or(Cell::Empty, estimate),
                Cell::Number { value: side.rows as f64, digits: 5 },
                Cell::Number { value: side.residual_std, digits: 3 },
            ]
        })
    });
    let columns = ["thruster", "table", "direction", "a", "b", "dead band", "supply exponent", "rows", "residual, N"];
    (!curves.is_empty()).then(|| {
        Block::Table(Table {
            title: "Thrusters at bollard pull".into(),
            columns: columns.into_iter().map(|c| Column::new(c, "")).collect(),
            rows: rows.collect(),
            note: "|F| = (a x\u{b2} + b x)(V_s/V_ref)\u{207f} with x the command beyond the dead band; equation (1)."
                .into(),
        })
    })
}

/// What speaks for each estimate.
fn belief(results: &Results<'_>) -> Option<Block> {
    let known = results.fit.identifiability.as_ref()?;
    let number = |x: Option<f64>, digits| x.map_or(Cell::Empty, |value| Cell::Number { value, digits });
    let rows = known
        .parameters
        .iter()
        .map(|p| {
            vec![
                Cell::from(p.term.as_str()),
                Cell::Text(Label::symbol(&p.name)),
                number(p.force_share.map(|s| 100.0 * s), 3),
                number(Some(p.inflation), 3),
                number(p.first_half, 4),
                number(p.second_half, 4),
                number(p.halves_z, 2),
            ]
        })
        .collect();
    let columns = ["term", "symbol", "share of force, %", "inflation", "first half", "second half", "apart, std"];
    let groups: Vec<String> =
        known.groups.iter().map(|g| format!(" Hardly told apart: {}; {}.", g.terms.join(", "), g.run)).collect();
    Some(Block::Table(Table {
        title: "What speaks for the estimates".into(),
        columns: columns.into_iter().map(|c| Column::new(c, "")).collect(),
        rows,
        note: format!(
            "Inflation: deviation over that with all other parameters known. Halves: estimates from the first and the second half of each run.{}",
            groups.concat()
        ),
    }))
}

/// The balance of one degree of freedom, with its numbers where an effect has one parameter.
fn equation(results: &Results<'_>, dof: Dof) -> Equation {
    let model = &results.fit.model;
    let v = dof.velocity();
    let value = |p: usize| crate::report::number(model.parameters[p].value.abs(), 4, crate::report::Style::Text);
    let here = |t: &&crate::model::Term| {
        t.place.dof == Some(dof) || (t.place.dof.is_none() && t.effect.about().id.ends_with(dof.name()))
    };
    let mut inertia = format!("m_{v}");
    let mut right = format!("τ_{v}");
    for term in model.terms.iter().filter(here) {
        let about = term.effect.about();
        let formula = about.formula.split(',').next().unwrap_or_default().replace("νᵢ", v);
        match (about.id, term.parameters.as_slice()) {
            ("inertia", [p]) => inertia = value(*p),
            // one coefficient, written first after its sign
            (_, [p]) if formula.starts_with("−d ") || formula.starts_with("− k_uv ") => {
                let sign = if model.parameters[*p].value < 0.0 { '+' } else { '−' };
                let product = formula.trim_start_matches("−d ").trim_start_matches("− k_uv ");
                right += &format!(" {sign} {} {product}", value(*p));
            }
            (_, [p]) if formula == "−b" => {
                let sign = if model.parameters[*p].value < 0.0 { '+' } else { '−' };
                right += &format!(" {sign} {}", value(*p));
            }
            _ => right += &format!(" {formula}"),
        }
    }
    Equation { formula: format!("{inertia} {v}̇ = {right}"), note: dof.name().into() }
}

fn comparison_section(results: &Results<'_>) -> Section {
    let rows = results
        .comparison
        .runs
        .iter()
        .map(|r| {
            let number = |value| Cell::Number { value, digits: 3 };
            vec![
                Cell::from(r.run.as_str()),
                Cell::from(if r.role == Role::Train { "fit" } else { "held out" }),
                Cell::from(r.dof.to_string().as_str()),
                number(r.mean_abs),
                number(r.std_abs),
                number(r.rms),
                number(r.noise_floor),
                number(r.fit_percent),
                Cell::from(r.unit.as_str()),
            ]
        })
        .collect();
    let columns = ["run", "role", "degree of freedom", "mean |error|", "std |error|", "rms", "noise", "fit, %", "unit"];
    let table = Table {
        title: "Simulation against measurement, equation (25)".into(),
        columns: columns.into_iter().map(|c| Column::new(c, "")).collect(),
        rows,
        note: String::new(),
    };
    Section { heading: "How well it predicts".into(), paragraphs: Vec::new(), blocks: vec![Block::Table(table)] }
}

/// Measured and simulated velocities with the residual below, of held-out runs first; a handful of runs.
fn motion_section(results: &Results<'_>) -> Section {
    const SHOWN: usize = 4;
    let mut runs: Vec<_> = results.simulation.runs.iter().collect();
    let held: BTreeMap<&str, bool> =
        results.campaign.runs.iter().map(|r| (r.name.as_str(), r.role == Role::Validate)).collect();
    runs.sort_by_key(|r| !held.get(r.run.as_str()).copied().unwrap_or(false));
    let mut blocks = Vec::new();
    for run in runs.into_iter().take(SHOWN) {
        for dof in &results.fit.model.dofs {
            let channel = dof.velocity();
            let (Some(simulated), Some(measured)) = (run.simulated.get(channel), run.measured.get(channel)) else {
                continue;
            };
            let unit = if dof.is_rotation() { "rad/s" } else { "m/s" };
            let samples: Vec<(f64, f64, f64)> =
                run.time.iter().zip(measured).zip(simulated).filter_map(|((t, y), x)| y.map(|y| (*t, y, *x))).collect();
            let column = |f: &dyn Fn(&(f64, f64, f64)) -> f64| samples.iter().map(f).collect::<Vec<f64>>();
            let t = column(&|s| s.0);
            let top = Panel {
                y: Axis::new(Label::symbol(channel), unit),
                series: vec![
                    Series::points("measured", t.clone(), column(&|s| s.1)),
                    Series::line("simulated", run.time.clone(), simulated.clone()),
                ],
                floor: None,
            };
            let noise =
                results.comparison.runs.iter().find(|r| r.run == run.run && r.dof == *dof).map(|r| r.noise_floor);
            let strip = Panel {
                y: Axis::new("residual", unit),
                series: vec![Series::points("residual", t, column(&|s| s.1 - s.2)), Series::line("", vec![], vec![])],
                floor: noise,
            };
            let chart =
                Chart::Curves(Curves { x: Axis::new("time", "s"), panels: vec![top, strip], spans: Vec::new() });
            let role = if held.get(run.run.as_str()) == Some(&true) {
                "took no part in the fit"
            } else {
                "was part of the fit"
            };
            blocks.push(Block::Figure(Figure {
                title: format!("{}, {dof}", run.run),
                caption: format!("This run {role}. The simulation starts from a state estimated on the first seconds."),
                chart,
            }));
        }
    }
    Section { heading: "Measured and simulated".into(), paragraphs: Vec::new(), blocks }
}

/// Force of each term over time, Fig. 11 of the paper: of the longest run, each degree of freedom.
fn force_section(results: &Results<'_>) -> Option<Section> {
    let campaign = results.campaign.under(&results.fit.efficiency);
    let parts = campaign::components(&campaign, &results.fit.model).runs;
    let longest = parts.iter().max_by_key(|p| p.time.len())?.run.clone();
    let figure = |part: &campaign::RunComponents| {
        let series =
            |(name, force): (&String, &Vec<f64>)| Series::line(name.as_str(), part.time.clone(), force.clone());
        let panel = Panel {
            y: Axis::new("force", part.unit.replace('*', "\u{b7}").as_str()),
            series: part.terms.iter().chain([(&"total".to_string(), &part.total)]).map(series).collect(),
            floor: None,
        };
        Block::Figure(Figure {
            title: format!("{}, {}: forces", part.run, part.dof),
            caption: "Force of each term on the vehicle at the logged motion; their sum is what accelerates it.".into(),
            chart: Chart::Curves(Curves { x: Axis::new("time", "s"), panels: vec![panel], spans: Vec::new() }),
        })
    };
    let blocks = parts.iter().filter(|p| p.run == longest).map(figure).collect();
    Some(Section { heading: "Forces over time".into(), paragraphs: Vec::new(), blocks })
}
