//! The bodies of a robot, and their distances from each other and from walls.
//!
//! [`bodies`] converts the collision geometry of a [`robot::Robot`] to convex solids. [`clearance::Clearance`] computes the
//! distances between them at a configuration, and lower bounds of the distances near this configuration.
//!
//! Lengths are in m and angles in rad, in the base frame unless stated otherwise. Not here: motions, and their evaluation.

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
