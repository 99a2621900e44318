//! States: the samples of one record (segment of a log), as inputs of the model: q, dq, ddq, measured torques tau, and the
//! direction of motion of each joint.

use crate::friction::terms::FrictionTerm;

/// The columns of one friction term for one record, low-pass filtered like the torques.
#[derive(Clone, Debug)]
pub struct FilteredFriction {
    /// The friction term.
    pub term: FrictionTerm,
    /// The entries, ordered by sample, then joint, then parameter of the term.
    pub columns: Vec<f64>,
}

/// The samples of one record, as inputs of the model. An array with n numbers per sample is stored sample by sample.
#[derive(Clone, Debug, Default)]
pub struct States {
    /// Number of coordinates.
    pub n: usize,
    /// Index of the log to which the record belongs, counted from 0.
    pub log: usize,
    /// Times, s, one per sample.
    pub t: Vec<f64>,
    /// Positions, rad (m): n per sample, sample by sample. The arrays dq, ddq, tau and direction have the same order.
    pub q: Vec<f64>,
    /// Velocities, rad/s (m/s).
    pub dq: Vec<f64>,
    /// Accelerations, rad/s^2 (m/s^2).
    pub ddq: Vec<f64>,
    /// Measured torques, N m (N).
    pub tau: Vec<f64>,
    /// Direction of each joint: sign(dq), or the filtered sign, between -1 and 1.
    pub direction: Vec<f64>,
    /// Direction of each coupling, sample by sample: the sign of its speed, or the filtered sign.
    pub motor_direction: Vec<f64>,
    /// The friction columns that were filtered after they were computed. All other friction columns are computed when rows are
    /// filled.
    pub friction: Vec<FilteredFriction>,
    /// Torque without friction, predicted by an earlier fit, N m (N), n per sample. Empty without load-dependent friction.
    pub load: Vec<f64>,
    /// Whether the row of each joint is used, n per sample. A joint at standstill has unused rows.
    pub used: Vec<bool>,
    /// Cut-off frequency of positions and velocities, Hz; 0: no filter.
    pub cutoff: f64,
    /// Cut-off frequency of the torques, Hz; 0: no filter.
    pub effort_cutoff: f64,
    /// Time between samples, s.
    pub period: f64,
    /// For each coordinate, the frequency below which 95 % of the energy of the velocity lies, Hz.
    pub f95: Vec<f64>,
}

impl States {
    /// Number of samples.
    #[inline]
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// The filtered columns of each of `terms`. `None` for a term whose columns are computed at each sample.
    pub fn filtered(&self, terms: &[FrictionTerm]) -> Vec<Option<&[f64]>> {
        let of = |term: &FrictionTerm| self.friction.iter().find(|f| f.term == *term).map(|f| f.columns.as_slice());
        terms.iter().map(of).collect()
    }

    /// The torque of joint j at sample r on which the friction of a single-joint term depends, N m (N): the torque without
    /// friction that an earlier fit predicts. Zero if there is no prediction; `None` if `term` is not a term of a single joint.
    #[inline]
    pub(crate) fn torque_of_friction(&self, term: FrictionTerm, r: usize, j: usize) -> Option<f64> {
        term.is_of_one_joint().then(|| self.load.get(r * self.n + j).copied().unwrap_or(0.0))
    }

    /// Joins the samples of several records of one robot. All records must have the same period and the same filters, because
    /// these values are taken from the first record.
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

    /// Memory of all arrays, bytes.
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
