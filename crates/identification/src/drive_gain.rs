//! Drive gains from the data: torque per unit of current, one joint's gain known.
//!
//! W_j X - k_j i_j = 0 for joints of unknown gain, W_j X = k_j i_j for those of known gain: linear in
//! (X, k). Currents are noisy columns, so least squares shrinks k; the maximum-likelihood estimate
//! divides each row by k_j,
//!   min sum_j |i_j - W_j X / k_j|^2 / sigma_j^2,
//! and is found from it by alternating Gauss-Newton steps [Gautier, Vandanjon, Presse 1994 for the
//! total least squares of the same equations; docs of `total_least_squares`]. Works on the triangles
//! by joint, with currents as right-hand sides.

use nalgebra::{DMatrix, DVector};

use crate::Error;
use crate::least_squares::solve;
use crate::triangle::{Block, Triangle};

/// Gains and parameters.
#[derive(Clone, Debug)]
pub struct DriveGains {
    /// N m/A, a joint; the known ones as given.
    pub gains: Vec<f64>,
    /// Standard deviation; zero for the known ones.
    pub sigma: Vec<f64>,
    /// Parameters of the columns, SI.
    pub x: Vec<f64>,
    /// Standard deviation of the current's residual, A, a joint.
    pub noise: Vec<f64>,
    pub iterations: usize,
}

const ITERATIONS: usize = 50;

/// From triangles by joint (currents on the right) and the gains that are known.
///
/// Fails when no gain is known: the scale of everything is then free; and when a gain is not
/// determined by these data.
pub fn drive_gains(joints: &[Triangle], known: &[Option<f64>]) -> Result<DriveGains, Error> {
    let n = joints.len();
    if known.len() != n || known.iter().all(Option::is_none) {
        let message = format!(
            "{n} drive gains, at least one of them known, are needed: data alone leave the scale of all gains and masses free"
        );
        return Err(Error::new(message));
    }
    let p = joints.first().map_or(0, Triangle::columns);
    let unknown: Vec<usize> = (0..n).filter(|&j| known[j].is_none()).collect();
    // Least squares in torque; rows of unequal current noise are weighed from the second round on.
    let (mut x, mut gains) = linear(joints, known, &unknown, &vec![1.0; n])?;
    let (mut noise, mut iterations) = (noises(joints, &gains, &x), 0);
    let mut normal = DMatrix::identity(0, 0);
    for iteration in 0..ITERATIONS {
        iterations = iteration + 1;
        let (step, matrix) = gauss_newton(joints, &unknown, &x, &gains, &noise).ok_or_else(|| {
            Error::new("the drive gains are not determined by these data: excite the coupling of joints")
        })?;
        let mut largest: f64 = 0.0;
        for c in 0..p {
            x[c] += step[c];
        }
        for (i, &j) in unknown.iter().enumerate() {
            gains[j] += step[p + i];
            largest = largest.max((step[p + i] / gains[j]).abs());
        }
        (noise, normal) = (noises(joints, &gains, &x), matrix);
        if largest < 1e-10 {
            break;
        }
    }
    let covariance = normal.try_inverse().unwrap_or_else(|| DMatrix::zeros(p + unknown.len(), p + unknown.len()));
    let mut sigma = vec![0.0; n];
    for (i, &j) in unknown.iter().enumerate() {
        sigma[j] = covariance[(p + i, p + i)].max(0.0).sqrt();
    }
    Ok(DriveGains { gains, sigma, x, noise, iterations })
}

/// Least squares for (X, k) in torque, each joint's rows times `weights`.
fn linear(
    joints: &[Triangle],
    known: &[Option<f64>],
    unknown: &[usize],
    weights: &[f64],
) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let p = joints.first().map_or(0, Triangle::columns);
    let m = p + unknown.len();
    let (mut total, mut block) = (Triangle::new(m), Block::new(m));
    for (j, t) in joints.iter().enumerate() {
        for i in 0..=p {
            if block.is_full() {
                total.fold(&mut block);
            }
            let mut row = vec![0.0; m];
            (i..p).for_each(|c| row[c] = weights[j] * t.at(i, c));
            let current = weights[j] * t.at(i, p);
            let y = match known[j] {
                Some(gain) => gain * current,
                None => {
                    let c = unknown.iter().position(|&u| u == j).unwrap_or(0);
                    row[p + c] = -current;
                    0.0
                }
            };
            block.push(&row, y);
        }
    }
    total.fold(&mut block);
    let solution = solve(&total);
    if let Some(i) = (0..unknown.len()).find(|i| !solution.determined[p + i] || solution.x[p + i] == 0.0) {
        let message = format!("the drive gain of joint {} is not determined by these data", unknown[i] + 1);
        return Err(Error::new(message));
    }
    let mut gains: Vec<f64> = known.iter().map(|k| k.unwrap_or(1.0)).collect();
    unknown.iter().enumerate().for_each(|(i, &j)| gains[j] = solution.x[p + i]);
    Ok((solution.x[..p].to_vec(), gains))
}

/// Root mean square of i_j - W_j X / k_j.
fn noises(joints: &[Triangle], gains: &[f64], x: &[f64]) -> Vec<f64> {
    let noise = |(t, k): (&Triangle, &f64)| {
        let scaled: Vec<f64> = x.iter().map(|x| x / k).collect();
        let (total, residual) = t.squares(&scaled);
        (residual.max(1e-20 * total) / t.rows.max(1) as f64).sqrt().max(f64::MIN_POSITIVE)
    };
    joints.iter().zip(gains).map(noise).collect()
}

/// One step for (X, k) and the normal matrix; `None` when it is singular.
fn gauss_newton(
    joints: &[Triangle],
    unknown: &[usize],
    x: &[f64],
    gains: &[f64],
    noise: &[f64],
) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let p = x.len();
    let m = p + unknown.len();
    let mut normal = DMatrix::zeros(m, m);
    let mut rhs = DVector::zeros(m);
    let xv = DVector::from_column_slice(x);
    for (j, t) in joints.iter().enumerate() {
        let (k, s) = (gains[j], noise[j]);
        let r = DMatrix::from_fn(p + 1, p, |i, c| if i <= c { t.at(i, c) } else { 0.0 });
        let z = DVector::from_fn(p + 1, |i, _| t.at(i, p));
        let fit = &r * &xv / k;
        let mut jacobian = DMatrix::zeros(p + 1, m);
        jacobian.view_mut((0, 0), (p + 1, p)).copy_from(&(r / k));
        if let Some(i) = unknown.iter().position(|&u| u == j) {
            jacobian.column_mut(p + i).copy_from(&(-&fit / k));
        }
        jacobian /= s;
        normal += jacobian.transpose() * &jacobian;
        rhs += jacobian.transpose() * ((z - fit) / s);
    }
    let d = normal.diagonal().map(|x: f64| if x > 0.0 { 1.0 / x.sqrt() } else { 1.0 });
    let scaled = DMatrix::from_fn(m, m, |i, j| normal[(i, j)] * d[i] * d[j]);
    let step = scaled.cholesky()?.solve(&rhs.component_mul(&d)).component_mul(&d);
    Some((step, normal))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Two joints that share two parameters, currents with noise.
    fn joints(noise: f64, seed: u64) -> Vec<Triangle> {
        let (x, k) = ([2.0, -1.0], [3.0, 0.5]);
        let mut random = Random::new(seed);
        let mut out = vec![Triangle::new(2), Triangle::new(2)];
        for (j, t) in out.iter_mut().enumerate() {
            let mut block = Block::new(2);
            for _ in 0..500 {
                let row = [random.normal(), random.normal()];
                let torque = row[0] * x[0] + row[1] * x[1];
                block.push(&row, torque / k[j] + noise * random.normal());
                if block.is_full() {
                    t.fold(&mut block);
                }
            }
            t.fold(&mut block);
        }
        out
    }

    #[test]
    fn gains_come_back_exactly_without_noise() {
        let found = drive_gains(&joints(0.0, 1), &[Some(3.0), None]).unwrap();
        assert!((found.gains[1] - 0.5).abs() < 1e-10, "{found:?}");
        assert!((found.x[0] - 2.0).abs() < 1e-10);
    }

    /// Noise of a third of the current: least squares in torque is 10 % low, maximum likelihood is not.
    #[test]
    fn noise_does_not_shrink_the_gain() {
        let runs = 60;
        let (mut mean, mut chi) = (0.0, 0.0);
        for seed in 0..runs {
            let found = drive_gains(&joints(1.5, 100 + seed), &[Some(3.0), None]).unwrap();
            mean += found.gains[1] / runs as f64;
            chi += ((found.gains[1] - 0.5) / found.sigma[1]).powi(2) / runs as f64;
        }
        // The standard error of the mean is about 0.006.
        assert!((mean - 0.5).abs() < 0.02, "{mean}");
        assert!((0.5..1.7).contains(&chi), "{chi}");
    }

    #[test]
    fn the_scale_must_be_given() {
        let message = drive_gains(&joints(0.0, 1), &[None, None]).unwrap_err().to_string();
        assert!(message.contains("at least one of them known"), "{message}");
    }
}
