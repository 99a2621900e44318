//! Whether the model explains the experiments, and cluster-robust standard deviations if it does not.
//!
//! The noise of torque and position is measured from the scatter between periods, before any fit. Only the harmonics of the
//! equations are used, because chatter of a controller at higher frequencies would hide errors of the model. With this noise
//!   chi^2 / freedom = sum (rho / sigma)^2 / (rows - unknowns)
//! is at most about 2 if the model contains every effect in the torques. Elastic joints, play, ripple, late torques
//! and another friction law repeat from period to period. So they do not raise the scatter between periods, but they raise
//! chi^2.
//!
//! If chi^2 is large, the residual is not noise. Then the rows of one experiment and one joint are a cluster g, and the
//! clusters are treated as independent samples of the residual. The variance of the unknowns x is
//!   var x = a (G - 1) / G sum_g S_g S_g',   S_g = (A - k A_g)^-1 W_g' rho_g     [Liang, Zeger 1986; Bell, McCaffrey 2002]
//! W_g: weighted rows of cluster g in the columns of the parameters and the friction; rho_g: their residuals; A_g = W_g' W_g; A
//! = sum_g A_g; G: number of clusters. The unknowns of a single experiment (drift, ends of the record) are eliminated from its
//! rows first. k is 19/20, as for the blocks of a log (`estimators::replicate_deviation`). With k < 1 a direction that only one
//! experiment determines keeps a finite variance.
//!
//! a grows with chi^2 / freedom of the joint with the largest value. a is 0 up to `NOISE_CHI_SQUARE` and 1 from
//! `LACKING_MODEL_CHI_SQUARE` on, so that an interval is a continuous function of chi^2. Each joint is evaluated separately,
//! because in the total, chatter of other joints would hide the misfit of one joint.

use numerics::least_squares::solve;
use numerics::triangle::{Triangle, TriangleBuilder};

use crate::estimate::claims::{LACKING_MODEL_CHI_SQUARE, NOISE_CHI_SQUARE};
use crate::estimators::clusters::{Cluster, FullNormalMatrix, REMAINDER_ROUNDING_SHARE};
use crate::estimators::drive_gains::likelihood::Gain;
use crate::spectrum::rist_mh::data::HarmonicData;
use crate::spectrum::rist_mh::fit::IterationState;

/// k in S_g = (A - k A_g)^-1 W_g' rho_g (see the module): the share of a cluster that is subtracted from A.
const CLUSTER_LEVERAGE_SHARE: f64 = 0.95;

/// The misfit between the model and the experiments.
#[derive(Clone, Debug, PartialEq)]
pub struct Misfit {
    /// chi^2 per degree of freedom of each joint, computed with the measured noise. Infinite if no noise was measured.
    pub joints: Vec<f64>,
    /// chi^2 per degree of freedom of all joints together.
    pub total: f64,
    /// chi^2 of all rows, with the measured noise.
    pub chi_square: f64,
    /// Degrees of freedom of all rows.
    pub freedom: f64,
    /// Standard deviations of parameters and friction with experiments as clusters; zero if there are too few experiments.
    /// Empty if noise explains the residual of every joint.
    pub by_experiment: Vec<f64>,
    /// Standard deviations of the drive gains with experiments as clusters, N m per unit of current, one per joint; zero for
    /// known gains.
    pub gains_by_experiment: Vec<f64>,
}

impl Misfit {
    /// Whether the model lacks an effect, because chi^2 per degree of freedom is too large. False if no noise was measured.
    pub fn is_lacking(&self) -> bool {
        self.total.is_finite() && self.total > LACKING_MODEL_CHI_SQUARE
    }

    /// Whether the residual is larger than noise explains. False if no noise was measured.
    pub fn is_beyond_noise(&self) -> bool {
        self.total.is_finite() && self.total > NOISE_CHI_SQUARE
    }

    /// Factor a of the variance from clusters (see the module): 0 if noise explains the residual, 1 if the model lacks an
    /// effect; between these limits, a grows linearly with chi^2.
    fn beyond_noise(&self) -> f64 {
        let most = self.joints.iter().copied().fold(self.total, f64::max);
        let share = (most - NOISE_CHI_SQUARE) / (LACKING_MODEL_CHI_SQUARE - NOISE_CHI_SQUARE);
        if most.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }
    }
}

impl HarmonicData<'_> {
    /// The misfit of a converged fit. `gains`: prior knowledge of the gains; empty if all are known.
    pub(crate) fn misfit(&self, fit: &IterationState, gains: &[Gain]) -> Misfit {
        let mut misfit = self.residual_squares(fit);
        let beyond = misfit.beyond_noise();
        if beyond > 0.0 {
            let mut x = fit.shared();
            let shared = x.len();
            // The unknown that belongs to a gain is the change from the present gain. At the converged fit, this change is
            // zero.
            x.extend(gains.iter().filter(|g| g.is_unknown()).map(|_| 0.0));
            let mut found = by_experiment(&fit.clusters(self, gains), &x);
            found.iter_mut().for_each(|deviation| *deviation *= beyond.sqrt());
            let mut of_gains = found.split_off(shared).into_iter();
            let next = |g: &Gain| if g.is_unknown() { of_gains.next().unwrap_or(0.0) } else { 0.0 };
            misfit.gains_by_experiment = gains.iter().map(next).collect();
            misfit.by_experiment = found;
        }
        misfit
    }

    /// For each experiment, a copy of the unknowns `x` of the whole fit, in which parameters, friction and effects are
    /// estimated from all other experiments. Weights and linearisation are taken from the whole fit. Empty if there is only one
    /// experiment.
    pub(crate) fn left_out(&self, fit: &IterationState, x: &[f64]) -> Vec<Vec<f64>> {
        let of_spectra = self.spectra.iter().map(|s| s.experiment);
        let sweeps = self.motions.iter().enumerate().filter(|(_, motion)| motion.is_none()).map(|(e, _)| e);
        let owners: Vec<usize> = of_spectra.chain(sweeps).collect();
        let clusters = fit.clusters(self, &[]);
        let shared = fit.shared_columns();
        let one = |experiment: usize| {
            let others = clusters.iter().zip(&owners).filter(|(_, owner)| **owner != experiment);
            let rest = Triangle::sum(shared.len(), others.map(|(rows, _)| rows));
            let mut left_out = x.to_vec();
            shared.iter().zip(solve(&rest).x).for_each(|(&c, found)| left_out[c] = found);
            left_out
        };
        let count = self.motions.len();
        if count > 1 { (0..count).map(one).collect() } else { Vec::new() }
    }

    /// The misfit with chi^2 only. The lists of standard deviations are empty.
    pub(crate) fn residual_squares(&self, fit: &IterationState) -> Misfit {
        let noise = self.deviations_by(&self.noise_of_band, Some(&fit.x[..self.p]));
        let squares = fit.squares_by(self, &noise);
        let share = fit.free_share();
        let rows = |is_of: &dyn Fn(usize) -> bool| {
            let of = || self.spectra.iter().zip(&squares).filter(|(s, _)| is_of(s.joint));
            let count: usize = of().map(|(s, _)| s.rows.len()).sum();
            (of().map(|(_, q)| q).sum::<f64>(), (count as f64 * share).max(1.0))
        };
        let ratio = |(squares, freedom): (f64, f64)| squares / freedom;
        let joints = (0..self.n).map(|j| ratio(rows(&|joint| joint == j))).collect();
        let (chi_square, freedom) = rows(&|_| true);
        let total = chi_square / freedom;
        Misfit { joints, total, chi_square, freedom, by_experiment: vec![], gains_by_experiment: vec![] }
    }
}

/// Standard deviations of the unknowns `x` with experiments as clusters. `triangles`: for each cluster, R of the QR
/// decomposition of the cluster's rows in the shared columns.
fn by_experiment(triangles: &[Triangle], x: &[f64]) -> Vec<f64> {
    let clusters: Vec<Cluster> = triangles.iter().map(|rows| Cluster::of(rows, x)).collect();
    let share = clusters.len().saturating_sub(1) as f64 / clusters.len().max(1) as f64;
    let variance = FullNormalMatrix::of_clusters(x.len(), &clusters).variance(
        &clusters,
        CLUSTER_LEVERAGE_SHARE,
        REMAINDER_ROUNDING_SHARE,
    );
    variance.iter().map(|v| (v * share).sqrt()).collect()
}

impl IterationState {
    /// Columns of the shared unknowns, which are common to all experiments: parameters, friction and effects.
    fn shared_columns(&self) -> Vec<usize> {
        self.layout.parameters_and_friction().chain(self.layout.effects()).collect()
    }

    /// The values of the shared unknowns.
    fn shared(&self) -> Vec<f64> {
        self.shared_columns().iter().map(|&c| self.x[c]).collect()
    }

    /// One triangle (R of a QR decomposition) per cluster, with the columns of the shared unknowns, then of the unknown gains.
    /// A cluster is a spectrum (after elimination of the drift and of the jumps at the ends of the record), the gravity rows of
    /// one sweep, or one expected gain.
    fn clusters(&self, data: &HarmonicData, gains: &[Gain]) -> Vec<Triangle> {
        let unknowns = self.x.len();
        let mut shared = self.shared_columns();
        let of_others: Vec<usize> = (0..unknowns).filter(|c| !shared.contains(c)).collect();
        shared.extend(unknowns..unknowns + gains.iter().filter(|g| g.is_unknown()).count());
        let (mut rows, mut expected) = (vec![Vec::new(); data.spectra.len() + data.sweeps.len()], Vec::new());
        for equation in self.gain_equations(data, gains) {
            let row = (equation.coefficients, equation.right);
            match equation.owner {
                Some(owner) => rows[owner.cluster].push(row),
                None => expected.push(vec![row]),
            }
        }
        let rows: Vec<_> = rows.into_iter().chain(expected).collect();
        rows.iter().map(|rows| projected(rows, &of_others, &shared)).collect()
    }
}

/// The triangle (R of QR) of the columns `kept`, after elimination of the columns `out`. `rows`: coefficients and right-hand side
/// of each row.
fn projected(rows: &[(Vec<f64>, f64)], out: &[usize], kept: &[usize]) -> Triangle {
    let own: Vec<usize> = out.iter().copied().filter(|&c| rows.iter().any(|(row, _)| row[c] != 0.0)).collect();
    let order: Vec<usize> = own.iter().chain(kept).copied().collect();
    let mut whole = TriangleBuilder::new(order.len());
    for (row, y) in rows {
        whole.push(&order.iter().map(|&c| row[c]).collect::<Vec<f64>>(), *y);
    }
    let whole = whole.finish();
    let mut builder = TriangleBuilder::new(kept.len());
    for i in own.len()..order.len() {
        builder.push(&(own.len()..order.len()).map(|j| whole.at(i, j)).collect::<Vec<f64>>(), whole.at(i, order.len()));
    }
    builder.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn misfit(joints: &[f64], total: f64) -> Misfit {
        Misfit {
            joints: joints.to_vec(),
            total,
            chi_square: total,
            freedom: 1.0,
            by_experiment: vec![],
            gains_by_experiment: vec![],
        }
    }

    #[test]
    fn the_allowance_grows_and_does_not_jump() {
        assert_eq!(misfit(&[0.3, NOISE_CHI_SQUARE], 0.6).beyond_noise(), 0.0);
        assert_eq!(misfit(&[0.1, 2.5], 0.6).beyond_noise(), 0.5 / (LACKING_MODEL_CHI_SQUARE - NOISE_CHI_SQUARE));
        let said = misfit(&[0.1, 5.0], LACKING_MODEL_CHI_SQUARE * (1.0 + f64::EPSILON));
        assert!(said.is_lacking() && said.beyond_noise() == 1.0);
        // If no noise was measured, the factor is 0.
        assert_eq!(misfit(&[0.1, f64::INFINITY], f64::INFINITY).beyond_noise(), 0.0);
    }
}
