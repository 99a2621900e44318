//! Replaces rounded angles and lengths by exact values: 1.5707 becomes pi/2.
//!
//! An angle within [`ROUND_ANGLE_TOLERANCE_RAD`] of a multiple of pi/2, pi/4 or pi/6 is replaced by this multiple, because no
//! calibration measures such a small difference. An angle is also replaced by a multiple of pi/2 if it is this multiple
//! rounded or cut off at its last decimal, down to four decimals ([`LONGEST_CUT_RAD`]): 1.5707 and 1.5708 are pi/2. A similar
//! angle with more digits is kept: 1.57065 is not pi/2. The angles 0.0001 and 0.00015 are kept, because zero has no digits to
//! omit. Sine and cosine of a multiple of pi are exact, so omitted digits do not lead to additional base parameters.

use std::f64::consts::PI;

use crate::kinematics::sin_cos;
use crate::robot::{ModifiedDh, Note, Robot};
use crate::value::Value;
use crate::vector::{Matrix3, Vector3, norm, product, scaled};

/// A cut-off decimal is replaced by a multiple of pi/2 if the two differ by at most this value, rad. 3.1415 differs from pi by
/// 9.3e-5 and is replaced. 1.57 differs from pi/2 by 8e-4 and is kept.
const LONGEST_CUT_RAD: f64 = 1e-4;
/// An angle is replaced by a round angle if the two differ by at most this value, rad (one arc second). 0.7854 differs from
/// pi/4 by 1.8e-6, and 1.5708 differs from pi/2 by 3.67e-6.
pub(crate) const ROUND_ANGLE_TOLERANCE_RAD: f64 = 5e-6;
/// A unit axis is replaced by a coordinate axis if its two other components are at most this value.
const AXIS_TOLERANCE_SINE: f64 = 1e-6;
/// A length below this value (m) in a file is a rounding error of the exporter.
const LENGTH_NOISE_M: f64 = 1e-9;
/// If two angles differ by at most this value (rad), the difference is a rounding error of double precision. It is removed
/// without a note, even with [`AngleSnapping::AsGiven`].
pub(crate) const UNNOTED_DIFFERENCE_RAD: f64 = 1e-9;
/// An entry of a rotation matrix is set to a known value if the two differ by at most this tolerance. Products of three sines
/// or cosines have an error of a few units in the last place, 2e-16.
const ROTATION_ENTRY_TOLERANCE: f64 = 1e-14;
/// An axis with all components below this value has no direction, and counts as the zero vector: the axes in files are unit
/// vectors.
const SMALLEST_AXIS_COMPONENT: f64 = 1e-9;
/// A value that this program computes from exact values has at most this rounding error, rad or m. The values are below 10,
/// and the computation has only a few operations.
const SNAPPED_VALUE_ROUNDING: f64 = 1e-12;
/// An angle is only replaced if it is below this number times pi/12.
const MAX_TWELFTHS: f64 = 1e6;

/// How the reader treats rounded angles of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AngleSnapping {
    /// Rounded angles are replaced: 1.5707 becomes pi/2.
    #[default]
    Meant,
    /// Angles are kept as given: 1.5707 stays 1.5707.
    AsGiven,
}

/// The value for an angle of a file, rad: the exact multiple of pi/12 that replaces it, or the angle itself.
pub(crate) fn given_angle(angle: f64, angles: AngleSnapping) -> Value {
    let twelfths = angle * 12.0 / PI;
    let n = twelfths.round();
    let away = (angle - n * PI / 12.0).abs();
    let step = n.rem_euclid(12.0);
    let tolerance = match (step as i64, angles) {
        (0 | 2 | 3 | 4 | 6 | 8 | 9 | 10, AngleSnapping::AsGiven) => UNNOTED_DIFFERENCE_RAD,
        (0 | 6, AngleSnapping::Meant) => ROUND_ANGLE_TOLERANCE_RAD.max(last_decimal(angle).min(LONGEST_CUT_RAD)),
        (2 | 3 | 4 | 8 | 9 | 10, AngleSnapping::Meant) => ROUND_ANGLE_TOLERANCE_RAD,
        _ => -1.0,
    };
    if away <= tolerance && n.abs() < MAX_TWELFTHS { twelfths_of_pi(n as i64) } else { Value::Number(angle) }
}

/// The note that the angle `name` of `subject`, rad, was replaced by `taken`. `None` if the two differ only by rounding.
pub(crate) fn note_of(subject: &str, name: &str, given: f64, taken: &Value) -> Option<Note> {
    let text = || format!("{name} {given} is taken as {}", multiple_of_pi(taken));
    let is_other = (taken.number(&[]) - given).abs() > UNNOTED_DIFFERENCE_RAD;
    is_other.then(|| Note { subject: subject.into(), text: text() })
}

/// Formats a multiple of pi as text: `-3*pi/4`.
fn multiple_of_pi(angle: &Value) -> String {
    let Some((numerator, denominator)) = angle.as_multiple_of_pi(&[]) else { return angle.number(&[]).to_string() };
    let sign = if numerator < 0 { "-" } else { "" };
    let multiple = match numerator.unsigned_abs() {
        0 => return "0".into(),
        1 => "pi".to_string(),
        n => format!("{n}*pi"),
    };
    if denominator == 1 { format!("{sign}{multiple}") } else { format!("{sign}{multiple}/{denominator}") }
}

/// The value of the last decimal of an angle: 1e-4 for 1.5707.
fn last_decimal(angle: f64) -> f64 {
    let text = angle.to_string();
    let decimals = text.split_once('.').map_or(0, |(_, after)| after.len());
    // The factor 1 - epsilon makes the value slightly smaller, because 10^-4 itself is rounded and may be too large.
    10f64.powi(-(decimals.min(300) as i32)) * (1.0 - f64::EPSILON)
}

/// The value for an angle computed from exact values, rad, in (-pi, pi]. Rounding errors are removed.
pub(crate) fn computed_angle(angle: f64) -> Value {
    let n = (angle * 12.0 / PI).round();
    if (angle - n * PI / 12.0).abs() <= SNAPPED_VALUE_ROUNDING {
        let n = n as i64;
        twelfths_of_pi(if n <= -12 { n + 24 } else { n })
    } else {
        Value::Number(decimal(angle))
    }
}

/// The value for a length computed from exact values, m. Rounding errors are removed.
pub(crate) fn computed_length(length: f64) -> Value {
    if length.abs() <= SNAPPED_VALUE_ROUNDING { Value::ZERO } else { Value::Number(decimal(length)) }
}

/// A length of a file, m. With [`AngleSnapping::Meant`], a length below 1e-9 m (rounding of the exporter) becomes zero.
pub(crate) fn given_length(length: f64, angles: AngleSnapping) -> f64 {
    if angles == AngleSnapping::Meant && length.abs() < LENGTH_NOISE_M { 0.0 } else { length }
}

/// The value n pi / 12 as a reduced fraction.
fn twelfths_of_pi(n: i64) -> Value {
    let (mut a, mut b) = (n.unsigned_abs(), 12u64);
    while b != 0 {
        (a, b) = (b, a % b);
    }
    let (numerator, denominator) = (n.unsigned_abs() / a, 12 / a);
    let number = |x: u64| Box::new(Value::Number(x as f64));
    let multiple = match numerator {
        0 => return Value::ZERO,
        1 => Value::Pi,
        k => Value::Mul(number(k), Box::new(Value::Pi)),
    };
    let fraction = if denominator == 1 { multiple } else { Value::Div(Box::new(multiple), number(denominator)) };
    if n < 0 { Value::Neg(Box::new(fraction)) } else { fraction }
}

/// The decimal number with twelve digits that equals `x` up to rounding, otherwise `x`: 0.13585 - 0.1197 becomes 0.01615.
fn decimal(x: f64) -> f64 {
    let short = format!("{x:.11e}").parse().unwrap_or(x);
    if (short - x).abs() <= 4.0 * f64::EPSILON * x.abs().max(1.0) { short } else { x }
}

/// The rotation matrix R = Rz(yaw) Ry(pitch) Rx(roll) of `rpy` = (roll, pitch, yaw).
pub(crate) fn rotation(rpy: &[Value; 3]) -> Matrix3 {
    let [(sr, cr), (sp, cp), (sy, cy)] = [0, 1, 2].map(|i| sin_cos(&rpy[i], &[]));
    let x = [[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]];
    let y = [[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]];
    let z = [[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]];
    exact(&product(&product(&z, &y), &x))
}

/// Sets matrix entries that equal 0, 1/2, sqrt(1/2), sqrt(3)/2 or 1, up to rounding and sign, to the exact value with this sign.
pub(crate) fn exact(m: &Matrix3) -> Matrix3 {
    m.map(|row| row.map(exact_entry))
}

fn exact_entry(x: f64) -> f64 {
    let known = [0.0, 0.5, 0.5f64.sqrt(), 3f64.sqrt() / 2.0, 1.0];
    let near = known.into_iter().find(|k| (x.abs() - k).abs() <= ROTATION_ENTRY_TOLERANCE);
    near.map_or(x, |k| if k == 0.0 { 0.0 } else { k.copysign(x) })
}

/// The unit vector along an axis of a file. `None` for the zero vector.
pub(crate) fn unit_axis(axis: Vector3, angles: AngleSnapping) -> Option<Vector3> {
    let largest = axis.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    if largest < SMALLEST_AXIS_COMPONENT {
        return None;
    }
    let axis = scaled(axis, 1.0 / largest);
    let unit = scaled(axis, 1.0 / norm(axis));
    let tolerance = if angles == AngleSnapping::Meant { AXIS_TOLERANCE_SINE } else { UNNOTED_DIFFERENCE_RAD };
    let along = (0..3).find(|&i| (0..3).all(|j| j == i || unit[j].abs() <= tolerance));
    Some(match along {
        Some(i) => [0, 1, 2].map(|j| if j == i { unit[i].signum() } else { 0.0 }),
        None => unit.map(exact_entry),
    })
}

/// Replaces rounded angles in the robot by exact multiples of pi, and adds a note to the robot for each.
pub(crate) fn snap_angles(robot: &mut Robot, angles: AngleSnapping) {
    let symbols = &robot.symbols;
    let mut notes = Vec::new();
    let mut snap = |subject: &str, geometry: &mut ModifiedDh| {
        let given_angles =
            [("gamma", &mut geometry.gamma), ("alpha", &mut geometry.alpha), ("theta", &mut geometry.theta)];
        for (key, value) in given_angles {
            if value.as_multiple_of_pi(symbols).is_some() {
                continue;
            }
            let given = value.number(symbols);
            let meant = given_angle(given, angles);
            let Some((n, d)) = meant.as_multiple_of_pi(symbols) else { continue };
            if (given - meant.number(symbols)).abs() > UNNOTED_DIFFERENCE_RAD {
                let text = format!("{key} = {given} is taken for {n}/{d} pi");
                notes.push(Note { subject: subject.to_string(), text });
            }
            *value = meant;
        }
    };
    for link in &mut robot.links {
        snap(&format!("link {}", link.label), &mut link.geometry);
    }
    for (i, one) in robot.loops.iter_mut().enumerate() {
        snap(&format!("cut of loop {}", i + 1), &mut one.cut.geometry);
        snap(&format!("twin of loop {}", i + 1), &mut one.twin.geometry);
    }
    robot.snapped.extend(notes);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_taken_for_what_was_meant() {
        // The angles are written as texts, because the function depends on the number of their digits.
        for (angle, multiple) in [
            ("1.5707", (1, 2)),
            ("-1.57079632679", (-1, 2)),
            ("3.1415", (1, 1)),
            ("-0.7854", (-1, 4)),
            ("0.523599", (1, 6)),
            ("2.0943951", (2, 3)),
            ("0", (0, 1)),
            ("6.2832", (2, 1)),
        ] {
            let found = given_angle(angle.parse().unwrap(), AngleSnapping::Meant);
            assert_eq!(found.as_multiple_of_pi(&[]), Some(multiple), "{angle}");
        }
        // These angles are kept. 1.57065, 0.0001 and 0.00015 can be calibrated values; 1.5708963 is a right angle plus 1e-4.
        for angle in ["1.57", "0.7853", "0.2618", "1.75057", "1.57065", "0.0001", "-0.00015", "1.5708963", "3.14149"] {
            let angle = angle.parse().unwrap();
            assert_eq!(given_angle(angle, AngleSnapping::Meant), Value::Number(angle));
        }
    }

    #[test]
    fn computed_values_lose_their_rounding() {
        assert_eq!(computed_length(0.13585 - 0.1197), Value::Number(0.01615));
        assert_eq!(computed_length(2f64.sqrt() / 10.0), Value::Number(2f64.sqrt() / 10.0));
        assert_eq!(computed_angle(-PI), Value::Pi);
        assert_eq!(computed_angle(-PI / 2.0 + 1e-15).as_multiple_of_pi(&[]), Some((-1, 2)));
    }

    #[test]
    fn rotations_keep_exact_entries() {
        let quarter = given_angle(PI / 4.0, AngleSnapping::Meant);
        let m = rotation(&[quarter.clone(), Value::ZERO, quarter]);
        assert_eq!(m[0], [0.5f64.sqrt(), -0.5, 0.5]);
        assert_eq!(unit_axis([0.0, -3.0, 1e-9], AngleSnapping::Meant), Some([0.0, -1.0, 0.0]));
        assert_eq!(unit_axis([1e300, 1e300, 0.0], AngleSnapping::Meant), Some([0.5f64.sqrt(), 0.5f64.sqrt(), 0.0]));
        assert_eq!(unit_axis([0.0; 3], AngleSnapping::Meant), None);
    }
}
