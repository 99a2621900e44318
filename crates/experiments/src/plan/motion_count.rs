//! The kinds of motion that a plan chooses from, and how many motions they make.

use crate::plan::motion_kind::MotionKind;

/// The kinds of motion of a fast joint of `n` with their slow companions, which are joints behind it in the chain.
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

/// How many kinds of motion `n` joints have.
pub fn count_of_kinds(n: usize, has_gravity: bool) -> usize {
    (0..n).map(|fast| kinds_of(fast, n, has_gravity).len()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every joint alone, and moved by gravity; every pair twice; all behind a joint at once.
    #[test]
    fn kinds_are_counted() {
        for n in 0_usize..9 {
            let pairs = n * n.saturating_sub(1) / 2;
            assert_eq!(count_of_kinds(n, true), 2 * n + 2 * pairs + n.saturating_sub(1));
            assert_eq!(count_of_kinds(n, false), n + 2 * pairs + n.saturating_sub(1));
        }
    }
}
