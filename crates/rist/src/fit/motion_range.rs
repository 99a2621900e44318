//! Computes the range of positions, speeds and accelerations that logs cover, and the range that the description allows.
//!
//! These ranges are the motions for which the uncertainty of predicted torques is computed.

use experiments::motion::reference_motion::Reference;
use experiments::plan::exciting_trajectory::ExcitingTrajectory;
use identification::estimate::torque_error::MotionRange;
use identification::rows::observation::Observation;

use crate::describe::model::Model;

/// A position range above this value, rad (m), counts as no limit. A speed limit above this value, rad/s (m/s), counts as no
/// limit too.
const LIMITLESS_POSITION: f64 = 1e3;

/// The range of motion of the logs. The acceleration of a joint is estimated as 2 pi f95 times its largest speed, rad/s^2
/// (m/s^2); f95: the frequency below which 95 % of the energy of the joint's velocity lies, Hz.
pub(crate) fn seen(observation: &Observation) -> MotionRange {
    let fastest = observation.f95.iter().copied().fold(0.0, f64::max);
    let acceleration = |(speed, f95): (&f64, &f64)| {
        let frequency = if *f95 > 0.0 { *f95 } else { fastest };
        std::f64::consts::TAU * frequency * speed
    };
    MotionRange {
        position: observation.range.clone(),
        speed: observation.speed.clone(),
        acceleration: observation.speed.iter().zip(&observation.f95).map(acceleration).collect(),
    }
}

/// The range of motion of the experiments of a plan.
pub(crate) fn seen_in_plan<'a>(trajectories: impl Iterator<Item = &'a ExcitingTrajectory>) -> MotionRange {
    let references: Vec<Reference> = trajectories.map(ExcitingTrajectory::reference).collect();
    let n = references.first().map_or(0, |reference| reference.q.len());
    let over = |series: fn(&Reference) -> &[Vec<f64>], k: usize| -> (f64, f64) {
        let all = references.iter().flat_map(|reference| series(reference)[k].iter().copied());
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    };
    let fastest = |series: fn(&Reference) -> &[Vec<f64>]| {
        (0..n).map(|k| over(series, k)).map(|(low, high)| high.max(-low)).collect()
    };
    let position = (0..n).map(|k| over(|reference| &reference.q, k)).collect();
    MotionRange {
        position,
        speed: fastest(|reference| &reference.dq),
        acceleration: fastest(|reference| &reference.ddq),
    }
}

/// The range of motion that the description allows. Without position limits, the range is one turn for a revolute joint, and
/// the range in `seen` for a prismatic joint. Without a speed limit, the speed in `seen` is used. The acceleration is scaled
/// like the speed, which keeps the frequencies of `seen`.
pub(crate) fn allowed(model: &Model, seen: &MotionRange) -> MotionRange {
    let mut range = seen.clone();
    for k in 0..seen.speed.len() {
        let limits = model.robot.coordinates.get(k).map(|c| &c.limits);
        let position =
            limits.and_then(|l| l.position).filter(|(low, high)| low < high && high - low < LIMITLESS_POSITION);
        range.position[k] = match position {
            Some(limits) => limits,
            None if model.regressor().is_prismatic(k) => seen.position[k],
            None => (-std::f64::consts::PI, std::f64::consts::PI),
        };
        let speed = limits.and_then(|l| l.velocity).filter(|speed| *speed > 0.0 && *speed < LIMITLESS_POSITION);
        if let Some(speed) = speed.filter(|_| seen.speed[k] > 0.0) {
            range.acceleration[k] *= speed / seen.speed[k];
            range.speed[k] = speed;
        }
    }
    range
}
