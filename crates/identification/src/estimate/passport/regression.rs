//! A signal on few columns: least squares with what each column explains of its own.
//!
//! The columns F that belong to any description (friction, rotor, offset) are taken out of the signal y and of the
//! column x by orthogonalisation: y' = y - P_F y, x' = x - P_F x. Then the slope is x'.y' / x'.x', and the share
//! that x explains of what F leaves is (x'.y')^2 / (x'.x' y'.y').

/// Share explained by the description, above which a joint's slope counts. Below it the slope is in brackets.
pub(crate) const COUNTED_SLOPE_SHARE: f64 = 0.5;

/// A column that keeps less than this share of its norm beside the columns before it is rounding.
const DEPENDENT_COLUMN_SHARE: f64 = 1e-9;

/// Orthonormal columns of equal length.
#[derive(Clone, Debug, Default)]
pub(crate) struct Basis(Vec<Vec<f64>>);

impl Basis {
    /// The space of these columns; those that are no more than rounding beside the others span nothing.
    pub(crate) fn of(columns: Vec<Vec<f64>>) -> Basis {
        let mut basis = Basis::default();
        for column in columns {
            let norm = square(&column).sqrt();
            // Orthogonalising twice is enough to be orthogonal to rounding.
            let mut column = basis.without(basis.without(column));
            let left = square(&column).sqrt();
            if left > DEPENDENT_COLUMN_SHARE * norm {
                column.iter_mut().for_each(|x| *x /= left);
                basis.0.push(column);
            }
        }
        basis
    }

    /// Number of independent columns.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// What the columns leave of a signal.
    pub(crate) fn without(&self, mut signal: Vec<f64>) -> Vec<f64> {
        for column in &self.0 {
            let share = product(column, &signal);
            signal.iter_mut().zip(column).for_each(|(x, c)| *x -= share * c);
        }
        signal
    }
}

/// A signal y and a column x, both without the columns of a basis, by their products.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Partial {
    /// y'.y', x'.x', x'.y'.
    pub yy: f64,
    pub xx: f64,
    pub xy: f64,
}

impl Partial {
    /// From signals of which the basis has been taken out.
    pub(super) fn of(y: &[f64], x: &[f64]) -> Partial {
        Partial { yy: square(y), xx: square(x), xy: product(x, y) }
    }

    /// y per x; 0 for a column of zeros.
    pub(super) fn slope(&self) -> f64 {
        if self.xx > 0.0 { self.xy / self.xx } else { 0.0 }
    }

    /// Share of y'.y' that the column explains, 0 to 1.
    pub(super) fn share(&self) -> f64 {
        let both = self.xx * self.yy;
        if both > 0.0 { (self.xy * self.xy / both).min(1.0) } else { 0.0 }
    }

    /// Share of y'.y' that is left with this slope; above 1 where the column makes it worse.
    pub(super) fn left(&self, slope: f64) -> f64 {
        if self.yy > 0.0 { (1.0 - slope * (2.0 * self.xy - slope * self.xx) / self.yy).max(0.0) } else { 0.0 }
    }

    /// The square of the column over that of the signal, which is its share there with slope 1.
    pub(super) fn weight(&self) -> f64 {
        if self.yy > 0.0 { self.xx / self.yy } else { 0.0 }
    }
}

/// |x|^2.
pub(crate) fn square(x: &[f64]) -> f64 {
    product(x, x)
}

/// x . y.
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
        // Noise of 0.1 over 400 rows: five standard errors are 0.025; its share of the variance is 0.02.
        assert!((partial.slope() - 0.7).abs() < 0.025, "{partial:?}");
        assert!((partial.share() - 0.98).abs() < 0.01 && (partial.left(0.7) - 0.02).abs() < 0.01);
        assert!(partial.left(-0.7) > 3.0);
        assert_eq!(Partial::of(&[0.0], &[0.0]), Partial::default());
        assert_eq!((Partial::default().slope(), Partial::default().share()), (0.0, 0.0));
    }
}
