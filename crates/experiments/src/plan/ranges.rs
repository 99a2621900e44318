//! Accepted ranges for the numbers that define a motion: realistic for a robot, and within the memory of a computer.
//!
//! Users also write files of plans and robots by hand. A number outside these ranges usually has a wrong unit or a wrong digit.

use std::ops::RangeInclusive;

use crate::motion::sample_count::check_samples;
use crate::plan::candidates::MotionLimits;
use crate::plan::exciting_trajectory::{ExcitingTrajectory, JointMotion};

/// Accepted sample times of a plan, s.
const SAMPLE_TIME_RANGE_S: RangeInclusive<f64> = 1e-5..=10.0;
/// Accepted positions in a plan or in limits, rad (m).
const POSITION_RANGE: RangeInclusive<f64> = -1e4..=1e4;
/// Accepted half ranges of swings and ranges of sweeps, rad (m). A half range may also be 0 (locked joint).
const SWING_RANGE: RangeInclusive<f64> = 1e-6..=1e4;
/// Accepted velocities of sweeps and limits, rad/s (m/s).
const VELOCITY_RANGE: RangeInclusive<f64> = 1e-5..=1e4;
/// Accepted accelerations of sweeps and limits, rad/s^2 (m/s^2).
const ACCELERATION_RANGE: RangeInclusive<f64> = 1e-4..=1e6;
/// Accepted settling times of sweeps, s.
const SETTLING_RANGE_S: RangeInclusive<f64> = 0.0..=60.0;

fn within(what: &str, unit: &str, x: f64, range: &RangeInclusive<f64>) -> Result<(), String> {
    if range.contains(&x) {
        return Ok(());
    }
    Err(format!("{what} is {x:?} {unit}; expected is a number from {:?} to {:?}", range.start(), range.end()))
}

/// Fails if a number of a motion is out of range, or if the motion has more samples than [`check_samples`] accepts. The message
/// names the number.
pub fn check_motion(trajectory: &ExcitingTrajectory) -> Result<(), String> {
    within("the sample time", "s", trajectory.sample_time, &SAMPLE_TIME_RANGE_S)?;
    for &centre in &trajectory.centre {
        within("an angle of the centre", "rad", centre, &POSITION_RANGE)?;
    }
    let samples = match &trajectory.motion {
        JointMotion::Swing { period, half_range, transient_periods, periods, .. } => {
            for &half in half_range {
                within("a half range", "rad", half, &(0.0..=*SWING_RANGE.end()))?;
            }
            *period as f64 * (*transient_periods as f64 + *periods as f64)
        }
        JointMotion::Sweep { range, velocity, acceleration, settling } => {
            within("the range of the sweep", "rad", *range, &SWING_RANGE)?;
            within("the velocity of the sweep", "rad/s", *velocity, &VELOCITY_RANGE)?;
            within("the acceleration of the sweep", "rad/s^2", *acceleration, &ACCELERATION_RANGE)?;
            within("the settling of the sweep", "s", *settling, &SETTLING_RANGE_S)?;
            2.0 * (velocity / acceleration + range / velocity) / trajectory.sample_time
        }
    };
    check_samples(samples)
}

/// Fails if a position, velocity or acceleration limit is out of range. The message names the coordinate.
pub fn check_limits(coordinates: &[String], limits: &[MotionLimits]) -> Result<(), String> {
    for (name, limit) in coordinates.iter().zip(limits) {
        let of = |what: &str| format!("{name}: the {what} of its limits");
        within(&of("least position"), "rad", limit.position.0, &POSITION_RANGE)?;
        within(&of("greatest position"), "rad", limit.position.1, &POSITION_RANGE)?;
        within(&of("velocity"), "rad/s", limit.velocity, &VELOCITY_RANGE)?;
        within(&of("acceleration"), "rad/s^2", limit.acceleration, &ACCELERATION_RANGE)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::test_plans::limits;

    #[test]
    fn numbers_out_of_range_are_named() {
        let sweep = |range: f64, velocity: f64, h: f64| ExcitingTrajectory::sweep(0, &[0.0], range, velocity, h);
        check_motion(&sweep(2.0, 1.0, 1e-3)).unwrap();
        for (motion, said) in [
            (sweep(2.0, 1e-9, 1e-3), "velocity of the sweep is 1e-9"),
            (sweep(1e300, 1.0, 1e-3), "range of the sweep is 1e300"),
            (sweep(2.0, f64::NAN, 1e-3), "velocity of the sweep is NaN"),
            (sweep(2.0, 1.0, 1e-300), "sample time is 1e-300"),
            (sweep(2000.0, 0.1, 1e-3), "4.0e7 samples"),
        ] {
            let refused = check_motion(&motion).unwrap_err();
            assert!(refused.contains(said), "{refused}");
        }
        let mut swing = sweep(2.0, 1.0, 1e-3);
        let (profile, half_range) = (crate::motion::profile::Profile::BangBang, vec![0.1]);
        swing.motion =
            JointMotion::Swing { profile, period: 400, half_range, transient_periods: usize::MAX, periods: 4 };
        assert!(check_motion(&swing).unwrap_err().contains("samples"));
    }

    #[test]
    fn limits_out_of_range_are_named() {
        let names = ["q1".to_string(), "q2".to_string()];
        let mut limits = limits()[..2].to_vec();
        check_limits(&names, &limits).unwrap();
        limits[1].acceleration = 1e-300;
        let refused = check_limits(&names, &limits).unwrap_err();
        assert!(refused.contains("q2: the acceleration of its limits is 1e-300"), "{refused}");
    }
}
