//! NIST's reference sets for linear least squares, and matrices of known condition number.
//!
//! The solver is compared with the exact solution of the problem as rounded to doubles
//! (`exact_float64_design`, solved with rational numbers). The remaining difference to NIST's
//! certified decimals is the rounding of powers to doubles, which no program can undo.

use std::path::Path;

use hydrosysid::estimate::{Fit, LeastSquaresOptions, RSquared, Refinement, least_squares, least_squares_with};
use serde_json::Value;

use crate::shared;

const SETS: [&str; 11] = [
    "Norris", "Pontius", "NoInt1", "NoInt2", "Longley", "Filip", "Wampler1", "Wampler2", "Wampler3", "Wampler4",
    "Wampler5",
];

fn json(folder: &Path, name: &str) -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder.join(name)).expect("it can be read")).expect("it is JSON")
}

fn number(value: &Value) -> f64 {
    value.as_str().and_then(|text| text.parse().ok()).expect("a number in quotes")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(number).collect()
}

/// Correct digits, at most 16: −log₁₀ of the relative error, or of the absolute error if the true value is 0.
fn digits(found: f64, exact: f64) -> f64 {
    let error = if exact == 0.0 { found.abs() } else { ((found - exact) / exact).abs() };
    (-error.log10()).clamp(0.0, 16.0)
}

fn fewest_digits(found: &[f64], exact: &[f64]) -> f64 {
    assert_eq!(found.len(), exact.len());
    found.iter().zip(exact).map(|(f, e)| digits(*f, *e)).fold(16.0, f64::min)
}

/// Columns of the design, followed by y.
fn design(folder: &Path, set: &str) -> Vec<Vec<f64>> {
    let mut reader = csv::Reader::from_path(folder.join(format!("{set}_design.csv"))).expect("the design is there");
    let mut columns = vec![Vec::new(); reader.headers().expect("a header").len()];
    for record in reader.records() {
        for (column, cell) in columns.iter_mut().zip(&record.expect("a record")) {
            column.push(cell.parse().expect("a number"));
        }
    }
    columns
}

fn fit(folder: &Path, set: &str, refinement: Refinement) -> Fit {
    let columns = design(folder, set);
    let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let (y, h) = slices.split_last().expect("y is the last");
    least_squares_with(h, y, &LeastSquaresOptions { refinement, ..Default::default() }).expect("full rank")
}

#[test]
fn exact_solution_of_all_sets_to_the_last_digits() {
    let Some(folder) = shared::path("strd") else { return };
    let truth = json(&folder, "certified.json");
    for set in SETS {
        let exact = &truth[set]["exact_float64_design"];
        let fit = fit(&folder, set, Refinement::Auto);
        let beta = fewest_digits(&fit.coefficients, &numbers(&exact["coefficients"]));
        let sd = fewest_digits(&fit.standard_errors, &numbers(&exact["standard_deviations"]));
        let rsd = digits(fit.residual_std, number(&exact["residual_standard_deviation"]));
        let r2 = digits(fit.r_squared, number(&exact["r_squared"]));
        println!("{set:9} refined: β {beta:.1}, σ_θ {sd:.1}, σ {rsd:.1}, R² {r2:.1}");
        assert!(fit.refined, "{set}");
        // correctly rounded results have at least 15.65 digits; σ_θ needs a root and two products more
        assert!(beta >= 15.6, "{set}: β to {beta} digits");
        assert!(sd >= 15.0, "{set}: σ_θ to {sd} digits");
        assert!(rsd >= 15.0, "{set}: σ to {rsd} digits");
        // the total sum of squares is not refined and has n roundings; for R² near 0 (Wampler 5),
        // 1 − R² is the exact quantity
        assert!(r2 >= 13.5, "{set}: R² to {r2} digits");
        let kind = if set.starts_with("NoInt") { RSquared::Uncentred } else { RSquared::Centred };
        assert_eq!(fit.r_squared_kind, kind, "{set}");
    }
}

#[test]
fn plain_qr_loses_the_digits_of_the_condition() {
    let Some(folder) = shared::path("strd") else { return };
    let truth = json(&folder, "certified.json");
    for set in SETS {
        let exact = &truth[set]["exact_float64_design"];
        let fit = fit(&folder, set, Refinement::Never);
        let beta = fewest_digits(&fit.coefficients, &numbers(&exact["coefficients"]));
        let sd = fewest_digits(&fit.standard_errors, &numbers(&exact["standard_deviations"]));
        println!("{set:9} plain: β {beta:.1}, σ_θ {sd:.1}");
        // the error is ε κ of the largest |θⱼ||hⱼ|, at least |y|/p, so that small coefficients lose
        // more digits; ε κ² |e| if residuals are large (Wampler 4 and 5); 1.5 digits for n and p
        let columns = design(&folder, set);
        let length = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let parts: Vec<f64> = fit.coefficients.iter().zip(&columns).map(|(t, h)| t.abs() * length(h)).collect();
        let greatest = parts.iter().copied().fold(length(&columns[parts.len()]), f64::max);
        let spread = greatest / parts.iter().copied().fold(f64::INFINITY, f64::min);
        let condition = fit.condition_number_scaled.log10();
        let times = if ["Wampler4", "Wampler5"].contains(&set) { 2.0 } else { 1.0 };
        let bound = 14.5 - times * condition - spread.log10();
        assert!(beta >= bound, "{set}: β to {beta} digits, {bound} expected");
    }
}

#[test]
fn exact_decimals_of_nist_as_far_as_doubles_hold_them() {
    let Some(folder) = shared::path("strd") else { return };
    let truth = json(&folder, "certified.json");
    for set in SETS {
        let fit = fit(&folder, set, Refinement::Auto);
        let exact = &truth[set]["certified"];
        let beta = fewest_digits(&fit.coefficients, &numbers(&exact["coefficients"]));
        println!("{set:9} against NIST: β {beta:.1}");
        // with powers of x rounded to doubles, Filip has 7.66 digits, the others 13 or more
        assert!(beta >= if set == "Filip" { 7.6 } else { 13.0 }, "{set}: {beta}");
    }
}

#[test]
fn exact_condition_numbers_of_all_sets() {
    let Some(folder) = shared::path("strd") else { return };
    let truth = json(&folder, "cond.json");
    for set in SETS {
        let fit = fit(&folder, set, Refinement::Auto);
        let raw = fit.condition_number / number(&truth[set]["cond2_H_float64_design"]).powi(2) - 1.0;
        let scaled = fit.condition_number_scaled / number(&truth[set]["cond2_H_unit_columns"]) - 1.0;
        println!("{set:9} cond(HᵀH) {raw:.1e}, scaled {scaled:.1e}");
        // at most ε κ of the scaled columns, 1.2e-6 for Filip; the actual error is a part of that
        assert!(raw.abs() < 1e-6, "{set}: {raw}");
        // the reference of Filip is that of the decimals, whose σ_min differs by 2.5e-9 from that
        // of the doubles
        assert!(scaled.abs() < 1e-6, "{set}: {scaled}");
    }
}

#[test]
fn exact_condition_numbers_of_lauchli_and_hilbert() {
    let Some(folder) = shared::path("strd") else { return };
    let truth = json(&folder, "cond_reference.json");
    let condition = |columns: &[Vec<f64>]| {
        let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let y: Vec<f64> = (0..columns[0].len()).map(|i| (i as f64).cos()).collect();
        least_squares(&slices, &y).map(|fit| fit.condition_number)
    };
    for case in truth["lauchli"].as_array().unwrap() {
        let (n, eps) = (case["n"].as_u64().unwrap() as usize, number(&case["eps"]));
        let columns: Vec<Vec<f64>> = (0..n)
            .map(|j| {
                (0..=n)
                    .map(|i| {
                        if i == 0 {
                            1.0
                        } else if i == j + 1 {
                            eps
                        } else {
                            0.0
                        }
                    })
                    .collect()
            })
            .collect();
        let error = condition(&columns).unwrap() / number(&case["cond2_HtH"]) - 1.0;
        println!("Läuchli {n} {eps}: {error:.1e}");
        assert!(error.abs() < 1e-6, "Läuchli {n} {eps}: {error}");
    }
    for case in truth["hilbert"].as_array().unwrap() {
        let n = case["n"].as_u64().unwrap() as usize;
        // a row of zeros does not change the singular values, and gives more rows than unknowns
        let columns: Vec<Vec<f64>> =
            (0..n).map(|j| (0..=n).map(|i| if i == n { 0.0 } else { 1.0 / (i + j + 1) as f64 }).collect()).collect();
        let exact = number(&case["cond2"]);
        match condition(&columns) {
            // the rounding of the entries already changes σ_min by ε κ, that of HᵀH by twice as much
            Ok(found) => {
                let (error, limit) = (found.sqrt() / exact - 1.0, f64::EPSILON * exact);
                println!("Hilbert {n}: {error:.1e}");
                assert!(error.abs() < limit.max(1e-13), "Hilbert {n}: {error}");
            }
            Err(error) => assert!(exact > 1e13, "Hilbert {n}: {error}"),
        }
    }
}
