//! Torques and powers at instants, before they are proved.
//!
//! A motion that is beyond a limit at an instant needs no proof to be made smaller. A proof of thirty joints takes twenty
//! seconds, and a look at the instants one.

use crate::excitation::course::Course;
use crate::excitation::described_torque::DescribedTorque;
use crate::excitation::enclosed_drives::{drives_at, limited_drives};
use crate::excitation::limits::{CoordinateLimits, LimitKind};

/// Instants of each first part of a proof.
const SAMPLES_PER_PART: usize = 4;

/// The greatest torque or power over what may be used of its limit, at instants: what a proof finds is at least that.
pub fn sampled_excess(course: &dyn Course, limits: &[CoordinateLimits], described: &DescribedTorque) -> f64 {
    let loaded = described.with_payload().map_or(0.0, |loaded| excess_of(course, limits, &loaded));
    loaded.max(excess_of(course, limits, described))
}

fn excess_of(course: &dyn Course, limits: &[CoordinateLimits], described: &DescribedTorque) -> f64 {
    let (enclosed, limited) = (course.enclosed(), limited_drives(limits, described));
    let mut greatest = 0.0_f64;
    if limited.is_empty() {
        return greatest;
    }
    for (i, stretch) in course.stretches().into_iter().enumerate() {
        let count = SAMPLES_PER_PART * stretch.parts.max(1);
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
