//! The part of the report about the quality of prediction: the table of equation (25), and each
//! run's own model on every other run, as in Table 6 of Avila et al. (2013).

use super::Results;
use crate::frame::Measured;
use crate::report::{Axis, Block, Cell, Chart, Colours, Column, Figure, HeatMap, Label, Section, Table};
use crate::run::Role;

/// The section of a report.
pub(super) fn section(results: &Results<'_>) -> Section {
    let compared = results.each_run.compared().into_iter();
    let matrices = compared.filter_map(|dof| matrix(results, dof)).map(Block::Figure);
    let ahead = results.fit.noise.as_ref().and_then(super::noise::predictions);
    let tables = std::iter::once(errors(results)).chain(ahead).map(Block::Table);
    Section {
        heading: "How well it predicts".into(),
        paragraphs: Vec::new(),
        blocks: tables.chain(matrices).collect(),
        folded: false,
    }
}

fn errors(results: &Results<'_>) -> Table {
    let rows = results
        .comparison
        .runs
        .iter()
        .map(|r| {
            let number = |value| Cell::Number { value, digits: 3 };
            vec![
                Cell::from(r.run.as_str()),
                Cell::from(if r.role == Role::Train { "train" } else { "validate" }),
                Cell::from(r.dof.to_string().as_str()),
                number(r.mean_abs),
                number(r.std_abs),
                number(r.rms),
                number(r.noise_floor),
                percent(r.fit_percent),
                Cell::from(r.unit.as_str()),
            ]
        })
        .collect();
    let columns = ["run", "role", "degree of freedom", "mean |error|", "std |error|", "rms", "noise", "fit, %", "unit"];
    Table {
        title: "Simulation against measurement, equation (25)".into(),
        columns: columns.into_iter().map(|c| Column::new(c, "")).collect(),
        rows,
        note: "Roles: train takes part in the fit, validate does not. Noise: that of the sensor. Fit: 100 % where the \
               simulation equals the measurement, 0 % where it is no better than the measurement's mean, as in a \
               degree of freedom at rest."
            .into(),
    }
}

/// A percentage with one decimal: a second one is not significant.
fn percent(value: f64) -> Cell {
    let value = (10.0 * value).round() / 10.0;
    let whole = (value.abs() + 0.05).log10().floor().clamp(-1.0, 9.0) as i32;
    Cell::Number { value, digits: (whole + 2).unsigned_abs() }
}

/// The cross-validation matrix of one degree of freedom.
fn matrix(results: &Results<'_>, dof: &Measured) -> Option<Figure> {
    let cells: Vec<&crate::campaign::Crossed> = results.each_run.crossed.iter().filter(|c| c.dof == *dof).collect();
    let (mut models, mut runs): (Vec<&str>, Vec<&str>) = (Vec::new(), Vec::new());
    for cell in &cells {
        if !models.contains(&cell.model.as_str()) {
            models.push(&cell.model);
        }
        if !runs.contains(&cell.run.as_str()) {
            runs.push(&cell.run);
        }
    }
    if models.len() < 2 {
        return None;
    }
    let error = |model: &&str, run: &&str| {
        let found = cells.iter().find(|c| c.model == *model && c.run == *run);
        found.map_or(f64::NAN, |c| 1e3 * c.mean_abs)
    };
    let values: Vec<Vec<f64>> = models.iter().map(|model| runs.iter().map(|run| error(model, run)).collect()).collect();
    let mut sorted: Vec<f64> = values.iter().flatten().copied().filter(|x| x.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let (low, high) = (*sorted.first()?, *sorted.last()?);
    // one model that fails completely must not make all others look alike
    let high = high.min(4.0 * sorted[sorted.len() / 2]).max(low * 1.01);
    let names = |list: &[&str]| list.iter().map(|name| Label::from(super::stem(name))).collect::<Vec<Label>>();
    let left_out: Vec<&str> = results.each_run.left_out.iter().map(|run| super::stem(run)).collect();
    let left_out = match left_out.as_slice() {
        [] => String::new(),
        names => format!(" The longest runs; left out: {}.", names.join(", ")),
    };
    Some(Figure {
        title: format!("Each run's own model on every run, {dof}"),
        caption: format!(
            "Mean |measured − simulated|. A row is a model fitted to one run alone, a column the run on which it is \
             simulated; on the diagonal they are the same.{left_out}"
        ),
        chart: Chart::HeatMap(HeatMap {
            x: Axis::new("simulated run", ""),
            y: Axis::new("", ""),
            columns: names(&runs),
            rows: names(&models),
            values,
            value: Axis::new("mean |error|", &format!("m{}", dof.unit())),
            decimals: if low < 10.0 { 1 } else { 0 },
            colours: Colours::Sequential { low, high },
        }),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_have_one_decimal() {
        let told = |x: f64| match percent(x) {
            Cell::Number { value, digits } => crate::report::number(value, digits, crate::report::Style::Text),
            _ => String::new(),
        };
        let all = [97.613, 100.0, 9.96, 5.52, 0.118, -0.0327, -12.34].map(told);
        assert_eq!(all, ["97.6", "100.0", "10.0", "5.5", "0.1", "0", "−12.3"]);
    }
}
