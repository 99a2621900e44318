//! A measured motion, from which spectral equations are computed: positions, velocities and accelerations over whole periods.

use linear_model::regressor::Regressor;

use crate::motion::reference_motion::Reference;

/// A measured motion: positions, velocities and accelerations, one series of samples per coordinate.
#[derive(Clone, Debug, Default)]
pub struct MeasuredMotion {
    /// Positions, rad (m), one series per coordinate.
    pub q: Vec<Vec<f64>>,
    /// Velocities, rad/s (m/s), one series per coordinate.
    pub dq: Vec<Vec<f64>>,
    /// Accelerations, rad/s^2 (m/s^2), one series per coordinate.
    pub ddq: Vec<Vec<f64>>,
}

/// Number of instants for which one call evaluates the regressor.
pub const INSTANTS_PER_PASS: usize = 64;

impl MeasuredMotion {
    /// Takes the samples of a reference motion that are inside its windows.
    pub fn of_reference(reference: &Reference) -> MeasuredMotion {
        let cut = |x: &Vec<Vec<f64>>| {
            let one = |x: &Vec<f64>| reference.windows.iter().flat_map(|w| x[w.clone()].iter().copied()).collect();
            x.iter().map(one).collect()
        };
        MeasuredMotion { q: cut(&reference.q), dq: cut(&reference.dq), ddq: cut(&reference.ddq) }
    }

    /// Computes velocities and accelerations from positions `q` over whole periods with sample time `h` (s) by periodic central
    /// differences.
    pub fn by_differences(q: &[Vec<f64>], h: f64) -> MeasuredMotion {
        let (dq, ddq) = q.iter().map(|q| numerics::fourier::circular_differences(q, h)).unzip();
        MeasuredMotion { q: q.to_vec(), dq, ddq }
    }

    /// Computes velocities and accelerations from one period of positions per coordinate with sample time `h`, s. Only harmonics
    /// up to `highest` are kept.
    pub fn by_harmonics(period: &[Vec<f64>], h: f64, highest: usize) -> MeasuredMotion {
        let mut motion = MeasuredMotion::default();
        for q in period {
            let [q, dq, ddq] = numerics::fourier::harmonic_derivatives(q, h, highest);
            motion.q.push(q);
            motion.dq.push(dq);
            motion.ddq.push(ddq);
        }
        motion
    }

    /// Number of instants (samples) of the motion.
    pub fn len(&self) -> usize {
        self.q.first().map_or(0, Vec::len)
    }

    /// Whether there are no instants.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The columns of the regressor Y over time, for each joint: `columns[joint][parameter][instant]`.
    pub fn regressor_columns(&self, regressor: &dyn Regressor) -> Vec<Vec<Vec<f64>>> {
        let (n, p, count) = (self.q.len(), regressor.parameters().len(), self.len());
        let mut columns = vec![vec![vec![0.0; count]; p]; n];
        let mut y = vec![0.0; INSTANTS_PER_PASS * n * p];
        let mut states = Vec::with_capacity(INSTANTS_PER_PASS * 3 * n);
        for first in (0..count).step_by(INSTANTS_PER_PASS) {
            let instants = first..count.min(first + INSTANTS_PER_PASS);
            states.clear();
            for i in instants.clone() {
                states.extend([&self.q, &self.dq, &self.ddq].into_iter().flatten().map(|x| x[i]));
            }
            let y = &mut y[..instants.len() * n * p];
            regressor.fill_many(&states, y);
            for j in 0..n {
                for c in 0..p {
                    let column = &mut columns[j][c][instants.clone()];
                    column.iter_mut().zip(y.chunks_exact((n * p).max(1))).for_each(|(x, y)| *x = y[j * p + c]);
                }
            }
        }
        columns
    }
}
