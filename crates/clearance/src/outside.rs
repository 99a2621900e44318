//! The distance from a body to a point outside of it, for example to a centre of mass.
//!
//! The distance refers to the hull of all shapes of the body together, because a centre of mass may lie between two shapes.

use robot::Pose;
use robot::vector::{Vector3, minus, norm, plus, turned};

use crate::bodies::FileLink;
use crate::hull::Hull;
use crate::separation::{PosedSolid, separation};
use crate::solid::{Core, Solid};

/// Two lengths, m: the distance of a point from the hull of all shapes of a body, and the diagonal of the bounding box of this
/// hull. The point is given in the frame of the link that carries the body. `None` if a shape is missing, or if no shape is a
/// mesh.
pub fn outside(body: &FileLink, point: Vector3) -> Option<(f64, f64)> {
    let is_mesh = body.shapes.iter().any(|shape| matches!(shape.solid.core, Core::Hull(_)));
    if !body.has_geometry || !body.missing.is_empty() || !is_mesh {
        return None;
    }
    let points: Vec<Vector3> = body
        .shapes
        .iter()
        .flat_map(|shape| {
            let pose = shape.pose;
            corners(&shape.solid.core).into_iter().map(move |p| plus(pose.position, turned(&pose.rotation, p)))
        })
        .collect();
    let extreme = |k: usize, sign: f64| points.iter().map(|p| sign * p[k]).fold(f64::NEG_INFINITY, f64::max);
    let across = norm([0, 1, 2].map(|k| extreme(k, 1.0) + extreme(k, -1.0)));
    let middle = [0, 1, 2].map(|k| 0.5 * (extreme(k, 1.0) - extreme(k, -1.0)));
    let radius = body.shapes.iter().map(|shape| shape.solid.radius).fold(0.0, f64::max);
    let hull = Solid { core: Core::Hull(Hull::new(points)), radius };
    let one = Solid { core: Core::Point, radius: 0.0 };
    let (one, hull) = (PosedSolid { solid: &one, pose: at(point) }, PosedSolid { solid: &hull, pose: Pose::IDENTITY });
    let apart = separation(one, hull, minus(point, middle)).at_least;
    Some((apart.max(0.0), across + 2.0 * radius))
}

fn at(position: Vector3) -> Pose {
    Pose { position, ..Pose::IDENTITY }
}

/// Points whose convex hull contains the core (the solid without its radius). For a round core they are the corners of its
/// bounding box.
fn corners(core: &Core) -> Vec<Vector3> {
    let half = match core {
        Core::Hull(hull) => return hull.points().to_vec(),
        Core::Point => [0.0; 3],
        Core::Segment { half } => [0.0, 0.0, *half],
        Core::Cuboid { half } => *half,
        Core::Cylinder { radius, half } => [*radius, *radius, *half],
    };
    (0..8).map(|k| [0, 1, 2].map(|i| if k >> i & 1 == 1 { half[i] } else { -half[i] })).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::bodies::bodies;

    #[test]
    fn a_point_is_as_far_as_from_the_nearest_face() {
        let folder = std::env::temp_dir().join(format!("rist-outside-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let corner = |k: usize| [0, 1, 2].map(|i| if k >> i & 1 == 1 { 0.1 } else { -0.1 });
        let vertices: String = (0..8).map(corner).map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
        let faces = "f 1 2 4 3\nf 5 6 8 7\nf 1 2 6 5\nf 3 4 8 7\nf 1 3 7 5\nf 2 4 8 6\n";
        std::fs::write(folder.join("cube.obj"), vertices + faces).unwrap();
        let link = |shape: &str, directory: &Path| {
            let text = format!(
                r#"<robot name="arm"><link name="base"/><joint name="q1" type="revolute"><parent link="base"/><child link="arm"/>
  <axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <link name="arm"><collision><origin xyz="0 0 1"/><geometry>{shape}</geometry></collision></link></robot>"#
            );
            let robot = robot::format::read_urdf(&text, "arm.urdf").unwrap();
            bodies(&robot, directory).into_iter().find(|body| body.name == "arm").unwrap()
        };
        let mesh = link(r#"<mesh filename="cube.obj"/>"#, &folder);
        for (point, apart) in [
            ([0.0, 0.0, 1.3], 0.2),
            ([0.0, -0.15, 1.0], 0.05),
            ([0.4, 0.5, 1.1], 0.5),
            ([0.05, 0.0, 1.05], 0.0),
            ([0.0; 3], 0.9),
        ] {
            let (found, across) = outside(&mesh, point).unwrap();
            // The distance from a vertex or an edge is accurate to 1e-6 m. The diagonal of the cube is 0.2 sqrt(3) m
            // = sqrt(0.12) m.
            let off = (found - apart).abs().max((across - 0.12_f64.sqrt()).abs());
            assert!(off < 1e-6, "{point:?}: {found} {across}");
        }
        assert_eq!(outside(&link(r#"<box size="0.2 0.2 0.2"/>"#, &folder), [0.0; 3]), None);
        // A body with a missing mesh has no distance.
        assert_eq!(outside(&link(r#"<mesh filename="none.obj"/>"#, &folder), [0.0; 3]), None);
        std::fs::remove_dir_all(&folder).ok();
    }
}
