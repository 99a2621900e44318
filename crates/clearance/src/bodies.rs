//! Converts the collision geometry of a robot's links into convex solids.
//!
//! Each link of the file with collision geometry is a body, even if a fixed joint connects it to another link. If neither a
//! moving link nor the links fixed to it have collision geometry, they form one body of points: the origins of their frames.
//! These points are enough to keep a tool inside a box, but not for the distance between two links.

use std::path::Path;

use robot::{Collision, CollisionShape, Pose, Robot};

use crate::mesh::{mesh_path, vertices};
use crate::solid::{Core, Solid};
use robot::vector::Vector3;

/// One convex solid of a body.
#[derive(Clone, Debug)]
pub struct BodyShape {
    /// The solid in its own frame.
    pub solid: Solid,
    /// Pose of the solid's frame in the frame of the link that carries it.
    pub pose: Pose,
    /// Centre of a ball that contains the solid (bounding ball), in the frame of the link, m.
    pub centre: Vector3,
    /// Radius of the bounding ball of the solid, m.
    pub ball: f64,
    /// Largest distance of a point of the solid from the axis of the joint that carries the link, m.
    pub max_axis_distance: f64,
}

/// A link of the file as a body: its shapes and the moving link that carries it.
#[derive(Clone, Debug)]
pub struct FileLink {
    /// Name of the link in the robot description file.
    pub name: String,
    /// Name of the moving link to which this link of the file is rigidly fixed, or of the link itself if it moves; `base` for the
    /// base.
    pub carrier: String,
    /// Index of the moving link that carries this link (see `carrier`); `None` for the base.
    pub link: Option<usize>,
    /// The solids of this link; empty if its shape is unknown.
    pub shapes: Vec<BodyShape>,
    /// Whether the file describes a shape of this link. If not, points (the origins of frames) represent the link.
    pub has_geometry: bool,
    /// For each shape that could not be read, the reason.
    pub missing: Vec<String>,
    /// For a body that points represent: the name of the frame of each point, in the order of `shapes`. Empty for other bodies.
    pub frames: Vec<String>,
}

impl BodyShape {
    pub(crate) fn new(solid: Solid, pose: Pose) -> BodyShape {
        let (centre, ball) = solid.ball();
        let centre = pose.compose(&Pose { position: centre, ..Pose::IDENTITY }).position;
        let reach = solid.reach_from_z(&pose);
        BodyShape { solid, pose, centre, ball, max_axis_distance: reach }
    }
}

/// All bodies of a robot: first the bodies of the base, then the bodies of each link in order. `directory`: folder of the
/// description, in which meshes are searched.
pub fn bodies(robot: &Robot, directory: &Path) -> Vec<FileLink> {
    let mut found = carried("base", None, &robot.base.collisions, &[], directory);
    for (j, link) in robot.links.iter().enumerate() {
        let own = [(link.name.clone(), link.file_frame)];
        let frames = if link.frames.is_empty() { &own[..] } else { &link.frames[..] };
        found.extend(carried(&link.name, Some(j), &link.collisions, frames, directory));
    }
    found
}

/// The bodies that one moving link (or the base) carries; they move together. `given`: their collision shapes. `frames`: the
/// frames of the link, whose origins are the points if there are no collision shapes.
fn carried(
    carrier: &str,
    link: Option<usize>,
    given: &[Collision],
    frames: &[(String, Pose)],
    directory: &Path,
) -> Vec<FileLink> {
    let body = |name: &str| FileLink {
        name: name.to_string(),
        carrier: carrier.to_string(),
        link,
        shapes: vec![],
        has_geometry: !given.is_empty(),
        missing: vec![],
        frames: vec![],
    };
    // Each link of the file becomes one body with all its shapes. A mesh that cannot be read is listed in `missing`.
    let mut found: Vec<FileLink> = Vec::new();
    for collision in given {
        let at = found.iter().position(|b| b.name == collision.link).unwrap_or_else(|| {
            found.push(body(&collision.link));
            found.len() - 1
        });
        match solid(collision, directory) {
            Ok(solid) => found[at].shapes.push(BodyShape::new(solid, collision.pose)),
            Err(why) => found[at].missing.push(why),
        }
    }
    // If no link here has a collision shape, the origins of all frames become one body of points.
    if given.is_empty() {
        let point = || Solid { core: Core::Point, radius: 0.0 };
        let points = frames.iter().map(|(_, pose)| BodyShape::new(point(), *pose)).collect();
        let frames = frames.iter().map(|(frame, _)| frame.clone()).collect();
        found.push(FileLink { shapes: points, frames, ..body(carrier) });
    }
    found
}

/// Largest allowed coordinate of a mesh vertex in the frame of its link, m.
const FARTHEST_POINT_M: f64 = 100.0;

/// Converts a collision shape to a solid. The error text gives the reason why this is not possible.
pub(crate) fn solid(collision: &Collision, directory: &Path) -> Result<Solid, String> {
    match &collision.shape {
        CollisionShape::Unread { reason } => Err(reason.clone()),
        CollisionShape::Mesh { file, scale } => {
            let points = mesh_points(file, scale, directory)?;
            Solid::around(&points).ok_or_else(|| format!("mesh {file}: it has no vertex"))
        }
        shape => Solid::of_primitive(shape).ok_or_else(|| "its shape is not known".to_string()),
    }
}

/// The vertices of a mesh (m) in the frame of its shape. `directory`: folder of the description.
///
/// Fails if the file cannot be found or read, or if a coordinate exceeds 100 m.
pub fn mesh_points(file: &str, scale: &Vector3, directory: &Path) -> Result<Vec<Vector3>, String> {
    let points = mesh_path(file, directory).and_then(|path| vertices(&path));
    points.and_then(|points| scaled(&points, scale)).map_err(|what| format!("mesh {file}: {what}"))
}

/// Scales the vertices of a mesh; the result is in the frame of its link, m.
///
/// Fails if a coordinate exceeds `FARTHEST_POINT_M`: no robot has such a body, and a proof of its distances would not end.
fn scaled(points: &[Vector3], scale: &Vector3) -> Result<Vec<Vector3>, String> {
    let points: Vec<Vector3> = points.iter().map(|p| [0, 1, 2].map(|k| scale[k] * p[k])).collect();
    match points.iter().flatten().find(|x| x.abs() > FARTHEST_POINT_M) {
        None => Ok(points),
        Some(far) => Err(format!(
            "a vertex is {far} m away, and no robot reaches {FARTHEST_POINT_M} m: of a mesh in millimetres the scale is 0.001"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_is_of_a_robots_size() {
        let arm = [[0.0, 0.0, 850.0], [60.0, -60.0, 0.0]];
        assert_eq!(scaled(&arm, &[1e-3; 3]).unwrap()[1], [0.06, -0.06, 0.0]);
        let refused = scaled(&arm, &[1.0; 3]).unwrap_err();
        assert!(refused.contains("850 m away") && refused.contains("scale is 0.001"), "{refused}");
    }
}
