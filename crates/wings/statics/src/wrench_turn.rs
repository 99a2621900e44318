//! Estimates the rotation between the axes of a force-torque sensor and the frame of its poses, from the forces.
//!
//! Q: rotation from the axes of the sensor to the axes of the poses; R, p: orientation and position of the poses; F: force; g:
//! gravity. The momentum equation of `wrench_load`, divided by the mass m, is
//! ```text
//! R (Q/m) F + R b - d2/dt2 (R c) = d2/dt2 p - g
//! ```
//! The equation is linear in Q/m, the offset b and the centre of mass c. Q is the rotation nearest to the least squares
//! solution of Q/m [Golub, Van Loan 2013]. A negative m means that the sensor gives the wrench of the load on the sensor.

use crate::wrenches::Wrenches;
use nalgebra::Matrix3;
use numerics::least_squares::solve;
use numerics::triangle::TriangleBuilder;

use crate::wrench_load::{GRAVITY, Window, spans};

/// Number of unknowns: nine of Q/m, three offsets, and three coordinates of the centre of mass.
const UNKNOWNS: usize = 15;

/// The rotation of the sensor's axes in the frame of the poses: roll, pitch and yaw (rad) in Rz(yaw) Ry(pitch) Rx(roll). `None`
/// if the log does not determine this rotation.
pub(crate) fn sensor_turn(log: &Wrenches) -> Option<[f64; 3]> {
    let mut block = TriangleBuilder::new(UNKNOWNS);
    // Windows with an even weight function, as for the load. A posture is a window of one sample.
    let windows: Vec<Window> = match log.t.is_empty() {
        true => (0..log.force.len())
            .map(|first| Window { first, samples: vec![(1.0, 0.0, 0.0)], point: [0.0; 3] })
            .collect(),
        false => spans(log).into_iter().map(|(first, last)| Window::of(log, first, last, false)).collect(),
    };
    for window in &windows {
        for i in 0..3 {
            // The momentum equation, integrated by parts over a window with the weight function f: f R (Q/m) F + f R b - f'' R
            // c = f'' p - f g.
            let (mut row, mut y) = ([0.0; UNKNOWNS], 0.0);
            for (k, &(f, _, dd)) in (window.first..).zip(&window.samples) {
                for (a, &r) in log.rotation[k][i].iter().enumerate() {
                    (0..3).for_each(|b| row[3 * a + b] += f * r * log.force[k][b]);
                    row[9 + a] += f * r;
                    row[12 + a] -= dd * r;
                }
                y += dd * (log.position[k][i] - window.point[i]) - if i == 2 { f * GRAVITY } else { 0.0 };
            }
            block.push(&row, y);
        }
    }
    let found = solve(&block.finish());
    if !found.determined[..9].iter().all(|is| *is) || !found.x.iter().all(|x| x.is_finite()) {
        return None;
    }
    // The nearest rotation is U V' from the singular value decomposition, multiplied by the sign with which its determinant is
    // 1.
    let svd = Matrix3::from_row_slice(&found.x[..9]).svd(true, true);
    let q = svd.u? * svd.v_t?;
    let q = q * q.determinant().signum();
    Some([q[(2, 1)].atan2(q[(2, 2)]), (-q[(2, 0)]).clamp(-1.0, 1.0).asin(), q[(1, 0)].atan2(q[(0, 0)])])
}
