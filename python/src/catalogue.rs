//! The catalogue of effects, and their columns on runs.

use hydrosysid::campaign::codes;
use hydrosysid::effects::{Coriolis, Effect, Place, Scope, catalogue, common_name, meant, search};
use hydrosysid::estimate::{Nodes, RegressorOptions, Span, regressors_of};
use hydrosysid::frame::Dof;
use hydrosysid::model::{Model, places_of};
use hydrosysid::run::Run;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::error;
use crate::run::{GivenRun, to_runs};
use crate::work::interruptible;

/// Returns the effects that match `text` as JSON, a list of objects; if there are none, also the nearest names.
#[pyfunction]
pub fn effects(text: &str) -> PyResult<String> {
    let all = catalogue(Coriolis::Tied);
    let list: Vec<Value> = search(&all, text).into_iter().map(described).collect();
    let near = if list.is_empty() { meant(&all, text) } else { None };
    error::to_json(&(list, near))
}

/// Returns the common name of an effect at its place: `linear_drag@sway` is linear drag in sway.
#[pyfunction(name = "common_name")]
pub fn common_name_of(name: &str) -> String {
    common_name(name)
}

fn described(effect: &dyn Effect) -> Value {
    let about = effect.about();
    let places = places_of(effect, &Dof::ALL);
    let dofs: Vec<Dof> = match about.scope {
        Scope::Vehicle(dofs) => dofs.to_vec(),
        _ => Dof::ALL.into_iter().filter(|dof| places.iter().any(|place| place.dof == Some(*dof))).collect(),
    };
    let parameters = effect.parameters(places.first().copied().unwrap_or(Place::VEHICLE));
    let parameters: Vec<Value> = parameters
        .iter()
        .map(|p| json!({"name": p.name, "unit": p.dimension.to_string(), "linear": p.is_linear(), "sname": p.sname}))
        .collect();
    json!({
        "id": about.id, "common_name": common_name(about.id), "family": about.family, "dofs": dofs, "formula": about.formula, "meaning": about.meaning,
        "source": about.source, "shown_by": about.shown_by, "parameters": parameters,
    })
}

/// What the codes of findings mean, as JSON: a list of objects.
#[pyfunction]
pub fn codes_explained() -> PyResult<String> {
    let list: Vec<Value> = codes::everywhere()
        .chain(hydrosysid::export::codes::ALL)
        .map(|c| json!({"code": c.code, "kind": c.kind, "severity": c.severity, "meaning": c.meaning}))
        .collect();
    error::to_json(&list)
}

/// Names, columns (n, p), right-hand side, and begin and end of each row (n, 2).
type System<'py> = (Vec<String>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

/// Integral regressors of the balance of one degree of freedom, stacked over runs.
#[pyfunction]
#[pyo3(signature = (runs, dof, dofs, effects, fixed, coriolis, samples, every_stamp))]
#[allow(clippy::too_many_arguments)] // the package calls it by keyword
pub fn regressors<'py>(
    py: Python<'py>,
    runs: Vec<GivenRun<'py>>,
    dof: &str,
    dofs: Vec<String>,
    effects: Vec<String>,
    fixed: Vec<(String, f64)>,
    coriolis: &str,
    samples: Option<usize>,
    every_stamp: bool,
) -> PyResult<System<'py>> {
    let runs = to_runs(py, &runs)?;
    let known = |name: &str| {
        Dof::from_name(name).ok_or_else(|| {
            error::usage(py, &format!("`{name}` is not a degree of freedom: surge, sway, heave, roll, pitch or yaw"))
        })
    };
    let dof = known(dof)?;
    let dofs: Vec<Dof> = dofs.iter().map(|name| known(name)).collect::<PyResult<_>>()?;
    let coriolis: Coriolis = serde_json::from_value(coriolis.into()).map_err(|e| error::usage(py, &e))?;
    let names: Vec<&str> = effects.iter().map(String::as_str).collect();
    let mut model = Model::with_effects(&dofs, coriolis, &names).map_err(|e| error::usage(py, &e))?;
    for (name, value) in &fixed {
        let Some(parameter) = model.parameter_of(name) else {
            return Err(error::usage(py, &format!("`{name}` has a fixed value, but is not among the effects")));
        };
        model.parameters[parameter].value = *value;
        model.parameters[parameter].fixed = true;
    }
    let options = RegressorOptions {
        span: samples.map_or(Span::FromStart, Span::Samples),
        nodes: if every_stamp { Nodes::Every } else { Nodes::Own },
    };
    let found = interruptible(py, None, || regressors_of(dof, &runs.iter().collect::<Vec<&Run>>(), &model, options))?
        .map_err(|e| error::data(py, &e))?;
    let (rows, width) = (found.rows(), found.columns.len());
    let flat: Vec<f64> = (0..rows).flat_map(|row| found.columns.iter().map(move |c| c[row])).collect();
    let spans: Vec<f64> = found.span.iter().flat_map(|(a, b)| [*a, *b]).collect();
    Ok((
        found.parameters.iter().map(|c| c.name.clone()).collect(),
        PyArray1::from_vec(py, flat).reshape([rows, width])?,
        PyArray1::from_vec(py, found.rhs),
        PyArray1::from_vec(py, spans).reshape([rows, 2])?,
    ))
}
