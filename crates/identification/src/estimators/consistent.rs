//! Physically consistent parameters: least squares over bodies with a positive definite pseudo-inertia.
//!
//! minimise  1/(2 s) |R (B phi, f) - z|^2 + 1/2 sum_i (f_i / sd_i)^2
//!           + gamma sum_j [tr(P0_j^-1 P_j) - log det(P0_j^-1 P_j) - 4]   over P_j > 0, IA >= 0
//!
//! R, z: the triangle of the data (R of the QR decomposition of the rows, z: its right-hand side), whitened (residual of unit
//! variance); phi: standard parameters (ten of each body); X = B phi: base parameters; f: friction; P_j: pseudo-inertia of body
//! j, P0_j: pseudo-inertia of its reference body; IA: rotor inertias. The last term is the entropic (log-determinant)
//! divergence from the reference bodies [Lee, Wensing, Park 2020]. This term regularises parameters that the data do not
//! determine. The logarithm in this term is also the barrier that keeps every P_j > 0, so the problem is convex and
//! unconstrained inside the cone. With gamma = 1e-3 the term counts as a thousandth of a unit of log-likelihood: the solution
//! then equals least squares if least squares is consistent.
//!
//! The last term acts as a prior and biases the solution, so chi^2 exceeds the minimum over all bodies. The logarithms alone
//! raise chi^2/2 by at most gamma (4 bodies + rotors). If the reference is far from the data, the excess is larger. Therefore
//! the problem is solved for decreasing weights of the prior and of the bounds on friction, down to a millionth, and further
//! until `Problem::suboptimality_bound` is small. The result is the solution with the largest weight, at most one, whose
//! chi^2/2 is within gamma (4 bodies + rotors) of the last solution. So a reference that contradicts the data loses its weight.
//!
//! s >= 1 discounts the data, because residuals are correlated in time. sd_i is the prior standard deviation of friction that the
//! motion does not identify. The problem is solved by Newton's method with line search. gamma is decreased from a value at which
//! the reference dominates. Not implemented: the metric of the manifold of bodies, and log-Cholesky coordinates.

use linear_model::pseudo_inertia::{Ten, parameters, pseudo_inertia, smallest_eigenvalue};
use linear_model::standard_map::StandardMap;
use nalgebra::{DMatrix, DVector, Matrix4};
use numerics::triangle::Triangle;

use crate::estimators::barrier::{BarrierStatus, CentralPath, Problem};

/// The prior knowledge of bodies and friction.
#[derive(Clone, Debug)]
pub struct Prior {
    /// Reference parameters XX .. M of each body, in the order of `StandardMap::bodies`. `None`: the parameters are unknown;
    /// the reference is a ball of mass `scale`.
    pub bodies: Vec<Option<Ten>>,
    /// Mass of the ball (radius of gyration 0.1 m) that replaces unknown bodies, kg.
    pub scale: f64,
    /// Weight of the log-determinant divergence from the references, nats per unit of divergence.
    pub gamma: f64,
    /// Discount s of the data: ratio of the variance of a parameter with correlated residuals to the variance with white
    /// residuals.
    pub discount: f64,
    /// For each parameter after the base parameters (friction), its prior standard deviation about zero, in the unit of the
    /// parameter. Infinite: no prior.
    pub friction: Vec<f64>,
}

/// A physically consistent solution: each body has a positive definite pseudo-inertia.
#[derive(Clone, Debug)]
pub struct Consistent {
    /// The standard parameters, in the order of `StandardMap::standard`.
    pub phi: Vec<f64>,
    /// The base parameters, then friction, in the order of the columns of the triangle.
    pub x: Vec<f64>,
    /// The smallest eigenvalue of the pseudo-inertia of each body.
    pub smallest_eigenvalues: Vec<f64>,
    /// 1/2 chi^2 of the data at the solution, divided by the discount, nats. The prior is not included.
    pub objective: f64,
    /// Suboptimality bound of `objective`, nats: largest possible difference between `objective` and the objective of any other
    /// bodies that are at most `LARGEST_BOUNDED_RATIO` times as large. `None` if the solver stalled.
    pub excess: Option<f64>,
    /// Final weight of the prior relative to its full weight. This share is 1 if the data do not contradict the prior.
    pub prior_share: f64,
    /// How Newton's method ended.
    pub outcome: BarrierStatus,
    /// Number of Newton steps over all values of gamma.
    pub newton_steps: usize,
}

/// The weight of the prior is decreased at least to this share of its full weight. At this weight the suboptimality bound is
/// evaluated.
const BOUND_PRIOR_SHARE: f64 = 1e-6;
/// If the suboptimality bound is not tight at `BOUND_PRIOR_SHARE` (bodies much larger than their references), the weight of the
/// prior is decreased further, down to this share. Below this share, the rounding of the Hessian dominates.
const SMALLEST_PRIOR_SHARE: f64 = 1e-9;
/// The suboptimality bound is tight if it is at most this share of gamma times the number of logarithms in the barrier.
const TIGHT_BOUND_SHARE: f64 = 0.5;
/// Factor by which the weight of the prior is multiplied after each solution.
const PRIOR_SHARE_FACTOR: f64 = 0.2;
/// Squared radius of gyration of the ball that replaces unknown bodies, m^2.
const BALL_SQUARED_RADIUS_M2: f64 = 0.01;
/// Reference inertia of a rotor divided by the mass of the ball that replaces unknown bodies, m^2.
const ROTOR_INERTIA_PER_MASS_M2: f64 = 0.01;

/// Solves for physically consistent standard parameters and friction. `triangle`: whitened data (residual of unit variance).
pub fn consistent(triangle: &Triangle, map: &StandardMap, prior: &Prior) -> Consistent {
    let (standard, total) = (map.matrix.ncols(), triangle.columns());
    let dimension = standard + total - map.matrix.nrows();
    let transform = transform(map, prior, dimension);
    let x_of_y = scatter(map, total) * &transform;
    let problem = problem(triangle, map, prior, &x_of_y);
    // The path starts at a gamma at which the prior dominates, and gamma decreases to the full weight of the prior. Then gamma
    // is decreased further, multiplied by [`PRIOR_SHARE_FACTOR`] in each round.
    let y = at_reference(&problem, dimension);
    let gamma = problem.starting_gamma(&y, problem.hessian.diagonal().max().max(prior.gamma));
    let mut path = CentralPath::new(&problem, y, gamma);
    let mut shares = Vec::new();
    let mut share = 1.0;
    while path.follow(share * prior.gamma) {
        shares.push((share, path.y.clone()));
        let is_tight =
            problem.suboptimality_bound(&path.y, share) <= TIGHT_BOUND_SHARE * prior.gamma * problem.barriers();
        if share <= SMALLEST_PRIOR_SHARE || (share <= BOUND_PRIOR_SHARE && is_tight) {
            break;
        }
        let least = if share > BOUND_PRIOR_SHARE { BOUND_PRIOR_SHARE } else { SMALLEST_PRIOR_SHARE };
        share = (PRIOR_SHARE_FACTOR * share).max(least);
    }
    let (steps, mut y) = (path.steps, path.y);
    let (mut excess, mut prior_share) = (None, 1.0);
    // Take the largest weight of the prior whose chi^2/2 is within gamma (4 bodies + rotors) of the solution with the smallest
    // weight.
    if let Some((last, nearest)) = shares.last() {
        let allowed = problem.quadratic(nearest) + prior.gamma * problem.barriers();
        if let Some((share, chosen)) = shares.iter().find(|(_, y)| problem.quadratic(y) <= allowed) {
            excess = Some(
                problem.quadratic(chosen) - problem.quadratic(nearest) + problem.suboptimality_bound(nearest, *last),
            );
            (prior_share, y) = (*share, chosen.clone());
        }
    }
    let outcome = if excess.is_some() { BarrierStatus::Converged } else { BarrierStatus::Stalled };
    let theta = &transform * &y;
    let ten = |first: &usize| -> Ten { std::array::from_fn(|i| theta[first + i]) };
    Consistent {
        phi: theta.rows(0, standard).iter().copied().collect(),
        x: (&x_of_y * &y).iter().copied().collect(),
        smallest_eigenvalues: problem.bodies.iter().map(|f| smallest_eigenvalue(&ten(f))).collect(),
        objective: problem.quadratic(&y),
        excess,
        prior_share,
        outcome,
        newton_steps: steps,
    }
}

/// The matrix T of (phi, f) = T y. phi: standard parameters, f: friction. In y, each body is relative to its reference, each
/// rotor is relative to the inertia of the ball, and friction is unscaled.
fn transform(map: &StandardMap, prior: &Prior, dimension: usize) -> DMatrix<f64> {
    let mut transform = DMatrix::identity(dimension, dimension);
    for (j, (_, first)) in map.bodies.iter().enumerate() {
        let reference = reference(prior.bodies.get(j).copied().flatten(), prior.scale);
        transform.view_mut((*first, *first), (10, 10)).copy_from(&body_transform(&reference));
    }
    for &c in &map.rotors {
        transform[(c, c)] = ROTOR_INERTIA_PER_MASS_M2 * prior.scale;
    }
    transform
}

/// The matrix from (phi, f) to (X, f). phi: standard parameters, X: base parameters, f: friction. `total`: number of entries of
/// (X, f).
fn scatter(map: &StandardMap, total: usize) -> DMatrix<f64> {
    let (base, standard) = map.matrix.shape();
    let mut scatter = DMatrix::zeros(total, standard + total - base);
    scatter.view_mut((0, 0), (base, standard)).copy_from(&map.matrix);
    for k in 0..total - base {
        scatter[(base + k, standard + k)] = 1.0;
    }
    scatter
}

/// Makes the minimisation problem from the data and the prior, in the scaled variables y. `x_of_y`: matrix from y to (X, f).
fn problem(triangle: &Triangle, map: &StandardMap, prior: &Prior, x_of_y: &DMatrix<f64>) -> Problem {
    let (standard, total) = (map.matrix.ncols(), triangle.columns());
    let r = DMatrix::from_fn(total + 1, total, |i, j| if i <= j { triangle.at(i, j) } else { 0.0 });
    let z = DVector::from_fn(total + 1, |i, _| triangle.at(i, total));
    let weight = (1.0 / prior.discount.max(1.0)).sqrt();
    let rows = weight * r * x_of_y;
    let bounded = prior.friction.iter().enumerate().filter(|(_, sd)| sd.is_finite());
    Problem {
        hessian: rows.tr_mul(&rows),
        rows,
        right: weight * z,
        friction: bounded.map(|(k, &sd)| (standard + k, sd)).collect(),
        gamma: prior.gamma,
        bodies: map.bodies.iter().map(|b| b.1).collect(),
        rotors: map.rotors.clone(),
        units: std::array::from_fn(|i| pseudo_inertia(&std::array::from_fn(|k| f64::from(i == k)))),
    }
}

/// The y at which all bodies and rotors equal their references and friction is zero.
fn at_reference(problem: &Problem, dimension: usize) -> DVector<f64> {
    let mut y = DVector::zeros(dimension);
    for first in &problem.bodies {
        y.rows_mut(*first, 10).copy_from_slice(&parameters(&Matrix4::identity()));
    }
    for &c in &problem.rotors {
        y[c] = 1.0;
    }
    y
}

/// The pseudo-inertia of a reference body. A body that is unknown or not positive definite is replaced by a ball of mass `scale`,
/// kg.
fn reference(body: Option<Ten>, scale: f64) -> Matrix4<f64> {
    let given = body.map(|b| pseudo_inertia(&b)).filter(|p| p.cholesky().is_some());
    let square = BALL_SQUARED_RADIUS_M2;
    given.unwrap_or_else(|| Matrix4::from_diagonal(&nalgebra::Vector4::new(square, square, square, 1.0)) * scale)
}

/// The 10 x 10 matrix from the parameters of a relative body Q to the parameters of the body P = L Q L'. L: Cholesky factor of
/// the reference, P0 = L L'.
fn body_transform(reference: &Matrix4<f64>) -> DMatrix<f64> {
    let l = reference.cholesky().map_or_else(Matrix4::identity, |c| c.l());
    let mut out = DMatrix::zeros(10, 10);
    for i in 0..10 {
        let unit = pseudo_inertia(&std::array::from_fn(|k| f64::from(i == k)));
        out.column_mut(i).copy_from_slice(&parameters(&(l * unit * l.transpose())));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use numerics::triangle::TriangleBuilder;
    use random::Random;

    const BODY: Ten = [0.30, 0.01, -0.02, 0.28, 0.015, 0.20, 0.4, -0.1, 0.2, 2.0];

    /// A triangle of 400 rows that determine all ten parameters of one body. `precision`: standard deviation of the entries of
    /// the rows; `noise`: standard deviation of the torque noise.
    fn measured(truth: &Ten, precision: f64, noise: f64) -> Triangle {
        let mut random = Random::new(21);
        let mut block = TriangleBuilder::new(10);
        for _ in 0..400 {
            let row: Vec<f64> = (0..10).map(|_| precision * random.normal()).collect();
            let y: f64 = row.iter().zip(truth).map(|(a, b)| a * b).sum();
            block.push(&row, y + noise * random.normal());
        }
        block.finish()
    }

    fn map() -> StandardMap {
        let standard = (0..10).map(|i| format!("P{i}")).collect();
        let matrix = DMatrix::identity(10, 10);
        StandardMap { standard, matrix, bodies: vec![("body".into(), 0)], rotors: Vec::new() }
    }

    fn prior(gamma: f64, body: Option<Ten>) -> Prior {
        Prior { bodies: vec![body], scale: 1.0, gamma, discount: 1.0, friction: Vec::new() }
    }

    #[test]
    fn where_least_squares_is_a_body_nothing_changes() {
        let triangle = measured(&BODY, 100.0, 1.0);
        let ls = numerics::least_squares::solve(&triangle);
        let out = consistent(&triangle, &map(), &prior(1e-6, None));
        assert_eq!(out.outcome, BarrierStatus::Converged);
        for i in 0..10 {
            let sigma = (ls.variance * ls.inverse[(i, i)]).sqrt();
            // A prior with weight gamma changes the optimum by about gamma sigma (gamma: nats per unit of divergence). The
            // tolerance of the test is larger than this change.
            assert!((out.x[i] - ls.x[i]).abs() < 1e-3 * sigma, "{i}: {} {}", out.x[i], ls.x[i]);
        }
    }

    #[test]
    fn data_of_no_body_end_on_the_boundary() {
        let mut impossible = BODY;
        impossible[5] = 1.5; // above the sum of the other two moments
        let triangle = measured(&impossible, 100.0, 1.0);
        let near = consistent(&triangle, &map(), &prior(1e-6, None));
        assert!(near.smallest_eigenvalues[0] > 0.0 && near.smallest_eigenvalues[0] < 1e-4, "{near:?}");
        // The suboptimality bound must also hold in comparison with a solution for a ten times weaker prior.
        let nearer = consistent(&triangle, &map(), &prior(1e-7, None));
        assert!(nearer.objective <= near.objective + 1e-6);
        let excess = near.excess.unwrap();
        assert!(near.objective - nearer.objective <= excess + 1e-9 * near.objective, "{near:?} {nearer:?}");
    }

    /// The nominal body is wrong by a factor of 1e-3 to 1e3. chi^2/2 exceeds chi^2/2 with the correct nominal body by at most the
    /// bound, and the bound is small.
    #[test]
    fn a_wrong_reference_yields_and_the_bound_holds() {
        let triangle = measured(&BODY, 100.0, 1.0);
        let of = |factor: f64| consistent(&triangle, &map(), &prior(0.1, Some(BODY.map(|x| factor * x))));
        let least = of(1.0).objective;
        for factor in [1e-3, 1e-2, 1.0, 1e3] {
            let out = of(factor);
            let excess = out.excess.unwrap();
            assert_eq!(out.outcome, BarrierStatus::Converged);
            assert!(out.objective - least <= excess, "{factor}: {out:?}, least {least}");
            // 0.8 = 2 x 4 logarithms x 0.1 nats: one half for the allowed excess, one half for the bound itself.
            assert!(excess <= 0.8, "{factor}: {out:?}");
            assert!((out.prior_share < 1.0) == (factor < 0.005), "{factor}: {out:?}");
        }
    }

    /// Data may determine some directions of the parameter space to many digits, and other directions not at all. The normal
    /// matrix A'A is then too ill-conditioned for f64.
    #[test]
    fn data_of_any_precision_are_followed() {
        for precision in [1e2, 1e5, 1e8, 1e10, 1e11] {
            let mut random = Random::new(9);
            let directions: Vec<Vec<f64>> = (0..6).map(|_| (0..10).map(|_| random.normal()).collect()).collect();
            let along = |d: &[f64], x: &[f64]| d.iter().zip(x).map(|(a, b)| a * b).sum::<f64>();
            let mut block = TriangleBuilder::new(10);
            for _ in 0..200 {
                let mut row = vec![0.0; 10];
                for direction in &directions {
                    let weight = precision * random.normal();
                    row.iter_mut().zip(direction).for_each(|(r, d)| *r += weight * d);
                }
                let y = along(&row, &BODY);
                block.push(&row, y + random.normal());
            }
            let out = consistent(&block.finish(), &map(), &prior(0.1, Some(BODY.map(|x| 1.3 * x))));
            assert_eq!(out.outcome, BarrierStatus::Converged, "{precision}: {out:?}");
            for direction in &directions {
                let (found, truth) = (along(direction, &out.x), along(direction, &BODY));
                // Allowed error: a few sigma, with sigma = 1 / (precision sqrt(200 rows)), and the rounding of the rows.
                let expected = 1.0 / precision + 1e-12;
                assert!((found - truth).abs() < expected, "{precision}: {found} {truth}");
            }
        }
    }

    #[test]
    fn both_directions_are_those_of_newton() {
        let triangle = measured(&BODY, 3.0, 1.0);
        let (map, mut prior) = (map(), prior(0.5, Some(BODY.map(|x| 1.2 * x))));
        prior.friction = Vec::new();
        let transform = transform(&map, &prior, 10);
        let problem = problem(&triangle, &map, &prior, &(scatter(&map, 10) * &transform));
        let mut y = at_reference(&problem, 10);
        y[3] *= 1.1;
        y[9] *= 0.9;
        let (by_hessian, by_rows) = problem.directions(&y, 0.5);
        assert!((by_hessian.0 / by_rows.0 - 1.0).abs() < 1e-9, "{} {}", by_hessian.0, by_rows.0);
        assert!((&by_hessian.1 - &by_rows.1).norm() < 1e-9 * by_rows.1.norm());
    }

    #[test]
    fn without_data_the_reference_is_the_answer() {
        let out = consistent(&Triangle::new(10), &map(), &prior(1.0, Some(BODY)));
        for (x, e) in out.x.iter().zip(BODY) {
            assert!((x - e).abs() < 1e-9, "{x} {e}");
        }
    }

    /// The entropic prior does not depend on the frame. If the frames of the body, the reference body and the data are rotated
    /// and moved equally, the solution is the same body, rotated and moved. A Euclidean prior would fail here.
    #[test]
    fn the_prior_does_not_depend_on_the_frame() {
        let (s, c) = 0.7f64.sin_cos();
        let pose = Matrix4::new(c, -s, 0.0, 0.3, s, c, 0.0, -0.2, 0.0, 0.0, 1.0, 0.5, 0.0, 0.0, 0.0, 1.0);
        let moved = |x: &Ten| parameters(&(pose * pseudo_inertia(x) * pose.transpose()));
        let mut map_of_pose = DMatrix::zeros(10, 10);
        for i in 0..10 {
            map_of_pose.column_mut(i).copy_from_slice(&moved(&std::array::from_fn(|k| f64::from(i == k))));
        }
        let inverse = map_of_pose.try_inverse().unwrap();
        let mut random = Random::new(5);
        let (mut a, mut b) = (TriangleBuilder::new(10), TriangleBuilder::new(10));
        for _ in 0..4 {
            // Four rows for ten parameters: in the directions that the rows do not determine, the solution follows from the
            // prior.
            let row: Vec<f64> = (0..10).map(|_| random.normal()).collect();
            let y: f64 = row.iter().zip(BODY).map(|(a, b)| a * b).sum();
            a.push(&row, y);
            let row = DVector::from_vec(row).transpose() * &inverse;
            b.push(row.as_slice(), y);
        }
        let (here, there) = (a.finish(), b.finish());
        let reference = [0.1, 0.0, 0.0, 0.1, 0.0, 0.1, 0.0, 0.0, 0.1, 1.0];
        let x = consistent(&here, &map(), &prior(0.1, Some(reference)));
        let z = consistent(&there, &map(), &prior(0.1, Some(moved(&reference))));
        let x: Ten = std::array::from_fn(|i| x.x[i]);
        for (a, b) in moved(&x).into_iter().zip(&z.x) {
            assert!((a - b).abs() < 1e-5, "{a} {b}");
        }
    }
}
