//! Findings about first samples of a log that take no part: nothing is left out without a finding.

use super::codes;
use crate::finding::Finding;
use crate::simulate::{FirstSample, Track};
use crate::wording::digits;

/// Returns one finding per sample that is left out.
pub(super) fn findings<'a>(tracks: impl Iterator<Item = &'a Track>) -> Vec<Finding> {
    tracks.flat_map(|track| track.left_out.iter().map(|sample| told(&track.name, sample))).collect()
}

fn told(run: &str, sample: &FirstSample) -> Finding {
    let text = format!(
        "t = {} s: {} is far off the samples that follow it at the start of the run; it is left out",
        digits(sample.time),
        digits(sample.value)
    );
    Finding::at(&codes::FIRST_SAMPLE, run, None, Some(&sample.channel), &text).of_run(run)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;
    use crate::estimate::output_error::{OutputErrorOptions, Problem};
    use crate::frame::Dof;
    use crate::model::Model;
    use crate::noise::Noise;
    use crate::run::{Run, Signal};

    #[test]
    fn what_is_left_out_is_told() {
        let model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia", "linear_drag"]).unwrap();
        let (time, mut noise): (Vec<f64>, _) = ((0..100).map(|k| 0.1 * f64::from(k)).collect(), Noise::new(1, 1));
        let mut logged: Vec<f64> = time.iter().map(|t| 0.2 * (0.5 * t).sin() + 0.01 * noise.normal()).collect();
        logged[0] = 0.7;
        let mut run = Run { name: "dive".into(), ..Run::default() };
        run.signals.insert("tau_u".into(), Signal::new(time.clone().into(), vec![0.0; 100]));
        run.signals.insert("u".into(), Signal::new(time.into(), logged));
        let problem = Problem::new(&model, &[run], &OutputErrorOptions::default()).unwrap();
        let told = findings(problem.tracks.iter());
        assert_eq!(told.len(), 1);
        assert_eq!(
            told[0].message,
            "dive, column u: t = 0 s: 0.70 is far off the samples that follow it at the start of the run; it is left \
             out"
        );
    }
}
