//! The density of an innovation: Gaussian within k standard deviations, with heavier tails beyond.
//!
//! ```text
//! ρ(z) = z²  within k,    2k|z| − k²  within b = 5,    ρ(b) + 2kb ln(|z|/b)  beyond
//! z = e/√s,   ψ = ½ ρ'
//! ψ(z) = z,    k,    kb/|z|          c = E[ψ(z) z] = erf(k/√2)          of a Gaussian z
//! s'   = s z/ψ(z)          the variance with which the sample is taken in
//! ```
//!
//! A sample beyond k moves the state like one at k standard deviations, and carries as little
//! information as that; a sample that no Gaussian noise makes (beyond b) moves the state less, the
//! farther off it is. ψ(z) z, the weight of a sample in the estimate of the noise, stays at kb
//! beyond b: when it grew with z, two samples of a hundred at 25 standard deviations made the noise
//! 1.6 times too wide. The innovations within b decide which k is used; those beyond b follow no
//! density. Huber, *Robust Statistics* (1981), ch. 7; Masreliez, *IEEE Transactions on Automatic
//! Control* 20 (1975) 107-110.

use statrs::function::erf::erf;

/// Standard deviations beyond which no Gaussian innovation is found in any log.
pub(super) const OUTLIER: f64 = 5.0;

/// ψ at an innovation, and how s' grows there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// ψ(|z|)
    pub pull: f64,
    /// d ln(s'/s) / d ln|z|:  0, 1, 2.
    pub bend: f64,
}

/// ψ of an innovation that is `z` standard deviations off, and how s' grows there.
#[inline(always)]
pub(super) fn place(z: f64, limit: f64) -> Place {
    let (z, far) = (z.abs(), OUTLIER.max(limit));
    if z > far {
        return Place { pull: limit * far / z, bend: 2.0 };
    }
    Place { pull: z.min(limit), bend: f64::from(u8::from(z > limit)) }
}

impl Place {
    /// ψ'
    pub fn slope(self, z: f64) -> f64 {
        if self.bend == 0.0 { 1.0 } else { self.pull * (1.0 - self.bend) / z.abs() }
    }

    /// s' of an innovation with the variance `s` that is `z` standard deviations off.
    #[inline(always)]
    pub fn taken(self, z: f64, s: f64) -> f64 {
        if self.bend == 0.0 { s } else { s * z.abs() / self.pull }
    }
}

/// √ρ with the sign of z, and its slope.
#[inline(always)]
pub(super) fn root(z: f64, limit: f64) -> (f64, f64) {
    let (size, far) = (z.abs(), OUTLIER.max(limit));
    if size <= limit {
        return (z, 1.0);
    }
    let within = 2.0 * limit * size.min(far) - limit * limit;
    let beyond = 2.0 * limit * far * (size / far).max(1.0).ln();
    let root = (within + beyond).sqrt();
    (root.copysign(z), place(z, limit).pull / root)
}

/// c of a limit; the part beyond b adds less than a millionth of it.
pub(super) fn share(limit: f64) -> f64 {
    if limit.is_finite() { erf(limit / std::f64::consts::SQRT_2) } else { 1.0 }
}

/// 2 ln of the ratio of ∫ exp(−ρ/2) to that of a Gaussian: by how much the normalisation raises
/// −2 ln L of a sample if its density is exp(−ρ/2) instead of a Gaussian.
pub(super) fn of_heavy_tails(limit: f64) -> f64 {
    if limit.is_infinite() {
        return 0.0;
    }
    let far = OUTLIER.max(limit);
    of_mass(mass_within(limit, far) + density(far, limit) * far / (limit * far - 1.0))
}

/// By how much −2 ln L of the innovations `z` within b is lower with `limit` than with `other`.
pub(super) fn likelier(z: impl Iterator<Item = f64>, limit: f64, other: f64) -> f64 {
    let of = |limit: f64| of_mass(mass_within(limit, OUTLIER));
    let more = of(other) - of(limit);
    z.filter(|z| z.abs() <= OUTLIER).map(|z| root(z, other).0.powi(2) - root(z, limit).0.powi(2) + more).sum()
}

/// exp(−ρ/2)
fn density(z: f64, limit: f64) -> f64 {
    (-0.5 * root(z, limit).0.powi(2)).exp()
}

/// ½ ∫ exp(−ρ/2) from −`far` to `far`, which is no less than the limit, and no more than b unless
/// it is the limit.
fn mass_within(limit: f64, far: f64) -> f64 {
    let gaussian = 0.5 * std::f64::consts::TAU.sqrt() * share(limit);
    gaussian + (density(limit, limit) - density(far, limit)) / limit
}

/// 2 ln of the ratio of twice a half mass to the mass of a Gaussian.
fn of_mass(half: f64) -> f64 {
    2.0 * (2.0 * half / std::f64::consts::TAU.sqrt()).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Innovations from −`most` to `most`, `h` apart.
    fn spread(most: f64, h: f64) -> impl Iterator<Item = f64> {
        let n = (most / h).round() as i32;
        (-n..n).map(move |k| (f64::from(k) + 0.5) * h)
    }

    /// c is E[ψ(z) z] of a standard normal z, here by a sum over z: accurate to the step squared,
    /// and to 3e-7 beyond b.
    #[test]
    fn exact_share_of_a_limit() {
        for limit in [1.0, 1.345, 2.0, 3.0] {
            let h = 1e-3;
            let mean: f64 = spread(8.0, h)
                .map(|z| place(z, limit).pull * z.abs() * (-0.5 * z * z).exp() * h / std::f64::consts::TAU.sqrt())
                .sum();
            assert!((share(limit) - mean).abs() < 1e-6, "{limit}");
        }
        assert_eq!(share(f64::INFINITY), 1.0);
    }

    /// The same sum of exp(−ρ/2); the part beyond 500 standard deviations is below 1e-9.
    #[test]
    fn exact_weight_of_heavy_tails() {
        for limit in [1.0, 1.345, 2.0, 3.0, 6.0] {
            let h = 1e-3;
            let weight: f64 = spread(500.0, h).map(|z| (-0.5 * root(z, limit).0.powi(2)).exp() * h).sum();
            let exact = 2.0 * (weight / std::f64::consts::TAU.sqrt()).ln();
            assert!((of_heavy_tails(limit) - exact).abs() < 1e-6, "{limit}: {} {exact}", of_heavy_tails(limit));
        }
        assert_eq!(of_heavy_tails(f64::INFINITY), 0.0);
    }

    /// Innovations with the tails of one limit are more likely with that limit than with another:
    /// 4000 of each density within b, by its quantiles.
    #[test]
    fn innovations_show_their_own_tails() {
        for (own, other) in [(2.0, 1.345), (1.345, 2.0), (2.0, 3.0)] {
            let h = 1e-4;
            let mass = 2.0 * mass_within(own, OUTLIER);
            let (mut sum, mut drawn) = (0.0, Vec::new());
            for z in spread(OUTLIER, h) {
                sum += density(z, own) * h / mass;
                if sum * 4000.0 > drawn.len() as f64 + 0.5 {
                    drawn.push(z);
                }
            }
            assert!(drawn.len() >= 3999);
            let more = likelier(drawn.iter().copied(), own, other);
            assert!(more > 1.0, "{own} for {other}: {more}");
            assert!((more + likelier(drawn.iter().copied(), other, own)).abs() < 1e-9);
            // innovations beyond b have no influence
            assert_eq!(more, likelier(drawn.iter().copied().chain([25.0, -8.0]), own, other));
        }
    }

    /// ψ is half of the slope of ρ, ψ' is the slope of ψ, and s' is the variance with which a
    /// sample moves the state by ψ.
    #[test]
    fn one_density() {
        for limit in [1.345, 2.0, 6.0, f64::INFINITY] {
            for z in [-40.0, -7.0, -4.0, -1.9, -0.3, 0.2, 1.5, 4.7, 5.3, 30.0] {
                let (h, at) = (1e-5, place(z, limit));
                let rho = |z: f64| root(z, limit).0.powi(2);
                let psi = |z: f64| place(z, limit).pull.copysign(z);
                assert!((psi(z) - 0.25 * (rho(z + h) - rho(z - h)) / h).abs() < 1e-6, "{limit} {z}");
                assert!((at.slope(z) - 0.5 * (psi(z + h) - psi(z - h)) / h).abs() < 1e-6, "{limit} {z}");
                let (value, slope) = root(z, limit);
                assert!((value * slope - psi(z)).abs() < 1e-12, "{limit} {z}");
                let s = 0.3_f64;
                assert!((z * s.sqrt() / at.taken(z, s) - psi(z) / s.sqrt()).abs() < 1e-12, "{limit} {z}");
                let log = |z: f64| (place(z, limit).taken(z, s) / s).ln();
                let bend = (log(z * (1.0 + h)) - log(z)) / h;
                assert!((at.bend - bend).abs() < 1e-4, "{limit} {z}");
            }
        }
    }
}
