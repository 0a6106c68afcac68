//! Order statistics.

/// Quantile `p` of the values (nearest rank); `None` without values.
pub fn quantile(values: impl IntoIterator<Item = f64>, p: f64) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    let last = values.len().checked_sub(1)?;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
    let rank = ((last as f64) * p.clamp(0.0, 1.0)).round() as usize;
    let (_, x, _) = values.select_nth_unstable_by(rank.min(last), f64::total_cmp);
    Some(*x)
}

/// Median (of an even number of values the upper of the two middle ones); `None` without values.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    quantile(values, 0.5)
}

/// Smallest and largest value; `None` without values.
pub fn range(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values.into_iter().fold(None, |r, x| match r {
        None => Some((x, x)),
        Some((a, b)) => Some((x.min(a), x.max(b))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_statistics() {
        assert_eq!(median([3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(quantile((0..101).map(f64::from), 0.9), Some(90.0));
        assert_eq!(median([]), None);
        assert_eq!(range([2.0, -1.0, 5.0]), Some((-1.0, 5.0)));
    }
}
