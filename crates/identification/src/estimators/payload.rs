//! Estimates a load on a link from a log with the load and a log without it.
//!
//! The load is an additional rigid body on the link: its ten parameters phi_L add to the parameters of the link. W: rows of the
//! regressor; phi: standard parameters of all links; X = B phi: base parameters. The torque of the log with the load is W (X +
//! B_L phi_L), where B_L are the ten columns of B that belong to the link. Both logs are solved together for X, friction and
//! phi_L [Khalil, Gautier, Lemoine 2007], weighted by joint.

use linear_model::pseudo_inertia::Ten;
use linear_model::standard_map::StandardMap;
use logs::Error;
use nalgebra::DMatrix;
use numerics::least_squares::solve;
use numerics::triangle::{Triangle, TriangleBuilder};

/// The estimated parameters of a load, with their standard deviations.
#[derive(Clone, Debug)]
pub struct Payload {
    /// The ten parameters XX XY XZ YY YZ ZZ MX MY MZ M of the load, in the frame of the link.
    pub parameters: Ten,
    /// Standard deviations for white noise, in the units of the parameters.
    pub sigma: Ten,
    /// Covariance for white noise, 10 x 10.
    pub covariance: DMatrix<f64>,
    /// For each joint, the change of the load's parameters if the torques of this joint are doubled in both logs. The load is
    /// linear in the torques, so the sum of these changes over all joints is the load itself.
    pub by_scale: Vec<Ten>,
    /// For each of the ten parameters, whether the data determine it.
    pub determined: [bool; 10],
}

/// Estimates the load on body `link` of the map, in the frame of that body.
///
/// `without`, `with`: the triangle (R of QR) of each joint from the log without the load, and from the log with the load.
/// `weights`: weight of each joint.
///
/// Fails if the map has no such body or does not fit the triangles.
pub fn payload(
    without: &[Triangle],
    with: &[Triangle],
    weights: &[f64],
    map: &StandardMap,
    link: usize,
) -> Result<Payload, Error> {
    let p = without.first().map_or(0, Triangle::columns);
    let base = map.matrix.nrows();
    let Some(&(_, first)) = map.bodies.get(link) else {
        return Err(Error::new(format!("there is no body {link}; the robot has {}", map.bodies.len())));
    };
    if base > p || without.len() != with.len() || weights.len() != with.len() {
        let (a, b) = (without.len(), with.len());
        return Err(Error::new(format!("{base} base parameters, {p} columns, {a} and {b} joints do not fit together")));
    }
    // The matrix B_L: the ten columns of B of the link that carries the load.
    let load = map.matrix.columns(first, 10);
    let m = p + 10;
    // The rows of the log with the load are [W, W B_L], and the rows of the log without the load are [W, 0]. W comes from the
    // triangle of each joint.
    let mut block = TriangleBuilder::new(m);
    let mut products = vec![vec![0.0; m]; with.len()];
    for (triangles, loaded) in [(without, false), (with, true)] {
        for ((t, &weight), products) in triangles.iter().zip(weights).zip(&mut products) {
            for i in 0..=p {
                let mut row = vec![0.0; m];
                (i..p).for_each(|c| row[c] = weight * t.at(i, c));
                if loaded {
                    for k in 0..10 {
                        row[p + k] = (i..base).map(|c| row[c] * load[(c, k)]).sum();
                    }
                }
                let torque = weight * t.at(i, p);
                products.iter_mut().zip(&row).for_each(|(product, x)| *product += x * torque);
                block.push(&row, torque);
            }
        }
    }
    let mut total = block.finish();
    total.rows = without.iter().chain(with).map(|t| t.rows).sum();
    let solution = solve(&total);
    let at = |k: usize| p + k;
    let parameters: Ten = std::array::from_fn(|k| solution.x[at(k)]);
    let moved = |products: &Vec<f64>| -> Ten {
        std::array::from_fn(|k| products.iter().enumerate().map(|(c, x)| solution.inverse[(at(k), c)] * x).sum())
    };
    Ok(Payload {
        parameters,
        by_scale: products.iter().map(moved).collect(),
        sigma: std::array::from_fn(|k| (solution.variance * solution.inverse[(at(k), at(k))]).sqrt()),
        covariance: solution.inverse.view((p, p), (10, 10)) * solution.variance,
        determined: std::array::from_fn(|k| solution.determined[at(k)]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    /// The standard map of a robot of one body. The ten standard parameters of the body are also the base parameters of the
    /// robot.
    fn one_body() -> StandardMap {
        let standard = (0..10).map(|i| format!("P{i}")).collect();
        let matrix = DMatrix::identity(10, 10);
        StandardMap { standard, matrix, bodies: vec![("body".into(), 0)], rotors: Vec::new() }
    }

    #[test]
    fn the_load_comes_back_within_its_sigma() {
        let map = one_body();
        let load: Ten = std::array::from_fn(|k| 0.1 * (k + 1) as f64);
        let noise = 0.02;
        let mut random = Random::new(23);
        let (mut squares, draws) = ([0.0; 10], 200);
        for _ in 0..draws {
            let mut log = |loaded: f64| {
                let mut block = TriangleBuilder::new(11);
                for _ in 0..60 {
                    // The eleventh column is friction, which the load does not change.
                    let row: Vec<f64> = (0..11).map(|_| random.normal()).collect();
                    let own: f64 = row.iter().map(|x| 0.5 * x).sum();
                    let torque = own + loaded * row.iter().zip(load).map(|(x, l)| x * l).sum::<f64>();
                    block.push(&row, torque + noise * random.normal());
                }
                let triangle = block.finish();
                [triangle]
            };
            let (without, with) = (log(0.0), log(1.0));
            let found = payload(&without, &with, &[1.0], &map, 0).unwrap();
            assert!(found.determined.iter().all(|d| *d));
            assert!((0..10).all(|k| (found.by_scale[0][k] - found.parameters[k]).abs() < 1e-12), "{found:?}");
            for k in 0..10 {
                squares[k] += ((found.parameters[k] - load[k]) / found.sigma[k]).powi(2) / f64::from(draws);
            }
        }
        for s in squares {
            // The mean square of 200 unit normals is 1 with a standard deviation of 0.1. Four standard deviations are allowed.
            assert!((s - 1.0).abs() < 0.4, "{squares:?}");
        }
    }

    #[test]
    fn refusals() {
        let map = one_body();
        let t = [Triangle::new(10)];
        assert!(payload(&t, &t, &[1.0], &map, 1).unwrap_err().to_string().contains("no body 1"));
        assert!(payload(&t, &[], &[1.0], &map, 0).unwrap_err().to_string().contains("do not fit"));
    }
}
