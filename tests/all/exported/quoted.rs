//! The differences of motion that `docs/exports.md` quotes, which are the limits in the tests of
//! the consumers.

use std::path::Path;

use hydrosysid::export::Target;
use nalgebra::Vector6;

use super::engine::differences;

/// Rows of the table of targets: the targets of each row, and its other cells.
pub fn rows() -> Vec<(Vec<String>, Vec<String>)> {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/exports.md");
    let text = std::fs::read_to_string(page).expect("a page of the book");
    let table = text.split_once("| target | consumer and version |").expect("the table is there").1;
    let lines = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    let cells = |line: &str| -> Vec<String> {
        let inside = line.trim().trim_matches('|').replace("\\|", "\u{1}");
        inside.split('|').map(|cell| cell.trim().replace('\u{1}', "|")).collect()
    };
    let row = |line: &str| {
        let cells = cells(line);
        let names = cells[0].split('`').skip(1).step_by(2).map(str::to_string).collect();
        (names, cells[1..].to_vec())
    };
    lines.map(row).collect()
}

/// Per cent that the first row of a target quotes, and whether it is only an upper bound (`below …`).
fn quoted(target: Target) -> (f64, bool) {
    let all = rows();
    let found = all.iter().find(|(names, _)| names.iter().any(|name| name == target.name()));
    let cell = &found.unwrap_or_else(|| panic!("{target:?} has a row")).1[1];
    let figure = cell.split(" %").next().expect("it begins").rsplit(' ').next().expect("a figure");
    let percent = figure.parse().unwrap_or_else(|_| panic!("{target:?}: no per cent in {cell:?}"));
    (percent, cell.starts_with("below"))
}

/// Asserts that the worst velocity differs by as much as the book quotes: by 0.5 to 1.5 times that,
/// or below it where it is an upper bound. Differences between machines are far smaller than this
/// margin.
pub fn assert_quoted(target: Target, path: &[Vector6<f64>], truth: &[Vector6<f64>]) {
    let each = differences(path, truth);
    let worst = 100.0 * each.iter().copied().fold(0.0, f64::max);
    println!("{target:?}: {worst:.3e} %; of u v w p q r {each:?}");
    let (percent, below) = quoted(target);
    let most = if below { percent } else { 1.5 * percent };
    assert!(worst < most, "{target:?}: {worst:.4e} %, and docs/exports.md says {percent} %");
    assert!(below || worst > 0.5 * percent, "{target:?}: {worst:.4e} % alone, and docs/exports.md says {percent} %");
}
