//! The regressor Y: the interface through which identification uses the dynamics of a robot, tau = Y(q, dq, ddq) X. X: base
//! parameters, the smallest set of inertial parameters that determines the torques tau.

pub use generated::Eight;

use crate::parameter::BaseParameter;
use crate::states::States;

/// A coordinate of a robot: its name, and whether it is a length or an angle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Coordinate {
    /// The name of the coordinate in the description.
    pub name: String,
    /// Whether the coordinate is a length and not an angle.
    pub is_prismatic: bool,
}

/// The base regressor of a robot: tau = Y(q, dq, ddq) X, friction not included.
///
/// `q`, `dq`, `ddq`: one entry per coordinate, rad, rad/s, rad/s^2 (m for a prismatic joint). `y`: n x p, row by row:
/// `y[i * p + c]` is the torque of coordinate i, N m (N), per unit of parameter c.
pub trait Regressor: Sync {
    /// The coordinates, in the order of q.
    fn coordinates(&self) -> &[String];

    /// The base parameters, in the order of the columns: `ZZR1`, `XXR2`, ...
    fn parameters(&self) -> &[BaseParameter];

    /// Whether coordinate k is a length and not an angle. This determines units and thresholds of motion.
    fn is_prismatic(&self, _k: usize) -> bool {
        false
    }

    /// Writes Y at one state. `y` has coordinates().len() * parameters().len() entries.
    fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]);

    /// Writes Y at many states, one after the other. `states`: q, dq and ddq of each state. A regressor that can compute several
    /// states at once overrides this function.
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

    /// Row and column of each entry of Y that is not always zero, row by row. By default all entries.
    fn non_zeros(&self) -> Vec<(usize, usize)> {
        let p = self.parameters().len();
        (0..self.coordinates().len()).flat_map(|i| (0..p).map(move |c| (i, c))).collect()
    }

    /// Writes the entries listed by `non_zeros` at many states, eight states in SIMD lanes.
    ///
    /// `blocks[g * stride + e]` is entry e of states 8 g .. 8 g + 7. `states` has q, dq and ddq of each state; the number of
    /// states is a multiple of eight. A regressor that can compute eight states at once overrides this function.
    fn fill_blocks(&self, states: &[f64], stride: usize, blocks: &mut [Eight]) {
        let (n, p, non_zeros) = (self.coordinates().len(), self.parameters().len(), self.non_zeros());
        if n == 0 {
            return;
        }
        let mut y = vec![0.0; states.len() / (3 * n) * n * p];
        self.fill_many(states, &mut y);
        for (y, group) in y.chunks_exact((8 * n * p).max(1)).zip(blocks.chunks_mut(stride)) {
            for (eight, (i, c)) in group.iter_mut().zip(&non_zeros) {
                eight.0 = std::array::from_fn(|l| y[l * n * p + i * p + c]);
            }
        }
    }
}

/// Computes the torques Y X at all states, N m (N), and stores them in `states.load`. `base`: the base parameters X.
pub fn predict_load(regressor: &dyn Regressor, states: &mut States, base: &[f64]) {
    let (n, p) = (states.n, base.len());
    let (mut inputs, mut y) = (vec![0.0; 3 * n], vec![0.0; n * p]);
    states.load.clear();
    for r in 0..states.len() {
        for (input, x) in inputs.chunks_exact_mut(n.max(1)).zip([&states.q, &states.dq, &states.ddq]) {
            input.copy_from_slice(&x[r * n..(r + 1) * n]);
        }
        regressor.fill_many(&inputs, &mut y);
        let torque = |row: &[f64]| row.iter().zip(base).map(|(y, x)| y * x).sum::<f64>();
        states.load.extend((0..n).map(|j| torque(&y[j * p..(j + 1) * p])));
    }
}
