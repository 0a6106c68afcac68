//! The tasks that measure the cost of the Python interface, called from Rust;
//! `benches/peers/door.py` calls them from Python.

use std::cell::OnceCell;
use std::hint::black_box;
use std::path::Path;

use hydrosysid::campaign::file::{CampaignFile, Estimator, ReadOptions};
use hydrosysid::campaign::{self, Campaign, Fit, FitOptions, ModelFile};
use hydrosysid::estimate::{Columns, RegressorOptions, least_squares, regressors_of};
use hydrosysid::frame::Dof;
use hydrosysid::model::Model;
use hydrosysid::run::Run;

use crate::write;

/// The campaign that `door.py` builds from arrays.
const CAMPAIGN: &str = "format = 1\n[model]\ndofs = ['surge', 'sway', 'yaw']\neffects = ['inertia', 'linear_drag', \
    'quadratic_drag', 'coriolis_surge', 'coriolis_sway', 'coriolis_yaw']\n[[run]]\nfile = 'run0.csv'\n";

/// Data that is prepared once: a linear system, and a run with its campaign and its fit.
pub struct Door {
    system: Columns,
    run: Run,
    fitted: OnceCell<(Campaign, Fit)>,
}

impl Door {
    /// The data from the columns of surge in `linear`, and from a simulated run of the planar vehicle.
    pub fn new((model, linear): &(Model, Run), run: Run) -> Door {
        let system = regressors_of(Dof::Surge, &[linear], model, RegressorOptions::default()).expect("surge is linear");
        Door { system, run, fitted: OnceCell::new() }
    }

    fn fitted(&self) -> &(Campaign, Fit) {
        self.fitted.get_or_init(|| fitted(&self.run))
    }

    /// Does one task; the returned text is the same from Python.
    pub fn run(&self, name: &str) -> Result<String, String> {
        match name {
            "core_least_squares" => {
                let fit = least_squares(&self.system.slices(), &self.system.rhs).map_err(|e| e.to_string())?;
                Ok(format!("{:.6e}", fit.coefficients[0]))
            }
            "core_simulate" => {
                let (campaign, fit) = self.fitted();
                let found = campaign::simulate(campaign, &fit.model, &fit.envelope).map_err(|e| e.to_string())?;
                let last = found.runs[0].simulated["u"].last().copied().unwrap_or(f64::NAN);
                black_box(&found);
                Ok(format!("{last:.6e}"))
            }
            "core_fit" => Ok(format!("{:.6e}", fitted(&self.run).1.parameters[0].value)),
            _ => Err(format!("`{name}` is no work")),
        }
    }

    /// Writes the arrays and the model that is simulated.
    pub fn data(&self, folder: &Path) -> Result<(), String> {
        for (k, column) in self.system.slices().into_iter().enumerate() {
            write(folder, &format!("h{k}"), column)?;
        }
        write(folder, "y", &self.system.rhs)?;
        for (name, signal) in &self.run.signals {
            write(folder, &format!("run_{name}"), signal.values())?;
            write(folder, "run_t", signal.time())?;
        }
        let (campaign, fit) = self.fitted();
        let text = ModelFile::of(campaign, fit).to_text(Path::new("model.toml")).map_err(|e| e.to_string())?;
        std::fs::write(folder.join("model.toml"), text).map_err(|e| e.to_string())
    }
}

/// The run as a campaign, fitted by integral least squares. Of all estimators it costs least, so
/// that the cost of the Python interface shows best.
fn fitted(run: &Run) -> (Campaign, Fit) {
    let options = ReadOptions { look_for_files: false, ..ReadOptions::default() };
    let file = CampaignFile::from_bytes(CAMPAIGN.as_bytes(), Path::new("door.toml"), &options).expect("a campaign");
    let campaign = Campaign::from_runs(file, vec![run.clone()]).expect("a sound run");
    let fit = campaign::fit(&campaign, FitOptions { estimator: Some(Estimator::Integral) }).expect("a fit");
    (campaign, fit)
}
