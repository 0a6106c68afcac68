//! Simulation of surge in plain arithmetic, independent of the library.

/// Times at 10 Hz and speeds of `u̇ = rate(t, u)` from rest, by the classical Runge-Kutta scheme at 10 ms.
pub fn surge(samples: usize, rate: impl Fn(f64, f64) -> f64) -> (Vec<f64>, Vec<f64>) {
    let (mut u, step) = (0.0, 0.01);
    let (mut time, mut speed) = (Vec::new(), Vec::new());
    for k in 0..samples * 10 {
        let t = k as f64 * step;
        if k % 10 == 0 {
            time.push(t);
            speed.push(u);
        }
        let k1 = rate(t, u);
        let k2 = rate(t + 0.5 * step, u + 0.5 * step * k1);
        let k3 = rate(t + 0.5 * step, u + 0.5 * step * k2);
        let k4 = rate(t + step, u + step * k3);
        u += step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    (time, speed)
}
