//! The ten parameters of a load on a link, estimated while the robot moves.
//!
//! A load with the parameters x changes the momentum by P x and the torques by B x, so the observer of the unloaded robot sees
//!
//! ```text
//! r = -H x + e          H: the columns of P and B through the same filter as r (n x 10)
//! ```
//! e has the standard deviation of the band without the part from the parameters. That part is an error of the robot's own
//! parameters. It is the same in every cycle, so averaging does not reduce it, and it is treated separately: if r = -H x + e +
//! Z d with constant d of unit covariance (Z = y G, see [`crate::Band`]), the error of the estimate is the least-squares
//! solution for e and for Z d [Schmidt 1966, consider states]:
//!
//! ```text
//! cov(x) = inv(R) inv(R)' + K K',   K = inv(R) inv(R)' sum H' Z / s^2
//! ```
//! The errors e are correlated from update to update. Therefore s, the deviation of a row, is larger than that of a single
//! error: s^2 = f (variance of e), where f is the ratio of two variances of a mean of errors, for correlated and for independent
//! errors. f = (1 + a) / (1 - a) if the correlation of successive errors is a.
//!
//! The estimate starts with parameters of zero and given standard deviations (of the loads that a gripper may hold). If more than a
//! tenth of this standard deviation remains, the parameter is reported as not determined by the motion.

use crate::real::Real;
use crate::recursion::Recursion;

/// Number of inertial parameters of a rigid body: XX XY XZ YY YZ ZZ MX MY MZ M.
const TEN: usize = 10;

/// A parameter is determined by the motion if its standard deviation has fallen below this share of the value at the start.
const DETERMINED_SHARE: f64 = 0.1;

/// Recursive estimate of a load. D: number of directions d of the error of the robot's own parameters.
#[derive(Clone, Copy, Debug)]
pub struct Payload<R, const D: usize> {
    recursion: Recursion<R, TEN>,
    /// Sum of H' Z / s^2.
    shared: [[R; D]; TEN],
    start: [R; TEN],
}

/// An estimated load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load<R> {
    /// XX XY XZ YY YZ ZZ MX MY MZ M about the origin of the load's frame, in its axes: kg m^2, kg m, kg.
    pub parameters: [R; TEN],
    /// Standard deviation of each parameter.
    pub sigma: [R; TEN],
    /// Whether the motion so far determines the parameter.
    pub is_determined: [bool; TEN],
}

impl<R: Real, const D: usize> Payload<R, D> {
    /// Starts without a load. `start`: standard deviation of each parameter of the loads that are possible.
    pub fn new(start: [R; TEN]) -> Payload<R, D> {
        Payload { recursion: Recursion::new(&start), shared: [[R::ZERO; D]; TEN], start }
    }

    /// Starts again without a load, for example when the load changes.
    pub fn reset(&mut self) {
        *self = Payload::new(self.start);
    }

    /// Takes the torque of one joint. `row`: its row of H; `torque`: external torque r of the observer of the unloaded robot, N
    /// m (N); `deviation`: s; `shared`: its row of Z. A row with an infinite number or NaN is not used.
    pub fn push(&mut self, row: &[R; TEN], torque: R, deviation: R, shared: &[R; D]) {
        let weight = R::ONE / deviation;
        let is_usable = weight.is_finite() && torque.is_finite();
        if !(is_usable && row.iter().chain(shared).all(|x| x.is_finite())) {
            return;
        }
        let scaled = row.map(|x| -x * weight);
        self.recursion.push(scaled, torque * weight);
        for (sums, x) in self.shared.iter_mut().zip(scaled) {
            for (sum, z) in sums.iter_mut().zip(shared) {
                *sum = *sum + x * weight * *z;
            }
        }
    }

    /// Multiplies the weight of all rows so far by `root_of_weight`^2, between 0 and 1. Afterwards the deviations at the start
    /// also count less; see [`Payload::push`] for new rows.
    pub fn forget(&mut self, root_of_weight: R) {
        self.recursion.forget(root_of_weight);
        self.shared.iter_mut().flatten().for_each(|x| *x = *x * root_of_weight * root_of_weight);
    }

    /// The load with its standard deviations. The load need not be physically possible; [`possible`] gives a possible one.
    pub fn load(&self) -> Load<R> {
        let inverse = self.recursion.inverse_triangle();
        // K = inv(R) (inv(R)' S), S: the sums in `shared`. `halfway`: inv(R)' S.
        let mut sigma = [R::ZERO; TEN];
        let mut halfway = [[R::ZERO; D]; TEN];
        for (k, half) in halfway.iter_mut().enumerate() {
            for (row, sums) in inverse.iter().zip(&self.shared) {
                half.iter_mut().zip(sums).for_each(|(h, s)| *h = *h + row[k] * *s);
            }
        }
        for (k, sigma) in sigma.iter_mut().enumerate() {
            let mut variance = R::ZERO;
            for x in &inverse[k] {
                variance = variance + *x * *x;
            }
            for d in 0..D {
                let mut gain = R::ZERO;
                for (x, half) in inverse[k].iter().zip(&halfway) {
                    gain = gain + *x * half[d];
                }
                variance = variance + gain * gain;
            }
            *sigma = variance.sqrt();
        }
        let mut is_determined = [false; TEN];
        for ((flag, sigma), start) in is_determined.iter_mut().zip(sigma).zip(self.start) {
            *flag = sigma < R::of(DETERMINED_SHARE) * start;
        }
        Load { parameters: self.recursion.solution(), sigma, is_determined }
    }

    /// The parameters of the load, without their standard deviations.
    pub fn parameters(&self) -> [R; TEN] {
        self.recursion.solution()
    }

    /// inv(R): the part of the covariance that comes from noise is inv(R) inv(R)'.
    pub fn inverse_triangle(&self) -> [[R; TEN]; TEN] {
        self.recursion.inverse_triangle()
    }

    /// The sum of squares that the parameters explain, in units of the deviations of the rows.
    pub fn explained_square(&self) -> R {
        self.recursion.explained_square()
    }
}

/// The physically possible load that keeps mass and first moment of `parameters`, if the mass is positive: the covariance matrix
/// of the mass about its centre, 1/2 tr(I) 1 - I, gets no negative eigenvalue. No load at all if the mass is not positive.
pub fn possible<R: Real>(parameters: &[R; TEN]) -> [R; TEN] {
    let [xx, xy, xz, yy, yz, zz, mx, my, mz, m] = *parameters;
    if !m.is_positive() {
        return [R::ZERO; TEN];
    }
    let half = R::of(0.5);
    let trace = half * (xx + yy + zz);
    let moment = [mx, my, mz];
    // Second moments about the origin, then about the centre of mass.
    let about_origin = [[trace - xx, -xy, -xz], [-xy, trace - yy, -yz], [-xz, -yz, trace - zz]];
    let mut about_centre = about_origin;
    for (row, a) in about_centre.iter_mut().zip(moment) {
        row.iter_mut().zip(moment).for_each(|(x, b)| *x = *x - a * b / m);
    }
    let clipped = without_negative_part(about_centre);
    let mut s = clipped;
    for (row, a) in s.iter_mut().zip(moment) {
        row.iter_mut().zip(moment).for_each(|(x, b)| *x = *x + a * b / m);
    }
    let sum = s[0][0] + s[1][1] + s[2][2];
    [sum - s[0][0], -s[0][1], -s[0][2], sum - s[1][1], -s[1][2], sum - s[2][2], mx, my, mz, m]
}

/// Number of sweeps of Jacobi's method over a 3 x 3 matrix; it converges quadratically, and three suffice for doubles.
const JACOBI_SWEEPS: usize = 6;

/// A symmetric matrix with its negative eigenvalues replaced by zero, by Jacobi's rotations [Golub, Van Loan 2013, chapter 8].
fn without_negative_part<R: Real>(mut a: [[R; 3]; 3]) -> [[R; 3]; 3] {
    let mut v = [[R::ONE, R::ZERO, R::ZERO], [R::ZERO, R::ONE, R::ZERO], [R::ZERO, R::ZERO, R::ONE]];
    for (p, q) in [(0, 1), (0, 2), (1, 2)].iter().cycle().take(3 * JACOBI_SWEEPS).copied() {
        if !a[p][q].abs().is_positive() {
            continue;
        }
        // The rotation by the angle phi in the plane (p, q) makes a_pq zero: theta = cot(2 phi). t = tan(phi) is the root of
        // t^2 + 2 theta t - 1 = 0 with the smaller magnitude; c = cos(phi), s = sin(phi).
        let theta = (a[q][q] - a[p][p]) / (R::of(2.0) * a[p][q]);
        let root = (theta * theta + R::ONE).sqrt();
        let t = if theta < R::ZERO { -R::ONE / (root - theta) } else { R::ONE / (root + theta) };
        let c = R::ONE / (t * t + R::ONE).sqrt();
        let s = t * c;
        // A <- J' A J and V <- V J, where J is the rotation. At the end A is diagonal and the columns of V are the
        // eigenvectors.
        for row in &mut a {
            (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
        }
        for k in 0..3 {
            (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
        }
        for row in &mut v {
            (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
        }
    }
    // A_+ = sum_k max(lambda_k, 0) v_k v_k'; lambda_k: eigenvalue a_kk, v_k: column k of V.
    let mut positive = [[R::ZERO; 3]; 3];
    for k in 0..3 {
        let value = a[k][k].max(R::ZERO);
        for i in 0..3 {
            for j in 0..3 {
                positive[i][j] = positive[i][j] + value * v[i][k] * v[j][k];
            }
        }
    }
    positive
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    extern crate std;

    #[test]
    fn load_and_sigma_with_noise_and_with_an_error_of_the_robot() {
        let truth = [0.1, -0.02, 0.01, 0.2, 0.03, 0.15, 0.3, -0.2, 0.1, 2.0];
        let mut random = Random::new(8);
        let draws = 300;
        let mut squares = [0.0; TEN];
        for _ in 0..draws {
            let mut payload = Payload::<f64, 2>::new([10.0; TEN]);
            let error = [random.normal(), random.normal()];
            for _ in 0..200 {
                let row: [f64; TEN] = std::array::from_fn(|_| random.normal());
                // The error of the robot's parameters resembles the effect of the mass and of MX.
                let shared = [0.05 * row[9], 0.05 * row[6] + 0.02 * random.normal()];
                let torque = -row.iter().zip(truth).map(|(h, x)| h * x).sum::<f64>()
                    + shared.iter().zip(error).map(|(z, d)| z * d).sum::<f64>()
                    + 0.1 * random.normal();
                payload.push(&row, torque, 0.1, &shared);
            }
            let load = payload.load();
            assert!(load.is_determined.iter().all(|d| *d));
            for k in 0..TEN {
                squares[k] += ((load.parameters[k] - truth[k]) / load.sigma[k]).powi(2) / f64::from(draws);
            }
        }
        // The mean of 300 squares of standard normal numbers is 1 with a standard deviation of 0.08. The limit is four standard
        // deviations.
        assert!(squares.iter().all(|s| (s - 1.0).abs() < 0.33), "{squares:?}");
    }

    #[test]
    fn what_the_motion_does_not_show_is_said() {
        let mut payload = Payload::<f64, 0>::new([1.0; TEN]);
        let mut row = [0.0; TEN];
        row[9] = 9.81;
        for _ in 0..100 {
            payload.push(&row, -9.81 * 0.5, 0.2, &[]);
            payload.push(&row, f64::NAN, 0.2, &[]);
        }
        let load = payload.load();
        assert_eq!(load.is_determined.map(u8::from), [0, 0, 0, 0, 0, 0, 0, 0, 0, 1]);
        // The estimate starts at zero with a standard deviation of 1 kg. This biases the mass by the ratio of the variances,
        // (0.2 / 9.81)^2 / 100.
        assert!((load.parameters[9] - 0.5).abs() < 1e-5, "{load:?}");
        payload.reset();
        assert_eq!(payload.load().parameters, [0.0; TEN]);
    }

    #[test]
    fn a_possible_load_stays_and_an_impossible_one_keeps_mass_and_centre() {
        // Three point masses: a body with positive second moments.
        let mut body = [0.0; TEN];
        for (m, [x, y, z]) in [(1.0, [0.1, 0.0, 0.2]), (0.5, [-0.1, 0.3, 0.0]), (0.7, [0.0, -0.1, -0.2])] {
            let ten = [y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y, x, y, z, 1.0];
            body.iter_mut().zip(ten).for_each(|(sum, t)| *sum += m * t);
        }
        let same = possible(&body);
        assert!(same.iter().zip(body).all(|(a, b)| (a - b).abs() < 1e-12), "{same:?} {body:?}");
        let mut wrong = body;
        wrong[0] -= 0.5;
        let mended = possible(&wrong);
        assert_eq!(mended[6..], wrong[6..]);
        let again = possible(&mended);
        assert!(again.iter().zip(mended).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(mended[0] > wrong[0]);
        wrong[9] = -0.1;
        assert_eq!(possible(&wrong), [0.0; TEN]);
    }
}
