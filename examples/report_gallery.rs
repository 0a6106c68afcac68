//! Writes a report with one block of every kind to the given path, and its first figure as a
//! separate file beside it:
//!
//! ```text
//! cargo run --example report_gallery -- gallery.html
//! ```
//!
//! The numbers are synthetic, of the size of a vehicle of 190 kg in a pool.

use std::f64::consts::TAU;
use std::path::Path;
use std::{env, fs, io};

use hydrosysid::report::{
    Axis, Bar, Bars, Block, Cell, Chart, Check, Colours, Column, Curves, Definition, Document, Equation, Figure,
    Forest, ForestRow, HeatMap, Input, Interval, Label, Light, Origin, Panel, Section, Series, Span, Table, render,
    svg, terminal,
};

fn main() -> io::Result<()> {
    let Some(path) = env::args().nth(1) else {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "usage: report_gallery FILE.html"));
    };
    let (surge, curves) = surge_run();
    fs::write(&path, render(&document(surge.clone())))?;
    fs::write(Path::new(&path).with_extension("svg"), svg::standalone(&surge))?;
    print!("{}", terminal::plot(&curves, 78, 18));
    Ok(())
}

/// Repeatable pseudo-random noise, about normal with standard deviation 1: sums of twelve uniform
/// numbers minus 6.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}

/// m_u u̇ = τ − k_u u − k_u|u| |u| u by Euler steps at 20 Hz; `astern` is a factor on the quadratic
/// drag for u < 0.
fn surge_motion(astern: f64) -> (Vec<f64>, Vec<f64>) {
    let (mut time, mut speed, mut u) = (Vec::new(), Vec::new(), 0.0_f64);
    for k in 0..2400 {
        let t = 0.05 * f64::from(k);
        time.push(t);
        speed.push(u);
        let thrust = 14.0 + 62.0 * (TAU * t / 28.0).sin();
        let drag = if u < 0.0 { 309.0 * astern } else { 309.0 };
        u += 0.05 * (thrust - 21.0 * u - drag * u.abs() * u) / 421.0;
    }
    (time, speed)
}

fn surge_run() -> (Figure, Curves) {
    let mut noise = Noise(7);
    let ((time, truth), (_, simulated)) = (surge_motion(1.22), surge_motion(1.0));
    let measured: Vec<f64> = truth.iter().map(|u| u + 0.009 * noise.next()).collect();
    let residual: Vec<f64> = measured.iter().zip(&simulated).map(|(m, s)| m - s).collect();
    let interval = simulated.iter().map(|u| (u - 0.008 - 0.03 * u.abs(), u + 0.008 + 0.03 * u.abs())).collect();
    let curves = Curves {
        x: Axis::new("Time", "s"),
        panels: vec![
            Panel {
                y: Axis::new(Label::symbol("Surge velocity u"), "m/s"),
                series: vec![
                    Series::points("measured", time.clone(), measured),
                    Series::line("simulated, 95 %", time.clone(), simulated).with_interval(interval),
                ],
                floor: None,
            },
            Panel {
                y: Axis::new("Measured − simulated", "m/s"),
                series: vec![Series::points("", time.clone(), residual), Series::line("", vec![], vec![])],
                floor: Some(0.018),
            },
        ],
        spans: vec![
            Span { from: 18.6, to: 30.8, label: "astern: above the noise floor".into() },
            Span { from: 46.6, to: 58.8, label: "astern: above the noise floor".into() },
            Span { from: 74.6, to: 86.8, label: "astern: above the noise floor".into() },
            Span { from: 102.6, to: 114.8, label: "astern: above the noise floor".into() },
        ],
    };
    let figure = Figure {
        title: "Surge run surge_p28, held out: measured and simulated".into(),
        caption: "The strip below shows the difference; the grey band is twice the sensor noise. Ahead the model \
                  is as good as the sensor. Astern it is not."
            .into(),
        chart: Chart::Curves(curves.clone()),
    };
    (figure, curves)
}

fn drag_curve() -> Figure {
    let mut noise = Noise(11);
    let law = |u: f64| 21.0 * u + 309.0 * u * u.abs();
    let fine: Vec<f64> = (-60..=60).map(|k| f64::from(k) / 100.0).collect();
    let drag = fine.iter().map(|u| law(*u)).collect();
    let interval = fine.iter().map(|u| (law(*u) - 1.5 - 24.0 * u * u, law(*u) + 1.5 + 24.0 * u * u)).collect();
    let steady: Vec<f64> = (-11..=11).filter(|k| *k != 0).map(|k| 0.05 * f64::from(k)).collect();
    let force: Vec<f64> = steady.iter().map(|u| law(*u) * (1.0 + 0.04 * noise.next()) + 0.8 * noise.next()).collect();
    let errors = steady.iter().zip(&force).map(|(u, f)| (f - 3.0 - 14.0 * u * u, f + 3.0 + 14.0 * u * u)).collect();
    let paper = fine.iter().map(|u| 0.93 * 309.0 * u * u.abs() + 17.0 * u).collect();
    let series = vec![
        Series::line("fitted law, 95 %", fine.clone(), drag).with_interval(interval),
        Series::line("former model", fine, paper),
        Series::points("steady towing, 95 %", steady, force).with_interval(errors),
    ];
    let panel = Panel { y: Axis::new("Drag", "N"), series, floor: None };
    Figure {
        title: "Drag in surge against speed".into(),
        caption: String::new(),
        chart: Chart::Curves(Curves { x: Axis::new("Surge velocity", "m/s"), panels: vec![panel], spans: Vec::new() }),
    }
}

fn waterfall() -> Figure {
    let bar = |label: &str, value: f64, std: Option<f64>, total: bool| Bar { label: label.into(), value, std, total };
    Figure {
        title: "What each added effect takes from the held-out error".into(),
        caption: "Free simulation of runs that took no part in the fit.".into(),
        chart: Chart::Bars(Bars {
            axis: Axis::new("Root mean square error, yaw rate", "mrad/s"),
            bars: vec![
                bar("Baseline, refitted", 41.3, Some(2.1), true),
                bar("Coriolis in yaw", -22.4, Some(1.8), false),
                bar("Thruster lag", -9.7, Some(1.1), false),
                bar("Tether", 0.4, Some(0.6), false),
                bar("With all three", 9.6, Some(0.8), true),
            ],
            waterfall: true,
            reference: Some(("noise floor of the gyro".into(), 8.1)),
        }),
    }
}

const NAMES: [&str; 7] = ["m_u", "m_v", "m_r", "k_u", "k_u|u|", "k_v|v|", "k_uv"];

fn correlations() -> Figure {
    let names: Vec<Label> = NAMES.iter().map(|n| Label::symbol(*n)).collect();
    let entry = |r: usize, c: usize| match (r.min(c), r.max(c)) {
        (a, b) if a == b => 1.0,
        (3, 4) => -0.94,
        (1, 6) => 0.71,
        (0, 6) => -0.38,
        (a, b) => 0.3 * ((a * 7 + b * 3) as f64).sin(),
    };
    Figure {
        title: "Correlation of the estimates".into(),
        caption: "Linear and quadratic drag in surge can hardly be told apart from these runs: a slower one would."
            .into(),
        chart: Chart::HeatMap(HeatMap {
            x: Axis::new("", ""),
            y: Axis::new("", ""),
            columns: names.clone(),
            rows: names,
            values: (0..7).map(|r| (0..7).map(|c| entry(r, c)).collect()).collect(),
            value: Axis::new("Correlation", ""),
            decimals: 2,
            colours: Colours::Diverging { limit: 1.0 },
        }),
    }
}

fn cross_validation() -> Figure {
    let runs = ["surge_p28.csv", "surge_p40.csv", "sway_p35.csv", "zigzag_15.csv", "zigzag_30.csv"];
    let error = |r: usize, c: usize| {
        if r == 2 && c == 2 { f64::NAN } else { 8.0 + 1.5 * (r as f64 - c as f64).abs().powf(1.7) + (r * c % 3) as f64 }
    };
    Figure {
        title: "Error on a run after fitting to another".into(),
        caption: String::new(),
        chart: Chart::HeatMap(HeatMap {
            x: Axis::new("judged on", ""),
            y: Axis::new("fitted to", ""),
            columns: runs.iter().map(|r| Label::from(*r)).collect(),
            rows: runs.iter().map(|r| Label::from(*r)).collect(),
            values: (0..5).map(|r| (0..5).map(|c| error(r, c)).collect()).collect(),
            value: Axis::new("Root mean square error", "mm/s"),
            decimals: 1,
            colours: Colours::Sequential { low: 6.0, high: 26.0 },
        }),
    }
}

fn forest() -> Figure {
    let sources = [("least squares", 0.08), ("output error", 0.035), ("printed in the paper", 0.06)];
    let scale = [421.0, 588.0, 46.3, 21.0, 309.0, 643.0, -167.0];
    let units = ["kg", "kg", "kg*m^2", "kg/s", "kg/m", "kg/m", "kg"];
    let rows = NAMES.iter().enumerate().map(|(r, name)| {
        let estimates = sources.iter().enumerate().map(|(k, (source, half))| {
            let half = half * if r == 3 { 2.6 } else { 1.0 };
            let value = 1.0 + half * ((r * 5 + k * 3) as f64).sin();
            let text = hydrosysid::report::estimate(
                value * scale[r],
                Some(0.5 * half * scale[r]),
                hydrosysid::report::Style::Text,
            );
            let text = format!("{text} {}", hydrosysid::report::unit(units[r]));
            Interval { source: (*source).into(), value, low: value - half, high: value + half, text }
        });
        ForestRow { label: Label::symbol(*name), estimates: estimates.collect() }
    });
    Figure {
        title: "Estimates by source, with 95 % intervals".into(),
        caption: "Each relative to the value that simulated the data.".into(),
        chart: Chart::Forest(Forest {
            axis: Axis::new("Estimate / true value", ""),
            rows: rows.collect(),
            reference: Some(1.0),
        }),
    }
}

fn estimates() -> Table {
    let row = |name: &str, meaning: &str, value: f64, std: Option<f64>, unit: &str| {
        vec![
            Cell::Text(Label::symbol(name)),
            meaning.into(),
            Cell::Estimate { value, std },
            Cell::Text(hydrosysid::report::unit(unit).into()),
            std.map_or(Cell::Empty, |std| Cell::Number { value: 100.0 * std / value.abs(), digits: 2 }),
        ]
    };
    Table {
        title: "Parameters of the model, with one standard deviation".into(),
        columns: vec![
            Column::new("Symbol", ""),
            Column::new("Meaning", ""),
            Column::new("Value", ""),
            Column::new("Unit", ""),
            Column::new("Relative", "%"),
        ],
        rows: vec![
            row("m_u", "virtual mass in surge", 421.3, Some(6.2), "kg"),
            row("m_v", "virtual mass in sway", 588.0, Some(14.0), "kg"),
            row("m_r", "virtual moment of inertia in yaw", 46.31, Some(0.87), "kg*m^2"),
            row("k_u", "linear drag in surge", 21.0, Some(5.5), "kg/s"),
            row("k_u|u|", "quadratic drag in surge", 309.07, Some(18.8), "kg/m"),
            row("k_uv", "Coriolis in yaw", -166.7, Some(12.3), "kg"),
            row("T", "time constant of the thrusters", 0.25, None, "s"),
        ],
        note: "Standard deviations allow for correlated residuals. T was held.".into(),
    }
}

fn document(surge: Figure) -> Document {
    let check = |light, code: &str, text: &str| Check { light, code: code.into(), text: text.into() };
    let equation = |formula: &str, note: &str| Equation { formula: formula.into(), note: note.into() };
    let define = |term: &str, meaning: &str| Definition { term: Label::symbol(term), meaning: meaning.into() };
    let input = |name: &str, digit: &str| Input { name: name.into(), sha256: digit.repeat(16) };
    Document {
        title: "Identification of a vehicle in surge, sway and yaw".into(),
        subtitle: "Gallery of the report · synthetic data · 190 kg, 0.58 m".into(),
        verdict: "The model predicts held-out runs to within the noise of the sensors ahead and in turns; astern, \
                  drag is 22 % larger than it says."
            .into(),
        checks: vec![
            check(Light::Green, "held_out", "Held-out error is at the noise floor in sway and yaw."),
            check(Light::Amber, "correlated", "Linear and quadratic drag in surge are correlated: −0.94."),
            check(Light::Red, "astern", "Astern the residual is four times the noise; see Figure 1."),
        ],
        first_screen: vec![Block::Figure(surge), Block::Figure(waterfall()), Block::Table(estimates())],
        sections: vec![
            Section {
                heading: "Prediction of a run that took no part in the fit".into(),
                paragraphs: vec![
                    "The vehicle was driven by a sinusoidal thrust about an offset. The model was started from the \
                     state of the first second and then ran free, with the logged commands as its only input."
                        .into(),
                ],
                blocks: vec![Block::Figure(drag_curve())],
                ..Section::default()
            },
            Section {
                heading: "The model".into(),
                paragraphs: Vec::new(),
                blocks: vec![
                    Block::Equations(vec![
                        equation("m_u·u̇ = τ_u − k_u·u − k_u|u|·|u|·u + m_v·v·r", "surge"),
                        equation("m_r·ṙ = τ_r − k_r|r|·|r|·r + k_uv·u·v", "yaw; the Coriolis coefficient is free"),
                    ]),
                    Block::Definitions(vec![
                        define("m_u", "virtual mass in surge: dry mass and the water that moves with it, kg"),
                        define("k_u|u|", "quadratic drag in surge, kg/m; in SNAME's notation with the opposite sign"),
                    ]),
                    Block::Figure(forest()),
                ],
                ..Section::default()
            },
            Section {
                heading: "What the data can and cannot tell".into(),
                paragraphs: Vec::new(),
                blocks: vec![Block::Figure(correlations()), Block::Figure(cross_validation())],
                ..Section::default()
            },
        ],
        origin: Origin {
            version: concat!("hydrosysid ", env!("CARGO_PKG_VERSION")).into(),
            command: "hydrosysid report campaign.toml --output report.html".into(),
            inputs: vec![input("campaign.toml", "a1f0"), input("surge_p28.csv", "09be")],
            seed: Some(7),
        },
    }
}
