//! A first-order Gauss-Markov process over one step, and its effect on a velocity over that step.
//!
//! ```text
//! ḋ = −d/T + white,  stationary deviation σ:     d₊ = a d + w_d,   ∫ d dt = h κ d + w_v
//! a = e^(−h/T),  κ = T (1−a)/h
//! cov(w_d) = σ² (1−a²),  cov(w_d, w_v) = σ² T (1−a)²,  cov(w_v) = σ² T² (2h/T − 3 + 4a − a²)
//! ```
//!
//! Exact for any step, from a nearly constant force (T ≫ h) to a white one (T ≪ h). Gelb, *Applied
//! Optimal Estimation* (1974), ch. 3.

/// The process over one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Step {
    /// a: share of d that remains after the step.
    pub decay: f64,
    /// κ: mean of d over the step, as a share of its value at the beginning.
    pub mean: f64,
    /// Standard deviation of w_v.
    pub drift: f64,
    /// Coefficient in w_d of the unit noise that drives w_v.
    pub shared: f64,
    /// Coefficient in w_d of a unit noise of its own.
    pub own: f64,
}

/// The process of stationary standard deviation `rms` and correlation time `time`, s, over a step
/// of `h`, s.
pub(super) fn step(rms: f64, time: f64, h: f64) -> Step {
    if h <= 0.0 {
        return Step { decay: 1.0, mean: 1.0, drift: 0.0, shared: 0.0, own: 0.0 };
    }
    let z = h / time;
    let lost = -(-z).exp_m1();
    let decay = 1.0 - lost;
    let dd = rms * rms * -(-2.0 * z).exp_m1();
    let vd = rms * rms * time * lost * lost;
    // below a tenth the closed form loses digits to cancellation
    let series = z * z * z * (2.0 / 3.0 + z * (-0.5 + z * (7.0 / 30.0 + z * (-1.0 / 12.0 + z * 31.0 / 1260.0))));
    let closed = 2.0 * z - 3.0 + 4.0 * decay - decay * decay;
    let vv = rms * rms * time * time * if z < 0.1 { series } else { closed };
    let drift = vv.max(0.0).sqrt();
    let shared = if drift > 0.0 { vd / drift } else { 0.0 };
    Step { decay, mean: lost / z, drift, shared, own: (dd - shared * shared).max(0.0).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two steps equal one of twice the length, for d and ∫d together.
    #[test]
    fn law_two_steps_are_one() {
        for (time, h) in [(1.0, 0.1), (0.01, 0.3), (50.0, 0.05), (0.2, 0.2), (1.0, 0.05), (1e-4, 0.1)] {
            let (one, two) = (step(0.7, time, h), step(0.7, time, 2.0 * h));
            let b = h * one.mean;
            assert!((one.decay * one.decay - two.decay).abs() < 1e-15);
            assert!((b + b * one.decay - 2.0 * h * two.mean).abs() < 1e-14 * h.max(time));
            let (vv, vd) = (one.drift.powi(2), one.drift * one.shared);
            let dd = one.shared.powi(2) + one.own.powi(2);
            // after two steps: w_v1 + b w_d1 + w_v2 and a w_d1 + w_d2
            let vv2 = vv + 2.0 * b * vd + b * b * dd + vv;
            let vd2 = one.decay * (vd + b * dd) + vd;
            let dd2 = one.decay * one.decay * dd + dd;
            // the series is accurate to z⁸/5000 at z = 0.1
            let near = |x: f64, y: f64| assert!((x - y).abs() < 1e-6 * y.abs() + 1e-300, "{time} {h}: {x} {y}");
            near(vv2, two.drift.powi(2));
            near(vd2, two.drift * two.shared);
            near(dd2, two.shared.powi(2) + two.own.powi(2));
        }
    }

    #[test]
    fn exact_limits() {
        let white = step(1.0, 1e-6, 0.1);
        assert!((white.drift.powi(2) - 2.0 * 1e-6 * 0.1).abs() < 1e-10 && white.decay == 0.0);
        let stays = step(1.0, 1e9, 0.1);
        assert!((stays.mean - 1.0).abs() < 1e-9 && stays.drift < 1e-5 && (stays.decay - 1.0).abs() < 1e-9);
    }
}
