//! Checks whether measured velocities are the derivatives of the measured positions.
//!
//! For each time span of the log, a = q(end) - q(start), and b is the integral of dq dt. The fit b = s a gives the slope s, which
//! is 1 if units, signs and clock are right. Spans are compared instead of samples, to reduce the effect of quantised positions.

use logs::{Error, GAP_PERIODS};

/// Number of time spans into which a log is divided. Position and velocity are compared in each span.
const SPANS_PER_LOG: usize = 200;
/// Least number of samples of a span.
const LEAST_SPAN_SAMPLES: usize = 5;
/// If the relative distance between the slope and the factor between two units is at most this value, the error message names
/// the wrong unit.
const UNIT_FACTOR_TOLERANCE: f64 = 0.05;

/// A joint is not checked if its largest change of position over a span is smaller than this value, rad (m).
const SMALLEST_CHECKED_CHANGE: f64 = 0.02;

/// Slopes of the fit in this range can be explained by noise, and are accepted.
const PLAUSIBLE_SLOPES: std::ops::Range<f64> = 0.8..1.25;

/// A joint is checked only if the fit b = s a explains at least this share of sum b^2. a: change of position over a time span, b:
/// integral of the velocity over this span.
const SMALLEST_EXPLAINED_SHARE: f64 = 0.8;

/// Fails if the measured velocity of a joint is not the derivative of its position; the message names the first such joint.
/// `period`: time between samples, s.
pub(crate) fn check_velocity(
    file: &str,
    coordinates: &[String],
    t: &[f64],
    q: &[Vec<f64>],
    dq: &[Vec<f64>],
    period: f64,
) -> Result<(), Error> {
    let length = (t.len() / SPANS_PER_LOG).max(LEAST_SPAN_SAMPLES);
    for ((name, q), dq) in coordinates.iter().zip(q).zip(dq) {
        // Sums of a^2, a b and b^2 over the spans that have no gap in time.
        let (mut aa, mut ab, mut bb, mut largest) = (0.0, 0.0, 0.0, 0.0f64);
        for start in (0..t.len().saturating_sub(length)).step_by(length) {
            let span = start..start + length;
            if span.clone().any(|i| t[i + 1] - t[i] > GAP_PERIODS * period) {
                continue;
            }
            let a = q[span.end] - q[span.start];
            let b: f64 = span.map(|i| 0.5 * (dq[i] + dq[i + 1]) * (t[i + 1] - t[i])).sum();
            (aa, ab, bb, largest) = (aa + a * a, ab + a * b, bb + b * b, largest.max(a.abs()));
        }
        let slope = ab / aa;
        // A joint is not checked if it hardly moves, or if its velocity is noise.
        if largest < SMALLEST_CHECKED_CHANGE
            || ab * ab < SMALLEST_EXPLAINED_SHARE * aa * bb
            || PLAUSIBLE_SLOPES.contains(&slope)
        {
            continue;
        }
        // The value of the slope shows which unit is wrong.
        let close = |x: f64| (slope / x - 1.0).abs() < UNIT_FACTOR_TOLERANCE;
        let degree = 180.0 / std::f64::consts::PI;
        let guess = match slope {
            _ if close(degree) => "velocities in degrees per second with positions in rad?",
            _ if close(1.0 / degree) => "positions in degrees with velocities in rad/s?",
            _ if close(1e3) => "a clock in ms?",
            _ if close(1e6) => "a clock in us?",
            _ if close(30.0 / std::f64::consts::PI) => "velocities in revolutions a minute?",
            _ if slope < 0.0 => "signs that differ?",
            _ => "a gear ratio, or another unit?",
        };
        let message = format!(
            "the velocity of {name} is {slope:.4} times the slope of its position: {guess} Name the unit in the header \
             (q1_deg, t_ms, ..) or in the options (columns), or use positions alone (signal: velocity: differentiated)"
        );
        return Err(Error::at(file, 0, message));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(position: f64, velocity: f64, clock: f64) -> Result<(), Error> {
        let t: Vec<f64> = (0..2000).map(|i| 0.001 * f64::from(i)).collect();
        // The encoder has steps of 1e-3 rad. The difference between successive samples is therefore only quantisation.
        let q = t.iter().map(|t| position * ((2.0 * t).sin() * 1e3).round() * 1e-3).collect();
        let dq = t.iter().map(|t| velocity * 2.0 * (2.0 * t).cos()).collect();
        let t: Vec<f64> = t.iter().map(|t| clock * t).collect();
        check_velocity("log.csv", &["q1".into()], &t, &[q], &[dq], 0.001 * clock)
    }

    #[test]
    fn units_and_signs() {
        check(1.0, 1.0, 1.0).unwrap();
        // If the joint does not move, position and velocity are not compared.
        check(1e-3, 1.0, 1.0).unwrap();
        for (position, velocity, clock, expected) in [
            (57.29578, 1.0, 1.0, "positions in degrees"),
            (1.0, 57.29578, 1.0, "velocities in degrees"),
            (1.0, 1.0, 1e3, "a clock in ms"),
            (1.0, 9.5493, 1.0, "revolutions a minute"),
            (1.0, -1.0, 1.0, "signs that differ"),
            (1.0, 100.0, 1.0, "a gear ratio"),
        ] {
            let message = check(position, velocity, clock).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
