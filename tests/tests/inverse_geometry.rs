//! The inverse geometric model against the direct one.

use expr::Tape;
use modeling::{Derivation, LinkFrame};
use tests::model;
use tests::random::Random;

/// Poses of each arm.
const POSES: usize = 100_000;

/// All solutions that are numbers reach the pose, and one of them is where it came from. Of a wrist with a centre all
/// eight are there; with parallel axes the elbow may not reach what the other shoulder or wrist asks for.
#[test]
fn all_solutions_reach_the_pose() {
    for (file, has_wrist) in [("puma560.yaml", true), ("rx90.yaml", true), ("ur5.yaml", false), ("ur5.urdf", false)] {
        let robot = model(file);
        let mut derivation = Derivation::new(&robot).unwrap();
        let last = robot.link_ids().next_back().unwrap();
        let frame = LinkFrame::named(&robot, LinkFrame::names(&robot).last().unwrap()).unwrap();
        let frame = if has_wrist { LinkFrame::from(last) } else { frame };
        let direct = Tape::new(&derivation.pose(frame.clone()).bound());
        let inverse = Tape::new(&derivation.inverse_geometry(frame).unwrap().bound());
        let (mut direct_work, mut inverse_work) = (direct.workspace(), inverse.workspace());
        let (mut random, mut t, mut found, mut again) = (Random(20), [0.0; 12], [0.0; 96], [0.0; 12]);
        let (mut solutions, mut worst) = (0_usize, 0.0_f64);
        for _ in 0..POSES {
            let q = random.vector(6, std::f64::consts::PI);
            direct.evaluate(&q, &mut direct_work, &mut t);
            inverse.evaluate(&t, &mut inverse_work, &mut found);
            let mut nearest = f64::INFINITY;
            let mut here = 0;
            for k in 0..8 {
                let angle = |joint: usize| found[6 * k + joint].atan2(found[48 + 6 * k + joint]);
                let solution: [f64; 6] = std::array::from_fn(angle);
                if solution.iter().any(|x| x.is_nan()) {
                    continue;
                }
                here += 1;
                direct.evaluate(&solution, &mut direct_work, &mut again);
                let apart = t.iter().zip(again).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                worst = worst.max(apart);
                let off = |(a, b): (&f64, f64)| (a - b).sin().abs().max(1.0 - (a - b).cos());
                nearest = nearest.min(q.iter().zip(solution).map(off).fold(0.0, f64::max));
            }
            solutions += here;
            assert!(!has_wrist || here == 8, "{file}: {here} solutions at {q:?}");
            // Near a singular configuration rounding of 1e-16 becomes its root.
            assert!(nearest < 1e-5, "{file}: {nearest:e} from {q:?}");
        }
        assert!(worst < 1e-9, "{file}: {worst:e}");
        println!("{file}: {} solutions a pose, {worst:e} off", solutions as f64 / POSES as f64);
    }
}

#[test]
fn other_arms_are_refused_with_the_reason() {
    for (file, reason) in
        [("stanford.yaml", "does not turn"), ("kuka_lwr.yaml", "7 joints"), ("scara.yaml", "4 joints")]
    {
        let robot = model(file);
        let last = robot.link_ids().next_back().unwrap();
        let refused = Derivation::new(&robot).unwrap().inverse_geometry(last).unwrap_err().to_string();
        assert!(refused.contains(reason) && refused.contains("spherical wrist"), "{file}: {refused}");
    }
}
