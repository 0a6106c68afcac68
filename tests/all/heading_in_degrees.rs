//! A heading in degrees in a channel that should be in radians, together with a sound gyro.

use hydrosysid::check::{self, CheckOptions, FaultKind};
use hydrosysid::run::{Run, Signal};
use hydrosysid::tank::Noise;

/// Log of a heading that swings by 80° to both sides of `middle`, wrapped at 360°, with noise of
/// 0.5° at 10 Hz, so that it sometimes steps by more than 3.14.
fn swinging(middle: f64) -> Run {
    let mut noise = Noise::new(11, 2);
    let time: std::sync::Arc<[f64]> = (0..900).map(|k| 0.1 * f64::from(k)).collect();
    let psi = |t: f64| 1.4 * (0.45 * t).sin();
    let rate = |t: f64| 0.63 * (0.45 * t).cos();
    let degrees = |n: f64, t: f64| (middle + psi(t).to_degrees() + n).rem_euclid(360.0);
    let heading: Vec<f64> = time.iter().map(|t| degrees(0.5 * noise.normal(), *t)).collect();
    let rates: Vec<f64> = time.iter().map(|t| rate(*t) + 0.003 * noise.normal()).collect();
    let mut run = Run::default();
    run.signals.insert("psi".into(), Signal::new(time.clone(), heading));
    run.signals.insert("r".into(), Signal::new(time, rates));
    run
}

#[test]
fn the_heading_is_named_whether_or_not_it_comes_round() {
    for middle in [200.0, 10.0] {
        let report = check::run(&swinging(middle), &CheckOptions::default());
        let told: Vec<_> = report.log_findings.iter().map(|f| (f.kind, f.channel.as_str())).collect();
        assert_eq!(told, [(FaultKind::Unit, "psi")], "{middle}: {:#?}", report.findings);
        assert!((report.log_findings[0].factor - 57.3).abs() < 0.1);
        assert!(
            report.findings.iter().any(|f| f.message.contains("columns.psi.unit = \"deg\"")),
            "{:#?}",
            report.findings
        );
    }
}
