//! Determines the independent errors of the geometry of a chain without a tolerance, for a kinematic calibration: the motion of
//! the last link per unit of each error is evaluated in a finite field, as for the inertial parameters
//! ([`crate::base::exact_rank`]).
//!
//! The measurements are full poses of the last link. The chain has no passive joints. At state i, the m errors e move the link by
//!
//! ```text
//! [v; w] = J(q_i) e          J: 6 x m, in the axes of the link; e: rad, m
//! ```
//! v: velocity of its origin, w: its angular velocity. The independent errors are the independent columns of the stacked J of
//! random states [Khalil, Dombre 2002, chapter 11]. The columns are those of [`Derivation::geometric_twists`]; an error of the
//! tool has a column of the unit matrix.

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

/// Indices of the errors whose effect on the pose of the link `tip` is independent of the errors before them, ascending. An error
/// of a link that does not move `tip` has no effect. `None` if the robot has passive joints.
pub fn independent_geometric_errors(robot: &Robot, tip: LinkId, errors: &[GeometricError]) -> Option<Vec<usize>> {
    if !robot.passive.is_empty() {
        return None;
    }
    let twists = Derivation::new(robot).ok()?.geometric_twists(tip);
    let mut chain: Vec<LinkId> = std::iter::successors(Some(tip), |&j| robot.link(j).antecedent).collect();
    chain.reverse();
    let first_twist = |link: LinkId| chain.iter().position(|k| *k == link).map(|place| TWISTS * place);
    let (graph, mut random) = (twists.graph(), SplitMix(FIELD_SEED));
    let (constants, angles) = (assigned(graph, &mut random), GraphAngles::of(graph));
    let mut echelon = Echelon::default();
    for _ in 0..errors.len().div_ceil(6) + EXTRA_STATES {
        let mut algebra = FieldAlgebra::new(graph, &angles, &constants, &mut random);
        let values = twists.evaluate_in(&mut algebra).swap_remove(0);
        for (row, values) in values.chunks(TWISTS * chain.len()).enumerate() {
            // Theta moves a revolute joint, and r a prismatic one.
            let zero = |coordinate: usize| {
                let mut sum = Residue::ZERO;
                for (place, &link) in chain.iter().enumerate() {
                    let joint = &robot.link(link).joint;
                    let own = TWISTS * place + if joint.kind == JointKind::Prismatic { 12 } else { 11 };
                    for (_, factor) in joint.variable.terms.iter().filter(|(k, _)| k.0 == coordinate) {
                        sum = sum + Residue::number(*factor) * values[own];
                    }
                }
                sum
            };
            let twist = |link, k: usize| first_twist(link).map_or(Residue::ZERO, |first| values[first + k]);
            let entry = |error: &GeometricError| match *error {
                GeometricError::Before { link, axis } => twist(link, axis),
                GeometricError::Tool { axis } if axis == row => Residue::ONE,
                GeometricError::Tool { .. } => Residue::ZERO,
                GeometricError::Zero(coordinate) => zero(coordinate),
                GeometricError::Link { link, error } => twist(link, 6 + error),
            };
            echelon.add(errors.iter().map(entry).collect());
        }
    }
    Some(echelon.columns())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two parallel axes and a slide across them: only some of the 3 x 7 errors are independent of base and tool. A branch beside
    /// the chain has no effect.
    #[test]
    fn errors_of_two_parallel_axes_and_a_slide() {
        let text = "convention: khalil-kleinfinger\nname: r\nlinks:\n- {link: 1, antecedent: base, theta: q1}\n\
                    - {link: 2, antecedent: 1, d: 0.4, theta: q2}\n\
                    - {link: 3, antecedent: 2, alpha: pi/2, joint: prismatic, r: q3}\n\
                    - {link: 4, antecedent: 1, d: 0.2, theta: q4}\n";
        let robot = robot::format::read_yaml(text, "r.yaml").unwrap();
        let [first, second, third, branch] = [0, 1, 2, 3].map(LinkId);
        let errors = |links: &[LinkId]| -> Vec<GeometricError> {
            let frames = (0..6).map(|axis| GeometricError::Before { link: first, axis });
            let tool = (0..6).map(|axis| GeometricError::Tool { axis });
            let links = links.iter().flat_map(|&link| (0..7).map(move |error| GeometricError::Link { link, error }));
            frames.chain(tool).chain(links).collect()
        };
        let count = |links: &[LinkId]| independent_geometric_errors(&robot, third, &errors(links)).unwrap().len();
        // 4 for each revolute joint, 2 for a prismatic one, and 6 [Khalil, Dombre 2002, chapter 11].
        assert_eq!(count(&[first, second, third]), 4 + 4 + 2 + 6);
        assert_eq!(count(&[branch]), count(&[]));
    }
}
