//! The coefficients of a model, read off its terms, for simulators with constant coefficients.
//!
//! ```text
//! πᵢ = Σⱼ Mᵢⱼ νⱼ
//! wᵢ = cᵢ + Σⱼ Lᵢⱼ νⱼ + Σⱼₖ Aᵢⱼₖ νⱼ|νₖ| + Σⱼ≤ₖ Pᵢⱼₖ νⱼνₖ
//! ```
//!
//! M: kg, kg·m, kg·m²; c, L, A, P: forces and moments with SNAME's sign (X_u|u| = A₀₀₀ is negative
//! where it brakes). No formula of an effect is written a second time: each term is evaluated at
//! many velocities and its coefficients are solved for. A term is left out and named if these
//! functions do not span it, if it has a memory, or if it reads anything but velocities.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};

use crate::chain::{Available, assemble, memory_count};
use crate::effects::{Family, id};
use crate::frame::Dof;
use crate::model::{Model, Term};
use crate::symbolic::{Expr, Graph, Leaf};

/// A six by six matrix, rows by columns.
pub type Matrix = [[f64; 6]; 6];

/// Coefficients by row and two velocities.
pub type Tensor = [[[f64; 6]; 6]; 6];

/// A term that coefficients cannot express.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// Name of the term, `thrust_lag`.
    pub term: String,
    /// Where in the chain it acts.
    pub family: Family,
    /// Why it is left out, as the end of a sentence.
    pub reason: String,
}

/// Restoring forces and moments.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Restoring {
    /// W − B in surge, sway and heave, N; 0 in a row without the term.
    pub net_weight: [f64; 3],
    /// z_g W − z_b B in roll and pitch, N·m; 0 in a row without the term.
    pub righting: [f64; 2],
    /// x_g W and y_g W of the trim offset, N·m.
    pub trim: [f64; 2],
}

/// The coefficients of a model, body axes forward-starboard-down.
#[derive(Debug, Clone, PartialEq)]
pub struct Coefficients {
    /// Degrees of freedom of the model.
    pub dofs: Vec<Dof>,
    /// M: virtual inertia, dry and added; 0 in rows that are not modelled.
    pub inertia: Matrix,
    /// c: constant force.
    pub constant: [f64; 6],
    /// L: force by velocity.
    pub linear: Matrix,
    /// A: force by ν_j |ν_k|.
    pub absolute: Tensor,
    /// P: force by ν_j ν_k, j ≤ k.
    pub product: Tensor,
    /// Restoring forces.
    pub restoring: Restoring,
    /// Terms that none of these express.
    pub left_out: Vec<LeftOut>,
}

/// Number of functions of the velocities: 1, νⱼ, νⱼ|νₖ|, νⱼνₖ.
const FUNCTIONS: usize = 1 + 6 + 36 + 21;

/// Number of velocities at which a term is evaluated: enough to detect a term that the functions do
/// not span.
const POINTS: usize = 4 * FUNCTIONS;

/// Residual, relative to the size of the term, below which a term counts as spanned: the rounding
/// of the solution.
const LEFT: f64 = 1e-9;

/// Reads the coefficients of `model` at the values of its parameters.
pub fn coefficients(model: &Model) -> Coefficients {
    let mut result = Coefficients {
        dofs: model.dofs.clone(),
        inertia: [[0.0; 6]; 6],
        constant: [0.0; 6],
        linear: [[0.0; 6]; 6],
        absolute: [[[0.0; 6]; 6]; 6],
        product: [[[0.0; 6]; 6]; 6],
        restoring: restoring(model),
        left_out: Vec::new(),
    };
    let mut kept = model.clone();
    kept.terms.retain(|term| match unfit(model, term) {
        None => !is_restoring(term),
        Some(reason) => {
            let family = term.effect.about().family;
            result.left_out.push(LeftOut { term: term.name(), family, reason });
            false
        }
    });
    read_terms(&kept, &mut result);
    result
}

/// The reason why a term cannot have constant coefficients, as far as it is known without its
/// formula; `None` if there is none.
fn unfit(model: &Model, term: &Term) -> Option<String> {
    match term.effect.about().family {
        Family::Actuator => return Some("it changes the force between command and water".into()),
        Family::Environment => return Some("it belongs to the water of the tests, not to the vehicle".into()),
        Family::Sensor => return Some("it belongs to the sensors of the tests, not to the vehicle".into()),
        Family::Body => {}
    }
    if memory_count(&Graph::new(), model, term.effect.as_ref(), term.place) > 0 {
        return Some("it has a memory".into());
    }
    let channels = term.effect.channels(term.place);
    (!channels.is_empty()).then(|| format!("it reads {}", channels.join(", ")))
}

/// Whether a term is part of [`Restoring`]; a user's formula of attitude or position is not.
fn is_restoring(term: &Term) -> bool {
    let id = term.effect.about().id;
    id == id::TRIM_OFFSET || Dof::ALL.into_iter().filter_map(id::restoring).any(|known| known == id)
}

fn restoring(model: &Model) -> Restoring {
    let value = |dof: Dof| id::restoring(dof).and_then(|name| model.value(&name)).unwrap_or(0.0);
    let offset = |symbol: &str| {
        let found = model.parameter(id::TRIM_OFFSET, symbol);
        model.weight * found.map_or(0.0, |p| model.parameters[p].value)
    };
    Restoring {
        net_weight: [Dof::Surge, Dof::Sway, Dof::Heave].map(value),
        righting: [Dof::Roll, Dof::Pitch].map(value),
        trim: [offset("x_g"), offset("y_g")],
    }
}

/// Adds the inertia and the forces of the terms of the body.
fn read_terms(model: &Model, result: &mut Coefficients) {
    let graph = Graph::new();
    let channels: BTreeSet<String> =
        Dof::ALL.iter().flat_map(|d| [d.velocity(), d.position(), d.force()]).map(str::to_string).collect();
    let equations = assemble(&graph, model, &Available { channels, from_log: true, ..Available::default() });
    let velocity = |leaf: Leaf| match leaf {
        Leaf::Input(k) => Dof::ALL.iter().position(|d| d.velocity() == equations.inputs[usize::from(k)]),
        _ => None,
    };
    let read = |nu: [f64; 6]| {
        let theta = model.values();
        move |leaf: Leaf| match leaf {
            Leaf::Parameter(p) => theta[usize::from(p)],
            leaf => velocity(leaf).map_or(0.0, |j| nu[j]),
        }
    };
    for i in model.dofs.iter().map(|d| d.index()) {
        for leaf in equations.momentum[i].leaves() {
            if let Some(j) = velocity(leaf) {
                result.inertia[i][j] = equations.momentum[i].derivative(leaf).evaluate(&read([0.0; 6]));
            }
        }
    }
    let points = points();
    let design = DMatrix::from_fn(POINTS, FUNCTIONS, |row, column| functions(points[row])[column]);
    let solver = design.clone().svd(true, true);
    for (index, wrench) in &equations.components {
        let Some(term) = index.map(|k| &model.terms[k]) else { continue };
        let name = |leaf: Leaf| match leaf {
            Leaf::Input(k) if velocity(leaf).is_none() => Some(equations.inputs[usize::from(k)].clone()),
            _ => None,
        };
        let others: BTreeSet<String> = wrench.iter().flat_map(|w: &Expr<'_>| w.leaves()).filter_map(name).collect();
        let mut reason = None;
        if !others.is_empty() {
            let read: Vec<String> = others.into_iter().collect();
            reason = Some(format!("it reads {}", read.join(", ")));
        }
        let mut found = [[0.0; FUNCTIONS]; 6];
        for (i, formula) in wrench.iter().enumerate() {
            if formula.is_zero() || reason.is_some() {
                continue;
            }
            let values = DVector::from_iterator(POINTS, points.iter().map(|nu| formula.evaluate(&read(*nu))));
            let size = values.amax();
            let solution = solver.solve(&values, 1e-12).unwrap_or_else(|_| DVector::zeros(FUNCTIONS));
            if (&design * &solution - &values).amax() > LEFT * size {
                reason = Some("it is not a sum of linear and quadratic terms".into());
            }
            for (k, x) in solution.iter().enumerate() {
                // a value at the level of rounding is zero
                found[i][k] = if x.abs() > LEFT * solution.amax() { *x } else { 0.0 };
            }
        }
        match reason {
            Some(reason) => {
                let family = term.effect.about().family;
                result.left_out.push(LeftOut { term: term.name(), family, reason });
            }
            None => (0..6).for_each(|i| add(result, i, &found[i])),
        }
    }
}

/// Adds coefficients, in the order of [`functions`], to a row.
fn add(result: &mut Coefficients, i: usize, found: &[f64; FUNCTIONS]) {
    let mut next = found.iter().copied();
    let mut take = |cell: &mut f64| *cell += next.next().unwrap_or(0.0);
    take(&mut result.constant[i]);
    (0..6).for_each(|j| take(&mut result.linear[i][j]));
    for j in 0..6 {
        (0..6).for_each(|k| take(&mut result.absolute[i][j][k]));
    }
    for j in 0..6 {
        (j..6).for_each(|k| take(&mut result.product[i][j][k]));
    }
}

/// 1, νⱼ, νⱼ|νₖ|, νⱼνₖ (j ≤ k) at a velocity.
fn functions(nu: [f64; 6]) -> Vec<f64> {
    let mut all = vec![1.0];
    all.extend(nu);
    for j in 0..6 {
        all.extend((0..6).map(|k| nu[j] * nu[k].abs()));
    }
    for j in 0..6 {
        all.extend((j..6).map(|k| nu[j] * nu[k]));
    }
    all
}

/// Velocities between −1.5 and 1.5 that fill the space evenly: multiples of square roots of primes,
/// modulo 1.
fn points() -> Vec<[f64; 6]> {
    const PRIMES: [f64; 6] = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0];
    (1..=POINTS).map(|n| PRIMES.map(|p: f64| 3.0 * (n as f64 * p.sqrt()).fract() - 1.5)).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::effects::{Coriolis, FormulaEffect, Place};
    use crate::formula::Formula;

    const PLANAR: [Dof; 3] = [Dof::Surge, Dof::Sway, Dof::Yaw];

    fn model(effects: &[(&str, f64)], coriolis: Coriolis) -> Model {
        let names: Vec<&str> = effects.iter().map(|(name, _)| *name).collect();
        let mut model = Model::with_effects(&PLANAR, coriolis, &names).unwrap();
        for (name, value) in effects {
            model.set(name, *value);
        }
        model
    }

    /// A formula of attitude is not a weight that a target knows: it is left out and named.
    #[test]
    fn a_user_s_restoring_force_is_named_where_it_is_left_out() {
        let mut model = Model::with_effects(&[Dof::Pitch], Coriolis::Tied, &["inertia", "restoring_pitch"]).unwrap();
        let formula = Formula::parse("sin(2*theta)").unwrap();
        let own = FormulaEffect::new("keel", Dof::Pitch, formula, crate::units::Dimension::MOMENT);
        model.add(Arc::new(own), Place::at(Dof::Pitch)).unwrap();
        let left: Vec<String> = coefficients(&model).left_out.into_iter().map(|left| left.term).collect();
        assert_eq!(left, ["keel@pitch"]);
    }

    #[test]
    fn signs_are_those_of_sname_and_coriolis_follows_from_the_inertia() {
        let found = coefficients(&model(
            &[
                ("inertia@surge", 250.0),
                ("inertia@sway", 300.0),
                ("inertia@yaw", 60.0),
                ("linear_drag@surge", 20.0),
                ("quadratic_drag@sway", 400.0),
                ("mixed_drag@yaw:surge", 15.0),
                ("linear_cross_damping@sway:yaw", 7.0),
                ("bias@yaw", 0.3),
                ("coriolis_surge", 0.0),
                ("coriolis_yaw", 0.0),
            ],
            Coriolis::Tied,
        ));
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9 * b.abs(), "{a} {b}");
        close(found.inertia[1][1], 300.0);
        close(found.linear[0][0], -20.0);
        close(found.linear[1][5], -7.0);
        close(found.absolute[1][1][1], -400.0);
        close(found.absolute[5][5][0], -15.0);
        close(found.constant[5], -0.3);
        // X: + m_v v r;  N: − (m_v − m_u) u v
        close(found.product[0][1][5], 300.0);
        close(found.product[5][0][1], -50.0);
        assert!(found.left_out.is_empty());
    }

    #[test]
    fn drag_that_differs_astern_is_a_sum_of_two_quadratic_terms() {
        let found = coefficients(&model(&[("inertia@surge", 1.0), ("drag_asymmetry@surge", 30.0)], Coriolis::Tied));
        assert!((found.absolute[0][0][0] + 15.0).abs() < 1e-9 && (found.product[0][0][0] - 15.0).abs() < 1e-9);
    }

    #[test]
    fn what_has_no_coefficient_is_left_out_with_the_reason() {
        let found = coefficients(&model(
            &[
                ("inertia@surge", 1.0),
                ("cubic_drag@surge", 3.0),
                ("coulomb_friction@surge", 0.5),
                ("thrust_lag", 0.3),
                ("fluid_memory@surge", 2.0),
                ("added_mass_amplitude@surge", 2.0),
                ("current", 0.1),
            ],
            Coriolis::Tied,
        ));
        let told: Vec<(&str, &str)> = found.left_out.iter().map(|l| (l.term.as_str(), l.reason.as_str())).collect();
        assert_eq!(told.len(), 6, "{told:?}");
        assert!(told.contains(&("cubic_drag@surge", "it is not a sum of linear and quadratic terms")));
        assert!(told.contains(&("added_mass_amplitude@surge", "it reads KC_u")));
        assert!(told.contains(&("fluid_memory@surge", "it has a memory")));
    }

    #[test]
    fn restoring_wrench_is_that_of_the_effects() {
        let mut six = Model::with_effects(
            &Dof::ALL,
            Coriolis::Tied,
            &["inertia", "restoring_surge", "restoring_heave", "restoring_roll", "restoring_pitch", "trim_offset"],
        )
        .unwrap();
        six.weight = 100.0;
        six.set("restoring_surge", -3.0);
        six.set("restoring_roll", 8.0);
        six.set("trim_offset", 0.02);
        let found = coefficients(&six).restoring;
        // (φ, θ) = (0.1, 0.2): −(W−B) sin θ, …, as EFFECTS.md has them
        let (roll, pitch) = (0.1_f64, 0.2_f64);
        let down = [-pitch.sin(), pitch.cos() * roll.sin(), pitch.cos() * roll.cos()];
        let [x, y] = found.trim;
        let w = [
            found.net_weight[0] * down[0],
            found.net_weight[1] * down[1],
            found.net_weight[2] * down[2],
            -found.righting[0] * down[1] + y * down[2],
            found.righting[1] * down[0] - x * down[2],
            x * down[1] - y * down[0],
        ];
        let expected = [
            3.0 * 0.2_f64.sin(),
            0.0,
            -3.0 * 0.2_f64.cos() * 0.1_f64.cos(),
            -8.0 * 0.2_f64.cos() * 0.1_f64.sin(),
            -8.0 * 0.2_f64.sin() - 2.0 * 0.2_f64.cos() * 0.1_f64.cos(),
            2.0 * 0.2_f64.cos() * 0.1_f64.sin(),
        ];
        for (a, b) in w.iter().zip(expected) {
            assert!((a - b).abs() < 1e-12, "{w:?}");
        }
    }
}
