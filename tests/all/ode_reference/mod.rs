//! The reference problems of ordinary differential equations, as read from their file.

#![allow(dead_code)] // each test reads what it needs of it

use std::collections::BTreeMap;

use serde_json::Value;

use crate::shared;

/// A file of the references; `None` if it is not available.
pub fn read(file: &str) -> Option<Value> {
    let path = shared::path("ode_ref")?.join(file);
    let text = std::fs::read_to_string(path).expect("the references can be read");
    Some(serde_json::from_str(&text).expect("the references are JSON"))
}

/// The value of a number, or of a text that holds a number.
pub fn number(value: &Value) -> f64 {
    let text = value.as_str().map(|s| s.parse().expect("a number"));
    text.or(value.as_f64()).expect("a number or its text")
}

/// The numbers of a nested list, flattened; empty for `null`.
pub fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(numbers).collect(),
        Value::Null => Vec::new(),
        one => vec![number(one)],
    }
}

/// A row of the table of convergence.
pub struct Row {
    /// Number of steps.
    pub n: f64,
    /// Longest step, s.
    pub longest: f64,
    /// Maximum error over states and instants.
    pub error: f64,
    /// Whether the row shows the order of the scheme.
    pub clean: bool,
}

/// One problem.
pub struct Problem {
    /// Its id.
    pub id: String,
    /// Names of its states.
    pub states: Vec<String>,
    /// Parameters by name: a number, or several.
    pub parameters: BTreeMap<String, Vec<f64>>,
    /// Initial state.
    pub y0: Vec<f64>,
    /// The first instant, the instants of the reference and those of jumps, sorted.
    pub grid: Vec<f64>,
    /// Instants of the reference.
    pub instants: Vec<f64>,
    /// The solution at `instants`, row by row.
    pub solution: Vec<f64>,
    /// Table of convergence.
    pub rows: Vec<Row>,
}

impl Problem {
    /// A parameter that is one number.
    pub fn p(&self, name: &str) -> f64 {
        self.parameters[name][0]
    }

    /// The instants of the steps of a row: every interval of the grid is divided into parts of
    /// about the longest step of the first row, which become shorter from row to row.
    fn steps(&self, row: &Row) -> Vec<f64> {
        let first = &self.rows[0];
        let mut instants = vec![self.grid[0]];
        for pair in self.grid.windows(2) {
            let parts = ((pair[1] - pair[0]) / first.longest).round_ties_even().max(1.0) * row.n / first.n;
            let step = (pair[1] - pair[0]) / parts;
            instants.extend((1..parts as usize).map(|k| pair[0] + step * k as f64));
            instants.push(pair[1]);
        }
        assert_eq!(instants.len(), row.n as usize + 1, "{}", self.id);
        instants
    }

    /// Maximum error at the instants of the reference of a solution at `time`, row by row.
    pub fn error(&self, time: &[f64], found: &[f64]) -> f64 {
        let width = self.y0.len();
        let rows = self.instants.iter().zip(self.solution.chunks(width));
        let errors = rows.map(|(t, exact)| {
            let k = time.partition_point(|s| *s < t - 1e-9);
            let row = &found[k * width..(k + 1) * width];
            row.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        });
        errors.fold(0.0, f64::max)
    }

    /// Compares `solve(instants)`, the solution at the instants of all steps, with the clean rows of
    /// the table: the error agrees to 1 % plus the rounding of the steps, and is smaller than in the
    /// row before by a factor of 14.4 to 17.6.
    pub fn hold_against_the_table(&self, solve: &mut dyn FnMut(&[f64]) -> Vec<f64>) {
        let scale = self.solution.iter().fold(1.0f64, |m, y| m.max(y.abs()));
        let mut before: Option<f64> = None;
        for row in &self.rows {
            let time = self.steps(row);
            let error = self.error(&time, &solve(&time));
            if row.clean {
                let rounding = 1e-15 * row.n.sqrt() * scale;
                let off = (error - row.error).abs();
                assert!(
                    off <= 0.01 * row.error + rounding,
                    "{}, {} steps: {error} against {}",
                    self.id,
                    row.n,
                    row.error
                );
                let ratio = before.expect("a clean row has one before it") / error;
                assert!((14.4..17.6).contains(&ratio), "{}, {} steps: ratio {ratio}", self.id, row.n);
            }
            before = Some(error);
        }
    }
}

/// All problems; none if the references are not available.
pub fn problems() -> Vec<Problem> {
    let Some(file) = read("ode_reference.json") else { return Vec::new() };
    let list = file["problems"].as_array().expect("a list of problems");
    list.iter().map(problem).collect()
}

fn problem(value: &Value) -> Problem {
    let text = |v: &Value| v.as_str().expect("a text").to_string();
    let table = &value["rk4_convergence"];
    let clean = numbers(&table["clean_window"]);
    let instants = numbers(&value["t_ref"]);
    let mut grid = [vec![number(&value["t0"])], instants.clone(), numbers(&value["breaks"])].concat();
    grid.sort_by(f64::total_cmp);
    grid.dedup();
    let row = |row: &Value| Row {
        n: number(&row["n"]),
        longest: number(&row["h_max"]),
        error: number(&row["max_abs_error"]),
        clean: clean.contains(&number(&row["n"])),
    };
    Problem {
        id: text(&value["id"]),
        states: value["states"].as_array().expect("states").iter().map(text).collect(),
        parameters: value["params"]
            .as_object()
            .expect("parameters")
            .iter()
            .map(|(name, v)| (name.clone(), numbers(v)))
            .collect(),
        y0: numbers(&value["y0"]),
        grid,
        instants,
        solution: numbers(&value["y_ref"]),
        rows: table["table"].as_array().expect("a table").iter().map(row).collect(),
    }
}
