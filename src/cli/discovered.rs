//! The terminal output of `discover`: the verdict, what is missing, the gap after each step, where
//! it occurs, what next.

use super::answer;
use super::output::Output;
use super::table::{measured, number, size, table, wrapped};
use crate::discover::{AS_A_WHOLE, Discovery, FoundParameter, SmallestVisible, Verdict};
use crate::effects::id;
use crate::frame::Measured;
use crate::wording::probability;

/// Maximum number of printed places, and half that of printed sizes; the JSON contains all.
const SHOWN: usize = 5;

/// Prints a discovery.
pub(super) fn print(found: &Discovery, output: &Output) {
    answer::verdict(&found.sentence, output);
    if !output.is_verbose() {
        output.print(&if found.effects.is_empty() { gap(found) } else { effects(found, false) });
        if let Some(next) = &found.next_experiment {
            output.print(&wrapped(&format!("next experiment: {next}")));
        }
        return;
    }
    if !found.log_findings.is_empty() {
        let rows: Vec<Vec<String>> = found
            .log_findings
            .iter()
            .map(|f| vec![f.channel.clone(), f.kind.clone(), number(f.factor), f.message.clone()])
            .collect();
        output.print(&format!("\nthe log\n{}", table(&["channel", "fault", "factor", "what it is"], &rows)));
    }
    if !found.effects.is_empty() {
        let heading = if found.names_are_all() { "missing" } else { "missing, among other things" };
        output.print(&format!("\n{heading}\n{}", effects(found, true)));
    }
    for like in found.resemblances() {
        output.print(&wrapped(&format!("something {}", like.told())));
    }
    if !found.removed.is_empty() {
        output.print(&format!("added and removed again: {}", found.removed.join(", ")));
    }
    output
        .print(&format!("\nthe gap: simulated minus measured on held-out runs, in units of the noise\n{}", gap(found)));
    place(found, output);
    smallest(found, output);
    if let Some(next) = &found.next_experiment {
        output.print(&format!("\n{}", wrapped(&format!("next experiment: {next}"))));
    }
}

/// The value and its standard deviation, with the least and the greatest if each run has its own.
fn value(p: &FoundParameter) -> String {
    let told = |value: f64| measured(value, Some(p.std));
    p.by_run(told).unwrap_or_else(|| told(p.value))
}

/// The missing effects; with `all` also common names, probabilities and alternatives.
fn effects(found: &Discovery, all: bool) -> String {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for effect in &found.effects {
        for (k, p) in effect.parameters.iter().enumerate() {
            let first = |text: String| if k == 0 { text } else { String::new() };
            rows.push(vec![
                first(effect.id.clone()),
                first(effect.common_name.clone()),
                p.name.clone(),
                value(p),
                p.unit.clone(),
                first(probability(effect.p_value)),
                first(effect.also_possible.join(", ")),
            ]);
        }
        if effect.parameters.is_empty() {
            let (id, name, p) = (effect.id.clone(), effect.common_name.clone(), probability(effect.p_value));
            let others = effect.also_possible.join(", ");
            rows.push(vec![id, name, String::new(), AS_A_WHOLE.into(), String::new(), p, others]);
        }
    }
    let mut headers = vec!["effect", "common name", "symbol", "value ± std", "unit", "p", "also possible"];
    // beside an unexplained remainder a probability would read as a proof
    if !found.names_are_all() {
        headers.remove(5);
        rows.iter_mut().for_each(|row| drop(row.remove(5)));
    }
    if !all {
        headers.truncate(5);
        headers.remove(1);
        for row in &mut rows {
            row.truncate(5);
            row.remove(1);
        }
    }
    table(&headers, &rows)
}

/// One row per step, one column per measured quantity: the error and, in brackets, its ratio to the
/// noise.
fn gap(found: &Discovery) -> String {
    let Some(first) = found.gap.first() else { return String::new() };
    let columns: Vec<&Measured> = first.held_out_rms.keys().collect();
    let mut rows: Vec<Vec<String>> = Vec::new();
    for (k, step) in found.gap.iter().enumerate() {
        let later = if step.dropped { " (removed later)" } else { "" };
        let name = step.added.as_ref().map_or_else(|| "baseline".to_string(), |added| format!("+ {added}{later}"));
        let cell = |m: &&Measured| match (step.held_out_rms.get(*m), step.noise_floor.get(*m)) {
            // the simulation has diverged
            (Some(rms), _) if !rms.is_finite() => "diverges".into(),
            (Some(rms), Some(noise)) if *noise > 0.0 => format!("{} ({:.1})", size(*rms), rms / noise),
            (Some(rms), _) => size(*rms),
            _ => String::new(),
        };
        rows.push(std::iter::once(name).chain(columns.iter().map(cell)).collect());
        if k + 1 == found.gap.len() {
            let noise = columns.iter().map(|m| step.noise_floor.get(*m).copied().map(size).unwrap_or_default());
            rows.push(std::iter::once("noise".to_string()).chain(noise).collect());
        }
    }
    let names: Vec<String> = columns.iter().map(ToString::to_string).collect();
    let headers: Vec<&str> = std::iter::once("with").chain(names.iter().map(String::as_str)).collect();
    table(&headers, &rows)
}

/// Prints where the baseline disagrees: the missing force in one sentence per degree of freedom,
/// then the worst places.
fn place(found: &Discovery, output: &Output) {
    if found.verdict == Verdict::NothingMissing || (found.places.is_empty() && found.residuals.is_empty()) {
        return;
    }
    output.print("\nwhere the baseline disagrees");
    for residual in &found.residuals {
        output.print(&wrapped(&format!("  {}", residual.sentence)));
    }
    let rows: Vec<Vec<String>> = found
        .places
        .iter()
        .take(SHOWN)
        .map(|p| {
            let span = format!("{} to {}", number(p.from), number(p.to));
            let condition = p.condition.split_once(": ").map_or(p.condition.as_str(), |(_, rest)| rest);
            vec![p.run.clone(), p.dof.to_string(), span, format!("{:.1}", p.times_noise), condition.to_string()]
        })
        .collect();
    if !rows.is_empty() {
        output.print(&table(&["run", "in", "seconds", "x noise", "condition"], &rows));
    }
    if found.places.len() > SHOWN {
        output.print(&format!("and {} more: --json has them all", found.places.len() - SHOWN));
    }
}

/// Prints the effects that the data could have shown, if nothing unexplained remains: those that
/// users ask for most.
fn smallest(found: &Discovery, output: &Output) {
    if matches!(found.verdict, Verdict::Unexplained | Verdict::PartlyExplained) {
        return;
    }
    let asked = id::ASKED_FOR
        .iter()
        .flat_map(|id| found.smallest_visible.iter().filter(move |s| s.id.split('@').next() == Some(id)));
    let row = |s: &SmallestVisible| {
        let (name, size, unit) = s.told();
        vec![name, number(size), unit.to_string()]
    };
    let rows: Vec<Vec<String>> = asked.take(2 * SHOWN).map(row).collect();
    if !rows.is_empty() {
        output.print(&format!(
            "\nsmallest sizes that this data would have shown\n{}",
            table(&["effect", "size", "unit"], &rows)
        ));
    }
    let rest = found.smallest_visible.len() - rows.len();
    if rest > 0 && !rows.is_empty() {
        output.print(&format!("and {rest} more: --json has them all"));
    }
}
