//! Arguments of the verbs for the next steps: further runs, new logs.

use std::path::PathBuf;

use clap::Args;

use super::{Loading, Reading, pair};

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid plan model.toml --want 5% --limit surge=145 --limit yaw=70 -o plan\n  hydrosysid plan campaign.toml --want 'quadratic_drag@surge=10' --without-known\n  hydrosysid plan model.toml --runs plan/plan.toml --rehearse 200"
)]
pub(in crate::cli) struct Plan {
    /// A fitted model, or a campaign, which is fitted first.
    #[arg(value_name = "MODEL|CAMPAIGN")]
    pub source: PathBuf,
    /// Wanted standard deviation, as TERM=STD (SI), TERM=5%, or 5% for all; may be repeated. 5% when absent.
    #[arg(long = "want", value_name = "WANT")]
    pub wants: Vec<crate::campaign::Want>,
    /// Maximum force or moment of a degree of freedom, N or N*m; may be repeated. Known if the campaign
    /// describes its thrusters.
    #[arg(long = "limit", value_name = "DOF=FORCE", value_parser = pair)]
    pub limits: Vec<(String, f64)>,
    /// Noise of a sensor, as CHANNEL=STD (SI); may be repeated. A fitted model holds that of its own runs.
    #[arg(long = "noise", value_name = "CHANNEL=STD", value_parser = pair)]
    pub noise: Vec<(String, f64)>,
    /// Rate of the sensors, Hz, or of one as CHANNEL=HZ; may be repeated.
    #[arg(long = "rate", value_name = "HZ|CHANNEL=HZ", value_parser = rate)]
    pub rates: Vec<(String, f64)>,
    /// Length of each run, s.
    #[arg(long, value_name = "S", default_value_t = 90.0)]
    pub length: f64,
    /// Maximum number of runs.
    #[arg(long, value_name = "N", default_value_t = 12)]
    pub most: usize,
    /// Maximum horizontal distance from the start of a run, m.
    #[arg(long, value_name = "M")]
    pub room: Option<f64>,
    /// Ignore the data of the earlier fit: the new runs will be fitted alone.
    #[arg(long)]
    pub without_known: bool,
    /// Judge the [[run]] tables of FILE instead of proposing runs.
    #[arg(long, value_name = "FILE")]
    pub runs: Option<PathBuf>,
    /// Simulate and fit N campaigns of the plan, and compare their scatter with the prediction.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub rehearse: usize,
    /// Seed of the rehearsal.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Folder for the plan (plan.toml) and the command history of each run (CSV).
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub loading: Loading,
}

/// Parses the rate of one channel; a number alone is the rate of all channels, under the empty
/// name.
fn rate(text: &str) -> Result<(String, f64), String> {
    text.parse().map_or_else(|_| pair(text), |all| Ok((String::new(), all)))
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid monitor model.toml dive17.csv\n  hydrosysid monitor model.toml dive17.csv --campaign campaign.toml --window 10 --json watch.json"
)]
pub(in crate::cli) struct Monitor {
    /// Model file.
    pub model: PathBuf,
    /// Logs, one run each.
    #[arg(required = true, value_name = "LOG")]
    pub logs: Vec<PathBuf>,
    /// Campaign of the same vehicle, for its thrusters, noise and reading options.
    #[arg(long, value_name = "FILE")]
    pub campaign: Option<PathBuf>,
    /// Length of a window, s.
    #[arg(long, value_name = "S", default_value_t = 8.0)]
    pub window: f64,
    /// Probability of a false alarm in the whole log, for white innovations.
    #[arg(long, value_name = "P", default_value_t = 0.01)]
    pub level: f64,
    #[command(flatten)]
    pub reading: Reading,
}
