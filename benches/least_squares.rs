//! Time of the linear solver: `cargo bench --bench least_squares`.
//!
//! The system is that of surge, 1e6 rows by 5, integrated from arrays by the trapezoidal rule. Each
//! figure is the median wall time of nine runs, on one thread and on all. Compare only figures of
//! one run with each other. Without `--bench` (as in the tests) a small system runs once.

mod timed;

use std::hint::black_box;

use hydrosysid::estimate::{Blocks, Names, least_squares};

/// Rows of a block of the bootstrap.
const BLOCK: usize = 100;

fn main() {
    let thorough = std::env::args().any(|a| a == "--bench");
    let (n, small, draws, repeats) = if thorough { (1_000_000, 10_000, 1_000, 9) } else { (10_000, 1_000, 20, 1) };
    for threads in [1, rayon::current_num_threads()] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        println!("{threads} threads");
        pool.install(|| {
            let channels = channels(n);
            report("trapezoid columns", n, repeats, || {
                black_box(trapezoid(&channels));
            });
            let (h, y) = trapezoid(&channels);
            let h: Vec<&[f64]> = h.iter().map(Vec::as_slice).collect();
            report("least squares, std, both conditions", n, repeats, || {
                black_box(least_squares(&h, &y).expect("full rank"));
            });
            let cut: Vec<&[f64]> = h.iter().map(|c| &c[..small]).collect();
            report("block bootstrap, factors and refits", small, repeats, || {
                let blocks = Blocks::of(&cut, &y[..small], BLOCK, &Names::default()).expect("blocks");
                black_box(blocks.bootstrap(draws, 1));
            });
        });
    }
}

fn report(part: &str, rows: usize, repeats: usize, work: impl FnMut()) {
    println!("  {part:38} {rows:>9} rows {:>10.3} ms", 1e3 * timed::median(repeats, work));
}

/// u, v, r, τ at 10 Hz, all varying.
fn channels(n: usize) -> [Vec<f64>; 4] {
    let wave = |offset: f64, amplitude: f64, rate: f64| -> Vec<f64> {
        (0..n).map(|k| offset + amplitude * (0.1 * rate * k as f64).sin() * (0.013 * k as f64).cos()).collect()
    };
    [wave(0.5, 0.3, 0.21), wave(0.1, 0.2, 0.37), wave(0.0, 0.3, 0.53), wave(180.0, 140.0, 0.22)]
}

/// Columns Δu, −∫v r, ∫u, ∫u|u|, ∫1 and right-hand side ∫τ of each interval.
fn trapezoid([u, v, r, tau]: &[Vec<f64>; 4]) -> (Vec<Vec<f64>>, Vec<f64>) {
    const STEP: f64 = 0.1;
    let integral = |f: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let mut last = f(0);
        (1..u.len())
            .map(|k| {
                let next = f(k);
                let area = 0.5 * STEP * (last + next);
                last = next;
                area
            })
            .collect()
    };
    let increments = u.windows(2).map(|u| u[1] - u[0]).collect();
    let columns = vec![
        increments,
        integral(&|k| -v[k] * r[k]),
        integral(&|k| u[k]),
        integral(&|k| u[k] * u[k].abs()),
        vec![STEP; u.len() - 1],
    ];
    (columns, integral(&|k| tau[k]))
}
