//! The verb `plan`: proposes the next runs.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::answer;
use super::arguments as typed;
use super::failure::Failure;
use super::output::Output;
use super::table::{number, size, table};
use super::verbs::load;
use crate::campaign::file::CampaignFile;
use crate::campaign::{self, FitOptions, ModelFile, Plan, PlanRequest, PlanSource, PlannedRun};
use crate::frame::Dof;
use crate::log;
use crate::nearest::nearest;
use crate::plan::{Manoeuvre, Push};
use crate::text_file;
use crate::wording::count;

/// The runs of a plan as a file: written by `--output`, read by `--runs`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanFile {
    /// Format of the file: 1.
    format: u32,
    /// The runs.
    #[serde(default, rename = "run")]
    runs: Vec<Manoeuvre>,
}

pub(super) fn plan(a: &typed::Plan, output: &Output) -> Result<(), Failure> {
    output.may_write(a.output.as_deref())?;
    let request = PlanRequest {
        wants: a.wants.clone(),
        limits: limits(&a.limits)?,
        noise: a.noise.iter().cloned().collect(),
        rates: a.rates.iter().cloned().collect(),
        length: a.length,
        most: a.most,
        room: a.room,
        without_known: a.without_known,
        runs: a.runs.as_deref().map(told).transpose()?,
        rehearse: a.rehearse,
        seed: a.seed,
    };
    let source = source(a, output)?;
    let busy = output.busy("planning");
    let made = campaign::plan(&source, &request, &|| busy.tick())?;
    busy.finish_and_clear();
    print(&made, output);
    if let Some(folder) = &a.output {
        write(&made, folder, output)?;
    }
    output.json(&made)?;
    output.tell(&made.warnings)?;
    answer::next(&next(a, &made, output), output);
    Ok(())
}

/// The next command: write the plan, then rehearse it; if no run is needed, export the parameters.
fn next(a: &typed::Plan, made: &Plan, output: &Output) -> String {
    let source = a.source.display();
    match (&a.output, &a.runs) {
        _ if made.runs.is_empty() => format!("hydrosysid export {source} --to csv -o parameters.csv"),
        (Some(folder), _) => {
            format!("hydrosysid plan {source} --runs {} --rehearse 50", folder.join("plan.toml").display())
        }
        (None, Some(runs)) if made.rehearsal.is_none() => {
            format!("hydrosysid plan {source} --runs {} --rehearse 50", runs.display())
        }
        // the same call, with a folder for the command histories
        (None, _) => format!("{} -o plan", output.typed()),
    }
}

/// The model of a model file, or the fit of a campaign.
fn source(a: &typed::Plan, output: &Output) -> Result<PlanSource, Failure> {
    let file = CampaignFile::at(&a.source);
    let read = |source| Failure::Read { file: file.clone(), source };
    let text = text_file::read(&file).map_err(read)?;
    // a model file contains the version that wrote it, a campaign never does
    let json = file.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let is_model = json || text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("hydrosysid"));
    if is_model {
        return Ok(PlanSource::of_file(&ModelFile::from_text(&text, &file)?, &file)?);
    }
    let loaded = load(&a.source, &a.loading, output)?;
    let busy = output.busy("fitting");
    let fitted = campaign::fit(&loaded, FitOptions::default())?;
    busy.finish_and_clear();
    Ok(PlanSource::of_fit(&loaded, &fitted))
}

fn limits(typed: &[(String, f64)]) -> Result<BTreeMap<Dof, f64>, Failure> {
    let of = |(name, limit): &(String, f64)| {
        let known = || nearest(name, Dof::ALL.map(Dof::name)).map(|n| format!(", did you mean `{n}`?"));
        let wrong = || {
            Failure::Argument(format!("--limit: `{name}` is not a degree of freedom{}", known().unwrap_or_default()))
        };
        Dof::from_name(name).map(|dof| (dof, *limit)).ok_or_else(wrong)
    };
    typed.iter().map(of).collect()
}

/// The runs of a plan file.
fn told(path: &Path) -> Result<Vec<Manoeuvre>, Failure> {
    let text = text_file::read(path).map_err(|source| Failure::Read { file: path.to_path_buf(), source })?;
    let wrong = |e: &dyn std::fmt::Display| Failure::Argument(format!("{}: {e}", path.display()));
    let file: PlanFile = toml::from_str(&text).map_err(|e| wrong(&e))?;
    if file.format != 1 {
        return Err(wrong(&format!("format {} is not known: this version reads format 1", file.format)));
    }
    if file.runs.is_empty() {
        return Err(wrong(&"it has no [[run]]"));
    }
    Ok(file.runs)
}

/// Maximum number of pushes of a run that are listed; more are the sines of a multisine, which the
/// plan's file contains.
const PUSHES: usize = 4;

/// `surge 60 ± 45, 12 s; yaw ± 30 to 60°`.
fn in_words(pushes: &[Push]) -> String {
    let words = |p: &Push| {
        let (offset, amplitude) = (number(p.offset), number(p.amplitude.abs()));
        match (p.period, p.bound, p.hold) {
            (Some(period), _, _) if p.offset == 0.0 => format!("{} ± {amplitude}, {} s", p.dof, number(period)),
            (Some(period), _, _) => format!("{} {offset} ± {amplitude}, {} s", p.dof, number(period)),
            (_, Some(bound), _) => format!("{} ± {amplitude} to {:.0}°", p.dof, bound.to_degrees()),
            (_, _, Some(_)) => format!("{} held", p.dof),
            _ => format!("{} {}", p.dof, number(p.offset + p.amplitude)),
        }
    };
    if pushes.len() > PUSHES {
        let dofs: Vec<&str> =
            Dof::ALL.into_iter().filter(|dof| pushes.iter().any(|p| p.dof == *dof)).map(Dof::name).collect();
        return format!("{} in {}", count(pushes.len(), "sine"), dofs.join(", "));
    }
    pushes.iter().map(words).collect::<Vec<_>>().join("; ")
}

fn print(made: &Plan, output: &Output) {
    answer::verdict(&made.sentence, output);
    let verbose = output.is_verbose();
    let row = |run: &PlannedRun| {
        let speeds: Vec<String> = run.greatest.iter().map(|(channel, v)| format!("{channel} {v:.2}")).collect();
        let worst = run.worst.map_or("-".into(), number);
        let mut row = vec![run.name.clone(), number(run.length), in_words(&run.pushes), worst];
        if verbose {
            row.extend([speeds.join(" "), number(run.reach)]);
        }
        row
    };
    let rows: Vec<Vec<String>> = made.runs.iter().map(row).collect();
    if !rows.is_empty() {
        let heads = ["run", "s", "push, N and N*m", "worst std/wanted", "up to", "m away"];
        output.print(&table(&heads[..if verbose { 6 } else { 4 }], &rows));
    }
    // without runs the parameters are the answer; a rehearsal was requested
    if verbose || rows.is_empty() || made.rehearsal.is_some() {
        print_parameters(made, output);
    }
    if let Some(r) = &made.rehearsal {
        output.print(&format!("rehearsed: {}, {} could not be fitted", count(r.campaigns, "campaign"), r.failed));
    }
}

fn print_parameters(made: &Plan, output: &Output) {
    let rehearsed = made.rehearsal.is_some();
    let rows: Vec<Vec<String>> = made
        .parameters
        .iter()
        .map(|p| {
            let place = [p.dof, p.other].iter().flatten().map(|d| d.name()).collect::<Vec<_>>().join(":");
            let told = |x: Option<f64>| x.map_or("-".to_string(), size);
            let name = if place.is_empty() { p.effect.clone() } else { format!("{}@{place}", p.effect) };
            let planned = p.std.map_or("not shown".into(), size);
            let mut row = vec![name, size(p.value), told(p.std_now), told(p.wanted), planned];
            if rehearsed {
                row.push(p.rehearsed_ratio.map_or("-".into(), |r| format!("{r:.2}")));
            }
            row.push(p.unit.clone());
            row
        })
        .collect();
    let mut heads = vec!["term", "value", "std now", "wanted", "planned"];
    if rehearsed {
        heads.push("rehearsed/predicted");
    }
    heads.push("unit");
    output.print(&table(&heads, &rows));
}

/// Writes the plan and the command histories to a folder.
fn write(made: &Plan, folder: &Path, output: &Output) -> Result<(), Failure> {
    let failed = |file: &Path, source| Failure::Write { file: file.to_path_buf(), source };
    std::fs::create_dir_all(folder).map_err(|e| failed(folder, e))?;
    let runs = made.runs.iter().map(|run| Manoeuvre {
        name: run.name.clone(),
        kind: run.kind,
        length: run.length,
        pushes: run.pushes.clone(),
    });
    let file = folder.join("plan.toml");
    let text = toml::to_string(&PlanFile { format: 1, runs: runs.collect() })
        .map_err(|e| failed(&file, std::io::Error::other(e)))?;
    output.write(&file, text.as_bytes())?;
    for run in &made.commands {
        let file = folder.join(run.name.replace(['/', '\\', ' '], "_")).with_extension("csv");
        let mut bytes = Vec::new();
        log::write_to(run, &mut bytes).map_err(|e| failed(&file, e))?;
        output.write(&file, &bytes)?;
    }
    output.print(&format!("written: {} and {}", file.display(), count(made.commands.len(), "command history")));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_degree_of_freedom_is_named_once() {
        let pushes = [Dof::Yaw, Dof::Heave, Dof::Yaw, Dof::Heave, Dof::Yaw].map(|dof| Push::constant(dof, 1.0));
        assert_eq!(in_words(&pushes), "5 sines in heave, yaw");
    }
}
