//! The exported C header, compiled by the C compiler of the machine, moves as the model does for a minute.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use crate::exported::engine::{assert_within, differences};
use crate::exported::quoted::assert_quoted;
use crate::exported::*;
use hydrosysid::campaign::ModelFile;
use hydrosysid::export::{ExportOptions, Target};
use hydrosysid::frame::Dof;
use hydrosysid::procedure::acting_forces;
use nalgebra::Vector6;

/// A C program that integrates the header's equations and the kinematics of z-y-x angles by RK4 at
/// 0.02 s, with forces that are linear between samples.
const MAIN: &str = r#"
#include <stdio.h>
#include "vehicle.h"
static void rate(const double x[12], const double tau[6], double out[12])
{
    const double *n = x + 6;
    const double phi = x[3], theta = x[4];
    out[0] = out[1] = out[2] = 0.0;
    out[3] = n[3] + (n[4] * sin(phi) + n[5] * cos(phi)) * tan(theta);
    out[4] = n[4] * cos(phi) - n[5] * sin(phi);
    out[5] = (n[4] * sin(phi) + n[5] * cos(phi)) / cos(theta);
    hydrosysid_nu_dot(x, n, tau, out + 6);
}
int main(void)
{
    double x[12] = {0}, k[4][12], y[12], tau[6];
    const double h = STEP / 5, at[4] = {0, 0.5, 0.5, 1}, weight[4] = {1, 2, 2, 1};
    for (int n = 0; n < COUNT; ++n) {
        for (int i = 0; i < 6; ++i) printf("%.12g ", x[6 + i]);
        printf("\n");
        for (int s = 0; s < 5; ++s) {
            for (int stage = 0; stage < 4; ++stage) {
                const double share = (s + at[stage]) / 5;
                for (int i = 0; i < 6; ++i) tau[i] = forces[n][i] * (1 - share) + forces[n + 1][i] * share;
                for (int i = 0; i < 12; ++i) y[i] = x[i] + (stage ? at[stage] * h * k[stage - 1][i] : 0);
                rate(y, tau, k[stage]);
            }
            for (int i = 0; i < 12; ++i)
                for (int stage = 0; stage < 4; ++stage) x[i] += h / 6 * weight[stage] * k[stage][i];
        }
    }
    return 0;
}
"#;

/// Velocities by the compiled header; `None` if there is no compiler.
fn moved(file: &ModelFile, name: &str) -> Option<Vec<Vector6<f64>>> {
    let options = ExportOptions { inertia: Some([20.0, 25.0, 28.0]), ..ExportOptions::default() };
    let export = made(file, Target::CHeader, &options);
    assert!(export.lost.is_empty(), "{:?}", export.lost);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    let samples = samples(&Dof::ALL);
    let count = (SECONDS / STEP).round() as usize + 1;
    let mut main = format!("#define STEP {STEP}\n#define COUNT {count}\nstatic const double forces[][6] = {{\n");
    for row in &samples {
        let _ = writeln!(main, "{{{}}},", row.map(|x| x.to_string()).join(", "));
    }
    main += "};\n";
    std::fs::write(folder.join("vehicle.h"), &export.bytes).expect("written");
    std::fs::write(folder.join("main.c"), main + MAIN).expect("written");
    let strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1"];
    let built = Command::new("cc").args(strict).args(["main.c", "-o", "main", "-lm"]).current_dir(&folder).output();
    let Ok(built) = built else {
        println!("skipped: there is no C compiler `cc` here");
        return None;
    };
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let output = Command::new(folder.join("main")).output().expect("it runs");
    let row = |line: &str| {
        let mut row = Vector6::zeros();
        for (cell, word) in row.iter_mut().zip(line.split_whitespace()) {
            *cell = word.parse().expect("a number");
        }
        row
    };
    Some(String::from_utf8_lossy(&output.stdout).lines().map(row).collect())
}

#[test]
fn the_compiled_header_moves_as_the_model() {
    let file = floating(&EVERY_COUPLING);
    let Some(path) = moved(&file, "header") else { return };
    // the same scheme on the same equations, with numbers of eleven digits
    assert_quoted(Target::CHeader, &path, &truth(&file));
}

#[test]
fn the_compiled_header_counts_the_losses_of_thrust() {
    let efficiency = "eta_inter = { surge = 0.9, pitch = 0.85, yaw = 0.8 }\n\
                      eta_adv = { slope = -0.4, intercept = 0.98, valid = [0, 1] }";
    let lossy = ModelFile {
        efficiency: toml::from_str(efficiency).expect("it is an [efficiency]"),
        ..floating(&EVERY_COUPLING)
    };
    let Some(path) = moved(&lossy, "header-losses") else { return };
    // as in a fit: nominal forces and velocities of a run give the effective forces, and these move the model
    let run = run_of(&Dof::ALL, &samples(&Dof::ALL), &|k, dof| path[k][dof.index()]);
    let (acting, _) = acting_forces(&run, &lossy.efficiency, &[]);
    // there effective forces are linear between samples, here they follow the speed
    assert_within(&path, &truth_of(&lossy, &acting), 1e-3);
    let lossless = differences(&path, &truth(&lossy));
    assert!(lossless[0] > 0.05 && lossless[5] > 0.05, "the losses are no rounding: {lossless:?}");
}

#[test]
fn the_python_tests_move_the_same_vehicle() {
    let text = include_str!("../../python/tests/floating.toml");
    assert_eq!(toml::from_str::<ModelFile>(text).expect("it is a model file"), floating(&EVERY_COUPLING));
}
