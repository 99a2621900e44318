//! Computes the errors of the torques that an estimate predicts, from the covariance of its parameters, for each use of
//! torques.
//!
//! Torques are evaluated at random states. y_j: regressor row of joint j; x, C: parameters and their covariance; e_j, t_j:
//! rms error and rms torque of joint j, N m (N); e: relative error.
//!
//! ```text
//! e_j^2 = mean y_j C y_j'       t_j^2 = mean (y_j x)^2       e = sqrt(sum e_j^2 / sum t_j^2)
//! ```
//! e_j and t_j refer to the measured torque: t_j includes a known spring, and both are multiplied by a known scale. N m and N
//! are not added: with revolute and prismatic joints, e is the larger of the values of both kinds.
//!
//! The relative error is large for a motion that needs little torque. So about twenty motions are drawn at random, each over
//! half of each joint's range, and the result is the 90 % quantile of e over these motions.
//!
//! For gravity compensation, the torques are the gravity torques at rest, without friction. Joints with a vertical axis have no
//! gravity torque. So the error is divided by the rms gravity torque, but by at least `GRAVITY_REFERENCE_SHARE` times the
//! torque of motion.
//!
//! Errors of the model are not included, since the covariance does not contain such errors.

use linear_model::linear_model::Model;
use linear_model::regressor::predict_load;
use linear_model::states::States;
use numerics::least_squares::solve;
use numerics::triangle::TriangleBuilder;
use random::Random;
use serde::{Deserialize, Serialize};

/// A purpose for which torques are predicted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Use {
    /// Gravity compensation: torques that hold the robot at rest, at positions within the position limits.
    Gravity,
    /// Feedforward of motions at positions within the limits, up to the speeds of the logs.
    SpeedsSeen,
    /// Feedforward of motions at positions within the limits, up to the speed limits of the robot.
    SpeedLimits,
}

impl Use {
    /// All uses of predicted torques.
    pub const ALL: [Use; 3] = [Use::Gravity, Use::SpeedsSeen, Use::SpeedLimits];

    /// Name of the use in reports.
    pub fn name(self) -> &'static str {
        match self {
            Use::Gravity => "gravity compensation",
            Use::SpeedsSeen => "feedforward at the speeds seen",
            Use::SpeedLimits => "feedforward at the speed limits",
        }
    }
}

/// Ranges of position, speed and acceleration, one entry per coordinate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionRange {
    /// Smallest and largest position, rad (m).
    pub position: Vec<(f64, f64)>,
    /// Largest speed, rad/s (m/s).
    pub speed: Vec<f64>,
    /// Largest acceleration, rad/s^2 (m/s^2).
    pub acceleration: Vec<f64>,
}

/// The rms error of the predicted torque of one joint, and the rms torque with which this error is compared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointTorqueError {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Root mean square of the torque error, N m (N); infinite if the data do not determine the torque.
    pub error: f64,
    /// Root mean square of the torque with which the error is compared, N m (N).
    pub torque: f64,
}

/// The error of the predicted torques in one use.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TorqueError {
    /// The use of the torques.
    #[serde(rename = "use")]
    pub of: Use,
    /// Error of each joint, one per coordinate.
    pub joints: Vec<JointTorqueError>,
    /// Relative error over all joints, as the 90 % quantile over random motions. If a robot has revolute and prismatic joints,
    /// the larger of the errors of both kinds.
    pub relative: f64,
    /// Relative error like `relative`, but at positions within the range of the logs. This error is given only if `relative`
    /// (positions within the limits) exceeds `SURE_TORQUE`, and if the error at positions of the logs is less than half of
    /// `relative`; otherwise `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within_seen: Option<f64>,
}

/// A predicted torque counts as accurate up to this relative error.
pub(crate) const SURE_TORQUE: f64 = 0.05;

/// The error of gravity torques is divided by at least this share of the rms torque of motion, because some axes have no
/// gravity torque.
const GRAVITY_REFERENCE_SHARE: f64 = 0.3;

/// Largest number of random states at which the torques of a use are evaluated.
const MOST_STATES: usize = 200;
/// Largest number of products in the variances y C y' of all torques (y: row, C: covariance). This number limits the number of
/// random states if there are many parameters.
const MOST_PRODUCTS: usize = 20_000_000;
/// Smallest number of random states at which the torques of a use are evaluated.
const FEWEST_STATES: usize = 30;
/// Number of random states that belong to one random motion.
const STATES_PER_MOTION: usize = 10;
/// Each random motion covers this share of each joint's range.
const MOTION_RANGE_SHARE: f64 = 0.5;
/// Limit for rounding errors. A change x of the parameters changes a torque by y x (y: regressor row). The change of the torque
/// counts only if |y x| exceeds the sum of |y_c x_c| times this number, and if the sum itself exceeds this number, N m (N).
const SHOWN_SHARE: f64 = 1e-6;
/// The reported relative error is this quantile over the random motions.
const REPORTED_QUANTILE: f64 = 0.9;
/// The error at positions within the range of the logs is reported in addition, if it is below this share of the error at
/// positions within the joint limits.
const NEAR_ERROR_SHARE: f64 = 0.5;

impl TorqueError {
    /// The joint with the largest error relative to its torque, and this relative error; `None` if no joint has a torque and
    /// a finite error.
    pub fn worst(&self) -> Option<(&str, f64)> {
        let known = self.joints.iter().filter(|j| j.torque > 0.0 && j.error.is_finite());
        let of = |j: &JointTorqueError| j.error / j.torque;
        known.max_by(|a, b| of(a).total_cmp(&of(b))).map(|j| (j.coordinate.as_str(), of(j)))
    }

    /// Names of the joints whose torque the data do not determine.
    pub(crate) fn undetermined_joints(&self) -> Vec<&str> {
        self.joints.iter().filter(|j| !j.error.is_finite()).map(|j| j.coordinate.as_str()).collect()
    }
}

/// Uncertainty of the parameters, from several sources. The errors of predicted torques are computed from this uncertainty.
#[derive(Clone, Copy, Debug)]
pub struct ErrorContributions<'a> {
    /// Covariance C of the parameters for noise, row by row.
    pub covariance: &'a [Vec<f64>],
    /// Further possible changes of the parameters, for example by a fault of the log; one vector of changes per fault. For each
    /// torque, the largest squared effect is added to the variance.
    pub changes: &'a [Vec<f64>],
    /// Changes of the parameters that single logs cause, one vector per log. For each torque, the sum of the squared effects
    /// replaces the variance from C if the sum is larger.
    pub logs: &'a [Vec<f64>],
    /// Changes of the parameters that the logs do not determine, one vector each. A torque that depends on such a change has
    /// an infinite error.
    pub open: &'a [Vec<f64>],
}

/// Computes the errors of predicted torques for every use. `unsure`: errors of the parameters x; `seen`: ranges of the motion
/// in the logs; `limits`: ranges that the robot allows.
pub fn torque_errors(
    model: &Model,
    x: &[f64],
    unsure: ErrorContributions,
    seen: &MotionRange,
    limits: &MotionRange,
) -> Vec<TorqueError> {
    let wide = |rates: &MotionRange| MotionRange { position: limits.position.clone(), ..rates.clone() };
    let narrow = |rates: &MotionRange| MotionRange { position: seen.position.clone(), ..rates.clone() };
    let (found, mut near) = (errors_within(model, x, unsure, [wide(seen), limits.clone()]), None);
    let with_near = |(k, error): (usize, TorqueError)| {
        if error.relative <= SURE_TORQUE {
            return error;
        }
        let near = near.get_or_insert_with(|| errors_within(model, x, unsure, [seen.clone(), narrow(limits)]));
        let relative = near[k].relative;
        TorqueError { within_seen: Some(relative).filter(|near| *near < NEAR_ERROR_SHARE * error.relative), ..error }
    };
    found.into_iter().enumerate().map(with_near).collect()
}

/// The torque error of each use. `seen`: range of motion for the uses gravity compensation and feedforward at the speeds of the
/// logs; `limits`: range of motion for the use feedforward at the speed limits.
fn errors_within(
    model: &Model,
    x: &[f64],
    unsure: ErrorContributions,
    [seen, limits]: [MotionRange; 2],
) -> [TorqueError; 3] {
    let moving = sums(model, x, unsure, &seen, true);
    let mut at_rest = mean(&sums(model, x, unsure, &seen, false));
    for (at_rest, moving) in at_rest.iter_mut().zip(&mean(&moving)) {
        at_rest.1 = at_rest.1.max(GRAVITY_REFERENCE_SHARE * GRAVITY_REFERENCE_SHARE * moving.1);
    }
    [
        error(model, Use::Gravity, &[at_rest]),
        error(model, Use::SpeedsSeen, &moving),
        error(model, Use::SpeedLimits, &sums(model, x, unsure, &limits, true)),
    ]
}

/// Rank of the regressor at random states within `range`. No log in this range can have a larger rank. `x`: base parameters,
/// which predict the load for load-dependent friction.
pub fn shown_rank(model: &Model, x: &[f64], range: &MotionRange) -> usize {
    let p = model.p();
    let mut states = random_states(model, range, MOST_STATES.max(p), true);
    predict_load(model.regressor, &mut states, x);
    let mut rows = TriangleBuilder::new(p);
    model.rows(&states, 0..states.len(), |_, all| all.chunks_exact(p).for_each(|row| rows.push(row, 0.0)));
    solve(&rows.finish()).rank
}

/// For each random motion and each joint: (e_j^2, t_j^2), the mean squared error and the mean squared torque, (N m)^2 or N^2.
/// `moves`: false for states at rest; the torques then contain no friction.
fn sums(
    model: &Model,
    x: &[f64],
    unsure: ErrorContributions,
    range: &MotionRange,
    moves: bool,
) -> Vec<Vec<(f64, f64)>> {
    let (n, p, base) = (model.n(), model.p(), model.regressor.parameters().len());
    let count = (MOST_PRODUCTS / (n * p * p).max(1)).clamp(FEWEST_STATES, MOST_STATES);
    let mut states = random_states(model, range, count, moves);
    predict_load(model.regressor, &mut states, &x[..base]);
    let mut sums = vec![vec![(0.0, 0.0); n]; count.div_ceil(STATES_PER_MOTION)];
    model.rows(&states, 0..count, |r, rows| {
        let first = r / STATES_PER_MOTION * STATES_PER_MOTION;
        let count = STATES_PER_MOTION.min(count - first);
        for (j, (row, sum)) in rows.chunks_exact_mut(p).zip(&mut sums[r / STATES_PER_MOTION]).enumerate() {
            if !moves {
                row[base..].fill(0.0);
            }
            let used: Vec<usize> = (0..p).filter(|&c| row[c] != 0.0).collect();
            // e_j^2 = y_j C y_j'; only entries of y_j that are not zero are summed.
            let of = |&a: &usize| row[a] * used.iter().map(|&b| unsure.covariance[a][b] * row[b]).sum::<f64>();
            let square = |x: &Vec<f64>| used.iter().map(|&c| row[c] * x[c]).sum::<f64>().powi(2);
            let changed = unsure.changes.iter().map(square).fold(0.0, f64::max);
            let by_logs = unsure.logs.iter().map(square).sum::<f64>();
            let shows = |x: &Vec<f64>| {
                let all: f64 = used.iter().map(|&c| (row[c] * x[c]).abs()).sum();
                square(x).sqrt() > SHOWN_SHARE * all && all > SHOWN_SHARE
            };
            let open = if unsure.open.iter().any(shows) { f64::INFINITY } else { 0.0 };
            // The transmission removed the scale and the spring of the joint from the torque. The measured torque contains
            // both.
            let weight = model.scale(j).powi(2) / count as f64;
            let torque = used.iter().map(|&c| row[c] * x[c]).sum::<f64>() + model.spring(&states, r, j);
            sum.0 += weight * (used.iter().map(of).sum::<f64>().max(by_logs) + changed + open);
            sum.1 += weight * torque * torque;
        }
    });
    sums
}

/// Mean of (e_j^2, t_j^2) over the motions, for each joint.
fn mean(motions: &[Vec<(f64, f64)>]) -> Vec<(f64, f64)> {
    let count = motions.len() as f64;
    let of = |k: usize| motions.iter().fold((0.0, 0.0), |sum, m| (sum.0 + m[k].0 / count, sum.1 + m[k].1 / count));
    (0..motions.first().map_or(0, Vec::len)).map(of).collect()
}

/// Makes the error of a use. `motions`: for each motion, (e_j^2, t_j^2) of each joint.
fn error(model: &Model, of: Use, motions: &[Vec<(f64, f64)>]) -> TorqueError {
    let all = mean(motions);
    let named = model.regressor.coordinates().iter().zip(&all);
    let joint = |(coordinate, &(error, torque)): (&String, &(f64, f64))| JointTorqueError {
        coordinate: coordinate.clone(),
        error: error.max(0.0).sqrt(),
        torque: torque.sqrt(),
    };
    let over = |sums: &[(f64, f64)], slides: bool| {
        let alike = (0..sums.len()).filter(|k| model.regressor.is_prismatic(*k) == slides);
        let (error, torque) = alike.fold((0.0, 0.0), |sum, k| (sum.0 + sums[k].0, sum.1 + sums[k].1));
        // If there is no torque, there is no error.
        if error > 0.0 { (error / torque).sqrt() } else { 0.0 }
    };
    let mut relative: Vec<f64> = motions.iter().map(|sums| over(sums, false).max(over(sums, true))).collect();
    relative.sort_by(f64::total_cmp);
    let at = (REPORTED_QUANTILE * relative.len() as f64) as usize;
    let relative = relative.get(at.min(relative.len().saturating_sub(1))).copied().unwrap_or(0.0);
    TorqueError { of, joints: named.map(joint).collect(), relative, within_seen: None }
}

fn random_states(model: &Model, range: &MotionRange, count: usize, moves: bool) -> States {
    let n = model.n();
    let mut random = Random::new(1995);
    let mut states = States { n, ..States::default() };
    let mut middle = vec![0.0; n];
    // All positions of one motion are within a window of MOTION_RANGE_SHARE of each joint's range. `middle`: centre of the
    // window.
    for r in 0..count {
        states.t.push(r as f64);
        for k in 0..n {
            let (low, high) = range.position[k];
            let half = 0.5 * MOTION_RANGE_SHARE * (high - low);
            if r % STATES_PER_MOTION == 0 {
                middle[k] = random.between(low + half, high - half);
            }
            states.q.push(middle[k] + random.between(-half, half));
            let (speed, acceleration) = (random.between(-1.0, 1.0), random.between(-1.0, 1.0));
            let moving = f64::from(u8::from(moves));
            states.dq.push(moving * range.speed[k] * speed);
            states.ddq.push(moving * range.acceleration[k] * acceleration);
            states.direction.push(if range.speed[k] > 0.0 { moving * speed.signum() } else { 0.0 });
            states.tau.push(0.0);
            states.used.push(true);
        }
        let dq = &states.dq[r * n..];
        states
            .motor_direction
            .extend(model.couplings.iter().map(|c| if c.speed(|k| dq[k]) < 0.0 { -1.0 } else { 1.0 }));
    }
    states
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::{Made, Pendulum, pendulum};
    use linear_model::friction::terms::FrictionTerm;
    use linear_model::regressor::Regressor;

    fn range(speed: f64) -> MotionRange {
        MotionRange { position: vec![(-3.0, 3.0)], speed: vec![speed], acceleration: vec![5.0 * speed] }
    }

    /// The covariance of uncorrelated parameters with these standard deviations.
    fn variances(sigma: &[f64]) -> Vec<Vec<f64>> {
        let square = |i: usize, j: usize| if i == j { sigma[i] * sigma[i] } else { 0.0 };
        (0..sigma.len()).map(|i| (0..sigma.len()).map(|j| square(i, j)).collect()).collect()
    }

    #[test]
    fn the_error_is_that_of_drawn_parameters() {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &FrictionTerm::STANDARD, &[]);
        let x = [&arm.truth[..], &[0.4, 0.3, 0.0]].concat();
        let sigma = [0.02, 0.05, 0.04, 0.01, 0.02, 0.03];
        let covariance = variances(&sigma);
        let unsure = ErrorContributions { covariance: &covariance, changes: &[], logs: &[], open: &[] };
        let found = torque_errors(&model, &x, unsure, &range(1.0), &range(3.0));
        let mut random = Random::new(8);
        for (one, (range, moves)) in found[1..].iter().zip([(range(1.0), true), (range(3.0), true)]) {
            let states = random_states(&model, &range, MOST_STATES, moves);
            let (mut sum, mut count) = (0.0, 0.0);
            for _ in 0..200 {
                let wrong: Vec<f64> = sigma.iter().map(|s| s * random.normal()).collect();
                model.rows(&states, 0..states.len(), |_, row| {
                    sum += row.iter().zip(&wrong).map(|(y, x)| y * x).sum::<f64>().powi(2);
                    count += 1.0;
                });
            }
            let drawn = (sum / count).sqrt();
            // Tolerance: the variance of two hundred random samples of a few parameters has a relative standard deviation of a
            // tenth.
            assert!((one.joints[0].error / drawn - 1.0).abs() < 0.15, "{one:?} {drawn}");
            // The 90 % quantile over motions exceeds the mean, since some motions need less torque.
            let mean = one.joints[0].error / one.joints[0].torque;
            assert!((mean..3.0 * mean).contains(&one.relative), "{one:?}");
        }
        // The torque of gravity depends neither on inertia nor on friction, so errors of these parameters cause no error of the
        // gravity torque.
        let only = variances(&[1.0, 0.0, 0.0, 1.0, 1.0, 0.0]);
        let only = ErrorContributions { covariance: &only, changes: &[], logs: &[], open: &[] };
        assert_eq!(torque_errors(&model, &x, only, &range(1.0), &range(3.0))[0].relative, 0.0);
        // Inertia contributes more to the torque at larger accelerations.
        let found = torque_errors(&model, &x, only, &range(1.0), &range(3.0));
        assert!(found[2].joints[0].error > 2.0 * found[1].joints[0].error, "{found:?}");
    }

    /// tau = g (MX cos q - MY sin q) with unknown MY: the torque is accurate near q = 0, the positions of the log, but not
    /// elsewhere. No second error is reported if the torque is equally inaccurate at the positions of the log, or accurate
    /// everywhere.
    #[test]
    fn the_error_within_the_positions_of_the_logs_is_beside_a_large_one() {
        let (arm, model) = pendulum();
        let seen = MotionRange { position: vec![(-0.05, 0.05)], ..range(1.0) };
        let of = |sigma: [f64; 3]| {
            let covariance = variances(&sigma);
            let unsure = ErrorContributions { covariance: &covariance, changes: &[], logs: &[], open: &[] };
            torque_errors(&model, &arm.truth, unsure, &seen, &range(3.0)).swap_remove(0)
        };
        let of_weak = of([0.0, 0.0, 3.0 * arm.truth[1]]);
        let near = of_weak.within_seen.unwrap();
        // |sin q| is about 0.03 at positions of the log, and several tenths elsewhere.
        assert!(of_weak.relative > 1.0 && near < 0.2, "{of_weak:?}");
        assert_eq!(of([0.0, 0.3 * arm.truth[1], 0.0]).within_seen, None);
        assert_eq!(of([0.0, 1e-3, 0.0]).within_seen, None);
    }

    #[test]
    fn the_largest_change_counts() {
        let (arm, model) = pendulum();
        let (x, p) = (&arm.truth, model.p());
        let times = |share: f64| x.iter().map(|x| share * x).collect::<Vec<f64>>();
        let (covariance, changes) = (vec![vec![0.0; p]; p], [times(0.05), times(-0.1)]);
        let unsure = ErrorContributions { covariance: &covariance, changes: &changes, logs: &[], open: &[] };
        for one in &torque_errors(&model, x, unsure, &range(1.0), &range(3.0))[1..] {
            assert!((one.relative - 0.1).abs() < 1e-12, "{one:?}");
        }
    }

    #[test]
    fn a_torque_that_shows_what_is_open_is_not_told() {
        let (arm, model) = pendulum();
        let (p, open) = (model.p(), [vec![1.0, 0.0, 0.0]]);
        let unsure = ErrorContributions { covariance: &vec![vec![0.0; p]; p], changes: &[], logs: &[], open: &open };
        let found = torque_errors(&model, &arm.truth, unsure, &range(1.0), &range(3.0));
        assert_eq!((found[0].relative, found[0].undetermined_joints().len()), (0.0, 0));
        assert!(
            found[1..]
                .iter()
                .all(|e| e.relative.is_infinite() && e.undetermined_joints() == [arm.coordinates()[0].as_str()])
        );
    }

    #[test]
    fn the_larger_of_noise_and_logs_counts() {
        let (arm, model) = pendulum();
        let (x, p) = (&arm.truth, model.p());
        let times = |share: f64| x.iter().map(|x| share * x).collect::<Vec<f64>>();
        let by = |share: f64, logs: &[Vec<f64>]| {
            let row = |i: usize| (0..p).map(|j| share * share * x[i] * x[j]).collect::<Vec<f64>>();
            let covariance: Vec<Vec<f64>> = (0..p).map(row).collect();
            let unsure = ErrorContributions { covariance: &covariance, changes: &[], logs, open: &[] };
            torque_errors(&model, x, unsure, &range(1.0), &range(3.0))[1].relative
        };
        let logs = [times(0.03), times(-0.04)];
        assert!((by(0.02, &logs) - 0.05).abs() < 1e-12 && (by(0.06, &logs) - 0.06).abs() < 1e-12);
    }

    /// A lift has three columns: mass, rotor and offset. The rank of these columns is 2 in any motion. The rank of the columns
    /// of mass and rotor alone is 2 too.
    #[test]
    fn no_motion_shows_more_than_the_rank() {
        // A lift with the mass m and the rotor inertia J: tau = m (ddq + g) + J ddq.
        let (lift, range) = (Made::new(&[true], 2, |ddq, y| y.copy_from_slice(&[ddq[0] + 9.81, ddq[0]])), range(1.0));
        assert_eq!(shown_rank(&Model::new(&lift, &[], &[]), &[1.0, 0.1], &range), 2);
        let model = Model::new(&lift, &FrictionTerm::STANDARD, &[]);
        assert_eq!((model.p(), shown_rank(&model, &[1.0, 0.1], &range)), (5, 4));
    }

    /// Errors: 10 % of the large torque, 100 % of the small torque, 0.1 % of the force. The force is a hundred times as large
    /// (in N), but it must not lower the relative error of the torques.
    #[test]
    fn torques_and_forces_are_not_added() {
        // Three joints with the inertia (or mass) x_k: tau_k = x_k ddq_k.
        let arm = Made::new(&[false, false, true], 3, |ddq, y| {
            y.fill(0.0);
            (0..3).for_each(|k| y[4 * k] = ddq[k]);
        });
        let (model, x, covariance) = (Model::new(&arm, &[], &[]), [1.0, 0.01, 100.0], variances(&[0.1, 0.01, 0.1]));
        let range = MotionRange { position: vec![(-1.0, 1.0); 3], speed: vec![1.0; 3], acceleration: vec![2.0; 3] };
        let unsure = ErrorContributions { covariance: &covariance, changes: &[], logs: &[], open: &[] };
        let found = &torque_errors(&model, &x, unsure, &range, &range)[1];
        let exact = ((0.01f64 + 1e-4) / (1.0 + 1e-4)).sqrt();
        // Tolerance: the joints have independent random accelerations, so with 200 states the ratio has a standard deviation of a
        // twentieth.
        assert!((found.relative / exact - 1.0).abs() < 0.05, "{found:?} {exact}");
    }
}
