//! A PUMA 560 and the experiments a plan for it may choose from.

use identification::algebra::random::Random;
use identification::experiments::candidates::Candidate;
use identification::experiments::exciting_trajectory::{ExcitingTrajectory, MotionKind};
use identification::experiments::profile::Profile;

use crate::tree_robot::{Link, Standard, TreeRobot, link_at};

/// A PUMA 560 in the frames of Corke and Armstrong-Helouvry, with rotor inertias. Masses, centres and inertias
/// are those of Armstrong, Khatib, Burdick 1986 (its link 3 is no body, which the simulation does not mind), with a
/// tool of 2 kg off the axis of the wrist.
pub fn puma() -> TreeRobot {
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
    let with_rotor = |mut x: Standard, ia: f64| {
        x[10] = ia;
        x
    };
    let mut standard = [
        with_rotor(link_at(1.0, [0.0; 3], [0.35, 0.0, 0.0, 0.35, 0.0, 0.35]), 1.14),
        with_rotor(link_at(17.4, [0.068, 0.006, -0.016], [0.13, 0.0, 0.0, 0.524, 0.0, 0.539]), 4.71),
        with_rotor(link_at(4.8, [0.0, -0.070, 0.014], [0.066, 0.0, 0.0, 0.0125, 0.0, 0.086]), 0.83),
        with_rotor(link_at(0.82, [0.0, 0.0, -0.019], [1.8e-3, 0.0, 0.0, 1.8e-3, 0.0, 1.3e-3]), 0.200),
        with_rotor(link_at(0.34, [0.0; 3], [0.3e-3, 0.0, 0.0, 0.3e-3, 0.0, 0.4e-3]), 0.179),
        with_rotor(link_at(0.09, [0.0, 0.0, 0.032], [0.15e-3, 0.0, 0.0, 0.15e-3, 0.0, 0.04e-3]), 0.193),
    ];
    let tool = link_at(2.0, [0.03, -0.02, 0.10], [4e-3, 3e-4, -4e-4, 5e-3, 2e-4, 3e-3]);
    standard[5].iter_mut().zip(tool).for_each(|(x, t)| *x += t);
    let link = |(j, (alpha, d, r)): (usize, (f64, f64, f64))| Link {
        antecedent: j.checked_sub(1),
        geometry: [0.0, 0.0, alpha, d, 0.0, r],
        variable: vec![(j, 1.0)],
        standard: standard[j],
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
