//! Content of a figure as plain data: curves over a shared axis, bars, matrices, estimates with
//! their intervals.
//!
//! Values that are not finite are gaps.

use super::label::Label;

/// A chart with title and caption.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// What it shows, one line.
    pub title: String,
    /// What the reader should see in it; may be empty.
    pub caption: String,
    /// The chart.
    pub chart: Chart,
}

/// The kinds of chart.
#[derive(Debug, Clone, PartialEq)]
pub enum Chart {
    /// Lines and points over a shared abscissa.
    Curves(Curves),
    /// Horizontal bars, or a waterfall.
    Bars(Bars),
    /// A matrix of values.
    HeatMap(HeatMap),
    /// Estimates with intervals, row by row, from several sources.
    Forest(Forest),
}

/// Quantity and unit of an axis.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Axis {
    /// The quantity.
    pub label: Label,
    /// Its unit; empty for none.
    pub unit: String,
}

impl Axis {
    /// An axis of `label` in `unit` (empty for none).
    pub fn new(label: impl Into<Label>, unit: &str) -> Axis {
        Axis { label: label.into(), unit: unit.into() }
    }
}

/// Lines and points in one or more panels, one above the other, over the same abscissa: time
/// histories with their residuals below, drag curves with their interval.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves {
    /// The shared abscissa.
    pub x: Axis,
    /// From top to bottom; the first is tall, the others are low strips.
    pub panels: Vec<Panel>,
    /// Stretches of the abscissa that are shaded in all panels.
    pub spans: Vec<Span>,
}

/// One panel of a [`Curves`] chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// The ordinate.
    pub y: Axis,
    /// Series from back to front. Series at the same place in the list look alike in all panels.
    pub series: Vec<Series>,
    /// Half width of a shaded band about zero, in the unit of `y`: the noise floor of a residual.
    pub floor: Option<f64>,
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Joined; its interval is a shaded band.
    Line,
    /// Dots; its interval is an error bar.
    Points,
}

/// Points (xₖ, yₖ), joined or not.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend; empty for none.
    pub name: Label,
    /// Joined or not.
    pub mark: Mark,
    /// Abscissas.
    pub x: Vec<f64>,
    /// Ordinates, as many as abscissas.
    pub y: Vec<f64>,
    /// Interval (low, high) about each ordinate; empty for none.
    pub interval: Vec<(f64, f64)>,
}

impl Series {
    /// Joined points without an interval.
    pub fn line(name: impl Into<Label>, x: Vec<f64>, y: Vec<f64>) -> Series {
        Series { name: name.into(), mark: Mark::Line, x, y, interval: Vec::new() }
    }

    /// Single points without an interval.
    pub fn points(name: impl Into<Label>, x: Vec<f64>, y: Vec<f64>) -> Series {
        Series { name: name.into(), mark: Mark::Points, x, y, interval: Vec::new() }
    }

    /// The same with an interval (low, high) about each ordinate.
    pub fn with_interval(mut self, interval: Vec<(f64, f64)>) -> Series {
        self.interval = interval;
        self
    }

    /// Number of points: the shorter of both lists.
    pub fn len(&self) -> usize {
        self.x.len().min(self.y.len())
    }

    /// Whether there is no point at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A stretch of the abscissa.
#[derive(Debug, Clone, PartialEq)]
pub struct Span {
    /// Begin, in the unit of the abscissa.
    pub from: f64,
    /// End, in the unit of the abscissa.
    pub to: f64,
    /// Description in a few words; may be empty.
    pub label: String,
}

/// Horizontal bars, one per row. In a waterfall a bar that is not a total starts where the one
/// above ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Bars {
    /// What the bars measure.
    pub axis: Axis,
    /// From top to bottom.
    pub bars: Vec<Bar>,
    /// Whether changes start where the bar above ended.
    pub waterfall: bool,
    /// A line for comparison, with its name: the noise floor.
    pub reference: Option<(String, f64)>,
}

/// One bar.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// Its name.
    pub label: Label,
    /// Its length; in a waterfall, the change, unless it is a total.
    pub value: f64,
    /// Standard deviation of the value, drawn as a whisker.
    pub std: Option<f64>,
    /// Whether it starts at zero in a waterfall.
    pub total: bool,
}

/// Range of the colours of a heat map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Colours {
    /// From −limit over neutral zero to +limit, in two hues: correlations.
    Diverging {
        /// Value of full colour.
        limit: f64,
    },
    /// From `low` (neutral) to `high` (full colour) in one hue: errors, counts.
    Sequential {
        /// Value without colour.
        low: f64,
        /// Value of full colour.
        high: f64,
    },
}

/// A matrix of values, each written in its cell.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    /// What the columns are.
    pub x: Axis,
    /// What the rows are.
    pub y: Axis,
    /// Names of the columns.
    pub columns: Vec<Label>,
    /// Names of the rows.
    pub rows: Vec<Label>,
    /// Values row by row; NaN is an empty cell.
    pub values: Vec<Vec<f64>>,
    /// What the values are, with their unit.
    pub value: Axis,
    /// Decimals to write.
    pub decimals: usize,
    /// Range of the colours.
    pub colours: Colours,
}

/// Estimates with intervals: one row per parameter, one mark per source. All share one axis, so
/// parameters of different units have to be given relative to a reference.
#[derive(Debug, Clone, PartialEq)]
pub struct Forest {
    /// The shared axis.
    pub axis: Axis,
    /// From top to bottom.
    pub rows: Vec<ForestRow>,
    /// A value for comparison: 1 for ratios, 0 for differences.
    pub reference: Option<f64>,
}

/// One parameter of a forest plot.
#[derive(Debug, Clone, PartialEq)]
pub struct ForestRow {
    /// The parameter.
    pub label: Label,
    /// Its estimates.
    pub estimates: Vec<Interval>,
}

/// An estimate with its interval.
#[derive(Debug, Clone, PartialEq)]
pub struct Interval {
    /// Its source; the same name has the same mark in all rows.
    pub source: String,
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// The estimate as text, with unit; may be empty.
    pub text: String,
}
