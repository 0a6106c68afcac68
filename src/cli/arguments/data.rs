//! Arguments of the verbs that work on logs.

use std::path::PathBuf;

use clap::Args;

use super::{Loading, Reading};

fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0);
    number.ok_or_else(|| "a finite number above 0".into())
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid init dive.csv --vehicle bluerov2 -o dive\n  hydrosysid init surge*.csv yaw*.csv --name LAURS --mass 189 --volume 0.19 -o campaign.toml\n  hydrosysid init imu.csv dvl.csv thrusters.csv -o dive --log 'columns.t = \"time\"'\n\nEvery guess stands in the file as a comment that begins with `# guessed:`. Logs outside the campaign's folder are\ncopied into it. With the Python package the logs may be ROS bags, .mcap, .BIN, .tlog, .ulg, .mat or .parquet too."
)]
pub(in crate::cli) struct Init {
    /// Logs; several logs of one dive are merged.
    #[arg(required = true, value_name = "LOG")]
    pub logs: Vec<PathBuf>,
    /// Output folder or campaign file (.toml); standard output when absent.
    #[arg(short, long, value_name = "FOLDER|FILE")]
    pub output: Option<PathBuf>,
    /// Vehicle that comes with the program (`hydrosysid vehicles`), or a vehicle file.
    #[arg(long, value_name = "NAME|FILE")]
    pub vehicle: Option<String>,
    /// Name of the vehicle.
    #[arg(long)]
    pub name: Option<String>,
    /// Dry mass, kg.
    #[arg(long, value_name = "KG", value_parser = positive)]
    pub mass: Option<f64>,
    /// Displaced volume, m3.
    #[arg(long, value_name = "M3", value_parser = positive)]
    pub volume: Option<f64>,
    /// Weight in air, N.
    #[arg(long, value_name = "N", value_parser = positive)]
    pub weight: Option<f64>,
    /// Buoyancy, N.
    #[arg(long, value_name = "N", value_parser = positive)]
    pub buoyancy: Option<f64>,
    /// Characteristic length, m.
    #[arg(long, value_name = "M", value_parser = positive)]
    pub length: Option<f64>,
    /// Definition of a ROS message that the bag does not contain (.msg), or a folder of them; needs the Python package.
    #[arg(long, value_name = "FILE|FOLDER")]
    pub msg: Vec<PathBuf>,
    /// What the reader of another format has learned from the log (TOML); written by the Python package.
    #[arg(long, value_name = "FILE", hide = true)]
    pub learned: Option<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid check campaign.toml\n  hydrosysid check dive.csv --log 'delimiter = \";\"' --log 'decimal = \",\"'"
)]
pub(in crate::cli) struct Check {
    /// A campaign (.toml, or the folder that holds campaign.toml), or logs.
    #[arg(required = true, value_name = "CAMPAIGN|LOG")]
    pub files: Vec<PathBuf>,
    /// Columns that a log without a campaign must have, separated by commas.
    #[arg(long, value_delimiter = ',', value_name = "COLUMNS", default_value = "t,u,v,r,tau_u,tau_v,tau_r")]
    pub columns: Vec<String>,
    #[command(flatten)]
    pub reading: Reading,
    #[command(flatten)]
    pub campaign: Loading,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid convert dive.csv -o plain.csv --log 'body_frame = \"flu\"' --log 'time_unit = \"ms\"'\n  hydrosysid convert dive.mcap -o plain.csv --map map.toml\n\nThe map is a TOML table as the campaign's [log]: columns (canonical name = where it stands, with unit, scale,\nsign and frame), body_frame, earth_frame, and so on. ROS bags, MCAP, DataFlash, ULog, MAT, Parquet, Arrow and NumPy\nfiles are read by the command of the Python package."
)]
pub(in crate::cli) struct Convert {
    /// Log to read: CSV, or with the Python package a bag, .mcap, .bin, .tlog, .ulg, .mat, .h5, .parquet, .arrow, .npz.
    pub log: PathBuf,
    /// File to write.
    #[arg(required_unless_present = "out", conflicts_with = "out")]
    pub output: Option<PathBuf>,
    /// File to write; `-` for standard output.
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// TOML file with the reading options, columns among them.
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Definition of a ROS message that the bag does not contain (.msg), or a folder of them; needs the Python package.
    #[arg(long, value_name = "FILE|FOLDER")]
    pub msg: Vec<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
}
