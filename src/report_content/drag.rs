//! Drag curves with their 95 % intervals, and added mass against amplitude: Tables 3, 5 and 7 of
//! Avila et al. (2013).
//!
//! ```text
//! D(ν) = Σ gⱼ(ν) θⱼ        σ_D² = gᵀ Σ_θ g        gⱼ: force of drag and bias per unit of θⱼ
//! C_m = (m − m_dry)/(ρ∇)   σ_C = σ_m/(ρ∇)
//! ```

use super::{COVER, Results};
use crate::campaign::FitStage;
use crate::chain::{Nature, nature};
use crate::effects::id;
use crate::estimate::force_components;
use crate::frame::Dof;
use crate::model::Model;
use crate::procedure::direct_regression::alone;
use crate::procedure::{is_powered, steady_means, towed};
use crate::report::{Axis, Chart, Curves, Figure, Label, Panel, Series};
use crate::run::{Run, RunKind, Signal};

/// Number of points of a curve.
const POINTS: usize = 81;

/// The figures: one per degree of freedom, and added mass against amplitude.
pub(super) fn figures(results: &Results<'_>) -> Vec<Figure> {
    let dofs = results.fit.model.dofs.iter();
    dofs.filter_map(|dof| curves(results, *dof)).chain(inertia(results)).collect()
}

/// Parameters, by their index in a model, with values and covariance.
struct Known {
    parameters: Vec<usize>,
    values: Vec<f64>,
    covariance: Vec<Vec<f64>>,
}

fn curves(results: &Results<'_>, dof: Dof) -> Option<Figure> {
    let model = drag_alone(&results.fit.model, dof);
    let [low, high] = *results.fit.envelope.get(dof.velocity())?;
    let whole: Vec<usize> = model.terms.iter().flat_map(|t| t.parameters.iter().copied()).collect();
    if !whole.iter().any(|p| model.parameters[*p].effect != id::BIAS) {
        return None;
    }
    let covariance = &results.fit.covariance;
    let own = Known {
        values: whole.iter().map(|p| model.parameters[*p].value).collect(),
        covariance: whole.iter().map(|a| whole.iter().map(|b| covariance[*a][*b]).collect()).collect(),
        parameters: whole,
    };
    let mut series = vec![band("the model", dof, &model, &own, [low, high])?];
    for stage in results.fit.stages.iter().filter(|s| s.dof == dof) {
        let range = match stage.name.as_str() {
            "towing" => [low.max(0.0), high],
            "steady" => [low, high],
            "steady clockwise" => [0.0, high],
            "steady anticlockwise" => [low, 0.0],
            _ => continue,
        };
        let known = of_stage(&model, stage);
        let word = if stage.name == "towing" { "towed" } else { &stage.name.replace("steady", "propelled") };
        series.extend(band(word, dof, &model, &known, range));
    }
    let steady = &results.campaign.file.stage.steady;
    let campaign = results.campaign.under(&results.fit.efficiency);
    let of_kind = |kind: RunKind| campaign.runs.iter().filter(move |run| run.kind == kind);
    let tow: Vec<Run> =
        of_kind(RunKind::Towing).filter(|run| !is_powered(run, dof)).filter_map(|run| towed(run, dof)).collect();
    for (name, runs) in [
        ("towed, means", tow.iter().collect::<Vec<&Run>>()),
        ("propelled, means", of_kind(RunKind::ConstantVelocity).collect()),
    ] {
        let means: Vec<_> = runs.iter().flat_map(|run| steady_means(run, dof, steady)).collect();
        // runs of other degrees of freedom do not move in this one
        let moved: Vec<_> = means.into_iter().filter(|(v, _)| v.value.abs() > 0.05 * high.max(-low)).collect();
        if !moved.is_empty() {
            let (x, y) = moved.iter().map(|(v, f)| (v.value, f.value)).unzip();
            let interval = moved.iter().map(|(_, f)| (f.value - COVER * f.std, f.value + COVER * f.std)).collect();
            series.push(Series::points(name, x, y).with_interval(interval));
        }
    }
    let (force, speed) = if dof.is_rotation() { ("N*m", "rad/s") } else { ("N", "m/s") };
    let panel = Panel { y: Axis::new("drag", force), series, floor: None };
    Some(Figure {
        title: format!("Drag in {dof}"),
        caption:
            "Drag and bias over the speeds of the fit, with 95 % intervals. Points: mean force of each steady window."
                .into(),
        chart: Chart::Curves(Curves {
            x: Axis::new(Label::symbol(dof.velocity()), speed),
            panels: vec![panel],
            spans: Vec::new(),
        }),
    })
}

/// The model with only the drag and the bias of one degree of freedom.
fn drag_alone(model: &Model, dof: Dof) -> Model {
    let mut own = alone(model, dof);
    own.terms.retain(|term| matches!(nature(model, term), Nature::Drag | Nature::Steady));
    own.observers.clear();
    own
}

/// The drag parameters that a stage has estimated; the others count as 0.
fn of_stage(model: &Model, stage: &FitStage) -> Known {
    let place = |e: &crate::procedure::Estimate| {
        let named = |p: &usize| model.parameters[*p].effect == e.effect && model.parameters[*p].spec.name == e.name;
        model.terms.iter().flat_map(|t| t.parameters.iter().copied()).find(named)
    };
    let kept: Vec<(usize, usize)> =
        stage.estimates.iter().enumerate().filter_map(|(k, e)| Some((k, place(e)?))).collect();
    Known {
        parameters: kept.iter().map(|(_, p)| *p).collect(),
        values: kept.iter().map(|(k, _)| stage.estimates[*k].value).collect(),
        covariance: kept.iter().map(|(a, _)| kept.iter().map(|(b, _)| stage.covariance[*a][*b]).collect()).collect(),
    }
}

/// Drag over `range` with its 95 % interval; `None` if it depends on more than the speed.
fn band(name: &str, dof: Dof, model: &Model, known: &Known, range: [f64; 2]) -> Option<Series> {
    if known.parameters.is_empty() || range[1] <= range[0] {
        return None;
    }
    let mut still = model.clone();
    for term in &model.terms {
        for p in &term.parameters {
            still.parameters[*p].value = 0.0;
            still.parameters[*p].per_run.clear();
        }
    }
    let speeds: Vec<f64> =
        (0..POINTS).map(|k| range[0] + (range[1] - range[0]) * k as f64 / (POINTS - 1) as f64).collect();
    let run = swept(dof, &speeds);
    // drag is linear in its coefficients
    let gradient: Option<Vec<Vec<f64>>> = known
        .parameters
        .iter()
        .map(|p| {
            let mut one = still.clone();
            one.parameters[*p].value = 1.0;
            let force = force_components(dof, &run, 0, &one).ok()?.total();
            Some(force.into_iter().map(|f| -f).collect())
        })
        .collect();
    let gradient = gradient.filter(|g| g.iter().all(|column| column.len() == POINTS))?;
    let at = |k: usize| gradient.iter().map(|column| column[k]).collect::<Vec<f64>>();
    let (mut force, mut interval) = (Vec::new(), Vec::new());
    for k in 0..POINTS {
        let g = at(k);
        let value: f64 = g.iter().zip(&known.values).map(|(g, v)| g * v).sum();
        let row = |row: &Vec<f64>| row.iter().zip(&g).map(|(c, g)| c * g).sum::<f64>();
        let variance: f64 = known.covariance.iter().zip(&g).map(|(c, g)| g * row(c)).sum();
        let reach = COVER * variance.max(0.0).sqrt();
        force.push(value);
        interval.push((value - reach, value + reach));
    }
    Some(Series::line(name, speeds, force).with_interval(interval))
}

/// A run that takes these speeds one after the other, without commands.
fn swept(dof: Dof, speeds: &[f64]) -> Run {
    let time: std::sync::Arc<[f64]> = (0..speeds.len()).map(|k| k as f64).collect();
    let mut run = Run { name: "sweep".into(), ..Run::default() };
    for other in Dof::ALL {
        for name in [other.velocity(), other.force(), other.position()] {
            run.signals.insert(name.into(), Signal::new(time.clone(), vec![0.0; speeds.len()]));
        }
    }
    run.signals.insert(dof.velocity().into(), Signal::new(time, speeds.to_vec()));
    run
}

/// Added-mass coefficient of single runs against their Keulegan-Carpenter number.
fn inertia(results: &Results<'_>) -> Option<Figure> {
    let vehicle = &results.campaign.vehicle;
    let displaced = vehicle.volume.map(|volume| results.campaign.water.density * volume);
    let mut series = Vec::new();
    for dof in &results.fit.model.dofs {
        let of_stage = |s: &FitStage| {
            let numbers = s.numbers?;
            let mass = s.estimates.iter().find(|e| e.effect == id::INERTIA)?;
            Some((numbers.keulegan_carpenter?, numbers.inertia_coefficient?, mass.std / displaced?))
        };
        let staged = results.fit.stages.iter().filter(|s| s.dof == *dof).filter_map(of_stage);
        let known = results.fit.identifiability.iter().flat_map(|i| &i.inertia_against_amplitude);
        let fitted = known
            .filter(|i| i.dof == *dof)
            .flat_map(|i| &i.runs)
            .filter_map(|r| Some((r.kc, r.added_mass_coefficient?, r.std / displaced?)));
        let points: Vec<(f64, f64, f64)> = staged.chain(fitted).collect();
        if !points.is_empty() {
            let (x, y) = points.iter().map(|(kc, c, _)| (*kc, *c)).unzip();
            let interval = points.iter().map(|(_, c, std)| (c - COVER * std, c + COVER * std)).collect();
            series.push(Series::points(dof.name(), x, y).with_interval(interval));
        }
    }
    if series.is_empty() {
        return None;
    }
    let panel = Panel { y: Axis::new(Label::symbol("C_m"), ""), series, floor: None };
    Some(Figure {
        title: "Added mass against the amplitude".into(),
        caption:
            "Coefficient of added mass of each oscillation, with 95 % intervals, against its Keulegan-Carpenter number."
                .into(),
        chart: Chart::Curves(Curves { x: Axis::new("KC", ""), panels: vec![panel], spans: Vec::new() }),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Coriolis;

    #[test]
    fn the_band_is_that_of_the_correlated_coefficients() {
        let effects = ["inertia", "linear_drag", "quadratic_drag"];
        let model = drag_alone(&Model::with_effects(&[Dof::Surge], Coriolis::Free, &effects).unwrap(), Dof::Surge);
        let parameters: Vec<usize> = model.terms.iter().flat_map(|t| t.parameters.iter().copied()).collect();
        let known =
            Known { parameters, values: vec![10.0, 100.0], covariance: vec![vec![4.0, -8.0], vec![-8.0, 16.0]] };
        let series = band("x", Dof::Surge, &model, &known, [0.0, 2.0]).unwrap();
        let (k, v) = (20, 0.5);
        assert!((series.x[k] - v).abs() < 1e-12);
        assert!((series.y[k] - (10.0 * v + 100.0 * v * v)).abs() < 1e-9);
        // fully anticorrelated: σ = |2v − 4v²| = 0 at a half
        assert!((series.interval[k].1 - series.y[k]).abs() < 1e-6, "{:?}", series.interval[k]);
        let at_one = 1.96 * 2.0;
        assert!((series.interval[40].1 - series.y[40] - at_one).abs() < 1e-9);
    }
}
