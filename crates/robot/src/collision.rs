//! The collision geometry of a link, as the description file gives it.
//!
//! The pose of a shape is relative to the frame of the moving link that carries it. In general, this frame is not the frame that
//! the file uses. Mesh files are not read here, and distances between shapes are not computed here.

use crate::inertial::Pose;

/// One collision shape of a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Collision {
    /// Name of the link of the file to which the shape belongs. Several links of the file may be fixed to one moving link.
    pub link: String,
    /// Pose of the shape's frame in the frame of the moving link.
    pub pose: Pose,
    /// The shape and its dimensions, relative to its own frame.
    pub shape: CollisionShape,
}

/// A collision shape, relative to its own frame; lengths in m.
#[derive(Clone, Debug, PartialEq)]
pub enum CollisionShape {
    /// A cuboid with its centre at the origin.
    Box {
        /// Full edge lengths along x, y and z.
        size: [f64; 3],
    },
    /// A cylinder along z with its centre at the origin.
    Cylinder {
        /// Radius of the cylinder.
        radius: f64,
        /// Full length of the cylinder.
        length: f64,
    },
    /// A cylinder along z with a half ball at each end, and its centre at the origin.
    Capsule {
        /// Radius of the cylinder and of the half balls.
        radius: f64,
        /// Length of the cylinder without the half balls.
        length: f64,
    },
    /// A ball with its centre at the origin.
    Sphere {
        /// Radius of the ball.
        radius: f64,
    },
    /// A mesh from a file.
    Mesh {
        /// Name of the mesh file, as written in the description.
        file: String,
        /// Scale factors along x, y and z of the mesh.
        scale: [f64; 3],
    },
    /// A shape that could not be read from the description.
    Unread {
        /// The reason why the shape could not be read: the place, what was found, and what was expected.
        reason: String,
    },
}
