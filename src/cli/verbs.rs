//! The verbs that work on logs and campaigns: each reads arguments, calls the library once, and
//! prints the result.

use std::collections::BTreeMap;
use std::path::Path;

use super::arguments::{self as typed, Loading, Reading};
use super::failure::Failure;
use super::output::Output;
use super::table::wrapped;
use super::{answer, plot, scatter};
use crate::campaign::{self, Adoption, Campaign, Fit, FitOptions, LoadOptions, ModelFile, Simulation};
use crate::log::{self, LogOptions};
use crate::run::{Run, Signal};
use crate::wording::count;

/// The `[log]` options of the command line.
pub(super) fn reading(reading: &Reading) -> Result<LogOptions, Failure> {
    let text = reading.options.join("\n");
    toml::from_str(&text).map_err(|e| Failure::Argument(format!("--log: {}", e.message())))
}

pub(super) fn load(path: &Path, loading: &Loading, output: &Output) -> Result<Campaign, Failure> {
    let options = LoadOptions { allow_outside: loading.allow_outside };
    Ok(output.working("reading logs", || Campaign::load(path, options))??)
}

pub(super) fn fit(a: &typed::Fit, output: &Output) -> Result<(), Failure> {
    output.may_write(a.model.as_deref())?;
    if let Some(result) = super::bench::alone(a, output)? {
        return result.hand_over(a, output);
    }
    if a.vehicle.is_some() {
        return Err(Failure::Argument(
            "--vehicle applies to bench runs: for other runs the campaign holds the vehicle".into(),
        ));
    }
    let (loaded, fitted) = if streams(a)? { streamed(a, output)? } else { kept(a, output)? };
    super::fitted::print(&fitted, output);
    plot::of_model(a.plotting.plot.as_deref(), &under(&loaded, &fitted), &fitted.model, output)?;
    match scatter::refits(a, &loaded, fitted.estimator, output)? {
        None => output.json(&fitted)?,
        Some(resampling) => output.json(&scatter::Scattered { fit: &fitted, resampling: &resampling })?,
    }
    if let Some(path) = &a.model {
        let text = ModelFile::of(&loaded, &fitted).to_text(path)?;
        output.write(path, text.as_bytes())?;
        output.print(&format!("written: {}, the model with its noise and covariance", path.display()));
    }
    output.tell(&fitted.warnings)?;
    super::fitted::print_next(&fitted, a, output);
    Ok(())
}

/// Whether the logs are streamed: on request, or if they are too large for the memory and no option
/// needs them.
fn streams(a: &typed::Fit) -> Result<bool, Failure> {
    if a.stream || a.bootstrap.is_some() || a.monte_carlo.is_some() || a.thorough || a.filters {
        return Ok(a.stream);
    }
    let options = LoadOptions { allow_outside: a.loading.allow_outside };
    Ok(campaign::too_large_to_keep(&a.campaign, options, a.estimator.map(Into::into))?)
}

/// A fit with all logs in memory.
fn kept(a: &typed::Fit, output: &Output) -> Result<(Campaign, Fit), Failure> {
    let loaded = load(&a.campaign, &a.loading, output)?;
    let estimator = a.estimator.map(Into::into);
    let mut fitted = output.working("fitting", || campaign::fit(&loaded, FitOptions { estimator }))??;
    if a.thorough {
        output.working("examining more closely", || campaign::examine(&loaded, &mut fitted))??;
    }
    if a.filters {
        fitted.filters = output.working("the same with filters", || campaign::filters(&loaded))??;
    }
    Ok((loaded, fitted))
}

/// A fit that streams the logs.
fn streamed(a: &typed::Fit, output: &Output) -> Result<(Campaign, Fit), Failure> {
    let options = LoadOptions { allow_outside: a.loading.allow_outside };
    Ok(output.working("reading logs", || campaign::fit_streamed(&a.campaign, options))??)
}

/// The campaign with the losses of thrust and the noise that its fit has estimated.
fn under(campaign: &Campaign, fitted: &Fit) -> Campaign {
    campaign.under(&fitted.efficiency).with_noise(fitted.model_noise())
}

/// The campaign with the requested model: from a file, or fitted now.
pub(super) struct Chosen {
    pub campaign: Campaign,
    pub model: crate::model::Model,
    pub envelope: crate::envelope::Envelope,
}

pub(super) fn chosen(path: &Path, model: Option<&Path>, loading: &Loading, output: &Output) -> Result<Chosen, Failure> {
    // the model first: a wrong name is reported before the logs are read
    let file = model.map(ModelFile::read).transpose()?;
    let loaded = load(path, loading, output)?;
    Ok(match (file, model) {
        (Some(file), Some(path)) => Chosen {
            model: file.model_for(&loaded, path)?,
            campaign: loaded.under_model(&file, &path.display().to_string()),
            envelope: file.envelope,
        },
        _ => {
            let fitted = output.working("fitting", || campaign::fit(&loaded, FitOptions::default()))??;
            Chosen { campaign: under(&loaded, &fitted), model: fitted.model, envelope: fitted.envelope }
        }
    })
}

/// Refuses, before any work, a file for series in a format that cannot be written.
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
    let result =
        output.working("simulating", || campaign::simulate(&chosen.campaign, &chosen.model, &chosen.envelope))??;
    super::simulated::print(&result, output);
    plot::simulated(a.plotting.plot.as_deref(), &result, output)?;
    if let Some(folder) = &a.output {
        for run in &result.runs {
            write_signals(folder, &run.run, run.signals(), output)?;
        }
        output.print(&format!("written: {}, {}", folder.display(), count(result.runs.len(), "simulated run")));
    }
    if let Some(path) = &a.series.series {
        write_series(&result, path, output)?;
        output.print(&format!("written: {}, all series side by side", path.display()));
    }
    if let Some(folder) = &a.forces {
        let parts = output.working("forces", || campaign::components(&chosen.campaign, &chosen.model))?;
        for part in &parts.runs {
            let stem = Path::new(&part.run).with_extension("");
            write_signals(folder, &format!("{}_{}.csv", stem.display(), part.dof), part.signals(), output)?;
        }
        output.print(&format!("written: {}, the force of each term over time", folder.display()));
        output.tell(&parts.warnings)?;
    }
    output.json(&result)?;
    output.tell(&result.warnings)?;
    let model = a.model.as_ref().map_or_else(String::new, |model| format!(" --model {}", model.display()));
    answer::next(&format!("hydrosysid compare {}{model}", a.campaign.display()), output);
    Ok(())
}

/// Writes signals as one CSV file in a folder, which is made if necessary.
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
    let found = output.working("searching", || campaign::discover(&loaded))??;
    super::discovered::print(&found, output);
    let campaign = a.campaign.display();
    let adoption = Adoption::from(&found);
    let Adoption { names, training, input } = adoption;
    // --adopt writes effects, the interpolation of the commands, and the roles of runs that took part
    let written = |effects: String| {
        let roles = format!("role = \"train\" for {}", training.join(", "));
        let input = input.map(|input| format!("input = \"{}\"", input.name()));
        let parts = [(!names.is_empty()).then_some(effects), input, (!training.is_empty()).then_some(roles)];
        parts.into_iter().flatten().collect::<Vec<_>>().join(" and ")
    };
    let next = match &a.adopt {
        _ if adoption.is_empty() => format!("hydrosysid report {campaign}"),
        Some(to) => {
            // the user asked to edit the campaign: it is the only input that a call writes
            let file = campaign::adopt(&a.campaign, to.as_deref(), &adoption)?;
            let file = file.display();
            output.print(&format!("{file} has {} now", written(format!("{} in its model", names.join(", ")))));
            format!("hydrosysid fit {file}")
        }
        None => {
            let list = names.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ");
            let what = written(format!("{list} into `effects` of [model]"));
            output.print(&wrapped(&format!("--adopt writes {what}, comments kept")));
            format!("hydrosysid discover {campaign} --adopt")
        }
    };
    output.json(&found)?;
    output.tell(&found.warnings)?;
    answer::next(&next, output);
    Ok(())
}
