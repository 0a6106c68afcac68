//! A [`Document`] as one HTML file: no network, readable without its script, on a desk, a phone and paper.
//!
//! The page is `templates/report.html` (askama: checked at compile time, escapes all text); style
//! and script are beside it. Each figure is drawn twice, wide and narrow, because text in an SVG
//! shrinks with it; the style sheet shows the one that fits.

use askama::Template;

use super::chart::{Chart, Curves, Figure};
use super::data;
use super::document::{Block, Cell, Check, Definition, Document, Equation, Light, Multiples, Table};
use super::escape::marked;
use super::label::{Label, unit};
use super::number::{Style, estimate, number};
use super::svg::{NARROW, Sheet, WIDE, inline};
use crate::wording::count;

pub use super::palette::{page_style, standalone_style as figure_style};

/// Points of all curves together, chosen so that a report with many figures stays below 2 MB: a
/// point takes about 25 bytes (drawn wide, drawn narrow, packed for the script), and the cells of
/// 27 runs on 27 in three degrees of freedom take half a megabyte.
const POINTS: usize = 40_000;

/// Width of a small figure beside others, px, and maximum number of points of each of its series:
/// 81 figures of two series take half a megabyte.
const SMALL: (f64, usize) = (240.0, 60);

/// Number of rows beyond which a table is folded.
const LONG: usize = 15;

#[derive(Template)]
#[template(path = "report.html")]
struct Page<'a> {
    document: &'a Document,
    checks: Vec<CheckLine<'a>>,
    first: Vec<BlockView<'a>>,
    sections: Vec<SectionView<'a>>,
    chart_style: String,
    figure_style: String,
    page_style: &'static str,
    script: &'static str,
}

impl Page<'_> {
    /// Escaped text, with the parts between backticks as code.
    fn text(&self, text: &str) -> String {
        marked(text)
    }
}

struct CheckLine<'a> {
    class: &'static str,
    sign: &'static str,
    word: &'static str,
    check: &'a Check,
}

struct SectionView<'a> {
    heading: &'a str,
    paragraphs: &'a [String],
    blocks: Vec<BlockView<'a>>,
    /// Shown instead of the blocks until they are requested; empty if they are open.
    summary: String,
}

enum BlockView<'a> {
    Table(TableView<'a>),
    Figure(FigureView<'a>),
    Multiples(MultiplesView<'a>),
    Equations(Vec<(String, &'a Equation)>),
    Definitions(Vec<(String, &'a Definition)>),
}

struct TableView<'a> {
    table: &'a Table,
    number: usize,
    heads: Vec<Head>,
    rows: Vec<Vec<CellView>>,
    csv: String,
    latex: String,
    /// Whether it is too long to be shown open.
    folded: bool,
}

struct MultiplesView<'a> {
    multiples: &'a Multiples,
    number: usize,
    /// Title and drawing of each figure.
    drawings: Vec<(&'a str, String)>,
}

struct Head {
    class: &'static str,
    html: String,
    unit: String,
}

struct CellView {
    class: &'static str,
    html: String,
}

struct FigureView<'a> {
    figure: &'a Figure,
    id: String,
    /// Its displayed number; empty for none.
    number: String,
    wide: String,
    narrow: String,
    /// Packed numbers; empty for a figure that does not zoom.
    data: String,
}

/// The whole report as HTML text, below 2 MB unless its tables are enormous.
pub fn render<'a>(document: &'a Document) -> String {
    let points = points_a_series(document);
    let (mut tables, mut figures) = (0, 0);
    let mut view = |block: &Block| -> usize {
        let count = if matches!(block, Block::Table(_)) { &mut tables } else { &mut figures };
        *count += usize::from(matches!(block, Block::Table(_) | Block::Figure(_) | Block::Multiples(_)));
        *count
    };
    let mut views = |blocks: &'a [Block]| -> Vec<BlockView<'a>> {
        blocks.iter().map(|block| block_view(block, view(block), points)).collect()
    };
    let first = views(&document.first_screen);
    let sections = document.sections.iter().map(|section| SectionView {
        heading: &section.heading,
        paragraphs: &section.paragraphs,
        blocks: views(&section.blocks),
        summary: if section.folded { contents(&section.blocks) } else { String::new() },
    });
    let sections = sections.collect();
    let page = Page {
        document,
        checks: document.checks.iter().map(check_line).collect(),
        first,
        sections,
        chart_style: page_style(),
        figure_style: figure_style(),
        page_style: include_str!("../../templates/report.css"),
        script: concat!(include_str!("../../templates/chart.js"), include_str!("../../templates/report.js")),
    };
    page.render().expect("writing to a string cannot fail")
}

/// `3 figures and 1 table`.
fn contents(blocks: &[Block]) -> String {
    let tables = blocks.iter().filter(|block| matches!(block, Block::Table(_))).count();
    let counted = [(blocks.len() - tables, "figure"), (tables, "table")];
    let told = counted.iter().filter(|(n, _)| *n > 0).map(|(n, thing)| count(*n, thing));
    told.collect::<Vec<_>>().join(" and ")
}

/// Maximum number of points of each series; a series with an interval counts as three, because a
/// point has three numbers.
fn points_a_series(document: &Document) -> usize {
    let blocks = document.first_screen.iter().chain(document.sections.iter().flat_map(|section| &section.blocks));
    let series: usize = blocks
        .filter_map(|block| match block {
            Block::Figure(Figure { chart: Chart::Curves(Curves { panels, .. }), .. }) => Some(panels),
            _ => None,
        })
        .flatten()
        .flat_map(|panel| &panel.series)
        .map(|series| if series.interval.is_empty() { 1 } else { 3 })
        .sum();
    (POINTS / series.max(1)).clamp(60, 3000)
}

fn check_line(check: &Check) -> CheckLine<'_> {
    let (class, sign, word) = match check.light {
        Light::Green => ("green", "✓", "in order"),
        Light::Amber => ("amber", "!", "to be kept in mind"),
        Light::Red => ("red", "✕", "not to be trusted"),
    };
    CheckLine { class, sign, word, check }
}

fn block_view(block: &Block, number: usize, points: usize) -> BlockView<'_> {
    match block {
        Block::Table(table) => BlockView::Table(table_view(table, number)),
        Block::Figure(figure) => BlockView::Figure(FigureView {
            number: format!("Figure {number}."),
            ..figure_view(figure, &number.to_string(), points)
        }),
        Block::Multiples(multiples) => BlockView::Multiples(multiples_view(multiples, number)),
        Block::Equations(list) => {
            BlockView::Equations(list.iter().map(|e| (Label::symbol(e.formula.as_str()).html(), e)).collect())
        }
        Block::Definitions(list) => BlockView::Definitions(list.iter().map(|d| (d.term.html(), d)).collect()),
    }
}

fn multiples_view(multiples: &Multiples, number: usize) -> MultiplesView<'_> {
    let (width, points) = SMALL;
    let draw =
        |(k, figure): (usize, &'_ Figure)| inline(figure, &Sheet { width, id: format!("m{number}-{k}"), points });
    let titles = multiples.figures.iter().map(|figure| figure.title.as_str());
    MultiplesView { multiples, number, drawings: titles.zip(multiples.figures.iter().enumerate().map(draw)).collect() }
}

fn table_view(table: &Table, number: usize) -> TableView<'_> {
    let class = |k: usize| if table.is_numeric(k) { "num" } else { "" };
    // an empty column would take room from the others
    let columns = table.filled();
    let heads = columns.iter().map(|k| Head {
        class: class(*k),
        html: table.columns[*k].name.html(),
        unit: unit(&table.columns[*k].unit),
    });
    let cell =
        |row: &[Cell], k: usize| CellView { class: class(k), html: cell_html(row.get(k).unwrap_or(&Cell::Empty)) };
    let rows = table.rows.iter().map(|row| columns.iter().map(|k| cell(row, *k)).collect());
    TableView {
        table,
        number,
        heads: heads.collect(),
        rows: rows.collect(),
        csv: table.csv(),
        latex: table.latex(),
        folded: table.rows.len() > LONG,
    }
}

fn cell_html(cell: &Cell) -> String {
    match cell {
        Cell::Empty => String::new(),
        Cell::Text(label) => label.html(),
        Cell::Number { value, digits } => number(*value, *digits, Style::Text),
        Cell::Estimate { value, std } => {
            let text = estimate(*value, *std, Style::Text);
            match (text.starts_with('('), text.split_once(" ± ")) {
                (false, Some((value, std))) => format!("{value}<span class=\"std\"> ± {std}</span>"),
                _ => text,
            }
        }
    }
}

/// A figure without a number; `name` must be unique on the page.
fn figure_view<'a>(figure: &'a Figure, name: &str, points: usize) -> FigureView<'a> {
    let draw = |kind: &str, width: f64| inline(figure, &Sheet { width, id: format!("{kind}{name}"), points });
    let data = match &figure.chart {
        Chart::Curves(chart) => data::packed(chart, points),
        _ => String::new(),
    };
    let (wide, narrow) = (draw("w", WIDE), draw("n", NARROW));
    FigureView { figure, id: format!("figure-{name}"), number: String::new(), wide, narrow, data }
}

/// One figure on its own.
#[derive(Template)]
#[template(path = "figure.html")]
struct Single<'a> {
    view: FigureView<'a>,
}

impl Single<'_> {
    /// As [`Page::text`].
    fn text(&self, text: &str) -> String {
        marked(text)
    }
}

/// Maximum number of points per series of a figure on its own.
const SINGLE_POINTS: usize = 3000;

/// A figure as in a report, for another page that contains [`page_style`], [`SCRIPT`] and, as
/// `#figure-style`, [`figure_style`]. `name` must be unique on that page: letters, digits and
/// hyphens.
pub fn figure(figure: &Figure, name: &str) -> String {
    let page = Single { view: figure_view(figure, name, SINGLE_POINTS) };
    page.render().expect("writing to a string cannot fail")
}

/// The script of the figures. It defines `charts.adorn(element)`, which adds zoom and read-out to
/// the figures below an element.
pub const SCRIPT: &str = include_str!("../../templates/chart.js");

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Axis, Column, Input, Origin, Panel, Section, Series, Span};

    const NASTY: &str = "</script><script>alert(1)</script><img src=x onerror='a()'>\"&{{ 1 }}";

    fn curves(series: Vec<Series>) -> Block {
        let panel = Panel { y: Axis::new(NASTY, NASTY), series, floor: Some(0.1) };
        let spans = vec![Span { from: 0.0, to: 1.0, label: NASTY.into() }];
        let chart = Chart::Curves(Curves { x: Axis::new(Label::symbol(NASTY), NASTY), panels: vec![panel], spans });
        Block::Figure(Figure { title: NASTY.into(), caption: NASTY.into(), chart })
    }

    fn with(blocks: Vec<Block>) -> Document {
        let section = Section { heading: NASTY.into(), paragraphs: vec![NASTY.into()], blocks, folded: false };
        Document { title: NASTY.into(), sections: vec![section], ..Document::default() }
    }

    #[test]
    fn no_text_from_outside_becomes_markup() {
        let table = Table {
            title: NASTY.into(),
            columns: vec![Column::new(Label::symbol(NASTY), NASTY)],
            rows: vec![vec![NASTY.into()], vec![]],
            note: NASTY.into(),
        };
        let series = vec![Series::line(NASTY, vec![0.0, 1.0], vec![2.0, 3.0])];
        let equation = Equation { formula: NASTY.into(), note: NASTY.into() };
        let definition = Definition { term: NASTY.into(), meaning: NASTY.into() };
        let blocks = vec![
            Block::Table(table),
            curves(series),
            Block::Equations(vec![equation]),
            Block::Definitions(vec![definition]),
        ];
        let input = Input { name: NASTY.into(), sha256: NASTY.into() };
        let check = Check { light: Light::Red, code: NASTY.into(), text: NASTY.into() };
        let origin = Origin { version: NASTY.into(), command: NASTY.into(), inputs: vec![input], seed: Some(1) };
        let document =
            Document { subtitle: NASTY.into(), verdict: NASTY.into(), checks: vec![check], origin, ..with(blocks) };
        let page = render(&document);
        assert!(!page.contains("<script>alert") && !page.contains("<img"));
        // Scripts of the page itself: the numbers of one figure, the style of figures, the script.
        assert_eq!(page.matches("<script").count(), 3);
        assert_eq!(page.matches("</script>").count(), 3);
    }

    #[test]
    fn a_report_of_long_runs_stays_below_two_megabytes() {
        let time: Vec<f64> = (0..200_000).map(|k| 0.005 * f64::from(k)).collect();
        let wave = |n: usize| time.iter().map(|t| (t * n as f64).sin() * 1e3 + t.cos()).collect::<Vec<f64>>();
        for figures in [2, 24] {
            let figure = |n: usize| {
                let y = wave(n + 1);
                let interval = y.iter().map(|y| (y - 1.0, y + 1.0)).collect();
                curves(vec![
                    Series::points("measured", time.clone(), y.clone()),
                    Series::line("simulated", time.clone(), y).with_interval(interval),
                ])
            };
            let size = render(&with((0..figures).map(figure).collect())).len();
            assert!(size < 2_000_000, "{figures} figures: {size} bytes");
        }
    }

    /// Small figures of 27 runs in three degrees of freedom and 24 large figures, as in the report
    /// of a campaign.
    #[test]
    fn a_report_of_27_runs_stays_below_two_megabytes() {
        let time: Vec<f64> = (0..6000).map(|k| 0.02 * f64::from(k)).collect();
        let figure = |n: usize| {
            let y: Vec<f64> = time.iter().map(|t| (t * n as f64).sin() * 0.123_456 + t.cos()).collect();
            let interval = y.iter().map(|y| (y - 0.1, y + 0.1)).collect();
            let band = Series::line("simulated", time.clone(), y.clone()).with_interval(interval);
            let panel = Panel {
                y: Axis::new("u", "m/s"),
                series: vec![Series::points("measured", time.clone(), y), band],
                floor: None,
            };
            let chart = Chart::Curves(Curves { x: Axis::new("time", "s"), panels: vec![panel], spans: Vec::new() });
            Figure { title: format!("run{n:02}.csv"), caption: String::new(), chart }
        };
        let small = |dof: usize| {
            let figures = (0..27).map(|run| figure(run + 27 * dof)).collect();
            Block::Multiples(Multiples { title: "u".into(), caption: String::new(), figures })
        };
        let blocks: Vec<Block> = (0..3).map(small).chain((0..24).map(|n| Block::Figure(figure(n)))).collect();
        let mut document = with(blocks);
        document.sections[0].folded = true;
        let page = render(&document);
        assert!(page.len() < 2_000_000, "{} bytes", page.len());
        assert_eq!(page.matches("class=\"small\"").count(), 81);
        assert!(page.contains("<summary>27 figures</summary>"));
    }

    #[test]
    fn an_empty_document_and_empty_figures_are_pages_too() {
        assert!(render(&Document::default()).ends_with("</html>"));
        let nothing = vec![Series::line("", vec![], vec![]), Series::points("", vec![f64::NAN], vec![1.0])];
        let page = render(&with(vec![curves(nothing), curves(vec![]), Block::Table(Table::default())]));
        let body = page.split("id=\"figure-style\"").next().unwrap_or_default();
        assert!(!body.contains("NaN") && !body.contains("inf"));
    }
}
