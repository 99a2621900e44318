//! Samples of one record, ready for the regressor.

use crate::friction::terms::FrictionTerm;

/// The columns of a friction term behind the filter of the torques.
#[derive(Clone, Debug)]
pub struct FilteredFriction {
    /// The term.
    pub term: FrictionTerm,
    /// Sample by sample, joint by joint, as many as the term has parameters.
    pub columns: Vec<f64>,
}

/// Samples ready for the regressor: row r of each n-column array is one instant.
#[derive(Clone, Debug, Default)]
pub struct States {
    /// Number of coordinates.
    pub n: usize,
    /// Which of the logs the record is of, from 0.
    pub log: usize,
    /// s, one per instant.
    pub t: Vec<f64>,
    /// rad (m); sample by sample, n each, as the series below.
    pub q: Vec<f64>,
    /// rad/s (m/s).
    pub dq: Vec<f64>,
    /// rad/s^2 (m/s^2).
    pub ddq: Vec<f64>,
    /// N m (N).
    pub tau: Vec<f64>,
    /// sign(dq), or that sign after the filter.
    pub direction: Vec<f64>,
    /// Directions of coupled motors, one per coupling, sample by sample.
    pub motor_direction: Vec<f64>,
    /// Columns of friction that were filtered as a whole; other terms are computed sample by sample.
    pub friction: Vec<FilteredFriction>,
    /// Torque of the bodies that an earlier fit predicts, N m (N), n each; empty where no friction grows with it.
    pub load: Vec<f64>,
    /// Whether the row of joint j at sample r counts.
    pub used: Vec<bool>,
    /// Cut-off of positions and velocities in force, Hz; 0: none.
    pub cutoff: f64,
    /// Cut-off of the torques in force, Hz; 0: none.
    pub effort_cutoff: f64,
    /// Time between samples, s.
    pub period: f64,
    /// Frequency below which 95 % of the energy of a coordinate's velocity lies, Hz, one per coordinate.
    pub f95: Vec<f64>,
}

impl States {
    /// Number of instants.
    #[inline]
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// The filtered columns of each of these terms; `None` where a term has none.
    pub fn filtered(&self, terms: &[FrictionTerm]) -> Vec<Option<&[f64]>> {
        let of = |term: &FrictionTerm| self.friction.iter().find(|f| f.term == *term).map(|f| f.columns.as_slice());
        terms.iter().map(of).collect()
    }

    /// The torque that a term of a single joint grows with, zero where none was predicted; `None` for other terms.
    #[inline]
    pub(crate) fn torque_of_friction(&self, term: FrictionTerm, r: usize, j: usize) -> Option<f64> {
        term.is_of_one_joint().then(|| self.load.get(r * self.n + j).copied().unwrap_or(0.0))
    }

    /// Joins records of one robot that were prepared alike; where there is one number only, it is that of the first.
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

    /// Bytes of the series.
    pub fn bytes(&self) -> usize {
        let of_terms = self.friction.iter().map(|term| &term.columns);
        let series =
            [&self.t, &self.q, &self.dq, &self.ddq, &self.tau, &self.direction, &self.motor_direction, &self.load];
        let numbers: usize = series.into_iter().chain(of_terms).map(Vec::len).sum();
        numbers * size_of::<f64>() + self.used.len()
    }

    /// Whether there is no instant.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }
}
