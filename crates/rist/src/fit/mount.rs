//! Computes the torques that a tilt of the base causes. A tilt rotates gravity about axes of the base.
//!
//! A small rotation a (rad) of the base about its axis e changes gravity g in the frame of the base by (e x g) a. The torques
//! per radian are the torques of the described bodies at rest under the acceleration e x g. A rotation about gravity itself has
//! no effect, so there are two axes, both perpendicular to gravity: the two axes of the base that are farthest from gravity,
//! made orthogonal to gravity and to each other.

use std::cell::RefCell;

use expr::{Tape, Workspace};
use modeling::Derivation;
use nalgebra::Vector3;
use robot::value::Value;
use robot::{Robot, StandardParameter};

/// Two orthogonal axes perpendicular to gravity (which is not zero), in the frame of the base, each with the number of the
/// nearest axis of the base.
pub fn axes(gravity: &Vector3<f64>) -> [(usize, Vector3<f64>); 2] {
    let along = gravity.normalize();
    let across = |axis: usize, others: &[Vector3<f64>]| {
        others.iter().fold(Vector3::ith(axis, 1.0), |e, other| e - other * e.dot(other)).normalize()
    };
    let [i, j] = [[1, 2], [0, 2], [0, 1]][along.iamax()];
    let first = across(i, &[along]);
    [(i, first), (j, across(j, &[along, first]))]
}

/// The torques per radian of tilt about one axis.
pub struct Tilt {
    tape: Tape,
    work: RefCell<Workspace>,
    bodies: Vec<f64>,
    n: usize,
}

impl Tilt {
    /// Tilts about the two axes perpendicular to gravity, each with the number of the nearest axis of the base. Empty if no
    /// link has inertial parameters, or if loops are solved numerically. `changes`: values added to the described parameters.
    pub(crate) fn both(robot: &Robot, changes: &[(StandardParameter, f64)]) -> Vec<(usize, Tilt)> {
        let is_described = robot.links.iter().any(|link| link.inertial.is_some());
        let gravity = Vector3::from(robot.gravity_number());
        if !is_described || !robot.passive.is_empty() || gravity.norm() == 0.0 {
            return Vec::new();
        }
        let turned = axes(&gravity).into_iter().map(|(axis, e)| (axis, e.cross(&gravity).into()));
        let mut tilts: Vec<(usize, Tilt)> = turned.filter_map(|(axis, g)| Some((axis, Tilt::of(robot, g)?))).collect();
        let places: Vec<StandardParameter> = StandardParameter::all(robot).into_iter().collect();
        for (parameter, change) in changes {
            let place = places.iter().position(|p| p == parameter);
            place.into_iter().for_each(|i| tilts.iter_mut().for_each(|(_, tilt)| tilt.bodies[i] += change));
        }
        tilts
    }

    /// The torques at rest under `gravity`, m/s^2 in the frame of the base; `None` if the derivation fails.
    pub fn of(robot: &Robot, gravity: [f64; 3]) -> Option<Tilt> {
        let mut turned = robot.clone();
        turned.gravity = gravity.map(Value::Number);
        let mut derivation = Derivation::new(&turned).ok()?;
        let tape = Tape::new(&derivation.torque().bound());
        let value = |p: StandardParameter| p.value(robot).unwrap_or(0.0);
        let bodies = StandardParameter::all(robot).into_iter().map(value).collect();
        Some(Tilt { work: RefCell::new(tape.workspace()), tape, bodies, n: robot.n_coordinates() })
    }

    /// Torque per radian of tilt at the position `q`, one per coordinate, N m (N) per rad.
    pub fn torques(&self, q: &[f64]) -> Vec<f64> {
        let at_rest = std::iter::repeat_n(0.0, 2 * self.n);
        let inputs: Vec<f64> = q.iter().copied().chain(at_rest).chain(self.bodies.iter().copied()).collect();
        let mut torques = vec![0.0; self.tape.n_outputs()];
        self.tape.evaluate(&inputs, &mut self.work.borrow_mut(), &mut torques);
        torques
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tilt_is_a_turned_gravity() {
        let puma = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/puma560.yaml");
        let robot = crate::describe::description::read_robot(puma.as_ref(), &Default::default()).unwrap();
        let tilts = Tilt::both(&robot, &[]);
        let zero = Tilt::of(&robot, robot.gravity_number()).unwrap();
        let angle = 1e-6;
        let [x, y, z] = robot.gravity_number();
        for (k, turned) in
            [[x, y - angle * z, z + angle * y], [x + angle * z, y, z - angle * x]].into_iter().enumerate()
        {
            let turned = Tilt::of(&robot, turned).unwrap();
            for q in [[0.3, -0.4, 0.5, 1.0, 2.0, -1.0], [1.0, 2.0, -2.0, 0.1, 0.2, 0.3]] {
                for j in 0..6 {
                    let found = (turned.torques(&q)[j] - zero.torques(&q)[j]) / angle;
                    // Tolerance: differences over 1e-6 rad, of torques of some ten N m with nine correct digits.
                    assert!((found - tilts[k].1.torques(&q)[j]).abs() < 1e-6 * 50.0, "{k} {q:?} {j}");
                }
            }
        }
    }
}
