//! Computes the pose of an MJCF element relative to its parent element from its attributes.
//!
//! The position is `pos`. The orientation is one of
//! - `quat`: w x y z;
//! - `axisangle`: an axis and an angle;
//! - `euler`: three angles about the axes of `eulerseq`; lower-case letters mean axes that rotate with the body;
//! - `xyaxes`: x, and a y that is made orthogonal to x;
//! - `zaxis`: z; the smallest rotation that turns z into this direction.
//!
//! Without any of these attributes there is no rotation. `angle` and `eulerseq` are attributes of `<compiler>`; MuJoCo's
//! defaults are degrees and `xyz`. Source: MuJoCo, XML reference, "frame orientations".
//!
//! Attributes in an included file (`<include>`) are not read.

use nalgebra::{Matrix3, Rotation3, Unit, UnitQuaternion, Vector3};
use robot::Pose;
use roxmltree::{Document, Node};

/// Unit and axis sequence of angles in a file.
pub(super) struct AngleConvention<'a> {
    /// Factor from the file's unit of angles to rad; `None` if an included file may define the unit.
    unit: Option<f64>,
    /// The axes of the three Euler angles; `None` if an included file may define these axes.
    sequence: Option<&'a str>,
}

impl<'a> AngleConvention<'a> {
    /// Reads the convention from the compiler options of the file.
    pub(super) fn of(document: &'a Document) -> AngleConvention<'a> {
        let compilers = || document.descendants().filter(|n| n.has_tag_name("compiler"));
        let said = |key: &str| compilers().filter_map(|n| n.attribute(key)).next_back();
        let is_whole = !document.descendants().any(|n| n.has_tag_name("include"));
        AngleConvention {
            unit: said("angle").or(is_whole.then_some("degree")).map(|unit| match unit {
                "radian" => 1.0,
                _ => 1f64.to_radians(),
            }),
            sequence: said("eulerseq").or(is_whole.then_some("xyz")),
        }
    }

    /// The pose of an element relative to its parent element; `None` if its attributes cannot be read.
    pub(super) fn pose(&self, node: &Node) -> Option<Pose> {
        let position = match node.attribute("pos") {
            Some(text) => numbers(text)?,
            None => [0.0; 3],
        };
        let rotation: Matrix3<f64> = self.rotation(node)?.to_rotation_matrix().into_inner();
        let rotation = [0, 1, 2].map(|r| [0, 1, 2].map(|c| rotation[(r, c)]));
        Some(Pose { rotation, position })
    }

    fn rotation(&self, node: &Node) -> Option<UnitQuaternion<f64>> {
        if let Some(text) = node.attribute("quat") {
            let [w, i, j, k] = numbers(text)?;
            return UnitQuaternion::try_new(nalgebra::Quaternion::new(w, i, j, k), f64::MIN_POSITIVE);
        }
        if let Some(text) = node.attribute("axisangle") {
            let [x, y, z, angle] = numbers(text)?;
            return Some(UnitQuaternion::from_axis_angle(&unit([x, y, z])?, angle * self.unit?));
        }
        if let Some(text) = node.attribute("euler") {
            let angles: [f64; 3] = numbers(text)?;
            return self.euler(angles.map(|angle| Some(angle * self.unit?)));
        }
        if let Some(text) = node.attribute("xyaxes") {
            let [x1, x2, x3, y1, y2, y3] = numbers(text)?;
            let (x, y) = (unit([x1, x2, x3])?, Vector3::new(y1, y2, y3));
            let y = Unit::try_new(y - x.into_inner() * x.dot(&y), f64::MIN_POSITIVE)?;
            let axes = Matrix3::from_columns(&[x.into_inner(), y.into_inner(), x.cross(&y)]);
            return Some(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes)));
        }
        if let Some(text) = node.attribute("zaxis") {
            let z = unit(numbers(text)?)?;
            // No smallest rotation exists if z becomes -z. MuJoCo then rotates by half a turn about x.
            let half = || UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
            return Some(UnitQuaternion::rotation_between(&Vector3::z_axis(), &z).unwrap_or_else(half));
        }
        Some(UnitQuaternion::identity())
    }

    /// Three successive rotations by Euler angles. Lower-case letters: axes that rotate with the body; capital letters: fixed
    /// axes.
    fn euler(&self, angles: [Option<f64>; 3]) -> Option<UnitQuaternion<f64>> {
        let sequence = self.sequence?;
        let mut rotation = UnitQuaternion::identity();
        for (letter, angle) in sequence.chars().zip(angles) {
            let axis = match letter.to_ascii_lowercase() {
                'x' => Vector3::x_axis(),
                'y' => Vector3::y_axis(),
                'z' => Vector3::z_axis(),
                _ => return None,
            };
            let turn = UnitQuaternion::from_axis_angle(&axis, angle?);
            rotation = if letter.is_ascii_lowercase() { rotation * turn } else { turn * rotation };
        }
        (sequence.chars().count() == 3).then_some(rotation)
    }
}

fn unit(axis: [f64; 3]) -> Option<Unit<Vector3<f64>>> {
    Unit::try_new(Vector3::from(axis), f64::MIN_POSITIVE)
}

/// Parses a text of exactly N finite numbers; `None` for any other text.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let found: Option<Vec<f64>> =
        text.split_whitespace().map(|x| x.parse().ok().filter(|x: &f64| x.is_finite())).collect();
    found?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::write_back::mjcf::quaternion;

    fn turned(compiler: &str, orientation: &str) -> Option<[f64; 4]> {
        let text = format!("<mujoco>{compiler}<worldbody><body {orientation}/></worldbody></mujoco>");
        let document = Document::parse(&text).unwrap();
        let body = document.descendants().find(|n| n.has_tag_name("body")).unwrap();
        AngleConvention::of(&document).pose(&body).map(|pose| quaternion(&pose))
    }

    /// The expected quaternions come from MuJoCo 4.0.0 and 3.1.1 (`body_quat` of the compiled model).
    #[test]
    fn orientations_are_those_of_mujoco() {
        let radian = "<compiler angle=\"radian\"/>";
        for (compiler, orientation, expected) in [
            ("", "", [1.0, 0.0, 0.0, 0.0]),
            ("", "quat=\"2 0 0 2\"", [0.5_f64.sqrt(), 0.0, 0.0, 0.5_f64.sqrt()]),
            ("", "euler=\"10 20 30\"", [0.94371436, 0.12767944, 0.14487813, 0.26853582]),
            ("<compiler eulerseq=\"XYZ\"/>", "euler=\"10 20 30\"", [0.95154852, 0.03813458, 0.18930786, 0.23929834]),
            (radian, "euler=\"10 20 30\"", [-0.15842345, -0.71160076, -0.40599185, -0.5510871]),
            ("", "axisangle=\"1 0 0 30\"", [0.96592583, 0.25881905, 0.0, 0.0]),
            (radian, "axisangle=\"2 0 0 30\"", [-0.75968791, 0.65028784, 0.0, 0.0]),
            ("", "xyaxes=\"1 1 0 0 1 1\"", [0.82047324, 0.4247082, 0.1759199, 0.33985114]),
            ("", "zaxis=\"0 1 1\"", [0.92387953, -0.38268343, 0.0, 0.0]),
            ("", "zaxis=\"0 0 -2\"", [0.0, 1.0, 0.0, 0.0]),
        ] {
            let found = turned(compiler, orientation).unwrap();
            let sign = if found.iter().zip(&expected).map(|(a, b)| a * b).sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
            // Tolerance: MuJoCo's values were printed with eight digits.
            let near = found.iter().zip(&expected).all(|(a, b)| (sign * a - b).abs() < 1e-8);
            assert!(near, "{compiler} {orientation}: {found:?} {expected:?}");
        }
    }

    #[test]
    fn what_is_not_plain_is_no_pose() {
        for orientation in ["quat=\"0 0 0 0\"", "quat=\"1 0 0\"", "euler=\"a b c\"", "zaxis=\"0 0 0\"", "pos=\"1 2\""] {
            assert_eq!(turned("", orientation), None, "{orientation}");
        }
        assert_eq!(turned("<compiler eulerseq=\"xyw\"/>", "euler=\"1 2 3\""), None);
        // Euler angles cannot be read: an included file may say that angles are in radians.
        assert_eq!(turned("<include file=\"options.xml\"/>", "euler=\"1 2 3\""), None);
        assert!(turned("<include file=\"options.xml\"/>", "zaxis=\"0 1 0\"").is_some());
    }
}
