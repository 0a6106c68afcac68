//! A campaign and its verbs.

use std::collections::BTreeMap;
use std::mem::take;
use std::path::{Path, PathBuf};

use hydrosysid::campaign::file::{CampaignFile, Estimator, ReadOptions};
use hydrosysid::campaign::{
    self, Campaign, Fit, FitOptions, InitFacts, InitRequest, LoadOptions, ModelFile, ModelFileError, Published, Refits,
    RunComponents, Simulated,
};
use hydrosysid::monitor::MonitorOptions;
use hydrosysid::report::{Input, Origin};
use hydrosysid::report_content::page_of;
use hydrosysid::tank;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::error;
use crate::log::options;
use crate::run::GivenRun;
use crate::work::{detached, interruptible};

type Array<'py> = Bound<'py, PyArray1<f64>>;
type Arrays<'py> = BTreeMap<String, Array<'py>>;

/// Residuals of a run: run, channel, time, values, expected standard deviations.
type Residuals<'py> = (String, String, Array<'py>, Array<'py>, Array<'py>);

/// A simulated run: time, simulated and measured channels, expected standard deviations.
type Trajectories<'py> = (Array<'py>, Arrays<'py>, Arrays<'py>, Arrays<'py>);

/// The forces of a balance: time, velocity, force of each term, total.
type Series<'py> = (Array<'py>, Array<'py>, Arrays<'py>, Array<'py>);

/// A campaign with its logs read. It cannot be pickled itself: the package pickles its source instead.
#[pyclass(frozen, module = "hydrosysid._native")]
pub struct NativeCampaign(Campaign);

#[pymethods]
impl NativeCampaign {
    /// Reads a campaign file and its logs.
    #[staticmethod]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        allow_outside: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<NativeCampaign> {
        let loaded = interruptible(py, progress, || Campaign::load(&path, LoadOptions { allow_outside }))?;
        loaded.map(NativeCampaign).map_err(|e| error::campaign(py, &e))
    }

    /// Creates a campaign from runs in memory; `tables` is the campaign file as JSON.
    #[staticmethod]
    fn from_runs(py: Python<'_>, tables: &str, runs: Vec<GivenRun<'_>>) -> PyResult<NativeCampaign> {
        let runs = runs.iter().map(|run| Ok((run.to_run(py)?, run.units()))).collect::<PyResult<_>>()?;
        let tables: toml::Table = serde_json::from_str(tables).map_err(|e| error::usage(py, &e))?;
        // converted to text first, so that it is checked like a file
        let text = toml::to_string(&tables).map_err(|e| error::usage(py, &e))?;
        let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
        let loaded = interruptible(py, None, || {
            let file = CampaignFile::from_bytes(text.as_bytes(), Path::new("Campaign(...)"), &options)?;
            Campaign::from_commanded_runs(file, runs)
        })?;
        loaded.map(NativeCampaign).map_err(|e| error::campaign(py, &e))
    }

    /// Returns vehicle name, degrees of freedom, terms, runs (name, kind, role) and findings of reading, as JSON.
    fn about(&self) -> PyResult<String> {
        let runs: Vec<_> = self.0.runs.iter().map(|run| (&run.name, run.kind, run.role)).collect();
        let effects: Vec<String> = self.0.model.terms.iter().map(|term| term.name()).collect();
        error::to_json(&(&self.0.vehicle.name, &self.0.model.dofs, effects, runs, &self.0.findings))
    }

    /// Fits the campaign. Returns the fit as JSON, its model file as TOML, and its residuals.
    fn fit<'py>(
        &self,
        py: Python<'py>,
        estimator: Option<&str>,
        thorough: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(String, String, Vec<Residuals<'py>>)> {
        let estimator = named(py, estimator)?;
        let fitted = interruptible(py, progress, || {
            let mut fitted = campaign::fit(&self.0, FitOptions { estimator })?;
            if thorough {
                campaign::examine(&self.0, &mut fitted)?;
            }
            Ok(fitted)
        })?;
        let mut fitted = fitted.map_err(|e| error::campaign(py, &e))?;
        let array = |values| PyArray1::from_vec(py, values);
        let left = take(&mut fitted.residuals).into_iter();
        let left = left.map(|r| (r.run, r.channel, array(r.time), array(r.values), array(r.std))).collect();
        let (told, model) = with_model(py, &self.0, &fitted)?;
        Ok((told, model, left))
    }

    /// Returns the estimator of a fit: the requested one, else that of the campaign, else the one that suits its runs.
    fn estimator(&self, py: Python<'_>, asked: Option<&str>) -> PyResult<&'static str> {
        Ok(FitOptions { estimator: named(py, asked)? }.estimator_for(&self.0).name())
    }

    /// Makes the refits with these numbers. Returns JSON, and the estimates of the successful ones, (draws, p).
    fn resample<'py>(
        &self,
        py: Python<'py>,
        method: &str,
        estimator: Option<&str>,
        numbers: (u64, u64),
        seed: Option<u64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(String, Bound<'py, PyArray2<f64>>)> {
        let method = serde_json::from_value(method.into()).map_err(|e| error::usage(py, &e))?;
        let estimator = FitOptions { estimator: named(py, estimator)? }.estimator_for(&self.0);
        let refits = Refits { numbers: numbers.0..numbers.1, seed };
        let result = interruptible(py, progress, || campaign::resample(&self.0, estimator, method, refits))?;
        let result = result.map_err(|e| error::campaign(py, &e))?;
        let (rows, width) = (result.samples.len(), result.parameters.len());
        let samples = PyArray1::from_vec(py, result.samples.concat()).reshape([rows, width])?;
        Ok((error::to_json(&result)?, samples))
    }

    /// Fits each run alone and simulates its model on every other run. Returns JSON.
    fn cross_validate(
        &self,
        py: Python<'_>,
        estimator: Option<String>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let estimator = estimator.map(|name| serde_json::from_value(name.into()));
        let estimator = estimator.transpose().map_err(|e| error::usage(py, &e))?;
        let found = interruptible(py, progress, || {
            let fitted = campaign::fit(&self.0, FitOptions { estimator })?;
            Ok(campaign::each_run(&self.0, &fitted))
        })?;
        error::to_json(&found.map_err(|e| error::campaign(py, &e))?)
    }

    /// Simulates a model (TOML, as returned by [`NativeCampaign::fit`]). Returns JSON with empty trajectories, and the
    /// trajectories of each run, NaN where there is no sample.
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        model: &str,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(String, Vec<Trajectories<'py>>)> {
        let (file, model) = self.model(py, model)?;
        let result = interruptible(py, progress, || {
            campaign::simulate(&self.0.under_model(&file, "the model"), &model, &file.envelope)
        })?;
        let mut result = result.map_err(|e| error::campaign(py, &e))?;
        let taken = |run: &mut Simulated| {
            let time = PyArray1::from_vec(py, take(&mut run.time));
            let simulated = arrays(py, take(&mut run.simulated));
            (time, simulated, samples(py, take(&mut run.measured)), samples(py, take(&mut run.std)))
        };
        let runs = result.runs.iter_mut().map(taken).collect();
        Ok((error::to_json(&result)?, runs))
    }

    /// Computes the forces of a model over time. Returns JSON with empty series, and the series of each entry.
    fn components<'py>(
        &self,
        py: Python<'py>,
        model: &str,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(String, Vec<Series<'py>>)> {
        let (file, model) = self.model(py, model)?;
        let parts = || campaign::components(&self.0.under(&file.efficiency), &model);
        let mut result = interruptible(py, progress, parts)?;
        let array = |values: &mut Vec<f64>| PyArray1::from_vec(py, take(values));
        let taken = |run: &mut RunComponents| {
            (array(&mut run.time), array(&mut run.velocity), arrays(py, take(&mut run.terms)), array(&mut run.total))
        };
        let runs = result.runs.iter_mut().map(taken).collect();
        Ok((error::to_json(&result)?, runs))
    }

    /// Compares a model with the runs. Returns JSON.
    fn compare(&self, py: Python<'_>, model: &str, progress: Option<Py<PyAny>>) -> PyResult<String> {
        let (file, model) = self.model(py, model)?;
        let under = self.0.under_model(&file, "the model");
        let result = interruptible(py, progress, || campaign::compare(&under, &model, &file.envelope))?;
        error::to_json(&result.map_err(|e| error::campaign(py, &e))?)
    }

    /// Compares a model and published parameters (both TOML) with the runs. Returns JSON.
    fn compare_published(
        &self,
        py: Python<'_>,
        model: &str,
        params: &str,
        name: &str,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let (file, model) = self.model(py, model)?;
        let result = interruptible(py, progress, || {
            let campaign = self.0.under_model(&file, "the model");
            let published = Published::parse(params, Path::new(name), &campaign)?;
            campaign::compare_published(&campaign, &model, &file.envelope, &published, Path::new(name))
        })?;
        error::to_json(&result.map_err(|e| error::campaign(py, &e))?)
    }

    /// Monitors a model along the runs. Returns JSON.
    fn monitor(
        &self,
        py: Python<'_>,
        model: &str,
        window: f64,
        level: f64,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        if !(window > 0.0 && window.is_finite() && level > 0.0 && level <= 0.5) {
            let text = format!(
                "window = {window}, level = {level}: window must be a time in s above 0, level above 0 and at most 0.5"
            );
            return Err(error::usage(py, &text));
        }
        let (file, model) = self.model(py, model)?;
        let options = MonitorOptions { window, level };
        let watch = || campaign::monitor(&self.0.under_model(&file, "the model"), &model, &file.envelope, &options);
        error::to_json(&interruptible(py, progress, watch)?.map_err(|e| error::campaign(py, &e))?)
    }

    /// Searches for missing effects. Returns JSON; `families` are those of the campaign when absent.
    fn discover(&self, py: Python<'_>, families: Option<Vec<String>>, progress: Option<Py<PyAny>>) -> PyResult<String> {
        let mut campaign = self.0.clone();
        if let Some(names) = families {
            let families = names.into_iter().map(|name| serde_json::from_value(name.into())).collect::<Result<_, _>>();
            campaign.file.discover.families = families.map_err(|e: serde_json::Error| error::usage(py, &e))?;
        }
        let result = interruptible(py, progress, || campaign::discover(&campaign))?;
        error::to_json(&result.map_err(|e| error::campaign(py, &e))?)
    }

    /// Returns the report as one HTML page. `params`: text and name of published parameters; `inputs`: names and hashes
    /// of the files read.
    fn report(
        &self,
        py: Python<'_>,
        discovery: bool,
        params: Option<(String, String)>,
        command: String,
        inputs: Vec<(String, String)>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let inputs = inputs.into_iter().map(|(name, sha256)| Input { name, sha256 }).collect();
        let version = format!("hydrosysid {}", env!("CARGO_PKG_VERSION"));
        let origin = Origin { version, command, inputs, seed: None };
        let page = interruptible(py, progress, || {
            let read = |(text, name): &(String, String)| Published::parse(text, Path::new(name), &self.0);
            let published = params.as_ref().map(read).transpose()?;
            let found = if discovery { Some(campaign::discover(&self.0)?) } else { None };
            page_of(&self.0, found.as_ref(), published.as_ref(), origin)
        })?;
        page.map_err(|e| error::campaign(py, &e))
    }

    /// Returns the files read: the campaign and its logs.
    fn sources(&self) -> Vec<PathBuf> {
        self.0.sources.clone()
    }

    /// Returns the campaign with other runs: each is the stretch `from` to `to`, s, of the run with this index.
    fn resampled(&self, stretches: Vec<(usize, f64, f64)>) -> NativeCampaign {
        let mut other = self.0.clone();
        other.runs = stretches
            .iter()
            .enumerate()
            .filter_map(|(k, (run, from, to))| {
                let mut run = self.0.runs.get(*run)?.between(*from, *to);
                run.name = format!("{} #{k}", run.name);
                Some(run)
            })
            .collect();
        NativeCampaign(other)
    }

    /// Returns kind, role, start and end of each run, s, as JSON.
    fn spans(&self) -> PyResult<String> {
        let spans: Vec<_> = self.0.runs.iter().map(|run| (run.kind, run.role, run.span())).collect();
        error::to_json(&spans)
    }
}

/// Converts columns to arrays without copying.
fn arrays(py: Python<'_>, columns: BTreeMap<String, Vec<f64>>) -> Arrays<'_> {
    columns.into_iter().map(|(name, values)| (name, PyArray1::from_vec(py, values))).collect()
}

/// Converts columns of sensors to arrays, NaN where there is no sample.
fn samples(py: Python<'_>, columns: BTreeMap<String, Vec<Option<f64>>>) -> Arrays<'_> {
    let known = |column: Vec<Option<f64>>| column.into_iter().map(|x| x.unwrap_or(f64::NAN)).collect();
    arrays(py, columns.into_iter().map(|(name, column)| (name, known(column))).collect())
}

/// File name of a model in memory, for messages.
const MODEL: &str = "model.toml";

fn model_error(py: Python<'_>, error: &ModelFileError) -> PyErr {
    error::usage(py, error)
}

impl NativeCampaign {
    /// Returns the campaign of the library.
    pub fn campaign(&self) -> &Campaign {
        &self.0
    }

    fn model(&self, py: Python<'_>, text: &str) -> PyResult<(ModelFile, hydrosysid::model::Model)> {
        let file: ModelFile = ModelFile::from_text(text, Path::new("a model")).map_err(|e| error::usage(py, &e))?;
        let model = file.model_for(&self.0, Path::new(MODEL)).map_err(|e| model_error(py, &e))?;
        Ok((file, model))
    }
}

/// Returns an estimator by its name.
fn named(py: Python<'_>, estimator: Option<&str>) -> PyResult<Option<Estimator>> {
    let estimator = estimator.map(|name| serde_json::from_value(name.into()));
    estimator.transpose().map_err(|e| error::usage(py, &e))
}

/// Returns a fit as JSON, and its model file as TOML.
fn with_model(py: Python<'_>, campaign: &Campaign, fitted: &Fit) -> PyResult<(String, String)> {
    let model = ModelFile::of(campaign, fitted).to_text(Path::new(MODEL)).map_err(|e| model_error(py, &e))?;
    Ok((error::to_json(fitted)?, model))
}

/// Whether a fit would read its logs piece by piece without being asked to.
#[pyfunction]
pub fn too_large_to_keep(py: Python<'_>, path: PathBuf, estimator: Option<&str>) -> PyResult<bool> {
    let estimator = named(py, estimator)?;
    let large = detached(py, || campaign::too_large_to_keep(&path, LoadOptions::default(), estimator))?;
    large.map_err(|e| error::campaign(py, &e))
}

/// Fits a campaign by integral least squares on logs that are not kept in memory.
#[pyfunction]
pub fn fit_streamed(py: Python<'_>, path: PathBuf, progress: Option<Py<PyAny>>) -> PyResult<(String, String)> {
    let fitted = interruptible(py, progress, || campaign::fit_streamed(&path, LoadOptions::default()))?;
    let (campaign, fitted) = fitted.map_err(|e| error::campaign(py, &e))?;
    with_model(py, &campaign, &fitted)
}

/// Checks a campaign. Returns JSON.
#[pyfunction]
pub fn check_campaign(
    py: Python<'_>,
    path: PathBuf,
    allow_outside: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let found = interruptible(py, progress, || campaign::check_campaign(&path, LoadOptions { allow_outside }))?;
    error::to_json(&found.map_err(|e| error::campaign(py, &e))?)
}

/// Writes the virtual tank's campaign of the paper into a folder.
#[pyfunction]
pub fn tank_campaign(py: Python<'_>, folder: PathBuf, seed: u64, noise: f64) -> PyResult<()> {
    let written = interruptible(py, None, || {
        let made = tank::paper_campaign(seed, noise).map_err(|e| e.to_string())?;
        made.write(&folder).map_err(|e| e.to_string())
    })?;
    written.map_err(|e| error::usage(py, &e))
}

/// A scaffold: text, files that the campaign needs next to it (location, name in the campaign), and warnings.
type Scaffolded = (String, Vec<(PathBuf, String)>, Vec<String>);

/// Returns the text of a campaign file for logs (each a path to read and the path to write in the campaign), the
/// files that it needs next to it, and warnings. `figures`: mass, volume, weight, buoyancy, length.
#[pyfunction]
pub fn init_campaign(
    py: Python<'_>,
    logs: Vec<(PathBuf, String)>,
    name: String,
    figures: [Option<f64>; 5],
    vehicle: Option<String>,
    log_options: &str,
    learned: &str,
) -> PyResult<Scaffolded> {
    let [mass, volume, weight, buoyancy, length] = figures;
    let request = InitRequest {
        logs,
        facts: InitFacts { name, mass, volume, weight, buoyancy, length },
        vehicle,
        options: options(py, log_options)?,
        learned: serde_json::from_str(learned).map_err(|e| error::usage(py, &e))?,
    };
    let made = interruptible(py, None, || campaign::init(&request))?.map_err(|e| error::campaign(py, &e))?;
    let warnings = made.warnings();
    Ok((made.text, made.companions, warnings))
}

/// Returns the vehicles that come with the program as JSON: name and tables.
#[pyfunction]
pub fn known_vehicles() -> PyResult<String> {
    let all: Vec<(String, campaign::VehicleFile)> =
        campaign::known_vehicles().into_iter().map(|known| (known.id, known.file)).collect();
    error::to_json(&all)
}
