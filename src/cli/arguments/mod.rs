//! Definitions of the command line: verbs, arguments, options.

mod data;
mod model;
mod next;
mod show;

use std::path::PathBuf;

use clap::builder::styling::{AnsiColor, Styles};
use clap::{Args, Parser, Subcommand};

pub(super) use data::{Check, Convert, Init};
pub(super) use model::{Compare, Discover, Fit, Simulate};
pub(super) use next::{Monitor, Plan};
pub(super) use show::{Completions, Demo, Effects, Explain, Export, Report, View};

/// Plain colours of the terminal's own scheme.
const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default());

/// Identification of underwater vehicles: from logs to a model that can be trusted.
#[derive(Debug, Parser)]
#[command(name = "hydrosysid", version, styles = STYLES, subcommand_required = true, arg_required_else_help = true,
    after_help = "Examples:\n  hydrosysid init dive.csv --vehicle bluerov2 -o dive\n  hydrosysid check dive\n  hydrosysid report dive\n  hydrosysid fit dive --model model.toml\n\nExit codes: 0 done, 1 data rejected, 2 usage error.")]
pub(super) struct Arguments {
    #[command(flatten)]
    pub shared: Shared,
    #[command(subcommand)]
    pub verb: Verb,
}

/// Options of every verb.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Options of every verb")]
pub(super) struct Shared {
    /// Write the result as JSON to FILE, or to standard output with `-` (then no table).
    #[arg(long, value_name = "FILE", global = true)]
    pub json: Option<PathBuf>,
    /// Treat warnings as errors.
    #[arg(long, global = true)]
    pub strict: bool,
    /// Replace output files that exist.
    #[arg(long, global = true)]
    pub force: bool,
    /// Print nothing but errors.
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Print the long tables too.
    #[arg(short, long, global = true, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Disable colours, as the environment variable NO_COLOR does.
    #[arg(long, global = true)]
    pub no_color: bool,
    /// Number of threads, at most the number of cores; all cores when absent.
    #[arg(short, long, value_name = "N", global = true, value_parser = threads)]
    pub jobs: Option<usize>,
}

fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if n > 0 => Ok(n),
        _ => Err("a number of threads, 1 or more".into()),
    }
}

#[derive(Debug, Subcommand)]
pub(super) enum Verb {
    /// Run the whole procedure on a virtual tank, including the discovery of a hidden effect.
    Demo(Demo),
    /// Write a commented campaign file from a set of logs.
    Init(Init),
    /// Check logs or a campaign before fitting: green, amber or red.
    Check(Check),
    /// Read a log with its options and write it as plain CSV in SI units.
    Convert(Convert),
    /// Estimate the model's parameters from the training runs.
    Fit(Fit),
    /// Simulate the runs with a model.
    Simulate(Simulate),
    /// Compare a model with every run, training and held-out.
    Compare(Compare),
    /// Find what the model lacks, and confirm it on held-out runs.
    Discover(Discover),
    /// Propose runs that reach wanted standard deviations, or predict those of given runs.
    Plan(Plan),
    /// Compare new logs with a model and report when and why it no longer fits.
    Monitor(Monitor),
    /// Write all results of a campaign as one HTML page.
    Report(Report),
    /// Work on a campaign in the browser: logs, columns, time ranges, effects, discovery, report.
    View(View),
    /// Export a model to a simulator, for control design or as a table; without arguments list the targets.
    Export(Export),
    /// List the effects that a model can contain, or describe one in full.
    Effects(Effects),
    /// List the vehicles that come with the program.
    Vehicles,
    /// Explain the code of a warning or an error.
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

/// How a campaign is loaded.
#[derive(Debug, Clone, Args)]
pub(super) struct Loading {
    /// Allow logs outside the campaign's folder.
    #[arg(long)]
    pub allow_outside: bool,
}

fn pair(text: &str) -> Result<(String, f64), String> {
    let (name, number) = text.split_once('=').ok_or("written NAME=NUMBER")?;
    let number = number.trim().parse().map_err(|_| format!("`{number}` is not a number"))?;
    Ok((name.trim().to_string(), number))
}
