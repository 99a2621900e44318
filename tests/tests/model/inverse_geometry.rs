//! The inverse geometric model against the direct one.

use expr::Tape;
use modeling::{Derivation, LinkFrame};
use robot::{JointKind, Robot};
use tests::model;
use tests::random::Random;

/// Poses of each arm.
const POSES: usize = 100_000;

/// An RX90 from its end: axes 1, 2 and 3 meet, and 4 and 5 are parallel.
const SHOULDER: &str = "\
convention: khalil-kleinfinger
name: shoulder
links:
  - {link: 1, antecedent: base, theta: q1, r: 0.2}
  - {link: 2, antecedent: 1, alpha: pi/2, theta: q2}
  - {link: 3, antecedent: 2, alpha: -pi/2, theta: q3 + pi/2, r: 0.45}
  - {link: 4, antecedent: 3, alpha: pi/2, d: 0.05, theta: q4, r: 0.04}
  - {link: 5, antecedent: 4, d: 0.4, theta: q5 - pi/2, r: 0.03}
  - {link: 6, antecedent: 5, alpha: -pi/2, d: 0.02, theta: -q6, r: 0.1}
";

/// A UR5 from its end: axes 3, 4 and 5 parallel.
const PARALLEL: &str = "\
convention: khalil-kleinfinger
name: parallel
links:
  - {link: 1, antecedent: base, theta: q1, r: 0.1}
  - {link: 2, antecedent: 1, alpha: pi/2, theta: q2, r: 0.09}
  - {link: 3, antecedent: 2, alpha: -pi/2, theta: q3, r: 0.11}
  - {link: 4, antecedent: 3, d: 0.39, theta: q4, r: 0.03}
  - {link: 5, antecedent: 4, d: -0.42, theta: q5}
  - {link: 6, antecedent: 5, alpha: pi/2, theta: q6, r: 0.05}
";

/// A Stanford arm whose boom passes beside axis 2, which stands above frame 1.
const BOOM: &str = "\
convention: khalil-kleinfinger
name: boom
links:
  - {link: 1, antecedent: base, theta: q1, r: 0.3}
  - {link: 2, antecedent: 1, b: 0.2, alpha: -pi/2, d: 0.07, theta: q2, r: 0.15}
  - {link: 3, antecedent: 2, alpha: pi/2, d: 0.06, theta: pi/2, r: 0.1 - q3, joint: prismatic}
  - {link: 4, antecedent: 3, theta: q4, r: 0.12}
  - {link: 5, antecedent: 4, alpha: -pi/2, theta: q5}
  - {link: 6, antecedent: 5, alpha: pi/2, theta: q6, r: 0.08}
";

/// The same with its boom, the fourth joint, behind a spherical shoulder.
const BOOM_BEHIND: &str = "\
convention: khalil-kleinfinger
name: boom behind
links:
  - {link: 1, antecedent: base, theta: q1}
  - {link: 2, antecedent: 1, alpha: -pi/2, theta: q2}
  - {link: 3, antecedent: 2, alpha: pi/2, theta: q3, r: 0.12}
  - {link: 4, antecedent: 3, theta: pi/2, r: q4, joint: prismatic}
  - {link: 5, antecedent: 4, alpha: pi/2, d: 0.06, theta: q5, r: 0.15}
  - {link: 6, antecedent: 5, alpha: -pi/2, d: 0.07, theta: q6, r: 0.3}
";

fn read(text: &str) -> Robot {
    robot::format::read_yaml(text, "arm.yaml").unwrap_or_else(|e| panic!("{e}"))
}

/// All solutions that are numbers reach the pose, and one of them is where it came from. Of a wrist with a centre
/// behind axes 1 and 2 that meet all eight are there; else the elbow may not reach what the other shoulder or wrist asks for.
#[test]
fn all_solutions_reach_the_pose() {
    let shipped = [
        ("puma560.yaml", true),
        ("rx90.yaml", true),
        ("stanford.yaml", true),
        ("ur5.yaml", false),
        ("ur5.urdf", false),
    ];
    let others = [(SHOULDER, false), (PARALLEL, false), (BOOM, false), (BOOM_BEHIND, false)];
    let robots = shipped.map(|(file, has_all)| (model(file), has_all)).into_iter();
    for (robot, has_all) in robots.chain(others.map(|(text, has_all)| (read(text), has_all))) {
        let file = &robot.name;
        let slides = robot.links.iter().find(|link| link.joint.kind == JointKind::Prismatic);
        let sliding = slides.map(|link| link.joint.variable.terms[0].0.0);
        let mut derivation = Derivation::new(&robot).unwrap();
        let last = robot.link_ids().next_back().unwrap();
        let frame = LinkFrame::named(&robot, LinkFrame::names(&robot).last().unwrap()).unwrap();
        let frame = if has_all { LinkFrame::from(last) } else { frame };
        let direct = Tape::new(&derivation.pose(frame.clone()).bound());
        let inverse = Tape::new(&derivation.inverse_geometry(frame).unwrap().bound());
        let (mut direct_work, mut inverse_work) = (direct.workspace(), inverse.workspace());
        let (mut random, mut t, mut found, mut again) =
            (Random(20), [0.0; 12], vec![0.0; if sliding.is_some() { 104 } else { 96 }], [0.0; 12]);
        let (mut solutions, mut worst) = (0_usize, 0.0_f64);
        for _ in 0..POSES {
            let q = random.vector(6, std::f64::consts::PI);
            direct.evaluate(&q, &mut direct_work, &mut t);
            inverse.evaluate(&t, &mut inverse_work, &mut found);
            let mut nearest = f64::INFINITY;
            let mut here = 0;
            for k in 0..8 {
                let angle = |joint: usize| match sliding {
                    Some(slide) if slide == joint => found[96 + k],
                    _ => found[6 * k + joint].atan2(found[48 + 6 * k + joint]),
                };
                let solution: [f64; 6] = std::array::from_fn(angle);
                if solution.iter().any(|x| x.is_nan()) {
                    continue;
                }
                here += 1;
                direct.evaluate(&solution, &mut direct_work, &mut again);
                let apart = t.iter().zip(again).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                worst = worst.max(apart);
                let off = |joint: usize| {
                    let difference = q[joint] - solution[joint];
                    if sliding == Some(joint) {
                        difference.abs()
                    } else {
                        difference.sin().abs().max(1.0 - difference.cos())
                    }
                };
                nearest = nearest.min((0..6).map(off).fold(0.0, f64::max));
            }
            solutions += here;
            assert!(!has_all || here == 8, "{file}: {here} solutions at {q:?}");
            // Near a singular configuration rounding of 1e-16 becomes its root.
            assert!(nearest < 1e-5, "{file}: {nearest:e} from {q:?}");
        }
        assert!(worst < 1e-9, "{file}: {worst:e}");
        println!("{file}: {} solutions a pose, {worst:e} off", solutions as f64 / POSES as f64);
    }
}

#[test]
fn other_arms_are_refused_with_the_reason() {
    let wrist_apart = SHOULDER.replace("alpha: pi/2, theta: q2", "alpha: pi/2, d: 0.01, theta: q2");
    let slides = SHOULDER.replace("theta: q1, r: 0.2", "r: q1, joint: prismatic");
    let others = [(read(&wrist_apart), "axis 3 not parallel"), (read(&slides), "joint 1 slides")];
    let shipped =
        [("kuka_lwr.yaml", "7 joints"), ("scara.yaml", "4 joints")].map(|(file, reason)| (model(file), reason));
    for (robot, reason) in others.into_iter().chain(shipped) {
        let file = &robot.name;
        let last = robot.link_ids().next_back().unwrap();
        let refused = Derivation::new(&robot).unwrap().inverse_geometry(last).unwrap_err().to_string();
        assert!(refused.contains(reason) && refused.contains("spherical wrist"), "{file}: {refused}");
    }
}
