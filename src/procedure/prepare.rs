//! Preparation of runs for the stages: smoothing, body rates that are not logged, common time
//! stamps.
//!
//! ```text
//! p, q, r: slope of the filtered φ, θ, ψ if not logged
//! ```

use super::{Align, StagedOptions};
use crate::filter::{FilterError, PolynomialFilter};
use crate::frame::Dof;
use crate::log::check::time::gaps_of;
use crate::model::Model;
use crate::navigation::unwrap;
use crate::run::{Run, RunKind, Signal};

/// The run with its velocities smoothed by the filter of its stage, if that has one.
pub(super) fn smooth(run: &Run, options: &StagedOptions) -> Result<Run, FilterError> {
    let filter = match run.kind {
        RunKind::Oscillatory => options.oscillatory.filter,
        RunKind::Zigzag => options.zigzag.filter,
        _ => None,
    };
    let mut smoothed = run.clone();
    for dof in Dof::ALL {
        if let (Some(filter), Some(signal)) = (filter, run.signal(dof.velocity())) {
            smoothed
                .signals
                .insert(dof.velocity().into(), filter.apply(signal, &gaps_of(run, [dof.velocity()]))?.value);
        }
    }
    Ok(smoothed)
}

/// A zig-zag with the velocity of `dof` and the other velocities at common time stamps, as [`Align`]
/// describes; unchanged for [`Align::Linear`], which interpolates later.
pub(super) fn aligned(run: &Run, dof: Dof, align: Align) -> Run {
    let mut common = run.clone();
    let (Some(own), false) = (run.signal(dof.velocity()), align == Align::Linear) else { return common };
    let others: Vec<Dof> = Dof::ALL.into_iter().filter(|d| *d != dof && run.signal(d.velocity()).is_some()).collect();
    let index = |signal: &Signal, t: f64| signal.time().partition_point(|s| *s <= t + SLACK).checked_sub(1);
    let stamps: Vec<f64> = own.time().to_vec();
    for other in others {
        let Some(signal) = run.signal(other.velocity()) else { continue };
        match align {
            Align::Previous => {
                let seen: Vec<(f64, f64)> =
                    stamps.iter().filter_map(|t| Some((*t, signal.values()[index(signal, *t)?]))).collect();
                let (time, values): (Vec<f64>, Vec<f64>) = seen.into_iter().unzip();
                common.signals.insert(other.velocity().into(), Signal::new(time.into(), values));
            }
            Align::Linear | Align::Common => {
                let there = |t: f64| index(signal, t).is_some_and(|k| (signal.time()[k] - t).abs() <= SLACK);
                let Some(kept) = common.signal(dof.velocity()) else { continue };
                let pairs = kept.time().iter().zip(kept.values()).filter(|(t, _)| there(**t));
                let (time, values): (Vec<f64>, Vec<f64>) = pairs.map(|(t, x)| (*t, *x)).unzip();
                common.signals.insert(dof.velocity().into(), Signal::new(time.into(), values));
            }
        }
    }
    common
}

/// Time stamps nearer than this are one instant, s.
const SLACK: f64 = 1e-6;

/// Derives the body rates that a coupling of the model reads and the run does not log, for small
/// roll and pitch; returns their names.
pub(super) fn make_rates(
    run: &mut Run,
    model: &Model,
    filter: &PolynomialFilter,
) -> Result<Vec<&'static str>, FilterError> {
    let mut made = Vec::new();
    let needed: Vec<Dof> = model.terms.iter().filter_map(|t| t.place.other).filter(|d| d.is_rotation()).collect();
    for dof in needed {
        let (rate, angle) = (dof.velocity(), dof.position());
        if run.signal(rate).is_some() {
            continue;
        }
        let Some(signal) = run.signal(angle) else { continue };
        let turned = Signal::new(signal.shared_time().clone(), unwrap(signal.values()));
        let slope = filter.apply(&turned, &gaps_of(run, [angle]))?.derivative;
        run.signals.insert(rate.into(), slope);
        made.push(rate);
    }
    Ok(made)
}

/// The degree of freedom that a run shows: the one with the greatest power of the command, |τ ν| in
/// W. At constant velocity the power is that of the means, otherwise of the deviations from the
/// means. Power compares translations with rotations without a scale factor. In captive runs the
/// load cell takes the place of the velocity (bollard) or counts alone (towing).
pub fn shown(run: &Run, dofs: &[Dof]) -> Option<Dof> {
    let size = |name: &str| {
        let x = run.signal(name).map_or(&[][..], Signal::values);
        let n = x.len().max(1) as f64;
        let mean = x.iter().sum::<f64>() / n;
        match run.kind {
            RunKind::ConstantVelocity => mean.abs(),
            _ => (x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt(),
        }
    };
    let power = |dof: &Dof| match run.kind {
        RunKind::Bollard => size(dof.load()) * size(dof.force()),
        RunKind::Towing => size(dof.load()),
        _ => size(dof.force()) * size(dof.velocity()),
    };
    dofs.iter().copied().max_by(|a, b| power(a).total_cmp(&power(b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn zigzag() -> Run {
        let mut run = Run { kind: RunKind::Zigzag, ..Run::default() };
        run.signals.insert("r".into(), Signal::new(vec![0.0, 1.0, 2.0, 3.0].into(), vec![0.0, 1.0, 2.0, 3.0]));
        run.signals.insert("u".into(), Signal::new(vec![0.0, 1.5, 3.0].into(), vec![4.0, 5.0, 6.0]));
        run
    }

    #[test]
    fn slow_channels_come_to_the_instants_of_fast_ones() {
        let of = |align| aligned(&zigzag(), Dof::Yaw, align);
        assert_eq!(of(Align::Linear).signals, zigzag().signals);
        assert_eq!(of(Align::Previous).signals["u"].values(), [4.0, 4.0, 5.0, 6.0]);
        let common = of(Align::Common);
        assert_eq!((common.signals["r"].time(), common.signals["r"].values()), (&[0.0, 3.0][..], &[0.0, 3.0][..]));
    }
}
