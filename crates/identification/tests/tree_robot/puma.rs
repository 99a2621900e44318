//! A PUMA 560 and the experiments a plan for it may choose from.

use identification::{Candidate, ExcitingTrajectory, MotionKind, Profile, Random};

use crate::tree_robot::{Link, TreeRobot};

/// A PUMA 560 in the frames of Corke and Armstrong-Helouvry, with rotor inertias. Standard
/// parameters are not given: it serves planning.
fn puma() -> TreeRobot {
    let half_pi = std::f64::consts::FRAC_PI_2;
    // alpha, d, r.
    let frames = [
        (0.0, 0.0, 0.0),
        (-half_pi, 0.0, 0.2435),
        (0.0, 0.4318, -0.0934),
        (half_pi, -0.0203, 0.4331),
        (-half_pi, 0.0, 0.0),
        (half_pi, 0.0, 0.0),
    ];
    let link = |(j, (alpha, d, r)): (usize, (f64, f64, f64))| Link {
        antecedent: j.checked_sub(1),
        geometry: [0.0, 0.0, alpha, d, 0.0, r],
        variable: vec![(j, 1.0)],
        standard: [0.0; 11],
        has_rotor: true,
    };
    let links = frames.into_iter().enumerate().map(link).collect();
    TreeRobot::new(links, [0.0, 0.0, -9.81], &["q1", "q2", "q3", "q4", "q5", "q6"])
}

/// Random configurations of a PUMA 560: 708 experiments for 40 parameters.
pub fn puma_candidates() -> Vec<Candidate> {
    const LOW: [f64; 6] = [-2.5, -2.5, -2.0, -2.0, -1.6, -2.5];
    const HIGH: [f64; 6] = [2.5, 0.5, 2.6, 2.0, 1.6, 2.5];
    const GREATEST: [(f64, f64); 6] = [(1.5, 10.0), (1.2, 8.0), (2.0, 15.0), (4.0, 30.0), (4.0, 30.0), (4.0, 30.0)];
    const PERIOD: [usize; 6] = [1000, 1000, 800, 500, 500, 500];
    const NOISE: [f64; 6] = [1.0, 1.5, 0.8, 0.2, 0.2, 0.2];
    let robot = puma();
    let mut random = Random::new(9);
    let mut configuration = || {
        let at = |k: usize, i: usize| 0.85 * (LOW[k] + (HIGH[k] - LOW[k]) * i as f64 / 6.0);
        (0..6).map(|k| if k == 0 { 0.0 } else { at(k, random.index(7)) }).collect::<Vec<f64>>()
    };
    let mut found = Vec::new();
    for fast in 0..6 {
        let (velocity, acceleration) = GREATEST[fast];
        let acceleration = acceleration.min(4.0 * velocity / (PERIOD[fast] as f64 * 1e-3));
        let mut companions = vec![(MotionKind::Inertial, vec![])];
        companions.extend((fast + 1..6).map(|l| (MotionKind::Mixed, vec![l])));
        companions.push((MotionKind::Mixed, (fast + 1..6).collect()));
        for (kind, slow) in companions {
            for _ in 0..24 {
                let centre = configuration();
                found.push(ExcitingTrajectory::swing(
                    kind,
                    fast,
                    &slow,
                    &centre,
                    Profile::BangBang,
                    PERIOD[fast],
                    acceleration,
                    &[0.15; 6],
                    4.0,
                    1e-3,
                ));
            }
        }
        if fast > 0 {
            found.extend((0..12).map(|_| ExcitingTrajectory::sweep(fast, &configuration(), 1.5, 0.5, 1e-3)));
        }
    }
    found.into_iter().map(|t| Candidate::new(t, &robot, &NOISE)).collect()
}
