//! Partial regression of a signal y on one column x, with a few other columns F (friction, rotor, offset) projected out.
//!
//! y' = y - P_F y and x' = x - P_F x, with the projector P_F onto the span of F. The slope is x'.y' / x'.x'. y'.y' is the
//! squared residual of a fit by F alone; x explains the share (x'.y')^2 / (x'.x' y'.y') of this squared residual.

/// The slope (measured / nominal torque) of a joint is meaningful if the description explains more than this share of the
/// torque. Otherwise the slope is printed in brackets.
pub(crate) const COUNTED_SLOPE_SHARE: f64 = 0.5;

/// A column is linearly dependent on other columns if less than this share of its norm remains after projection onto the
/// orthogonal complement of the other columns.
const DEPENDENT_COLUMN_SHARE: f64 = 1e-9;

/// An orthonormal basis; the columns have equal length.
#[derive(Clone, Debug, Default)]
pub(crate) struct Basis(Vec<Vec<f64>>);

impl Basis {
    /// An orthonormal basis of the span of these columns; dependent columns are dropped.
    pub(crate) fn of(columns: Vec<Vec<f64>>) -> Basis {
        let mut basis = Basis::default();
        for column in columns {
            let norm = square(&column).sqrt();
            // A second projection makes the columns orthogonal up to rounding.
            let mut column = basis.without(basis.without(column));
            let left = square(&column).sqrt();
            if left > DEPENDENT_COLUMN_SHARE * norm {
                column.iter_mut().for_each(|x| *x /= left);
                basis.0.push(column);
            }
        }
        basis
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// Projects a signal onto the complement of the basis.
    pub(crate) fn without(&self, mut signal: Vec<f64>) -> Vec<f64> {
        for column in &self.0 {
            let share = product(column, &signal);
            signal.iter_mut().zip(column).for_each(|(x, c)| *x -= share * c);
        }
        signal
    }
}

/// The products of a signal y and a column x, both projected onto the complement of a basis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Partial {
    /// The scalar products y'.y', x'.x' and x'.y'.
    pub yy: f64,
    pub xx: f64,
    pub xy: f64,
}

impl Partial {
    /// Makes the products from the projected signal y and the projected column x.
    pub(super) fn of(y: &[f64], x: &[f64]) -> Partial {
        Partial { yy: square(y), xx: square(x), xy: product(x, y) }
    }

    /// The regression slope of y on x; 0 for a column of zeros.
    pub(super) fn slope(&self) -> f64 {
        if self.xx > 0.0 { self.xy / self.xx } else { 0.0 }
    }

    /// Share of y'.y' that the column x explains, 0 to 1.
    pub(super) fn share(&self) -> f64 {
        let both = self.xx * self.yy;
        if both > 0.0 { (self.xy * self.xy / both).min(1.0) } else { 0.0 }
    }

    /// Squared residual with a given slope, divided by y'.y'. The result is above 1 if the column with this slope increases the
    /// residual.
    pub(super) fn residual(&self, slope: f64) -> f64 {
        if self.yy > 0.0 { (1.0 - slope * (2.0 * self.xy - slope * self.xx) / self.yy).max(0.0) } else { 0.0 }
    }

    /// The ratio x'.x' / y'.y'. If x is the nominal and y the measured torque: squared nominal / squared measured torque.
    pub(super) fn weight(&self) -> f64 {
        if self.yy > 0.0 { self.xx / self.yy } else { 0.0 }
    }
}

/// The squared norm |x|^2.
pub(crate) fn square(x: &[f64]) -> f64 {
    product(x, x)
}

/// The scalar product x . y.
pub(super) fn product(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    #[test]
    fn slopes_beside_other_columns_come_back() {
        let mut random = Random::new(4);
        let mut column = || (0..400).map(|_| random.normal()).collect::<Vec<f64>>();
        let (f, g, x, noise) = (column(), column(), column(), column());
        let mixed: Vec<f64> = (0..400).map(|i| x[i] + 3.0 * f[i]).collect();
        let y: Vec<f64> = (0..400).map(|i| 0.7 * mixed[i] - 2.0 * f[i] + 5.0 * g[i] + 0.1 * noise[i]).collect();
        let basis = Basis::of(vec![f.clone(), g, f]);
        assert_eq!(basis.0.len(), 2, "a column twice spans nothing more");
        let partial = Partial::of(&basis.without(y), &basis.without(mixed));
        // Noise of 0.1 in 400 rows: five standard errors of the slope are 0.025. The share of the noise in the variance is
        // 0.02.
        assert!((partial.slope() - 0.7).abs() < 0.025, "{partial:?}");
        assert!((partial.share() - 0.98).abs() < 0.01 && (partial.residual(0.7) - 0.02).abs() < 0.01);
        assert!(partial.residual(-0.7) > 3.0);
        assert_eq!(Partial::of(&[0.0], &[0.0]), Partial::default());
        assert_eq!((Partial::default().slope(), Partial::default().share()), (0.0, 0.0));
    }
}
