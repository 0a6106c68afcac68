//! Reduction of points without change of the picture: of each run of neighbouring points the lowest
//! and the highest are kept.
//!
//! A column of pixels shows the line between the smallest and the largest value that fall on it. So
//! the extremes of as many runs as there are columns draw the same line as all points.

/// Indices of at most about `limit` of the values `y`, increasing: the first, the last, and the
/// extremes of limit/2 runs of equal length. A gap (a value that is not finite) is kept once per
/// run.
pub fn decimate(y: &[f64], limit: usize) -> Vec<usize> {
    if y.len() <= limit.max(4) {
        return (0..y.len()).collect();
    }
    let runs = (limit / 2).max(1);
    let mut kept = vec![0];
    for run in 0..runs {
        let (from, to) = (run * y.len() / runs, (run + 1) * y.len() / runs);
        let finite = || (from..to).filter(|k| y[*k].is_finite());
        let lowest = finite().min_by(|a, b| y[*a].total_cmp(&y[*b]));
        let highest = finite().max_by(|a, b| y[*a].total_cmp(&y[*b]));
        let gap = (from..to).find(|k| !y[*k].is_finite());
        let mut found: Vec<usize> = [lowest, highest, gap].into_iter().flatten().collect();
        found.sort_unstable();
        kept.extend(found);
    }
    kept.push(y.len() - 1);
    kept.dedup();
    kept
}

/// Indices of about `limit` of the scattered values `y`, increasing: every n-th, and the extremes
/// of the series in limit/10 runs. With the extremes alone a cloud of points would look like its
/// two edges.
pub fn thin(y: &[f64], limit: usize) -> Vec<usize> {
    let stride = y.len().div_ceil(limit.max(1)).max(1);
    let mut kept: Vec<usize> = (0..y.len()).step_by(stride).collect();
    if stride > 1 {
        kept.extend(decimate(y, limit / 10));
        kept.sort_unstable();
        kept.dedup();
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_ends_and_gaps_stay() {
        let mut y: Vec<f64> = (0..100_000).map(|k| (f64::from(k) * 0.01).sin()).collect();
        y[31_415] = 7.0;
        y[77_777] = -9.0;
        y[50_000] = f64::NAN;
        let kept = decimate(&y, 1000);
        assert!(kept.len() <= 1003, "{} points", kept.len());
        for k in [0, 31_415, 50_000, 77_777, 99_999] {
            assert!(kept.contains(&k), "{k} is lost");
        }
        assert!(kept.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn a_thinned_cloud_keeps_its_middle_and_its_extremes() {
        let mut y: Vec<f64> = (0..10_000).map(|k| f64::from(k * 7919 % 1000) / 1000.0).collect();
        y[1234] = 5.0;
        let kept = thin(&y, 500);
        assert!(kept.len() < 570 && kept.contains(&1234));
        assert!(kept.iter().filter(|k| (0.25..0.75).contains(&y[**k])).count() > 200);
        assert_eq!(thin(&y[..10], 500).len(), 10);
    }

    #[test]
    fn short_series_are_left_alone() {
        assert_eq!(decimate(&[1.0, 2.0, 3.0], 100), vec![0, 1, 2]);
        assert!(decimate(&[], 100).is_empty());
        assert_eq!(decimate(&[f64::NAN; 50], 10).len(), 6);
    }
}
