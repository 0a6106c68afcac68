//! Effects that are not in the catalogue, to test the reports on a residual that no effect of the
//! catalogue explains.
//!
//! Each is given with its formula below. Some are implemented in the part of the plant to which
//! they belong: |u|^1.5 drag in [`crate::hydrodynamics`], tide and current by heading in
//! [`crate::water`], ripple in [`crate::actuation`], backlash and a swapped wire in
//! [`crate::commands`], clock drift in [`crate::sail`].

use std::f64::consts::TAU;

use nalgebra::{Vector3, Vector6};

/// Maximum number of states of all outside effects of a vehicle together.
pub const OUTSIDE_STATES: usize = 6;

/// An effect outside the catalogue. Instants are those of the campaign's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outside {
    /// All drag is `1 + share` times as large from `from` on, as with weed or a lost fairing.
    DragStep {
        /// Share of the drag that is added.
        share: f64,
        /// Instant, s.
        from: f64,
    },
    /// A neutrally buoyant payload of `mass` is attached at `place` from `from` on.
    MassStep {
        /// Mass, kg; negative if it is dropped.
        mass: f64,
        /// Where it is attached, m.
        place: Vector3<f64>,
        /// Instant, s.
        from: f64,
    },
    /// Drag is 1 + k e^(−h/h₀) times as large above an undulating bed: h = h₀ (1.2 + sin(2π (x + y)/λ)).
    GroundEffect {
        /// k.
        strength: f64,
        /// h₀, m.
        height: f64,
        /// λ, m.
        wavelength: f64,
    },
    /// A tether that goes taut at the horizontal distance `length` from the anchor. Beyond it, the tension
    /// max(k (d − l) + c ḋ, 0) pulls towards the anchor.
    SnaggingTether {
        /// k, N/m.
        stiffness: f64,
        /// c, N·s/m.
        damping: f64,
        /// l, m.
        length: f64,
    },
    /// Friction that is largest near rest: f tanh(ν/ε) e^(−(ν/s)²), ε = 0.01, s = 0.06.
    Stiction {
        /// f, N and N·m.
        force: [f64; 6],
    },
    /// A payload that slides along x against a soft spring: m (s̈ + u̇ − v r − s r²) = −k s − c ṡ.
    SlidingPayload {
        /// m, kg.
        mass: f64,
        /// Natural period on its rail, s.
        period: f64,
    },
    /// Y += c u² sin ϕ, ϕ̇ = 2π St |u|/D, St = 0.2.
    VortexShedding {
        /// c, kg/m.
        strength: f64,
        /// D, m.
        breadth: f64,
    },
    /// Water that sloshes along x: X += m (ω² s + 2ζω ṡ), ṡ = a − u, ȧ = −ω² s − 2ζω ṡ; ζ = 0.05.
    Sloshing {
        /// m, kg.
        mass: f64,
        /// Period, s.
        period: f64,
    },
}

/// Inputs of an outside effect at one instant.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// ν_r.
    pub relative: &'a Vector6<f64>,
    /// ν.
    pub nu: &'a Vector6<f64>,
    /// Position north, east, down, m.
    pub position: Vector3<f64>,
    /// Velocity over ground, m/s.
    pub velocity: Vector3<f64>,
    /// Position at which the run began.
    pub anchor: Vector3<f64>,
    /// Drag D(ν_r) ν_r.
    pub drag: &'a Vector6<f64>,
    /// Middle of the interval on the campaign's clock, s.
    pub clock: f64,
}

impl Outside {
    /// Number of its states.
    pub fn states(&self) -> usize {
        match self {
            Outside::SlidingPayload { .. } | Outside::Sloshing { .. } => 2,
            Outside::VortexShedding { .. } => 1,
            _ => 0,
        }
    }

    /// Instant at which it begins, on the campaign's clock, s.
    pub fn event(&self) -> Option<f64> {
        match self {
            Outside::DragStep { from, .. } | Outside::MassStep { from, .. } => Some(*from),
            _ => None,
        }
    }

    /// Force in body axes, N and N·m, and a force in earth axes, N. The rates of its states are
    /// written to `rates`.
    pub fn force(&self, at: &Scene<'_>, states: &[f64], rates: &mut [f64]) -> (Vector6<f64>, Vector3<f64>) {
        let mut force = Vector6::zeros();
        let mut pull = Vector3::zeros();
        match *self {
            Outside::DragStep { share, from } if at.clock >= from => force = -share * at.drag,
            Outside::DragStep { .. } | Outside::MassStep { .. } => {}
            Outside::GroundEffect { strength, height, wavelength } => {
                let over = 1.2 + (TAU * (at.position.x + at.position.y) / wavelength).sin();
                force = -strength * (-over * height / height).exp() * at.drag;
            }
            Outside::SnaggingTether { stiffness, damping, length } => {
                let mut out = at.position - at.anchor;
                out.z = 0.0;
                let distance = out.norm();
                if distance > length {
                    let away = out / distance;
                    let tension = stiffness * (distance - length) + damping * away.dot(&at.velocity);
                    pull = -tension.max(0.0) * away;
                }
            }
            Outside::Stiction { force: most } => {
                for i in 0..6 {
                    let v = at.relative[i];
                    force[i] = -most[i] * (v / 0.01).tanh() * (-(v / 0.06).powi(2)).exp();
                }
            }
            Outside::SlidingPayload { mass, period } => {
                // states: s, and the velocity of the payload over ground along the body's x axis
                let (s, along) = (states[0], states[1]);
                let omega = TAU / period;
                let (u, v, r) = (at.nu[0], at.nu[1], at.nu[5]);
                let slip = along - u;
                let spring = mass * (omega * omega * s + 2.0 * 0.1 * omega * slip);
                rates[0] = slip;
                rates[1] = -spring / mass + (v + s * r) * r;
                // reaction to carrying the payload sideways, beyond that of a mass fixed at the origin
                let sideways = -mass * 2.0 * slip * r;
                force[0] = spring;
                force[1] = sideways;
                force[5] = s * (sideways - mass * u * r);
            }
            Outside::VortexShedding { strength, breadth } => {
                let u = at.relative[0];
                rates[0] = TAU * 0.2 * u.abs() / breadth;
                force[1] = strength * u * u * states[0].sin();
            }
            Outside::Sloshing { mass, period } => {
                let omega = TAU / period;
                let slip = states[1] - at.nu[0];
                let spring = omega * omega * states[0] + 2.0 * 0.05 * omega * slip;
                rates[0] = slip;
                rates[1] = -spring;
                force[0] = mass * spring;
            }
        }
        (force, pull)
    }
}
