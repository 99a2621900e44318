//! The bodies of a robot, and their distances from each other and from walls.
//!
//! [`bodies`] makes convex solids of the collision geometry of a [`robot::Robot`]; [`clearance::Clearance`] computes their
//! distances at a configuration, and lower bounds of the distances near it.
//!
//! Lengths in m, angles in rad, all in the base frame unless stated otherwise. Not here: motions, and their evaluation.

#![warn(missing_docs)]

pub mod bodies;
pub mod body_errors;
pub mod clearance;
mod crowded;
pub mod gaps;
pub mod half_space;
pub mod hull;
pub mod kinematic_tree;
pub mod mesh;
mod named_links;
pub mod nearby;
pub mod outside;
mod pieces;
mod rules;
pub mod sampled_room;
pub mod separation;
pub mod shown_length;
pub mod solid;
mod unknown_links;
mod walls;
