//! The collision geometry of a link, as its file describes it.
//!
//! A shape stands in the frame of the link that carries it, which is not the frame of the file. Not here: the files of
//! meshes, and distances between shapes.

use crate::inertial::Pose;

/// One shape of a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Collision {
    /// The link of the file that it belongs to: several may be fixed to one that moves.
    pub link: String,
    /// Its own frame in the link frame.
    pub pose: Pose,
    /// What it is, about its own frame.
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
        /// Of the round.
        radius: f64,
        /// From end to end.
        length: f64,
    },
    /// A cylinder along z with half a ball at each end, its middle at the origin.
    Capsule {
        /// Of the round and of the balls.
        radius: f64,
        /// Of the cylinder.
        length: f64,
    },
    /// A ball about the origin.
    Sphere {
        /// Of the ball.
        radius: f64,
    },
    /// The vertices of a file of its own.
    Mesh {
        /// As the description names it.
        file: String,
        /// Factors along x, y, z of the mesh.
        scale: [f64; 3],
    },
    /// A shape that could not be read.
    Unread {
        /// Why: where it stands, what was found and what was expected.
        reason: String,
    },
}
