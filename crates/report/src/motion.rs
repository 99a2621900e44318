//! Compares the motion in the logs with the joint limits, for the page.
//!
//! For each joint, the page shows which part of the ranges of position, speed and torque the motion uses, as bars.

use identification::plot_data::PlotData;
use robot::Robot;
use serde::Serialize;

use crate::number::significant;

/// The motion of one joint compared with its limits.
#[derive(Serialize)]
pub(crate) struct Used {
    name: String,
    position: Bar,
    speed: Bar,
    effort: Bar,
}

/// A bar in a table: its start and its length, 0 to 100, and its text.
#[derive(Serialize)]
struct Bar {
    from: f64,
    length: f64,
    text: String,
    is_limited: bool,
}

/// For each joint, its motion in the logs compared with the limits of the description.
pub(crate) fn used(plot_data: &PlotData, robot: Option<&Robot>) -> Vec<Used> {
    let one = |(k, joint): (usize, &identification::plot_data::JointPlotData)| {
        let limits = robot.and_then(|robot| robot.coordinates.get(k)).map(|c| c.limits).unwrap_or_default();
        let unit = if joint.is_prismatic { "m" } else { "rad" };
        let (low, high) = joint.position;
        let text = format!("{} to {} {unit}", significant(low, 3), significant(high, 3));
        let position = match limits.position {
            Some((from, to)) if to > from => {
                let at = |q: f64| (100.0 * (q - from) / (to - from)).clamp(0.0, 100.0);
                let text = format!("{text} of {} to {}", significant(from, 3), significant(to, 3));
                Bar { from: at(low), length: at(high) - at(low), text, is_limited: true }
            }
            _ => Bar { from: 0.0, length: 0.0, text, is_limited: false },
        };
        Used {
            name: joint.coordinate.clone(),
            position,
            speed: part(joint.speed, limits.velocity, &format!("{unit}/s")),
            effort: part(joint.effort, limits.effort, &joint.unit),
        }
    };
    plot_data.joints.iter().enumerate().map(one).collect()
}

fn part(value: f64, limit: Option<f64>, unit: &str) -> Bar {
    let text = format!("{} {unit}", significant(value, 3));
    match limit {
        Some(limit) if limit > 0.0 => {
            let text = format!("{} of {} {unit}", significant(value, 3), significant(limit, 3));
            Bar { from: 0.0, length: (100.0 * value / limit).min(100.0), text, is_limited: true }
        }
        _ => Bar { from: 0.0, length: 0.0, text, is_limited: false },
    }
}
