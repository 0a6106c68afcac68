//! Completions and the manual page.

use clap::CommandFactory;

use super::arguments::{Arguments, Completions};
use super::failure::Failure;
use super::output::Output;

pub(super) fn completions(arguments: &Completions, output: &Output) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut Arguments::command(), "hydrosysid", &mut text);
    output.hand_over(&String::from_utf8_lossy(&text));
    Ok(())
}

pub(super) fn man(output: &Output) -> Result<(), Failure> {
    let failed = |source| Failure::Write { file: "standard output".into(), source };
    let mut text = Vec::new();
    let mut command = Arguments::command();
    clap_mangen::Man::new(command.clone()).render(&mut text).map_err(failed)?;
    command.build();
    for verb in command.get_subcommands().filter(|c| c.get_name() != "help") {
        let verb = verb.clone().display_name(format!("hydrosysid-{}", verb.get_name()));
        clap_mangen::Man::new(verb).render(&mut text).map_err(failed)?;
    }
    output.hand_over(&String::from_utf8_lossy(&text));
    Ok(())
}
