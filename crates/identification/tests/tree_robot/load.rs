//! R3G with a load on its forearm.

use identification::model::regressor::Regressor;

use crate::tree_robot::{TreeRobot, link_at};

/// R3G with `mass` kg at (0.35, 0.02, 0.03) m in the frame of its third link, 1e-3 kg m^2 about each axis of its
/// own; and what that adds to the base parameters.
pub fn with_load(robot: &TreeRobot, mass: f64) -> (TreeRobot, Vec<f64>) {
    let load = link_at(mass, [0.35, 0.02, 0.03], [1e-3, 0.0, 0.0, 1e-3, 0.0, 1e-3]);
    let mut links = robot.links.clone();
    links[2].standard.iter_mut().zip(load).for_each(|(x, l)| *x += l);
    let names: Vec<&str> = robot.coordinates().iter().map(String::as_str).collect();
    let loaded = TreeRobot::new(links, robot.gravity, &names);
    let added = loaded.truth.iter().zip(&robot.truth).map(|(a, b)| a - b).collect();
    (loaded, added)
}
