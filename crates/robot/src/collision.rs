//! The collision geometry of a link, from its file.
//!
//! The pose of a shape is in the frame of the link that carries it, which is not the frame of the file. Mesh files are not
//! read here, and distances between shapes are not computed here.

use crate::inertial::Pose;

/// One shape of a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Collision {
    /// The link of the file to which it belongs: several links of the file may be fixed to one moving link.
    pub link: String,
    /// The pose of the shape's frame in the link frame.
    pub pose: Pose,
    /// The shape, in its own frame.
    pub shape: CollisionShape,
}

/// A shape about its own frame; lengths in m.
#[derive(Clone, Debug, PartialEq)]
pub enum CollisionShape {
    /// A cuboid about the origin.
    Box {
        /// Whole lengths along x, y, z.
        size: [f64; 3],
    },
    /// A cylinder along z, its middle at the origin.
    Cylinder {
        /// Radius of the circle.
        radius: f64,
        /// Length from end to end.
        length: f64,
    },
    /// A cylinder along z with half a ball at each end, its middle at the origin.
    Capsule {
        /// Radius of the cylinder and of the balls.
        radius: f64,
        /// Length of the cylinder.
        length: f64,
    },
    /// A ball about the origin.
    Sphere {
        /// Radius of the ball.
        radius: f64,
    },
    /// The vertices of a mesh file.
    Mesh {
        /// The file name in the description.
        file: String,
        /// Factors along x, y, z of the mesh.
        scale: [f64; 3],
    },
    /// A shape that could not be read.
    Unread {
        /// The reason: the place, what was found and what was expected.
        reason: String,
    },
}
