//! Candidate experiments for unit tests of this crate and of wings. A file that includes this file must import the types that it
//! uses.

use super::{CandidateGrid, MotionLimits, Profile, Random, WeightedRows};

/// Blocks of `count` candidates with one to three random rows of `p` entries each.
pub(crate) fn random_blocks(count: usize, p: usize, seed: u64) -> Vec<WeightedRows> {
    let mut random = Random::new(seed);
    let mut block = || {
        let mut rows = WeightedRows::new(p);
        for _ in 0..1 + random.index(3) {
            rows.push(&(0..p).map(|_| random.normal()).collect::<Vec<_>>());
        }
        rows
    };
    (0..count).map(|_| block()).collect()
}

pub(crate) fn limits() -> [MotionLimits; 3] {
    let limit = |range: f64, velocity, acceleration| MotionLimits {
        position: (-range, range),
        velocity,
        acceleration,
        slow_velocity: 0.5,
        bandwidth: 10.0,
        quantum: 1e-4,
    };
    [limit(2.6, 5.0, 30.0), limit(1.5, 5.0, 40.0), limit(2.4, 7.0, 60.0)]
}

pub(crate) fn grid() -> CandidateGrid {
    CandidateGrid {
        profile: Profile::BangBang,
        steps: 4,
        configurations: 12,
        duration: 4.0,
        sample_time: 1e-3,
        gravity: true,
        seed: 1,
    }
}
