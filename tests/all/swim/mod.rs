//! Simulation of a planar vehicle in plain arithmetic, independent of the library, and its log as text.

#![allow(dead_code)] // no test uses all of it

use std::fmt::Write as _;

use hydrosysid::log::PLANAR;

/// The campaign file without its runs; the baseline has every effect of the swim.
pub const CAMPAIGN: &str = r#"format = 1
[vehicle]
name = "swim"
mass = 800.0
volume = 0.8
[model]
dofs = ["surge", "sway", "yaw"]
effects = ["inertia", "linear_drag", "quadratic_drag", "coriolis_surge", "coriolis_sway"]
"#;

/// Parameters of the swim, in the order inertia, linear, quadratic drag of surge, sway, yaw.
pub const TRUTH: [f64; 9] = [841.93, 82.3, 309.07, 1100.0, 120.0, 450.0, 186.0, 12.78, 95.32];

/// Motion of a planar vehicle: mu u̇ − mv v r = X, mv v̇ + mu u r = Y, I ṙ = N, each minus linear
/// and quadratic drag, by classical RK4 at 1 ms. White sensor noise as in the corpus (0.003 m/s,
/// 0.003 m/s, 0.002 rad/s) from a fixed generator.
pub struct Swim {
    /// Rows, each t, u, v, r, tau_u, tau_v, tau_r.
    pub rows: Vec<[f64; 7]>,
}

impl Swim {
    /// At `rate` Hz; `scale` multiplies inertia, drag and force alike.
    pub fn new(rate: f64, seconds: f64, scale: f64, seed: u64) -> Swim {
        Swim::sail(rate, seconds, scale, seed, 1.0)
    }

    /// Without noise.
    pub fn quiet(rate: f64, seconds: f64) -> Swim {
        Swim::sail(rate, seconds, 1.0, 0, 0.0)
    }

    fn sail(rate: f64, seconds: f64, scale: f64, mut seed: u64, loud: f64) -> Swim {
        let tau = |t: f64| {
            [
                scale * (180.0 + 150.0 * (0.7 * t).sin()),
                scale * 60.0 * (1.3 * t + 0.7).sin(),
                scale * 68.0 * (0.9 * t).sin(),
            ]
        };
        let rate_of = |s: [f64; 3], t: f64| {
            let ([u, v, r], [x, y, n]) = (s, tau(t));
            let drag = |k: f64, k2: f64, s: f64| scale * (k * s + k2 * s * s.abs());
            [
                (x + scale * 1100.0 * v * r - drag(82.3, 309.07, u)) / (scale * 841.93),
                (y - scale * 841.93 * u * r - drag(120.0, 450.0, v)) / (scale * 1100.0),
                (n - drag(12.78, 95.32, r)) / (scale * 186.0),
            ]
        };
        let mut noise = || {
            // sum of twelve uniform numbers, variance 1
            let sum = (0..12)
                .map(|_| {
                    seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    f64::from((seed >> 40) as u32) / f64::from(1u32 << 24)
                })
                .sum::<f64>();
            loud * (sum - 6.0)
        };
        let (mut s, mut rows) = ([0.3, 0.0, 0.0], Vec::new());
        let steps = (1000.0 / rate).round() as u32;
        for k in 0..=(seconds * rate) as u32 {
            let t = f64::from(k * steps) / 1000.0;
            let f = tau(t);
            rows.push([t, s[0] + 0.003 * noise(), s[1] + 0.003 * noise(), s[2] + 0.002 * noise(), f[0], f[1], f[2]]);
            for i in 0..steps {
                let (t, h) = (t + f64::from(i) * 1e-3, 1e-3);
                let add = |a: [f64; 3], b: [f64; 3], h: f64| [a[0] + h * b[0], a[1] + h * b[1], a[2] + h * b[2]];
                let k1 = rate_of(s, t);
                let k2 = rate_of(add(s, k1, h / 2.0), t + h / 2.0);
                let k3 = rate_of(add(s, k2, h / 2.0), t + h / 2.0);
                let k4 = rate_of(add(s, k3, h), t + h);
                s = add(add(s, k1, h / 6.0), add(add(k2, k3, 1.0), k4, 0.5), h / 3.0);
            }
        }
        Swim { rows }
    }

    pub fn change(mut self, change: impl Fn(&mut [f64; 7])) -> Swim {
        self.rows.iter_mut().for_each(change);
        self
    }

    /// Lines of the file, the header first.
    pub fn lines(&self) -> Vec<String> {
        let row = |r: &[f64; 7]| {
            let mut line = format!("{:.3}", r[0]);
            r[1..].iter().for_each(|x| write!(line, ",{x:.6}").expect("a string takes all"));
            line
        };
        std::iter::once(PLANAR.join(",")).chain(self.rows.iter().map(row)).collect()
    }
}
