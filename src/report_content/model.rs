//! The part of the report about the model: its equations with numbers, and its parameters.

use super::{COVER, Results};
use crate::chain::{Nature, nature};
use crate::effects::{Place, common_name, id};
use crate::frame::Dof;
use crate::model::{Model, Term};
use crate::report::{Block, Cell, Column, Equation, Label, Section, Style, Table, estimate, number};
use crate::thrust::fit::Estimate;

/// The section of a report.
pub(super) fn section(results: &Results<'_>) -> Section {
    let first = [Block::Equations(equations(results))];
    Section {
        heading: "The model".into(),
        paragraphs: vec![
            "Balance of momentum in body axes, forward-starboard-down; drag and bias have a minus sign.".into(),
        ],
        blocks: first.into_iter().chain(thrust_curves(results)).chain(super::belief::blocks(results)).collect(),
        folded: false,
    }
}

/// Thruster curves that were fitted to bollard tables, equation (1).
fn thrust_curves(results: &Results<'_>) -> Option<Block> {
    let curves = &results.fit.thrusters;
    let rows = curves.iter().flat_map(|curve| {
        [("forward", curve.forward), ("reverse", curve.reverse)].map(|(way, side)| {
            let estimate = |e: Estimate| Cell::Estimate { value: e.value, std: Some(e.std).filter(|std| *std > 0.0) };
            vec![
                Cell::from(curve.thrusters.join(", ").as_str()),
                Cell::from(curve.file.as_str()),
                Cell::from(way),
                estimate(side.a),
                estimate(side.b),
                estimate(curve.deadband),
                curve.supply_exponent.map_or(Cell::Empty, estimate),
                Cell::Number { value: side.rows as f64, digits: 5 },
                Cell::Number { value: side.residual_std, digits: 3 },
            ]
        })
    });
    let columns = ["thruster", "table", "direction", "a", "b", "dead band", "supply exponent", "rows", "residual, N"];
    (!curves.is_empty()).then(|| {
        Block::Table(Table {
            title: "Thrusters at bollard pull".into(),
            columns: columns.into_iter().map(|c| Column::new(c, "")).collect(),
            rows: rows.collect(),
            note: "|F| = (a x² + b x)(V_s/V_ref)ⁿ with x the command beyond the dead band; equation (1).".into(),
        })
    })
}

/// The parameters with their standard deviations, one per row.
pub(super) fn parameters(results: &Results<'_>) -> Table {
    let rows = results
        .fit
        .parameters
        .iter()
        .map(|p| {
            let place = [p.dof, p.other].iter().flatten().map(|d| d.name()).collect::<Vec<_>>().join(":");
            let of_runs = p.by_run(|value| estimate(value, p.std, Style::Text));
            let mut row = vec![
                Cell::from(p.effect.as_str()),
                Cell::from(common_name(&p.effect).as_str()),
                Cell::from(place.as_str()),
                Cell::Text(Label::symbol(&p.name)),
                match &of_runs {
                    Some(of_runs) => Cell::from(of_runs.as_str()),
                    None => Cell::Number { value: p.value, digits: digits_beside(p.value, p.std) },
                },
                match (p.fixed, &of_runs) {
                    (true, _) => Cell::from("held"),
                    (false, Some(_)) => Cell::Empty,
                    (false, None) => Cell::from(interval(p.value, p.std).as_str()),
                },
                Cell::from(crate::report::unit(&p.unit).as_str()),
                p.sname.as_ref().map_or(Cell::Empty, |s| Cell::Text(Label::symbol(s))),
                p.sname_value.map_or(Cell::Empty, |value| Cell::Number { value, digits: 5 }),
            ];
            if !results.fit.converged {
                row.push(if p.fixed { Cell::Empty } else { Cell::from(super::NOT_CONVERGED) });
            }
            row
        })
        .collect();
    let columns = [
        "effect",
        "common name",
        "degree of freedom",
        "symbol",
        "value",
        "95 % interval",
        "unit",
        "SNAME",
        "value",
        "interval",
    ];
    let shown = if results.fit.converged { &columns[..9] } else { &columns };
    Table {
        title: "Parameters".into(),
        columns: shown.iter().map(|c| Column::new(*c, "")).collect(),
        rows,
        note: format!(
            "Intervals: {COVER} standard deviations on either side, by {}. SNAME's values have the opposite sign; \
             those of an inertia and of a coupling are the added part.",
            results.fit.std_method
        ),
    }
}

/// Number of digits up to the second digit of the standard deviation; four for a held value.
fn digits_beside(value: f64, std: Option<f64>) -> u32 {
    let Some(std) = std.filter(|std| *std > 0.0 && std.is_finite() && value.abs() > 0.0) else { return 4 };
    ((value.abs() / std).log10().floor() as i32 + 2).clamp(2, 8) as u32
}

/// `16.99 to 17.04`, without a line break; a dash if the standard deviation is not known.
fn interval(value: f64, std: Option<f64>) -> String {
    let Some(std) = std.filter(|std| *std > 0.0 && std.is_finite()) else { return "–".into() };
    let end = |x: f64| number(x, digits_beside(x, Some(std)), Style::Text);
    format!("{}\u{a0}to\u{a0}{}", end(value - COVER * std), end(value + COVER * std))
}

/// The balance of each degree of freedom, then the terms of the chain from command to force, of the
/// water and of the sensors.
fn equations(results: &Results<'_>) -> Vec<Equation> {
    let model = &results.fit.model;
    let stands = |t: &Term| model.dofs.iter().any(|dof| in_balance(t, *dof));
    let chain = |t: &Term| Equation { formula: written(t.effect.about().formula, t.place), note: t.name() };
    let others = model.terms.iter().filter(|t| !stands(t)).map(chain);
    model.dofs.iter().map(|dof| balance(model, *dof)).chain(others).collect()
}

/// Whether a term is a force or a momentum of this degree of freedom.
fn in_balance(term: &Term, dof: Dof) -> bool {
    let about = term.effect.about();
    let force = !about.formula.contains('→') && !about.formula.contains("_log") && !about.formula.contains(" += k τ");
    let here = term.place.dof == Some(dof) || (term.place.dof.is_none() && about.id.ends_with(&format!("_{dof}")));
    force && here
}

/// A formula with the symbols of its place.
fn written(formula: &str, place: Place) -> String {
    let mut out = formula.to_string();
    for (index, dof) in [("ᵢ", place.dof), ("ⱼ", place.other)] {
        if let Some(dof) = dof {
            let v = dof.velocity();
            out = out.replace(&format!("ν{index}"), v).replace(&format!("τ{index}"), &format!("τ_{v}"));
        }
    }
    out
}

/// One balance, with numbers for effects that have one parameter.
fn balance(model: &Model, dof: Dof) -> Equation {
    let v = dof.velocity();
    let value = |p: usize| number(model.parameters[p].value.abs(), 4, Style::Text);
    let signed = |p: usize| if model.parameters[p].value < 0.0 { ('−', '+') } else { ('+', '−') };
    let mut left = format!("m_{v} {v}̇");
    let mut right = format!("τ_{v}");
    for term in model.terms.iter().filter(|t| in_balance(t, dof)) {
        let about = term.effect.about();
        let formula = term.effect.formula_in(&model.dofs);
        let formula = written(formula.split(',').next().unwrap_or_default(), term.place);
        match (about.id, term.parameters.as_slice(), term.place.other) {
            (id::INERTIA, [p], _) => left = left.replacen(&format!("m_{v} "), &format!("{} ", value(*p)), 1),
            (id::ADDED_MASS_COUPLING, [p], Some(other)) => {
                left += &format!(" {} {} {}̇", signed(*p).0, value(*p), other.velocity());
            }
            // the coefficient k_uv has the sign of its row
            (_, [p], _) if nature(model, term) == Nature::Coriolis => {
                let row = model.parameters[*p].value * if formula.starts_with('−') { -1.0 } else { 1.0 };
                let letters = model.parameters[*p].spec.name.trim_start_matches("k_").chars();
                let product = letters.map(|c| format!(" {c}")).collect::<String>();
                right += &format!(" {} {}{product}", if row < 0.0 { '−' } else { '+' }, value(*p));
            }
            // one coefficient, written first after its sign
            (_, [p], _) if formula.starts_with("−d ") => {
                let product = formula.trim_start_matches("−d ");
                right += &format!(" {} {} {product}", signed(*p).1, value(*p));
            }
            (_, [p], _) if formula == "−b" => right += &format!(" {} {}", signed(*p).1, value(*p)),
            _ => {
                let (sign, rest) = formula.strip_prefix('−').map_or(('+', formula.as_str()), |rest| ('−', rest));
                let rest = rest.trim_start().trim_start_matches("+ ");
                right += &format!(" {sign} {rest}");
            }
        }
    }
    Equation { formula: format!("{left} = {right}"), note: dof.name().into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;

    #[test]
    fn an_interval_ends_where_its_deviation_does() {
        assert_eq!(interval(17.018, Some(0.012)), "16.994\u{a0}to\u{a0}17.042");
        assert_eq!(interval(309.07, Some(18.8)), "272\u{a0}to\u{a0}346");
        assert_eq!((interval(5.0, None), digits_beside(17.018, Some(0.012))), ("–".into(), 5));
    }

    #[test]
    fn momenta_stand_left_forces_right_and_the_chain_apart() {
        let effects = ["inertia", "quadratic_drag", "added_mass_coupling@surge:pitch", "coriolis_pitch", "bias@surge"];
        let dofs = [Dof::Surge, Dof::Heave, Dof::Pitch];
        let mut model = Model::with_effects(&dofs, Coriolis::Free, &effects).unwrap();
        for (name, value) in [
            ("inertia@surge", 200.0),
            ("quadratic_drag@surge", 50.0),
            ("added_mass_coupling@surge:pitch", -3.0),
            ("bias@surge", -2.0),
            ("coriolis_pitch", -7.0),
        ] {
            assert!(model.set(name, value), "{name}");
        }
        assert_eq!(balance(&model, Dof::Surge).formula, "200.0 u̇ − 3.000 q̇ = τ_u − 50.00 u |u| + 2.000");
        let pitch = balance(&model, Dof::Pitch).formula;
        assert!(pitch.ends_with(" + 7.000 w u"), "{pitch}");
    }
}
