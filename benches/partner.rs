//! This program's side of the comparison with other packages; `benches/peers/` drives it.
//!
//! A line on standard input names a task. It is done once, and one line of JSON gives the seconds
//! of process CPU and of wall time that it took. `data NAME FOLDER` writes the arrays of a task as
//! little-endian doubles, so that both sides work on the same numbers. Data that is read once and
//! used many times (a compiled model, a prepared run) is prepared beforehand on both sides. Without
//! `--bench` (as in the tests) the tasks run once at a small size, without `discover`.

mod door;
mod planar;

use std::cell::OnceCell;
use std::hint::black_box;
use std::io::{BufRead as _, Write as _};
use std::path::Path;
use std::time::Instant;

use cpu_time::ProcessTime;
use door::Door;
use hydrosysid::chain::Available;
use hydrosysid::discover::{SearchOptions, discover};
use hydrosysid::dynamics::Dynamics;
use hydrosysid::effects::Coriolis;
use hydrosysid::estimate::filter_error::FilterErrorOptions;
use hydrosysid::estimate::output_error::{OutputErrorOptions, output_error};
use hydrosysid::estimate::{Blocks, Names, RegressorOptions, folded, regressors_of, started};
use hydrosysid::frame::Dof;
use hydrosysid::model::{Interpolation, Model};
use hydrosysid::run::{Run, Signal};
use hydrosysid::simulate::{Stretch, Track, free_run, integrate_fast};
use hydrosysid::tank::{BlindOptions, Noise, blind};

/// Trajectories side by side in an ensemble: two of the widest registers, so that one can work
/// while the other waits.
const LANES: usize = 16;

/// Sizes of the tasks.
struct Sizes {
    rows: usize,
    steps: usize,
    seconds: f64,
    sailed: usize,
}

fn main() {
    if !std::env::args().any(|a| a == "--bench") {
        let works = Works::new(&Sizes { rows: 1_000, steps: 100, seconds: 24.0, sailed: 601 });
        let door = ["core_least_squares", "core_simulate", "core_fit"];
        for name in ["least_squares", "bootstrap", "rk4", "ensemble", "output_error"].into_iter().chain(door) {
            works.run(name).expect("a known work");
        }
        return;
    }
    let works = Works::new(&Sizes { rows: 1_000_000, steps: 6_000, seconds: 120.0, sailed: 100_001 });
    for line in std::io::stdin().lock().lines() {
        let line = line.expect("a line of text");
        let answer = match line.split_whitespace().collect::<Vec<_>>()[..] {
            ["data", name, folder] => works.data(name, Path::new(folder)),
            [name] => works.timed(name),
            _ => Err(format!("`{line}` is no work")),
        };
        println!("{}", answer.unwrap_or_else(|why| format!("{{\"error\": {why:?}}}")));
        std::io::stdout().flush().expect("somebody listens");
    }
}

/// Data of all tasks, prepared once.
struct Works {
    columns: (Model, Run),
    few: (Model, Run),
    motion: (Model, Dynamics, Track),
    fit: (Model, Vec<Run>, OutputErrorOptions),
    sailed: usize,
    door: OnceCell<Door>,
}

impl Works {
    fn new(sizes: &Sizes) -> Works {
        Works {
            columns: regression(sizes.rows),
            few: regression(sizes.rows.min(10_001)),
            motion: motion(sizes.steps),
            fit: fit(sizes.seconds),
            sailed: sizes.sailed,
            door: OnceCell::new(),
        }
    }

    fn timed(&self, name: &str) -> Result<String, String> {
        let (cpu, wall) = (ProcessTime::now(), Instant::now());
        let note = self.run(name)?;
        let (cpu, wall) = (cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64());
        Ok(format!("{{\"cpu\": {cpu:e}, \"wall\": {wall:e}, \"note\": {note:?}}}"))
    }

    /// Does one task; the returned text has its result, so that the results of both sides can be compared.
    fn run(&self, name: &str) -> Result<String, String> {
        match name {
            "least_squares" => Ok(self.regress()),
            "bootstrap" => Ok(self.resample()),
            "rk4" => Ok(self.sail()),
            "ensemble" => Ok(self.sail_together()),
            "output_error" => Ok(self.fit_motion()),
            "discover" => Ok(self.find()),
            name => self.door().run(name),
        }
    }

    fn door(&self) -> &Door {
        self.door.get_or_init(|| Door::new(&self.columns, sailed(&planar::model(false), self.sailed, 0)))
    }

    /// Least squares on rows that are folded as they are computed.
    fn regress(&self) -> String {
        let ((model, run), options) = (&self.columns, RegressorOptions::default());
        let rows = folded(Dof::Surge, run, model, options).expect("surge is linear");
        let fit = rows.tall.fit().expect("full rank");
        format!("{:?} cond {:e}", fit.coefficients, fit.condition_number)
    }

    fn resample(&self) -> String {
        let (model, run) = &self.few;
        let columns = regressors_of(Dof::Surge, &[run], model, RegressorOptions::default()).expect("surge is linear");
        let blocks = Blocks::of(&columns.slices(), &columns.rhs, 50, &Names::default()).expect("full rank");
        let draws = blocks.bootstrap(1_000, 1);
        format!("{:?}", (0..5).map(|k| draws.std(k)).collect::<Vec<_>>())
    }

    fn sail(&self) -> String {
        let (model, dynamics, track) = &self.motion;
        let end = free_run(dynamics, track, &model.values(), &[0.0; 4], 0, track.time.len() - 1);
        format!("{:?}", &end.states[end.states.len() - 4..])
    }

    fn sail_together(&self) -> String {
        let (model, dynamics, track) = &self.motion;
        let theta: Vec<[f64; LANES]> = model.values().iter().map(|v| [*v; LANES]).collect();
        let stretches = [Some(Stretch { track: 0, first: 0, last: track.time.len() - 1 }); LANES];
        let mut end = [0.0; LANES];
        integrate_fast(
            dynamics,
            std::slice::from_ref(track),
            &stretches,
            &theta,
            &[[0.0; LANES]; 4],
            false,
            &mut |at| end = at.states[0],
        );
        format!("{end:?}")
    }

    fn fit_motion(&self) -> String {
        let (model, runs, options) = &self.fit;
        let fit = output_error(model, runs, options).expect("a fit");
        format!("{} steps, cost {:.6}", fit.iterations, fit.cost)
    }

    fn find(&self) -> String {
        let campaign = blind(&BlindOptions::default()).expect("the tank sails");
        let base = OutputErrorOptions { position: true, ..OutputErrorOptions::default() };
        let fitting = FilterErrorOptions { base, ..FilterErrorOptions::default() };
        let (cpu, wall) = (ProcessTime::now(), Instant::now());
        let model = campaign.model().expect("a model");
        let found = discover(&model, &campaign.runs, &[], &fitting, &SearchOptions::default()).expect("a fit");
        black_box(&found);
        format!("without the tank: cpu {:e}, wall {:e}", cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64())
    }

    fn data(&self, name: &str, folder: &Path) -> Result<String, String> {
        let signals = |run: &Run, prefix: &str| -> Result<(), String> {
            let first = run.signals.values().next().ok_or("an empty run")?;
            write(folder, &format!("{prefix}t"), first.time())?;
            run.signals.iter().try_for_each(|(name, s)| write(folder, &format!("{prefix}{name}"), s.values()))
        };
        match name {
            "least_squares" => signals(&self.columns.1, "")?,
            "bootstrap" => signals(&self.few.1, "")?,
            "rk4" => {
                signals(&planar::run(self.motion.2.time.len(), 0.1, 0.0), "")?;
                write(folder, "figures", planar::FIGURES.map(|(_, figures)| figures).as_flattened())?;
            }
            "output_error" => {
                let (model, runs, _) = &self.fit;
                for (k, run) in runs.iter().enumerate() {
                    signals(run, &format!("run{k}_"))?;
                }
                write(folder, "start", &model.free().iter().map(|p| model.parameters[*p].value).collect::<Vec<_>>())?;
            }
            "discover" => {
                let campaign = blind(&BlindOptions::default()).map_err(|e| e.to_string())?;
                for (k, run) in campaign.runs.iter().enumerate() {
                    signals(run, &format!("run{k}_"))?;
                }
            }
            "door" => self.door().data(folder)?,
            _ => return Err(format!("`{name}` has no data")),
        }
        Ok("{}".into())
    }
}

fn write(folder: &Path, name: &str, values: &[f64]) -> Result<(), String> {
    let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    std::fs::write(folder.join(format!("{name}.f64")), bytes).map_err(|e| e.to_string())
}

/// Surge with five unknowns: m u̇ + d u + d_q u|u| + b − k v r = τ.
fn regression(rows: usize) -> (Model, Run) {
    let effects = ["inertia@surge", "linear_drag@surge", "quadratic_drag@surge", "bias@surge", "coriolis_surge"];
    let model = Model::with_effects(&[Dof::Surge, Dof::Sway, Dof::Yaw], Coriolis::Free, &effects);
    (model.expect("surge"), planar::run(rows, 0.1, 0.0))
}

fn compiled(model: &Model, run: &Run) -> (Dynamics, Track) {
    let available = Available { channels: run.signals.keys().cloned().collect(), ..Available::default() };
    let observed = ["u", "v", "r", "psi"].map(String::from).into();
    let dynamics = Dynamics::compile(model, &available, &observed, &[]);
    let track = Track::new(run, 0, &dynamics, &model.values(), Interpolation::Linear, 1.0).expect("a complete run");
    (dynamics, track)
}

fn motion(steps: usize) -> (Model, Dynamics, Track) {
    let model = planar::model(true);
    let (dynamics, track) = compiled(&model, &planar::run(steps + 1, 0.1, 0.0));
    (model, dynamics, track)
}

/// Eight runs with 5 mm/s, 3 mrad/s and 5 mrad of noise, and the model at its start from integral
/// least squares. With segments of 8 s and runs of 120 s there are 480 initial states and 11
/// parameters.
fn fit(seconds: f64) -> (Model, Vec<Run>, OutputErrorOptions) {
    let truth = planar::model(false);
    let runs: Vec<Run> = (0..8).map(|k| sailed(&truth, (10.0 * seconds) as usize + 1, k)).collect();
    let mut start = truth.clone();
    for name in ["bias@surge", "bias@yaw"] {
        start.add_named(name).expect("a place for it");
    }
    let sigma = [("u", 0.005), ("v", 0.005), ("r", 0.003), ("psi", 0.005)].map(|(name, s)| (name.to_string(), s));
    (started(&start, &runs), runs, OutputErrorOptions { sigma: Some(sigma.into()), ..OutputErrorOptions::default() })
}

/// Run number `k`, simulated by the model, with noise.
fn sailed(truth: &Model, n: usize, k: u64) -> Run {
    let mut run = planar::run(n, 0.1, 0.7 * k as f64);
    let (dynamics, track) = compiled(truth, &run);
    let motion = free_run(&dynamics, &track, &truth.values(), &[0.3, 0.0, 0.0, 0.0], 0, n - 1);
    let mut noise = Noise::new(7, k);
    for (column, (name, sigma)) in [("u", 0.005), ("v", 0.005), ("r", 0.003), ("psi", 0.005)].into_iter().enumerate() {
        let values: Vec<f64> =
            motion.states.iter().skip(column).step_by(4).map(|x| x + sigma * noise.normal()).collect();
        let time = run.signals["tau_u"].shared_time().clone();
        run.signals.insert(name.into(), Signal::new(time, values));
    }
    run
}
