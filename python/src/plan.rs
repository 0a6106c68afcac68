//! Plans of the next runs.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use hydrosysid::campaign::{self, FitOptions, ModelFile, Plan, PlanRequest, PlanSource};
use hydrosysid::progress::tell;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::campaign::NativeCampaign;
use crate::error;
use crate::work::interruptible;

type Arrays<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// The command histories: name, kind, and signals of each run.
type Commands<'py> = Vec<(String, String, BTreeMap<String, Arrays<'py>>)>;

/// The plan of a campaign, which is fitted first, as JSON, and its command histories; the request is JSON.
#[pyfunction]
pub fn plan_campaign<'py>(
    py: Python<'py>,
    campaign: &NativeCampaign,
    request: &str,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, Commands<'py>)> {
    let request = asked(py, request)?;
    let made = interruptible(py, progress, || {
        let fitted = campaign::fit(campaign.campaign(), FitOptions::default())?;
        campaign::plan(&PlanSource::of_fit(campaign.campaign(), &fitted), &request, &rehearsed(request.rehearse))
    })?;
    told(py, &made.map_err(|e| error::campaign(py, &e))?)
}

/// The plan of a model (TOML, as a fit returns it) as JSON, and its command histories; the request is JSON.
#[pyfunction]
pub fn plan_model<'py>(
    py: Python<'py>,
    model: &str,
    request: &str,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, Commands<'py>)> {
    let request = asked(py, request)?;
    let file: ModelFile = ModelFile::from_text(model, Path::new("a model")).map_err(|e| error::usage(py, &e))?;
    let source = PlanSource::of_file(&file, Path::new("model.toml")).map_err(|e| error::usage(py, &e))?;
    let made = interruptible(py, progress, || campaign::plan(&source, &request, &rehearsed(request.rehearse)))?;
    told(py, &made.map_err(|e| error::campaign(py, &e))?)
}

/// A callback that reports each finished campaign of the rehearsal.
fn rehearsed(of: usize) -> impl Fn() + Sync {
    let done = AtomicUsize::new(0);
    move || tell("rehearsing", done.fetch_add(1, Ordering::Relaxed) + 1, of)
}

fn asked(py: Python<'_>, request: &str) -> PyResult<PlanRequest> {
    serde_json::from_str(request).map_err(|e| error::usage(py, &e))
}

fn told<'py>(py: Python<'py>, plan: &Plan) -> PyResult<(String, Commands<'py>)> {
    let array = |values: &[f64]| PyArray1::from_slice(py, values);
    let kind = |run: &hydrosysid::run::Run| serde_json::to_value(run.kind).ok()?.as_str().map(str::to_string);
    let commands = plan.commands.iter().map(|run| {
        let signals =
            run.signals.iter().map(|(name, s)| (name.clone(), (array(s.time()), array(s.values())))).collect();
        (run.name.clone(), kind(run).unwrap_or_default(), signals)
    });
    Ok((error::to_json(plan)?, commands.collect()))
}
