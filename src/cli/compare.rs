//! The verb `compare`: a model or published parameters against the runs of a campaign, or two models against each other.

use super::arguments::Compare;
use super::failure::Failure;
use super::output::Output;
use super::table::{chance, measured, number, size, table, wrapped};
use super::verbs::{Chosen, chosen, load, may_hold_series, write_series};
use super::{noise, plot};
use crate::campaign::{self, Crossed, EachRun, FitOptions, ModelDifference, Noise, Published, PublishedComparison};
use crate::compare::Disagreement;
use crate::frame::Dof;

pub(super) fn compare(a: &Compare, output: &Output) -> Result<(), Failure> {
    may_hold_series(a.series.series.as_deref(), output)?;
    if let Some(other) = &a.other {
        let found = campaign::difference_of(&a.campaign, other)?;
        print_difference(&found, output);
        output.json(&found)?;
        return output.tell(&found.warnings);
    }
    if a.cross {
        let loaded = load(&a.campaign, &a.loading, output)?;
        let fitted = output.working("fitting", || campaign::fit(&loaded, FitOptions::default()))??;
        let found = output.working("each run alone", || campaign::each_run(&loaded, &fitted))?;
        print_crossed(&found, output);
        return output.json(&found);
    }
    let Chosen { campaign, model, envelope } = chosen(&a.campaign, a.model.as_deref(), &a.loading, output)?;
    let Some(params) = &a.params else {
        let result = output.working("simulating", || campaign::compare(&campaign, &model, &envelope))??;
        if let Some(path) = &a.series.series {
            write_series(&campaign::simulate(&campaign, &model, &envelope)?, path, output)?;
        }
        output.print(&runs(&result.runs, result.noise.as_ref()));
        if let Some(found) = &result.noise {
            forces(found, output);
        }
        plot::of_model(a.plotting.plot.as_deref(), &campaign, &model, output)?;
        output.json(&result)?;
        return output.tell(&result.warnings);
    };
    let published = Published::read(params, &campaign)?;
    let result = output
        .working("simulating", || campaign::compare_published(&campaign, &model, &envelope, &published, params))??;
    print_published(&result, output);
    plot::of_model(a.plotting.plot.as_deref(), &campaign, &model, output)?;
    output.json(&result)?;
    output.tell(&result.warnings)
}

/// The random force in words, and with `--verbose` how each run is predicted.
fn forces(found: &Noise, output: &Output) {
    output.print(&wrapped(&found.sentence()));
    if output.is_verbose() {
        noise::by_run(found, output);
    }
}

/// Measured against simulated; beside the noise of the sensor the error of a free run that the noise lets expect.
fn runs(rows: &[Disagreement], found: Option<&Noise>) -> String {
    let rows: Vec<Vec<String>> = rows
        .iter()
        .map(|r| {
            vec![
                r.run.clone(),
                format!("{:?}", r.role).to_lowercase(),
                r.dof.to_string(),
                format!("{} ± {}", size(r.mean_abs), size(r.std_abs)),
                size(r.rms),
                size(r.noise_floor),
                noise::expected(found, &r.run, r.dof.dof()).map_or("-".into(), size),
                format!("{:.1}", r.fit_percent),
                r.unit.clone(),
            ]
        })
        .collect();
    table(&["run", "role", "dof", "|error| (25)", "rms", "noise", "expected", "fit %", "unit"], &rows)
}

/// A matrix a degree of freedom: a row a model, a column a run.
fn print_crossed(found: &EachRun, output: &Output) {
    if found.models.len() < 2 {
        output.print("fewer than two runs can stand alone: there is nothing to cross");
    }
    if !found.left_out.is_empty() {
        output.print(&format!("the longest runs; left out: {}", found.left_out.join(", ")));
    }
    for dof in Dof::ALL {
        let cells: Vec<&Crossed> = found.crossed.iter().filter(|c| c.dof == dof).collect();
        let mut runs: Vec<&str> = Vec::new();
        for cell in &cells {
            if !runs.contains(&cell.run.as_str()) {
                runs.push(&cell.run);
            }
        }
        let row = |model: &str| -> Vec<String> {
            let cell = |run: &&str| {
                let own = cells.iter().find(|c| c.model == model && c.run == **run);
                own.map_or_else(String::new, |c| format!("{} ± {}", size(c.mean_abs), size(c.std_abs)))
            };
            std::iter::once(model.to_string()).chain(runs.iter().map(cell)).collect()
        };
        let models = found.models.iter().filter(|m| cells.iter().any(|c| c.model == m.run));
        let rows: Vec<Vec<String>> = models.map(|m| row(&m.run)).collect();
        if !rows.is_empty() {
            let unit = if dof.is_rotation() { "rad/s" } else { "m/s" };
            output.print(&format!("|error| (25) in {dof}, {unit}:"));
            let heads: Vec<&str> = std::iter::once("model of").chain(runs.iter().copied()).collect();
            output.print(&table(&heads, &rows));
        }
    }
}

fn probability(p: Option<f64>) -> String {
    p.map(chance).unwrap_or_default()
}

fn print_difference(found: &ModelDifference, output: &Output) {
    let rows: Vec<Vec<String>> = found
        .parameters
        .iter()
        .map(|p| {
            vec![
                p.effect.clone(),
                p.name.clone(),
                measured(p.a, p.std_a),
                measured(p.b, p.std_b),
                measured(p.difference, p.std),
                p.z.map(|z| format!("{z:+.1}")).unwrap_or_default(),
                probability(p.p_value),
                p.unit.clone(),
            ]
        })
        .collect();
    output.print(&table(&["term", "symbol", &found.a, &found.b, "difference ± std", "z", "p", "unit"], &rows));
    if let Some(joint) = found.joint {
        let p = chance(joint.p_value);
        output.print(&format!(
            "all together: chi2 = {} on {} degrees of freedom, p {}{p}",
            number(joint.chi_squared),
            joint.degrees_of_freedom,
            if p.starts_with('<') { "" } else { "= " }
        ));
    }
}

fn print_published(found: &PublishedComparison, output: &Output) {
    output.print(&format!(
        "published{}:",
        if found.source.is_empty() { String::new() } else { format!(" ({})", found.source) }
    ));
    output.print(&runs(&found.runs, found.noise.as_ref()));
    output.print("own model:");
    output.print(&runs(&found.own_runs, found.own_noise.as_ref()));
    let rows: Vec<Vec<String>> = found
        .parameters
        .iter()
        .map(|p| {
            vec![
                p.effect.clone(),
                p.name.clone(),
                p.published.map(|x| measured(x, p.published_std)).unwrap_or_else(|| "-".into()),
                p.own.map(|x| measured(x, p.own_std)).unwrap_or_else(|| "-".into()),
                p.interval.map(|[low, high]| format!("{} to {}", number(low), number(high))).unwrap_or_default(),
                p.z.map(|z| format!("{z:+.1}")).unwrap_or_default(),
                probability(p.p_value),
                p.unit.clone(),
            ]
        })
        .collect();
    output.print(&table(&["term", "symbol", "published", "own ± std", "95 % of own", "z", "p", "unit"], &rows));
}
