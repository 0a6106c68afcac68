//! The `hydrosysid` command: reads arguments, calls one function of the library, prints its result.
//!
//! People get tables on standard output, programs get JSON with `--json`; progress and messages go
//! to standard error. Exit codes: 0 done, 1 data rejected or unsuitable for the work, 2 usage
//! error.

mod answer;
mod arguments;
mod bench;
mod catalogue;
mod check;
mod compare;
mod convert;
mod crossed;
mod difference;
mod discovered;
mod export;
mod failure;
mod fitted;
mod init;
mod inputs;
mod message;
mod monitor;
mod noise;
mod output;
mod plan;
mod plot;
mod scatter;
mod shell;
mod show;
mod simulated;
mod table;
mod vehicles;
mod verbs;
mod view;

use std::ffi::OsString;
use std::io::Write;
use std::num::NonZero;
use std::process::ExitCode;

use clap::Parser;

use arguments::{Arguments, Verb};
use failure::Failure;
use output::Output;

/// Runs the command with the arguments of the process.
pub fn run() -> ExitCode {
    ExitCode::from(run_with(std::env::args_os()))
}

/// Runs the command with these arguments, the first of which is its name; returns the exit code.
pub fn run_with(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> u8 {
    let words: Vec<OsString> = arguments.into_iter().map(Into::into).collect();
    let typed = words.iter().map(|word| word.to_string_lossy().into_owned()).collect();
    let arguments = match Arguments::try_parse_from(words) {
        Ok(arguments) => arguments,
        Err(told) => {
            // a reader that closed the pipe is no error here; a full disk gives exit code 2
            let is_lost = told.print().and_then(|()| std::io::stdout().flush());
            let is_lost = is_lost.is_err_and(|e| e.kind() != std::io::ErrorKind::BrokenPipe);
            return if is_lost { 2 } else { u8::try_from(told.exit_code()).unwrap_or(2) };
        }
    };
    let output = Output::new(&arguments.shared, inputs::of(&arguments.verb), typed);
    if let Some(jobs) = arguments.shared.jobs {
        // the pool is made at its first use; an existing pool stays unchanged
        let _ = rayon::ThreadPoolBuilder::new().num_threads(jobs.min(cores())).build_global();
    }
    let once = inputs::can_be_read_again(&arguments.verb);
    match once.and_then(|()| dispatch(&arguments, &output)).and_then(|()| output.finish()) {
        Ok(()) => 0,
        Err(failure) => {
            message::failure(&failure, &output);
            failure.exit_code()
        }
    }
}

/// Number of cores that this process may use: more threads would only take memory.
fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}

/// Calls the function of the verb.
fn dispatch(arguments: &Arguments, output: &Output) -> Result<(), Failure> {
    match &arguments.verb {
        Verb::Demo(a) => show::demo(a, output),
        Verb::Init(a) => init::init(a, output),
        Verb::Check(a) => check::check(a, output),
        Verb::Convert(a) => convert::convert(a, output),
        Verb::Fit(a) => verbs::fit(a, output),
        Verb::Simulate(a) => verbs::simulate(a, output),
        Verb::Compare(a) => compare::compare(a, output),
        Verb::Discover(a) => verbs::discover(a, output),
        Verb::Plan(a) => plan::plan(a, output),
        Verb::Monitor(a) => monitor::monitor(a, output),
        Verb::Report(a) => show::report(a, output),
        Verb::View(a) => view::view(a, output),
        Verb::Export(a) => export::export(a, output),
        Verb::Effects(a) => catalogue::effects(a, output),
        Verb::Vehicles => vehicles::vehicles(output),
        Verb::Explain(a) => catalogue::explain(a, output),
        Verb::Completions(a) => shell::completions(a, output),
        Verb::Man => shell::man(output),
    }
}
