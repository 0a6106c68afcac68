//! The verb `compare` on two models: do they describe the same vehicle?
//!
//! ```text
//! δ = θ_b − θ_a,   σ² = σ_a² + σ_b²,   z = δ/σ        each parameter against N(0, 1)
//! δᵀ (Σ_a + Σ_b)⁺ δ                                    all of them together against χ²(rank)
//! ```
//!
//! θ, σ, Σ: values, standard deviations, covariances of the parameters that both models have and at
//! least one has estimated. The two fits are taken as independent. If both have used the same runs,
//! the difference is more certain than reported. Rao, *Linear Statistical Inference* (1973), ch. 3.

use std::path::Path;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

use super::codes;
use super::model_file::{ModelFile, ModelFileError, ModelParameter};
use crate::finding::Finding;
use crate::wording::p_value;

/// Two models compared. Serialises as `hydrosysid compare MODEL_A MODEL_B --json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModelDifference {
    /// Format of the result: 1.
    pub format: u32,
    /// The first model's file.
    pub a: String,
    /// The second model's file.
    pub b: String,
    /// Parameters that both models have.
    pub parameters: Vec<ParameterDifference>,
    /// Parameters of the first model alone: `term symbol`.
    pub only_a: Vec<String>,
    /// Parameters of the second model alone.
    pub only_b: Vec<String>,
    /// Test of all common parameters together; `null` if none was estimated.
    pub joint: Option<Joint>,
    /// Findings for the user.
    pub warnings: Vec<Finding>,
}

/// One parameter of two models.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterDifference {
    /// Term that reads it.
    pub effect: String,
    /// Symbol.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value in the first model, SI.
    pub a: f64,
    /// Value in the second model, SI.
    pub b: f64,
    /// Standard deviation in the first model.
    pub std_a: Option<f64>,
    /// Standard deviation in the second model.
    pub std_b: Option<f64>,
    /// Value in the second model minus value in the first.
    pub difference: f64,
    /// Standard deviation of the difference; `null` if neither was estimated.
    pub std: Option<f64>,
    /// 95 % confidence interval of the difference.
    pub interval: Option<[f64; 2]>,
    /// Difference divided by its standard deviation.
    pub z: Option<f64>,
    /// Probability of so large a difference by chance.
    pub p_value: Option<f64>,
}

/// The joint test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Joint {
    /// δᵀ (Σ_a + Σ_b)⁺ δ.
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Probability of so large a value by chance.
    pub p_value: f64,
}

/// Half-width of the 95 % confidence interval, in standard deviations.
pub(super) const COVER: f64 = 1.959_963_984_540_054;

/// Part of the greatest eigenvalue of the correlation below which an eigenvalue is rounding error.
const RANK: f64 = 1e-10;

/// p-value of the joint test below which the models differ.
const LEVEL: f64 = 0.01;

/// Compares two model files.
///
/// # Errors
/// [`ModelFileError`] if one of the files cannot be read.
pub fn difference_of(a: &Path, b: &Path) -> Result<ModelDifference, ModelFileError> {
    let names = [a.display().to_string(), b.display().to_string()];
    Ok(difference(&ModelFile::read(a)?, &ModelFile::read(b)?, names))
}

/// [`difference_of`] for models in memory, with the names that the result gives them.
pub fn difference(a: &ModelFile, b: &ModelFile, [name_a, name_b]: [String; 2]) -> ModelDifference {
    let same = |p: &ModelParameter, q: &ModelParameter| p.effect == q.effect && p.name == q.name;
    let pairs: Vec<(usize, usize)> = (0..a.parameters.len())
        .filter_map(|i| Some((i, b.parameters.iter().position(|q| same(&a.parameters[i], q))?)))
        .collect();
    let alone = |mine: &ModelFile, other: &ModelFile| -> Vec<String> {
        let own = mine.parameters.iter().filter(|p| !other.parameters.iter().any(|q| same(p, q)));
        own.map(|p| format!("{} {}", p.effect, p.name)).collect()
    };
    let parameters: Vec<ParameterDifference> =
        pairs.iter().map(|(i, j)| of_parameter(&a.parameters[*i], &b.parameters[*j])).collect();
    let unsettled = [a.unsettled(&name_a), b.unsettled(&name_b)];
    let mut result = ModelDifference {
        format: 1,
        a: name_a,
        b: name_b,
        only_a: alone(a, b),
        only_b: alone(b, a),
        joint: joint(a, b, &pairs),
        parameters,
        warnings: unsettled.into_iter().flatten().collect(),
    };
    if a.campaign == b.campaign && !a.campaign.is_empty() {
        let text = format!(
            "both models come from {}: if they used the same runs, their errors are correlated, and the difference is \
             more certain than stated",
            a.campaign
        );
        result.warnings.push(Finding::new(&codes::SAME_DATA, text));
    }
    if !result.only_a.is_empty() || !result.only_b.is_empty() {
        let text = format!(
            "only {} has {}; only {} has {}: common parameters mean something different next to different terms",
            result.a,
            listed(&result.only_a),
            result.b,
            listed(&result.only_b)
        );
        result.warnings.push(Finding::new(&codes::OTHER_TERMS, text));
    }
    if let Some(joint) = result.joint.filter(|j| j.p_value < LEVEL) {
        let mut most: Vec<&ParameterDifference> = result.parameters.iter().filter(|p| p.z.is_some()).collect();
        most.sort_by(|p, q| q.z.unwrap_or(0.0).abs().total_cmp(&p.z.unwrap_or(0.0).abs()));
        let names: Vec<String> = most
            .iter()
            .filter(|p| p.p_value.is_some_and(|x| x < LEVEL))
            .take(3)
            .map(|p| format!("{} of `{}` ({:+.1} standard deviations)", p.name, p.effect, p.z.unwrap_or(0.0)))
            .collect();
        let text = format!(
            "the models differ: chi2 = {:.1} on {} degrees of freedom, {}{}",
            joint.chi_squared,
            joint.degrees_of_freedom,
            p_value(joint.p_value),
            if names.is_empty() { String::new() } else { format!("; most in {}", names.join(", ")) }
        );
        result.warnings.push(Finding::new(&codes::DIFFERENT, text));
    }
    result
}

fn listed(names: &[String]) -> String {
    if names.is_empty() { "no other".into() } else { names.join(", ") }
}

fn of_parameter(p: &ModelParameter, q: &ModelParameter) -> ParameterDifference {
    let [std_a, std_b] = [p, q].map(|x| if x.fixed { Some(0.0) } else { x.std });
    let std = std_a.zip(std_b).map(|(s, t)| s.hypot(t)).filter(|s| *s > 0.0 && s.is_finite());
    let difference = q.value - p.value;
    let z = std.map(|s| difference / s);
    ParameterDifference {
        effect: p.effect.clone(),
        name: p.name.clone(),
        unit: p.unit.to_string(),
        a: p.value,
        b: q.value,
        std_a,
        std_b,
        difference,
        std,
        interval: std.map(|s| [difference - COVER * s, difference + COVER * s]),
        z,
        p_value: z.map(two_sided),
    }
}

/// Returns the probability that a standard normal number is farther from 0 than z.
pub(super) fn two_sided(z: f64) -> f64 {
    let normal = Normal::standard();
    2.0 * normal.cdf(-z.abs())
}

fn joint(a: &ModelFile, b: &ModelFile, pairs: &[(usize, usize)]) -> Option<Joint> {
    let cell = |file: &ModelFile, i: usize, j: usize| {
        let held = file.parameters[i].fixed || file.parameters[j].fixed;
        let known = file.covariance.get(i).and_then(|row| row.get(j)).copied().filter(|x| x.is_finite());
        if held { 0.0 } else { known.unwrap_or(0.0) }
    };
    let variance = |(i, j): &(usize, usize)| cell(a, *i, *i) + cell(b, *j, *j);
    let used: Vec<(usize, usize)> = pairs.iter().filter(|p| variance(p) > 0.0).copied().collect();
    if used.is_empty() {
        return None;
    }
    let n = used.len();
    let scale: Vec<f64> = used.iter().map(|p| variance(p).sqrt()).collect();
    let correlation = DMatrix::from_fn(n, n, |r, c| {
        (cell(a, used[r].0, used[c].0) + cell(b, used[r].1, used[c].1)) / (scale[r] * scale[c])
    });
    let delta = DVector::from_fn(n, |r, _| (b.parameters[used[r].1].value - a.parameters[used[r].0].value) / scale[r]);
    let eigen = correlation.symmetric_eigen();
    let greatest = eigen.eigenvalues.amax();
    let along = eigen.eigenvectors.transpose() * delta;
    let kept: Vec<usize> = (0..n).filter(|k| eigen.eigenvalues[*k] > RANK * greatest).collect();
    let chi_squared: f64 = kept.iter().map(|k| along[*k].powi(2) / eigen.eigenvalues[*k]).sum();
    let distribution = ChiSquared::new(kept.len() as f64).ok()?;
    Some(Joint { chi_squared, degrees_of_freedom: kept.len(), p_value: distribution.sf(chi_squared) })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::campaign::Estimator;
    use crate::campaign::file::ModelTable;
    use crate::log::LogOptions;
    use crate::units::Dimension;
    use crate::vehicle::{Vehicle, Water};

    fn model(values: &[(&str, f64, f64)], correlation: f64) -> ModelFile {
        let n = values.len();
        let parameter = |(effect, value, std): &(&str, f64, f64)| ModelParameter {
            effect: (*effect).into(),
            name: "d".into(),
            value: *value,
            std: Some(*std),
            unit: Dimension::MASS,
            fixed: *std == 0.0,
            per_run: BTreeMap::new(),
        };
        let cell = |i: usize, j: usize| values[i].2 * values[j].2 * if i == j { 1.0 } else { correlation };
        ModelFile {
            format: 1,
            hydrosysid: "0.1.0".into(),
            campaign: String::new(),
            estimator: Estimator::OutputError,
            std_method: "information".into(),
            converged: true,
            vehicle: Vehicle::default(),
            water: Water::default(),
            model: ModelTable::default(),
            log: LogOptions::default(),
            readings: Vec::new(),
            thrusters: Vec::new(),
            efficiency: Default::default(),
            envelope: BTreeMap::new(),
            effects: Vec::new(),
            observed: Vec::new(),
            tied: Vec::new(),
            sensors: BTreeMap::new(),
            noise: None,
            parameters: values.iter().map(parameter).collect(),
            covariance: (0..n).map(|i| (0..n).map(|j| cell(i, j)).collect()).collect(),
        }
    }

    fn names() -> [String; 2] {
        ["a".into(), "b".into()]
    }

    #[test]
    fn intervals_and_probabilities_are_those_of_the_normal_law() {
        let a = model(&[("drag", 100.0, 3.0)], 0.0);
        let b = model(&[("drag", 110.0, 4.0)], 0.0);
        let found = difference(&a, &b, names());
        let p = &found.parameters[0];
        assert_eq!((p.difference, p.std, p.z), (10.0, Some(5.0), Some(2.0)));
        // 2 Φ(−2), Abramowitz and Stegun, table 26.1
        assert!((p.p_value.unwrap() - 0.045_500_263_9).abs() < 1e-9);
        assert!((p.interval.unwrap()[0] - (10.0 - 9.799_819_922_7)).abs() < 1e-9);
        let joint = found.joint.unwrap();
        // one parameter: χ² is z², with the same probability
        assert!((joint.chi_squared - 4.0).abs() < 1e-12 && (joint.p_value - p.p_value.unwrap()).abs() < 1e-9);
        assert!(found.warnings.is_empty());
    }

    #[test]
    fn what_each_alone_hides_the_correlation_shows() {
        // the sum is known well, each part badly: 1.4 standard deviations each, far apart along the
        // sum
        let a = model(&[("mass", 100.0, 5.0), ("drag", 50.0, 5.0)], -0.99);
        let b = model(&[("mass", 110.0, 5.0), ("drag", 60.0, 5.0)], -0.99);
        let found = difference(&a, &b, names());
        assert!(found.parameters.iter().all(|p| p.p_value.unwrap() > 0.1));
        let joint = found.joint.unwrap();
        // δ² sum over 2σ²(1 + ρ): 2·10²/(2·25·0.01)
        assert!((joint.chi_squared - 400.0).abs() < 1e-6, "{joint:?}");
        assert!(joint.p_value < 1e-80 && found.warnings.iter().any(|w| w.code == "M117"));
    }

    #[test]
    fn held_parameters_and_others_are_told_apart() {
        let a = model(&[("mass", 100.0, 0.0), ("drag", 50.0, 5.0)], 0.0);
        let b = model(&[("mass", 100.0, 0.0), ("lift", 60.0, 5.0)], 0.0);
        let found = difference(&a, &b, names());
        assert_eq!(
            (found.only_a.as_slice(), found.only_b.as_slice()),
            (&["drag d".to_string()][..], &["lift d".to_string()][..])
        );
        assert_eq!((found.parameters[0].std, found.joint), (None, None));
        assert!(found.warnings.iter().any(|w| w.code == "M113"));
    }
}
