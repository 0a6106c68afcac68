//! `compare MODEL_A MODEL_B`: differences of two models.

use super::answer;
use super::output::Output;
use super::table::{measured, number, table};
use crate::campaign::{ModelDifference, ParameterDifference};
use crate::wording::{count, p_value, probability};

/// Level of significance of a difference.
const LEVEL: f64 = 0.01;

pub(super) fn print(found: &ModelDifference, output: &Output) {
    answer::verdict(&verdict(found), output);
    // one row per parameter; the widest columns are shown on request only
    let row = |p: &ParameterDifference| {
        let place = found.parameters.iter().filter(|q| q.effect == p.effect).count() > 1;
        let name = if place { format!("{} {}", p.effect, p.name) } else { p.effect.clone() };
        vec![
            name,
            measured(p.a, p.std_a),
            measured(p.b, p.std_b),
            p.z.map(|z| format!("{z:+.1}")).unwrap_or_default(),
            p.unit.clone(),
        ]
    };
    let rows: Vec<Vec<String>> = found.parameters.iter().map(row).collect();
    if !rows.is_empty() {
        output.print(&table(&["term", "A ± std", "B ± std", "z", "unit"], &rows));
    }
    if output.is_verbose() {
        let row = |p: &ParameterDifference| {
            let p_of = p.p_value.map(probability).unwrap_or_default();
            vec![p.effect.clone(), p.name.clone(), measured(p.difference, p.std), p_of, p.unit.clone()]
        };
        let rows: Vec<Vec<String>> = found.parameters.iter().map(row).collect();
        output.print(&table(&["term", "symbol", "B − A ± std", "p", "unit"], &rows));
        if let Some(joint) = found.joint {
            output.print(&format!(
                "all together: chi2 = {} on {}, {}",
                number(joint.chi_squared),
                degrees(joint.degrees_of_freedom),
                p_value(joint.p_value)
            ));
        }
    }
}

fn degrees(n: usize) -> String {
    if n == 1 { "1 degree of freedom".into() } else { format!("{n} degrees of freedom") }
}

fn verdict(found: &ModelDifference) -> String {
    let models = format!("A is {}, B is {}.", found.a, found.b);
    let Some(joint) = found.joint else {
        return format!("No common parameter was estimated: the models cannot be compared. {models}");
    };
    let p = p_value(joint.p_value);
    let common = count(found.parameters.len(), "common parameter");
    if joint.p_value >= LEVEL {
        return format!("The models agree: {common} differ no more than by chance ({p}). {models}");
    }
    let most = found.parameters.iter().filter(|p| p.z.is_some());
    let most = most.max_by(|p, q| p.z.map(f64::abs).unwrap_or(0.0).total_cmp(&q.z.map(f64::abs).unwrap_or(0.0)));
    let most = most
        .map_or(String::new(), |m| format!(", most in {} ({:+.1} standard deviations)", m.effect, m.z.unwrap_or(0.0)));
    format!("The models differ: {common} differ by more than chance ({p}){most}. {models}")
}
