//! Evaluates torques and powers at sampled instants, before a proof.
//!
//! A motion that exceeds a limit at an instant is scaled down without a proof, because a proof of thirty joints takes twenty
//! seconds and an evaluation at the instants one second.

use crate::excitation::enclosed_drives::{drives_at, limited_drives};
use crate::excitation::limits::{CoordinateLimits, LimitKind};
use crate::excitation::nominal_torque::NominalTorque;
use crate::excitation::trajectory::Trajectory;

/// Number of sampled instants in each of the equal time intervals with which a proof starts (before it divides them further).
const SAMPLES_PER_INTERVAL: usize = 4;

/// The greatest ratio of a torque or power to its usable limit at sampled instants, with and without payload. It is a lower bound
/// of the ratio that a proof finds.
pub fn sampled_excess(course: &dyn Trajectory, limits: &[CoordinateLimits], described: &NominalTorque) -> f64 {
    let loaded = described.with_payload().map_or(0.0, |loaded| excess_of(course, limits, &loaded));
    loaded.max(excess_of(course, limits, described))
}

fn excess_of(course: &dyn Trajectory, limits: &[CoordinateLimits], described: &NominalTorque) -> f64 {
    let (enclosed, limited) = (course.enclosed(), limited_drives(limits, described));
    let mut greatest = 0.0_f64;
    if limited.is_empty() {
        return greatest;
    }
    for (i, stretch) in course.stretches().into_iter().enumerate() {
        let count = SAMPLES_PER_INTERVAL * stretch.parts.max(1);
        for sample in 0..=count {
            let time = stretch.length * (sample as f64 / count as f64);
            let all = drives_at(enclosed.as_ref(), i, time, described);
            for &(k, kind, bound) in &limited {
                let value = if kind == LimitKind::Power { all[k].1 } else { all[k].0 };
                greatest = greatest.max(value.magnitude() / bound.max(f64::MIN_POSITIVE));
            }
        }
    }
    greatest
}
