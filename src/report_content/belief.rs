//! The evidence for each estimate: a table, the correlations as a heat map, and a forest plot of
//! the values from runs, stages and the literature.
//!
//! ```text
//! ρ_jk = Σ_jk / √(Σ_jj Σ_kk)
//! ```

use super::{COVER, Results};
use crate::report::{
    Axis, Block, Cell, Chart, Colours, Column, Figure, Forest, ForestRow, HeatMap, Interval, Label, Table, estimate,
};

/// Maximum number of parameters of a heat map: more would be too small to read.
const MOST: usize = 24;
/// Maximum number of sources per row of the forest besides the model and the literature: those with
/// the smallest standard deviations.
const SOURCES: usize = 10;
/// Limit of the standard deviation of an estimate in the forest, as a fraction of the common
/// estimate and of its own value: a worse one says nothing and would stretch the axis.
const SHOWN: f64 = 0.5;

/// Tables and figures of the section on the model.
pub(super) fn blocks(results: &Results<'_>) -> Vec<Block> {
    let table = table(results).map(Block::Table);
    let figures = [correlations(results), forest(results)].into_iter().flatten().map(Block::Figure);
    table.into_iter().chain(figures).collect()
}

fn table(results: &Results<'_>) -> Option<Table> {
    let known = results.fit.identifiability.as_ref()?;
    let number = |x: Option<f64>, digits| x.map_or(Cell::Empty, |value| Cell::Number { value, digits });
    let rows = known
        .parameters
        .iter()
        .map(|p| {
            vec![
                Cell::from(p.term.as_str()),
                Cell::Text(Label::symbol(&p.name)),
                number(p.force_share.map(|s| 100.0 * s), 3),
                number(Some(p.inflation), 3),
                number(p.first_half, 4),
                number(p.second_half, 4),
                number(p.halves_z, 2),
            ]
        })
        .collect();
    let columns = ["term", "symbol", "share of force, %", "inflation", "first half", "second half", "apart, std"];
    let groups: Vec<String> = known
        .groups
        .iter()
        .map(|g| format!(" Not separated by this data: {}; {}.", g.terms.join(", "), g.run))
        .collect();
    Some(Table {
        title: "Evidence for the estimates".into(),
        columns: columns.into_iter().map(|c| Column::new(c, "")).collect(),
        rows,
        note: format!(
            "Inflation: standard error relative to that with all other parameters known. Halves: estimates from the \
             first and the second half of each run.{}",
            groups.concat()
        ),
    })
}

/// Correlations of the estimates.
fn correlations(results: &Results<'_>) -> Option<Figure> {
    let covariance = &results.fit.covariance;
    let variance = |k: usize| covariance.get(k).and_then(|row| row.get(k)).copied().unwrap_or(0.0);
    let free = results.fit.parameters.iter().enumerate().filter(|(k, p)| !p.fixed && variance(*k) > 0.0);
    let kept: Vec<usize> = free.map(|(k, _)| k).collect();
    if kept.len() < 2 || kept.len() > MOST {
        return None;
    }
    let names: Vec<Label> = kept.iter().map(|k| Label::symbol(&results.fit.parameters[*k].name)).collect();
    let rho = |j: usize, k: usize| covariance[j][k] / (variance(j) * variance(k)).sqrt();
    let values = kept.iter().map(|j| kept.iter().map(|k| rho(*j, *k)).collect()).collect();
    let chart = Chart::HeatMap(HeatMap {
        x: Axis::new("", ""),
        y: Axis::new("", ""),
        columns: names.clone(),
        rows: names,
        values,
        value: Axis::new("correlation of the estimates", ""),
        decimals: 2,
        colours: Colours::Diverging { limit: 1.0 },
    });
    Some(Figure {
        title: "What the data can separate".into(),
        caption: "Near ±1 only a combination of the two is known: an error of one compensates an error of the other."
            .into(),
        chart,
    })
}

/// Each parameter from runs, stages and published values, relative to the estimate.
fn forest(results: &Results<'_>) -> Option<Figure> {
    let mut shortened = false;
    let rows: Vec<ForestRow> = results
        .fit
        .parameters
        .iter()
        .zip(&results.fit.model.parameters)
        .filter_map(|(p, own)| row(results, p, &own.term, &mut shortened))
        .collect();
    if rows.is_empty() {
        return None;
    }
    let most = match shortened {
        false => String::new(),
        true => format!(" Of more than {SOURCES}, the {SOURCES} with the smallest standard errors are shown."),
    };
    let published = if results.published.is_some() { " Published values are shown as well." } else { "" };
    Some(Figure {
        title: "The same parameter from other sources".into(),
        caption: format!(
            "Each with its 95 % interval, relative to the estimate of the model. A run or a stage that hardly \
             determines a parameter is left out.{most}{published}"
        ),
        chart: Chart::Forest(Forest { axis: Axis::new("value over the estimate", ""), rows, reference: Some(1.0) }),
    })
}

/// The row of a parameter of `term`.
fn row(
    results: &Results<'_>,
    p: &crate::campaign::FitParameter,
    term: &str,
    shortened: &mut bool,
) -> Option<ForestRow> {
    let unit = crate::report::unit(&p.unit);
    let interval = |source: &str, value: f64, std: f64| {
        let reach = COVER * std;
        let ends = [(value - reach) / p.value, (value + reach) / p.value];
        Interval {
            source: source.into(),
            value: value / p.value,
            low: ends[0].min(ends[1]),
            high: ends[0].max(ends[1]),
            text: format!("{} {unit}", estimate(value, (std > 0.0).then_some(std), crate::report::Style::Text)),
        }
    };
    let shows = |std: f64| std.is_finite() && std < SHOWN * p.value.abs();
    // values that differ from run to run are no estimates of one quantity
    let common = p.std.filter(|std| !p.fixed && p.per_run.is_empty() && shows(*std))?;
    let stages = results.fit.stages.iter().filter(|s| s.runs.len() != 1).flat_map(|stage| {
        let named = |e: &&crate::procedure::Estimate| e.effect == p.effect && e.name == p.name;
        stage.estimates.iter().filter(named).map(|e| (stage.name.as_str(), e.value, e.std))
    });
    let runs = results.each_run.models.iter().flat_map(|own| {
        let found = own.estimates.iter().filter(|e| e.term == term && e.name == p.name);
        found.map(|e| (own.run.as_str(), e.value, e.std))
    });
    let sources: Vec<(&str, f64, f64)> =
        stages.chain(runs).filter(|(_, value, std)| shows(*std) && *std < SHOWN * value.abs()).collect();
    let mut deviations: Vec<f64> = sources.iter().map(|(.., std)| *std).collect();
    deviations.sort_by(f64::total_cmp);
    let widest = deviations.get(SOURCES - 1).copied().unwrap_or(f64::INFINITY);
    *shortened |= sources.len() > SOURCES;
    let best = sources.iter().filter(|(.., std)| *std <= widest).take(SOURCES);
    let others: Vec<Interval> = best.map(|(source, value, std)| interval(source, *value, *std)).collect();
    let literature = results.published.iter().flat_map(|published| published.values());
    let published = literature
        .filter(|(of, symbol, value, _)| *of == term && *symbol == p.name && value.is_finite())
        .map(|(_, _, value, std)| interval("published", value, std.unwrap_or(0.0)));
    let others: Vec<Interval> = others.into_iter().chain(published).collect();
    (!others.is_empty()).then(|| ForestRow {
        label: Label::symbol(&p.name),
        estimates: std::iter::once(interval("the model", p.value, common)).chain(others).collect(),
    })
}
