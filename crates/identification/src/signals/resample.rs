//! Resamples the signals of a log to a uniform clock by linear interpolation.

/// Largest number of resampled samples. A requested rate that gives more samples is taken as wrong.
const MAX_RESAMPLED_SAMPLES: f64 = 1e8;
/// Relative margin that is added to a number of periods before rounding down. So a whole number of periods with a rounding
/// error is not rounded down to the next smaller whole number.
const WHOLE_PERIOD_MARGIN: f64 = 1e-12;

/// Times in steps of `period`, s, from the first time of `t` up to at most the last time of `t`. `None` if this gives fewer
/// than two times, or too many.
pub(crate) fn uniform_clock(t: &[f64], period: f64) -> Option<Vec<f64>> {
    let (first, last) = (*t.first()?, *t.last()?);
    let steps = ((last - first) / period * (1.0 + WHOLE_PERIOD_MARGIN)).floor();
    let usable = (1.0..MAX_RESAMPLED_SAMPLES).contains(&steps);
    usable.then(|| (0..=steps as usize).map(|i| first + i as f64 * period).collect())
}

/// Interpolates the samples x at times t linearly at the times `at`. Before the first time of t, the result is the first
/// sample; after the last time, the last sample. `t` and `at` must increase.
pub fn interpolate(t: &[f64], x: &[f64], at: &[f64]) -> Vec<f64> {
    let mut i = 0;
    let value = |&s: &f64| {
        while i + 2 < t.len() && t[i + 1] <= s {
            i += 1;
        }
        let (Some(&t1), Some(&x1)) = (t.get(i + 1), x.get(i + 1)) else { return x.first().copied().unwrap_or(0.0) };
        let share = ((s - t[i]) / (t1 - t[i])).clamp(0.0, 1.0);
        x[i] + share * (x1 - x[i])
    };
    at.iter().map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_survive() {
        let t: Vec<f64> = (0..50).map(|i| 0.1 * i as f64 + 0.02 * (i % 3) as f64).collect();
        let x: Vec<f64> = t.iter().map(|t| 2.0 - 3.0 * t).collect();
        let clock = uniform_clock(&t, 0.07).unwrap();
        for (s, y) in clock.iter().zip(interpolate(&t, &x, &clock)) {
            assert!((y - (2.0 - 3.0 * s)).abs() < 1e-12);
        }
        assert!(clock[clock.len() - 1] <= t[49] && clock[clock.len() - 1] > t[49] - 0.07);
    }

    #[test]
    fn ends_and_absurd_rates() {
        assert_eq!(interpolate(&[0.0, 1.0], &[1.0, 2.0], &[-1.0, 0.5, 9.0]), [1.0, 1.5, 2.0]);
        for period in [0.0, -1.0, f64::NAN, 1e-12, 10.0] {
            assert!(uniform_clock(&[0.0, 1.0], period).is_none(), "{period}");
        }
        assert_eq!(uniform_clock(&[0.0, 0.3], 0.1).unwrap().len(), 4);
    }
}
