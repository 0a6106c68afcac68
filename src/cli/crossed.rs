//! `compare --cross`: the model of each run on every other run, as matrices that fit into a
//! terminal.

use super::answer;
use super::output::Output;
use super::table::{number, table, width};
use crate::campaign::{Crossed, EachRun};
use crate::frame::Measured;
use crate::wording::count;

/// Width of a column of the matrix, characters, including the blanks between two columns.
const CELL: usize = 7;

/// Ratio of the median error on other runs to that on the own run, above which models carry over
/// poorly.
const POORLY: f64 = 2.0;

/// Prints the verdict and the matrix of the degree of freedom in which the models carry over worst;
/// all with `--verbose`.
pub(super) fn print(found: &EachRun, output: &Output) {
    if found.models.len() < 2 {
        answer::verdict("Fewer than two runs can be fitted alone: no cross-validation is possible.", output);
        return;
    }
    let mut dofs: Vec<(&Measured, f64)> =
        found.compared().into_iter().filter_map(|dof| Some((dof, apart(found, dof)?))).collect();
    dofs.sort_by(|a, b| b.1.total_cmp(&a.1));
    let Some((worst, times)) = dofs.first().copied() else {
        answer::verdict(
            "No model of a single run can be simulated on another run that logs what it predicts: no cross-validation \
             is possible.",
            output,
        );
        return;
    };
    answer::verdict(
        &format!(
            "{} of single runs on all others: in {worst} the median error on another run is {} times that on its own \
             run. {}",
            count(found.models.len(), "model"),
            number(times),
            if times > POORLY {
                "If a model transfers badly, its run does not show what the other run needs."
            } else {
                "Each run shows what the others need."
            }
        ),
        output,
    );
    if !found.left_out.is_empty() && output.is_verbose() {
        output.print(&format!("the longest runs; left out: {}", found.left_out.join(", ")));
    }
    let shown = if output.is_verbose() { dofs.len() } else { 1 };
    for (dof, _) in &dofs[..shown] {
        matrix(found, dof, output);
    }
    if shown < dofs.len() {
        let others: Vec<String> = dofs[1..].iter().map(|(dof, _)| dof.to_string()).collect();
        output.print(&format!("-v shows {} too", others.join(", ")));
    }
}

/// Root mean square of measured − simulated.
fn rms(cell: &Crossed) -> f64 {
    cell.mean_abs.hypot(cell.std_abs)
}

/// Median over the models of (median error on other runs / error on the own run); `None` if there
/// are no other runs.
fn apart(found: &EachRun, dof: &Measured) -> Option<f64> {
    let of_model = |model: &str| {
        let cells = || found.crossed.iter().filter(|c| c.dof == *dof && c.model == model);
        let own = cells().find(|c| c.run == c.model).map(rms)?;
        let other = median(cells().filter(|c| c.run != c.model).map(rms).collect())?;
        (own > 0.0).then(|| other / own)
    };
    median(found.models.iter().filter_map(|m| of_model(&m.run)).collect())
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Prints one row per model and one numbered column per run, in blocks of as many columns as fit
/// into the terminal.
fn matrix(found: &EachRun, dof: &Measured, output: &Output) {
    let cells: Vec<&Crossed> = found.crossed.iter().filter(|c| c.dof == *dof).collect();
    let mut runs: Vec<&str> = Vec::new();
    for cell in &cells {
        if !runs.contains(&cell.run.as_str()) {
            runs.push(&cell.run);
        }
    }
    let numbered = |run: &str| runs.iter().position(|r| *r == run).map_or_else(String::new, |k| (k + 1).to_string());
    let label = |run: &str| answer::cut(&format!("{} {run}", numbered(run)), 24);
    let models: Vec<&str> =
        found.models.iter().map(|m| m.run.as_str()).filter(|m| cells.iter().any(|c| c.model == *m)).collect();
    let left = models.iter().map(|m| label(m).chars().count()).max().unwrap_or(0).max("model of".len()) + 2;
    let room = width().unwrap_or(80).saturating_sub(left) / CELL;
    output
        .print(&format!("rms error in {dof}, m{}; columns are the runs on which the models are simulated", dof.unit()));
    let columns: Vec<usize> = (0..runs.len()).collect();
    for block in columns.chunks(room.max(1)) {
        let row = |model: &&str| -> Vec<String> {
            let cell = |k: &usize| {
                let own = cells.iter().find(|c| c.model == **model && c.run == runs[*k]);
                own.map_or_else(String::new, |c| short(1e3 * rms(c)))
            };
            std::iter::once(label(model)).chain(block.iter().map(cell)).collect()
        };
        let heads: Vec<String> =
            std::iter::once("model of".to_string()).chain(block.iter().map(|k| (k + 1).to_string())).collect();
        let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
        output.print(&table(&heads, &models.iter().map(row).collect::<Vec<_>>()));
    }
    let alone: Vec<String> = runs.iter().filter(|run| !models.contains(run)).map(|run| label(run)).collect();
    if !alone.is_empty() {
        output.print(&super::table::wrapped(&format!("without their own model: {}", alone.join(", "))));
    }
}

/// A number in at most five characters: `4.10`, `81.4`, `1520`, `>1e4`.
fn short(x: f64) -> String {
    match x {
        x if !x.is_finite() || x >= 1e4 => ">1e4".into(),
        x if x >= 100.0 => format!("{x:.0}"),
        x if x >= 10.0 => format!("{x:.1}"),
        x => format!("{x:.2}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_is_short() {
        let told: Vec<String> = [0.004, 4.1, 81.44, 1520.3, 1e9, f64::NAN].map(short).into();
        assert_eq!(told, ["0.00", "4.10", "81.4", "1520", ">1e4", ">1e4"]);
        assert!(told.iter().all(|cell| cell.len() + 2 <= CELL));
    }
}
