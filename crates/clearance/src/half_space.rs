//! Half-spaces in which bodies must stay: the space above a floor, before a wall, or inside a box.
//!
//! ```text
//! n . x >= offset   for every point x of the body, n a unit vector in the base frame
//! ```
//! A box is the intersection of six half-spaces.

use robot::vector::{Vector3, dot, norm, scaled};

/// The allowed half-space: the points on one side of a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct HalfSpace {
    /// Name of the obstacle, for example `the floor`.
    pub name: String,
    /// Unit normal vector of the plane, in the base frame. It points into the allowed space.
    pub normal: Vector3,
    /// Distance of the plane from the origin of the base frame along the normal, m.
    pub offset: f64,
    /// Links of the file that must stay in the half-space. `None`: all moving links.
    pub links: Option<Vec<String>>,
}

impl HalfSpace {
    /// The half-space bounded by a plane through `point`, on the side to which `normal` points.
    ///
    /// Fails if the normal is zero or a number is not finite.
    pub fn beyond(name: String, point: Vector3, normal: Vector3) -> Result<HalfSpace, String> {
        let length = norm(normal);
        if !(length.is_finite() && length > 0.0 && point.iter().all(|x| x.is_finite())) {
            return Err(format!(
                "{name}: normal {normal:?} at {point:?}; expected are finite numbers, and a direction"
            ));
        }
        let normal = scaled(normal, 1.0 / length);
        Ok(HalfSpace { name, normal, offset: dot(normal, point), links: None })
    }

    /// The six half-spaces whose intersection is a box. `low`, `high`: opposite corners of the box in the base frame, m.
    ///
    /// Fails if a coordinate of `low` is not below the same coordinate of `high`.
    pub fn sides_of_box(name: &str, low: Vector3, high: Vector3) -> Result<Vec<HalfSpace>, String> {
        if let Some(k) = (0..3).find(|&k| !(low[k].is_finite() && high[k].is_finite() && low[k] < high[k])) {
            let axis = ["x", "y", "z"][k];
            return Err(format!("{name}: it is empty along {axis}: from {} to {}", low[k], high[k]));
        }
        let side = |k: usize, is_low: bool| {
            let mut normal = [0.0; 3];
            normal[k] = if is_low { 1.0 } else { -1.0 };
            let axis = ["x", "y", "z"][k];
            let (end, offset) = if is_low { ("least", low[k]) } else { ("greatest", -high[k]) };
            HalfSpace { name: format!("the {end} {axis} of {name}"), normal, offset, links: None }
        };
        Ok((0..3).flat_map(|k| [side(k, true), side(k, false)]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_six_sides() {
        let sides = HalfSpace::sides_of_box("the cell", [-1.0, -2.0, 0.0], [1.0, 2.0, 3.0]).unwrap();
        let inside = |p: Vector3| sides.iter().all(|s| dot(s.normal, p) >= s.offset);
        assert!(inside([0.9, -1.9, 0.1]) && !inside([0.9, -2.1, 0.1]) && !inside([0.0, 0.0, 3.1]));
        assert_eq!(sides[5].name, "the greatest z of the cell");
        let error = HalfSpace::sides_of_box("the cell", [0.0; 3], [1.0, 0.0, 1.0]).unwrap_err();
        assert_eq!(error, "the cell: it is empty along y: from 0 to 0");
        let wall = HalfSpace::beyond("wall 1".into(), [0.0, 0.5, 0.0], [0.0, -2.0, 0.0]).unwrap();
        assert_eq!((wall.normal, wall.offset), ([0.0, -1.0, 0.0], -0.5));
        assert!(HalfSpace::beyond("wall 1".into(), [0.0; 3], [0.0; 3]).is_err());
    }
}
