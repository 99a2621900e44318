//! Samples of one record, as inputs of the regressor.

use crate::friction::terms::FrictionTerm;

/// The columns of a friction term after the filter of the torques.
#[derive(Clone, Debug)]
pub struct FilteredFriction {
    /// The term.
    pub term: FrictionTerm,
    /// Columns by sample and joint, one per parameter of the term.
    pub columns: Vec<f64>,
}

/// Samples as inputs of the regressor: row r of each n-column array is one sample.
#[derive(Clone, Debug, Default)]
pub struct States {
    /// Number of coordinates.
    pub n: usize,
    /// Number of the log of the record, from 0.
    pub log: usize,
    /// Times, s, one per sample.
    pub t: Vec<f64>,
    /// Positions, rad (m); sample by sample, n each, as the series below.
    pub q: Vec<f64>,
    /// Velocities, rad/s (m/s).
    pub dq: Vec<f64>,
    /// Accelerations, rad/s^2 (m/s^2).
    pub ddq: Vec<f64>,
    /// Torques, N m (N).
    pub tau: Vec<f64>,
    /// sign(dq), or that sign after the filter.
    pub direction: Vec<f64>,
    /// Directions of coupled motors, one per coupling, sample by sample.
    pub motor_direction: Vec<f64>,
    /// Friction columns that were filtered as a whole; columns of other terms are computed sample by sample.
    pub friction: Vec<FilteredFriction>,
    /// Torque of the bodies predicted by an earlier fit, N m (N), n each; empty without load-dependent friction.
    pub load: Vec<f64>,
    /// Whether the row of joint j at sample r is used.
    pub used: Vec<bool>,
    /// Cut-off of positions and velocities, Hz; 0: none.
    pub cutoff: f64,
    /// Cut-off of the torques, Hz; 0: none.
    pub effort_cutoff: f64,
    /// Time between samples, s.
    pub period: f64,
    /// Frequency below which 95 % of the energy of a coordinate's velocity lies, Hz, one per coordinate.
    pub f95: Vec<f64>,
}

impl States {
    /// Number of samples.
    #[inline]
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// The filtered columns of each of these terms; `None` for a term without filtered columns.
    pub fn filtered(&self, terms: &[FrictionTerm]) -> Vec<Option<&[f64]>> {
        let of = |term: &FrictionTerm| self.friction.iter().find(|f| f.term == *term).map(|f| f.columns.as_slice());
        terms.iter().map(of).collect()
    }

    /// The load of a term of a single joint, N m (N), zero where none was predicted; `None` for other terms.
    #[inline]
    pub(crate) fn torque_of_friction(&self, term: FrictionTerm, r: usize, j: usize) -> Option<f64> {
        term.is_of_one_joint().then(|| self.load.get(r * self.n + j).copied().unwrap_or(0.0))
    }

    /// Joins records of one robot with equal preparation; single numbers come from the first record.
    pub fn joined(records: &[States]) -> States {
        let mut all = records.first().cloned().unwrap_or_default();
        for states in records.iter().skip(1) {
            all.t.extend(&states.t);
            for (all, more) in [
                (&mut all.q, &states.q),
                (&mut all.dq, &states.dq),
                (&mut all.ddq, &states.ddq),
                (&mut all.tau, &states.tau),
                (&mut all.direction, &states.direction),
                (&mut all.motor_direction, &states.motor_direction),
                (&mut all.load, &states.load),
            ] {
                all.extend(more);
            }
            for (all, more) in all.friction.iter_mut().zip(&states.friction) {
                all.columns.extend(&more.columns);
            }
            all.used.extend(&states.used);
        }
        all
    }

    /// Size of the series, bytes.
    pub fn bytes(&self) -> usize {
        let of_terms = self.friction.iter().map(|term| &term.columns);
        let series =
            [&self.t, &self.q, &self.dq, &self.ddq, &self.tau, &self.direction, &self.motor_direction, &self.load];
        let numbers: usize = series.into_iter().chain(of_terms).map(Vec::len).sum();
        numbers * size_of::<f64>() + self.used.len()
    }

    /// Whether there is no sample.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }
}
