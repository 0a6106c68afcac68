//! Arguments of the verbs that show and hand over.

use std::path::PathBuf;

use clap::Args;

use super::{Loading, pair};
use crate::demo::HIDDEN;

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  hydrosysid demo\n  hydrosysid demo --hide current --seed 7")]
pub(in crate::cli) struct Demo {
    /// Folder to write; an earlier demo's is replaced, nobody else's.
    #[arg(long, value_name = "FOLDER", default_value = "demo")]
    pub folder: PathBuf,
    /// Seed of the tank.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Noise of the sensors, in units of the ordinary one.
    #[arg(long, value_name = "X", default_value_t = 1.0)]
    pub noise: f64,
    /// Effect that the second campaign hides: any id of `hydrosysid effects`.
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
    /// Campaign file, or a folder for one: without a campaign it begins with the logs that are dropped.
    pub campaign: PathBuf,
    /// Port of 127.0.0.1; any that is free when absent.
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
    /// Operating point of a linear model: u=0.5,r=0.1 and forces tau_u=... where they are not those that hold it.
    #[arg(long, value_name = "NAME=VALUE", value_delimiter = ',', value_parser = pair, allow_hyphen_values = true)]
    pub at: Vec<(String, f64)>,
    /// Forces in the target are those that act: losses of thrust ([efficiency]) are counted by what makes them.
    #[arg(long)]
    pub acting: bool,
    /// Version of the simulator that is to read the file, such as 8 or 7.2: refused where it would not.
    #[arg(long, value_name = "VERSION")]
    pub target_version: Option<String>,
}

#[derive(Debug, Args)]
pub(in crate::cli) struct Effects {
    /// Id of one effect; all of them when absent.
    pub id: Option<String>,
    /// Only effects that hold these words in their id, common name or meaning.
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
