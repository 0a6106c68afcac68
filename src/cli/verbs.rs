//! The verbs that work on logs and campaigns: arguments in, one call of the library, the result out.

use std::collections::BTreeMap;
use std::path::Path;

use super::arguments::{self as typed, Loading, Reading};
use super::failure::Failure;
use super::output::Output;
use super::scatter;
use super::table::{measured, number, table};
use crate::campaign::{self, Campaign, Fit, FitOptions, InitFacts, LoadOptions, ModelFile, Simulation};
use crate::log::{self, LogOptions};
use crate::procedure::sensitivity::{Spread, spreads};
use crate::progress::{Watch, watched};
use crate::run::{Run, Signal};
use crate::thrust::fit::Estimate;

/// The `[log]` options that were typed.
pub(super) fn reading(reading: &Reading) -> Result<LogOptions, Failure> {
    let text = reading.options.join("\n");
    toml::from_str(&text).map_err(|e| Failure::Argument(format!("--log: {}", e.message())))
}

pub(super) fn load(path: &Path, loading: &Loading, output: &Output) -> Result<Campaign, Failure> {
    let busy = output.busy("reading logs");
    let campaign = Campaign::load(path, LoadOptions { allow_outside: loading.allow_outside })?;
    busy.finish_and_clear();
    Ok(campaign)
}

pub(super) fn init(a: &typed::Init, output: &Output) -> Result<(), Failure> {
    output.may_write(a.output.as_deref())?;
    let options = reading(&a.reading)?;
    let folder = a.output.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
    let mut logs = Vec::new();
    for path in &a.logs {
        let shown = path.strip_prefix(folder).unwrap_or(path);
        if shown.is_absolute() || shown.starts_with("..") {
            let text = format!(
                "{}: a log lies in the campaign's folder or below it; write the campaign there with --output",
                path.display()
            );
            return Err(Failure::Argument(text));
        }
        logs.push((path.as_path(), shown.display().to_string()));
    }
    let facts = InitFacts {
        name: a.name.clone(),
        mass: a.mass,
        volume: a.volume,
        weight: a.weight,
        buoyancy: a.buoyancy,
        length: a.length,
    };
    let text = campaign::init(&logs, &facts, &options)?;
    match &a.output {
        None => output.hand_over(&text),
        Some(path) => {
            output.write(path, text.as_bytes())?;
            output.print(&format!("{} written; read it through, then: hydrosysid check {0}", path.display()));
        }
    }
    Ok(())
}

pub(super) fn fit(a: &typed::Fit, output: &Output) -> Result<(), Failure> {
    output.may_write(a.model.as_deref())?;
    let (loaded, fitted) = if streams(a)? { streamed(a, output)? } else { kept(a, output)? };
    print_fit(&fitted, output);
    print_identifiability(&fitted, output);
    match scatter::refits(a, &loaded, output)? {
        None => output.json(&fitted)?,
        Some(resampling) => output.json(&scatter::Scattered { fit: &fitted, resampling: &resampling })?,
    }
    output.tell(&fitted.warnings)?;
    if let Some(path) = &a.model {
        let text = ModelFile::of(&loaded, &fitted).to_text(path)?;
        output.write(path, text.as_bytes())?;
    }
    Ok(())
}

/// Whether the logs are to pass by: where it is asked for, and where they are too large to keep and nothing needs them.
fn streams(a: &typed::Fit) -> Result<bool, Failure> {
    if a.stream || a.bootstrap.is_some() || a.monte_carlo.is_some() || a.thorough || a.filters {
        return Ok(a.stream);
    }
    let options = LoadOptions { allow_outside: a.loading.allow_outside };
    Ok(campaign::too_large_to_keep(&a.campaign, options, a.estimator.map(Into::into))?)
}

/// A fit of logs that are in memory.
fn kept(a: &typed::Fit, output: &Output) -> Result<(Campaign, Fit), Failure> {
    let loaded = load(&a.campaign, &a.loading, output)?;
    let busy = output.busy("fitting");
    let mut fitted = campaign::fit(&loaded, FitOptions { estimator: a.estimator.map(Into::into) })?;
    if a.thorough {
        campaign::examine(&loaded, &mut fitted)?;
    }
    if a.filters {
        fitted.filters = campaign::filters(&loaded)?;
    }
    busy.finish_and_clear();
    Ok((loaded, fitted))
}

/// A fit of logs that pass by.
fn streamed(a: &typed::Fit, output: &Output) -> Result<(Campaign, Fit), Failure> {
    let busy = output.busy("reading logs");
    let shown = busy.clone();
    let watch = Watch::new(move |step| shown.set_message(format!("{} {}", step.what, step.done)));
    let options = LoadOptions { allow_outside: a.loading.allow_outside };
    let done = watched(&watch, || campaign::fit_streamed(&a.campaign, options));
    busy.finish_and_clear();
    // nobody stops this watch
    Ok(done.map_err(|stopped| Failure::Argument(stopped.to_string()))??)
}

fn print_fit(fitted: &Fit, output: &Output) {
    let rows: Vec<Vec<String>> = fitted
        .parameters
        .iter()
        .map(|p| {
            let place = [p.dof, p.other].iter().flatten().map(|d| d.name()).collect::<Vec<_>>().join(":");
            let sname = p.sname.as_ref().zip(p.sname_value).map(|(s, v)| format!("{s} = {}", number(v)));
            vec![
                p.effect.clone(),
                place,
                p.name.clone(),
                if p.fixed { format!("{} (held)", number(p.value)) } else { measured(p.value, p.std) },
                p.std_paper.filter(|s| *s > 0.0).map(|s| format!("± {}", number(s))).unwrap_or_default(),
                p.unit.clone(),
                sname.unwrap_or_default(),
            ]
        })
        .collect();
    output.print(&table(&["effect", "dof", "symbol", "value ± std", "(14)", "unit", "SNAME"], &rows));
    let rows: Vec<Vec<String>> = fitted
        .stages
        .iter()
        .map(|s| {
            vec![
                s.name.clone(),
                s.dof.to_string(),
                s.runs.len().to_string(),
                s.rows.to_string(),
                number(s.residual_std),
                number(s.condition_number),
                number(s.condition_number_scaled),
            ]
        })
        .collect();
    output.print(&table(&["stage", "dof", "runs", "rows", "residual", "cond(HᵀH)", "cond scaled"], &rows));
    print_thrusters(fitted, output);
    print_stages(fitted, output);
    print_filters(&spreads(&fitted.filters), output);
    output.print(&format!("estimator {}, standard deviations: {}", fitted.estimator.name(), fitted.std_method));
}

/// Curves of thrusters that were found from bollard tables, equation (1).
fn print_thrusters(fitted: &Fit, output: &Output) {
    let told = |e: Estimate| measured(e.value, Some(e.std).filter(|std| *std > 0.0));
    let of_curve = |curve: &campaign::FittedCurve| {
        [("forward", curve.forward), ("reverse", curve.reverse)].map(|(way, side)| {
            vec![
                curve.thrusters.join(" "),
                way.to_string(),
                told(side.a),
                told(side.b),
                told(curve.deadband),
                curve.supply_exponent.map(told).unwrap_or_default(),
                side.rows.to_string(),
                number(side.residual_std),
            ]
        })
    };
    let rows: Vec<Vec<String>> = fitted.thrusters.iter().flat_map(of_curve).collect();
    if !rows.is_empty() {
        let heads = ["thruster", "direction", "a", "b", "dead band", "supply exponent", "rows", "residual, N"];
        output.print(&table(&heads, &rows));
    }
}

/// What speaks for the estimates, and what against.
fn print_identifiability(fitted: &Fit, output: &Output) {
    let Some(known) = &fitted.identifiability else { return };
    let told = |x: Option<f64>| x.map_or("-".to_string(), number);
    let rows: Vec<Vec<String>> = known
        .parameters
        .iter()
        .map(|p| {
            let share = p.force_share.map_or("-".into(), |s| format!("{:.1}", 100.0 * s));
            let z = p.halves_z.map_or("-".into(), |z| format!("{z:.1}"));
            let (first, second) = (told(p.first_half), told(p.second_half));
            vec![p.term.clone(), p.name.clone(), share, number(p.inflation), first, second, z]
        })
        .collect();
    let heads = ["term", "symbol", "% of force", "inflation", "first half", "second half", "apart, std"];
    output.print(&table(&heads, &rows));
    for pair in &known.correlations {
        output.print(&format!("correlated: {} and {}, {:+.3}", pair.a, pair.b, pair.correlation));
    }
    for one in &known.profiles {
        let end = |x: Option<f64>| x.map_or("not bounded".to_string(), number);
        let [low, high] = one.interval.map(end);
        output.print(&format!("{} of {}: 95 % by profile likelihood from {low} to {high}", one.name, one.term));
    }
}

/// What each stage has found: drag towed beside propelled with J, each oscillation with its flow numbers.
fn print_stages(fitted: &Fit, output: &Output) {
    let of_stage = |s: &campaign::FitStage| -> Vec<Vec<String>> {
        let run = if s.runs.len() == 1 { s.runs[0].clone() } else { format!("{} runs", s.runs.len()) };
        // J of Table 3 is the square of the residual's deviation in N or N m
        let forces = ["bollard", "towing", "steady"].contains(&s.name.split(' ').next().unwrap_or_default());
        let mut rows: Vec<Vec<String>> =
            s.estimates.iter().map(|e| vec![e.name.clone(), measured(e.value, Some(e.std)), e.unit.clone()]).collect();
        if forces {
            rows.push(vec!["J".into(), number(s.residual_std.powi(2)), "".into()]);
        }
        if let Some(n) = s.numbers {
            let all = [("KC", n.keulegan_carpenter), ("λ", Some(n.lambda)), ("C_m", n.inertia_coefficient)];
            rows.extend(all.into_iter().filter_map(|(name, x)| Some(vec![name.into(), number(x?), "1".into()])));
        }
        let stage = s.name.split(' ').next().unwrap_or_default();
        let way = if s.name.ends_with("clockwise") { s.name.as_str() } else { stage };
        rows.into_iter().map(|row| [vec![way.into(), s.dof.to_string(), run.clone()], row].concat()).collect()
    };
    let rows: Vec<Vec<String>> = fitted.stages.iter().flat_map(of_stage).collect();
    if !rows.is_empty() {
        output.print(&table(&["stage", "dof", "of", "symbol", "value ± std", "unit"], &rows));
    }
}

/// How far each estimate moves with window and degree of the filter, those of all runs together.
pub(super) fn print_filters(spreads: &[Spread], output: &Output) {
    let together = |s: &&Spread| !s.stage.contains(' ') && !["bollard", "towing", "steady"].contains(&s.stage.as_str());
    let rows: Vec<Vec<String>> = spreads
        .iter()
        .filter(together)
        .map(|s| {
            let moved = if s.relative < 10.0 { format!("{:.1}", 100.0 * s.relative) } else { "> 1000".into() };
            let range = format!("{} to {}", number(s.least), number(s.most));
            vec![s.stage.clone(), s.dof.to_string(), s.name.clone(), range, number(s.std), moved, s.unit.clone()]
        })
        .collect();
    if !rows.is_empty() {
        output.print("With polynomial filters of 5, 9 and 15 samples, degree 2 and 3, and without:");
        output.print(&table(&["stage", "dof", "symbol", "range", "std", "moves by, %", "unit"], &rows));
    }
}

/// The campaign under the model that was asked for: from a file, or fitted now.
pub(super) struct Chosen {
    pub campaign: Campaign,
    pub model: crate::model::Model,
    pub envelope: crate::envelope::Envelope,
}

pub(super) fn chosen(path: &Path, model: Option<&Path>, loading: &Loading, output: &Output) -> Result<Chosen, Failure> {
    // the model first: a wrong name is better told before the logs are read
    let file = model.map(ModelFile::read).transpose()?;
    let loaded = load(path, loading, output)?;
    Ok(match (file, model) {
        (Some(file), Some(path)) => Chosen {
            model: file.model(&loaded.runs, path)?,
            campaign: loaded.under(&file.efficiency),
            envelope: file.envelope,
        },
        _ => {
            let busy = output.busy("fitting");
            let fitted = campaign::fit(&loaded, FitOptions::default())?;
            busy.finish_and_clear();
            Chosen { campaign: loaded.under(&fitted.efficiency), model: fitted.model, envelope: fitted.envelope }
        }
    })
}

/// Refuses a file for series that cannot be written, before any work.
pub(super) fn may_hold_series(path: Option<&Path>, output: &Output) -> Result<(), Failure> {
    output.may_write(path)?;
    match path.map(|p| (p, p.extension().and_then(|e| e.to_str()))) {
        None | Some((_, Some("csv"))) => Ok(()),
        Some((path, end)) => {
            let who = "is written by the command of the Python package: pip install 'hydrosysid[mcap]'";
            let what = if end == Some("mcap") { who } else { "ends neither in .csv nor in .mcap" };
            Err(Failure::Argument(format!("--series {}: this {what}", path.display())))
        }
    }
}

/// Writes measured, simulated and residual series side by side.
pub(super) fn write_series(simulated: &Simulation, path: &Path, output: &Output) -> Result<(), Failure> {
    let mut bytes = Vec::new();
    let failed = |source| Failure::Write { file: path.to_path_buf(), source };
    log::write_to(&simulated.series(), &mut bytes).map_err(failed)?;
    output.write(path, &bytes)
}

pub(super) fn simulate(a: &typed::Simulate, output: &Output) -> Result<(), Failure> {
    output.may_write(a.output.as_deref())?;
    may_hold_series(a.series.series.as_deref(), output)?;
    let chosen = chosen(&a.campaign, a.model.as_deref(), &a.loading, output)?;
    let busy = output.busy("simulating");
    let result = campaign::simulate(&chosen.campaign, &chosen.model, &chosen.envelope)?;
    busy.finish_and_clear();
    output.tell(&result.warnings)?;
    let rows: Vec<Vec<String>> = result
        .runs
        .iter()
        .map(|run| {
            let channels: Vec<&str> = run.simulated.keys().map(String::as_str).collect();
            vec![run.run.clone(), run.time.len().to_string(), channels.join(" ")]
        })
        .collect();
    output.print(&table(&["run", "instants", "simulated"], &rows));
    if let Some(folder) = &a.output {
        for run in &result.runs {
            write_signals(folder, &run.run, run.signals(), output)?;
        }
    }
    if let Some(path) = &a.series.series {
        write_series(&result, path, output)?;
    }
    if let Some(folder) = &a.forces {
        let parts = campaign::components(&chosen.campaign, &chosen.model);
        for part in &parts.runs {
            let stem = Path::new(&part.run).with_extension("");
            write_signals(folder, &format!("{}_{}.csv", stem.display(), part.dof), part.signals(), output)?;
        }
        output.tell(&parts.warnings)?;
    }
    output.json(&result)
}

/// Writes signals as one CSV in a folder that is made where it is not there.
fn write_signals(folder: &Path, name: &str, signals: BTreeMap<String, Signal>, output: &Output) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|source| Failure::Write { file: folder.to_path_buf(), source })?;
    let file = folder.join(name.replace(['/', '\\', ' ', '#'], "_")).with_extension("csv");
    let run = Run { name: name.to_string(), signals, ..Run::default() };
    let mut bytes = Vec::new();
    log::write_to(&run, &mut bytes).map_err(|source| Failure::Write { file: file.clone(), source })?;
    output.write(&file, &bytes)
}

pub(super) fn discover(a: &typed::Discover, output: &Output) -> Result<(), Failure> {
    output.may_write(None)?;
    let mut loaded = load(&a.campaign, &a.loading, output)?;
    if !a.families.is_empty() {
        loaded.file.discover.families = a.families.iter().map(|name| (*name).into()).collect();
    }
    let busy = output.busy("searching");
    let found = campaign::discover(&loaded)?;
    busy.finish_and_clear();
    super::discovered::print(&found, output);
    output.json(&found)?;
    output.tell(&found.warnings)
}
