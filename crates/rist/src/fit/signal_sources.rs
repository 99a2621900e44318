//! Chooses the source of velocities and accelerations: columns of a log, or derivatives of positions. This applies only if the
//! options leave the source free.
//!
//! The log check compares the columns with the derivatives of the positions.

use identification::estimate::log_check::{LogCheck, TIMELY_S};
use identification::estimate::options::Options;
use identification::signals::signal_options::Velocity;

/// Replaces velocity or acceleration columns by derivatives of the positions, if the log check finds that the columns disagree
/// with the positions. Returns a sentence on each replacement.
pub(crate) fn sources(seen: &LogCheck, options: &mut Options) -> Vec<String> {
    let mut sentences = Vec::new();
    let signal = &mut options.signal;
    if signal.velocity == Velocity::Auto
        && let Some(lag) = seen.velocity_lag()
        && lag.abs() > TIMELY_S
    {
        signal.velocity = Velocity::Differentiated;
        signal.acceleration = Velocity::Differentiated;
        sentences.push(format!(
            "the velocity columns lag the slopes of the positions by {:.1} ms: those slopes are taken \
             ([options.signal.velocity=measured] takes the columns)",
            1e3 * lag
        ));
    }
    let wrong: Vec<&str> = seen.joints.iter().filter(|j| j.wrong_acceleration).map(|j| j.coordinate.as_str()).collect();
    if signal.acceleration == Velocity::Auto && !wrong.is_empty() {
        signal.acceleration = Velocity::Differentiated;
        sentences.push(format!(
            "the acceleration columns of {} are not the slopes of their velocities: those slopes are taken \
             ([options.signal.acceleration=measured] takes the columns)",
            wrong.join(", ")
        ));
    }
    sentences
}
