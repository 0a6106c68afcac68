//! Fit of the thruster's curve to a bollard-pull table, by least squares for each direction.
//!
//! ```text
//! |F| = (a x² + b x) (V_s/V_ref)ⁿ,     x = max(0, |V| − c)
//! ```
//!
//! a and b (N/V², N/V) are linear and fitted for each direction. The dead band c (as V), common to
//! both, and the exponent n of the supply voltage are fitted by profile: the sum of squares of the
//! best a and b is minimised over each. If a shape parameter is free, all standard deviations come
//! from the linearised joint problem, so that those of a and b include its uncertainty. Source:
//! Avila, Donha and Adamowski, *Ocean Engineering* 60 (2013) 81-94, eq. (1).

mod covariance;

use serde::Serialize;

use self::covariance::{apart, together};
use super::bollard::{Bollard, CurveOptions, DeadBand, FitError, check};
use super::curve::{Coefficients, Supply, ThrustCurve};
use crate::least_squares::{Fit, LeastSquaresError, LeastSquaresOptions, Refinement, least_squares_with};

/// A number and its standard deviation, both in the same unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Standard deviation; 0 for a held number.
    pub std: f64,
}

/// Result for one direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DirectionFit {
    /// Quadratic coefficient, N/V².
    pub a: Estimate,
    /// Linear coefficient, N/V.
    pub b: Estimate,
    /// Number of rows of the table with a command in this direction.
    pub rows: usize,
    /// Standard deviation of the residual, N: sqrt(Σe²/(rows − 2)).
    pub residual_std: f64,
    /// Covariance of a and b, N²/V³.
    pub covariance: f64,
}

/// A fitted curve with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveFit {
    /// The curve; its `max` is the given one, or the table's greatest command if the thrust would
    /// fall beyond it.
    pub curve: ThrustCurve,
    /// Coefficients for V > 0.
    pub forward: DirectionFit,
    /// Coefficients for V < 0.
    pub reverse: DirectionFit,
    /// Dead band, as V.
    pub deadband: Estimate,
    /// Exponent n; `None` if the table has fewer than two supply voltages.
    pub exponent: Option<Estimate>,
    /// Covariance of a and b forward, a and b in reverse, dead band, exponent; 0 for held values.
    pub covariance: [[f64; 6]; 6],
}

/// One of the two directions of a thruster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// V > 0.
    Forward,
    /// V < 0.
    Reverse,
}

impl Direction {
    fn name(self) -> &'static str {
        match self {
            Direction::Forward => "forward",
            Direction::Reverse => "reverse",
        }
    }
}

/// a and b with their covariance, and the residual.
struct Regression {
    coefficients: Vec<f64>,
    covariance: Vec<Vec<f64>>,
    residual_std: f64,
    sum_of_squares: f64,
}

impl From<Fit> for Regression {
    fn from(fit: Fit) -> Regression {
        Regression {
            sum_of_squares: fit.residual_std.powi(2) * (fit.rows - fit.rank) as f64,
            coefficients: fit.coefficients,
            covariance: fit.covariance,
            residual_std: fit.residual_std,
        }
    }
}

/// The profile solves two columns about a thousand times: plain QR is accurate enough for the
/// table.
fn regress(columns: &[&[f64]], y: &[f64]) -> Result<Regression, LeastSquaresError> {
    let options = LeastSquaresOptions { refinement: Refinement::Never, ..LeastSquaresOptions::default() };
    least_squares_with(columns, y, &options).map(Regression::from)
}

/// The rows of one direction, without signs.
struct Side {
    direction: Direction,
    command: Vec<f64>,
    force: Vec<f64>,
    /// ln(V_s/V_ref), zero without a supply voltage.
    log_supply: Vec<f64>,
}

impl Side {
    fn new(table: &Bollard<'_>, direction: Direction, reference: f64, max: f64) -> Result<Side, FitError> {
        let sign = if direction == Direction::Forward { 1.0 } else { -1.0 };
        let mut side = Side { direction, command: vec![], force: vec![], log_supply: vec![] };
        for (row, (&command, &force)) in table.command.iter().zip(table.force).enumerate() {
            if command * sign > 0.0 {
                // beyond `max` the thruster is at its limit
                side.command.push(command.abs().min(max));
                side.force.push(force * sign);
                side.log_supply.push(table.supply.map_or(0.0, |s| (s[row] / reference).ln()));
            }
        }
        if side.command.iter().zip(&side.force).map(|(v, f)| v * f).sum::<f64>() < 0.0 {
            return Err(FitError::WrongSign { direction: direction.name() });
        }
        Ok(side)
    }

    fn greatest(&self) -> f64 {
        self.command.iter().copied().fold(0.0, f64::max)
    }

    /// x and the supply factor of each row.
    fn rows(&self, c: f64, n: f64) -> impl Iterator<Item = (f64, f64)> {
        self.command.iter().zip(&self.log_supply).map(move |(v, l)| ((v - c).max(0.0), (n * l).exp()))
    }

    /// Columns x² k and x k.
    fn columns(&self, c: f64, n: f64) -> [Vec<f64>; 2] {
        self.rows(c, n).map(|(x, k)| (x * x * k, x * k)).unzip::<_, _, Vec<_>, Vec<_>>().into()
    }

    /// The best a and b; with `bounded`, under b ≥ 0.
    fn regress(&self, c: f64, n: f64, bounded: bool) -> Result<Regression, FitError> {
        let direction = self.direction.name();
        let rows = self.command.iter().filter(|v| **v > c).count();
        if rows < 3 {
            return Err(FitError::TooFewRows { direction, rows });
        }
        let [square, linear] = self.columns(c, n);
        let solve =
            |columns: &[&[f64]]| regress(columns, &self.force).map_err(|_| FitError::NotIdentifiable { direction });
        let free = solve(&[&square, &linear])?;
        if !bounded || free.coefficients[1] >= 0.0 {
            return Ok(free);
        }
        let alone = solve(&[&square])?;
        let coefficients = vec![alone.coefficients[0], 0.0];
        Ok(Regression { coefficients, covariance: free.covariance, ..alone })
    }

    /// Sum of squares for the best a and b ≥ 0 (a free dead band and a negative b have the same
    /// effect); infinite if there are none.
    fn cost(&self, c: f64, n: f64) -> f64 {
        self.regress(c, n, true).map_or(f64::INFINITY, |fit| fit.sum_of_squares)
    }

    /// The result for held c and n. With `bounded`, b is kept at 0 or above; without, a b clearly
    /// below 0 is an error.
    fn fit(&self, c: f64, n: f64, bounded: bool) -> Result<DirectionFit, FitError> {
        let free = self.regress(c, n, bounded)?;
        let reach = self.greatest() - c;
        let force = self.force.iter().copied().fold(0.0, f64::max);
        let [a, b] = [0, 1].map(|i| Estimate { value: free.coefficients[i], std: free.covariance[i][i].sqrt() });
        let covariance = free.covariance[0][1];
        // noise, or rounding of a table computed by the formula, may make a b of zero negative;
        // more than that is no thruster
        let slack = (2.0 * b.std * reach).max(1e-9 * force);
        let slope = 2.0 * a.value * reach + b.value;
        if b.value * reach < -slack || slope * reach < -1e-9 * force {
            let direction = self.direction.name();
            return Err(FitError::NotMonotone { direction, a: a.value, a_std: a.std, b: b.value, b_std: b.std });
        }
        let fit = if b.value < 0.0 { self.regress(c, n, true)? } else { free };
        let a = Estimate { value: fit.coefficients[0], ..a };
        let b = Estimate { value: fit.coefficients[1], ..b };
        Ok(DirectionFit { a, b, rows: self.command.len(), residual_std: fit.residual_std, covariance })
    }
}

/// The minimum of f on [low, high]: by a grid, because a dead band gives f kinks, then by golden
/// section about the best grid point.
fn minimum(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    const CELLS: usize = 24;
    let at = |i: usize| low + (high - low) * i as f64 / CELLS as f64;
    let tried = |x: f64| (f(x), x);
    let grid: Vec<(f64, f64)> = (0..=CELLS).map(|i| tried(at(i))).collect();
    let best = (0..=CELLS).min_by(|a, b| grid[*a].0.total_cmp(&grid[*b].0)).unwrap_or(0);
    let (mut left, mut right) = (at(best.saturating_sub(1)), at((best + 1).min(CELLS)));
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    let (mut a, mut b) = (tried(right - golden * (right - left)), tried(left + golden * (right - left)));
    // 0.618³⁴ of two cells is in the eighth digit: beyond it the sum of squares is flat in floating
    // point
    for _ in 0..34 {
        if a.0 <= b.0 {
            (right, b) = (b.1, a);
            a = tried(right - golden * (right - left));
        } else {
            (left, a) = (a.1, b);
            b = tried(left + golden * (right - left));
        }
    }
    // the end of the interval is never inside a bracket
    [a, b, grid[best]].into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(low, |(_, x)| x)
}

/// Fits the whole curve to a bollard table. The exponent n is fitted if the table has more than one
/// supply voltage.
///
/// # Errors
/// Columns of different length, unusable cells or options; fewer than 3 rows in a direction;
/// commands that do not separate the parameters; a force against the command; thrust that falls as
/// the command grows.
pub fn fit_curve(table: &Bollard<'_>, options: &CurveOptions) -> Result<CurveFit, FitError> {
    check(table, options)?;
    let limit = options.max.unwrap_or(f64::INFINITY);
    let reference = options.reference_supply.or_else(|| median(table.supply?)).unwrap_or(1.0);
    let [forward, reverse] = [Direction::Forward, Direction::Reverse].map(|d| Side::new(table, d, reference, limit));
    let (forward, reverse) = (forward?, reverse?);
    let several = table.supply.is_some_and(|s| s.iter().any(|v| (v - s[0]).abs() > 1e-3 * s[0]));

    let cost = |c: f64, n: f64| forward.cost(c, n) + reverse.cost(c, n);
    let widest = 0.5 * forward.greatest().min(reverse.greatest());
    let deadband_at = |n: f64| match options.deadband {
        DeadBand::Given(c) => c,
        DeadBand::Fitted => minimum(0.0, widest, |c| cost(c, n)),
    };
    // limits of the search; propeller theory gives 1 to 2
    let (least, most) = (-1.0, 4.0);
    let n = if several { minimum(least, most, |n| cost(deadband_at(n), n)) } else { 0.0 };
    let c = deadband_at(n);
    let near = |x: f64, end: f64| (x - end).abs() <= 1e-6 * end.abs();
    if several && (near(n, least) || near(n, most)) {
        return Err(FitError::AtEnd { parameter: "supply exponent", value: n });
    }
    if options.deadband == DeadBand::Fitted && near(c, widest) {
        return Err(FitError::AtEnd { parameter: "dead band", value: c });
    }

    let free = [options.deadband == DeadBand::Fitted, several];
    let mut sides = [forward.fit(c, n, free[0])?, reverse.fit(c, n, free[0])?];
    let (mut deadband, mut exponent) = (Estimate { value: c, std: 0.0 }, None);
    let mut covariance = apart(&sides);
    if free != [false; 2] {
        covariance = together([&forward, &reverse], &sides, c, n, free)?;
        let std = |j: usize| covariance[j][j].sqrt();
        for (k, side) in sides.iter_mut().enumerate() {
            (side.a.std, side.b.std) = (std(2 * k), std(2 * k + 1));
            side.covariance = covariance[2 * k][2 * k + 1];
        }
        deadband.std = std(4);
        exponent = several.then_some(Estimate { value: n, std: std(5) });
    }
    let [forward_fit, reverse_fit] = sides;
    let coefficients = |fit: &DirectionFit| Coefficients { a: fit.a.value, b: fit.b.value };
    let turns = forward_fit.a.value < 0.0 || reverse_fit.a.value < 0.0;
    let curve = ThrustCurve {
        forward: coefficients(&forward_fit),
        reverse: coefficients(&reverse_fit),
        deadband: c,
        max: if turns { forward.greatest().min(reverse.greatest()) } else { limit },
        supply: exponent.map(|n| Supply { reference, exponent: n.value }),
    };
    Ok(CurveFit { curve, forward: forward_fit, reverse: reverse_fit, deadband, exponent, covariance })
}

fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thrust::noise::Noise;

    /// The paper's thruster at ± 0.1 … ± 4 V, with noise of `std` N.
    fn paper_table(deadband: f64, supplies: &[f64], std: f64, noise: &mut Noise) -> [Vec<f64>; 3] {
        let curve = ThrustCurve {
            deadband,
            supply: Some(Supply { reference: 16.0, exponent: 1.3 }),
            ..ThrustCurve::new(Coefficients { a: 11.53, b: 4.21 }, Coefficients { a: 7.87, b: 4.68 })
        };
        let mut table = [vec![], vec![], vec![]];
        for &supply in supplies {
            for step in (-40..=40).filter(|s| *s != 0) {
                let voltage = 0.1 * f64::from(step);
                table[0].push(voltage);
                table[1].push(curve.force_at(voltage, supply) + std * noise.normal());
                table[2].push(supply);
            }
        }
        table
    }

    fn fit(table: &[Vec<f64>; 3], deadband: DeadBand) -> Result<CurveFit, FitError> {
        let rows = Bollard { command: &table[0], force: &table[1], supply: Some(&table[2]) };
        fit_curve(&rows, &CurveOptions { deadband, reference_supply: Some(16.0), max: None })
    }

    #[test]
    fn paper_thruster_is_found_from_its_own_curve() {
        let table = paper_table(0.0, &[16.0], 0.0, &mut Noise::new(1));
        let found = fit(&table, DeadBand::Given(0.0)).unwrap();
        // no noise, condition of the columns about 10: rounding only
        for (side, a, b) in [(found.forward, 11.53, 4.21), (found.reverse, 7.87, 4.68)] {
            assert!((side.a.value - a).abs() < 1e-11 && (side.b.value - b).abs() < 1e-11);
            assert_eq!(side.rows, 40);
        }
        assert_eq!(found.exponent, None);
    }

    #[test]
    fn exact_dead_band_and_supply_exponent_are_found() {
        let found = fit(&paper_table(0.23, &[12.0, 16.0, 20.0], 0.0, &mut Noise::new(1)), DeadBand::Fitted).unwrap();
        // golden section ends where the sum of squares is flat in floating point, at half the digits
        assert!((found.deadband.value - 0.23).abs() < 1e-6, "{found:?}");
        assert!((found.exponent.unwrap().value - 1.3).abs() < 1e-6);
        assert!((found.forward.a.value - 11.53).abs() < 1e-4 && (found.reverse.b.value - 4.68).abs() < 1e-4);
        found.curve.validate().unwrap();
    }

    #[test]
    fn law_standard_deviations_cover_the_truth_68_times_in_100() {
        let mut noise = Noise::new(20_130_301);
        // forward a and b with nothing else free; then the dead band, then the exponent, each with its a
        let mut within = [0; 6];
        for _ in 0..200 {
            let held = fit(&paper_table(0.0, &[16.0], 0.5, &mut noise), DeadBand::Given(0.0)).unwrap();
            let band = fit(&paper_table(0.23, &[16.0], 0.5, &mut noise), DeadBand::Fitted).unwrap();
            let supply = fit(&paper_table(0.23, &[12.0, 20.0], 0.5, &mut noise), DeadBand::Given(0.23)).unwrap();
            let truths = [
                (held.forward.a, 11.53),
                (held.forward.b, 4.21),
                (band.forward.a, 11.53),
                (band.deadband, 0.23),
                (supply.forward.a, 11.53),
                (supply.exponent.unwrap(), 1.3),
            ];
            for (count, (estimate, truth)) in within.iter_mut().zip(truths) {
                *count += usize::from((estimate.value - truth).abs() < estimate.std);
            }
        }
        for count in within {
            // 68.3 % of 200 is 137, with a binomial spread of 6.6: four of them, for six tallies
            assert!((110..=163).contains(&count), "{within:?}");
        }
    }

    #[test]
    fn noise_does_not_trade_the_dead_band_for_a_negative_b() {
        let mut noise = Noise::new(7);
        for _ in 0..50 {
            let found = fit(&paper_table(0.23, &[16.0], 3.0, &mut noise), DeadBand::Fitted).unwrap();
            found.curve.validate().unwrap();
        }
    }

    #[test]
    fn a_purely_quadratic_thruster_is_no_nonsense() {
        let command: Vec<f64> = (-20..=20).map(f64::from).collect();
        let force: Vec<f64> = command.iter().map(|v| 3.0 * v * v.abs()).collect();
        let rows = Bollard { command: &command, force: &force, supply: None };
        let found = fit_curve(&rows, &CurveOptions::default()).unwrap();
        assert!((found.forward.a.value - 3.0).abs() < 1e-12 && found.forward.b.value >= 0.0);
        found.curve.validate().unwrap();
    }

    #[test]
    fn nonsense_is_refused_with_its_reason() {
        let command = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0];
        let fit =
            |force: &[f64]| fit_curve(&Bollard { command: &command, force, supply: None }, &CurveOptions::default());
        let falling = fit(&[-9.0, -4.0, -1.0, 0.0, 10.0, 11.0, 1.0]).unwrap_err();
        assert!(matches!(falling, FitError::NotMonotone { direction: "forward", .. }), "{falling}");
        let against = fit(&[9.0, 4.0, 1.0, 0.0, 1.0, 4.0, 9.0]).unwrap_err();
        assert_eq!(against, FitError::WrongSign { direction: "reverse" });
        let halves = [10.0, 20.0].map(|supply| command.map(|v| (v, v * v.abs() * (supply / 10.0_f64).powi(6), supply)));
        let [v, f, s] =
            [0, 1, 2].map(|i| halves.iter().flatten().map(|row| [row.0, row.1, row.2][i]).collect::<Vec<_>>());
        let wild = Bollard { command: &v, force: &f, supply: Some(&s) };
        let error = fit_curve(&wild, &CurveOptions::default()).unwrap_err();
        assert!(matches!(error, FitError::AtEnd { parameter: "supply exponent", .. }), "{error}");
        let few = Bollard { command: &[1.0, 2.0, 3.0, -1.0], force: &[1.0, 4.0, 9.0, -1.0], supply: None };
        let error = fit_curve(&few, &CurveOptions::default()).unwrap_err();
        assert_eq!(error, FitError::TooFewRows { direction: "reverse", rows: 1 });
        let same = Bollard { command: &[2.0; 4], force: &[4.0, 4.1, 3.9, 4.0], supply: None };
        let error = Side::new(&same, Direction::Forward, 1.0, f64::INFINITY).unwrap().fit(0.0, 0.0, false).unwrap_err();
        assert_eq!(error, FitError::NotIdentifiable { direction: "forward" });
    }
}
