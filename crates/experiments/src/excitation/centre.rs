//! Finds a pose for the centre of a motion: by descent, it searches a pose at which distances of bodies and torques at rest keep
//! their limits. If there is none, this file counts the limits that random poses violate.
//!
//! The residuals at a pose q are
//!
//! ```text
//! r = (a - room(q)) / w     of each pair of solids whose distance room(q) above its bound is below a
//! r = share(q) - s          of each torque at rest that exceeds the share s of its bound
//! ```
//! The step d solves (J' J + lambda I) d = -J' r; J has the derivatives of r by the scaled coordinates. The damping lambda
//! decreases after a step that lowers r' r and increases otherwise (Levenberg-Marquardt) [Nocedal, Wright 2006, 10.3].

use nalgebra::{DMatrix, DVector};
use numerics::interruption::Interruption;
use random::Random;

use crate::excitation::gap_proof::GapCache;
use crate::excitation::limits::LimitKind;
use crate::excitation::problem::{Prepared, Problem};

/// Room (distance above the bound) that the descent requires for each pair of bodies, as a multiple of the pair's reserve
/// (additional distance for the motion between samples). The first value leaves room for a large motion; the second value is
/// tried if the first is not reached. At its start, a search needs at least two reserves.
const WANTED_RESERVES: [f64; 2] = [12.0, 4.0];
/// Unit w that makes residuals of distances dimensionless, m.
const UNIT_OF_ROOM_M: f64 = 0.01;
/// Share s of the torque bound that a torque at rest may use in the descent; one share for each entry of `WANTED_RESERVES`. At
/// its start, a search needs a share below 0.95.
const WANTED_TORQUE_SHARES: [f64; 2] = [0.5, 0.8];
/// Longest step of a coordinate in one iteration, as a share of half its position range.
const MAX_STEP_SHARE: f64 = 0.3;
/// Share of a coordinate's position range that a step keeps free at each end.
const FREE_RANGE_SHARE: f64 = 0.01;
/// Greatest number of steps in the search for the centre of a motion by descent; most descents end after ten.
const MAX_DESCENT_STEPS: usize = 40;
/// Damping lambda of the descent: initial value, factor after a successful step, factor after an unsuccessful step, and the value
/// at which a descent ends.
const DAMPING: (f64, f64, f64, f64) = (1e-2, 0.3, 4.0, 1e6);

/// The residuals r of limits that a pose violates, each with its derivatives by the scaled coordinates that move.
type Missing = Vec<(f64, Vec<f64>)>;

impl Prepared<'_> {
    /// The zero pose, with each coordinate clamped to its position limits.
    pub(super) fn home(&self) -> Vec<f64> {
        self.pose(|(low, high)| 0.0_f64.clamp(low, high))
    }

    /// The pose in the middle of the position limits of all coordinates.
    pub(super) fn middle(&self) -> Vec<f64> {
        self.pose(|(low, high)| 0.5 * (low + high))
    }

    fn pose(&self, mut of: impl FnMut((f64, f64)) -> f64) -> Vec<f64> {
        self.problem.limits.iter().map(|l| l.locked.unwrap_or_else(|| of(l.position))).collect()
    }

    /// The pose at which the descent from `q` ends. The descent first requires the greater distances of [`WANTED_RESERVES`]. If
    /// it does not reach them, it requires the smaller ones.
    pub(super) fn freed(&self, q: &[f64]) -> Vec<f64> {
        let [far, near] = [0, 1].map(|k| (WANTED_RESERVES[k], WANTED_TORQUE_SHARES[k]));
        let found = self.descended(q, far);
        if self.missing(&found, near, &mut None).is_empty() { found } else { self.descended(&found, near) }
    }

    fn descended(&self, q: &[f64], wanted: (f64, f64)) -> Vec<f64> {
        let half: Vec<f64> = self.moving().iter().map(|&k| self.half_room(k)).collect();
        let mut known = None;
        let mut q: Vec<f64> = q.to_vec();
        self.moving().iter().for_each(|&k| q[k] = self.within(k, q[k]));
        let mut missing = self.missing(&q, wanted, &mut known);
        let (mut damping, fall, rise, most) = DAMPING;
        for _ in 0..MAX_DESCENT_STEPS {
            if missing.is_empty() || damping > most || Interruption::check().is_err() {
                break;
            }
            let Some(step) = step(&missing, half.len(), damping) else { break };
            let mut next = q.clone();
            for ((&k, d), half) in self.moving().iter().zip(step.iter()).zip(&half) {
                next[k] = self.within(k, q[k] + half * d.clamp(-MAX_STEP_SHARE, MAX_STEP_SHARE));
            }
            let found = self.missing(&next, wanted, &mut known);
            if squared_norm(&found) < squared_norm(&missing) {
                (q, missing) = (next, found);
                damping *= fall;
            } else {
                damping *= rise;
            }
        }
        q
    }

    fn half_room(&self, k: usize) -> f64 {
        let (low, high) = self.problem.limits[k].position;
        0.5 * (high - low)
    }

    fn within(&self, k: usize, q: f64) -> f64 {
        let ((low, high), free) = (self.problem.limits[k].position, 2.0 * FREE_RANGE_SHARE * self.half_room(k));
        q.clamp(low + free, high - free)
    }

    fn missing(&self, q: &[f64], (reserves, most_share): (f64, f64), known: &mut GapCache) -> Missing {
        let (mut rows, scaled) = (Missing::new(), |slope: &[f64], factor: f64| -> Vec<f64> {
            self.moving().iter().map(|&k| factor * slope[k] * self.half_room(k)).collect()
        });
        if let Some(surroundings) = self.problem.surroundings {
            let gaps = surroundings.gaps();
            let most = gaps.iter().map(|gap| reserves * gap.reserve).fold(0.0, f64::max);
            surroundings.near(q, most, known, &mut |gap, room, slope| {
                let wanted = reserves * gaps[gap].reserve;
                if room < wanted {
                    rows.push(((wanted - room) / UNIT_OF_ROOM_M, scaled(slope, -UNIT_OF_ROOM_M.recip())));
                }
            });
        }
        if let Some(wall) = self.problem.torque {
            let (n, states) = (q.len(), at_rest(q));
            let rigid = self.rigid_torques(&states);
            for held in wall.near(self.problem.limits, &states, &rigid, &[1.0], most_share) {
                let mut weights = vec![0.0; n];
                weights[held.coordinate] = held.value.signum() / held.bound;
                let gradient = self.torques_pulled_back(&states, &weights);
                rows.push((held.share() - most_share, scaled(&gradient[..n], 1.0)));
            }
        }
        rows
    }
}

/// The state (q, dq, ddq) of a robot at rest at `q`.
fn at_rest(q: &[f64]) -> Vec<f64> {
    [q, &vec![0.0; 2 * q.len()]].concat()
}

fn squared_norm(missing: &Missing) -> f64 {
    missing.iter().map(|(r, _)| r * r).sum()
}

fn step(missing: &Missing, n: usize, damping: f64) -> Option<DVector<f64>> {
    let slopes = DMatrix::from_fn(missing.len(), n, |i, j| missing[i].1[j]);
    let residuals = DVector::from_iterator(missing.len(), missing.iter().map(|(r, _)| -r));
    let normal = slopes.tr_mul(&slopes) + DMatrix::identity(n, n) * damping;
    Some(normal.cholesky()?.solve(&slopes.tr_mul(&residuals)))
}

/// A limit that some of the random poses violate, with the number of these poses.
#[derive(Clone, Debug, PartialEq)]
pub struct ViolatedLimit {
    /// The violated limit: the least distance of two bodies, or the effort of a coordinate.
    pub what: Obstacle,
    /// Number of random poses that violate the limit.
    pub poses: usize,
}

/// A limit that can prevent a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// Least distance of two bodies; the number is the index of this pair among the limited distances (gaps).
    Gap(usize),
    /// Effort of a drive that cannot hold the weight of its links: index of the coordinate.
    Effort(usize),
}

/// Seed of the random poses in [`broken_at_poses`].
const COUNT_SEED: u64 = 40;

/// Draws `poses` random poses within the position limits. Gives the number of poses that violate no limit, and the violated
/// limits, the most frequent first.
pub fn broken_at_poses(problem: &Problem, poses: usize) -> (usize, Vec<ViolatedLimit>) {
    let prepared = Prepared::new(problem);
    let n = problem.limits.len();
    let gaps = problem.surroundings.map_or(0, |s| s.gaps().len());
    let (all, still) = ((0..gaps).collect::<Vec<usize>>(), vec![0.0; n]);
    let (mut of_gaps, mut of_efforts, mut free) = (vec![0; gaps], vec![0; n], 0);
    // Each pose has its own random stream. So a pose does not depend on how many poses are drawn.
    for pose in 0..poses {
        let mut random = Random::stream(COUNT_SEED, pose as u64);
        let q = prepared.pose(|(low, high)| random.between(low, high));
        let mut is_free = true;
        if let Some(surroundings) = problem.surroundings {
            for ((room, gap), count) in
                surroundings.rooms(&q, &still, &all).iter().zip(surroundings.gaps()).zip(&mut of_gaps)
            {
                let is_broken = room.reached < gap.bound;
                *count += usize::from(is_broken);
                is_free &= !is_broken;
            }
        }
        // At rest only gravity, dry friction and the torque offset load the drives.
        if let Some(wall) = problem.torque {
            let states = at_rest(&q);
            let near = wall.near(problem.limits, &states, &prepared.rigid_torques(&states), &[1.0], 1.0);
            for held in near.iter().filter(|held| held.limit == LimitKind::Effort) {
                of_efforts[held.coordinate] += 1;
                is_free = false;
            }
        }
        free += usize::from(is_free);
    }
    // Only violated limits are listed.
    let of_gaps = of_gaps.into_iter().enumerate().map(|(gap, poses)| ViolatedLimit { what: Obstacle::Gap(gap), poses });
    let of_efforts =
        of_efforts.into_iter().enumerate().map(|(k, poses)| ViolatedLimit { what: Obstacle::Effort(k), poses });
    let mut broken: Vec<ViolatedLimit> = of_gaps.chain(of_efforts).filter(|broken| broken.poses > 0).collect();
    broken.sort_by_key(|broken| std::cmp::Reverse(broken.poses));
    (free, broken)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::gap_proof::tests::Rod;
    use crate::excitation::search::tests::{pendulum_limits, pendulum_torque, problem};
    use crate::excitation::search::{SearchOptions, can_begin, search};
    use crate::pendulum::Pendulum;

    #[test]
    fn a_narrow_place_is_found() {
        let (arm, limits, torque) = (Pendulum::new(), [pendulum_limits()], pendulum_torque());
        let beside = |rod| Problem { surroundings: Some(rod), ..problem(&arm, &limits, &torque) };
        // The rod collides if sin q > -0.9; it is free for q from -1.5 to -1.12, within the range -1.5 to 2.
        let narrow = Rod::new(-0.9);
        let narrow = beside(&narrow);
        let options = SearchOptions { starts: 2, iterations: 10, seed: 3, threads: 1 };
        let found = search(&narrow, &options, &|_, _| ()).unwrap();
        assert!(can_begin(&narrow, 3) && found.iter().all(|f| f.nearest.unwrap().0 > 0.0), "{found:?}");
        let (free, broken) = broken_at_poses(&narrow, 300);
        // The expected share of free poses is 0.38 / 3.5; the bounds of the count allow three standard deviations.
        assert!((15..=50).contains(&free), "{broken:?}");
        assert_eq!(broken, [ViolatedLimit { what: Obstacle::Gap(0), poses: 300 - free }]);

        let nowhere = Rod::new(-1.0);
        let nowhere = beside(&nowhere);
        assert!(!can_begin(&nowhere, 3) && search(&nowhere, &options, &|_, _| ()).is_err());
        assert_eq!(broken_at_poses(&nowhere, 50), (0, vec![ViolatedLimit { what: Obstacle::Gap(0), poses: 50 }]));
    }

    #[test]
    fn a_light_pose_is_found() {
        let (arm, limits, mut torque) = (Pendulum::new(), [pendulum_limits()], pendulum_torque());
        torque.share = 0.4;
        let problem = problem(&arm, &limits, &torque);
        let prepared = Prepared::new(&problem);
        let share = |q: &[f64]| {
            let states = at_rest(q);
            torque.greatest(&limits, &states, &prepared.rigid_torques(&states)).unwrap().0
        };
        let (home, found) = (prepared.home(), prepared.freed(&prepared.home()));
        assert!(share(&home) > 1.0 && share(&found) < WANTED_TORQUE_SHARES[1] + 1e-6, "{} {found:?}", share(&found));
    }
}
