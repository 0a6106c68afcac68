//! Simulation of a campaign: combines runs, instruments and random numbers.

use nalgebra::Vector3;

use crate::actuation::CHANNELS;
use crate::attitude::from_angles;
use crate::campaign::{Campaign, Commands as Commanded, PlantError, RandomForce};
use crate::commands::{Commands, Input};
use crate::disturbance::{Force, node_spacing};
use crate::dof::Dof;
use crate::hide::{Setup, setup};
use crate::instrument::{Instrument, Truth as Instant, Working};
use crate::integrate::integrate;
use crate::log::{Log, Signal};
use crate::pilot::{Pilot, Seen};
use crate::plant::{Interval, Plant, STATES, State, place};
use crate::random::Random;
use crate::run_number::run_number;
use crate::trials::{Kind, Trial, trials};
use crate::truth::Truth;
use crate::vehicle::Vehicle;

/// Pause between the end of one run and the start of the next on the campaign's clock, s.
pub const PAUSE: f64 = 120.0;

/// Reference of the supply voltage, its fall over a run, and its fall over the runs of the campaign, V.
const SUPPLY: [f64; 3] = [15.5, 1.2, 0.8];

/// Number of rehearsals in which the inertia and the amplitude of the motion converge.
const ROUNDS: usize = 4;

/// Longest step of a rehearsal, s.
const REHEARSAL_STEP: f64 = 0.05;

/// A simulated campaign.
#[derive(Debug, Clone)]
pub struct Sailed {
    /// The campaign as described.
    pub campaign: Campaign,
    /// The drawn vehicle as its owner knows it, without the hidden effects.
    pub vehicle: Vehicle,
    /// The simulated plant, with the hidden effects.
    pub plant: Plant,
    /// Names of the effects of the baseline.
    pub baseline: Vec<String>,
    /// The logs.
    pub logs: Vec<Log>,
    /// True values.
    pub truth: Truth,
}

impl Campaign {
    /// Simulates all runs.
    ///
    /// # Errors
    /// [`PlantError`] if an effect cannot be hidden, the motion diverges, or a degree of freedom of
    /// the model does not move.
    pub fn sail(&self) -> Result<Sailed, PlantError> {
        if self.dofs.iter().any(|dof| !self.moves.contains(dof)) {
            return Err(PlantError::Wrong("every degree of freedom of the model must be one that moves".to_string()));
        }
        let mut setup = setup(self)?;
        let trials = trials(self, &setup.vehicle);
        self.number_runs(&mut setup, &trials)?;
        let rms = self.commanded_rms(&setup, &trials)?;
        let sigma = std::array::from_fn(|i| rms[i] * self.force_of(i).share);
        let mut logs = Vec::new();
        for (k, trial) in trials.iter().enumerate() {
            logs.push(Voyage { campaign: self, setup: &setup, trial, index: k }.sail(&sigma, self.step, true)?.0);
        }
        let truth = Truth::of(self, &setup, &sigma, &rms);
        let Setup { vehicle, plant, baseline, .. } = setup;
        Ok(Sailed { campaign: self.clone(), vehicle, plant, baseline, logs, truth })
    }

    /// Sets the Keulegan-Carpenter numbers of the runs if the inertia depends on them. The motion
    /// depends on the inertia and the inertia on the motion, so this is iterated.
    fn number_runs(&self, setup: &mut Setup, trials: &[Trial]) -> Result<(), PlantError> {
        let depends: Vec<usize> = (0..6).filter(|i| setup.amplitude[*i] != 0.0).collect();
        if depends.is_empty() {
            return Ok(());
        }
        for _ in 0..ROUNDS {
            let mut numbers = vec![[0.0; 6]; trials.len()];
            for (index, trial) in trials.iter().enumerate().filter(|(_, trial)| trial.kind != Kind::Bollard) {
                let voyage = Voyage { campaign: self, setup, trial, index };
                let (log, wrenches) = voyage.sail(&[0.0; 6], REHEARSAL_STEP, false)?;
                for i in &depends {
                    let period = 1.0 / self.command_rate;
                    numbers[index][*i] = run_number(&log, &wrenches, period, *i, setup.vehicle.length);
                }
            }
            setup.run_numbers = numbers;
        }
        Ok(())
    }

    /// Root mean square of the commanded force over the campaign, N and N·m, from a rehearsal
    /// without random force and with long steps. For a degree of freedom commanded with less than
    /// 5 % of its rated force it is 30 % of the rated force.
    fn commanded_rms(&self, setup: &Setup, trials: &[Trial]) -> Result<[f64; 6], PlantError> {
        let (mut sum, mut count) = ([0.0; 6], 0.0);
        for (index, trial) in trials.iter().enumerate().filter(|(_, trial)| trial.kind != Kind::Bollard) {
            let voyage = Voyage { campaign: self, setup, trial, index };
            for wrench in voyage.sail(&[0.0; 6], REHEARSAL_STEP, false)?.1 {
                (0..6).for_each(|i| sum[i] += wrench[i] * wrench[i]);
                count += 1.0;
            }
        }
        Ok(std::array::from_fn(|i| {
            let (rms, rated) = ((sum[i] / f64::max(count, 1.0)).sqrt(), setup.vehicle.rated[i]);
            if rms < 0.05 * rated { 0.3 * rated } else { rms }
        }))
    }
}

/// One run.
struct Voyage<'a> {
    campaign: &'a Campaign,
    setup: &'a Setup,
    trial: &'a Trial,
    index: usize,
}

/// File name of a run.
pub(crate) fn file_of_run(run: usize) -> String {
    format!("run{run:02}.csv")
}

impl Voyage<'_> {
    fn random(&self, purpose: u64) -> Random {
        Random::new(self.campaign.seed, (purpose << 32) + ((self.index as u64) << 8))
    }

    /// The log, and the commanded wrenches. Without instruments if `logs` is false, as in a rehearsal.
    fn sail(&self, sigma: &[f64; 6], step: f64, logs: bool) -> Result<(Log, Vec<[f64; 6]>), PlantError> {
        let (campaign, setup) = (self.campaign, self.setup);
        let name = file_of_run(self.index);
        let rate = campaign.command_rate;
        let period = 1.0 / rate;
        let lead = (campaign.lead_in * rate).round() as i64;
        let last = (campaign.duration * rate).round() as i64;
        let stamp = |tick: i64| tick as f64 / rate;
        let (start, end) = (stamp(-lead), stamp(last));
        let clock = self.index as f64 * (campaign.duration + PAUSE);

        let mut plant = setup.plant.clone();
        setup.of_run(&mut plant, self.index);
        let mut instruments: Vec<Instrument> = if logs { setup.instruments.clone() } else { Vec::new() };
        if self.trial.kind == Kind::Bollard {
            plant.moves = [false; 6];
            let cell = |dof: &Dof| (dof.load(), 0.005 * setup.vehicle.rated[dof.index()]);
            let cells: Vec<_> = campaign.dofs.iter().map(cell).collect();
            instruments = vec![Instrument::new(rate, &cells)];
        }
        if let Some(sea) = campaign.sea.or(setup.sea) {
            plant.waves.extend(sea.realise(&mut self.random(4)));
        }
        let ready = plant.ready();
        let believed: &[_] = if campaign.commands == Commanded::Thrusters { &setup.vehicle.thrusters } else { &[] };
        let mut commands = Commands::new(believed, &setup.wiring, self.index, campaign.input, start, period);
        let mut pilot = Pilot::new(self.trial.laws.clone(), self.random(1));
        let moves = std::array::from_fn(|i| campaign.moves.iter().any(|dof| dof.index() == i));
        let forces: Vec<Force> = (0..6)
            .map(|i| {
                let RandomForce { correlation, .. } = campaign.force_of(i);
                let rms = if setup.plant.moves[i] { sigma[i] } else { 0.0 };
                let mut random = Random::new(campaign.seed, (2 << 32) + ((self.index as u64) << 8) + i as u64);
                let until = if rms > 0.0 { end } else { start };
                Force::realise(rms, correlation, start, until, period, &mut random)
            })
            .collect();
        let mut spacings: Vec<f64> = (0..6)
            .filter(|i| sigma[*i] > 0.0)
            .map(|i| match campaign.force_of(i).correlation {
                time if time > 0.0 => node_spacing(time),
                _ => period,
            })
            .collect();
        spacings.sort_unstable_by(f64::total_cmp);
        spacings.dedup();

        let mut working: Vec<Working<'_>> = instruments
            .iter()
            .enumerate()
            .map(|(k, one)| {
                let stream = (3 << 32) + ((self.index as u64) << 8) + k as u64;
                Working::new(one, start, Random::new(campaign.seed, stream))
            })
            .collect();
        let mut x: State = [0.0; STATES];
        x[2] = self.trial.depth;
        x[place::QUATERNION..place::NU].copy_from_slice(&from_angles([0.0, 0.0, self.trial.heading]));
        let mut truth = Vec::new();
        let mut wrenches = Vec::new();
        let mut anchor: Option<Vector3<f64>> = None;
        // one tick beyond the last time stamp, for the samples at the end
        for tick in -lead..=last {
            let (from, to) = (stamp(tick), stamp(tick + 1));
            let seen = seen(&working, from, &x);
            let ahead = if campaign.input == Input::Linear { 1 } else { 0 };
            while (commands.logged.len() as i64) <= tick + lead + ahead {
                let of = stamp(commands.logged.len() as i64 - lead);
                commands.give(&pilot.command(of, period, &seen), moves);
            }
            if tick >= 0 {
                truth.push((from, x));
                wrenches.push(commands.believed().into());
                anchor.get_or_insert(Vector3::new(x[0], x[1], x[2]));
            }
            let delay = plant.actuation.delay;
            let mut edges = vec![from, to];
            let mut add = |edge: f64| {
                if edge > from + 1e-9 && edge < to - 1e-9 {
                    edges.push(edge);
                }
            };
            if delay > 0.0 {
                add(from + delay - (delay * rate).floor() / rate);
            }
            for spacing in &spacings {
                let first = ((from - start) / spacing).floor() as i64;
                let count = (period / spacing).ceil() as i64 + 1;
                (first..=first + count).for_each(|node| add(start + node as f64 * *spacing));
            }
            setup.events(clock).into_iter().for_each(&mut add);
            edges.sort_unstable_by(f64::total_cmp);
            // nodes of several forces can coincide
            edges.dedup_by(|later, earlier| *later - *earlier < 1e-9);
            for pair in edges.windows(2) {
                let (a, b) = (pair[0], pair[1]);
                let volts = |t: f64| self.supply(t);
                let interval = Interval {
                    from: a,
                    to: b,
                    clock,
                    command: commands.line(a, b, delay),
                    force: std::array::from_fn(|i| forces[i].line(a, b)),
                    supply: (volts(a) / SUPPLY[0], (volts(b) - volts(a)) / (b - a) / SUPPLY[0]),
                    anchor,
                };
                x = integrate(&ready, x, &interval, step, |done| {
                    for one in &mut working {
                        // a sample that depends on the command is taken with the command that
                        // begins at the same instant
                        let until = if one.sees_command() { done.to - 1e-9 } else { done.to + 1e-9 };
                        while one.due() <= until {
                            let t = one.due();
                            let state = done.at(t);
                            let held = self.trial.kind == Kind::Bollard;
                            let load = if held { ready.rates(t, &state, &interval).thrust.into() } else { [0.0; 6] };
                            let effort = effort(&interval, t, one.instrument(), believed);
                            one.sample(&Instant { time: t, state, effort, load, supply: volts(t) });
                        }
                    }
                });
            }
            if x.iter().any(|value| !value.is_finite()) {
                return Err(PlantError::Diverged { run: name, time: from });
            }
        }
        let mut signals = self.logged_commands(&commands, lead, last);
        for one in &working {
            signals.extend(self.logged_samples(one));
        }
        let log = Log { name, kind: self.trial.kind.name(), validates: self.trial.validates, signals, truth };
        Ok((log, wrenches))
    }

    /// Supply voltage, V. It falls over a run and from run to run; its mean over the campaign is
    /// the reference.
    fn supply(&self, t: f64) -> f64 {
        let [reference, fall, spread] = SUPPLY;
        let runs = self.campaign.runs as f64;
        let of_run = spread * ((runs - 1.0) / 2.0 - self.index as f64) / runs.max(2.0);
        reference + of_run + fall * (0.5 - t / self.campaign.duration)
    }

    fn logged_commands(&self, commands: &Commands<'_>, lead: i64, last: i64) -> Vec<Signal> {
        let time: Vec<f64> = (0..=last).map(|k| k as f64 / self.campaign.command_rate).collect();
        let column = |channel: usize| {
            let first = lead as usize;
            (0..=last as usize).map(|k| commands.logged[first + k][channel]).collect()
        };
        let wrench = self.campaign.commands == Commanded::Wrench;
        let names: Vec<(usize, String)> = if wrench {
            Dof::ALL.iter().filter(|d| self.campaign.moves.contains(d)).map(|d| (d.index(), d.force().into())).collect()
        } else {
            (0..self.setup.vehicle.thrusters.len().min(CHANNELS)).map(|k| (k, format!("V{}", k + 1))).collect()
        };
        names.into_iter().map(|(k, name)| Signal { name, time: time.clone(), values: column(k) }).collect()
    }

    fn logged_samples(&self, one: &Working<'_>) -> Vec<Signal> {
        let kept: Vec<(usize, f64)> = one
            .stamps
            .iter()
            .enumerate()
            .map(|(k, t)| (k, t / (1.0 - self.setup.clock_drift)))
            .filter(|(_, t)| (-1e-9..=self.campaign.duration + 1e-9).contains(t))
            .collect();
        let time: Vec<f64> = kept.iter().map(|(_, t)| t.max(0.0)).collect();
        let signal = |(c, values): (usize, &Vec<f64>)| Signal {
            name: one.instrument().channels[c].name.to_string(),
            time: time.clone(),
            values: kept.iter().map(|(k, _)| values[*k]).collect(),
        };
        one.values.iter().enumerate().map(signal).collect()
    }
}

/// Measurements that the pilot has at the time t: the newest sample of each channel, or the true
/// value if there is no sample.
fn seen(working: &[Working<'_>], t: f64, x: &State) -> Seen {
    let mut seen = Seen::default();
    let angles = crate::attitude::angles(&crate::attitude::rotation(crate::plant::quaternion_of(x)));
    for i in 0..6 {
        seen.nu[i] = x[place::NU + i];
        seen.pose[i] = if i < 3 { x[i] } else { angles[i - 3] };
    }
    for one in working {
        for (k, channel) in one.instrument().channels.iter().enumerate() {
            for dof in Dof::ALL {
                let target = match channel.name {
                    name if name == dof.velocity() => &mut seen.nu[dof.index()],
                    name if name == dof.position() => &mut seen.pose[dof.index()],
                    _ => continue,
                };
                if let Some(value) = one.newest(k, t) {
                    *target = value;
                }
            }
        }
    }
    seen
}

/// Sum of the magnitudes of the commanded forces along the body axes, N; 0 for an instrument that
/// it does not disturb.
fn effort(interval: &Interval, t: f64, instrument: &Instrument, believed: &[crate::thruster::Thruster]) -> f64 {
    if instrument.magnetic == 0.0 {
        return 0.0;
    }
    let command = interval.command.map(|(value, slope)| value + slope * (t - interval.from));
    if believed.is_empty() {
        return command[..3].iter().map(|f| f.abs()).sum();
    }
    let forces = believed.iter().zip(command).map(|(thruster, v)| thruster.unit_wrench() * thruster.bollard(v));
    forces.sum::<nalgebra::Vector6<f64>>().fixed_rows::<3>(0).abs().sum()
}
