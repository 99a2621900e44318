//! The convex solids that a robot's links consist of.
//!
//! A moving link is one body together with the links that the file fixes to it. The base is another body. For a link
//! without collision geometry the origins of its frames stand in. They are enough for a box that a tool must stay in,
//! and too little for a distance between links.

use std::path::Path;

use robot::{Collision, CollisionShape, Pose, Robot};

use crate::mesh::{mesh_path, vertices};
use crate::solid::{Core, Solid};
use crate::vector::Vector3;

/// A solid of a body.
#[derive(Clone, Debug)]
pub struct Shape {
    /// The link of the file that it belongs to.
    pub link: String,
    /// The solid in its own frame.
    pub solid: Solid,
    /// Pose of that frame in the frame of the link that carries it.
    pub pose: Pose,
    /// Centre of a ball about it, in the frame of the link.
    pub centre: Vector3,
    /// Radius of that ball, m.
    pub ball: f64,
    /// Largest distance of its points from the axis of the joint that carries it, m.
    pub reach: f64,
}

/// Links that move as one.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name of the link in the file.
    pub name: String,
    /// The link that carries it; none: the base.
    pub link: Option<usize>,
    /// Empty: nothing is known of its shape.
    pub shapes: Vec<Shape>,
    /// Whether the file describes a shape: without one, points stand for it.
    pub has_geometry: bool,
    /// Why a shape of it is missing.
    pub missing: Vec<String>,
}

impl Shape {
    fn new(link: &str, solid: Solid, pose: Pose) -> Shape {
        let (centre, ball) = solid.ball();
        let centre = pose.compose(&Pose { position: centre, ..Pose::IDENTITY }).position;
        let reach = solid.reach_from_z(&pose);
        Shape { link: link.to_string(), solid, pose, centre, ball, reach }
    }
}

/// The base, then every link, in order; `directory`: that of the description, from which meshes are found.
pub fn bodies(robot: &Robot, directory: &Path) -> Vec<Body> {
    let base = &robot.base.collisions;
    let name = base.first().map_or("base", |c| &c.link);
    let mut found = vec![body(name, None, base, &[], directory)];
    for (j, link) in robot.links.iter().enumerate() {
        let own = [(link.name.clone(), link.file_frame)];
        let frames = if link.frames.is_empty() { &own[..] } else { &link.frames[..] };
        found.push(body(&link.name, Some(j), &link.collisions, frames, directory));
    }
    found
}

fn body(name: &str, link: Option<usize>, given: &[Collision], frames: &[(String, Pose)], directory: &Path) -> Body {
    let (mut shapes, mut missing) = (Vec::new(), Vec::new());
    for collision in given {
        match solid(collision, directory) {
            Ok(solid) => shapes.push(Shape::new(&collision.link, solid, collision.pose)),
            Err(why) => missing.push(format!("{}: {why}", collision.link)),
        }
    }
    let has_geometry = !given.is_empty();
    if !has_geometry {
        let point = || Solid { core: Core::Point, radius: 0.0 };
        shapes.extend(frames.iter().map(|(frame, pose)| Shape::new(frame, point(), *pose)));
    }
    Body { name: name.to_string(), link, shapes, has_geometry, missing }
}

fn solid(collision: &Collision, directory: &Path) -> Result<Solid, String> {
    match &collision.shape {
        CollisionShape::Unread { reason } => Err(reason.clone()),
        CollisionShape::Mesh { file, scale } => {
            let path = mesh_path(file, directory).map_err(|what| format!("mesh {file}: {what}"))?;
            let points = vertices(&path).map_err(|what| format!("mesh {file}: {what}"))?;
            let points: Vec<Vector3> = points.iter().map(|p| [0, 1, 2].map(|k| scale[k] * p[k])).collect();
            Solid::around(&points).ok_or_else(|| format!("mesh {file}: it has no vertex"))
        }
        shape => Solid::of_primitive(shape).ok_or_else(|| "its shape is not known".to_string()),
    }
}
