//! Standard deviations by the jackknife, which omits one block of the data at a time.
//!
//! Residuals that persist for some time, in one or several joints, are correlated within a block but not between blocks. A_g,
//! s_g: normal matrix and score of block g; W_jg, y_jg: regressor and torques of joint j in block g; w_j: weight of joint j
//! (fixed). The solution without block g and the variance are
//!   x_(g) = x - (A - A_g)^-1 s_g,   A_g = sum_j w_j^2 W_jg' W_jg,   s_g = sum_j w_j^2 W_jg' (y_jg - W_jg x),
//!   var x_c = (G - 1)/G sum_g (x_(g) - x)_c^2,   A = sum_g A_g
//! [Miller 1974; Kunsch 1989, for blocks of a series]; x_c: parameter c, G: number of blocks. If only a few blocks determine a
//! parameter, the estimate of its variance is as uncertain as if there were only these few blocks. pi_g: share of block g in the
//! information on the parameter. The degrees of freedom of the variance are
//!   nu_c = 1 / sum_g pi_g^2 - 1,   pi_g = (A^-1 A_g A^-1)_cc / (A^-1)_cc       [Satterthwaite 1946]
//! which is G - 1 if all blocks contribute equally. Everything follows from the triangles of the blocks (R of their QR
//! decompositions), so sums over many logs have standard deviations without a second pass over their rows. If each block is one
//! log, the standard deviations contain differences between logs, for example of temperature.
//!
//! | symbol | code | shape |
//! |---|---|---|
//! | A_g, s_g | `clusters::Cluster` | p x p, p |
//! | G | `blocks` | |
//!
//! Not here: correlation across the ends of blocks; `correlated_deviation` includes it, but needs the rows.

use numerics::least_squares::Solution;
use numerics::triangle::Triangle;

use identification::estimators::clusters::{Cluster, FullNormalMatrix};
use identification::rows::observation::weighted;

/// Standard deviations by the jackknife.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BlockDeviation {
    /// Standard deviation of each parameter, in the unit of the parameter; zero if there are fewer than two blocks.
    pub sigma: Vec<f64>,
    /// Degrees of freedom of each standard deviation; zero if a single block determines the parameter.
    pub freedom: Vec<f64>,
    /// Number of blocks with rows.
    pub blocks: usize,
}

/// If only the omitted block determines a parameter, the matrix without this block is singular. Then the parameter is
/// regularised with this fraction of the norm of its column. A direction of condition number 1000 has a hundred times this
/// fraction.
const REGULARISATION_SHARE: f64 = 1e-5;

/// Standard deviations of a solution. `parts[g][j]`: triangle (R of the QR decomposition) of block g and joint j. `weights`:
/// weight of each joint.
pub(crate) fn block_deviation(parts: &[Vec<Triangle>], weights: &[f64], solution: &Solution) -> BlockDeviation {
    let p = solution.x.len();
    let with_rows = parts.iter().filter(|part| part.iter().any(|joint| joint.rows > 0));
    let clusters: Vec<Cluster> = with_rows.map(|part| Cluster::of(&weighted(part, weights), &solution.x)).collect();
    let whole = FullNormalMatrix::of_clusters(p, &clusters);
    let (mut variance, mut squares, mut blocks) = (vec![0.0; p], vec![0.0; p], 0);
    for (cluster, shares) in
        clusters.iter().zip(whole.information_shares(&clusters, REGULARISATION_SHARE * REGULARISATION_SHARE))
    {
        // The regularised matrix is positive definite. So `None` is returned only for a block with NaN, which is skipped.
        let Some(moved) = whole.moved(cluster, 1.0, REGULARISATION_SHARE * REGULARISATION_SHARE) else { continue };
        squares.iter_mut().zip(shares).for_each(|(sum, share)| *sum += share * share);
        variance.iter_mut().zip(moved).for_each(|(v, d)| *v += d * d);
        blocks += 1;
    }
    let share = if blocks > 1 { (blocks - 1) as f64 / blocks as f64 } else { 0.0 };
    let free = |squares: f64| if squares > 0.0 { (1.0 / squares - 1.0).max(0.0) } else { 0.0 };
    BlockDeviation {
        sigma: variance.into_iter().map(|v| (share * v).sqrt()).collect(),
        freedom: squares.into_iter().map(free).collect(),
        blocks,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;
    use identification::estimators::weighted::{Weights, fit};
    use identification::rows::observation::Observation;
    use linear_model::linear_model::Model;
    use numerics::least_squares::solve;
    use numerics::student::two_sided_quantile;
    use random::Random;

    #[test]
    fn it_is_the_jackknife() {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &[], &[]);
        let (mut states, mut random) = (arm.states(800), Random::new(3));
        states.tau.iter_mut().for_each(|tau| *tau += 0.1 * random.normal());
        let observation = Observation::of(&model, &states, 8);
        let (solution, weights) = fit(&observation.joints(|_| true), Weights::Joint);
        let found = block_deviation(&observation.parts, &weights, &solution);
        assert_eq!(found.blocks, 8);
        for c in 0..3 {
            let without = |g: usize| solve(&weighted(&observation.joints(|k| k != g), &weights)).x[c] - solution.x[c];
            let variance: f64 = 7.0 / 8.0 * (0..8).map(|g| without(g).powi(2)).sum::<f64>();
            // Tolerance: products of columns lose half of the digits, and the columns are well conditioned.
            assert!((found.sigma[c] / variance.sqrt() - 1.0).abs() < 1e-6, "{c}");
        }
    }

    #[test]
    fn intervals_cover() {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &[], &[]);
        for (rho, least) in [(0.0, 0.92), (0.98, 0.86)] {
            let mut random = Random::new(17);
            let (runs, mut covered) = (200, 0);
            for _ in 0..runs {
                let (mut states, mut noise) = (arm.states(3000), 0.0);
                for r in 0..states.len() {
                    noise = rho * noise + f64::sqrt(1.0 - rho * rho) * random.normal();
                    states.tau[r] += 0.1 * noise;
                }
                let observation = Observation::of(&model, &states, 16);
                let (solution, weights) = fit(&observation.joints(|_| true), Weights::Joint);
                let found = block_deviation(&observation.parts, &weights, &solution);
                let half = |c: usize| two_sided_quantile(0.05, found.freedom[c]) * found.sigma[c];
                covered += (0..3).filter(|&c| (solution.x[c] - arm.truth[c]).abs() < half(c)).count();
            }
            // Coverage of 95 % is expected. With 600 draws its standard deviation is 1 %, and the limit is 95 % minus three
            // standard deviations. For correlated noise the limit is lower, because the correlation across the ends of blocks
            // is neglected.
            assert!(covered as f64 / (3.0 * f64::from(runs)) > least, "{rho}: {covered}");
        }
    }

    #[test]
    fn what_one_block_shows_spoils_no_other() {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &[], &[]);
        let (mut states, mut random) = (arm.states(800), Random::new(5));
        states.tau.iter_mut().for_each(|tau| *tau += 0.1 * random.normal());
        for r in 100..800 {
            states.tau[r] -= arm.truth[0] * std::mem::take(&mut states.ddq[r]);
        }
        let observation = Observation::of(&model, &states, 8);
        let (solution, weights) = fit(&observation.joints(|_| true), Weights::Joint);
        let found = block_deviation(&observation.parts, &weights, &solution);
        let white = |c: usize| (solution.variance * solution.inverse[(c, c)]).sqrt();
        assert!(found.sigma.iter().all(|s| s.is_finite()), "{found:?}");
        // With eight blocks, a standard deviation has a relative uncertainty of a quarter. The limits of the test are wider.
        assert!((1..3).all(|c| (0.4..2.5).contains(&(found.sigma[c] / white(c)))), "{found:?}");
        // Only the first block determines ZZ, so it has no degree of freedom. All blocks determine the other parameters equally
        // well.
        assert!(found.freedom[0] < 0.1 && found.freedom[1] > 5.0 && found.freedom[1] <= 7.0, "{found:?}");
        let one = block_deviation(&observation.parts[..1], &weights, &solution);
        assert_eq!((one.sigma, one.blocks), (vec![0.0; 3], 1));
        assert!(one.freedom.iter().all(|&free| free < 1e-6), "{:?}", one.freedom);
    }
}
