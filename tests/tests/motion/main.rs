//! Tests of motions and plans: search, proof, independent checks, refusals.

mod bodies;
mod checked_points;
mod checkers;
mod described_limits;
mod every_robot;
mod impossible_motions;
mod kept_room;
mod known_arms;
mod promise;
mod second_motion;
mod shipped_models;
mod spline_motion;
mod tampered_motions;
