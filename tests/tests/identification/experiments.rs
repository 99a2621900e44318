//! Candidate experiments of R3G (an arm with three revolute axes) stay within its limits. For exact motions, they give the rows
//! that the publication states.

use experiments::motion::profile::Profile;
use experiments::plan::candidates::{Candidate, CandidateGrid, candidates, swing};
use experiments::plan::exciting_trajectory::MovingJoints;
use experiments::plan::measured_motion::MeasuredMotion;
use experiments::plan::motion_kind::MotionKind;
use experiments::plan::paper_rows::spectral_rows;
use tests::benchmark::arms::NOISE;
use tests::benchmark::candidates::{bang_bang, r3_limits};
use tests::benchmark::robots::r3;

fn grid(profile: Profile) -> CandidateGrid {
    CandidateGrid { profile, steps: 4, configurations: 12, duration: 4.0, sample_time: 1e-3, gravity: true, seed: 1 }
}

#[test]
fn candidates_respect_the_limits() {
    let robot = r3(true);
    for profile in [Profile::BangBang, Profile::Smooth] {
        let found = candidates(&grid(profile), &r3_limits(), &robot, &NOISE);
        assert!(found.len() > 80, "{}", found.len());
        for c in &found {
            let r = c.trajectory.reference();
            for (k, limit) in r3_limits().iter().enumerate() {
                let greatest = |x: &[f64]| x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                // Tolerance for the rounding of positions, velocities and accelerations.
                assert!(r.q[k].iter().all(|&q| q > limit.position.0 - 1e-12 && q < limit.position.1 + 1e-12));
                assert!(greatest(&r.dq[k]) < limit.velocity * (1.0 + 1e-12));
                assert!(greatest(&r.ddq[k]) < limit.acceleration * (1.0 + 1e-12));
            }
            assert!(!c.information.is_empty());
        }
    }
}

#[test]
fn rows_of_a_candidate_are_those_of_its_record() {
    let robot = r3(true);
    let joints = MovingJoints { kind: MotionKind::Mixed, fast: 0, slow: &[1, 2], centre: &[0.0, 0.4, -0.7] };
    let t = swing(&grid(Profile::BangBang), &r3_limits(), &joints).unwrap();
    let motion = MeasuredMotion::of_reference(&t.reference());
    let zero = vec![vec![0.0; motion.len()]; 3];
    let full = spectral_rows(&t, &robot, &motion, &zero, &NOISE).weighted();
    let brief = Candidate::new(t, &robot, &NOISE).information;
    for (a, b) in full.iter().flatten().zip(brief.iter().flatten()) {
        // The motion has corners. They cause different aliasing with 516 and with 200 samples per period.
        assert!((a - b).abs() < 2e-3 * full.trace().sqrt(), "{a} {b}");
    }
}

fn torque(columns: &[Vec<Vec<f64>>], x: &[f64]) -> Vec<Vec<f64>> {
    let one = |d: &Vec<Vec<f64>>| (0..d[0].len()).map(|i| d.iter().zip(x).map(|(d, x)| d[i] * x).sum()).collect();
    columns.iter().map(one).collect()
}

#[test]
fn exact_motion_gives_exact_equations() {
    let robot = r3(true);
    let swing = bang_bang(MotionKind::Mixed, 0, &[1, 2], [0.0, 0.3, -0.7], 500);
    let motion = MeasuredMotion::of_reference(&swing.reference());
    let tau = torque(&motion.regressor_columns(&robot), &robot.truth);
    let block = spectral_rows(&swing, &robot, &motion, &tau, &NOISE);
    assert_eq!(block.joint, [0, 1, 1, 2, 2]);
    for (row, y) in block.rows.iter().zip(&block.right) {
        let x: f64 = row.iter().zip(&robot.truth).map(|(a, b)| a * b).sum();
        // The operator Sp, which gives the rows, is linear. So the difference is only rounding.
        assert!((x - y).abs() < 1e-12, "{x} {y}");
    }
}
