//! Waves that stand in for what the catalogue does not hold.
//!
//! A wave is fitted with a phase and an amplitude of its own in every run, so that a chain of them follows any force that
//! comes and goes: vortices that leave the hull, water that sloshes. A wave that is one is alone, and there in every run.

use super::FoundEffect;
use crate::finding::{Code, Severity};

/// A wave among the effects that is no explanation.
pub(super) const STANDS_IN: Code = Code {
    code: "D104",
    kind: "stands-in",
    severity: Severity::Warning,
    meaning: "A wave has a phase of its own in every run and fits any force that comes and goes. Several of them, or one \
              that is there in some runs only, stand in for something periodic that the catalogue does not hold: the \
              verdict is no explanation.",
};

/// An amplitude of a wave below this share of the greatest counts as none.
const FAINT: f64 = 0.2;

/// Why the waves among the effects are no explanation, if they are none.
pub(super) fn stand_in(effects: &[FoundEffect]) -> Option<String> {
    let waves: Vec<&FoundEffect> = effects.iter().filter(|e| e.id.split('@').next() == Some("wave")).collect();
    if waves.len() > 1 {
        let names: Vec<&str> = waves.iter().map(|w| w.id.as_str()).collect();
        return Some(format!("{}: {}", names.join(", "), STANDS_IN.meaning));
    }
    let wave = waves.first()?;
    let parts: Vec<&[f64]> = wave.parameters.iter().map(|p| p.per_run.as_slice()).filter(|v| !v.is_empty()).collect();
    let runs = parts.first()?.len();
    let amplitude = |run: usize| parts.iter().filter_map(|v| v.get(run)).map(|x| x * x).sum::<f64>().sqrt();
    let (least, most) =
        (0..runs).map(amplitude).fold((f64::INFINITY, 0.0), |(l, m), a| (f64::min(l, a), f64::max(m, a)));
    (least < FAINT * most).then(|| format!("{}: {}", wave.id, STANDS_IN.meaning))
}

#[cfg(test)]
mod tests {
    use super::super::FoundParameter;
    use super::*;

    fn wave(id: &str, sine: &[f64], cosine: &[f64]) -> FoundEffect {
        let part = |name: &str, per_run: &[f64]| FoundParameter {
            name: name.into(),
            value: 0.0,
            std: 0.1,
            unit: "N".into(),
            per_run: per_run.to_vec(),
        };
        FoundEffect {
            id: id.into(),
            dofs: Vec::new(),
            parameters: vec![part("a_wave", sine), part("b_wave", cosine)],
            p_value: 0.0,
            also_possible: Vec::new(),
            evidence: String::new(),
        }
    }

    #[test]
    fn one_wave_of_any_phase_in_every_run_is_a_wave() {
        assert_eq!(stand_in(&[wave("wave@surge", &[3.0, 0.0, -2.1], &[0.0, 3.1, 2.1])]), None);
        assert_eq!(stand_in(&[]), None);
    }

    #[test]
    fn several_waves_or_one_in_a_single_run_stand_in_for_something_else() {
        let all = [3.0, 3.0, 3.0];
        let several = [wave("wave@sway", &all, &all), wave("wave@yaw", &all, &all)];
        assert!(stand_in(&several).unwrap().starts_with("wave@sway, wave@yaw: "));
        let single = [wave("wave@yaw", &[0.1, 3.0, 0.2], &[0.1, 0.0, 0.1])];
        assert!(stand_in(&single).unwrap().starts_with("wave@yaw: "));
    }
}
