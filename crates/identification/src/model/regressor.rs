//! The one interface through which identification sees a robot's dynamics.

use crate::model::parameter::BaseParameter;

/// A coordinate of a robot: its name, and whether it is a length.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Coordinate {
    /// As the description names it.
    pub name: String,
    /// Whether it is a length, not an angle.
    pub is_prismatic: bool,
}

/// The base regressor of a robot: tau = Y(q, dq, ddq) X, friction not included.
///
/// `q`, `dq`, `ddq`: one entry a coordinate, rad, rad/s, rad/s^2 (m for a prismatic joint). `y`:
/// n x p, row by row: `y[i * p + c]` is the torque of coordinate i per unit of parameter c.
pub trait Regressor: Sync {
    /// The coordinates, in the order of q.
    fn coordinates(&self) -> &[String];

    /// The base parameters, in the order of the columns: `ZZR1`, `XXR2`, ...
    fn parameters(&self) -> &[BaseParameter];

    /// Whether coordinate k is a length, not an angle. Units, and the limit of little motion, follow from it.
    fn is_prismatic(&self, _k: usize) -> bool {
        false
    }

    /// Writes Y at one instant. `y` has coordinates().len() * parameters().len() entries.
    fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]);

    /// Writes Y at many instants, one after the other: `states` holds q, dq, ddq of one instant after
    /// the other. A regressor that computes several at a time overrides this.
    fn fill_many(&self, states: &[f64], y: &mut [f64]) {
        let n = self.coordinates().len();
        let size = n * self.parameters().len();
        if size == 0 {
            return;
        }
        for (s, y) in states.chunks_exact(3 * n).zip(y.chunks_exact_mut(size)) {
            self.fill(&s[..n], &s[n..2 * n], &s[2 * n..], y);
        }
    }
}
