//! Options for a log of a force-torque sensor: the names of the columns, and corrections of the numbers in these columns
//! (units, axes, order of a quaternion).

use std::fmt;

use serde::{Deserialize, Serialize};

/// The content of the options file for a force-torque log.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WrenchOptions {
    /// Headers of the columns, if they cannot be found by their names.
    pub columns: WrenchColumns,
    /// Corrections that are applied to the numbers.
    pub corrections: Corrections,
}

/// Headers of columns. `None`: the column is searched by its name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WrenchColumns {
    /// Header of the time column.
    pub time: Option<String>,
    /// Headers of the force: x, y, z.
    pub force: Option<[String; 3]>,
    /// Headers of the torque: x, y, z.
    pub torque: Option<[String; 3]>,
    /// Headers of the position: x, y, z.
    pub position: Option<[String; 3]>,
    /// Headers of the orientation: x, y, z, w of a quaternion, or roll, pitch, yaw.
    pub orientation: Option<Vec<String>>,
    /// Headers of a rotation vector (axis times angle): x, y, z.
    pub rotation_vector: Option<[String; 3]>,
}

/// Corrections of the numbers, applied in the order of the fields. Display prints the YAML that requests them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Corrections {
    /// Whether roll, pitch and yaw, or the rotation vector, are in degrees instead of rad.
    pub degrees: bool,
    /// Whether the order of a quaternion is w, x, y, z.
    pub scalar_first: bool,
    /// Whether the poses are poses of the frame at rest in the sensor frame, instead of the inverse.
    pub inverted_poses: bool,
    /// Whether forces and torques are in the axes of the frame at rest instead of the sensor's axes.
    pub base_axes: bool,
    /// Rotation of the sensor's axes in the frame of the poses: roll, pitch and yaw, rad, Rz(yaw) Ry(pitch) Rx(roll).
    pub turn: [f64; 3],
    /// Unit of the forces in the log, N.
    pub force: f64,
    /// Unit of the torques in the log, N m.
    pub torque: f64,
}

impl Default for Corrections {
    fn default() -> Corrections {
        let (turn, force, torque) = ([0.0; 3], 1.0, 1.0);
        Corrections {
            degrees: false,
            scalar_first: false,
            inverted_poses: false,
            base_axes: false,
            turn,
            force,
            torque,
        }
    }
}

impl fmt::Display for Corrections {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = [
            ("degrees", self.degrees),
            ("scalar_first", self.scalar_first),
            ("inverted_poses", self.inverted_poses),
            ("base_axes", self.base_axes),
        ];
        let mut parts: Vec<String> =
            words.into_iter().filter(|(_, is)| *is).map(|(word, _)| format!("{word}: true")).collect();
        let [r, p, y] = self.turn;
        parts.extend((self.turn != [0.0; 3]).then(|| format!("turn: [{r:.4}, {p:.4}, {y:.4}]")));
        let factors = [("force", self.force), ("torque", self.torque)];
        parts.extend(factors.into_iter().filter(|(_, x)| *x != 1.0).map(|(word, x)| format!("{word}: {x}")));
        write!(f, "corrections: {{{}}}", parts.join(", "))
    }
}

type Matrix = [[f64; 3]; 3];

impl Corrections {
    /// Applies the corrections to a row: orientation `turn`, position `place`, and force and torque `wrench`. Angles are already
    /// in rad.
    pub(crate) fn correct(&self, turn: &mut Matrix, place: &mut [f64; 3], wrench: [&mut [f64; 3]; 2]) {
        if self.scalar_first {
            let [x, y, z, w] = quaternion(turn);
            *turn = matrix([y, z, w, x]);
        }
        if self.inverted_poses {
            *turn = transposed(turn);
            *place = turned(turn, *place).map(|x| -x);
        }
        let sensor = roll_pitch_yaw(self.turn);
        for (vector, factor) in wrench.into_iter().zip([self.force, self.torque]) {
            if self.base_axes {
                *vector = turned(&transposed(turn), *vector);
            }
            *vector = turned(&sensor, *vector).map(|x| factor * x);
        }
    }
}

/// The rotation matrix Rz(yaw) Ry(pitch) Rx(roll).
pub(crate) fn roll_pitch_yaw(angles: [f64; 3]) -> Matrix {
    let [(sr, cr), (sp, cp), (sy, cy)] = angles.map(f64::sin_cos);
    [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
}

/// The rotation matrix of a unit quaternion x, y, z, w.
pub(crate) fn matrix([x, y, z, w]: [f64; 4]) -> Matrix {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// The quaternion x, y, z, w of a rotation matrix. The largest component is computed first, to avoid a division by a small
/// number.
fn quaternion(m: &Matrix) -> [f64; 4] {
    let trace = m[0][0] + m[1][1] + m[2][2];
    // Four times the squares of x, y, z, w.
    let squares = [0, 1, 2, 3].map(|k| if k < 3 { 1.0 + 2.0 * m[k][k] - trace } else { 1.0 + trace });
    let k = (0..4).max_by(|a, b| squares[*a].total_cmp(&squares[*b])).unwrap_or(3);
    let largest = squares[k].sqrt() / 2.0;
    let product = |a: usize, b: usize| match (a.min(b), a.max(b)) {
        (a, b) if a == b => squares[a],
        (a, 3) => m[(a + 2) % 3][(a + 1) % 3] - m[(a + 1) % 3][(a + 2) % 3],
        (a, b) => m[a][b] + m[b][a],
    };
    [0, 1, 2, 3].map(|i| product(i, k) / (4.0 * largest))
}

fn transposed(m: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|k| m[k][i]))
}

fn turned(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| (0..3).map(|k| row[k] * v[k]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quaternion_comes_back_and_a_correction_says_itself() {
        for q in [[0.5, -0.5, 0.5, 0.5], [0.0, 1.0, 0.0, 0.0], [0.1, 0.2, -0.3, 0.86f64.sqrt()], [0.8, 0.0, 0.6, 0.0]] {
            let found = quaternion(&matrix(q));
            let sign = if found.iter().zip(q).map(|(a, b)| a * b).sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
            assert!(found.iter().zip(q).all(|(a, b)| (sign * a - b).abs() < 1e-15), "{found:?} {q:?}");
        }
        let all = Corrections { scalar_first: true, turn: [0.0, 0.0, 0.5], torque: 0.001, ..Corrections::default() };
        assert_eq!(all.to_string(), "corrections: {scalar_first: true, turn: [0.0000, 0.0000, 0.5000], torque: 0.001}");
    }
}
