//! The runs of a campaign: each degree of freedom alone, zig-zags, all degrees of freedom at once,
//! or automatic control.

use std::f64::consts::{FRAC_PI_3, PI, TAU};

use crate::campaign::{Campaign, Pilots};
use crate::dof::Dof;
use crate::pilot::{Holds, Law, Sine};
use crate::random::Random;
use crate::vehicle::Vehicle;

/// Kind of a run in the campaign file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A sine in one degree of freedom.
    Oscillatory,
    /// A zig-zag.
    Zigzag,
    /// A steady speed.
    ConstantVelocity,
    /// Anything else under way.
    Free,
    /// Held on load cells.
    Bollard,
}

impl Kind {
    /// Name of the kind in a campaign file.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Oscillatory => "oscillatory",
            Kind::Zigzag => "zigzag",
            Kind::ConstantVelocity => "constant_velocity",
            Kind::Free => "free",
            Kind::Bollard => "bollard",
        }
    }
}

/// One run to be simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Kind.
    pub kind: Kind,
    /// Whether it is a validation run, which takes no part in a fit.
    pub validates: bool,
    /// Laws of the pilot.
    pub laws: Vec<(Dof, Law)>,
    /// Heading at the start, rad.
    pub heading: f64,
    /// Depth at the start, m.
    pub depth: f64,
}

/// Manoeuvre of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Manoeuvre {
    /// A sine in one degree of freedom about an offset; amplitude and offset as shares of the rated force.
    Alone(Dof, f64, f64),
    /// A zig-zag with this share of the rated moment.
    Zigzag(f64),
    /// Three sines in each degree of freedom.
    Multisine,
    /// A random binary sequence in each degree of freedom.
    Random,
    /// Steps in each degree of freedom, one after the other.
    Steps,
    /// A constant share of the rated force in one degree of freedom, which leads to a constant velocity.
    Constant(Dof, f64),
    /// PID control of the measurements.
    Controlled,
    /// Held on load cells.
    Bollard,
}

impl Manoeuvre {
    /// The manoeuvre of this name: a degree of freedom, `zigzag`, `multisine`, `random`, `steps`,
    /// `constant` (ahead), `constant:yaw=-0.4` (share of the rated force), `controlled` or
    /// `bollard`.
    pub fn named(name: &str) -> Option<Manoeuvre> {
        if let Some((dof, share)) = name.strip_prefix("constant:").and_then(|rest| rest.split_once('=')) {
            return Some(Manoeuvre::Constant(Dof::from_name(dof)?, share.parse().ok()?));
        }
        Some(match name {
            "zigzag" => Manoeuvre::Zigzag(0.65),
            "multisine" => Manoeuvre::Multisine,
            "random" => Manoeuvre::Random,
            "steps" => Manoeuvre::Steps,
            "constant" => Manoeuvre::Constant(Dof::Surge, 0.6),
            "controlled" => Manoeuvre::Controlled,
            "bollard" => Manoeuvre::Bollard,
            _ => Manoeuvre::Alone(Dof::from_name(name)?, 0.6, 0.0),
        })
    }
}

/// The runs of a campaign.
pub fn trials(campaign: &Campaign, vehicle: &Vehicle) -> Vec<Trial> {
    let held_out = if campaign.runs > 1 { (campaign.runs / 3).max(1) } else { 0 };
    let training = campaign.runs - held_out;
    (0..campaign.runs)
        .map(|k| {
            let validates = k >= training && campaign.given.is_empty();
            let (list, place) = match &campaign.manoeuvres {
                list if !list.is_empty() => (list.clone(), k),
                _ => (usual(&campaign.dofs, validates), if validates { k - training } else { k }),
            };
            let closed = match campaign.pilots {
                Pilots::Open => false,
                Pilots::Closed => true,
                Pilots::Mixed => k % 2 == 1,
            };
            let manoeuvre = match list[place % list.len()] {
                Manoeuvre::Bollard => Manoeuvre::Bollard,
                _ if campaign.bollard && k == 0 => Manoeuvre::Bollard,
                _ if closed => Manoeuvre::Controlled,
                open => open,
            };
            let mut random = Random::new(campaign.seed, 0x7000 + k as u64);
            let (kind, laws) = match campaign.given.get(k) {
                Some(given) => (Kind::Free, given.iter().map(|(dof, f)| (*dof, Law::Given(f.clone()))).collect()),
                None => laws(manoeuvre, campaign, vehicle, &mut random),
            };
            Trial { kind, validates, laws, heading: random.between(-PI, PI), depth: random.between(8.0, 12.0) }
        })
        .collect()
}

/// The usual manoeuvres of the training or validation runs with these degrees of freedom, in turn.
fn usual(dofs: &[Dof], validates: bool) -> Vec<Manoeuvre> {
    let has = |dof: Dof| dofs.contains(&dof);
    let steers = has(Dof::Surge) && has(Dof::Yaw);
    let mut list = Vec::new();
    if validates {
        if steers {
            list.push(Manoeuvre::Zigzag(-0.6));
        }
        list.extend([Manoeuvre::Multisine, Manoeuvre::Random]);
        return list;
    }
    if has(Dof::Surge) {
        list.push(Manoeuvre::Alone(Dof::Surge, 0.45, 0.5));
    }
    for dof in dofs {
        list.push(Manoeuvre::Alone(*dof, if *dof == Dof::Surge { 0.6 } else { 0.9 }, 0.0));
    }
    if dofs.len() > 3 {
        // to save a run: the zig-zag and the multisine also go ahead
        list.remove(0);
    }
    if steers {
        list.push(Manoeuvre::Zigzag(0.65));
    }
    list.push(Manoeuvre::Multisine);
    list
}

fn laws(manoeuvre: Manoeuvre, campaign: &Campaign, vehicle: &Vehicle, random: &mut Random) -> (Kind, Vec<(Dof, Law)>) {
    let rated = vehicle.rated.map(|f| f * random.between(0.9, 1.05));
    match manoeuvre {
        Manoeuvre::Alone(dof, share, offset) => {
            let i = dof.index();
            let period = [12.0, 14.0, 13.0, 7.0, 8.0, 17.0][i] * random.between(0.85, 1.3);
            let sine = Sine { amplitude: share * rated[i], period, phase: 0.0 };
            (Kind::Oscillatory, vec![(dof, Law::Sines(offset * rated[i], vec![sine]))])
        }
        Manoeuvre::Zigzag(turn) => {
            let ahead = Law::Sines(random.between(0.4, 0.6) * rated[0], Vec::new());
            let turns = Law::Zigzag { moment: turn * rated[5], bound: FRAC_PI_3 };
            (Kind::Zigzag, vec![(Dof::Surge, ahead), (Dof::Yaw, turns)])
        }
        Manoeuvre::Multisine => (Kind::Free, everything(campaign, vehicle, random)),
        Manoeuvre::Steps => (Kind::Free, steps(campaign, vehicle, random)),
        Manoeuvre::Constant(dof, share) => {
            (Kind::ConstantVelocity, vec![(dof, Law::Sines(share * rated[dof.index()], Vec::new()))])
        }
        Manoeuvre::Controlled => (Kind::Free, controlled(campaign, vehicle, random)),
        Manoeuvre::Bollard => (Kind::Bollard, everything(campaign, vehicle, random)),
        Manoeuvre::Random => {
            let law = |dof: &Dof| {
                let offset = if *dof == Dof::Surge { 0.2 * rated[0] } else { 0.0 };
                let hold = random.between(1.5, 4.0);
                (*dof, Law::Random { offset, amplitude: 0.4 * rated[dof.index()], hold })
            };
            (Kind::Free, campaign.dofs.iter().map(law).collect())
        }
    }
}

/// Four levels of force in one degree of freedom while the others have none, then in the next.
fn steps(campaign: &Campaign, vehicle: &Vehicle, random: &mut Random) -> Vec<(Dof, Law)> {
    let hold = random.between(3.0, 5.0);
    let count = campaign.dofs.len();
    let law = |(n, dof): (usize, &Dof)| {
        let mut levels = vec![0.0; 4 * count];
        for (k, share) in [0.4, 0.8, -0.5, 0.2].into_iter().enumerate() {
            levels[4 * n + k] = share * vehicle.rated[dof.index()];
        }
        (*dof, Law::Steps(levels, hold))
    };
    campaign.dofs.iter().enumerate().map(law).collect()
}

/// Three sines in each degree of freedom.
fn everything(campaign: &Campaign, vehicle: &Vehicle, random: &mut Random) -> Vec<(Dof, Law)> {
    let law = |dof: &Dof| {
        let force = vehicle.rated[dof.index()];
        let sines = (0..3).map(|_| Sine {
            amplitude: force * random.between(0.15, 0.3),
            period: random.between(5.0, 28.0),
            phase: random.between(0.0, TAU),
        });
        let sines = sines.collect();
        (*dof, Law::Sines(if *dof == Dof::Surge { 0.2 * force } else { 0.0 }, sines))
    };
    campaign.dofs.iter().map(law).collect()
}

/// PID control of the speed in surge and sway, of depth, heading, roll and pitch.
fn controlled(campaign: &Campaign, vehicle: &Vehicle, random: &mut Random) -> Vec<(Dof, Law)> {
    let inertia = vehicle.plant.inertia();
    let speed = vehicle.speed();
    let law = |dof: &Dof| {
        let i = dof.index();
        let mut targets = |low: f64, high: f64, start: f64| {
            let mut t = start;
            std::iter::from_fn(|| {
                let one = (t, random.between(low, high));
                t += random.between(5.0, 12.0);
                (one.0 < campaign.duration).then_some(one)
            })
            .collect::<Vec<_>>()
        };
        let (m, limit) = (inertia[(i, i)], vehicle.rated[i]);
        // bandwidths of about 0.8 rad/s for speeds, and about 0.7 rad/s, well damped, for positions
        let law = match dof {
            Dof::Surge => Law::Pid {
                holds: Holds::Velocity,
                targets: targets(0.1 * speed[0], 0.9 * speed[0], -campaign.lead_in),
                gains: [0.8 * m, 0.3 * m, 0.0],
                limit,
            },
            Dof::Sway => Law::Pid {
                holds: Holds::Velocity,
                targets: targets(-0.5 * speed[1], 0.5 * speed[1], -campaign.lead_in),
                gains: [0.8 * m, 0.3 * m, 0.0],
                limit,
            },
            Dof::Heave | Dof::Yaw => Law::Pid {
                holds: Holds::Position,
                targets: targets(-1.0, 1.0, -campaign.lead_in),
                gains: [0.7 * m, 0.1 * m, 1.2 * m],
                limit,
            },
            Dof::Roll | Dof::Pitch => Law::Pid {
                holds: Holds::Position,
                targets: targets(-0.15, 0.15, -campaign.lead_in),
                gains: [0.7 * m, 0.0, 1.2 * m],
                limit,
            },
        };
        (*dof, law)
    };
    campaign.dofs.iter().map(law).collect()
}
