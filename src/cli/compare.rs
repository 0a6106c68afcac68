//! The verb `compare`: a model or published parameters against the runs of a campaign, or one model
//! against another.

use std::path::Path;

use super::answer;
use super::arguments::Compare;
use super::failure::Failure;
use super::output::Output;
use super::table::{measured, number, size, table};
use super::verbs::{Chosen, chosen, load, may_hold_series, write_series};
use super::{crossed, difference, noise, plot};
use crate::campaign::{self, FitOptions, Noise, Published, PublishedComparison, PublishedParameter};
use crate::compare::Disagreement;
use crate::run::Role;
use crate::wording::{count, probability};

/// Greatest ratio of the error of a free simulation to its predicted error that counts as predicted:
/// the rms error of one run scatters by as much.
const AS_PREDICTED: f64 = 1.5;

pub(super) fn compare(a: &Compare, output: &Output) -> Result<(), Failure> {
    may_hold_series(a.series.series.as_deref(), output)?;
    if let Some(other) = &a.other {
        let found = campaign::difference_of(&a.campaign, other)?;
        difference::print(&found, output);
        output.json(&found)?;
        output.tell(&found.warnings)?;
        answer::next(&format!("hydrosysid export {} --to csv -o parameters.csv", other.display()), output);
        return Ok(());
    }
    if a.cross {
        let loaded = load(&a.campaign, &a.loading, output)?;
        let fitted = output.working("fitting", || campaign::fit(&loaded, FitOptions::default()))??;
        let found = output.working("each run alone", || campaign::each_run(&loaded, &fitted))?;
        crossed::print(&found, output);
        output.json(&found)?;
        answer::next(&format!("hydrosysid discover {}", a.campaign.display()), output);
        return Ok(());
    }
    let Chosen { campaign, model, envelope } = chosen(&a.campaign, a.model.as_deref(), &a.loading, output)?;
    let Some(params) = &a.params else {
        let result = output.working("simulating", || campaign::compare(&campaign, &model, &envelope))??;
        if let Some(path) = &a.series.series {
            write_series(&campaign::simulate(&campaign, &model, &envelope)?, path, output)?;
        }
        let errs = print_runs(&result.runs, result.noise.as_ref(), output);
        plot::of_model(a.plotting.plot.as_deref(), &campaign, &model, output)?;
        output.json(&result)?;
        output.tell(&result.warnings)?;
        answer::next(&next(&a.campaign, errs), output);
        return Ok(());
    };
    let published = Published::read(params, &campaign)?;
    let result = output
        .working("simulating", || campaign::compare_published(&campaign, &model, &envelope, &published, params))??;
    print_published(&result, output);
    plot::of_model(a.plotting.plot.as_deref(), &campaign, &model, output)?;
    output.json(&result)?;
    output.tell(&result.warnings)?;
    answer::next(&format!("hydrosysid report {} --params {}", a.campaign.display(), params.display()), output);
    Ok(())
}

/// The next command: a search if the model errs more than predicted or has a large random force,
/// otherwise a report.
fn next(campaign: &Path, errs: bool) -> String {
    let verb = if errs { "discover" } else { "report" };
    format!("hydrosysid {verb} {}", campaign.display())
}

/// The error of one run and degree of freedom, with the error that the noise of the model predicts
/// there.
struct Row<'a> {
    of: &'a Disagreement,
    predicted: Option<f64>,
}

impl Row<'_> {
    /// Ratio of the error to the predicted error, or to the noise of the sensor if there is no
    /// prediction.
    fn times(&self) -> f64 {
        self.of.rms / self.predicted.unwrap_or(self.of.noise_floor).max(f64::MIN_POSITIVE)
    }
}

/// The worst degree of freedom of each run, in the order of the runs.
fn worst_of_each_run<'a>(rows: &'a [Disagreement], found: Option<&Noise>) -> Vec<Row<'a>> {
    let mut worst: Vec<Row<'a>> = Vec::new();
    for of in rows {
        let row = Row { of, predicted: noise::expected(found, &of.run, of.dof.along()) };
        match worst.iter_mut().find(|known| known.of.run == of.run) {
            Some(known) if known.times() >= row.times() => {}
            Some(known) => *known = row,
            None => worst.push(row),
        }
    }
    worst
}

/// Prints verdict and table; returns whether the model may lack something.
fn print_runs(rows: &[Disagreement], found: Option<&Noise>, output: &Output) -> bool {
    let worst = worst_of_each_run(rows, found);
    let (text, errs) = verdict(&worst, found);
    answer::verdict(&text, output);
    print_table(&worst, output);
    if output.is_verbose() {
        output.print(&every_degree_of_freedom(rows, found));
        if let Some(found) = found {
            noise::by_run(found, output);
        }
    }
    errs
}

/// The verdict about the held-out runs, or about all runs if none is held out, then the random
/// force; and whether the model may lack something.
fn verdict(worst: &[Row<'_>], found: Option<&Noise>) -> (String, bool) {
    let held: Vec<&Row<'_>> = worst.iter().filter(|row| row.of.role == Role::Validate).collect();
    let (judged, which) = match held.is_empty() {
        true => (worst.iter().collect(), "of the fit"),
        false => (held, "that took no part in the fit"),
    };
    let off: Vec<&&Row<'_>> = judged.iter().filter(|row| row.times() > AS_PREDICTED).collect();
    let erring: Vec<&&Row<'_>> =
        off.iter().copied().filter(|row| !noise::follows_ahead(found, &row.of.run, AS_PREDICTED)).collect();
    let named = if erring.is_empty() { judged.iter().collect() } else { erring.clone() };
    let Some(most) = named.into_iter().max_by(|a, b| a.times().total_cmp(&b.times())) else {
        return ("There is no run of free motion to compare the model with.".into(), false);
    };
    let against = if most.predicted.is_some() { "the predicted error" } else { "the noise of its sensor" };
    let place = format!("{} of {}", most.of.dof, most.of.run);
    let runs = count(judged.len(), "run");
    let text = match erring.len() {
        // a controller reacts to disturbances; a free simulation with its commands has the
        // reactions without the disturbances
        0 if !off.is_empty() => format!(
            "The model errs as predicted 8 s ahead on {runs} {which}. In free simulation it drifts {} times as far as \
             predicted in {place}: typical of nearly unstable motion, or of commands from a controller that reacted to \
             disturbances.",
            size(most.times())
        ),
        0 => format!(
            "The model errs as predicted on {runs} {which}; at most {} times {against}, in {place}.",
            size(most.times())
        ),
        n => format!(
            "The model errs more than expected on {n} of {runs} {which}; at worst {} times {against}, in {place}.",
            size(most.times())
        ),
    };
    let noise = found.map_or_else(
        || " No noise could be estimated: the model cannot follow the runs, or they have too few samples.".to_string(),
        |found| format!(" {}", found.sentence()),
    );
    let weak = found.map(|found| found.beyond_turbulence(": a model that expects such errors has proven little"));
    (text + &noise + &weak.unwrap_or_default(), !erring.is_empty() || found.is_some_and(Noise::is_more_than_turbulence))
}

/// One row per run: its worst degree of freedom.
fn print_table(worst: &[Row<'_>], output: &Output) {
    let cell = |row: &Row<'_>| {
        let mark = if row.of.pieces > 1 { " *" } else { "" };
        vec![
            format!("{}{mark}", row.of.run),
            format!("{:?}", row.of.role).to_lowercase(),
            row.of.dof.to_string(),
            size(row.of.rms),
            size(row.of.noise_floor),
            row.predicted.map_or("-".into(), size),
            row.of.unit.clone(),
        ]
    };
    let rows: Vec<Vec<String>> = worst.iter().map(cell).collect();
    if !rows.is_empty() {
        output.print(&table(&["run", "role", "worst in", "rms error", "noise", "predicted", "unit"], &rows));
    }
    if let Some(most) = worst.iter().map(|row| row.of.pieces).max().filter(|pieces| *pieces > 1) {
        output.print(&super::table::wrapped(&format!(
            "* simulated in up to {}, each from its own initial state: at gaps, or because the motion is unstable \
             (C001)",
            count(most, "piece")
        )));
    }
}

/// Measured against simulated, in every degree of freedom.
fn every_degree_of_freedom(rows: &[Disagreement], found: Option<&Noise>) -> String {
    let rows: Vec<Vec<String>> = rows
        .iter()
        .map(|r| {
            vec![
                r.run.clone(),
                r.dof.to_string(),
                format!("{} ± {}", size(r.mean_abs), size(r.std_abs)),
                size(r.rms),
                size(r.noise_floor),
                noise::expected(found, &r.run, r.dof.along()).map_or("-".into(), size),
                format!("{:.1}", r.fit_percent),
                r.pieces.to_string(),
                r.unit.clone(),
            ]
        })
        .collect();
    table(&["run", "dof", "|error| (25)", "rms", "noise", "predicted", "fit %", "pieces", "unit"], &rows)
}

/// Prints published parameters beside the estimates; with `--verbose` also how well both predict.
fn print_published(found: &PublishedComparison, output: &Output) {
    answer::verdict(&published_verdict(found), output);
    let verbose = output.is_verbose();
    let row = |p: &PublishedParameter| {
        let mut row = vec![
            p.effect.clone(),
            p.published.map(|x| measured(x, p.published_std)).unwrap_or_else(|| "-".into()),
            p.own.map(|x| measured(x, p.own_std)).unwrap_or_else(|| "-".into()),
            p.z.map(|z| format!("{z:+.1}")).unwrap_or_default(),
            p.unit.clone(),
        ];
        if verbose {
            let interval = p.interval.map(|[low, high]| format!("{} to {}", number(low), number(high)));
            row.extend([p.name.clone(), interval.unwrap_or_default(), p.p_value.map(probability).unwrap_or_default()]);
        }
        row
    };
    let heads = ["term", "published", "own ± std", "z", "unit", "symbol", "95 % of own", "p"];
    let rows: Vec<Vec<String>> = found.parameters.iter().map(row).collect();
    output.print(&table(if verbose { &heads } else { &heads[..5] }, &rows));
    if verbose {
        output.print("the published parameters on the runs:");
        output.print(&every_degree_of_freedom(&found.runs, found.noise.as_ref()));
        output.print("the own model on the runs:");
        output.print(&every_degree_of_freedom(&found.own_runs, found.own_noise.as_ref()));
    }
}

fn published_verdict(found: &PublishedComparison) -> String {
    let outside = |p: &&PublishedParameter| {
        p.published.zip(p.interval).is_some_and(|(value, [low, high])| value < low || value > high)
    };
    let known = found.parameters.iter().filter(|p| p.published.is_some() && p.interval.is_some()).count();
    let out = found.parameters.iter().filter(outside).count();
    let mean = |runs: &[Disagreement]| {
        let squares: f64 = runs.iter().map(|r| (r.rms / r.noise_floor.max(f64::MIN_POSITIVE)).powi(2)).sum();
        (squares / runs.len().max(1) as f64).sqrt()
    };
    let source = if found.source.is_empty() { String::new() } else { format!(" Published: {}.", found.source) };
    format!(
        "{out} of {} lie outside the 95 % intervals of your own model. On the runs, the published parameters err {} \
         times the sensor noise, your own {} times.{source}",
        count(known, "published parameter"),
        size(mean(&found.runs)),
        size(mean(&found.own_runs))
    )
}
