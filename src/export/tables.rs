//! The parameters as a table: LaTeX for papers, CSV for other uses.
//!
//! ```text
//! X_q̇ = (M_RB)₁₅ − m_uq,   X_u̇ = m − m_u,   K_ṗ = I_x − I_p        SNAME's added part: dry minus virtual
//! X_vr = k_vr,   Y_ur = −k_ur                                      complete row of −C(ν)ν, with its dry part
//! ```
//!
//! M_RB: from the dry mass, the centre of gravity and, if given, the dry moments of inertia about
//! the body origin.

use std::fmt::Write;

use csv::Terminator;

use super::header::{Bounds, Draft, one_line};
use super::number::number;
use super::{Export, ExportError, ExportOptions, Source, Target, losses};
use crate::campaign::{FitParameter, described};
use crate::effects::id;
use crate::frame::Dof;
use crate::model::Parameter;
use crate::spreadsheet::{self, harmless};
use crate::vehicle::Vehicle;

pub(super) fn export(source: &Source<'_>, target: Target, options: &ExportOptions) -> Result<Export, ExportError> {
    let draft = Draft::new(target);
    let mut head = draft.head(
        source,
        &[
            "SI units, axes forward-starboard-down; value: on the side of drag and inertia, SNAME: the opposite sign",
            "SNAME's added mass is dry minus virtual mass, couplings with m r_g; it is left out if the dry one is not \
             known",
            "SNAME's X_vr, Y_ur ... are those of the whole product, including the dry mass",
        ],
        &Bounds {
            limits: "the values hold for motions similar to those of the fit",
            stability: "a table simulates nothing; whatever uses it has its own longest step",
        },
    );
    let told = losses::named(&source.file.efficiency);
    if !told.is_empty() {
        head.push(format!("The values refer to effective forces, after losses of thrust: {}", one_line(&told)));
    }
    let vehicle = Vehicle { mass: options.mass.or(source.file.vehicle.mass), ..source.file.vehicle.clone() };
    let row = |p: &Parameter| sname(p, described(p, None, &vehicle, &[]), options.inertia);
    let rows: Vec<FitParameter> = source.model.parameters.iter().map(row).collect();
    let text = match target {
        Target::Latex => latex(&head, &rows),
        _ => csv(&head, &rows),
    };
    Ok(draft.finish(text.into_bytes()))
}

/// SNAME's name and value; for a moment of inertia, which no vehicle file contains, from the given
/// dry one.
fn sname(p: &Parameter, told: FitParameter, inertia: Option<[f64; 3]>) -> FitParameter {
    let Some(dof) = p.place.dof else { return coriolis(p, told) };
    if p.effect != id::INERTIA || !dof.is_rotation() {
        return told;
    }
    let dry = inertia.map(|i| i[dof.index() - 3]);
    FitParameter { sname: dry.and(p.spec.sname.clone()), sname_value: dry.map(|dry| dry - p.value), ..told }
}

/// A row of −C(ν)ν whose coefficient already has SNAME's sign: `k_vr` of surge is X_vr.
fn coriolis(p: &Parameter, told: FitParameter) -> FitParameter {
    let row = Dof::ALL.into_iter().find(|dof| p.effect == id::coriolis(*dof));
    match (row, &told.sname, p.spec.name.strip_prefix("k_")) {
        (Some(row), None, Some(product)) => {
            FitParameter { sname: Some(format!("{}_{product}", row.sname())), sname_value: Some(p.value), ..told }
        }
        _ => told,
    }
}

fn place(p: &FitParameter) -> String {
    [p.dof, p.other].iter().flatten().map(|d| d.name()).collect::<Vec<_>>().join(":")
}

fn csv(head: &[String], rows: &[FitParameter]) -> String {
    let text: String = head.iter().map(|line| format!("# {}\n", plain_cells(line))).collect();
    let names = ["effect", "dof", "symbol", "value", "std", "unit", "sname", "sname_value", "fixed"];
    let word = |word: &str| harmless(&one_line(word)).into_owned();
    let row = |p: &FitParameter| {
        let [std, sname_value] = [p.std, p.sname_value].map(|x| x.map(number).unwrap_or_default());
        vec![
            word(&p.effect),
            word(&place(p)),
            word(&p.name),
            number(p.value),
            std,
            word(&p.unit),
            word(p.sname.as_deref().unwrap_or_default()),
            sname_value,
            p.fixed.to_string(),
        ]
    };
    let table = std::iter::once(names.map(str::to_string).to_vec()).chain(rows.iter().map(row));
    text + &spreadsheet::csv(table, Terminator::Any(b'\n'))
}

/// A line of a comment in which no cell is a formula, because spreadsheets do not recognise
/// comments.
fn plain_cells(line: &str) -> String {
    let mut out = String::new();
    for part in line.split_inclusive([',', ';']) {
        // a cell that begins with a blank was written by this program
        out += &if part.starts_with(' ') { part.into() } else { harmless(part) };
    }
    out
}

fn latex(head: &[String], rows: &[FitParameter]) -> String {
    let mut text: String = head.iter().map(|line| format!("% {line}\n")).collect();
    text += "\\begin{tabular}{llrll}\n\\toprule\nTerm & Symbol & Value & Unit & SNAME \\\\\n\\midrule\n";
    for p in rows {
        let std = p.std.filter(|s| *s > 0.0 && s.is_finite());
        // digits down to the second significant digit of the standard deviation
        let value = match std {
            Some(std) => {
                let decimals = (1 - std.log10().floor() as i32).clamp(0, 12) as usize;
                format!("${:.decimals$} \\pm {std:.decimals$}$", p.value)
            }
            None => format!("${}$", number(p.value)),
        };
        let sname = p.sname.as_ref().zip(p.sname_value).map(|(s, v)| format!("${} = {}$", symbol(s), rounded(v)));
        let term = match place(p) {
            place if place.is_empty() => p.effect.clone(),
            place => format!("{}, {place}", p.effect),
        };
        let _ = writeln!(
            text,
            "{} & ${}$ & {value} & {} & {} \\\\",
            words(&term),
            symbol(&p.name),
            unit(&p.unit),
            sname.unwrap_or_default()
        );
    }
    text + "\\bottomrule\n\\end{tabular}\n"
}

fn rounded(x: f64) -> String {
    let decimals = (3 - x.abs().max(1e-12).log10().floor() as i32).clamp(0, 12) as usize;
    format!("{x:.decimals$}")
}

/// Text for LaTeX, with its special characters escaped.
fn words(text: &str) -> String {
    let mut out = String::new();
    for c in one_line(text).chars() {
        match c {
            '\\' => out += "\\textbackslash{}",
            '~' => out += "\\textasciitilde{}",
            '^' => out += "\\textasciicircum{}",
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => out.extend(['\\', c]),
            c => out.push(c),
        }
    }
    out
}

/// `k_u|u|` as `k_{u|u|}`, `X_udot` as `X_{\dot{u}}`.
///
/// A difference of moments, `z_gW-z_bB`, becomes `z_g W - z_b B`; a sign at the end of a name,
/// `k_w|w|-`, is part of its index.
fn symbol(name: &str) -> String {
    if let Some((left, right)) = name.split_once('-').filter(|(_, right)| !right.is_empty()) {
        let product = |text: &str| match text.char_indices().last() {
            Some((at, force)) if force.is_uppercase() && at > 0 => format!("{} {force}", symbol(&text[..at])),
            _ => symbol(text),
        };
        return format!("{} - {}", product(left), product(right));
    }
    let Some((letter, index)) = name.split_once('_') else { return name.replace('_', "\\_") };
    let index = match index.strip_suffix("dot") {
        Some(velocity) => format!("\\dot{{{velocity}}}"),
        None => index.replace('_', "\\_"),
    };
    format!("{letter}_{{{index}}}")
}

/// `kg*m2/s` as `$\mathrm{kg\,m^{2}/s}$`.
fn unit(unit: &str) -> String {
    let mut out = String::new();
    for c in unit.chars() {
        match c {
            '*' => out += "\\,",
            c if c.is_ascii_digit() && out.ends_with(char::is_alphabetic) => out += &format!("^{{{c}}}"),
            c => out.push(c),
        }
    }
    format!("$\\mathrm{{{out}}}$")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_and_units_are_those_of_latex() {
        assert_eq!(symbol("X_u|u|"), "X_{u|u|}");
        assert_eq!(symbol("N_rdot"), "N_{\\dot{r}}");
        assert_eq!(symbol("z_gW-z_bB"), "z_{g} W - z_{b} B");
        assert_eq!((symbol("W-B"), symbol("m_u")), ("W - B".into(), "m_{u}".into()));
        assert_eq!((symbol("k_w|w|-"), symbol("Z_w|w|-")), ("k_{w|w|-}".into(), "Z_{w|w|-}".into()));
        assert_eq!(unit("kg*m2/s"), "$\\mathrm{kg\\,m^{2}/s}$");
        assert_eq!(unit("1"), "$\\mathrm{1}$");
        assert_eq!(rounded(-309.0712), "-309.1");
        assert_eq!(words("a_b & 5%\n\\x"), "a\\_b \\& 5\\% \\textbackslash{}x");
    }

    #[test]
    fn no_cell_is_a_formula() {
        assert_eq!(plain_cells("boat,=cmd(),b;@x, y"), "boat,'=cmd(),b;'@x, y");
    }
}
