//! Growth of time and memory with size: one task of one size in a process of its own, so that the
//! peak memory of the process is that of the task.
//!
//! `growth --bench TASK SIZE` does the task and prints a line of JSON: seconds of process CPU and
//! of wall time, medians of the repetitions within one second. `benches/peers/` calls it and reads
//! the memory of the process. `growth --bench log ROWS FOLDER` writes a campaign with a log of this
//! many rows. Without `--bench` (as in the tests) every task is done once at a small size.

mod planar;

use std::fs::File;
use std::hint::black_box;
use std::io::{BufWriter, Write as _};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use cpu_time::ProcessTime;
use hydrosysid::chain::Available;
use hydrosysid::dynamics::Dynamics;
use hydrosysid::effects::{Coriolis, FormulaEffect, Place};
use hydrosysid::estimate::output_error::{OutputErrorOptions, output_error};
use hydrosysid::estimate::{Names, RegressorOptions, StreamingQr, folded, least_squares, regressors_of, started};
use hydrosysid::formula::Formula;
use hydrosysid::frame::Dof;
use hydrosysid::model::{Interpolation, Model};
use hydrosysid::run::{Run, Signal};
use hydrosysid::simd::widest;
use hydrosysid::simulate::{Stretch, Track, free_run, integrate_fast};
use hydrosysid::units::Dimension;

/// Rows that are generated and folded at once.
const BLOCK: usize = 1 << 20;

/// Trajectories side by side.
const LANES: usize = 16;

/// Names of the tasks, each with its size in the tests.
const WORKS: [(&str, usize); 9] = [
    ("kept", 1_000),
    ("folded", 1_000),
    ("streamed", 1_000),
    ("effects", 5),
    ("runs", 1),
    ("rk4", 100),
    ("ensemble", 100),
    ("copy", 1_000),
    ("arithmetic", 1_000),
];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let number = |text: &str| text.parse().expect("a number");
    match &arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["log", rows, folder] => write_campaign(Path::new(folder), number(rows)).expect("a folder to write into"),
        [work, size] => println!("{}", done(work, number(size))),
        _ => WORKS.iter().for_each(|(work, size)| drop(done(work, *size))),
    }
}

/// Does a task of this size.
fn done(work: &str, size: usize) -> String {
    match work {
        "kept" => kept(size),
        "folded" => one_fold(size),
        "streamed" => streamed(size),
        "effects" => effects(size),
        "runs" => runs(size),
        "rk4" => rk4(size),
        "ensemble" => ensemble(size),
        "copy" => copy(size),
        "arithmetic" => arithmetic(size),
        _ => panic!("`{work}` is no work"),
    }
}

/// Median CPU and wall time of `work`, which is repeated up to nine times within a second.
fn timed(mut work: impl FnMut()) -> String {
    let (mut cpu, mut wall) = (Vec::new(), Vec::new());
    let begin = Instant::now();
    // a count of instructions needs a fixed number of passes
    let asked: Option<usize> = std::env::var("PASSES").ok().and_then(|n| n.parse().ok());
    let wanted = |passes: usize| match asked {
        Some(n) => passes < n,
        None => passes == 0 || (passes < 9 && begin.elapsed().as_secs_f64() < 1.0),
    };
    while wanted(cpu.len()) {
        let (used, passed) = (ProcessTime::now(), Instant::now());
        work();
        cpu.push(used.elapsed().as_secs_f64());
        wall.push(passed.elapsed().as_secs_f64());
    }
    answer(&mut cpu, &mut wall)
}

fn answer(cpu: &mut [f64], wall: &mut [f64]) -> String {
    cpu.sort_by(f64::total_cmp);
    wall.sort_by(f64::total_cmp);
    format!("{{\"cpu\": {:e}, \"wall\": {:e}}}", cpu[cpu.len() / 2], wall[wall.len() / 2])
}

/// Surge with five unknowns.
fn surge() -> Model {
    let effects = ["inertia@surge", "linear_drag@surge", "quadratic_drag@surge", "bias@surge", "coriolis_surge"];
    Model::with_effects(&[Dof::Surge, Dof::Sway, Dof::Yaw], Coriolis::Free, &effects).expect("surge")
}

/// Writes a campaign of surge with five unknowns and one log of seven columns, with six decimals as
/// usual in logs.
fn write_campaign(folder: &Path, rows: usize) -> std::io::Result<()> {
    const CAMPAIGN: &str = "format = 1\n[vehicle]\nname = \"bench\"\nmass = 400.0\nvolume = 0.4\n\
        [model]\ndofs = [\"surge\", \"sway\", \"yaw\"]\ncoriolis = \"free\"\n\
        effects = [\"inertia\", \"linear_drag@surge\", \"quadratic_drag@surge\", \"bias@surge\", \"coriolis_surge\"]\n\
        [fit]\nestimator = \"integral\"\n[[run]]\nfile = \"log.csv\"\nkind = \"free\"\nrole = \"train\"\n";
    std::fs::write(folder.join("campaign.toml"), CAMPAIGN)?;
    let mut log = BufWriter::new(File::create(folder.join("log.csv"))?);
    writeln!(log, "t,u,v,r,tau_u,tau_v,tau_r")?;
    for begin in (0..rows).step_by(BLOCK) {
        let run = planar::run(BLOCK.min(rows - begin), 0.1, 1e-3 * begin as f64);
        let channels = ["u", "v", "r", "tau_u", "tau_v", "tau_r"].map(|name| run.signals[name].values());
        for k in 0..channels[0].len() {
            write!(log, "{:.1}", 0.1 * (begin + k) as f64)?;
            channels.iter().try_for_each(|x| write!(log, ",{:.6}", x[k]))?;
            writeln!(log)?;
        }
    }
    log.flush()
}

/// Least squares on columns that are kept in memory.
fn kept(rows: usize) -> String {
    let (model, run) = (surge(), planar::run(rows + 1, 0.1, 0.0));
    timed(|| {
        let columns = regressors_of(Dof::Surge, &[&run], &model, RegressorOptions::default()).expect("linear");
        black_box(least_squares(&columns.slices(), &columns.rhs).expect("full rank"));
    })
}

/// Least squares on the rows of one run, which are folded as they are computed.
fn one_fold(rows: usize) -> String {
    let (model, run) = (surge(), planar::run(rows + 1, 0.1, 0.0));
    timed(|| {
        let folded = folded(Dof::Surge, &run, &model, RegressorOptions::default()).expect("linear");
        black_box(folded.tall.fit().expect("full rank"));
    })
}

/// Least squares on rows that are generated block by block and folded as they are computed; the
/// generation is not timed.
fn streamed(rows: usize) -> String {
    let model = surge();
    let mut whole = StreamingQr::new(5, Names::default()).expect("columns");
    let (mut cpu, mut wall) = (0.0, 0.0);
    for begin in (0..rows).step_by(BLOCK) {
        let run = planar::run(BLOCK.min(rows - begin) + 1, 0.1, 1e-3 * begin as f64);
        let (used, passed) = (ProcessTime::now(), Instant::now());
        let block = folded(Dof::Surge, &run, &model, RegressorOptions::default()).expect("linear");
        whole.merge(block.tall).expect("as wide");
        cpu += used.elapsed().as_secs_f64();
        wall += passed.elapsed().as_secs_f64();
    }
    black_box(whole.fit().expect("full rank"));
    answer(&mut [cpu], &mut [wall])
}

/// Least squares on ten thousand rows with this many unknowns: inertia, and user formulas that all differ.
fn effects(count: usize) -> String {
    let mut model = Model::with_effects(&[Dof::Surge], Coriolis::Tied, &["inertia@surge"]).expect("surge");
    for k in 1..count {
        let text = format!("u*sin({}*t)", 0.017 * k as f64);
        let formula = Formula::parse(&text).expect("a formula");
        let effect = FormulaEffect::new(&format!("own_{k}"), Dof::Surge, formula, Dimension::ONE);
        model.add(Arc::new(effect), Place::at(Dof::Surge)).expect("a place");
    }
    let run = planar::run(10_001, 0.1, 0.0);
    timed(|| {
        let rows = folded(Dof::Surge, &run, &model, RegressorOptions::default()).expect("linear");
        black_box(rows.tall.fit().expect("full rank"));
    })
}

/// Output error on this many runs of 60 s, with 9 parameters and an initial state every 8 s.
fn runs(count: usize) -> String {
    let truth = planar::model(false);
    let runs: Vec<Run> = (0..count).map(|k| sailed(&truth, 601, 0.7 * k as f64)).collect();
    let sigma = ["u", "v", "r"].map(|name| (name.to_string(), 0.005));
    let options = OutputErrorOptions { sigma: Some(sigma.into()), ..OutputErrorOptions::default() };
    let start = started(&truth, &runs);
    timed(|| drop(black_box(output_error(&start, &runs, &options).expect("a fit"))))
}

/// A run simulated by the model, with a ripple of up to 5 mm/s (mrad/s) on the measured channels.
fn sailed(truth: &Model, n: usize, phase: f64) -> Run {
    let mut run = planar::run(n, 0.1, phase);
    let (dynamics, track) = compiled(truth, &run);
    let motion = free_run(&dynamics, &track, &truth.values(), &[0.3, 0.0, 0.0], 0, n - 1);
    for (column, name) in ["u", "v", "r"].into_iter().enumerate() {
        let ripple = |k: usize| 0.005 * ((12.9898 * (k + 7 * column) as f64 + phase).sin() * 43_758.547 % 1.0);
        let values: Vec<f64> =
            motion.states.iter().skip(column).step_by(3).enumerate().map(|(k, x)| x + ripple(k)).collect();
        let time = run.signals["tau_u"].shared_time().clone();
        run.signals.insert(name.into(), Signal::new(time, values));
    }
    run
}

fn compiled(model: &Model, run: &Run) -> (Dynamics, Track) {
    let available = Available { channels: run.signals.keys().cloned().collect(), ..Available::default() };
    let observed = ["u", "v", "r"].map(String::from).into();
    let dynamics = Dynamics::compile(model, &available, &observed, &[]);
    let track = Track::new(run, 0, &dynamics, &model.values(), Interpolation::Linear, 1.0).expect("a complete run");
    (dynamics, track)
}

/// One trajectory of this many steps.
fn rk4(steps: usize) -> String {
    let model = planar::model(true);
    let (dynamics, track) = compiled(&model, &planar::run(steps + 1, 0.1, 0.0));
    timed(|| drop(black_box(free_run(&dynamics, &track, &model.values(), &[0.0; 3], 0, steps))))
}

/// Sixteen trajectories of this many steps.
fn ensemble(steps: usize) -> String {
    let model = planar::model(true);
    let (dynamics, track) = compiled(&model, &planar::run(steps + 1, 0.1, 0.0));
    let theta: Vec<[f64; LANES]> = model.values().iter().map(|v| [*v; LANES]).collect();
    let stretches = [Some(Stretch { track: 0, first: 0, last: steps }); LANES];
    timed(|| {
        let mut end = [0.0; LANES];
        let tracks = std::slice::from_ref(&track);
        integrate_fast(&dynamics, tracks, &stretches, &theta, &[[0.0; LANES]; 3], false, &mut |at| end = at.states[0]);
        black_box(end);
    })
}

/// Copies this many numbers, to measure the memory bandwidth: 16 bytes for each number.
fn copy(count: usize) -> String {
    let (from, mut to) = (vec![1.0_f64; count], vec![0.0_f64; count]);
    timed(|| {
        to.copy_from_slice(black_box(&from));
        black_box(&mut to);
    })
}

/// Does this many times 64 multiply-adds in eight independent registers, to measure the rate of arithmetic.
fn arithmetic(count: usize) -> String {
    timed(|| {
        let sums = widest(
            #[inline(always)]
            || {
                let mut sums = [[1.0_f64; 8]; 8];
                let factor = black_box([0.999_f64; 8]);
                for _ in 0..count {
                    for sum in &mut sums {
                        *sum = std::array::from_fn(|i| sum[i].mul_add(factor[i], 1e-3));
                    }
                }
                sums
            },
        );
        black_box(sums);
    })
}
