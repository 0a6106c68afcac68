//! Export of models to files for other tools, and comparison of two models.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use hydrosysid::campaign::{Adoption, ModelFile, difference};
use hydrosysid::export::{self, Export, ExportError, ExportOptions, Target};
use hydrosysid::model::Interpolation;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error;
use crate::work::detached;

/// An export: its description as JSON, and the content of the file.
type Made<'py> = (String, Bound<'py, PyBytes>);

fn made(py: Python<'_>, result: Result<Export, ExportError>) -> PyResult<Made<'_>> {
    let export = result.map_err(|e| error::usage(py, &e))?;
    Ok((error::to_json(&export)?, PyBytes::new(py, &export.bytes)))
}

fn target_of(py: Python<'_>, name: &str) -> PyResult<Target> {
    let names: Vec<&str> = Target::ALL.iter().map(|t| t.name()).collect();
    let listed = || format!("no target is called {name:?}; there are {}", names.join(", "));
    let unknown = || error::usage(py, &Target::why_absent(name).map_or_else(listed, str::to_string));
    Target::from_name(name).ok_or_else(unknown)
}

/// Exports a model (TOML, as a fit returns it), or with `is_file` the model or campaign file with that path.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // keywords of one call
pub fn export_model<'py>(
    py: Python<'py>,
    model: &str,
    is_file: bool,
    target: &str,
    link: Option<String>,
    mass: Option<f64>,
    inertia: Option<[f64; 3]>,
    at: BTreeMap<String, f64>,
    acting: bool,
    version: Option<String>,
) -> PyResult<Made<'py>> {
    let target = target_of(py, target)?;
    let options = ExportOptions { link, mass, inertia, at, acting, version };
    if is_file {
        let result = detached(py, || export::export(&PathBuf::from(model), target, &options))?;
        return made(py, result);
    }
    let file = ModelFile::from_text(model, Path::new("a fit")).map_err(|e| error::usage(py, &e))?;
    let result = detached(py, || export::export_model(&file, Path::new("a fit"), target, &options))?;
    made(py, result)
}

/// Compares two models (TOML). Returns JSON.
#[pyfunction]
pub fn model_difference(py: Python<'_>, a: &str, b: &str, names: [String; 2]) -> PyResult<String> {
    let read = |text: &str| ModelFile::from_text(text, Path::new("a model")).map_err(|e| error::usage(py, &e));
    let (a, b) = (read(a)?, read(b)?);
    error::to_json(&detached(py, || difference(&a, &b, names))?)
}

/// Adds `names` to the effects of a campaign, or of another next to it; the runs `training` get the role `train`, and
/// `input` (`hold` or `linear`) becomes that of its model.
#[pyfunction]
pub fn adopt(
    py: Python<'_>,
    campaign: PathBuf,
    to: Option<PathBuf>,
    names: Vec<String>,
    training: Vec<String>,
    input: Option<&str>,
) -> PyResult<()> {
    let known = |name: &str| Interpolation::ALL.into_iter().find(|one| one.name() == name);
    let unknown = |name: &str| PyValueError::new_err(format!("{name:?} is neither \"linear\" nor \"hold\""));
    let input = input.map(|name| known(name).ok_or_else(|| unknown(name))).transpose()?;
    let what = Adoption { names: &names, training: &training, input };
    let adopted = hydrosysid::campaign::adopt(&campaign, to.as_deref(), &what);
    adopted.map(drop).map_err(|e| error::usage(py, &e))
}
