//! Samples of instruments during a known motion.

use hydrosysid_plant::attitude::from_angles;
use hydrosysid_plant::instrument::{Instrument, Truth, Working};
use hydrosysid_plant::plant::{STATES, State, place};
use hydrosysid_plant::random::Random;
use nalgebra::Vector3;

/// Samples of an instrument over `seconds` of a motion.
fn samples(instrument: &Instrument, seconds: f64, motion: impl Fn(f64) -> State) -> (Vec<f64>, Vec<Vec<f64>>) {
    let mut working = Working::new(instrument, 0.0, Random::new(4, 9));
    while working.due() <= seconds {
        let time = working.due();
        working.sample(&Truth { time, state: motion(time), effort: 12.0, load: [0.0; 6], supply: 15.0 });
    }
    (working.stamps, working.values)
}

fn still(_: f64) -> State {
    let mut x = [0.0; STATES];
    x[place::QUATERNION] = 1.0;
    x
}

/// Surge speed grows by 0.1 m/s per second, heading by 0.3 rad per second.
fn ramp(t: f64) -> State {
    let mut x = still(t);
    (x[place::NU], x[place::NU + 5]) = (0.1 * t, 0.3);
    x[place::QUATERNION..place::NU].copy_from_slice(&from_angles([0.0, 0.0, 0.3 * t]));
    x
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

fn deviation(x: &[f64]) -> f64 {
    let m = mean(x);
    (x.iter().map(|v| (v - m).powi(2)).sum::<f64>() / x.len() as f64).sqrt()
}

fn correlation(x: &[f64], lag: usize) -> f64 {
    x.iter().zip(&x[lag..]).map(|(a, b)| a * b).sum::<f64>() / x.iter().map(|a| a * a).sum::<f64>()
}

/// Noise has the standard deviation and the correlation that are asked for. With 20 000 samples,
/// one standard error of white noise is 0.5 % for the deviation and 0.007 for the correlation.
#[test]
fn law_noise_has_its_deviation_and_its_colour() {
    for colour in [0.0, 0.8] {
        let instrument = Instrument { colour, ..Instrument::new(10.0, &[("u", 0.005), ("v", 0.01)]) };
        let (_, values) = samples(&instrument, 2000.0, still);
        for (list, noise) in values.iter().zip([0.005, 0.01]) {
            assert!((deviation(list) / noise - 1.0).abs() < 0.04, "{colour}: {}", deviation(list));
            assert!(
                (correlation(list, 1) - colour).abs() < 0.03 && (correlation(list, 2) - colour * colour).abs() < 0.05
            );
        }
        let both: f64 = values[0].iter().zip(&values[1]).map(|(a, b)| a * b).sum::<f64>() / values[0].len() as f64;
        assert!(both.abs() < 0.1 * 0.005 * 0.01);
    }
}

#[test]
fn bias_scale_and_quantum_are_exact() {
    let mut instrument = Instrument::new(10.0, &[("u", 0.0)]);
    let channel = instrument.channel("u").expect("it has one");
    (channel.bias, channel.scale, channel.quantum) = (0.02, 0.1, 0.05);
    let (time, values) = samples(&instrument, 20.0, ramp);
    for (t, y) in time.iter().zip(&values[0]) {
        assert!((y - 0.11 * t - 0.02).abs() <= 0.025 + 1e-12);
        assert!((y / 0.05 - (y / 0.05).round()).abs() < 1e-9);
    }
}

#[test]
fn latency_makes_old_samples_and_jitter_moves_their_stamps() {
    let instrument = Instrument { latency: 0.25, ..Instrument::new(10.0, &[("u", 0.0)]) };
    let (time, values) = samples(&instrument, 20.0, ramp);
    assert!(time.iter().zip(&values[0]).all(|(t, y)| (y - 0.1 * (t - 0.25)).abs() < 1e-12));
    let instrument = Instrument { jitter: 0.02, ..Instrument::new(5.0, &[("u", 0.0)]) };
    let (time, values) = samples(&instrument, 4000.0, ramp);
    let off: Vec<f64> = time.iter().zip(&values[0]).map(|(t, y)| t - 10.0 * y).collect();
    assert!((deviation(&off) / 0.02 - 1.0).abs() < 0.03 && time.windows(2).all(|w| w[1] > w[0]));
}

/// Drop-outs and outliers have the shares that are asked for. With 10 000 samples, the standard
/// error is 0.3 % for a share of 10 %, and 0.1 % for a share of 1 %.
#[test]
fn law_drop_outs_and_outliers_have_their_shares() {
    let instrument = Instrument { dropouts: 0.1, outliers: (0.01, 20.0), ..Instrument::new(10.0, &[("u", 0.005)]) };
    let (time, values) = samples(&instrument, 1000.0, still);
    assert!((time.len() as f64 / 10_001.0 - 0.9).abs() < 0.015, "{}", time.len());
    let far = values[0].iter().filter(|y| y.abs() > 0.06).count() as f64 / time.len() as f64;
    assert!((far - 0.01).abs() < 0.004, "{far}");
}

#[test]
fn student_noise_has_tails() {
    let instrument = Instrument { student: Some(3), ..Instrument::new(10.0, &[("u", 0.005)]) };
    let (_, values) = samples(&instrument, 1000.0, still);
    let far = values[0].iter().filter(|y| y.abs() > 0.02).count();
    // beyond four standard deviations: 6 of 1000 with 3 degrees of freedom, 0.6 of 10 000 for normal noise
    assert!((30..110).contains(&far), "{far}");
}

/// A low-pass filter of 0.3 s delays a ramp by 0.3 s; its noise has the stated standard deviation
/// and the correlation of the filter.
#[test]
fn law_a_filtered_gyro_is_late_and_smooth() {
    let quiet = Instrument { low_pass: 0.3, ..Instrument::new(10.0, &[("u", 0.0)]) };
    let (time, values) = samples(&quiet, 20.0, ramp);
    let late = time[150] - 10.0 * values[0][150];
    // the tolerance is for the discrete filter: half an internal sample of 5 ms
    assert!((late - 0.3).abs() < 0.004, "{late}");
    let noisy = Instrument { low_pass: 0.3, ..Instrument::new(10.0, &[("r", 0.003)]) };
    let (_, values) = samples(&noisy, 3000.0, still);
    assert!((deviation(&values[0]) / 0.003 - 1.0).abs() < 0.05, "{}", deviation(&values[0]));
    assert!((correlation(&values[0], 1) - (-0.1f64 / 0.3).exp()).abs() < 0.05);
}

#[test]
fn a_smoothed_heading_follows_without_lag_and_with_less_noise() {
    let instrument = Instrument { smoothing: 2.0, ..Instrument::new(10.0, &[("psi", 0.01)]) };
    let (time, values) = samples(&instrument, 400.0, ramp);
    let off: Vec<f64> =
        time.iter().zip(&values[0]).skip(100).map(|(t, y)| hydrosysid_plant::attitude::wrapped(y - 0.3 * t)).collect();
    assert!(mean(&off).abs() < 1e-3 && deviation(&off) < 0.3 * 0.01, "{} {}", mean(&off), deviation(&off));
    assert!(values[0].iter().all(|psi| psi.abs() <= std::f64::consts::PI));
}

#[test]
fn held_samples_repeat() {
    let instrument = Instrument { renewed: Some(3.0), ..Instrument::new(9.0, &[("u", 0.005)]) };
    let (_, values) = samples(&instrument, 100.0, ramp);
    let same = values[0].windows(2).filter(|w| w[0].to_bits() == w[1].to_bits()).count();
    assert_eq!((values[0].len(), same), (901, 600));
}

#[test]
fn exact_lever_arm_misalignment_and_compass() {
    let mut dvl = Instrument::new(10.0, &[("u", 0.0), ("v", 0.0)]);
    (dvl.lever_arm, dvl.misalignment) = (Vector3::new(0.25, -0.1, 0.0), 0.1);
    let (time, values) = samples(&dvl, 5.0, ramp);
    let (u, v) = (0.1 * time[20] + 0.3 * 0.1, 0.3 * 0.25);
    let (sin, cos) = 0.1f64.sin_cos();
    assert!((values[0][20] - u * cos - v * sin).abs() < 1e-12 && (values[1][20] - v * cos + u * sin).abs() < 1e-12);
    let mut compass = Instrument::new(10.0, &[("psi", 0.0)]);
    (compass.deviation, compass.magnetic) = ((0.08, 0.05), 0.001);
    let (time, values) = samples(&compass, 5.0, ramp);
    let psi = 0.3 * time[40];
    assert!((values[0][40] - psi - 0.08 * psi.cos() - 0.05 * psi.sin() - 0.012).abs() < 1e-12);
}
