//! Fossen's equations as one C header, for the user's own controllers and simulators.
//!
//! ```text
//! ν̇ = M⁻¹ (τ + τ_0 + N(ν) − C(ν) ν − D ν − D_n(ν) ν − g(η))    M⁻¹ as numbers; no library, no allocation
//! ```

use std::fmt::Write;

use nalgebra::Matrix6;

use super::coefficients::Matrix;
use super::fossen::{CONVENTIONS, Pieces};
use super::header::{Bounds, Draft};
use super::number::{number, numbers};
use super::{Export, ExportError, ExportOptions, Source, Target};

pub(super) fn export(source: &Source<'_>, options: &ExportOptions) -> Result<Export, ExportError> {
    let mut draft = Draft::new(Target::CHeader);
    let pieces = Pieces::new(source, options, &mut draft)?;
    let limits = "no walls, no surface, no tether; double precision; the caller integrates, by angles for pitch below 90 degrees";
    let head = draft.head(source, &CONVENTIONS, &Bounds { limits, stability: &pieces.stability() });
    let rigid = pieces.body.matrix();
    let inertia = Matrix6::from_fn(|i, j| rigid[i][j] + pieces.added[i][j]);
    let inverse = inertia.try_inverse().ok_or(ExportError::NoInertia)?;
    let mut text: String = "/*\n".into();
    for line in head {
        // sequences that would end the comment
        let _ = writeln!(text, " * {}", line.replace("*/", "* /").replace("/*", "/ *").replace(['\n', '\r'], " "));
    }
    text += " */\n#ifndef HYDROSYSID_VEHICLE_H\n#define HYDROSYSID_VEHICLE_H\n\n#include <math.h>\n\n";
    let cells =
        |m: &dyn Fn(usize, usize) -> f64| -> Matrix { std::array::from_fn(|i| std::array::from_fn(|j| m(i, j))) };
    matrix(&mut text, "hydrosysid_M", "M_RB + M_A", &cells(&|i, j| inertia[(i, j)]));
    matrix(&mut text, "hydrosysid_M_inverse", "its inverse", &cells(&|i, j| inverse[(i, j)]));
    matrix(&mut text, "hydrosysid_D", "linear damping", &pieces.linear);
    let r = &pieces.found.restoring;
    let restoring: Vec<f64> = r.net_weight.iter().chain(&r.righting).chain(&r.trim).copied().collect();
    for (name, what, values) in [
        ("tau_0", "constant force", &pieces.found.constant[..]),
        ("restoring", "W - B of X, Y, Z; z_g W - z_b B of K, M; x_g W, y_g W", &restoring),
        (
            "eta_inter",
            "thrust that acts: eta_inter max(eta_adv[0] |v| + eta_adv[1], 0) times the nominal one",
            &pieces.losses.interaction,
        ),
        ("eta_adv", "", &pieces.losses.advance),
    ] {
        if !what.is_empty() {
            let _ = writeln!(text, "/* {what} */");
        }
        let _ =
            writeln!(text, "static const double hydrosysid_{name}[{}] = {{{}}};", values.len(), numbers(values, ", "));
    }
    text += FUNCTIONS;
    terms(&mut text, &pieces);
    text += LAST;
    Ok(draft.finish(text.into_bytes()))
}

fn matrix(text: &mut String, name: &str, what: &str, m: &Matrix) {
    let rows: Vec<String> = m.iter().map(|row| format!("    {{{}}}", numbers(row, ", "))).collect();
    let _ = writeln!(text, "/* {what} */\nstatic const double {name}[6][6] = {{\n{}\n}};", rows.join(",\n"));
}

/// Writes quadratic damping and products, term by term.
fn terms(text: &mut String, pieces: &Pieces) {
    for ([i, j, k], d) in &pieces.absolute {
        let _ = writeln!(text, "    f[{i}] -= {} * nu[{j}] * fabs(nu[{k}]);", number(*d));
    }
    for ([i, j, k], n) in &pieces.product {
        let _ = writeln!(text, "    f[{i}] += {} * nu[{j}] * nu[{k}];", number(*n));
    }
}

const FUNCTIONS: &str = r"
/* a x b subtracted from out */
static inline void hydrosysid_less_cross(const double a[3], const double b[3], double out[3])
{
    out[0] -= a[1] * b[2] - a[2] * b[1];
    out[1] -= a[2] * b[0] - a[0] * b[2];
    out[2] -= a[0] * b[1] - a[1] * b[0];
}

/* Acceleration nu_dot at eta, nu under the force tau. */
static inline void hydrosysid_nu_dot(const double eta[6], const double nu[6], const double tau[6], double nu_dot[6])
{
    static const int advance[6] = {0, 1, 2, 0, 0, 0};
    double f[6], momentum[6];
    const double down[3] = {-sin(eta[4]), cos(eta[4]) * sin(eta[3]), cos(eta[4]) * cos(eta[3])};
    const double *g = hydrosysid_restoring;
    for (int i = 0; i < 6; ++i) {
        const double eta_adv = hydrosysid_eta_adv[0] * fabs(nu[advance[i]]) + hydrosysid_eta_adv[1];
        f[i] = hydrosysid_eta_inter[i] * (eta_adv > 0.0 ? eta_adv : 0.0) * tau[i] + hydrosysid_tau_0[i];
        momentum[i] = 0.0;
        for (int j = 0; j < 6; ++j) {
            f[i] -= hydrosysid_D[i][j] * nu[j];
            momentum[i] += hydrosysid_M[i][j] * nu[j];
        }
    }
    /* C(nu) nu */
    hydrosysid_less_cross(nu + 3, momentum, f);
    hydrosysid_less_cross(nu + 3, momentum + 3, f + 3);
    hydrosysid_less_cross(nu, momentum, f + 3);
    /* g(eta) */
    for (int i = 0; i < 3; ++i) f[i] += g[i] * down[i];
    f[3] += -g[3] * down[1] + g[6] * down[2];
    f[4] += g[4] * down[0] - g[5] * down[2];
    f[5] += g[5] * down[1] - g[6] * down[0];
    /* D_n(nu) nu and N(nu) */
";

const LAST: &str = r"    for (int i = 0; i < 6; ++i) {
        nu_dot[i] = 0.0;
        for (int j = 0; j < 6; ++j) nu_dot[i] += hydrosysid_M_inverse[i][j] * f[j];
    }
}

#endif
";
