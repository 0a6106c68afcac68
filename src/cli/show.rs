//! The verbs `demo` and `report`, which show everything at once.

use super::answer;
use super::arguments as typed;
use super::failure::Failure;
use super::fitted::print_filters;
use super::output::Output;
use super::table::{measured, number, table};
use super::verbs::load;
use crate::campaign::{self, Campaign, ModelFile, Published};
use crate::check::codes::AT_REST;
use crate::demo::{self, Demo, DemoOptions};
use crate::discover::Discovery;
use crate::effects::named;
use crate::progress::tell;
use crate::report::svg::standalone;
use crate::report::{Document, render};
use crate::report_content::{self, gap_figure};
use crate::wording::count;

pub(super) fn demo(a: &typed::Demo, output: &Output) -> Result<(), Failure> {
    output.may_write(None)?;
    let options = DemoOptions { folder: a.folder.clone(), seed: a.seed, noise: a.noise, hide: a.hide.clone() };
    let mut made = output.working("sailing", || demo::demo(&options, &|what| tell(what, 0, 0)))??;
    let model = options.folder.join("model.toml");
    output.write(&model, ModelFile::of(&made.campaign, &made.fit).to_text(&model)?.as_bytes())?;
    let page = options.folder.join("report.html");
    let found = made.discovery.model().cloned();
    let document = output.working("writing the report", || {
        document_of(&made.blind, found.as_ref().map(|_| &made.discovery), None, Some(made.seed))
    })??;
    output.write(&page, render(&document).as_bytes())?;
    let numbers = options.folder.join("demo.json");
    made.files.extend([model, page, numbers.clone()]);
    if let Some(figure) = gap_figure(&made.discovery) {
        let gap = options.folder.join("gap.svg");
        output.write(&gap, standalone(&figure).as_bytes())?;
        made.files.push(gap);
    }
    let text = serde_json::to_string_pretty(&made)
        .map_err(|e| Failure::Write { file: numbers.clone(), source: std::io::Error::other(e) })?;
    output.write(&numbers, text.as_bytes())?;
    print_demo(&made, output);
    output.json(&made)?;
    answer::next(&format!("hydrosysid view {}", options.folder.join("hidden").display()), output);
    Ok(())
}

fn print_demo(made: &Demo, output: &Output) {
    answer::verdict(&demo_verdict(made), output);
    if output.is_verbose() {
        print_staged(made, output);
        output.print(&format!("A second campaign, whose baseline lacks {}:", made.hidden.join(", ")));
        super::discovered::print(&made.discovery, output);
        for file in &made.files {
            output.print(&format!("written: {}", file.display()));
        }
        return;
    }
    let rows: Vec<Vec<String>> = made
        .estimates
        .iter()
        .filter(|e| ["towing", "steady"].contains(&e.stage.as_str()))
        .map(|e| {
            let truth = e.truth.map(number).unwrap_or_default();
            vec![
                e.stage.clone(),
                e.dof.to_string(),
                e.name.clone(),
                measured(e.value, Some(e.std)),
                truth,
                e.unit.clone(),
            ]
        })
        .collect();
    let forces = made.forces.iter().flat_map(|force| {
        let row = |symbol: &str, found: Option<(f64, f64)>, truth: f64, unit: &str| {
            let told = found.map_or("none".to_string(), |(value, std)| measured(value, Some(std)));
            vec!["random".into(), force.dof.to_string(), symbol.into(), told, number(truth), unit.into()]
        };
        let found = force.found.as_ref();
        let unit = if force.dof.is_rotation() { "N*m" } else { "N" };
        [
            row("rms", found.map(|f| (f.rms, f.std)), force.rms, unit),
            row("time", found.map(|f| (f.correlation_time, f.correlation_time_std)), force.correlation_time, "s"),
        ]
    });
    let rows: Vec<Vec<String>> = rows.into_iter().chain(forces).collect();
    output.print(&table(&["stage", "dof", "symbol", "estimate ± std", "truth", "unit"], &rows));
    if let Some(folder) = made.files.iter().find(|f| f.ends_with("report.html")).and_then(|f| f.parent()) {
        output.print(&format!("written: {}, with report.html, model.toml and demo.json", folder.display()));
    }
}

/// The share of staged estimates near their true values, and whether the hidden effect was found.
fn demo_verdict(made: &Demo) -> String {
    let known: Vec<f64> = made
        .estimates
        .iter()
        .filter_map(|e| Some(((e.value - e.truth?) / e.std).abs()))
        .filter(|off| off.is_finite())
        .collect();
    let near = known.iter().filter(|off| **off <= 2.0).count();
    let is_found = |hidden: &String| made.discovery.effects.iter().any(|e| e.id == *hidden);
    let names = made.hidden.iter().map(|id| named(id)).collect::<Vec<_>>().join(", ");
    let found = match made.hidden.iter().all(is_found) {
        true => format!("Hidden and found again: {names}."),
        false => format!("Hidden and not found again: {names}. {}", made.discovery.sentence),
    };
    format!(
        "{found} {near} of {} of the staged procedure lie within two standard errors of the truth.",
        count(known.len(), "estimate"),
    )
}

/// Prints all tables of the staged procedure.
fn print_staged(made: &Demo, output: &Output) {
    output.print(&format!("The staged procedure on the paper's runs, seed {}:", made.seed));
    let rows: Vec<Vec<String>> = made
        .estimates
        .iter()
        .map(|e| {
            vec![
                e.stage.clone(),
                e.run.clone().unwrap_or_default(),
                e.dof.to_string(),
                e.name.clone(),
                measured(e.value, Some(e.std)),
                e.truth.map(number).unwrap_or_default(),
                e.paper.map(|(value, std)| measured(value, Some(std))).unwrap_or_default(),
                e.unit.clone(),
            ]
        })
        .collect();
    output.print(&table(&["stage", "run", "dof", "symbol", "estimate ± std", "truth", "paper", "unit"], &rows));
    let rows: Vec<Vec<String>> = made
        .conditions
        .iter()
        .map(|c| {
            let [plain, scaled] = [c.condition_number, c.condition_number_scaled].map(number);
            vec![c.stage.clone(), c.dof.to_string(), c.rows.to_string(), plain, scaled]
        })
        .collect();
    output.print(&table(&["stage", "dof", "rows", "cond(HᵀH)", "cond scaled"], &rows));
    output.print("Staged against all at once with a differentiated yaw rate: a good match is not a true value.");
    let rows: Vec<Vec<String>> = made
        .twins
        .iter()
        .flat_map(|t| {
            t.values.iter().map(|(name, staged, value, std, truth)| {
                let truth = truth.map(number).unwrap_or_default();
                vec![t.run.clone(), name.clone(), number(*staged), measured(*value, Some(*std)), truth]
            })
        })
        .collect();
    output.print(&table(&["run", "symbol", "staged", "all at once ± std", "truth"], &rows));
    let rows: Vec<Vec<String>> =
        made.twins.iter().map(|t| vec![t.run.clone(), number(t.staged_error), number(t.twin_error)]).collect();
    output.print(&table(&["run", "|error| staged, rad/s", "|error| all at once, rad/s"], &rows));
    output.print("Each oscillation's model on every other run, mean |error| ± std in surge, m/s:");
    let mut names: Vec<&str> = made.cross_validation.iter().map(|c| c.run.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let rows: Vec<Vec<String>> = names
        .iter()
        .map(|model| {
            let cell = |run: &&str| {
                let found = made.cross_validation.iter().find(|c| c.model == *model && c.run == **run);
                found.map_or_else(String::new, |c| format!("{} ± {}", number(c.mean_abs), number(c.std_abs)))
            };
            std::iter::once((*model).to_string()).chain(names.iter().map(cell)).collect()
        })
        .collect();
    let heads: Vec<&str> = std::iter::once("model of").chain(names.iter().copied()).collect();
    output.print(&table(&heads, &rows));
    print_filters(&made.filters, output);
}

pub(super) fn report(a: &typed::Report, output: &Output) -> Result<(), Failure> {
    output.may_write(Some(&a.output))?;
    let loaded = load(&a.campaign, &a.loading, output)?;
    loaded.refuse_bench_alone()?;
    let published = a.params.as_deref().map(|path| Published::read(path, &loaded)).transpose()?;
    let found = match a.no_discovery {
        true => None,
        false => match output.working("searching", || campaign::discover(&loaded))? {
            Ok(found) => Some(found),
            // the rest of the report does not depend on it
            Err(error) => {
                output.complain(&format!("warning: the report does not say what is missing: {error}"));
                None
            }
        },
    };
    let document =
        output.working("writing the report", || document_of(&loaded, found.as_ref(), published.as_ref(), None))??;
    let html = render(&document);
    output.write(&a.output, html.as_bytes())?;
    answer::verdict(&document.verdict, output);
    output.print(&format!("written: {}, {} kB: open it in a browser", a.output.display(), html.len() / 1000));
    output.json(&serde_json::json!({"format": 1, "file": a.output, "bytes": html.len()}))?;
    let campaign = a.campaign.display();
    let next = match &found {
        _ if document.checks.iter().any(|check| check.code == AT_REST.code) => format!("hydrosysid check {campaign}"),
        Some(found) if !found.adopt.is_empty() => format!("hydrosysid discover {campaign} --adopt"),
        _ => format!("hydrosysid fit {campaign} --model model.toml"),
    };
    answer::next(&next, output);
    Ok(())
}

/// The report of a campaign, with its origin.
fn document_of(
    loaded: &Campaign,
    found: Option<&Discovery>,
    published: Option<&Published>,
    seed: Option<u64>,
) -> Result<Document, Failure> {
    let command = std::env::args().collect::<Vec<_>>().join(" ");
    let origin = report_content::origin(loaded, command, seed)
        .map_err(|report_content::Unhashed { file, source }| Failure::Read { file, source })?;
    Ok(report_content::document_of(loaded, found, published, origin)?)
}
