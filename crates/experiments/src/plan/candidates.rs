//! The experiments from which a plan is chosen: every kind of motion about a grid of configurations.
//!
//! A swing moves a fast joint periodically between two positions. Its stroke L, period T and frequency f_P = 1/T follow from the
//! limits of the fast joint: a_max, v_max, the range about the centre, the bandwidth f_bw of its controller and its smallest
//! smooth velocity v_small. The equations are for the bang-bang profile (acceleration +a_max or -a_max); a smooth profile has
//! other peak factors:
//!
//! inertial, coupling   f_P = min(f_bw/4, a_max/(4 v_small)),  L = a_max T^2/16: greatest
//! acceleration at low velocity; L at least 200 encoder counts
//!
//! centrifugal          L = v_max^2/a_max, T = 4 sqrt(L/a_max): greatest velocity
//!
//! mixed                T is the geometric mean of the two periods above
//!
//! L is limited to the range. T is then rounded up to a multiple of four samples. L does not change, so the acceleration
//! decreases. Slow joints move by v_small T/4.
//!
//! If a [`Permission`] refuses a motion because of its torques or a collision of bodies, lower accelerations are tried.
//!
//! [Vandanjon, Gautier, Desbats 1995, section 3.2 and table 1], with exact equations.

use linear_model::regressor::Regressor;
use logs::Error;
use numerics::information_matrix::WeightedRows;
use numerics::interruption::Interruption;
use processor::{in_order, threads};
use random::Random;

use crate::motion::profile::Profile;
use crate::plan::exciting_trajectory::{
    ExcitingTrajectory, JointMotion, MovingJoints, SWEEP_ACCELERATION, SwingCourse,
};
use crate::plan::measured_motion::MeasuredMotion;
use crate::plan::motion_count::kinds_of;
use crate::plan::motion_kind::MotionKind;
use crate::plan::paper_rows::{gravity_rows, spectral_rows};
use crate::plan::permission::{AllowAll, Permission};

/// The limits of one coordinate from which the motions of a plan follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionLimits {
    /// Smallest and largest position, rad (m).
    pub position: (f64, f64),
    /// Largest speed, rad/s (m/s).
    pub velocity: f64,
    /// Largest acceleration, rad/s^2 (m/s^2).
    pub acceleration: f64,
    /// Smallest velocity at which the joint moves without stick-slip, rad/s (m/s).
    pub slow_velocity: f64,
    /// Bandwidth of the position controller, Hz.
    pub bandwidth: f64,
    /// Resolution of the position encoder: one count, rad (m).
    pub quantum: f64,
}

/// Settings for the grid of candidate experiments.
#[derive(Clone, Debug, PartialEq)]
pub struct CandidateGrid {
    /// Profile (position over time) of a swing, the periodic motion of a joint between two positions.
    pub profile: Profile,
    /// Number of grid positions of each coordinate, within its position limits narrowed by a tenth of the range on each side.
    pub steps: usize,
    /// Greatest number of configurations for each kind of motion. If the grid has more, this number is drawn from it at random.
    pub configurations: usize,
    /// Recorded time of one experiment, s.
    pub duration: f64,
    /// Time between samples, s.
    pub sample_time: f64,
    /// Whether gravity loads the joints. Only then are slow sweeps (at constant velocity) informative.
    pub gravity: bool,
    /// Seed of the random choice of configurations.
    pub seed: u64,
}

/// A possible experiment of a plan, with its predicted regressor rows.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The motion of the experiment.
    pub trajectory: ExcitingTrajectory,
    /// The unweighted rows of [Vandanjon, Gautier, Desbats 1995], N m per unit of the parameter. Their Frobenius condition number
    /// is criterion (15) of this paper.
    pub raw: WeightedRows,
    /// The rows divided by the standard deviations of their right-hand sides, for the determinant criterion.
    pub information: WeightedRows,
}

/// Longest duration of a sweep (slow motion at constant velocity) in one direction, s; or [`SWEEP_PER_RECORD`] times the recorded
/// time if that is longer.
///
/// An axis that is too slow for its whole range sweeps only a section of it.
const LONGEST_SWEEP_S: f64 = 10.0;
/// Longest duration of a sweep (slow motion at constant velocity) in one direction, as a multiple of the recorded time of an
/// experiment.
const SWEEP_PER_RECORD: f64 = 2.5;
/// Greatest length of a sweep (slow motion at constant velocity), divided by the distance from its centre to the nearer position
/// limit. At 2, the sweep would reach the limit.
const SWEEP_RANGE_SHARE: f64 = 1.8;
/// Time at constant velocity of the shortest sweep in one direction, s. In the first part of this time the controller settles, so
/// these samples are not used.
const SHORTEST_CRUISE_S: f64 = 0.4;
/// Least stroke of a swing (periodic motion between two positions), in counts of the encoder.
const SMALLEST_STROKE_COUNTS: f64 = 200.0;
/// Number of instants per period at which the regressor rows of a swing (periodic motion) are predicted.
const INSTANTS_PER_PERIOD: usize = 200;
/// Least ratio of the controller's bandwidth to the frequency of a swing (periodic motion).
const BANDWIDTH_RATIO: f64 = 4.0;
/// Share of a coordinate's position range, at each end, in which no motion has its centre.
const RANGE_MARGIN: f64 = 0.1;
/// Change of a coordinate in the test of whether the regressor depends on it, rad (m).
const DEPENDENCE_STEP: f64 = 0.7;
/// Number of random states in the test of whether the regressor depends on a coordinate.
const DEPENDENCE_STATES: usize = 4;
/// Relative change of a regressor entry above which the regressor depends on a coordinate.
const DEPENDENCE_TOLERANCE: f64 = 1e-9;
/// Tolerance for rounding when a period is divided by four sample times.
const PERIOD_ROUNDING: f64 = 1e-9;

impl Candidate {
    /// Predicts the regressor rows of a motion that follows its reference exactly. `noise`: standard deviation of a torque
    /// sample, N m, one per coordinate.
    pub fn new(trajectory: ExcitingTrajectory, regressor: &dyn Regressor, noise: &[f64]) -> Candidate {
        let n = trajectory.centre.len();
        match &trajectory.motion {
            JointMotion::Swing { profile, period, half_range, periods, .. } => {
                // These instants suffice, because the rows use only the first two harmonics of the motion.
                let (count, t) = (INSTANTS_PER_PERIOD, *period as f64 * trajectory.sample_time);
                let series = |value: &dyn Fn(usize, (f64, f64, f64)) -> f64| -> Vec<Vec<f64>> {
                    let at = |i: usize| profile.at(i as f64 / count as f64);
                    (0..n).map(|k| (0..count).map(|i| value(k, at(i))).collect()).collect()
                };
                let motion = MeasuredMotion {
                    q: series(&|k, p| trajectory.centre[k] + half_range[k] * p.0),
                    dq: series(&|k, p| half_range[k] * p.1 / t),
                    ddq: series(&|k, p| half_range[k] * p.2 / (t * t)),
                };
                let mut one_period = trajectory.clone();
                if let JointMotion::Swing { period, .. } = &mut one_period.motion {
                    *period = count;
                }
                // The noise is scaled, because the instants of one period represent all recorded samples.
                let share = (count as f64 / (periods * period) as f64).sqrt();
                let noise: Vec<f64> = noise.iter().map(|s| s * share).collect();
                let zero = vec![vec![0.0; count]; n];
                let block = spectral_rows(&one_period, regressor, &motion, &zero, &noise);
                Candidate { trajectory, information: block.weighted(), raw: block.rows }
            }
            JointMotion::Sweep { .. } => {
                let reference = trajectory.reference();
                let motion = MeasuredMotion::of_reference(&reference);
                let directions: Vec<usize> = reference.windows.iter().map(|w| w.len()).collect();
                let zero = vec![vec![0.0; motion.len()]; n];
                let block = gravity_rows(&trajectory, regressor, &motion.q, &zero, noise, &directions);
                let mean = 1.0 / (motion.len().max(1) as f64).sqrt();
                let raw = block.rows.scaled(&vec![mean; block.rows.width()]);
                Candidate { trajectory, information: block.weighted(), raw }
            }
        }
    }
}

/// Greatest number of lower accelerations that are tried if a permission refuses a motion.
const MAX_SLOWER_TRIALS: i32 = 6;
/// Ratio of the acceleration in a trial to the acceleration in the previous trial.
const ACCELERATION_RATIO: f64 = 0.7;
/// Greatest number of configurations that are drawn, per configuration that is wanted.
const DRAWS_PER_CONFIGURATION: usize = 10;

/// Every informative motion within the limits, for the configurations and kinds of motion of `grid`. `noise`: standard deviation
/// of a torque sample, N m, one per coordinate. Empty if the computation is interrupted.
pub fn candidates(
    grid: &CandidateGrid,
    limits: &[MotionLimits],
    regressor: &dyn Regressor,
    noise: &[f64],
) -> Vec<Candidate> {
    permitted_candidates(grid, limits, regressor, noise, &AllowAll)
}

/// The motions of [`candidates`] that `permission` accepts. If it refuses a motion, the motion is tried with lower accelerations.
pub fn permitted_candidates(
    grid: &CandidateGrid,
    limits: &[MotionLimits],
    regressor: &dyn Regressor,
    noise: &[f64],
    permission: &dyn Permission,
) -> Vec<Candidate> {
    let n = limits.len();
    let mut trajectories = Vec::new();
    let matters = coordinates_that_matter(regressor, limits);
    for fast in 0..n {
        let motions = kinds_of(fast, n, grid.gravity);
        // Each kind of motion has its own random stream, so the motions of one kind do not depend on how many random numbers
        // the other kinds use.
        for (index, (kind, slow)) in motions.into_iter().enumerate() {
            if Interruption::check().is_err() {
                return vec![];
            }
            let mut random = Random::stream(grid.seed, (fast * 1000 + index) as u64);
            for centre in configurations(grid, limits, &matters, &mut random, permission) {
                trajectories.extend(about(grid, limits, &MovingJoints { kind, fast, slow: &slow, centre: &centre }));
            }
        }
    }
    // Predict the rows of all motions on all processors; leave motions without information out.
    let mut found = Vec::new();
    let rows = |_, trajectory: &ExcitingTrajectory| {
        let permitted = permitted(grid, limits, trajectory, permission)?;
        Some(Candidate::new(permitted, regressor, noise)).filter(|candidate| candidate.information.trace() > 0.0)
    };
    let done = in_order(&trajectories, threads(), rows, |_, candidate| {
        Interruption::check().map_err(|e| Error::new(e.message()))?;
        found.extend(candidate);
        Ok(())
    });
    done.map_or_else(|_: Error| Vec::new(), |()| found)
}

/// Makes the motion of some joints about a configuration: a slow sweep for the gravity torques, otherwise a periodic swing.
/// `None` if it would be too short.
fn about(grid: &CandidateGrid, limits: &[MotionLimits], joints: &MovingJoints) -> Option<ExcitingTrajectory> {
    match joints.kind {
        MotionKind::Gravity => sweep(grid, limits, joints),
        _ => swing(grid, limits, joints),
    }
}

/// The motion itself if it is permitted, else the fastest permitted motion with lower accelerations. `None` if none is permitted.
fn permitted(
    grid: &CandidateGrid,
    limits: &[MotionLimits],
    motion: &ExcitingTrajectory,
    permission: &dyn Permission,
) -> Option<ExcitingTrajectory> {
    if permission.motion(motion) {
        return Some(motion.clone());
    }
    let ExcitingTrajectory { kind, fast, slow, centre, .. } = motion;
    let joints = MovingJoints { kind: *kind, fast: *fast, slow, centre };
    let slower = (1..=MAX_SLOWER_TRIALS).filter_map(|k| {
        let lower = |l: &MotionLimits| MotionLimits { acceleration: ACCELERATION_RATIO.powi(k) * l.acceleration, ..*l };
        let limits: Vec<MotionLimits> = limits.iter().map(lower).collect();
        about(grid, &limits, &joints)
    });
    slower.into_iter().find(|slower| permission.motion(slower))
}

/// Makes the largest swing (periodic motion) of some joints that the limits allow. `None` if the stroke or the ranges of the slow
/// joints are too small.
pub fn swing(grid: &CandidateGrid, limits: &[MotionLimits], joints: &MovingJoints) -> Option<ExcitingTrajectory> {
    let &MovingJoints { kind, fast, slow, centre } = joints;
    let limit = &limits[fast];
    let (v_factor, a_factor) = grid.profile.peaks();
    // Period T of a swing at the greatest acceleration with low velocity, and T at the greatest velocity: equations in the head
    // of this file.
    let low_velocity =
        (BANDWIDTH_RATIO / limit.bandwidth).max(a_factor / v_factor * limit.slow_velocity / limit.acceleration);
    let high_velocity =
        (a_factor / v_factor * limit.velocity / limit.acceleration).max(BANDWIDTH_RATIO / limit.bandwidth);
    let t = match kind {
        MotionKind::Inertial | MotionKind::Coupling => low_velocity,
        MotionKind::Centrifugal => high_velocity,
        MotionKind::Mixed => (low_velocity * high_velocity).sqrt(),
        MotionKind::Gravity => return None,
    };
    // Stroke L of the swing within the limits of acceleration, velocity and range; period T in multiples of four samples.
    let room = |k: usize| 2.0 * (centre[k] - limits[k].position.0).min(limits[k].position.1 - centre[k]);
    let stroke = (limit.acceleration * t * t / a_factor).min(limit.velocity * t / v_factor).min(room(fast));
    let period = 4 * ((t / (4.0 * grid.sample_time) - PERIOD_ROUNDING).ceil() as usize).max(2);
    let t = period as f64 * grid.sample_time;
    let slow_velocity: Vec<f64> = limits.iter().map(|l| l.slow_velocity).collect();
    // Slow joints need the range v_small T / v_factor (v_small: their slow velocity). The stroke of the fast joint must have
    // enough encoder counts.
    let fits = slow.iter().all(|&l| slow_velocity[l] * t / v_factor <= room(l));
    if !fits || stroke < SMALLEST_STROKE_COUNTS * limit.quantum {
        return None;
    }
    let course = SwingCourse {
        profile: grid.profile,
        period,
        acceleration: stroke * a_factor / (t * t),
        slow_velocity: &slow_velocity,
        duration: grid.duration,
        sample_time: grid.sample_time,
    };
    Some(ExcitingTrajectory::swing(joints, &course))
}

/// Makes the longest sweep (slow motion at constant velocity) of the fast joint that the limits allow, at 1 rad/s or the joint's
/// slow velocity, whichever is greater. `None` if it is too short.
fn sweep(grid: &CandidateGrid, limits: &[MotionLimits], joints: &MovingJoints) -> Option<ExcitingTrajectory> {
    let &MovingJoints { fast, centre, .. } = joints;
    let limit = &limits[fast];
    let velocity = limit.slow_velocity.max(1.0_f64.min(limit.velocity));
    let ramps = SWEEP_ACCELERATION.min(limit.acceleration);
    let longest = LONGEST_SWEEP_S.max(SWEEP_PER_RECORD * grid.duration) * velocity;
    let room = longest.min(SWEEP_RANGE_SHARE * (centre[fast] - limit.position.0).min(limit.position.1 - centre[fast]));
    // Least length: both ramps plus a section of constant velocity, whose first samples (settling) are not used.
    let least = velocity * velocity / ramps + SHORTEST_CRUISE_S * velocity;
    let mut found = ExcitingTrajectory::sweep(fast, centre, room, velocity, grid.sample_time);
    if let JointMotion::Sweep { acceleration, .. } = &mut found.motion {
        *acceleration = ramps;
    }
    (room > least).then_some(found)
}

/// For each coordinate: whether the regressor Y depends on it. Y does not depend on the coordinate of a first axis that is
/// parallel to gravity.
fn coordinates_that_matter(regressor: &dyn Regressor, limits: &[MotionLimits]) -> Vec<bool> {
    let (n, p) = (limits.len(), regressor.parameters().len());
    let mut random = Random::new(1);
    let mut y = vec![0.0; n * p];
    let mut z = vec![0.0; n * p];
    (0..n)
        .map(|k| {
            (0..DEPENDENCE_STATES).any(|_| {
                let mut q: Vec<f64> = limits.iter().map(|l| random.between(l.position.0, l.position.1)).collect();
                let dq: Vec<f64> = (0..n).map(|_| random.normal()).collect();
                let ddq: Vec<f64> = (0..n).map(|_| random.normal()).collect();
                regressor.fill(&q, &dq, &ddq, &mut y);
                q[k] += DEPENDENCE_STEP;
                regressor.fill(&q, &dq, &ddq, &mut z);
                y.iter().zip(&z).any(|(a, b)| (a - b).abs() > DEPENDENCE_TOLERANCE * (1.0 + a.abs()))
            })
        })
        .collect()
}

fn configurations(
    grid: &CandidateGrid,
    limits: &[MotionLimits],
    matters: &[bool],
    random: &mut Random,
    permission: &dyn Permission,
) -> Vec<Vec<f64>> {
    let n = limits.len();
    // A coordinate on which the regressor does not depend stays in the middle. The grid of the other coordinates covers 80 % of
    // their range.
    let steps: Vec<usize> = (0..n).map(|k| if matters[k] { grid.steps.max(1) } else { 1 }).collect();
    let total = steps.iter().try_fold(1usize, |a, &b| a.checked_mul(b)).unwrap_or(usize::MAX);
    let at = |k: usize, i: usize| {
        let (low, high) = limits[k].position;
        let (low, high) = (low + RANGE_MARGIN * (high - low), high - RANGE_MARGIN * (high - low));
        if steps[k] == 1 { 0.5 * (low + high) } else { low + (high - low) * i as f64 / (steps[k] - 1) as f64 }
    };
    // Points of the grid of configurations: all points if there are few enough, else random ones.
    let point = |mut index: usize| -> Vec<f64> {
        let one = |k: usize| {
            let i = index % steps[k];
            index /= steps[k];
            at(k, i)
        };
        (0..n).map(one).collect()
    };
    if total <= grid.configurations {
        return (0..total).map(point).filter(|q| permission.pose(q)).collect();
    }
    let drawn = (0..DRAWS_PER_CONFIGURATION * grid.configurations)
        .map(|_| (0..n).map(|k| at(k, random.index(steps[k]))).collect::<Vec<f64>>());
    drawn.filter(|q| permission.pose(q)).take(grid.configurations).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::test_plans::{grid, limits};

    #[test]
    fn the_words_of_table_1() {
        let about = |kind, slow: &[usize]| {
            swing(&grid(), &limits(), &MovingJoints { kind, fast: 0, slow, centre: &[0.0; 3] }).unwrap()
        };
        let period = |t: &ExcitingTrajectory| match t.motion {
            JointMotion::Swing { period, .. } => period,
            JointMotion::Sweep { .. } => 0,
        };
        // Expected periods: 4/f_bw = 0.4 s; 4 v_max/a_max = 0.667 s, rounded up to a multiple of four samples.
        assert_eq!(period(&about(MotionKind::Inertial, &[])), 400);
        assert_eq!(period(&about(MotionKind::Centrifugal, &[1])), 668);
        let r = about(MotionKind::Centrifugal, &[1]).reference();
        let peak = |x: &[f64]| x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        assert!((peak(&r.dq[0]) - 5.0).abs() < 0.02 && (peak(&r.dq[1]) - 0.5).abs() < 1e-9);
        let at_the_limit = MovingJoints { kind: MotionKind::Inertial, fast: 0, slow: &[], centre: &[2.599, 0.0, 0.0] };
        let too_narrow = swing(&grid(), &limits(), &at_the_limit);
        assert!(too_narrow.is_none());
    }
}
