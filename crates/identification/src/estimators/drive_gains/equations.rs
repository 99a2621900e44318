//! The equations of one joint in currents, (D X + t) / k = I + noise, which `likelihood` solves. D: rows of the regressor, X:
//! parameters, t: torque of a known load, k: drive gain, I: currents.
//!
//! Nuisance parameters such as friction are eliminated by a triangle (R of the QR decomposition of the rows) in which the
//! columns of the nuisance parameters come first. The rows of the triangle below these columns contain all information on the
//! other parameters. The last diagonal entry of the triangle is the norm of the residual.

use numerics::triangle::TriangleBuilder;
use numerics::vector::dot;

/// The equations of one joint in currents: `rows[r]` X + `known[r]` = k `current[r]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointEquations {
    /// The rows of D, each with p coefficients.
    pub rows: Vec<Vec<f64>>,
    /// Torque t of the known load in each row, in the unit of `rows[r]` X.
    pub known: Vec<f64>,
    /// Currents I, A, one per row.
    pub current: Vec<f64>,
    /// The data from which the noise of the currents is estimated. `None`: the rows are scaled so that the noise of each current
    /// is 1.
    pub scatter: Option<NoiseEvidence>,
}

/// The data from which the noise of a joint is estimated. The noise is equal in all rows of the joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseEvidence {
    /// Part of the residual sum of squares of the currents, A^2, that no values of the parameters can reduce. The residuals of
    /// `rows` are not part of this sum.
    pub left: f64,
    /// Number of independent equations from which `rows` and `left` were computed.
    pub equations: f64,
}

/// Least mean square residual that is used for the noise, divided by the mean square current. The value is the square of the
/// relative rounding error of currents, 1e-10.
const ROUNDING_SQUARE_SHARE: f64 = 1e-20;
/// Least number of degrees of freedom for the noise, as a share of the number of equations. This limit is used if there are
/// nearly as many unknowns as equations.
const LEAST_EQUATIONS_SHARE: f64 = 0.1;

impl JointEquations {
    /// Makes equations without nuisance columns: the rows of the triangle below these columns.
    ///
    /// `rows[r]` has `nuisance` nuisance columns, then p parameters. The weight of the rows is known up to a factor, which
    /// follows from the residual. The known torque is a column of the same triangle, after the parameters.
    pub(crate) fn without_nuisance(
        rows: &[Vec<f64>],
        known: &[f64],
        current: &[f64],
        nuisance: usize,
    ) -> JointEquations {
        let Some(width) = rows.first().map(Vec::len) else { return JointEquations::default() };
        let mut block = TriangleBuilder::new(width + 1);
        let mut longer = vec![0.0; width + 1];
        for (row, (&known, &y)) in rows.iter().zip(known.iter().zip(current)) {
            longer[..width].copy_from_slice(row);
            longer[width] = known;
            block.push(&longer, y);
        }
        let triangle = block.finish();
        let at = |i: usize, j: usize| if j >= i { triangle.at(i, j) } else { 0.0 };
        // The nuisance columns of other joints are zero here and are not counted.
        let used = (0..nuisance).filter(|&c| triangle.column_norm(c) > 0.0).count();
        // The last row that is kept belongs to the column of the known torque.
        let kept = nuisance..width + 1;
        JointEquations {
            rows: kept.clone().map(|i| (nuisance..width).map(|j| at(i, j)).collect()).collect(),
            known: kept.clone().map(|i| at(i, width)).collect(),
            current: kept.map(|i| at(i, width + 1)).collect(),
            scatter: Some(NoiseEvidence {
                left: triangle.at(width + 1, width + 1).powi(2),
                equations: rows.len().saturating_sub(used).max(1) as f64,
            }),
        }
    }

    pub(crate) fn each(&self) -> impl Iterator<Item = (&Vec<f64>, f64, f64)> {
        self.rows.iter().zip(&self.known).zip(&self.current).map(|((d, t), i)| (d, *t, *i))
    }

    /// The residual sum of squares |I - g (D X + t)|^2 of the rows, with g = 1/k.
    pub(crate) fn squares(&self, x: &[f64], g: f64) -> f64 {
        self.each().map(|(d, t, i)| (i - g * (dot(d, x) + t)).powi(2)).sum()
    }

    /// The standard deviation of the noise of the currents at (X, g = 1/k). `used`: degrees of freedom that the unknowns take
    /// from the equations of this joint.
    pub(crate) fn noise(&self, x: &[f64], g: f64, used: f64) -> f64 {
        let Some(scatter) = self.scatter else { return 1.0 };
        let total: f64 = scatter.left + self.current.iter().map(|i| i * i).sum::<f64>();
        let left = (scatter.left + self.squares(x, g)).max(ROUNDING_SQUARE_SHARE * total);
        let equations = (scatter.equations - used).max(LEAST_EQUATIONS_SHARE * scatter.equations);
        (left / equations).sqrt().max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    #[test]
    fn nuisance_is_projected_out_of_the_known_torque_too() {
        let mut random = Random::new(6);
        let (mut rows, mut known, mut current) = (vec![], vec![], vec![]);
        for _ in 0..40 {
            let row: Vec<f64> = (0..5).map(|_| random.normal()).collect();
            // The torque of the known load is correlated with the friction column.
            known.push(random.normal() + 2.0 * row[0]);
            current.push(7.0 * row[0] - 3.0 * row[1] + 0.5 * row[2] + 0.2 * row[3] - row[4] + known[known.len() - 1]);
            rows.push(row);
        }
        let e = JointEquations::without_nuisance(&rows, &known, &current, 2);
        assert_eq!(e.rows.len(), 4);
        for (d, t, i) in e.each() {
            let torque = 0.5 * d[0] + 0.2 * d[1] - d[2] + t;
            // The allowed error is the rounding of forty rows.
            assert!((torque - i).abs() < 1e-12);
        }
        // The residual sum of squares is at most the square of the rounding error above.
        assert!(e.scatter.unwrap().left < 1e-24 && e.scatter.unwrap().equations == 38.0);
    }
}
