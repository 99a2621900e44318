//! Lists the kinds of motion from which a plan is chosen, and computes the number of motions and rows, and their memory.
//!
//! While a plan is chosen, memory holds all rows up to five times: unweighted and divided by their standard deviations, a copy
//! of both, and one of them with scaled columns. Memory also holds each motion twice: as it was tried, and together with its
//! rows.

use numerics::information_matrix::WeightedRows;

use crate::plan::exciting_trajectory::ExcitingTrajectory;
use crate::plan::motion_kind::MotionKind;

/// The kinds of motion whose fast joint is `fast`, in a chain of `n` joints. Each has its list of slow joints, which follow
/// `fast` in the chain. `has_gravity`: whether gravity loads the joints.
pub(crate) fn kinds_of(fast: usize, n: usize, has_gravity: bool) -> Vec<(MotionKind, Vec<usize>)> {
    let mut motions = vec![(MotionKind::Inertial, vec![])];
    for l in fast + 1..n {
        motions.push((MotionKind::Centrifugal, vec![l]));
        motions.push((MotionKind::Coupling, vec![l]));
    }
    if fast + 1 < n {
        motions.push((MotionKind::Mixed, (fast + 1..n).collect()));
    }
    if has_gravity {
        motions.push((MotionKind::Gravity, vec![]));
    }
    motions
}

/// Greatest number of regressor rows that a kind of motion gives. A slow sweep gives two rows: the gravity torque of a revolute
/// joint is a cos q + b sin q + c if the other joints are at rest, and c vanishes because the equations are centred.
fn rows_of((kind, slow): &(MotionKind, Vec<usize>)) -> usize {
    match kind {
        MotionKind::Inertial => 1,
        MotionKind::Centrifugal | MotionKind::Coupling => slow.len(),
        MotionKind::Mixed => 1 + 2 * slow.len(),
        MotionKind::Gravity => 2,
    }
}

/// Greatest number of regressor rows of all kinds of motion of a chain of `n` joints about one configuration.
pub fn count_of_rows(n: usize, has_gravity: bool) -> usize {
    (0..n).flat_map(|fast| kinds_of(fast, n, has_gravity)).map(|kind| rows_of(&kind)).sum()
}

/// Number of copies of each row in memory at the peak of the choice of a plan.
const COPIES_OF_ROWS: f64 = 5.0;
/// Number of copies of each motion in memory at the peak of the choice of a plan.
const COPIES_OF_MOTIONS: f64 = 2.0;

/// Memory in bytes for the choice of a plan among all kinds of motion of `n` joints about `configurations` configurations; `p`:
/// number of parameters.
pub fn bytes_of_choice(n: usize, p: usize, has_gravity: bool, configurations: usize) -> f64 {
    let (rows, kinds) = (count_of_rows(n, has_gravity), count_of_kinds(n, has_gravity));
    let of_rows = COPIES_OF_ROWS * (rows * p * size_of::<f64>() + kinds * size_of::<WeightedRows>()) as f64;
    // A motion has three lists of numbers: centre, half ranges, and slow joints.
    let of_motions = COPIES_OF_MOTIONS * (kinds * (size_of::<ExcitingTrajectory>() + 3 * n * size_of::<f64>())) as f64;
    configurations as f64 * (of_rows + of_motions)
}

/// Number of different kinds of motion in a chain of `n` joints about one configuration.
pub fn count_of_kinds(n: usize, has_gravity: bool) -> usize {
    (0..n).map(|fast| kinds_of(fast, n, has_gravity).len()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::profile::Profile;
    use crate::plan::exciting_trajectory::{MovingJoints, SwingCourse};

    #[test]
    fn rows_are_the_equations_of_the_motions() {
        let n = 5;
        for fast in 0..n {
            for kind in kinds_of(fast, n, true) {
                let (word, slow) = (kind.0, &kind.1);
                let (centre, slowest) = ([0.0; 5], [0.1; 5]);
                let course = SwingCourse {
                    profile: Profile::Smooth,
                    period: 400,
                    acceleration: 1.0,
                    slow_velocity: &slowest,
                    duration: 4.0,
                    sample_time: 0.01,
                };
                let joints = MovingJoints { kind: word, fast, slow, centre: &centre };
                let swing = ExcitingTrajectory::swing(&joints, &course);
                let equations = swing.equations().len();
                // For a gravity sweep two rows are expected; the tests of paper_rows.rs check this number.
                assert_eq!(rows_of(&kind), if word == MotionKind::Gravity { 2 } else { equations }, "{kind:?}");
            }
        }
    }

    #[test]
    fn kinds_are_counted() {
        for n in 0_usize..9 {
            let pairs = n * n.saturating_sub(1) / 2;
            assert_eq!(count_of_kinds(n, true), 2 * n + 2 * pairs + n.saturating_sub(1));
            assert_eq!(count_of_kinds(n, false), n + 2 * pairs + n.saturating_sub(1));
        }
    }
}
