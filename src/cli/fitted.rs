//! Tables of a fit for people.

use super::arguments as typed;
use super::output::Output;
use super::table::{UNSETTLED, estimated, measured, number, table, wrapped};
use super::{answer, noise};
use crate::campaign::file::Estimator;
use crate::campaign::{self, Fit, Noise};
use crate::procedure::sensitivity::{Spread, spreads};
use crate::thrust::fit::Estimate;

/// Prints the verdict and the parameters; warnings follow on standard error. With `--verbose` also
/// noise, stages, thruster curves, filters, and the evidence for the estimates. Results that an
/// option requests are always shown.
pub(super) fn print(fitted: &Fit, output: &Output) {
    // with --verbose the random force has its own table
    let forces = fitted.noise.as_ref().filter(|_| !output.is_verbose()).and_then(Noise::forces);
    let rest = answer::verdict_with(&fitted.sentence, forces.as_deref(), output);
    parameters(fitted, output);
    if output.is_verbose() {
        if let Some(rest) = rest {
            output.print(&wrapped(&rest));
        }
        let made = format!("estimator {}, standard deviations: {}", fitted.estimator.name(), fitted.std_method);
        output.print(&wrapped(&made));
        if let Some(found) = &fitted.noise {
            noise::print(found, fitted.converged, output);
        }
        print_thrusters(fitted, output);
        print_stages(fitted, output);
    }
    print_filters(&spreads(&fitted.filters), output);
    if output.is_verbose() {
        print_rows(fitted, output);
        print_identifiability(fitted, output);
    }
}

/// Prints the command to type next.
pub(super) fn print_next(fitted: &Fit, a: &typed::Fit, output: &Output) {
    let campaign = a.campaign.display();
    // the same estimator as in this fit
    let by = a.estimator.map(Estimator::from);
    let by = by.map_or(String::new(), |estimator| format!(" --estimator {}", estimator.name()));
    // no effect can make up for a thruster that pushes the wrong way
    let is_usable = fitted.converged && !fitted.is_at_rest() && !fitted.is_misplaced();
    let next = match (is_usable, fitted.may_lack(), &a.model) {
        (false, ..) => format!("hydrosysid check {campaign}"),
        (true, true, _) => format!("hydrosysid discover {campaign}"),
        (true, false, None) => format!("hydrosysid fit {campaign}{by} --model model.toml"),
        (true, false, Some(model)) => format!("hydrosysid compare {campaign} --model {}", model.display()),
    };
    answer::next(&next, output);
}

/// Prints term, symbol, value and unit; with `--verbose` also SNAME's name and value and the
/// paper's standard deviation.
fn parameters(fitted: &Fit, output: &Output) {
    let verbose = output.is_verbose();
    let mark = if fitted.converged { String::new() } else { format!(" {UNSETTLED}") };
    let rows: Vec<Vec<String>> = fitted
        .parameters
        .iter()
        .map(|p| {
            let place = [p.dof, p.other].iter().flatten().map(|d| d.name()).collect::<Vec<_>>().join(":");
            let sname = p.sname.as_ref().zip(p.sname_value).map(|(s, v)| format!("{s} = {}", number(v)));
            let mut row = vec![
                p.effect.clone(),
                place,
                p.name.clone(),
                if p.fixed {
                    format!("{} (held)", number(p.value))
                } else {
                    let told = |value: f64| estimated(value, p.std, fitted.converged);
                    p.by_run(told).unwrap_or_else(|| told(p.value))
                },
                p.unit.clone(),
            ];
            if verbose {
                let paper = p.std_paper.filter(|s| *s > 0.0);
                row.extend([
                    paper.map(|s| format!("± {}{mark}", number(s))).unwrap_or_default(),
                    sname.unwrap_or_default(),
                ]);
            }
            row
        })
        .collect();
    let heads = ["effect", "dof", "symbol", "value ± std", "unit", "(14)", "SNAME"];
    output.print(&table(if verbose { &heads } else { &heads[..5] }, &rows));
    if !fitted.converged {
        output.print(&format!("{UNSETTLED}: the fit did not converge, so these standard deviations mean nothing"));
    }
}

/// Prints the rows of each stage and its condition numbers.
fn print_rows(fitted: &Fit, output: &Output) {
    let rows: Vec<Vec<String>> = fitted
        .stages
        .iter()
        .map(|s| {
            vec![
                s.name.clone(),
                s.dof.to_string(),
                s.runs.len().to_string(),
                s.rows.to_string(),
                number(s.residual_std),
                number(s.condition_number),
                number(s.condition_number_scaled),
            ]
        })
        .collect();
    output.print(&table(&["stage", "dof", "runs", "rows", "residual", "cond(HᵀH)", "cond scaled"], &rows));
}

/// Prints the thruster curves that were fitted to bollard tables, equation (1).
fn print_thrusters(fitted: &Fit, output: &Output) {
    let told = |e: Estimate| measured(e.value, Some(e.std).filter(|std| *std > 0.0));
    let of_curve = |curve: &campaign::FittedCurve| {
        [("forward", curve.forward), ("reverse", curve.reverse)].map(|(way, side)| {
            vec![
                curve.thrusters.join(" "),
                way.to_string(),
                told(side.a),
                told(side.b),
                told(curve.deadband),
                curve.supply_exponent.map(told).unwrap_or_default(),
                side.rows.to_string(),
                number(side.residual_std),
            ]
        })
    };
    let rows: Vec<Vec<String>> = fitted.thrusters.iter().flat_map(of_curve).collect();
    if !rows.is_empty() {
        let heads = ["thruster", "direction", "a", "b", "dead band", "supply exponent", "rows", "residual, N"];
        output.print(&table(&heads, &rows));
    }
}

/// Prints the evidence for and against the estimates.
fn print_identifiability(fitted: &Fit, output: &Output) {
    let Some(known) = &fitted.identifiability else { return };
    let told = |x: Option<f64>| x.map_or("-".to_string(), number);
    let rows: Vec<Vec<String>> = known
        .parameters
        .iter()
        .map(|p| {
            let share = p.force_share.map_or("-".into(), |s| format!("{:.1}", 100.0 * s));
            let z = p.halves_z.map_or("-".into(), |z| format!("{z:.1}"));
            let (first, second) = (told(p.first_half), told(p.second_half));
            vec![p.term.clone(), p.name.clone(), share, number(p.inflation), first, second, z]
        })
        .collect();
    let heads = ["term", "symbol", "% of force", "inflation", "first half", "second half", "apart, std"];
    output.print(&table(&heads, &rows));
    for pair in &known.correlations {
        output.print(&wrapped(&format!("correlated: {} and {}, {:+.3}", pair.a, pair.b, pair.correlation)));
    }
    for one in &known.profiles {
        let end = |x: Option<f64>| x.map_or("not bounded".to_string(), number);
        let [low, high] = one.interval.map(end);
        let told = format!("{} of {}: 95 % by profile likelihood from {low} to {high}", one.name, one.term);
        output.print(&wrapped(&told));
    }
}

/// Prints the estimates of each stage: towed beside propelled drag with J, each oscillation with
/// its flow numbers.
fn print_stages(fitted: &Fit, output: &Output) {
    let of_stage = |s: &campaign::FitStage| -> Vec<Vec<String>> {
        let run = if s.runs.len() == 1 { s.runs[0].clone() } else { format!("{} runs", s.runs.len()) };
        // J of Table 3 is the variance of the residual, in N² or (N m)²
        let forces = ["bollard", "towing", "steady"].contains(&s.name.split(' ').next().unwrap_or_default());
        let mut rows: Vec<Vec<String>> =
            s.estimates.iter().map(|e| vec![e.name.clone(), measured(e.value, Some(e.std)), e.unit.clone()]).collect();
        if forces {
            rows.push(vec!["J".into(), number(s.residual_std.powi(2)), "".into()]);
        }
        if let Some(n) = s.numbers {
            let all = [("KC", n.keulegan_carpenter), ("λ", Some(n.lambda)), ("C_m", n.inertia_coefficient)];
            rows.extend(all.into_iter().filter_map(|(name, x)| Some(vec![name.into(), number(x?), "1".into()])));
        }
        let stage = s.name.split(' ').next().unwrap_or_default();
        let way = if s.name.ends_with("clockwise") { s.name.as_str() } else { stage };
        rows.into_iter().map(|row| [vec![way.into(), s.dof.to_string(), run.clone()], row].concat()).collect()
    };
    let rows: Vec<Vec<String>> = fitted.stages.iter().flat_map(of_stage).collect();
    if !rows.is_empty() {
        output.print(&table(&["stage", "dof", "of", "symbol", "value ± std", "unit"], &rows));
    }
}

/// Prints the variation of each estimate with window and degree of the filter, for estimates from
/// all runs together.
pub(super) fn print_filters(spreads: &[Spread], output: &Output) {
    let together = |s: &&Spread| !s.stage.contains(' ') && !["bollard", "towing", "steady"].contains(&s.stage.as_str());
    let rows: Vec<Vec<String>> = spreads
        .iter()
        .filter(together)
        .map(|s| {
            let moved = if s.relative < 10.0 { format!("{:.1}", 100.0 * s.relative) } else { "> 1000".into() };
            let range = format!("{} to {}", number(s.least), number(s.most));
            vec![s.stage.clone(), s.dof.to_string(), s.name.clone(), range, number(s.std), moved, s.unit.clone()]
        })
        .collect();
    if !rows.is_empty() {
        output.print("With polynomial filters of 5, 9 and 15 samples, degree 2 and 3, and without:");
        output.print(&table(&["stage", "dof", "symbol", "range", "std", "moves by, %", "unit"], &rows));
    }
}
