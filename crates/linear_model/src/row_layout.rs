//! Defines where the entries of the rows of one sample are stored in a block: the entries of the regressor that are not always
//! zero, then the friction of each joint, then the couplings, then the torque of each joint. Zero entries are not stored.

use crate::coupling::Coupling;
use crate::friction::terms::{FrictionTerm, columns_before, columns_of};
use crate::regressor::Regressor;

/// The positions of all entries of one sample in a block.
#[derive(Clone, Debug)]
pub struct RowLayout {
    /// Number of stored entries of the regressor. These entries come first in a sample.
    pub base: usize,
    /// For each joint, the columns of its row and their positions.
    pub joints: Vec<JointEntries>,
    /// For each coupling, one number per joint of the coupling: the position of the first entry of the coupling in the row of
    /// that joint.
    pub couplings: Vec<Vec<usize>>,
    /// Number of all entries of a sample.
    pub entries: usize,
}

/// The columns of the row of one joint, and the positions of their entries.
#[derive(Clone, Debug, Default)]
pub struct JointEntries {
    /// The columns on which the torque of the joint can depend: base parameters ascending, then friction, then couplings.
    pub columns: Vec<usize>,
    /// The position of the entry of each column in `columns`; the last number is the position of the torque.
    pub places: Vec<usize>,
    /// The position of the first friction entry of the joint.
    pub friction: usize,
}

impl JointEntries {
    /// The position of the measured torque of the joint.
    #[inline]
    pub fn torque_place(&self) -> usize {
        self.places.last().copied().unwrap_or_default()
    }
}

impl RowLayout {
    /// Makes the layout of the rows of a model with these friction terms and couplings.
    pub fn new(regressor: &dyn Regressor, friction: &[FrictionTerm], couplings: &[Coupling]) -> RowLayout {
        let (n, p) = (regressor.coordinates().len(), regressor.parameters().len());
        let non_zeros = regressor.non_zeros();
        let mut joints = vec![JointEntries::default(); n];
        let take = |joint: &mut JointEntries, columns: std::ops::Range<usize>, first: usize| {
            joint.columns.extend(columns.clone());
            joint.places.extend(first..first + columns.len());
            first + columns.len()
        };
        // The entries are in this order: regressor, friction by joint, couplings, torques.
        for (place, &(joint, column)) in non_zeros.iter().enumerate() {
            take(&mut joints[joint], column..column + 1, place);
        }
        let mut entries = non_zeros.len();
        for (j, joint) in joints.iter_mut().enumerate() {
            joint.friction = entries;
            let first = p + columns_before(friction, j);
            entries = take(joint, first..first + columns_of(friction, j), entries);
        }
        // A coupling has the same columns in the rows of all joints on which it acts.
        let mut of_couplings = Vec::new();
        let mut first = p + columns_before(friction, n);
        for coupling in couplings {
            let width = coupling.parameters().len();
            let mut places = Vec::new();
            for j in coupling.rows() {
                places.push(entries);
                entries = take(&mut joints[j], first..first + width, entries);
            }
            of_couplings.push(places);
            first += width;
        }
        for joint in &mut joints {
            joint.places.push(entries);
            entries += 1;
        }
        RowLayout { base: non_zeros.len(), joints, couplings: of_couplings, entries }
    }
}
