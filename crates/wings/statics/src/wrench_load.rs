//! Estimates the load after a force-torque sensor from measured wrenches and poses of the sensor.
//!
//! The load is a body with ten parameters about the sensor's origin: mass m, first moments mc, inertia I. R and p: orientation
//! and position of the sensor in a frame at rest; w: its angular velocity; F and N: force and torque; g: gravity; o: any point at
//! rest. Momentum and angular momentum H obey:
//!
//! ```text
//! d2/dt2 (m p + R mc) = R F + m g
//! d/dt H = (p - o) x R F + R N + (m (p - o) + R mc) x g
//! H = m (p - o) x p' + (p - o) x R (w x mc) + R mc x p' + R I w
//! ```
//! Each equation is multiplied by a weight function and integrated by parts over a window. The weight function and its slope
//! are zero at both ends of the window. So only the weight function is differentiated, and not the measurements
//! [Shinbrot 1957]; only p' and w are computed from the poses. The equations are linear in the ten parameters and in constant
//! offsets of the six signals. Force and torque equations have weights that follow from their residuals. Standard deviations
//! are for white noise, inflated by the correlation between successive windows.
//!
//! In a log without a clock, each row is a posture at rest: F = -m R'g, N = -mc x R'g. Postures do not determine the inertia.
//!
//! Not modelled: drift, elasticity and crosstalk of the sensor.

use crate::wrenches::Wrenches;
use linear_model::pseudo_inertia::Ten;
use logs::Error;
use numerics::least_squares::{Solution, solve};
use numerics::triangle::TriangleBuilder;

/// Gravity along z of the frame at rest, m/s^2.
pub(super) const GRAVITY: f64 = -9.81;
/// Shortest duration of a window (a short interval of the log that gives six equations), s. `WINDOW_SAMPLES`: smallest number of
/// its samples.
const WINDOW_S: f64 = 0.25;
const WINDOW_SAMPLES: usize = 24;
/// The velocity at a sample is computed from this number of samples on each side.
const NEIGHBOURS: usize = 3;
/// A time step of more than this number of median steps is a gap.
const GAP_STEPS: f64 = 3.0;
/// Number of unknowns: ten parameters, and an offset of each of the six signals.
const UNKNOWNS: usize = 16;
/// Number of repeated fits. The weights of each fit are computed from the residuals of the previous fit.
const REWEIGHTING_ROUNDS: usize = 4;
/// If the column of an inertia entry is below this fraction of the largest column, it contains only rounding errors of the
/// poses. Such columns occur if the sensor rotates about fewer than three axes.
const ROUNDING_SHARE: f64 = 1e-9;
/// Smallest standard deviation of one kind of equations (force or torque), as a fraction of the largest one.
const LEAST_DEVIATION_SHARE: f64 = 1e-12;
/// Standard deviation of a torque in the first fit (N m) relative to 1 N for a force. The ratio corresponds to a lever arm of
/// 10 cm.
const FIRST_TORQUE_DEVIATION: f64 = 0.1;
/// Smallest relative singular value in the fit of a cubic polynomial to neighbouring samples. The slope of this polynomial is
/// the velocity.
const CUBIC_RANK_TOLERANCE: f64 = 1e-12;
/// If the sine of a rotation angle is below this value, the angle is replaced by its sine.
const SMALL_SINE: f64 = 1e-9;
/// Largest value that is used for the correlation between successive windows.
const LARGEST_CORRELATION: f64 = 0.9;

type Vector3 = [f64; 3];
type Matrix3 = [[f64; 3]; 3];
type Row = [f64; UNKNOWNS];
/// An equation: the coefficients of the unknowns, and the right-hand side.
type Equation = (Row, f64);

/// A load with its accuracy.
#[derive(Clone, Debug)]
pub struct WrenchLoad {
    /// The parameters XX XY XZ YY YZ ZZ MX MY MZ M (inertia, first moments, mass) about the origin of the sensor's frame, in its
    /// axes.
    pub parameters: Ten,
    /// Standard deviations of the ten parameters.
    pub sigma: Ten,
    /// For each of the ten parameters, whether the log determines it.
    pub determined: [bool; 10],
    /// Offsets of the forces (N) and of the torques (N m) with their standard deviations. The entry of an offset that the log
    /// does not determine is `None`.
    pub offsets: [Option<(f64, f64)>; 6],
    /// Whether the sensor measures the wrench that the load exerts on the sensor; otherwise it measures the opposite wrench.
    pub is_reaction: bool,
    /// Rms residuals of a sample: of the force, N; and of the torque about a point near the sensor, N m.
    pub residuals: [f64; 2],
    /// Number of windows of the log; for a log of postures, number of postures.
    pub windows: usize,
}

/// Determines the load from a log of a force-torque sensor.
///
/// Fails if the log has too few windows without gaps, or if numbers exceed the range of f64.
pub fn wrench_load(log: &Wrenches) -> Result<WrenchLoad, Error> {
    wrench_load_under(log, GRAVITY)
}

/// Determines the load. `gravity`: gravity along z, m/s^2; zero if the driver of the sensor subtracts the weight.
pub(crate) fn wrench_load_under(log: &Wrenches, gravity: f64) -> Result<WrenchLoad, Error> {
    let down = [0.0, 0.0, gravity];
    let mut groups = if log.t.is_empty() { postures(log, down) } else { windows(log, down) };
    leave_out_rounding(&mut groups);
    let windows = groups[0].rows.len() / 3;
    if 3 * windows < 2 * UNKNOWNS {
        let what = if log.t.is_empty() { "postures" } else { "windows of a quarter of a second without a gap" };
        let least = (2 * UNKNOWNS).div_ceil(3);
        return Err(Error::at(&log.name, 0, format!("{windows} {what} are too few for a load: {least} are the least")));
    }
    // Initial weights: a torque is a force times a lever arm of 10 cm.
    let mut deviations: Vec<f64> = groups.iter().map(|g| g.first_deviation).collect();
    let mut solution = weighted(&groups, &deviations);
    for _ in 0..REWEIGHTING_ROUNDS {
        for (deviation, group) in deviations.iter_mut().zip(&groups) {
            let sum: f64 = group.residuals(&solution).map(|r| r * r).sum();
            let free = group.rows.len() as f64 - UNKNOWNS as f64 / groups.len() as f64;
            *deviation =
                (sum / free.max(1.0)).sqrt().max(LEAST_DEVIATION_SHARE * group.largest()).max(f64::MIN_POSITIVE);
        }
        solution = weighted(&groups, &deviations);
    }
    if !solution.x.iter().all(|x| x.is_finite()) {
        return Err(Error::at(&log.name, 0, "its numbers exceed the range of floating-point numbers"));
    }
    Ok(found(&groups, &deviations, &solution, windows))
}

fn found(groups: &[EquationGroup], deviations: &[f64], solution: &Solution, windows: usize) -> WrenchLoad {
    let correlation = correlation(groups, deviations, solution);
    let inflation = ((1.0 + correlation) / (1.0 - correlation)).sqrt();
    let sigma = |k: usize| inflation * solution.inverse[(k, k)].max(0.0).sqrt();
    let is_reaction = solution.x[9] < 0.0;
    let sign = if is_reaction { -1.0 } else { 1.0 };
    let offset = |k: usize| solution.determined[k].then(|| (solution.x[k], sigma(k)));
    WrenchLoad {
        parameters: std::array::from_fn(|k| sign * solution.x[k]),
        sigma: std::array::from_fn(sigma),
        determined: std::array::from_fn(|k| solution.determined[k]),
        offsets: std::array::from_fn(|k| offset(10 + k)),
        is_reaction,
        residuals: [0, 1].map(|k| deviations[k] / groups[k].of_a_sample),
        windows,
    }
}

/// The equations of one kind (force or torque, even or odd weight function): three per window, or three per posture.
struct EquationGroup {
    rows: Vec<Equation>,
    /// Standard deviation of an equation that is assumed in the first fit.
    first_deviation: f64,
    /// Standard deviation of the right-hand side of an equation if the noise of each sample has the standard deviation 1.
    of_a_sample: f64,
}

impl EquationGroup {
    fn new(first_deviation: f64) -> EquationGroup {
        EquationGroup { rows: Vec::new(), first_deviation, of_a_sample: 1.0 }
    }

    fn residuals<'a>(&'a self, solution: &'a Solution) -> impl Iterator<Item = f64> + 'a {
        self.rows.iter().map(|(row, y)| y - row.iter().zip(&solution.x).map(|(a, x)| a * x).sum::<f64>())
    }

    fn largest(&self) -> f64 {
        self.rows.iter().fold(0.0, |largest, (_, y)| largest.max(y.abs()))
    }
}

/// Sets the columns of inertia entries to zero that are only rounding.
fn leave_out_rounding(groups: &mut [EquationGroup]) {
    let norm = |c: usize| groups.iter().flat_map(|g| &g.rows).map(|(row, _)| row[c] * row[c]).sum::<f64>().sqrt();
    let norms: [f64; 6] = std::array::from_fn(norm);
    let largest = norms.into_iter().fold(0.0, f64::max);
    for (row, _) in groups.iter_mut().flat_map(|group| &mut group.rows) {
        row.iter_mut().zip(norms).filter(|(_, norm)| *norm < ROUNDING_SHARE * largest).for_each(|(x, _)| *x = 0.0);
    }
}

fn weighted(groups: &[EquationGroup], deviations: &[f64]) -> Solution {
    let mut block = TriangleBuilder::new(UNKNOWNS);
    for (group, deviation) in groups.iter().zip(deviations) {
        for (row, y) in &group.rows {
            block.push(&row.map(|x| x / deviation), y / deviation);
        }
    }
    solve(&block.finish())
}

/// Correlation between the residuals of successive windows, as a mean over all kinds of equations. At least zero.
fn correlation(groups: &[EquationGroup], deviations: &[f64], solution: &Solution) -> f64 {
    let (mut products, mut count) = (0.0, 0.0);
    for (group, deviation) in groups.iter().zip(deviations) {
        let scaled: Vec<f64> = group.residuals(solution).map(|r| r / deviation).collect();
        for (a, b) in scaled.iter().zip(scaled.iter().skip(3)) {
            products += a * b;
            count += 1.0;
        }
    }
    (products / f64::max(count, 1.0)).clamp(0.0, LARGEST_CORRELATION)
}

/// The equations of postures at rest, in two groups: equations of forces and equations of torques.
fn postures(log: &Wrenches, down: Vector3) -> Vec<EquationGroup> {
    let mut groups = vec![EquationGroup::new(1.0), EquationGroup::new(FIRST_TORQUE_DEVIATION)];
    for ((rotation, force), torque) in log.rotation.iter().zip(&log.force).zip(&log.torque) {
        let down = back(rotation, down);
        for i in 0..3 {
            let (mut of_force, mut of_torque) = ([0.0; UNKNOWNS], [0.0; UNKNOWNS]);
            of_force[9] = -down[i];
            of_force[10 + i] = 1.0;
            for k in 0..3 {
                of_torque[6 + k] = -cross(unit(k), down)[i];
            }
            of_torque[13 + i] = 1.0;
            groups[0].rows.push((of_force, force[i]));
            groups[1].rows.push((of_torque, torque[i]));
        }
    }
    groups
}

/// The equations of windows, in four groups: forces and torques with an even weight function, then with an odd weight function.
fn windows(log: &Wrenches, down: Vector3) -> Vec<EquationGroup> {
    let mut groups = Vec::from([1.0, FIRST_TORQUE_DEVIATION, 1.0, FIRST_TORQUE_DEVIATION].map(EquationGroup::new));
    let mut squares = [0.0; 2];
    let velocities = Velocities::of(log);
    for (first, last) in spans(log) {
        for odd in [0, 1] {
            let window = Window::of(log, first, last, odd == 1);
            squares[odd] += window.samples.iter().map(|s| s.0 * s.0).sum::<f64>();
            let (force, torque) = equations(log, &velocities, &window, down);
            groups[2 * odd].rows.extend(force);
            groups[2 * odd + 1].rows.extend(torque);
        }
    }
    for (k, group) in groups.iter_mut().enumerate() {
        group.of_a_sample = (3.0 * squares[k / 2] / (group.rows.len() as f64).max(1.0)).sqrt();
    }
    groups
}

/// For each window, the indices of its first and last sample.
pub(super) fn spans(log: &Wrenches) -> Vec<(usize, usize)> {
    let (mut first, mut spans, step) = (0, Vec::new(), usual_step(&log.t));
    while first + WINDOW_SAMPLES <= log.t.len() {
        let enough = |&last: &usize| log.t[last] - log.t[first] >= WINDOW_S;
        let Some(last) = (first + WINDOW_SAMPLES - 1..log.t.len()).find(enough) else { break };
        if let Some(gap) = (first..last).rev().find(|&k| log.t[k + 1] - log.t[k] > GAP_STEPS * step) {
            first = gap + 1;
            continue;
        }
        spans.push((first, last));
        first = last + 1;
    }
    spans
}

fn usual_step(t: &[f64]) -> f64 {
    let mut steps: Vec<f64> = t.windows(2).map(|w| w[1] - w[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(0.0)
}

/// The weight function at the samples of a window: (1 - u^2)^4, or u (1 - u^2)^4 if odd. u: time, scaled to -1 .. 1 in the
/// window.
pub(super) struct Window {
    pub(super) first: usize,
    /// For each sample, the weight function and its first two derivatives, multiplied by the time step, s.
    pub(super) samples: Vec<(f64, f64, f64)>,
    /// The point o, which is at rest and near the sensor, m. Angular momentum is about this point.
    pub(super) point: Vector3,
}

impl Window {
    pub(super) fn of(log: &Wrenches, first: usize, last: usize, odd: bool) -> Window {
        let t = &log.t[first..=last];
        let (middle, half) = ((t[0] + t[t.len() - 1]) / 2.0, (t[t.len() - 1] - t[0]) / 2.0);
        let sample = |k: usize| {
            let u = (t[k] - middle) / half;
            let v = (1.0 - u * u).max(0.0);
            let step = (t[(k + 1).min(t.len() - 1)] - t[k.saturating_sub(1)]) / 2.0;
            let (f, d, dd) = (v.powi(4), -8.0 * u * v.powi(3), 8.0 * v * v * (7.0 * u * u - 1.0));
            let (f, d, dd) = if odd { (u * f, f + u * d, 2.0 * d + u * dd) } else { (f, d, dd) };
            (f * step, d * step / half, dd * step / (half * half))
        };
        let samples = (0..t.len()).map(sample).collect();
        Window { first, samples, point: log.position[usize::midpoint(first, last)] }
    }
}

/// The equations of a window of the log: three for momentum and three for angular momentum.
fn equations(
    log: &Wrenches,
    velocities: &Velocities,
    window: &Window,
    down: Vector3,
) -> (Vec<Equation>, Vec<Equation>) {
    let (mut force, mut torque) = ([([0.0; UNKNOWNS], 0.0); 3], [([0.0; UNKNOWNS], 0.0); 3]);
    for (k, &(f, d, dd)) in (window.first..).zip(&window.samples) {
        let turn = &log.rotation[k];
        let place = minus(log.position[k], window.point);
        let (speed, spin) = (velocities.linear[k], velocities.angular[k]);
        let (pushed, twisted) = (turned(turn, log.force[k]), turned(turn, log.torque[k]));
        let about = plus(cross(place, pushed), twisted);
        let (swept, fallen) = (cross(place, speed), cross(place, down));
        for i in 0..3 {
            force[i].1 += f * pushed[i];
            force[i].0[9] += dd * place[i] - f * down[i];
            torque[i].1 += f * about[i];
            torque[i].0[9] -= d * swept[i] + f * fallen[i];
        }
        for c in 0..3 {
            let axis = turned(turn, unit(c));
            let moved = plus(cross(place, turned(turn, cross(spin, unit(c)))), cross(axis, speed));
            let (weighed, levered) = (cross(axis, down), cross(place, axis));
            for i in 0..3 {
                force[i].0[6 + c] += dd * axis[i];
                force[i].0[10 + c] += f * axis[i];
                torque[i].0[6 + c] -= d * moved[i] + f * weighed[i];
                torque[i].0[10 + c] += f * levered[i];
                torque[i].0[13 + c] += f * axis[i];
            }
        }
        // The angular momentum I w, as a linear function of the entries xx xy xz yy yz zz of I.
        for (c, (a, b)) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate() {
            let mut momentum = [0.0; 3];
            momentum[a] = spin[b];
            momentum[b] = spin[a];
            let momentum = turned(turn, momentum);
            (0..3).for_each(|i| torque[i].0[c] -= d * momentum[i]);
        }
    }
    (force.to_vec(), torque.to_vec())
}

/// For each sample: velocity of the sensor's origin in the frame at rest, m/s; angular velocity in the axes of the sensor, rad/s.
struct Velocities {
    linear: Vec<Vector3>,
    angular: Vec<Vector3>,
}

impl Velocities {
    /// The slopes, at each sample, of cubic polynomials that are fitted to its neighbours. For the angular velocity, the
    /// polynomial is fitted to the rotation vectors from the sample to its neighbours.
    fn of(log: &Wrenches) -> Velocities {
        let count = log.t.len();
        let mut found = Velocities { linear: Vec::with_capacity(count), angular: Vec::with_capacity(count) };
        for k in 0..count {
            let near = k.saturating_sub(NEIGHBOURS)..=(k + NEIGHBOURS).min(count - 1);
            let times: Vec<f64> = near.clone().map(|i| log.t[i] - log.t[k]).collect();
            let weights = slope_weights(&times);
            let (mut linear, mut angular) = ([0.0; 3], [0.0; 3]);
            for (i, weight) in near.zip(weights) {
                let (moved, turned) =
                    (minus(log.position[i], log.position[k]), turn(&log.rotation[k], &log.rotation[i]));
                (0..3).for_each(|a| {
                    linear[a] += weight * moved[a];
                    angular[a] += weight * turned[a];
                });
            }
            found.linear.push(linear);
            found.angular.push(angular);
        }
        found
    }
}

/// Weights for samples at these times, s. The weighted sum of the samples is the slope, at time zero, of a cubic polynomial that
/// is fitted to the samples.
fn slope_weights(times: &[f64]) -> Vec<f64> {
    let scale = times.iter().fold(f64::MIN_POSITIVE, |s: f64, t| s.max(t.abs()));
    let powers = nalgebra::DMatrix::from_fn(times.len(), times.len().min(4), |r, c| (times[r] / scale).powi(c as i32));
    let inverse =
        powers.pseudo_inverse(CUBIC_RANK_TOLERANCE).unwrap_or_else(|_| nalgebra::DMatrix::zeros(4, times.len()));
    (0..times.len()).map(|k| if inverse.nrows() > 1 { inverse[(1, k)] / scale } else { 0.0 }).collect()
}

/// The rotation between two orientations, as a rotation vector in the axes of `from`, rad.
fn turn(from: &Matrix3, to: &Matrix3) -> Vector3 {
    let entry = |i: usize, k: usize| (0..3).map(|a| from[a][i] * to[a][k]).sum::<f64>();
    let twice = [entry(2, 1) - entry(1, 2), entry(0, 2) - entry(2, 0), entry(1, 0) - entry(0, 1)];
    let sine = (twice.iter().map(|x| x * x).sum::<f64>()).sqrt() / 2.0;
    let cosine = (entry(0, 0) + entry(1, 1) + entry(2, 2) - 1.0) / 2.0;
    let scale = if sine < SMALL_SINE { 0.5 } else { sine.atan2(cosine) / (2.0 * sine) };
    twice.map(|x| scale * x)
}

fn unit(k: usize) -> Vector3 {
    std::array::from_fn(|i| f64::from(u8::from(i == k)))
}

fn cross(a: Vector3, b: Vector3) -> Vector3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn plus(a: Vector3, b: Vector3) -> Vector3 {
    std::array::from_fn(|i| a[i] + b[i])
}

fn minus(a: Vector3, b: Vector3) -> Vector3 {
    std::array::from_fn(|i| a[i] - b[i])
}

fn turned(m: &Matrix3, v: Vector3) -> Vector3 {
    m.map(|row| (0..3).map(|k| row[k] * v[k]).sum())
}

fn back(m: &Matrix3, v: Vector3) -> Vector3 {
    std::array::from_fn(|k| (0..3).map(|i| m[i][k] * v[i]).sum())
}

#[cfg(test)]
pub(crate) mod tests {
    use random::Random;

    use super::*;

    /// The ten inertial parameters, about the origin, of a body of 2.1 kg with its centre of mass at (0.02, -0.03, 0.12) m.
    fn body() -> Ten {
        let (m, [x, y, z]) = (2.1, [0.02, -0.03, 0.12]);
        [
            0.011 + m * (y * y + z * z),
            0.001 - m * x * y,
            -0.002 - m * x * z,
            0.013 + m * (x * x + z * z),
            0.0015 - m * y * z,
            0.006 + m * (x * x + y * y),
            m * x,
            m * y,
            m * z,
            m,
        ]
    }

    /// Roll, pitch, yaw and position of the sensor at time t, and their first and second derivatives.
    fn motion(t: f64) -> [[f64; 6]; 3] {
        let [mut x, mut dx, mut ddx] = [[0.0; 6]; 3];
        let sines = [(0.9, 2.1), (0.7, 3.3), (1.1, 1.7), (0.2, 2.9), (0.25, 1.3), (0.15, 3.7)];
        for (k, (size, rate)) in sines.into_iter().enumerate() {
            let (s, c) = (rate * t + k as f64).sin_cos();
            (x[k], dx[k], ddx[k]) = (size * s, size * rate * c, -size * rate * rate * s);
        }
        [x, dx, ddx]
    }

    fn rotation([r, p, y]: Vector3) -> Matrix3 {
        let [(sr, cr), (sp, cp), (sy, cy)] = [r, p, y].map(f64::sin_cos);
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    }

    /// The angular velocity in the axes of the sensor, from roll, pitch, yaw and their derivatives.
    fn spin([r, p, _]: Vector3, [dr, dp, dy]: Vector3) -> Vector3 {
        let [(sr, cr), (sp, cp)] = [r, p].map(f64::sin_cos);
        [dr - sp * dy, cr * dp + sr * cp * dy, -sr * dp + cr * cp * dy]
    }

    const OFFSETS: [f64; 6] = [3.0, -2.0, 5.0, 0.2, 0.1, -0.3];

    /// Force, torque, orientation and position of the sensor at time t, by the Newton-Euler equations of textbooks.
    fn wrench(body: &Ten, t: f64) -> (Vector3, Vector3, Matrix3, Vector3) {
        let [x, dx, ddx] = motion(t);
        let three = |v: &[f64; 6], at: usize| [v[at], v[at + 1], v[at + 2]];
        let turn = rotation(three(&x, 0));
        let w = spin(three(&x, 0), three(&dx, 0));
        // The derivative of w by a difference quotient of fourth order. The error of this quotient is 1e-12.
        let at = |h: f64| {
            let [x, dx, _] = motion(t + h);
            spin(three(&x, 0), three(&dx, 0))
        };
        let (h, near, far) = (1e-3, [at(1e-3), at(-1e-3)], [at(2e-3), at(-2e-3)]);
        let dw: Vector3 =
            std::array::from_fn(|i| (8.0 * (near[0][i] - near[1][i]) - (far[0][i] - far[1][i])) / (12.0 * h));
        let felt = back(&turn, minus(three(&ddx, 3), [0.0, 0.0, GRAVITY]));
        let &[xx, xy, xz, yy, yz, zz, mx, my, mz, m] = body;
        let inertia = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let first = [mx, my, mz];
        let force = plus(plus(felt.map(|a| m * a), cross(dw, first)), cross(w, cross(w, first)));
        let torque = plus(plus(cross(first, felt), turned(&inertia, dw)), cross(w, turned(&inertia, w)));
        (force, torque, turn, three(&x, 3))
    }

    /// A log of the moving body. `noise`: standard deviation of the forces, N. `sign`: sign of the measured wrench.
    pub(crate) fn log(seconds: f64, noise: f64, sign: f64, seed: u64) -> Wrenches {
        let mut random = Random::new(seed);
        let count = (seconds * 250.0) as usize;
        let mut log =
            Wrenches { name: "w.csv".into(), t: (0..count).map(|k| k as f64 / 250.0).collect(), ..Wrenches::default() };
        for &t in &log.t {
            let (force, torque, turn, place) = wrench(&body(), t);
            let mut noisy = |x: Vector3, size: f64, at: usize| -> Vector3 {
                std::array::from_fn(|i| sign * x[i] + OFFSETS[at + i] + size * noise * random.normal())
            };
            log.force.push(noisy(force, 1.0, 0));
            log.torque.push(noisy(torque, 0.05, 3));
            log.rotation.push(turn);
            log.position.push(place);
        }
        log
    }

    #[test]
    fn the_body_comes_back() {
        for sign in [1.0, -1.0] {
            let found = wrench_load(&log(10.0, 0.0, sign, 1)).unwrap();
            assert_eq!(found.is_reaction, sign < 0.0);
            for (k, (x, truth)) in found.parameters.iter().zip(body()).enumerate() {
                assert!((x - truth).abs() < 2e-5, "{k}: {x} {truth}");
            }
            for (offset, truth) in found.offsets.iter().zip(OFFSETS) {
                assert!((offset.unwrap().0 - truth).abs() < 1e-3, "{offset:?} {truth}");
            }
        }
    }

    /// With noise, the errors agree with their standard deviations: the mean squares of 16 normalised errors over 30 simulated
    /// logs are near 1.
    #[test]
    fn deviations_hold_the_errors() {
        let (mut squares, mut left, draws) = ([0.0; UNKNOWNS], [0.0; 2], 30);
        for seed in 0..draws {
            let found = wrench_load(&log(12.0, 0.8, 1.0, seed)).unwrap();
            (0..2).for_each(|k| left[k] += found.residuals[k] / draws as f64);
            let offsets = found.offsets.map(|o| o.unwrap());
            let estimates = found.parameters.iter().copied().zip(found.sigma).chain(offsets);
            for (k, ((x, sigma), truth)) in estimates.zip(body().into_iter().chain(OFFSETS)).enumerate() {
                squares[k] += ((x - truth) / sigma).powi(2) / draws as f64;
            }
        }
        // The rms of the residuals of 138 equations has a relative error of 6 %. The mean over 30 logs has a relative error of
        // 1.1 %, and four times this error is allowed. The force noise also causes torque noise, because the torque is about a
        // point some centimetres from the sensor.
        assert!((left[0] / 0.8 - 1.0).abs() < 0.044 && (0.038..0.05).contains(&left[1]), "{left:?}");
        let mean = squares.iter().sum::<f64>() / UNKNOWNS as f64;
        // The mean square of 480 normal numbers, which are correlated within a log, differs from 1 by at most a fifth.
        assert!((0.75..1.25).contains(&mean) && squares.iter().all(|s| *s < 2.2), "{mean} {squares:?}");
    }

    /// A log of the body at rest in `count` orientations.
    pub(crate) fn rests(count: usize, noise: f64, seed: u64) -> Wrenches {
        let mut random = Random::new(seed);
        let (mut log, truth) = (log(1.0, 0.0, 1.0, 1), body());
        log.t.clear();
        let first = [truth[6], truth[7], truth[8]];
        for k in 0..count {
            log.rotation[k] = rotation([0, 1, 2].map(|_| random.between(-3.0, 3.0)));
            let down = back(&log.rotation[k], [0.0, 0.0, GRAVITY]);
            log.force[k] = down.map(|g| -truth[9] * g + noise * random.normal());
            log.torque[k] = cross(first, down).map(|x| -x + 0.04 * noise * random.normal());
            (0..3).for_each(|i| log.force[k][i] += OFFSETS[i]);
        }
        log.force.truncate(count);
        log.torque.truncate(count);
        log.rotation.truncate(count);
        log.position = vec![[0.0; 3]; count];
        log
    }

    #[test]
    fn postures_tell_mass_and_centre() {
        let (truth, mut log) = (body(), rests(250, 0.5, 3));
        let found = wrench_load(&log).unwrap();
        assert_eq!(found.determined, [false, false, false, false, false, false, true, true, true, true]);
        for k in 6..10 {
            let error = (found.parameters[k] - truth[k]) / found.sigma[k];
            assert!(error.abs() < 4.0, "{k}: {error}");
        }
        log.force.truncate(5);
        log.rotation.truncate(5);
        let message = wrench_load(&log).unwrap_err().to_string();
        assert!(message.contains("5 postures are too few for a load: 11 are the least"), "{message}");
    }
    /// If a sensor rotates about only one axis, the log determines only the inertia entries of this axis. Rounding in the poses
    /// must not determine other entries.
    #[test]
    fn one_axis_tells_no_whole_inertia() {
        let mut log = log(10.0, 0.02, 1.0, 4);
        // The computed sine of pi is not exactly zero, so the poses contain rounding errors.
        log.rotation = log.t.iter().map(|t| rotation([std::f64::consts::PI, 0.0, (2.0 * t).sin()])).collect();
        let found = wrench_load(&log).unwrap();
        assert_eq!(found.determined[..6], [false, false, true, false, true, true]);
        assert!(found.parameters.iter().all(|x| x.abs() < 1e3), "{:?}", found.parameters);
    }
}
