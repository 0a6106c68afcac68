//! The part of the report about forces: nominal against actual thrust, drag, and the force of each
//! term over time (Fig. 11 of Avila et al., 2013).

use super::{COVER, Results};
use crate::campaign::{self, RunComponents};
use crate::effects::common_name;
use crate::frame::Dof;
use crate::procedure::settled_loads;
use crate::report::{Axis, Block, Chart, Curves, Figure, Panel, Section, Series, Style, estimate};
use crate::run::RunKind;

/// Maximum number of points in a figure of thrust.
const POINTS: usize = 800;

/// The section of a report.
pub(super) fn section(results: &Results<'_>) -> Option<Section> {
    let thrusts = results.fit.model.dofs.iter().filter_map(|dof| thrust(results, *dof));
    let blocks: Vec<Block> =
        super::drag::figures(results).into_iter().chain(thrusts).chain(over_time(results)).map(Block::Figure).collect();
    (!blocks.is_empty()).then(|| Section { heading: "Forces".into(), paragraphs: Vec::new(), blocks, folded: true })
}

fn unit_of(dof: Dof) -> &'static str {
    if dof.is_rotation() { "N*m" } else { "N" }
}

/// Effective thrust against the nominal thrust of the thruster curves: from load cells if there are
/// any, otherwise from the losses that the campaign or its fit contains.
fn thrust(results: &Results<'_>, dof: Dof) -> Option<Figure> {
    let options = &results.campaign.file.stage.bollard;
    let nominal = results.campaign.nominal_runs();
    let bollard = nominal.iter().filter(|run| run.kind == RunKind::Bollard);
    let mut pairs: Vec<(f64, f64)> = bollard.flat_map(|run| settled_loads(run, dof, options)).collect();
    let cells = !pairs.is_empty();
    if !cells {
        let acting = results.campaign.under(&results.fit.efficiency);
        for run in &acting.runs {
            let (Some(asked), Some(acts)) = (run.signal(&campaign::nominal(dof)), run.signal(dof.force())) else {
                continue;
            };
            pairs.extend(asked.time().iter().zip(asked.values()).map(|(t, f)| (*f, acts.at(*t))));
        }
    }
    let low = pairs.iter().map(|p| p.0).fold(0.0, f64::min);
    let high = pairs.iter().map(|p| p.0).fold(0.0, f64::max);
    if pairs.is_empty() || high - low <= 0.0 {
        return None;
    }
    let step = pairs.len().div_ceil(POINTS);
    let (x, y): (Vec<f64>, Vec<f64>) = pairs.iter().step_by(step).copied().unzip();
    let ends = vec![low, high];
    let mut series = vec![Series::points(if cells { "load cell" } else { "as it acts" }, x, y)];
    series.push(Series::line("without loss", ends.clone(), ends.clone()));
    for stage in results.fit.stages.iter().filter(|s| s.dof == dof && s.name.starts_with("bollard")) {
        let Some(eta) = stage.estimates.first() else { continue };
        let line = ends.iter().map(|f| eta.value * f).collect();
        let reach = |f: &f64| COVER * eta.std * f.abs();
        let interval = ends.iter().map(|f| (eta.value * f - reach(f), eta.value * f + reach(f))).collect();
        let name = format!("{}: {}", stage.name, estimate(eta.value, Some(eta.std), Style::Text));
        series.push(Series::line(name, ends.clone(), line).with_interval(interval));
    }
    let panel = Panel { y: Axis::new("effective thrust", unit_of(dof)), series, floor: None };
    let caption = if cells {
        "Load-cell forces of the bollard-pull runs against the forces from the thruster curves, once each command has \
         settled."
    } else {
        "Effective thrust after the known losses against the forces from the thruster curves."
    };
    Some(Figure {
        title: format!("Nominal and actual thrust in {dof}"),
        caption: caption.into(),
        chart: Chart::Curves(Curves {
            x: Axis::new("nominal thrust", unit_of(dof)),
            panels: vec![panel],
            spans: Vec::new(),
        }),
    })
}

/// Force of each term over time, for the longest run, in each degree of freedom that moves.
fn over_time(results: &Results<'_>) -> Vec<Figure> {
    let campaign = results.campaign.under(&results.fit.efficiency);
    let parts = campaign::components(&campaign, &results.fit.model).runs;
    let Some(longest) = parts.iter().max_by_key(|p| p.time.len()).map(|p| p.run.clone()) else { return Vec::new() };
    let figure = |part: &RunComponents| {
        let series =
            |(term, force): (&String, &Vec<f64>)| Series::line(common_name(term), part.time.clone(), force.clone());
        let panel = Panel {
            y: Axis::new("force", part.unit),
            series: part.terms.iter().chain([(&"total".to_string(), &part.total)]).map(series).collect(),
            floor: None,
        };
        Figure {
            title: format!("{}, {}: forces", part.run, part.dof),
            caption: "Force of each term on the vehicle at the logged motion; their sum is what accelerates it.".into(),
            chart: Chart::Curves(Curves { x: Axis::new("time", "s"), panels: vec![panel], spans: Vec::new() }),
        }
    };
    let moved =
        |p: &&RunComponents| super::motion::moves(&p.velocity, super::motion::noise(results, &p.run, p.dof.velocity()));
    parts.iter().filter(|p| p.run == longest).filter(moved).map(figure).collect()
}
