//! The torques by which a tilted base shows: those of gravity that is turned about the axes of the base.
//!
//! A small turn a of the base about its axis e turns gravity g, seen from the base, by e x g a. The torques that follow are
//! those of the description's bodies at rest under the acceleration e x g.

use std::cell::RefCell;

use expr::{Tape, Workspace};
use modeling::Derivation;
use robot::value::Value;
use robot::{Robot, StandardParameter};

/// The torques per radian of one axis.
pub(crate) struct Tilt {
    tape: Tape,
    work: RefCell<Workspace>,
    bodies: Vec<f64>,
    n: usize,
}

impl Tilt {
    /// About x and y of the base; none for a robot without described bodies, and for one whose loops are solved
    /// numerically.
    pub(crate) fn both(robot: &Robot) -> Vec<Tilt> {
        let is_described = robot.links.iter().any(|link| link.inertial.is_some());
        if !is_described || !robot.passive.is_empty() {
            return Vec::new();
        }
        let [x, y, z] = robot.gravity_number();
        [[0.0, -z, y], [z, 0.0, -x]].into_iter().filter_map(|g| Tilt::of(robot, g)).collect()
    }

    /// Of gravity as given, m/s^2 in the frame of the base, per unit of 1.
    pub(crate) fn of(robot: &Robot, gravity: [f64; 3]) -> Option<Tilt> {
        let mut turned = robot.clone();
        turned.gravity = gravity.map(Value::Number);
        let mut derivation = Derivation::new(&turned).ok()?;
        let tape = Tape::new(&derivation.torque().bound());
        let value = |p: StandardParameter| p.value(robot).unwrap_or(0.0);
        let bodies = StandardParameter::all(robot).into_iter().map(value).collect();
        Some(Tilt { work: RefCell::new(tape.workspace()), tape, bodies, n: robot.n_coordinates() })
    }

    /// N m (N) per rad, one per coordinate, at the position `q`.
    pub(crate) fn torques(&self, q: &[f64]) -> Vec<f64> {
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

    /// The torques of a robot whose gravity is turned, less those as it is, are those of the tilt.
    #[test]
    fn a_tilt_is_a_turned_gravity() {
        let puma = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/puma560.yaml");
        let robot = crate::description::read_robot(puma.as_ref(), &Default::default()).unwrap();
        let tilts = Tilt::both(&robot);
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
                    // Torques of some ten N m, of which differences of a millionth keep nine digits.
                    assert!((found - tilts[k].torques(&q)[j]).abs() < 1e-6 * 50.0, "{k} {q:?} {j}");
                }
            }
        }
    }
}
