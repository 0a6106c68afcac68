//! Python bindings: each function converts its arguments, releases the interpreter, calls the
//! library and converts the result. The bindings contain no mathematics and no decisions; names,
//! defaults and classes are in the Python package.
//!
//! Results of verbs are passed as the JSON that the command line writes, so that both interfaces
//! give the same.

#![allow(missing_docs)] // what is public here is what the macros of PyO3 make so; `_native.pyi` is its documentation

mod attitude;
mod campaign;
mod catalogue;
mod command;
mod error;
mod least_squares;
mod log;
mod models;
mod numbers;
mod plan;
mod run;
mod work;

/// Compiled part of the package.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use super::attitude::{euler, to_body};
    #[pymodule_export]
    use super::campaign::{
        NativeCampaign, check_campaign, fit_streamed, init_campaign, known_vehicles, tank_campaign, too_large_to_keep,
    };
    #[pymodule_export]
    use super::catalogue::{codes_explained, common_name_of, effects, regressors};
    #[pymodule_export]
    use super::command::{command, watched_command};
    #[pymodule_export]
    use super::least_squares::{block_bootstrap, least_squares};
    #[pymodule_export]
    use super::log::{check_logs, csv_of, read_log, to_si};
    #[pymodule_export]
    use super::models::{adopt, export_model, model_difference};
    #[pymodule_export]
    use super::numbers::{fit_thruster, polynomial_filter, rk4, student_quantile};
    #[pymodule_export]
    use super::plan::{plan_campaign, plan_model};

    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        use pyo3::types::PyModuleMethods;
        // not in `__all__`, so that one stub file fits every wheel
        #[cfg(feature = "panics")]
        pyo3::types::PyAnyMethods::setattr(
            module.as_any(),
            "fail",
            pyo3::wrap_pyfunction!(super::work::fail, module)?,
        )?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
