//! Cross talk: the share of the residual of one joint that the motion of another joint explains.
//!
//! The residual e_j of joint j is regressed on acceleration ddq_k, velocity dq_k and direction (filtered sign of dq_k) of
//! each other joint k. If the model is complete, these three columns explain nearly nothing of |e_j|^2. If they explain much,
//! the motor of joint j also turns with joint k (coupled transmission), and the model lacks the inertia and friction of this
//! motor.

use linear_model::linear_model::{Model, ResidualGroup};
use nalgebra::{Matrix3, Vector3};

use crate::estimators::huber::{Robust, row_factor};
use crate::rows::residual_sums::ResidualSum;

/// The share of the residual of joint `joint` that is explained by the motion of joint `of`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossTalk {
    /// Number of the joint with the residual.
    pub joint: usize,
    /// Number of the joint whose motion explains the residual.
    pub of: usize,
    /// Explained share of the squared residual, 0 to 1.
    pub share: f64,
}

/// Number of motion columns of a joint k: ddq_k, dq_k and the direction.
const CROSS_TALK_COLUMNS: usize = 3;
/// Singular values below this value are treated as zero. The matrix contains the products of the columns, scaled to unit norm.
const SINGULAR_VALUE_TOLERANCE: f64 = 1e-9;

/// Sums from which cross talk is computed: products of the motion columns (ddq_k, dq_k, direction) of each joint k with one
/// another, and with the residual of each joint j.
#[derive(Clone)]
pub struct CrossTalkSums {
    n: usize,
    /// Entry k: products of the three columns of joint k, summed over the samples in which all joints are used with weight 1.
    /// Most samples are of this kind, and the sum over these samples is the same for every residual.
    motions: Vec<Matrix3<f64>>,
    /// Entry j n + k: products of the three columns of joint k, summed over the rows of joint j in the samples that are not
    /// in `motions`.
    more: Vec<Matrix3<f64>>,
    /// Entry j n + k of each vector: product of one column of joint k with the residual of joint j. The three vectors belong
    /// to ddq, dq and direction.
    residuals: [Vec<f64>; CROSS_TALK_COLUMNS],
    /// Entry j: |e_j|^2, the squared residual of joint j.
    squares: Vec<f64>,
    robust: Option<Robust>,
}

impl CrossTalkSums {
    /// Creates empty sums for n joints. `robust`: robust weights of the rows; `None` if all rows have equal weight.
    pub fn new(n: usize, robust: Option<Robust>) -> CrossTalkSums {
        let (none, nothing) = (Matrix3::zeros(), vec![0.0; n * n]);
        let residuals = [nothing.clone(), nothing.clone(), nothing];
        CrossTalkSums { n, motions: vec![none; n], more: vec![none; n * n], residuals, squares: vec![0.0; n], robust }
    }

    /// For each joint, the other joint whose motion explains the largest part of the residual; empty for a single joint.
    pub(crate) fn cross_talk(&self) -> Vec<CrossTalk> {
        let n = self.n;
        let share = |j: usize, k: usize| {
            let right = Vector3::from_fn(|i, _| self.residuals[i][j * n + k]);
            explained(&(self.motions[k] + self.more[j * n + k]), &right, self.squares[j])
        };
        let of_joint = |j: usize| {
            let talk = (0..n).filter(|&k| k != j).map(|k| CrossTalk { joint: j, of: k, share: share(j, k) });
            talk.max_by(|a, b| a.share.total_cmp(&b.share))
        };
        (0..n).filter_map(of_joint).collect()
    }
}

impl ResidualSum for CrossTalkSums {
    fn add(&mut self, _: &Model, group: &ResidualGroup) {
        let (n, states) = (self.n, group.states);
        for (lane, r) in group.samples.clone().enumerate() {
            let at = r * n..(r + 1) * n;
            let (used, columns) = (&states.used[at.clone()], [&states.ddq, &states.dq, &states.direction]);
            let columns = columns.map(|x| &x[at.clone()]);
            let square = |k: usize| {
                let row = Vector3::from_fn(|i, _| columns[i][k]);
                row * row.transpose()
            };
            let all = self.robust.is_none() && used.iter().all(|used| *used);
            if all {
                self.motions.iter_mut().enumerate().for_each(|(k, sum)| *sum += square(k));
            }
            for j in (0..n).filter(|&j| used[j]) {
                let e = group.residuals[j][lane];
                let weight = row_factor(self.robust.as_ref(), j, e).powi(2);
                self.squares[j] += weight * e * e;
                for (sums, column) in self.residuals.iter_mut().zip(columns) {
                    sums[j * n..][..n].iter_mut().zip(column).for_each(|(sum, x)| *sum += weight * e * x);
                }
                if !all {
                    self.more[j * n..][..n].iter_mut().enumerate().for_each(|(k, sum)| *sum += weight * square(k));
                }
            }
        }
    }

    fn append(&mut self, next: Self) {
        self.motions.iter_mut().zip(next.motions).for_each(|(a, b)| *a += b);
        self.more.iter_mut().zip(next.more).for_each(|(a, b)| *a += b);
        let residuals = self.residuals.iter_mut().flatten().zip(next.residuals.into_iter().flatten());
        residuals.for_each(|(a, b)| *a += b);
        self.squares.iter_mut().zip(next.squares).for_each(|(a, b)| *a += b);
    }
}

/// The share (0 to 1) of a squared residual `total` that three columns explain.
///
/// `products`: products of the columns with one another; `with_residual`: products of the columns with the residual.
fn explained(products: &Matrix3<f64>, with_residual: &Vector3<f64>, total: f64) -> f64 {
    let scale = |i: usize| if products[(i, i)] > 0.0 { products[(i, i)].sqrt().recip() } else { 0.0 };
    let gram = Matrix3::from_fn(|i, k| scale(i) * products[(i, k)] * scale(k));
    let right = Vector3::from_fn(|i, _| scale(i) * with_residual[i]);
    // The pseudo-inverse ignores a column that is zero or depends on the other columns.
    let solved = gram.pseudo_inverse(SINGULAR_VALUE_TOLERANCE).map(|inverse| right.dot(&(inverse * right)));
    match solved {
        Ok(square) if total > 0.0 => square / total,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::residual_sums::residual_sums;
    use crate::test_arm::Made;
    use linear_model::friction::terms::sign;
    use linear_model::states::States;
    use random::Random;

    #[test]
    fn a_coupled_motor_is_found() {
        let wheels = Made::new(&[false; 2], 2, |ddq, y| y.copy_from_slice(&[ddq[0], 0.0, 0.0, ddq[1]]));
        let model = Model::new(&wheels, &[], &[]);
        let share = |coupling: f64| {
            let mut random = Random::new(3);
            let mut states = States { n: 2, ..States::default() };
            for r in 0..500 {
                let t = 0.01 * f64::from(r);
                let dq = [(3.0 * t).sin(), (5.0 * t).cos()];
                let ddq = [3.0 * (3.0 * t).cos(), -5.0 * (5.0 * t).sin()];
                states.t.push(t);
                states.q.extend([0.0, 0.0]);
                states.dq.extend(dq);
                states.ddq.extend(ddq);
                states.direction.extend(dq.map(sign));
                let noise = [0.1 * random.normal(), 0.1 * random.normal()];
                let coupled = coupling * (0.2 * ddq[1] + sign(dq[1]));
                states.tau.extend([ddq[0] + coupled + noise[0], 2.0 * ddq[1] + noise[1]]);
                states.used.extend([true, true]);
            }
            let sums = residual_sums(&model, [states].as_slice(), &[1.0, 2.0], CrossTalkSums::new(2, None)).unwrap();
            let talk = sums.cross_talk();
            assert_eq!((talk[0].joint, talk[0].of, talk[1].joint), (0, 1, 1));
            (talk[0].share, talk[1].share)
        };
        let (coupled, other) = share(1.0);
        // The noise has variance 0.01; the mean square of the residual is above 1.
        assert!(coupled > 0.95, "{coupled}");
        // On average, three columns explain the share 3/500 of white noise in 500 rows.
        assert!(other < 0.05 && share(0.0).0 < 0.05, "{other}");
    }
}
