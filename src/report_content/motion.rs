//! The part of the report about motion: measured and simulated velocities with their residual, and
//! the residual against each state, where a missing effect appears as a systematic shape.

use super::discovery::widest;
use super::{COVER, Results};
use crate::campaign::{self, Simulated};
use crate::compare::Disagreement;
use crate::frame::Dof;
use crate::report::{Axis, Block, Chart, Curves, Figure, Label, Multiples, Panel, Section, Series};
use crate::run::Role;

/// Number of runs that are shown large, held-out ones first.
const SHOWN: usize = 4;
/// Number of groups of samples whose median and quartiles are drawn against a state.
const GROUPS: usize = 12;
/// Maximum number of points of a panel against a state.
const POINTS: usize = 600;

/// The sections of a report.
pub(super) fn sections(results: &Results<'_>) -> Vec<Section> {
    let runs = in_order(results);
    let held: Vec<&Simulated> = runs.iter().copied().filter(|r| r.role == Role::Validate).collect();
    let of_run = |run: &&Simulated| -> Vec<Block> {
        let figure = |dof: &Dof| {
            let channel = measured_motion(run, *dof).0;
            let floor = noise(results, &run.run, channel);
            let measured: Vec<f64> = samples(run, channel).iter().map(|s| s.1).collect();
            motion_figure(run, *dof, floor).filter(|_| moves(&measured, floor)).map(Block::Figure)
        };
        results.fit.model.dofs.iter().filter_map(figure).collect()
    };
    let blocks = runs.iter().take(SHOWN).flat_map(of_run).collect();
    let (judged, which) = if held.is_empty() { (&runs, "all runs") } else { (&held, "runs that took no part") };
    let against: Vec<Block> = against_states(results, judged, which).into_iter().map(Block::Figure).collect();
    let all: Vec<Block> = results.fit.model.dofs.iter().filter_map(|dof| side_by_side(results, &runs, *dof)).collect();
    let every = Section { heading: "All runs".into(), paragraphs: Vec::new(), blocks: all, folded: false };
    let motion = Section { heading: "Measured and simulated".into(), paragraphs: Vec::new(), blocks, folded: true };
    let residual = Section {
        heading: "Residual against each state".into(),
        paragraphs: vec![
            "Noise scatters flat about zero. A slope, a step or a curve shows which state the missing force depends \
             on."
            .into(),
        ],
        blocks: against,
        folded: true,
    };
    [every, motion, residual].into_iter().filter(|section| !section.blocks.is_empty()).collect()
}

/// All runs that move in `dof`, small, side by side; `None` if no run does.
fn side_by_side(results: &Results<'_>, runs: &[&Simulated], dof: Dof) -> Option<Block> {
    let small = |run: &&Simulated| {
        let (channel, unit) = measured_motion(run, dof);
        let samples = samples(run, channel);
        let measured: Vec<f64> = samples.iter().map(|s| s.1).collect();
        if samples.is_empty() || !moves(&measured, noise(results, &run.run, channel)) {
            return None;
        }
        let time: Vec<f64> = samples.iter().map(|s| s.0).collect();
        let simulated = Series::line("", run.time.clone(), run.simulated[channel].clone());
        // without names there is no legend: the caption explains points and line
        let series = vec![Series::points("", time, measured), simulated];
        let panel = Panel { y: Axis::new(Label::symbol(channel), unit), series, floor: None };
        let chart = Chart::Curves(Curves { x: Axis::new("time", "s"), panels: vec![panel], spans: Vec::new() });
        let held = if run.role == Role::Validate { ", held out" } else { "" };
        Some(Figure { title: format!("{}{held}", super::stem(&run.run)), caption: String::new(), chart })
    };
    let figures: Vec<Figure> = runs.iter().filter_map(small).collect();
    let caption = "Points: measured. Line: simulated from a state estimated on the first seconds.".to_string();
    (!figures.is_empty())
        .then(|| Block::Multiples(Multiples { title: format!("All runs that move in {dof}"), caption, figures }))
}

/// The worst run among those that move, in one degree of freedom, with the simulation of the model
/// without the added effects. Held-out runs come first, then the degree of freedom in which most
/// was missing.
pub(super) fn worst(results: &Results<'_>) -> Option<Figure> {
    let run_of = |r: &Disagreement| results.simulation.runs.iter().find(|run| run.run == r.run);
    let is_moving = |r: &Disagreement, of: fn(&(f64, f64, f64)) -> f64| {
        let motion = |run, dof| samples(run, measured_motion(run, dof).0).iter().map(of).collect::<Vec<f64>>();
        run_of(r).zip(r.dof.along()).is_some_and(|(run, dof)| moves(&motion(run, dof), Some(r.noise_floor)))
    };
    let missing = results.discovery.filter(|found| !found.effects.is_empty()).and_then(widest);
    let rank = |r: &Disagreement| {
        let times_noise = r.rms / r.noise_floor.max(f64::MIN_POSITIVE);
        // a motion that only the water causes says nothing about the model
        let is_driven = is_moving(r, |s| s.2);
        ((r.role == Role::Validate, missing.as_ref() == Some(&r.dof), is_driven), times_noise)
    };
    let moving = results.comparison.runs.iter().filter(|r| is_moving(r, |s| s.1)).map(|r| (rank(r), r));
    let (_, worst) = moving.max_by(|(a, _), (b, _)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)))?;
    let (run, dof) = run_of(worst).zip(worst.dof.along())?;
    let mut figure = motion_figure(run, dof, Some(worst.noise_floor))?;
    figure.title = format!("The worst run: {}", figure.title);
    if let (Chart::Curves(curves), Some(before)) = (&mut figure.chart, without_names(results, &worst.run)) {
        let channel = measured_motion(run, dof).0;
        if let Some(values) = before.simulated.get(channel) {
            curves.panels[0].series.push(Series::line("without what was missing", before.time.clone(), values.clone()));
        }
    }
    Some(figure)
}

/// A run simulated with the baseline of a search that added effects.
fn without_names(results: &Results<'_>, run: &str) -> Option<Simulated> {
    let found = results.discovery.filter(|found| !found.effects.is_empty())?;
    let baseline = &found.steps.first()?.fit.model;
    let mut alone = results.campaign.under(&results.fit.efficiency);
    alone.runs.retain(|r| r.name == run);
    campaign::simulate(&alone, baseline, &results.fit.envelope).ok()?.runs.pop()
}

/// Held-out runs first, then one run of each kind, then the others.
fn in_order<'a>(results: &Results<'a>) -> Vec<&'a Simulated> {
    let kind = |run: &Simulated| results.campaign.runs.iter().find(|r| r.name == run.run).map(|r| r.kind);
    let mut seen = Vec::new();
    let mut ranked: Vec<(u8, &Simulated)> = Vec::new();
    for run in &results.simulation.runs {
        let first = !seen.contains(&kind(run));
        seen.push(kind(run));
        let rank = match (run.role, first) {
            (Role::Validate, _) => 0,
            (_, true) => 1,
            (_, false) => 2,
        };
        ranked.push((rank, run));
    }
    ranked.sort_by_key(|(rank, _)| *rank);
    ranked.into_iter().map(|(_, run)| run).collect()
}

/// Whether the range of a velocity is more than `WIDTH` times the noise of its sensor.
pub(super) fn moves(velocity: &[f64], noise: Option<f64>) -> bool {
    const WIDTH: f64 = 12.0;
    let finite = || velocity.iter().copied().filter(|v| v.is_finite());
    let width = finite().fold(f64::NEG_INFINITY, f64::max) - finite().fold(f64::INFINITY, f64::min);
    width > WIDTH * noise.unwrap_or(0.0)
}

fn unit_of(dof: Dof) -> &'static str {
    if dof.is_rotation() { "rad/s" } else { "m/s" }
}

/// Measured samples (t, y, x) of a channel with the simulated value x.
fn samples(run: &Simulated, channel: &str) -> Vec<(f64, f64, f64)> {
    let (Some(simulated), Some(measured)) = (run.simulated.get(channel), run.measured.get(channel)) else {
        return Vec::new();
    };
    run.time.iter().zip(measured).zip(simulated).filter_map(|((t, y), x)| y.map(|y| (*t, y, *x))).collect()
}

/// Noise of the sensor of a channel in a run, in the unit of the channel.
pub(super) fn noise(results: &Results<'_>, run: &str, channel: &str) -> Option<f64> {
    results.comparison.runs.iter().find(|r| r.run == run && r.dof.channel() == channel).map(|r| r.noise_floor)
}

/// Half width of the band for 95 % of the samples, at each time stamp; `None` if the model contains
/// no noise.
fn half_width(run: &Simulated, channel: &str) -> Option<Vec<f64>> {
    let std = run.std.get(channel).filter(|std| std.iter().any(Option::is_some))?;
    // a missing width, at the beginning of a stretch, takes the next known value
    let mut wide: Vec<f64> = std.iter().map(|s| COVER * s.unwrap_or(f64::NAN)).collect();
    let mut next = f64::NAN;
    for s in wide.iter_mut().rev() {
        next = if s.is_nan() { next } else { *s };
        *s = next;
    }
    Some(wide)
}

/// A line over the time of a run with that band.
fn banded(name: &str, run: &Simulated, channel: &str, mean: Vec<f64>) -> Series {
    let interval = half_width(run, channel).unwrap_or_default();
    let about = |(x, w): (&f64, &f64)| if w.is_nan() { (*x, *x) } else { (x - w, x + w) };
    let interval = mean.iter().zip(&interval).map(about).collect();
    Series::line(name, run.time.clone(), mean).with_interval(interval)
}

/// The sentence about the bands of a figure: the expected and the actual share of samples in them.
fn of_bands(run: &Simulated, channel: &str) -> Option<String> {
    let wide = half_width(run, channel)?;
    let (simulated, measured) = (run.simulated.get(channel)?, run.measured.get(channel)?);
    let known = measured.iter().zip(simulated).zip(&wide).filter_map(|((y, x), w)| Some(((*y)? - x, *w)));
    let judged: Vec<bool> = known.filter(|(_, w)| w.is_finite()).map(|(e, w)| e.abs() <= w).collect();
    let share = 100.0 * judged.iter().filter(|inside| **inside).count() as f64 / judged.len().max(1) as f64;
    Some(format!(
        " Bands: expected to contain 95 of 100 samples, given sensor noise and random force; they contain {share:.0}."
    ))
}

/// The velocity channel of `dof` with its unit; that of the position if the log contains only the
/// pose.
fn measured_motion(run: &Simulated, dof: Dof) -> (&'static str, &'static str) {
    match samples(run, dof.velocity()).is_empty() {
        false => (dof.velocity(), unit_of(dof)),
        true => (dof.position(), if dof.is_rotation() { "rad" } else { "m" }),
    }
}

/// Measured and simulated velocity of `dof`, or its position if no velocity is measured, over time
/// with the residual below; `None` if either is absent. `noise`: that of the sensor of the shown
/// channel, in its unit.
pub fn motion_figure(run: &Simulated, dof: Dof, noise: Option<f64>) -> Option<Figure> {
    let (channel, unit) = measured_motion(run, dof);
    let samples = samples(run, channel);
    if samples.is_empty() {
        return None;
    }
    let column = |f: &dyn Fn(&(f64, f64, f64)) -> f64| samples.iter().map(f).collect::<Vec<f64>>();
    let t = column(&|s| s.0);
    let top = Panel {
        y: Axis::new(Label::symbol(channel), unit),
        series: vec![
            Series::points("measured", t.clone(), column(&|s| s.1)),
            banded("simulated", run, channel, run.simulated[channel].clone()),
        ],
        floor: None,
    };
    let bands = of_bands(run, channel);
    let zero = banded("", run, channel, vec![0.0; run.time.len()]);
    let strip = Panel {
        y: Axis::new("residual", unit),
        series: vec![Series::points("residual", t, column(&|s| s.1 - s.2)), zero],
        floor: noise.filter(|_| bands.is_none()),
    };
    let chart = Chart::Curves(Curves { x: Axis::new("time", "s"), panels: vec![top, strip], spans: Vec::new() });
    let role = if run.role == Role::Validate { "took no part in the fit" } else { "was part of the fit" };
    let sensor = noise.map(|_| " Grey: one standard deviation of the sensor's noise.".to_string());
    let said = bands.or(sensor).unwrap_or_default();
    let caption = format!("This run {role}. The simulation starts from a state estimated on the first seconds.{said}");
    Some(Figure { title: format!("{}, {dof}", run.run), caption, chart })
}

/// One figure per state that changes, with one panel per degree of freedom.
fn against_states(results: &Results<'_>, runs: &[&Simulated], which: &str) -> Vec<Figure> {
    let dofs = &results.fit.model.dofs;
    let velocities = dofs.iter().map(|dof| (dof.velocity(), unit_of(*dof)));
    let attitude = [Dof::Roll, Dof::Pitch, Dof::Yaw].into_iter().map(|dof| (dof.position(), "rad"));
    let depth = std::iter::once((Dof::Heave.position(), "m"));
    velocities.chain(attitude).chain(depth).filter_map(|state| against(results, runs, state, which)).collect()
}

fn against(results: &Results<'_>, runs: &[&Simulated], (state, unit): (&str, &str), which: &str) -> Option<Figure> {
    let pairs = |dof: &Dof| -> Vec<(f64, f64)> {
        let channel = dof.velocity();
        let of_run = |run: &&Simulated| -> Vec<(f64, f64)> {
            let (Some(x), Some(simulated), Some(measured)) =
                (run.simulated.get(state), run.simulated.get(channel), run.measured.get(channel))
            else {
                return Vec::new();
            };
            let rows = x.iter().zip(simulated).zip(measured);
            rows.filter_map(|((x, simulated), y)| y.map(|y| (*x, y - simulated))).collect()
        };
        runs.iter().flat_map(of_run).collect()
    };
    let panel = |dof: &Dof| {
        let mut all = pairs(dof);
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (first, last) = (all.first()?.0, all.last()?.0);
        if all.len() < 4 * GROUPS || last - first < 1e-6 {
            return None;
        }
        let step = all.len().div_ceil(POINTS);
        let (x, y): (Vec<f64>, Vec<f64>) = all.iter().step_by(step).copied().unzip();
        let floors: Vec<f64> = runs.iter().filter_map(|run| noise(results, &run.run, dof.velocity())).collect();
        Some(Panel {
            y: Axis::new(Label::symbol(format!("{} residual", dof.velocity())), unit_of(*dof)),
            series: vec![Series::points("residual", x, y), groups(&all)],
            floor: floors.into_iter().reduce(f64::max),
        })
    };
    let panels: Vec<Panel> = results.fit.model.dofs.iter().filter_map(panel).collect();
    if panels.is_empty() {
        return None;
    }
    Some(Figure {
        title: format!("Residuals against {state}"),
        caption: format!("Of {which}. Line and band: median and quartiles of {GROUPS} groups of equal size."),
        chart: Chart::Curves(Curves { x: Axis::new(Label::symbol(state), unit), panels, spans: Vec::new() }),
    })
}

/// Median and quartiles of groups of equally many samples; `pairs` are in the order of their
/// abscissa.
fn groups(pairs: &[(f64, f64)]) -> Series {
    let (mut x, mut middle, mut interval) = (Vec::new(), Vec::new(), Vec::new());
    for group in pairs.chunks(pairs.len().div_ceil(GROUPS)) {
        let mut y: Vec<f64> = group.iter().map(|(_, y)| *y).collect();
        y.sort_by(f64::total_cmp);
        let at = |part: f64| y[((y.len() - 1) as f64 * part).round() as usize];
        x.push(group.iter().map(|(x, _)| x).sum::<f64>() / group.len() as f64);
        middle.push(at(0.5));
        interval.push((at(0.25), at(0.75)));
    }
    Series::line("median and quartiles", x, middle).with_interval(interval)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_follow_a_step() {
        let pairs: Vec<(f64, f64)> = (0..240).map(|k| (f64::from(k), if k < 120 { -1.0 } else { 2.0 })).collect();
        let series = groups(&pairs);
        assert_eq!(series.len(), GROUPS);
        assert_eq!((series.y[0], series.y[GROUPS - 1]), (-1.0, 2.0));
        assert_eq!(series.interval[3], (-1.0, -1.0));
    }
}
