//! The numbers of the curves, packed for the page's script (zoom and read-out).
//!
//! A list of numbers is stored as an origin o, a step s and the differences d in whole steps:
//! xₖ = o + s Σ_{i≤k} dᵢ. The step is 1/20 000 of the range, a thirtieth of a pixel on the widest
//! figure; most differences then need two to four characters. A gap is `null`.

use serde_json::{Value, json};

use super::chart::{Curves, Mark, Series};
use super::label::{Label, unit};
use super::svg::{decimate, thin};

/// Number of steps over the range of a list.
const STEPS: f64 = 20_000.0;

/// The chart as JSON that may be placed in a `<script>`: it contains no `<`.
pub(super) fn packed(chart: &Curves, points: usize) -> String {
    let panels: Vec<Value> = chart
        .panels
        .iter()
        .map(|panel| {
            let series: Vec<Value> = panel.series.iter().map(|s| packed_series(s, points)).collect();
            json!({
                "label": plain(&panel.y.label), "unit": unit(&panel.y.unit), "floor": panel.floor, "series": series,
            })
        })
        .collect();
    let spans: Vec<Value> = chart.spans.iter().map(|s| json!([s.from, s.to])).collect();
    let x = json!({"label": plain(&chart.x.label), "unit": unit(&chart.x.unit)});
    json!({"x": x, "panels": panels, "spans": spans}).to_string().replace('<', "\\u003c")
}

fn packed_series(series: &Series, points: usize) -> Value {
    let y = &series.y[..series.len()];
    let kept = match series.mark {
        Mark::Line => decimate(y, points),
        Mark::Points => thin(y, points),
    };
    let pick = |list: &[f64]| numbers(kept.iter().map(|k| list[*k]).collect());
    let mark = match series.mark {
        Mark::Line => "line",
        Mark::Points => "dots",
    };
    let mut out = json!({"name": plain(&series.name), "mark": mark, "x": pick(&series.x), "y": pick(&series.y)});
    if !series.interval.is_empty() {
        let ends = |k: usize| series.interval.get(k).copied().unwrap_or((f64::NAN, f64::NAN));
        out["low"] = numbers(kept.iter().map(|k| ends(*k).0).collect());
        out["high"] = numbers(kept.iter().map(|k| ends(*k).1).collect());
    }
    out
}

fn numbers(values: Vec<f64>) -> Value {
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let low = finite().fold(f64::INFINITY, f64::min);
    let high = finite().fold(f64::NEG_INFINITY, f64::max);
    let origin = if low.is_finite() { low } else { 0.0 };
    // The halves of a difference cannot overflow.
    let step = 2.0 * (0.5 * high - 0.5 * origin) / STEPS;
    let step = if step.is_finite() && step > 0.0 { step } else { 1.0 };
    let mut last = 0;
    let differences: Vec<Option<i64>> = values
        .into_iter()
        .map(|v| {
            let whole = v.is_finite().then(|| ((v - origin) / step).round() as i64)?;
            let difference = whole - last;
            last = whole;
            Some(difference)
        })
        .collect();
    json!({"o": origin, "s": step, "d": differences})
}

/// A symbol without its markup: the read-out is plain text.
fn plain(label: &Label) -> String {
    match label {
        Label::Plain(text) => text.clone(),
        Label::Symbol(text) => text.chars().filter(|c| !matches!(c, '_' | '^' | '{' | '}')).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unpacked(value: &Value) -> Vec<Option<f64>> {
        let (origin, step) = (value["o"].as_f64().unwrap(), value["s"].as_f64().unwrap());
        let mut sum = 0;
        let read = |d: &Value| {
            sum += d.as_i64()?;
            Some(origin + step * sum as f64)
        };
        value["d"].as_array().unwrap().iter().map(read).collect()
    }

    #[test]
    fn numbers_come_back_within_half_a_step() {
        let values = vec![3.0, -1.5, f64::NAN, 0.25, 1e-9, 7.0];
        let back = unpacked(&numbers(values.clone()));
        let tolerance = 0.5001 * 8.5 / STEPS;
        for (v, b) in values.iter().zip(&back) {
            assert!(b.map_or(v.is_nan(), |b| (b - v).abs() <= tolerance), "{v} came back as {b:?}");
        }
        assert_eq!(unpacked(&numbers(vec![2.0, 2.0])), [Some(2.0), Some(2.0)]);
        assert_eq!(numbers(vec![f64::NAN])["d"], json!([null]));
    }
}
