//! The model of a robot, and the file formats of robot descriptions.
//!
//! A [`Robot`] is a tree of links in Khalil-Kleinfinger frames, with a cut in each loop. Every file format is converted to a
//! `Robot`. Algorithms do not change this robot.
//!
//! [Khalil, Kleinfinger 1986]: iTj = Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r).

#![warn(missing_docs)]

mod agreement;
mod angle_snap;
mod assembly;
mod body;
mod body_doubt;
pub mod closure;
mod collision;
pub mod convention;
mod error;
mod extent;
mod finding;
mod floating;
pub mod format;
mod gravity_load;
mod inertial;
mod inertial_conventions;
mod inertial_repair;
pub mod kinematics;
mod linear_angle;
pub mod lint;
mod locked;
pub mod mesh;
mod mirror_comparison;
pub mod mirror_pairs;
mod parameter;
mod passive;
mod polygon;
mod principal;
mod relation;
mod relative_density;
mod robot;
mod substitute;
pub mod value;
pub mod vector;
pub mod xml_bounds;

pub use collision::{Collision, CollisionShape};
pub use error::{Error, Place};
pub use inertial::{Matrix3, Part, Pose, inertial_matrix, transform_inertial, turned_inertia};
pub use inertial_conventions::DEGREES_LIMIT_RAD;
pub use parameter::{Inertial, StandardParameter};
pub use robot::{
    Coordinate, Drive, Format, Friction, Joint, JointKind, Limits, Link, LinkId, Loop, LoopFrame, ModifiedDh, Note,
    PassiveCoordinate, Robot, RotorInertia,
};
pub use value::{Affine, CoordinateId, Symbol, SymbolId, Value};
