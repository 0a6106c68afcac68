//! Coupling compared with inertia: the Coriolis force in surge must contain the inertia found in
//! sway, and vice versa.
//!
//! ```text
//! surge   u̇ = τ_u/m_u + (m_v/m_u) v r − …          ratio  c_vr (m_u of surge)/(m_v of sway) = 1
//! sway    v̇ = τ_v/m_v − (m_u/m_v) u r − …          ratio −c_ur (m_v of sway)/(m_u of surge) = 1
//! ```
//!
//! With r in deg/s the ratios are 1/57.3; with one of r, u and v reversed they are −1. This shows
//! even if force and velocity of each degree of freedom agree, as when a whole frame is upside
//! down. Source: Fossen (2011), (6.53).

use std::f64::consts::PI;

use super::balance::{Balance, Term};
use super::codes;
use super::fit::Fit;
use super::report::{Agreement, FaultKind, Found};
use crate::log::number::short;

/// Number of standard deviations from zero at which a coefficient is certain.
const CERTAIN: f64 = 5.0;

/// Returns the two ratios, where they can be determined: the coefficient over its value from the inertias.
pub fn measure(surge: &Balance, sway: &Balance) -> Vec<Agreement> {
    let (Some(surge_fit), Some(sway_fit)) = (surge.fit(0.0), sway.fit(0.0)) else { return Vec::new() };
    let gain = |b: &Balance, f: &Fit| {
        let own = b.terms.first() == Some(&Term::Command(b.dof.force().to_string()));
        let clear = own && f.theta[0].abs() > CERTAIN * f.std[0] && f.theta[0] > 0.0;
        clear.then(|| (f.theta[0], f.std[0] / f.theta[0]))
    };
    let (Some((a_u, s_u)), Some((a_v, s_v))) = (gain(surge, &surge_fit), gain(sway, &sway_fit)) else {
        return Vec::new();
    };
    let ratio = |b: &Balance, f: &Fit, term: Term, inertia: f64, against: &str| {
        let k = b.terms.iter().position(|t| *t == term)?;
        let (c, std) = (f.theta[k], f.std[k]);
        let factor = c * inertia;
        let relative = ((std / c).powi(2) + s_u * s_u + s_v * s_v).sqrt();
        let channel = b.dof.velocity().to_string();
        let against = against.to_string();
        (c.abs() > CERTAIN * std).then(|| Agreement {
            channel,
            against,
            factor,
            std: relative * factor.abs(),
            angle: None,
            lag: None,
        })
    };
    let of_surge = ratio(surge, &surge_fit, Term::Product("v", "r"), a_v / a_u, "inertia in sway");
    let of_sway = ratio(sway, &sway_fit, Term::Product("u", "r"), -a_u / a_v, "inertia in surge");
    of_surge.into_iter().chain(of_sway).collect()
}

/// Returns the finding that all ratios support: both, or the one that could be determined.
pub fn judge(ratios: &[Agreement]) -> Vec<Found> {
    if ratios.is_empty() {
        return Vec::new();
    }
    let says = |a: &Agreement| {
        format!(
            "the coupling in {} is {} ± {} times the {}",
            if a.channel == "u" { "surge" } else { "sway" },
            short(a.factor, 3),
            short(a.std, 2),
            a.against
        )
    };
    let said = ratios.iter().map(says).collect::<Vec<_>>().join(", ");
    let all = |f: fn(&Agreement) -> bool| ratios.iter().all(f);
    // another effect may add to the coupling: a fault is reported only if every ratio is in its range
    if all(|a| (-3.0..-0.4).contains(&a.factor)) {
        let text = format!(
            "{said}: one axis is reversed; most likely r and its moment have the opposite sign (z up instead of down); \
             check body_frame"
        );
        return vec![Found::new(&codes::SIGN, &["r"], text).fault(FaultKind::Sign, "r", -1.0)];
    }
    let degrees = |a: &Agreement| (0.4..2.5).contains(&(a.factor.abs() * 180.0 / PI));
    if ratios.iter().all(degrees) {
        let text = format!("{said}: r is most likely in deg/s; set columns.r.unit");
        return vec![Found::new(&codes::UNIT, &["r"], text).fault(FaultKind::Unit, "r", 180.0 / PI)];
    }
    Vec::new()
}
