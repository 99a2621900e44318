//! Determines the independent errors of the geometry of a chain without a tolerance, for a kinematic calibration: the motion of
//! the last link per unit of each error is evaluated in a finite field, as for the inertial parameters
//! ([`crate::base::exact_rank`]).
//!
//! The measurements are full poses of the last link. The chain has no passive joints.

use robot::{JointKind, LinkId, Robot};

use crate::base::angles::GraphAngles;
use crate::base::exact_rank::{Echelon, assigned};
use crate::base::field::Residue;
use crate::base::field_algebra::FieldAlgebra;
use crate::derivation::Derivation;
use random::SplitMix;

/// An error of the geometry, or of a frame. An axis is a number from 0 to 5: slides along x, y, z, then turns about x, y, z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GeometricError {
    /// Of the frame of the antecedent of a link, in which the link is placed. For the first link: the base.
    Before {
        /// The link.
        link: LinkId,
        /// The axis.
        axis: usize,
    },
    /// Of the frame of the last link, to which the tool is fixed.
    Tool {
        /// The axis.
        axis: usize,
    },
    /// The zero error of a coordinate, by its index.
    Zero(usize),
    /// One of the seven errors of a link: gamma, b, beta, alpha, d, theta, r.
    Link {
        /// The link.
        link: LinkId,
        /// Index of the error, from 0 to 6.
        error: usize,
    },
}

/// Seed of the random field elements.
const FIELD_SEED: u64 = 1994;
/// Number of random states beyond the number of states that would give as many rows as there are errors.
const EXTRA_STATES: usize = 4;
/// Number of twists of a link: of the frame of its antecedent, and its own.
const TWISTS: usize = 13;

/// Indices of the errors whose effect on the pose of the link `tip` is independent of the errors before them. `None` if the robot
/// has passive joints.
pub fn independent_geometric_errors(robot: &Robot, tip: LinkId, errors: &[GeometricError]) -> Option<Vec<usize>> {
    if !robot.passive.is_empty() {
        return None;
    }
    let twists = Derivation::new(robot).ok()?.geometric_twists(tip);
    let mut chain: Vec<LinkId> = std::iter::successors(Some(tip), |&j| robot.link(j).antecedent).collect();
    chain.reverse();
    let first_twist = |link: LinkId| TWISTS * chain.iter().position(|k| *k == link).unwrap_or(0);
    let graph = twists.graph();
    let mut random = SplitMix(FIELD_SEED);
    let (constants, angles) = (assigned(graph, &mut random), GraphAngles::of(graph));
    let mut echelon = Echelon::default();
    for _ in 0..errors.len().div_ceil(6) + EXTRA_STATES {
        let mut algebra = FieldAlgebra::new(graph, &angles, &constants, &mut random);
        let values = twists.evaluate_in(&mut algebra).swap_remove(0);
        for (row, values) in values.chunks(TWISTS * chain.len()).enumerate() {
            // Theta moves a revolute joint, and r a prismatic one.
            let zero = |coordinate: usize| {
                let mut sum = Residue::ZERO;
                for &link in &chain {
                    let joint = &robot.link(link).joint;
                    let own = first_twist(link) + if joint.kind == JointKind::Prismatic { 12 } else { 11 };
                    for (_, factor) in joint.variable.terms.iter().filter(|(k, _)| k.0 == coordinate) {
                        sum = sum + Residue::number(*factor) * values[own];
                    }
                }
                sum
            };
            let entry = |error: &GeometricError| match *error {
                GeometricError::Before { link, axis } => values[first_twist(link) + axis],
                GeometricError::Tool { axis } if axis == row => Residue::ONE,
                GeometricError::Tool { .. } => Residue::ZERO,
                GeometricError::Zero(coordinate) => zero(coordinate),
                GeometricError::Link { link, error } => values[first_twist(link) + 6 + error],
            };
            echelon.add(errors.iter().map(entry).collect());
        }
    }
    Some(echelon.columns())
}
