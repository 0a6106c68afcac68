//! Arguments of the verbs that work on a campaign and its model.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::Loading;
use crate::campaign::Estimator;
use crate::effects::Family;

fn refits(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if n > 1 => Ok(n),
        _ => Err("a number of refits, 2 or more".into()),
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub(in crate::cli) enum EstimatorName {
    /// Maximum likelihood with a random force in the model (Kalman filter).
    FilterError,
    /// Maximum likelihood of free simulation on segments, sensor noise only.
    OutputError,
    /// The paper's procedure, stage by stage.
    Staged,
    /// Integral least squares on all runs at once.
    Integral,
}

impl From<EstimatorName> for Estimator {
    fn from(name: EstimatorName) -> Estimator {
        match name {
            EstimatorName::FilterError => Estimator::FilterError,
            EstimatorName::OutputError => Estimator::OutputError,
            EstimatorName::Staged => Estimator::Staged,
            EstimatorName::Integral => Estimator::Integral,
        }
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid fit campaign.toml --json fit.json --model model.toml\n  hydrosysid fit bench.toml --model ours.toml --vehicle bluerov2\n  hydrosysid fit campaign.toml --bootstrap 1000\n  hydrosysid fit campaign.toml --plot"
)]
pub(in crate::cli) struct Fit {
    /// Campaign file.
    pub campaign: PathBuf,
    /// Estimator. Default: that of the campaign's [fit] table; else staged if there are bollard or towing
    /// runs and runs that show every drag at constant speed, and filter error otherwise.
    #[arg(long, value_enum)]
    pub estimator: Option<EstimatorName>,
    /// Fit by integral least squares without keeping the logs in memory; `--estimator integral` does so above 64 MiB.
    #[arg(long, conflicts_with_all = ["bootstrap", "monte_carlo", "estimator", "thorough", "filters", "plot"])]
    pub stream: bool,
    /// Refit on N bootstrap samples of stretches of the training runs (staged estimator: of whole runs, kind
    /// by kind), and show the scatter.
    #[arg(long, value_name = "N", value_parser = refits, conflicts_with = "monte_carlo")]
    pub bootstrap: Option<usize>,
    /// Refit on N data sets simulated with the fitted model, and show the scatter.
    #[arg(long, value_name = "N", value_parser = refits)]
    pub monte_carlo: Option<usize>,
    /// Test identifiability more closely (some ten fits): profile likelihoods of doubtful parameters, other
    /// segment lengths, the most informative next run; for fits by rows, halves of the runs and longer
    /// windows.
    #[arg(long)]
    pub thorough: bool,
    /// Write the fitted model to FILE (TOML, or JSON if it ends in .json); for bench runs a vehicle file, see
    /// --vehicle.
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// For bench runs: the vehicle that the vehicle file extends, a name from `hydrosysid vehicles` or a file.
    #[arg(long, value_name = "NAME", requires = "model")]
    pub vehicle: Option<String>,
    /// Repeat the staged and the all-at-once fit with polynomial filters of several windows and degrees.
    #[arg(long)]
    pub filters: bool,
    #[command(flatten)]
    pub plotting: Plotting,
    #[command(flatten)]
    pub loading: Loading,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid simulate campaign.toml --model model.toml --output simulated\n  hydrosysid simulate campaign.toml --series series.csv\n  hydrosysid simulate campaign.toml --plot=run07.csv"
)]
pub(in crate::cli) struct Simulate {
    /// Campaign file.
    pub campaign: PathBuf,
    /// Model to simulate; the campaign is fitted when absent.
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Folder for the simulated runs, one CSV file each.
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Folder for the forces of each run and degree of freedom, CSV with one column per term.
    #[arg(long, value_name = "FOLDER")]
    pub forces: Option<PathBuf>,
    #[command(flatten)]
    pub series: Series,
    #[command(flatten)]
    pub plotting: Plotting,
    #[command(flatten)]
    pub loading: Loading,
}

/// Curves in the terminal.
#[derive(Debug, Args)]
pub(in crate::cli) struct Plotting {
    /// Plot measured and simulated velocities in the terminal: of the held-out runs, or of RUN.
    #[arg(long, value_name = "RUN", num_args = 0..=1, require_equals = true, default_missing_value = "")]
    pub plot: Option<String>,
}

/// Series for a plotting tool.
#[derive(Debug, Args)]
pub(in crate::cli) struct Series {
    /// Write measured, simulated and residual series of all runs side by side to FILE, for PlotJuggler or Foxglove:
    /// .csv, or .mcap with the Python package.
    #[arg(long, value_name = "FILE")]
    pub series: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid compare campaign.toml --model model.toml --json compare.json\n  hydrosysid compare campaign.toml --params literature.toml\n  hydrosysid compare campaign.toml --cross\n  hydrosysid compare spring.toml autumn.toml"
)]
pub(in crate::cli) struct Compare {
    /// Campaign file; or the first of two models.
    #[arg(value_name = "CAMPAIGN|MODEL_A")]
    pub campaign: PathBuf,
    /// The second of two models.
    #[arg(value_name = "MODEL_B", conflicts_with_all = ["model", "params", "series", "plot"])]
    pub other: Option<PathBuf>,
    /// Model to compare; the campaign is fitted when absent.
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Fit each run alone and simulate its model on every other run: the cross-validation matrix.
    #[arg(long, conflicts_with_all = ["other", "model", "params", "series", "plot"])]
    pub cross: bool,
    /// Published parameters to compare with the runs and the fitted model: TOML with format, convention,
    /// [parameters]; or a vehicle of `hydrosysid vehicles`.
    #[arg(long, value_name = "FILE", conflicts_with = "series")]
    pub params: Option<PathBuf>,
    #[command(flatten)]
    pub series: Series,
    #[command(flatten)]
    pub plotting: Plotting,
    #[command(flatten)]
    pub loading: Loading,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid discover campaign.toml --json discovery.json\n  hydrosysid discover campaign.toml --adopt"
)]
pub(in crate::cli) struct Discover {
    /// Campaign file.
    pub campaign: PathBuf,
    /// Families of effects to search; those of the campaign's [discover] table when absent.
    #[arg(long, value_enum, value_delimiter = ',', value_name = "FAMILY")]
    pub families: Vec<FamilyName>,
    /// Write the named effects into the campaign and keep its comments; or into FILE, a campaign in the same
    /// folder, which starts as a copy of this one if it does not exist.
    #[arg(long, value_name = "FILE")]
    #[allow(clippy::option_option)] // absent, alone, with a file
    pub adopt: Option<Option<PathBuf>>,
    #[command(flatten)]
    pub loading: Loading,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum FamilyName {
    /// Forces in the balance of momentum.
    Body,
    /// Changes of the force between command and water.
    Actuator,
    /// Motion of the water, and external forces.
    Environment,
    /// Errors of what is logged.
    Sensor,
}

impl From<FamilyName> for Family {
    fn from(name: FamilyName) -> Family {
        match name {
            FamilyName::Body => Family::Body,
            FamilyName::Actuator => Family::Actuator,
            FamilyName::Environment => Family::Environment,
            FamilyName::Sensor => Family::Sensor,
        }
    }
}
