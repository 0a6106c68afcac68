//! Arguments of the verbs that show and hand over.

use std::path::PathBuf;

use clap::Args;

use super::{Loading, pair};
use crate::demo::HIDDEN;

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  hydrosysid demo\n  hydrosysid demo --hide current --seed 7")]
pub(in crate::cli) struct Demo {
    /// Output folder; only the folder of an earlier demo is replaced.
    #[arg(long, value_name = "FOLDER", default_value = "demo")]
    pub folder: PathBuf,
    /// Seed of the tank.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Sensor noise, as a multiple of the default.
    #[arg(long, value_name = "X", default_value_t = 1.0)]
    pub noise: f64,
    /// Effect hidden in the second campaign: any id of `hydrosysid effects`.
    #[arg(long, value_name = "EFFECT", default_value = HIDDEN)]
    pub hide: String,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid report campaign.toml -o report.html\n  hydrosysid report campaign.toml --params literature.toml"
)]
pub(in crate::cli) struct Report {
    /// Campaign file.
    pub campaign: PathBuf,
    /// Page to write.
    #[arg(short, long, value_name = "FILE", default_value = "report.html")]
    pub output: PathBuf,
    /// Published parameters to show beside the estimates: TOML as for `compare --params`.
    #[arg(long, value_name = "FILE")]
    pub params: Option<PathBuf>,
    /// Leave out the search for what is missing.
    #[arg(long)]
    pub no_discovery: bool,
    #[command(flatten)]
    pub loading: Loading,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid view dive\n  hydrosysid view campaign.toml --port 8080 --no-browser\n\nThe page is served to this machine alone, under the address that is printed, until Ctrl-C. Every change is written into the campaign file, comments kept."
)]
pub(in crate::cli) struct View {
    /// Campaign file, or a folder; in a folder without a campaign the dropped logs make one.
    pub campaign: PathBuf,
    /// Port of 127.0.0.1; a free one when absent.
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub port: u16,
    /// Print the address and open no browser.
    #[arg(long)]
    pub no_browser: bool,
    #[command(flatten)]
    pub loading: Loading,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid export\n  hydrosysid export model.toml --to gazebo-added-mass -o vehicle.sdf\n  hydrosysid export model.toml --to linear-python --at u=0.5 -o linear.py\n  hydrosysid export campaign.toml --to ardusub -o thrusters.param"
)]
pub(in crate::cli) struct Export {
    /// Model file; for thrusters a campaign file.
    #[arg(value_name = "MODEL|CAMPAIGN")]
    pub file: Option<PathBuf>,
    /// Target.
    #[arg(long, value_name = "TARGET")]
    pub to: Option<String>,
    /// File to write; standard output when absent or `-`.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Name of the link that the forces act on [default: base_link].
    #[arg(long, value_name = "NAME")]
    pub link: Option<String>,
    /// Dry mass, kg; that of the vehicle when absent.
    #[arg(long, value_name = "KG")]
    pub mass: Option<f64>,
    /// Dry moments of inertia about the body origin in roll, pitch, yaw, kg*m2.
    #[arg(long, value_name = "IXX,IYY,IZZ", value_delimiter = ',')]
    pub inertia: Vec<f64>,
    /// Operating point of a linear model: u=0.5,r=0.1, and forces tau_u=... unless the equilibrium forces are meant.
    #[arg(long, value_name = "NAME=VALUE", value_delimiter = ',', value_parser = pair, allow_hyphen_values = true)]
    pub at: Vec<(String, f64)>,
    /// The target's inputs are effective forces: thrust losses ([efficiency]) are left to whatever commands it.
    #[arg(long)]
    pub acting: bool,
    /// Version of the simulator that will read the file, such as 8 or 7.2; refused if it cannot.
    #[arg(long, value_name = "VERSION")]
    pub target_version: Option<String>,
}

#[derive(Debug, Args)]
pub(in crate::cli) struct Effects {
    /// Id of one effect; all of them when absent.
    pub id: Option<String>,
    /// Only effects with these words in their id, common name or description.
    #[arg(long, value_name = "TEXT", conflicts_with = "id")]
    pub search: Option<String>,
}

#[derive(Debug, Args)]
pub(in crate::cli) struct Explain {
    /// Code of a finding, such as L105; all of them when absent.
    pub code: Option<String>,
}

#[derive(Debug, Args)]
pub(in crate::cli) struct Completions {
    /// Shell.
    pub shell: clap_complete::Shell,
}
