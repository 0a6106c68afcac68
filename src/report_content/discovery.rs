//! The part of the report about missing effects: verdict in words, the effects, where the missing
//! force occurs and with what it correlates, the gap after each step, and the smallest effect that
//! the data could have shown.

use crate::discover::{AS_A_WHOLE, Discovery, FoundEffect, FoundParameter, Residual};
use crate::effects::{common_name, named};
use crate::frame::Measured;
use crate::report::{
    Axis, Bar, Bars, Block, Cell, Chart, Column, Curves, Figure, Label, Panel, Section, Series, Style, Table, estimate,
    number,
};
use crate::wording::{capitalised, probability};

/// Maximum number of figures of the missing force per degree of freedom.
const FIGURES: usize = 2;
/// Maximum number of places in the table.
const PLACES: usize = 12;

/// The section of a report.
pub(super) fn section(found: &Discovery) -> Section {
    let mut paragraphs: Vec<String> = found.log_findings.iter().map(|f| format!("The log: {}.", f.message)).collect();
    paragraphs.extend(found.effects.iter().map(|e| format!("{}: {}.", capitalised(&named(&e.id)), e.evidence)));
    paragraphs.extend(found.resemblances().map(|like| format!("Something {}.", like.told())));
    paragraphs.extend(found.residuals.iter().map(|r| format!("{}.", capitalised(&r.sentence.replace("N*m", "N·m")))));
    paragraphs.extend(found.next_experiment.iter().map(|next| format!("Next: {next}")));
    let mut blocks = Vec::new();
    if !found.effects.is_empty() {
        blocks.push(Block::Table(effects(found)));
    }
    // the widest gap is on the first screen
    let shown = widest(found);
    let measured = found.gap.iter().take(1).flat_map(|baseline| baseline.held_out_rms.keys());
    for measured in measured.filter(|measured| shown.as_ref() != Some(measured)) {
        blocks.extend(waterfall(found, measured).map(Block::Figure));
    }
    blocks.extend(found.residuals.iter().flat_map(forces).map(Block::Figure));
    if !found.places.is_empty() {
        blocks.push(Block::Table(places(found)));
    }
    if !found.smallest_visible.is_empty() {
        blocks.push(Block::Table(smallest(found)));
    }
    Section { heading: "What is missing".into(), paragraphs, blocks, folded: false }
}

fn columns(names: &[&str]) -> Vec<Column> {
    names.iter().map(|name| Column::new(*name, "")).collect()
}

fn effects(found: &Discovery) -> Table {
    // beside an unexplained remainder a probability would read as a proof
    let partly = !found.names_are_all();
    let row = |e: &FoundEffect, [symbol, value, unit]: [Cell; 3]| {
        let p = (!partly).then_some(Cell::from(probability(e.p_value).as_str()));
        let others: Vec<String> = e.also_possible.iter().map(|id| named(id)).collect();
        let others = Cell::from(others.join(", ").as_str());
        let names = [e.id.as_str(), e.common_name.as_str()].map(Cell::from);
        names.into_iter().chain([symbol, value, unit]).chain(p).chain([others]).collect()
    };
    let rows = |e: &FoundEffect| -> Vec<Vec<Cell>> {
        let of = |p: &FoundParameter| {
            let of_runs = p.by_run(|value| estimate(value, Some(p.std), Style::Text));
            let value = match of_runs {
                Some(told) => Cell::from(told.as_str()),
                None => Cell::Estimate { value: p.value, std: Some(p.std) },
            };
            row(e, [Cell::Text(Label::symbol(&p.name)), value, Cell::from(crate::report::unit(&p.unit).as_str())])
        };
        match e.parameters.as_slice() {
            [] => vec![row(e, [Cell::Empty, Cell::from(AS_A_WHOLE), Cell::Empty])],
            all => all.iter().map(of).collect(),
        }
    };
    let names = ["effect", "common name", "symbol", "value ± std", "unit", "p", "also possible"];
    let names: Vec<&str> = names.into_iter().filter(|name| !partly || *name != "p").collect();
    let chance = "p: probability that noise alone makes any candidate look this likely.";
    Table {
        title: if partly { "What was missing, among other things" } else { "What was missing" }.into(),
        columns: columns(&names),
        rows: found.effects.iter().flat_map(rows).collect(),
        note: if partly { String::new() } else { chance.into() },
    }
}

/// The missing force against the quantities with which it correlates, one point per window.
fn forces(residual: &Residual) -> Vec<Figure> {
    let figure = |d: &crate::discover::Dependence| {
        let (x, y) = d.points.iter().copied().unzip();
        let panel = Panel {
            y: Axis::new("missing force", residual.unit),
            series: vec![Series::points("", x, y)],
            floor: Some(residual.noise),
        };
        Figure {
            title: format!("The missing force in {} against {}", residual.dof, d.quantity),
            caption: format!(
                "One point a second: the force missing from the momentum balance of the refitted baseline. Correlation \
                 {}. Shaded: the force that the noise of the velocity sensor alone would show.",
                number(d.correlation, 2, Style::Text)
            ),
            chart: Chart::Curves(Curves {
                x: Axis::new(Label::symbol(&d.quantity), ""),
                panels: vec![panel],
                spans: Vec::new(),
            }),
        }
    };
    residual.goes_with.iter().take(FIGURES).map(figure).collect()
}

fn places(found: &Discovery) -> Table {
    let number = |value| Cell::Number { value, digits: 3 };
    let row = |p: &crate::discover::Where| {
        vec![
            Cell::from(p.run.as_str()),
            Cell::from(p.dof.to_string().as_str()),
            number(p.from),
            number(p.to),
            number(p.times_noise),
            // the degree of freedom has a column of its own
            Cell::from(p.condition.split_once(": ").map_or(p.condition.as_str(), |(_, rest)| rest)),
        ]
    };
    let more = found.places.len().saturating_sub(PLACES);
    Table {
        title: "Where the baseline disagrees".into(),
        columns: columns(&["run", "in", "from, s", "to, s", "times the noise", "condition"]),
        rows: found.places.iter().take(PLACES).map(row).collect(),
        note: if more > 0 { format!("And {more} more, less clear.") } else { String::new() },
    }
}

fn smallest(found: &Discovery) -> Table {
    let row = |s: &crate::discover::SmallestVisible| {
        let (name, value, unit) = s.told();
        vec![
            Cell::from(name.as_str()),
            Cell::Number { value, digits: 2 },
            Cell::from(crate::report::unit(unit).as_str()),
        ]
    };
    Table {
        title: "What this data could have shown".into(),
        columns: columns(&["effect", "smallest size", "unit"]),
        rows: found.smallest_visible.iter().filter(|s| !s.id.contains(':')).map(row).collect(),
        note: "An effect that was not added and whose first parameter is at least this large would almost certainly have been found. \
               Couplings of two degrees of freedom are in the JSON."
            .into(),
    }
}

/// The waterfall of the measured quantity with the widest gap relative to the noise.
pub fn gap_figure(found: &Discovery) -> Option<Figure> {
    waterfall(found, &widest(found)?)
}

/// The measured quantity with the widest gap relative to the noise.
pub(super) fn widest(found: &Discovery) -> Option<Measured> {
    let first = found.gap.first()?;
    let ratio = |(dof, rms): (&Measured, &f64)| Some((dof.clone(), rms / first.noise_floor.get(dof)?));
    first.held_out_rms.iter().filter_map(ratio).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(dof, _)| dof)
}

/// The held-out gap of a measured quantity, step by step, beside the noise.
fn waterfall(found: &Discovery, dof: &Measured) -> Option<Figure> {
    let mut bars: Vec<Bar> = Vec::new();
    let mut before: Option<f64> = None;
    for step in found.gap.iter().filter(|step| !step.dropped) {
        let rms = *step.held_out_rms.get(dof)?;
        let label = step.added.as_ref().map_or_else(|| "baseline".into(), |id| common_name(id));
        let (value, total) = before.map_or((rms, true), |known| (rms - known, false));
        bars.push(Bar { label: label.into(), value, std: None, total });
        before = Some(rms);
    }
    if found.gap.len() > 1 {
        bars.push(Bar { label: "with all".into(), value: before?, std: None, total: true });
    }
    let noise = found.gap.first().and_then(|s| s.noise_floor.get(dof)).copied()?;
    // a channel that takes no part has an unbounded noise
    let largest = found.gap.iter().filter_map(|s| s.held_out_rms.get(dof)).fold(0.0_f64, |m, x| m.max(*x));
    if noise > 100.0 * largest {
        return None;
    }
    let axis = Axis::new("held-out rms", dof.unit());
    let chart = Chart::Bars(Bars { axis, bars, waterfall: true, reference: Some(("sensor noise".into(), noise)) });
    Some(Figure {
        title: format!("The gap in {dof}"),
        caption: format!(
            "Root mean square of simulated minus measured on held-out runs{}.{}",
            if found.gap.len() > 1 { ", as effects are added" } else { "" },
            match found.removed.as_slice() {
                [] => String::new(),
                ids => {
                    let names: Vec<String> = ids.iter().map(|id| named(id)).collect();
                    format!(" Removed again, because later effects explain the same: {}.", names.join(", "))
                }
            }
        ),
        chart,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::{FoundEffect, FoundParameter, Verdict};

    #[test]
    fn an_effect_without_parameters_has_a_row_of_its_own() {
        let effect = |id: &str, parameters| FoundEffect {
            id: id.into(),
            common_name: id.into(),
            dofs: Vec::new(),
            parameters,
            p_value: 1e-9,
            also_possible: Vec::new(),
            evidence: String::new(),
        };
        let drag =
            FoundParameter { name: "k_u".into(), value: 1.0, std: 0.1, unit: "kg/s".into(), per_run: Vec::new() };
        let found = Discovery {
            format: 1,
            verdict: Verdict::Explained,
            sentence: String::new(),
            changed_parameter: None,
            behaves_like: Vec::new(),
            effects: vec![effect("coriolis_yaw", Vec::new()), effect("linear_drag@surge", vec![drag])],
            places: Vec::new(),
            residuals: Vec::new(),
            gap: Vec::new(),
            adopt: Vec::new(),
            removed: Vec::new(),
            log_findings: Vec::new(),
            smallest_visible: Vec::new(),
            next_experiment: None,
            seed: 1,
            warnings: Vec::new(),
            steps: Vec::new(),
            moved_otherwise: Vec::new(),
            erring: Vec::new(),
            took_part: Vec::new(),
            input: None,
        };
        let table = effects(&found);
        assert_eq!(table.rows.len(), 2);
        // beside its id and its common name
        assert_eq!(table.rows[0][3], Cell::from(AS_A_WHOLE));
    }
}
