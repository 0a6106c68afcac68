//! Measured and simulated velocities in the terminal, for `--plot`.

use super::failure::Failure;
use super::output::Output;
use crate::campaign::{self, Campaign, Simulated, Simulation};
use crate::frame::Dof;
use crate::model::Model;
use crate::report::{Chart, terminal};
use crate::report_content::motion_figure;
use crate::run::Role;

/// Width if standard output is no terminal, characters.
const WIDTH: usize = 80;
/// Height of a plot, characters.
const HEIGHT: usize = 16;

/// Simulates `model` and draws plots, if plots are requested.
pub(super) fn of_model(
    asked: Option<&str>,
    campaign: &Campaign,
    model: &Model,
    output: &Output,
) -> Result<(), Failure> {
    let Some(run) = asked else { return Ok(()) };
    // the verb itself has reported what lies outside the envelope
    let simulation = output.working("simulating", || campaign::simulate(campaign, model, &Default::default()))??;
    simulated(Some(run), &simulation, output)
}

/// Draws the requested run; for an empty name the held-out runs, or all if there are none.
pub(super) fn simulated(asked: Option<&str>, simulation: &Simulation, output: &Output) -> Result<(), Failure> {
    let Some(name) = asked else { return Ok(()) };
    let held_out = simulation.runs.iter().any(|run| run.role == Role::Validate);
    let wanted = |run: &&Simulated| match name {
        "" => !held_out || run.role == Role::Validate,
        name => run.run == name,
    };
    let runs: Vec<&Simulated> = simulation.runs.iter().filter(wanted).collect();
    if runs.is_empty() {
        let names: Vec<&str> = simulation.runs.iter().map(|run| run.run.as_str()).collect();
        return Err(Failure::Argument(format!("--plot={name}: no such run; there are {}", names.join(", "))));
    }
    let width = super::table::width().unwrap_or(WIDTH);
    for run in runs {
        for figure in Dof::ALL.into_iter().filter_map(|dof| motion_figure(run, dof, None)) {
            if let Chart::Curves(curves) = &figure.chart {
                output.print(&format!("{}\n{}", figure.title, terminal::plot(curves, width, HEIGHT)));
            }
        }
    }
    Ok(())
}
