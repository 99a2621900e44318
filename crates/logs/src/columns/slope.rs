//! Regression of a velocity on the derivative of a position.
//!
//! ```text
//! s_r = (q_{r+1} - q_{r-1}) / (t_{r+1} - t_{r-1})       ratio = sum_r v_r s_r / sum_r s_r^2
//! ```

/// The regression of a velocity on the derivative of a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slope {
    /// Velocity per derivative of the position.
    pub ratio: f64,
    /// Squared correlation of velocity and derivative, whose means are not subtracted. NaN if one of them is zero in all rows.
    pub squared_correlation: f64,
}

impl Slope {
    /// The regression of the velocity `v` on the derivative of `q` over the clock `t`. Without a clock, successive rows are one
    /// unit of time apart. Rows with a number that is not finite are left out.
    pub(crate) fn of(q: &[f64], v: &[f64], t: Option<&[f64]>) -> Slope {
        let rows = q.len().min(v.len()).min(t.map_or(usize::MAX, <[f64]>::len));
        let [mut vs, mut ss, mut vv] = [0.0; 3];
        for k in 1..rows.saturating_sub(1) {
            let slope = (q[k + 1] - q[k - 1]) / t.map_or(2.0, |t| t[k + 1] - t[k - 1]);
            if slope.is_finite() && v[k].is_finite() {
                (vs, ss, vv) = (vs + v[k] * slope, ss + slope * slope, vv + v[k] * v[k]);
            }
        }
        Slope { ratio: vs / ss, squared_correlation: vs * vs / (ss * vv) }
    }

    /// The ratio, if it is positive (velocity and derivative have the same sign) and if the squared correlation is large
    /// enough.
    pub(crate) fn positive_ratio(self, min_squared_correlation: f64) -> Option<f64> {
        (self.ratio > 0.0 && self.squared_correlation > min_squared_correlation).then_some(self.ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ratio_counts_the_clock_and_skips_gaps() {
        let t: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k)).collect();
        let mut q: Vec<f64> = t.iter().map(|t| (2.0 * t).sin()).collect();
        let v: Vec<f64> = t.iter().map(|t| 3.0 * 2.0 * (2.0 * t).cos()).collect();
        q[50] = f64::NAN;
        // Central differences of a sine of 2 rad/s err by (0.02)^2 / 6.
        let found = Slope::of(&q, &v, Some(&t));
        assert!((found.ratio / 3.0 - 1.0).abs() < 1e-4 && found.squared_correlation > 0.999, "{found:?}");
        assert!((Slope::of(&q, &v, None).ratio / 300.0 - 1.0).abs() < 1e-4);
        let reversed: Vec<f64> = v.iter().map(|v| -v).collect();
        assert_eq!(Slope::of(&q, &reversed, None).positive_ratio(0.9), None);
        assert!(Slope::of(&q, &[0.0; 200], None).squared_correlation.is_nan());
    }
}
