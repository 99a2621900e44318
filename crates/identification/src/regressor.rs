//! The one interface through which identification sees a robot's dynamics.

/// The base regressor of a robot: tau = Y(q, dq, ddq) X, friction not included.
///
/// `q`, `dq`, `ddq`: one entry a coordinate, rad, rad/s, rad/s^2 (m for a prismatic joint). `y`:
/// n x p, row by row: `y[i * p + c]` is the torque of coordinate i per unit of parameter c.
pub trait Regressor: Sync {
    /// The coordinates, in the order of q.
    fn coordinates(&self) -> &[String];

    /// The base parameters, in the order of the columns: `ZZR1`, `XXR2`, ...
    fn parameters(&self) -> &[String];

    /// Writes Y at one instant. `y` has coordinates().len() * parameters().len() entries.
    fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]);
}
