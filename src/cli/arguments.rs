//! What may be typed: verbs, arguments, options.

use std::path::PathBuf;

use clap::builder::styling::{AnsiColor, Styles};
use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::campaign::Estimator;
use crate::effects::Family;

/// Plain colours of the terminal's own scheme.
const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default());

/// Identification of underwater vehicles: from logs to a model that can be trusted.
#[derive(Debug, Parser)]
#[command(name = "hydrosysid", version, styles = STYLES, subcommand_required = true, arg_required_else_help = true,
    after_help = "Examples:\n  hydrosysid init run1.csv run2.csv --mass 189 -o campaign.toml\n  hydrosysid check campaign.toml\n  hydrosysid fit campaign.toml --model model.toml\n  hydrosysid compare campaign.toml --model model.toml\n\nExit codes: 0 done, 1 the data was refused, 2 wrong use.")]
pub(super) struct Arguments {
    #[command(flatten)]
    pub shared: Shared,
    #[command(subcommand)]
    pub verb: Verb,
}

/// Options of every verb.
#[derive(Debug, Clone, Args)]
pub(super) struct Shared {
    /// Write the result as JSON to FILE, or to standard output with `-` (then no table).
    #[arg(long, value_name = "FILE", global = true)]
    pub json: Option<PathBuf>,
    /// Take warnings as errors.
    #[arg(long, global = true)]
    pub strict: bool,
    /// Replace output files that exist.
    #[arg(long, global = true)]
    pub force: bool,
    /// Print nothing but errors.
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// No colours; the environment variable NO_COLOR does the same.
    #[arg(long, global = true)]
    pub no_color: bool,
    /// Number of threads; all cores when absent.
    #[arg(short, long, value_name = "N", global = true, value_parser = threads)]
    pub jobs: Option<usize>,
}

fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if n > 0 => Ok(n),
        _ => Err("a number of threads, 1 or more".into()),
    }
}

fn refits(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if n > 1 => Ok(n),
        _ => Err("a number of refits, 2 or more".into()),
    }
}

#[derive(Debug, Subcommand)]
pub(super) enum Verb {
    /// Show the whole procedure on a virtual tank, and an effect that was hidden found again.
    Demo(Demo),
    /// Write a commented campaign file from a set of logs.
    Init(Init),
    /// Look at logs or a campaign before anything is fitted: green, amber or red.
    Check(Check),
    /// Read a log with its options and write it as plain CSV in SI units.
    Convert(Convert),
    /// Estimate the model's parameters from the training runs.
    Fit(Fit),
    /// Simulate the runs with a model.
    Simulate(Simulate),
    /// Hold a model against every run, those of the fit and those that took no part.
    Compare(Compare),
    /// Find what the model lacks, and show it on runs that took no part.
    Discover(Discover),
    /// Propose the runs that bring parameters to wanted deviations, or say what given runs will bring.
    Plan(Plan),
    /// Run a model along a new log and say when it no longer fits.
    Monitor(Monitor),
    /// Write everything about a campaign as one HTML page.
    Report(Report),
    /// Write a model for a simulator, for control design or as a table; without arguments list the targets.
    Export(Export),
    /// List the effects that a model may hold, or tell all of one.
    Effects(Effects),
    /// Tell what the code of a warning or an error means.
    Explain(Explain),
    /// Write completions for a shell.
    Completions(Completions),
    /// Write the manual page.
    Man,
}

/// How bare logs are read.
#[derive(Debug, Clone, Args)]
pub(super) struct Reading {
    /// A reading option as in the campaign's [log] table, such as 'missing = "drop"'; may be repeated.
    #[arg(long = "log", value_name = "KEY=VALUE")]
    pub options: Vec<String>,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  hydrosysid init surge*.csv yaw*.csv --name LAURS --mass 189 --volume 0.19 -o campaign.toml"
)]
pub(super) struct Init {
    /// Logs.
    #[arg(required = true, value_name = "LOG")]
    pub logs: Vec<PathBuf>,
    /// Campaign file to write; standard output when absent.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Name of the vehicle.
    #[arg(long, default_value = "vehicle")]
    pub name: String,
    /// Dry mass, kg.
    #[arg(long, value_name = "KG")]
    pub mass: Option<f64>,
    /// Displaced volume, m3.
    #[arg(long, value_name = "M3")]
    pub volume: Option<f64>,
    /// Weight in air, N.
    #[arg(long, value_name = "N")]
    pub weight: Option<f64>,
    /// Buoyancy, N.
    #[arg(long, value_name = "N")]
    pub buoyancy: Option<f64>,
    /// Characteristic length, m.
    #[arg(long, value_name = "M")]
    pub length: Option<f64>,
    #[command(flatten)]
    pub reading: Reading,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid check campaign.toml\n  hydrosysid check dive.csv --log 'delimiter = \";\"' --log 'decimal = \",\"'"
)]
pub(super) struct Check {
    /// A campaign (.toml), or logs.
    #[arg(required = true, value_name = "CAMPAIGN|LOG")]
    pub files: Vec<PathBuf>,
    /// Columns that a bare log must have, separated by commas.
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
pub(super) struct Convert {
    /// Log to read: CSV, or with the Python package a bag, .mcap, .bin, .ulg, .mat, .parquet, .arrow, .npz.
    pub log: PathBuf,
    /// File to write.
    #[arg(required_unless_present = "out", conflicts_with = "out")]
    pub output: Option<PathBuf>,
    /// File to write.
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// TOML file with the reading options, columns among them.
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
}

/// How a campaign is loaded.
#[derive(Debug, Clone, Args)]
pub(super) struct Loading {
    /// Let logs lie outside the campaign's folder.
    #[arg(long)]
    pub allow_outside: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub(super) enum EstimatorName {
    /// Simulation against measurement on segments.
    OutputError,
    /// The paper's procedure, stage by stage.
    Staged,
    /// Integral least squares on all runs at once.
    Integral,
}

impl From<EstimatorName> for Estimator {
    fn from(name: EstimatorName) -> Estimator {
        match name {
            EstimatorName::OutputError => Estimator::OutputError,
            EstimatorName::Staged => Estimator::Staged,
            EstimatorName::Integral => Estimator::Integral,
        }
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid fit campaign.toml --json fit.json --model model.toml\n  hydrosysid fit campaign.toml --bootstrap 1000"
)]
pub(super) struct Fit {
    /// Campaign file.
    pub campaign: PathBuf,
    /// Estimator; that of the campaign's [fit] table, else staged where bollard or towing runs take part and output
    /// error otherwise.
    #[arg(long, value_enum)]
    pub estimator: Option<EstimatorName>,
    /// Fit by integral least squares without keeping the logs, as `--estimator integral` does of itself beyond 64 MiB.
    #[arg(long, conflicts_with_all = ["bootstrap", "monte_carlo", "estimator", "thorough", "filters"])]
    pub stream: bool,
    /// Refit by output error on N resamplings of stretches of the training runs, and show the scatter.
    #[arg(long, value_name = "N", value_parser = refits, conflicts_with = "monte_carlo")]
    pub bootstrap: Option<usize>,
    /// Refit by output error on N data sets that the fitted model makes, and show the scatter.
    #[arg(long, value_name = "N", value_parser = refits)]
    pub monte_carlo: Option<usize>,
    /// Look closer at what the data can tell: profile likelihoods of doubtful parameters, segments of other lengths, the
    /// run that would tell most (output error only; takes some ten fits).
    #[arg(long)]
    pub thorough: bool,
    /// Write the fitted model to FILE (TOML, or JSON where it ends in .json).
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Repeat the staged and the all-at-once fit with polynomial filters of several windows and degrees.
    #[arg(long)]
    pub filters: bool,
    #[command(flatten)]
    pub loading: Loading,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid simulate campaign.toml --model model.toml --output simulated\n  hydrosysid simulate campaign.toml --series series.csv"
)]
pub(super) struct Simulate {
    /// Campaign file.
    pub campaign: PathBuf,
    /// Model to simulate; the campaign is fitted when absent.
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Folder in which each run is written as CSV.
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Folder in which the forces of each run and degree of freedom are written as CSV, a column a term.
    #[arg(long, value_name = "FOLDER")]
    pub forces: Option<PathBuf>,
    #[command(flatten)]
    pub series: Series,
    #[command(flatten)]
    pub loading: Loading,
}

/// Series for a plotting tool.
#[derive(Debug, Args)]
pub(super) struct Series {
    /// Write measured, simulated and residual series of all runs side by side to FILE, for PlotJuggler or Foxglove: .csv,
    /// or .mcap with the Python package.
    #[arg(long, value_name = "FILE")]
    pub series: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid compare campaign.toml --model model.toml --json compare.json\n  hydrosysid compare campaign.toml --params literature.toml\n  hydrosysid compare spring.toml autumn.toml"
)]
pub(super) struct Compare {
    /// Campaign file; or the first of two models.
    #[arg(value_name = "CAMPAIGN|MODEL_A")]
    pub campaign: PathBuf,
    /// The second of two models.
    #[arg(value_name = "MODEL_B", conflicts_with_all = ["model", "params", "series"])]
    pub other: Option<PathBuf>,
    /// Model to compare; the campaign is fitted when absent.
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Published parameters to hold against the runs and the own model: TOML with format, convention, [parameters].
    #[arg(long, value_name = "FILE", conflicts_with = "series")]
    pub params: Option<PathBuf>,
    #[command(flatten)]
    pub series: Series,
    #[command(flatten)]
    pub loading: Loading,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  hydrosysid discover campaign.toml --json discovery.json")]
pub(super) struct Discover {
    /// Campaign file.
    pub campaign: PathBuf,
    /// Families of effects to search; those of the campaign's [discover] table when absent.
    #[arg(long, value_enum, value_delimiter = ',', value_name = "FAMILY")]
    pub families: Vec<FamilyName>,
    #[command(flatten)]
    pub loading: Loading,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum FamilyName {
    /// Forces in the balance of momentum.
    Body,
    /// Changes of the force between command and water.
    Actuator,
    /// What the water does, and what pulls from outside.
    Environment,
    /// Changes of what is logged.
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

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid plan model.toml --want 5% --limit surge=145 --limit yaw=70 -o plan\n  hydrosysid plan campaign.toml --want 'quadratic_drag@surge=10' --with-known\n  hydrosysid plan model.toml --runs plan/plan.toml --rehearse 200"
)]
pub(super) struct Plan {
    /// A fitted model, or a campaign, which is fitted first.
    #[arg(value_name = "MODEL|CAMPAIGN")]
    pub source: PathBuf,
    /// Wanted standard deviation, as TERM=STD (SI), TERM=5%, or 5% for all; may be repeated. 5% when absent.
    #[arg(long = "want", value_name = "WANT")]
    pub wants: Vec<crate::campaign::Want>,
    /// Greatest force or moment of a degree of freedom, N or N*m; may be repeated. A campaign's thrusters are known.
    #[arg(long = "limit", value_name = "DOF=FORCE", value_parser = pair)]
    pub limits: Vec<(String, f64)>,
    /// Noise of a sensor, as CHANNEL=STD (SI); may be repeated. A model knows that of its own runs.
    #[arg(long = "noise", value_name = "CHANNEL=STD", value_parser = pair)]
    pub noise: Vec<(String, f64)>,
    /// Rate of the sensors, Hz, or of one as CHANNEL=HZ; may be repeated.
    #[arg(long = "rate", value_name = "HZ|CHANNEL=HZ", value_parser = rate)]
    pub rates: Vec<(String, f64)>,
    /// Length of each run, s.
    #[arg(long, value_name = "S", default_value_t = 90.0)]
    pub length: f64,
    /// Most runs.
    #[arg(long, value_name = "N", default_value_t = 12)]
    pub most: usize,
    /// Greatest horizontal distance from the start of a run, m.
    #[arg(long, value_name = "M")]
    pub room: Option<f64>,
    /// Count on the data that the model comes from: old and new runs will be fitted together.
    #[arg(long)]
    pub with_known: bool,
    /// Judge the [[run]] tables of FILE instead of proposing runs.
    #[arg(long, value_name = "FILE")]
    pub runs: Option<PathBuf>,
    /// Simulate and fit N campaigns of the plan, and hold their scatter against the prediction.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub rehearse: usize,
    /// Seed of the rehearsal.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Folder in which the plan (plan.toml) and the command history of each run (CSV) are written.
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub loading: Loading,
}

fn pair(text: &str) -> Result<(String, f64), String> {
    let (name, number) = text.split_once('=').ok_or("written NAME=NUMBER")?;
    let number = number.trim().parse().map_err(|_| format!("`{number}` is no number"))?;
    Ok((name.trim().to_string(), number))
}

/// A rate of its own, or under the empty name that of all.
fn rate(text: &str) -> Result<(String, f64), String> {
    text.parse().map_or_else(|_| pair(text), |all| Ok((String::new(), all)))
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid monitor model.toml dive17.csv\n  hydrosysid monitor model.toml dive17.csv --campaign campaign.toml --window 10 --json watch.json"
)]
pub(super) struct Monitor {
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
    /// Probability of a false alarm in the whole log, by white noise.
    #[arg(long, value_name = "P", default_value_t = 0.01)]
    pub level: f64,
    #[command(flatten)]
    pub reading: Reading,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  hydrosysid demo\n  hydrosysid demo --hide current --seed 7")]
pub(super) struct Demo {
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
    #[arg(long, value_name = "EFFECT", default_value = "coriolis_yaw")]
    pub hide: String,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  hydrosysid report campaign.toml -o report.html")]
pub(super) struct Report {
    /// Campaign file.
    pub campaign: PathBuf,
    /// Page to write.
    #[arg(short, long, value_name = "FILE", default_value = "report.html")]
    pub output: PathBuf,
    /// Leave out the search for what is missing.
    #[arg(long)]
    pub no_discovery: bool,
    #[command(flatten)]
    pub loading: Loading,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  hydrosysid export\n  hydrosysid export model.toml --to gazebo-added-mass -o vehicle.sdf\n  hydrosysid export model.toml --to linear-python --at u=0.5 -o linear.py\n  hydrosysid export campaign.toml --to ardusub -o thrusters.param"
)]
pub(super) struct Export {
    /// Model file; for thrusters a campaign file.
    #[arg(value_name = "MODEL|CAMPAIGN")]
    pub file: Option<PathBuf>,
    /// Target.
    #[arg(long, value_name = "TARGET")]
    pub to: Option<String>,
    /// File to write; standard output when absent.
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
}

#[derive(Debug, Args)]
pub(super) struct Effects {
    /// Id of one effect.
    pub id: Option<String>,
}

#[derive(Debug, Args)]
pub(super) struct Explain {
    /// Code of a finding, such as L105; all of them when absent.
    pub code: Option<String>,
}

#[derive(Debug, Args)]
pub(super) struct Completions {
    /// Shell.
    pub shell: clap_complete::Shell,
}
