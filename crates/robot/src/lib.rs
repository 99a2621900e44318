//! The description of a robot, and the files that hold it.
//!
//! A [`Robot`] is a tree of links in Khalil-Kleinfinger frames, cut where it closes on itself.
//! Every file format ends in the same `Robot`; algorithms read it and never change it.
//!
//! [Khalil, Kleinfinger 1986]: iTj = Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r).

#![warn(missing_docs)]

mod agreement;
mod angle_snap;
mod assembly;
pub mod closure;
mod collision;
pub mod convention;
mod error;
mod finding;
mod floating;
pub mod format;
mod habits;
mod inertial;
pub mod kinematics;
mod linear_angle;
pub mod lint;
mod locked;
pub mod mesh;
mod parameter;
mod passive;
mod polygon;
mod principal;
mod relation;
mod robot;
pub mod value;
pub mod vector;
pub mod xml_bounds;

pub use collision::{Collision, CollisionShape};
pub use error::{Error, Place};
pub use habits::DEGREES_LIMIT_RAD;
pub use inertial::{Matrix3, Part, Pose, inertial_matrix, transform_inertial};
pub use parameter::{Inertial, StandardParameter};
pub use robot::{
    Coordinate, Drive, Format, Friction, Joint, JointKind, Limits, Link, LinkId, Loop, LoopFrame, ModifiedDh, Note,
    PassiveCoordinate, Robot, RotorInertia,
};
pub use value::{Affine, CoordinateId, Symbol, SymbolId, Value};
