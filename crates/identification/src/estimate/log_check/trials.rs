//! Compares nominal torques with the torques of a log, for many changes of the log.
//!
//! A change of the log undoes one fault. The change determines which motion columns and which torque column of the log belong
//! to a joint. The joint's own columns (rotor, friction, offset) depend only on these motion columns. The torque, projected
//! onto the complement of the own columns, depends only on these motion columns and this torque column. So own columns and
//! projected torque are computed once for each pair of motion and torque, and thousands of trials are fast.

use std::sync::OnceLock;

use linear_model::states::States;

use crate::estimate::log_check::change::{
    Change, Description, MIN_SAMPLES_PER_JOINT, column, motion_of, torque_of, used,
};
use crate::estimate::log_check::regression::{Basis, Partial};

/// A log and a description, prepared for comparison under many changes of the log.
pub(super) struct Trials<'a> {
    description: &'a Description<'a>,
    states: &'a States,
    rows: &'a [usize],
    joints: Vec<InvariantPart>,
}

/// Data of one joint that are computed once for all changes of the log.
struct InvariantPart {
    /// `places`: indices into `rows` of the samples at which the joint is used; `chosen`: these samples.
    places: Vec<usize>,
    chosen: Vec<usize>,
    /// Entry k: orthonormal basis of the joint's own columns (rotor, friction, offset), if the motion of coordinate k in the
    /// log belongs to the joint.
    bases: Vec<OnceLock<Basis>>,
    /// Entry k n + l: torque column l of the log, projected onto the complement of basis k.
    torques: Vec<OnceLock<Vec<f64>>>,
}

impl<'a> Trials<'a> {
    /// Prepares the comparison of log and description at the samples `rows` of the log.
    pub(super) fn new(description: &'a Description<'a>, states: &'a States, rows: &'a [usize]) -> Trials<'a> {
        let n = states.n;
        let own = |j: usize| {
            let places = used(states, rows, j);
            let chosen = places.iter().map(|&i| rows[i]).collect();
            let (bases, torques) = ((0..n).map(|_| OnceLock::new()), (0..n * n).map(|_| OnceLock::new()));
            InvariantPart { places, chosen, bases: bases.collect(), torques: torques.collect() }
        };
        Trials { description, states, rows, joints: (0..n).map(own).collect() }
    }

    /// Nominal torques of the log after these changes, N m (N), sample by sample.
    pub(super) fn nominal_torques(&self, changes: &[Change]) -> Vec<f64> {
        self.description.torques(self.states, self.rows, changes)
    }

    /// Regression of each joint's measured torque on its nominal torque after these changes. Offset, friction and rotor of the
    /// joint are projected out of both torques.
    pub(super) fn partials(&self, changes: &[Change]) -> Vec<Partial> {
        self.partials_of(&self.nominal_torques(changes), changes)
    }

    /// Regression of each joint's measured torque on its nominal torque after these changes, as in `partials`. `described`:
    /// the nominal torques after the changes, N m (N), sample by sample.
    pub(super) fn partials_of(&self, described: &[f64], changes: &[Change]) -> Vec<Partial> {
        let n = self.states.n;
        let joint = |(j, own): (usize, &InvariantPart)| {
            if own.places.len() < MIN_SAMPLES_PER_JOINT {
                return Partial::default();
            }
            let (k, (of, sign)) = (motion_of(changes, j), torque_of(changes, j));
            let basis = own.bases[k].get_or_init(|| Basis::of(self.own_columns(&own.chosen, k)));
            let measured =
                own.torques[k * n + of].get_or_init(|| basis.without(column(&self.states.tau, n, of, &own.chosen)));
            let mut partial = Partial::of(measured, &basis.without(column(described, n, j, &own.places)));
            partial.xy *= sign;
            partial
        };
        self.joints.iter().enumerate().map(joint).collect()
    }

    /// The columns of a joint that no description contains: 1, dq, direction, ddq (offset, friction, rotor). k: coordinate in
    /// the log whose motion belongs to the joint.
    fn own_columns(&self, rows: &[usize], k: usize) -> Vec<Vec<f64>> {
        let (states, n) = (self.states, self.states.n);
        vec![
            vec![1.0; rows.len()],
            column(&states.dq, n, k, rows),
            column(&states.direction, n, k, rows),
            column(&states.ddq, n, k, rows),
        ]
    }
}
