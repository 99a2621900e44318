//! A plan of eight for R3G.

use identification::experiments::exciting_trajectory::{ExcitingTrajectory, MotionKind};

use crate::tree_robot::bang_bang;

/// A plan of eight whose determinant is within one per cent of the best known.
pub fn golden_plan() -> Vec<ExcitingTrajectory> {
    let third = |i: f64| 2.2 * i / 6.0;
    let one = |q2, i| bang_bang(MotionKind::Mixed, 0, &[1, 2], [0.0, q2, third(i)], 500);
    let two = |q2, i| bang_bang(MotionKind::Mixed, 1, &[2], [0.0, q2, third(i)], 400);
    vec![
        one(-1.2, -2.0),
        one(-0.3, 0.0),
        one(0.3, -6.0),
        one(1.2, 4.0),
        two(-0.7, -6.0),
        two(0.7, -1.0),
        two(0.7, 5.0),
        ExcitingTrajectory::sweep(1, &[0.0, 0.0, -2.2], 2.0, 1.0, 1e-3),
    ]
}
