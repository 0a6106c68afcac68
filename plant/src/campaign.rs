//! Description of a campaign: the vehicle, its runs and instruments, the random force, and the
//! hidden effects.

use std::fmt;

use crate::commands::Input;
use crate::dof::Dof;
use crate::instrument::Instrument;
use crate::trials::Manoeuvre;
use crate::vehicle::Vehicle;
use crate::water::Sea;

/// Quantity that the pilot commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Commands {
    /// A force or moment for each degree of freedom: `tau_u` … in the log.
    #[default]
    Wrench,
    /// A command for each thruster: `V1` … in the log, `[[thruster]]` in the campaign.
    Thrusters,
}

/// Whether the runs are commanded open-loop or closed-loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pilots {
    /// Forces as functions of time; a zig-zag turns where the measured heading reaches its bound.
    #[default]
    Open,
    /// PID control of the measured heading, depth and speed.
    Closed,
    /// Open-loop and closed-loop runs in turn.
    Mixed,
}

/// Size and correlation time of a random force.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RandomForce {
    /// Root mean square in each degree of freedom, as a share of the root mean square of the
    /// commanded force over the campaign.
    pub share: f64,
    /// Correlation time, s; 0: a new number at every command sample.
    pub correlation: f64,
}

/// An effect that the truth has and the baseline lacks.
#[derive(Debug, Clone, PartialEq)]
pub struct Hidden {
    /// Name: `id`, `id@dof`, `id@dof:other`, `thruster_loss@T6`, `thruster_swap@T2:T5`, or one
    /// outside the catalogue.
    pub name: String,
    /// Size: 1 is a realistic size with a clear effect on the log.
    pub size: f64,
}

impl Hidden {
    /// The effect `name` at size 1.
    pub fn new(name: &str) -> Hidden {
        Hidden { name: name.to_string(), size: 1.0 }
    }
}

/// A campaign to be simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct Campaign {
    /// The vehicle with its typical coefficients.
    pub vehicle: Vehicle,
    /// Largest deviation of a coefficient from the typical one, as a share of it; see [`Vehicle::drawn`].
    pub spread: f64,
    /// Degrees of freedom of the model.
    pub dofs: Vec<Dof>,
    /// Degrees of freedom that move, including those of the model.
    pub moves: Vec<Dof>,
    /// Number of runs; the last third are validation runs.
    pub runs: usize,
    /// Length of each log, s.
    pub duration: f64,
    /// Time for which each run is simulated before its log begins, s.
    pub lead_in: f64,
    /// Rate of the commands, Hz.
    pub command_rate: f64,
    /// Interpolation of the commands between their instants.
    pub input: Input,
    /// Quantity that is commanded.
    pub commands: Commands,
    /// Open-loop or closed-loop runs.
    pub pilots: Pilots,
    /// Manoeuvres of the runs, in turn. If empty, the usual ones: each degree of freedom alone,
    /// zig-zags, all degrees of freedom at once.
    pub manoeuvres: Vec<Manoeuvre>,
    /// Forces of each run by degree of freedom, N and N·m, one for each command period from the
    /// first time stamp on. They replace the manoeuvres. If there are any, no run is a validation
    /// run.
    pub given: Vec<Vec<(Dof, Vec<f64>)>>,
    /// Whether the first run is at bollard pull, with load cells.
    pub bollard: bool,
    /// Instruments.
    pub instruments: Vec<Instrument>,
    /// The random force.
    pub force: RandomForce,
    /// Random forces of single degrees of freedom, which replace `force` there.
    pub own_forces: Vec<(Dof, RandomForce)>,
    /// Wave forces.
    pub sea: Option<Sea>,
    /// Hidden effects.
    pub hidden: Vec<Hidden>,
    /// Rows of the Coriolis matrix that the plant lacks and the baseline has: `coriolis_yaw` …
    pub without: Vec<String>,
    /// Longest step of the integrator, s.
    pub step: f64,
    /// Seed of everything random.
    pub seed: u64,
}

impl Campaign {
    /// A campaign of a vehicle with the ordinary instruments: 9 runs of 60 s in the plane, 11
    /// otherwise; commands at 10 Hz, held between their instants.
    pub fn new(vehicle: Vehicle, dofs: &[Dof]) -> Campaign {
        let plane = dofs.iter().all(|dof| Dof::PLANE.contains(dof));
        Campaign {
            vehicle,
            spread: 0.15,
            dofs: dofs.to_vec(),
            moves: dofs.to_vec(),
            runs: if plane { 9 } else { 11 },
            duration: 60.0,
            lead_in: 3.0,
            command_rate: 10.0,
            input: Input::Hold,
            commands: Commands::Wrench,
            pilots: Pilots::Open,
            manoeuvres: Vec::new(),
            given: Vec::new(),
            bollard: false,
            instruments: Suite::default().instruments(dofs),
            force: RandomForce::default(),
            own_forces: Vec::new(),
            sea: None,
            hidden: Vec::new(),
            without: Vec::new(),
            step: 0.01,
            seed: 1,
        }
    }
}

impl Campaign {
    /// The random force of the degree of freedom with index `i`.
    pub fn force_of(&self, i: usize) -> RandomForce {
        self.own_forces.iter().find(|(dof, _)| dof.index() == i).map_or(self.force, |(_, own)| *own)
    }
}

/// Settings of the ordinary instruments and of their usual faults.
#[derive(Debug, Clone, PartialEq)]
pub struct Suite {
    /// Sample rate of all instruments, Hz.
    pub rate: f64,
    /// Sample rate of the velocity, Hz; `None`: `rate`.
    pub dvl_rate: Option<f64>,
    /// Factor on the ordinary noise of 5 mm/s, 3 mrad/s, 0.5°, 5 cm north and east, 2 cm of depth.
    pub noise: f64,
    /// Noise of the velocity, m/s; `None`: the ordinary one times `noise`.
    pub dvl_noise: Option<f64>,
    /// Whether north and east are measured, independently of the velocity.
    pub position: bool,
    /// Whether roll, pitch, yaw and depth are logged even if they do not move.
    pub attitude: bool,
    /// Whether the velocity is logged at `rate` but renewed only at `dvl_rate`.
    pub held: bool,
    /// Correlation of the noise of all instruments from sample to sample.
    pub colour: f64,
    /// Degrees of freedom of Student's t, for the noise of all instruments; `None` for normal noise.
    pub student: Option<u32>,
    /// Share of the samples that are lost.
    pub dropouts: f64,
    /// Share of the samples that are outliers, of 20 standard deviations each.
    pub outliers: f64,
    /// Standard deviation of the error of the time stamps, s.
    pub jitter: f64,
    /// Age of the samples of the velocity at their time stamps, s.
    pub dvl_latency: f64,
    /// Quantisation in units of the noise.
    pub quantum: f64,
    /// Age of the samples of the gyro at their time stamps, s.
    pub gyro_latency: f64,
    /// Time constant of a low-pass filter in the gyro, s.
    pub gyro_filter: f64,
    /// Time constant of the filter that smooths the attitude, s.
    pub smoothing: f64,
}

impl Default for Suite {
    fn default() -> Suite {
        Suite {
            rate: 10.0,
            dvl_rate: None,
            noise: 1.0,
            dvl_noise: None,
            position: true,
            attitude: false,
            held: false,
            colour: 0.0,
            student: None,
            dropouts: 0.0,
            outliers: 0.0,
            jitter: 0.0,
            dvl_latency: 0.0,
            quantum: 0.0,
            gyro_latency: 0.0,
            gyro_filter: 0.0,
            smoothing: 0.0,
        }
    }
}

impl Suite {
    /// The instruments of a vehicle that moves in these degrees of freedom.
    pub fn instruments(&self, moves: &[Dof]) -> Vec<Instrument> {
        let has = |dof: &Dof| moves.contains(dof);
        let pick = |dofs: &[Dof], all: bool, name: fn(Dof) -> &'static str, noise: f64| {
            dofs.iter().filter(|d| all || has(d)).map(|d| (name(*d), noise * self.noise)).collect::<Vec<_>>()
        };
        let (linear, angular) = Dof::ALL.split_at(3);
        let mut dvl = pick(linear, false, Dof::velocity, 0.005);
        if let Some(noise) = self.dvl_noise {
            dvl.iter_mut().for_each(|(_, n)| *n = noise);
        }
        let gyro = pick(angular, false, Dof::velocity, 0.003);
        let mut attitude = pick(angular, self.attitude, Dof::position, 0.5_f64.to_radians());
        // without a heading, north and east cannot be related to body axes
        if self.position && !has(&Dof::Yaw) && !self.attitude && linear[..2].iter().any(has) {
            attitude.push((Dof::Yaw.position(), 0.5_f64.to_radians() * self.noise));
        }
        let fix = if self.position { pick(&linear[..2], false, Dof::position, 0.05) } else { Vec::new() };
        let depth = pick(&linear[2..], self.attitude, Dof::position, 0.02);
        let mut list = Vec::new();
        for (kind, channels) in [dvl, gyro, attitude, fix, depth].into_iter().enumerate() {
            if channels.is_empty() {
                continue;
            }
            let mut one = Instrument::new(self.rate, &channels);
            match kind {
                0 => {
                    one.latency = self.dvl_latency;
                    match self.dvl_rate {
                        Some(rate) if self.held => one.renewed = Some(rate),
                        Some(rate) => one.rate = rate,
                        None => {}
                    }
                }
                1 => (one.latency, one.low_pass) = (self.gyro_latency, self.gyro_filter),
                2 => one.smoothing = self.smoothing,
                _ => {}
            }
            (one.colour, one.student, one.jitter) = (self.colour, self.student, self.jitter);
            (one.dropouts, one.outliers) = (self.dropouts, (self.outliers, 20.0));
            for channel in &mut one.channels {
                channel.quantum = self.quantum * channel.noise;
            }
            list.push(one);
        }
        list
    }
}

/// Reason for which a campaign cannot be simulated.
#[derive(Debug, Clone, PartialEq)]
pub enum PlantError {
    /// An effect of this name cannot be hidden in this campaign.
    CannotHide {
        /// The name.
        name: String,
        /// Why not.
        reason: &'static str,
    },
    /// An invalid value.
    Wrong(String),
    /// The motion diverges: a state is no longer finite.
    Diverged {
        /// File name of the run.
        run: String,
        /// Time in the run, s.
        time: f64,
    },
    /// A file cannot be written.
    File {
        /// Path of the file.
        path: String,
        /// The system's reason.
        reason: String,
    },
}

impl fmt::Display for PlantError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PlantError::CannotHide { name, reason } => write!(f, "{name} cannot be hidden: {reason}"),
            PlantError::Wrong(text) => f.write_str(text),
            PlantError::Diverged { run, time } => write!(f, "{run}: the motion has no bounds, from {time:.1} s on"),
            PlantError::File { path, reason } => write!(f, "{path}: {reason}"),
        }
    }
}

impl std::error::Error for PlantError {}
