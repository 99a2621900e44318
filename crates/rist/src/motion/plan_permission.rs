//! Decides which motions a plan may choose: torques and distances between bodies must keep their limits with a margin.
//!
//! Torques are checked at instants of one period, distances at places on the straight path between the ends of the motion. The
//! proof of the chosen experiments covers the motion in between ([`crate::motion::planning`]).
//!
//! A swing is a periodic motion between two ends; a sweep is a slow motion through the range and back. A gap is a pair of
//! bodies, or a body and a floor or wall, with a least allowed distance.

use experiments::excitation::gap_proof::{GapCache, Surroundings};
use experiments::excitation::limits::AskedLimits;
use experiments::excitation::proof::NominalFriction;
use experiments::plan::exciting_trajectory::{ExcitingTrajectory, JointMotion};
use experiments::plan::permission::Permission;

use crate::describe::adapters::surroundings::RobotSurroundings;
use crate::describe::model::Model;
use crate::motion::known_torque::KnownTorque;
use crate::motion::nominal::nominal_friction;

/// Number of instants per period at which torques are checked. The instants are shifted by half a step, so that no instant is
/// at a corner of the motion.
const TORQUE_INSTANTS: usize = 64;
/// Largest step of a coordinate between two places at which distances are checked, rad (m).
const LARGEST_STEP_RAD_M: f64 = 0.1;
/// Range of the number of places on the straight path of a motion.
const PLACES_ON_PATH: std::ops::RangeInclusive<usize> = 5..=60;

/// Requirements of the description and of the user on torques and distances.
pub(crate) struct PlanPermission<'a> {
    model: &'a Model,
    /// Known base parameters of the robot, and known base parameters with a possible payload; empty if no base parameters are
    /// known.
    parameters: Vec<Vec<f64>>,
    friction: Vec<NominalFriction>,
    /// Largest allowed torque without dry friction, one per coordinate, N m (N); `None` if there is no limit.
    most: Vec<Option<f64>>,
    surroundings: &'a RobotSurroundings,
}

impl<'a> PlanPermission<'a> {
    /// `share`: share of the limits of effort that a torque may use; `known`: the known torques of the robot.
    pub(crate) fn new(
        model: &'a Model,
        limits: &[AskedLimits],
        share: f64,
        known: &KnownTorque,
        surroundings: &'a RobotSurroundings,
    ) -> PlanPermission<'a> {
        let friction = nominal_friction(model);
        let most = |(l, f): (&AskedLimits, &NominalFriction)| l.effort.map(|effort| share * effort - f.coulomb.abs());
        let most = limits.iter().zip(&friction).map(most).collect();
        let loaded = known.loaded.as_ref().map(|(_, parameters)| parameters);
        let parameters = known.parameters.iter().chain(loaded).cloned().collect();
        PlanPermission { model, parameters, friction, most, surroundings }
    }

    /// Whether distances and torques at rest keep their limits at the pose `q`. `known`: distances at the previous pose of the
    /// path, which are reused to save time.
    fn is_free(&self, q: &[f64], known: &mut GapCache) -> bool {
        let mut is_free = true;
        let most = self.surroundings.gaps.iter().map(|gap| gap.reserve).fold(0.0, f64::max);
        self.surroundings.near(q, most, known, &mut |gap, room, _| {
            is_free &= room >= self.surroundings.gaps[gap].reserve;
        });
        let still = vec![0.0; q.len()];
        is_free && self.is_strong_enough(&[[q.to_vec(), still.clone(), still]])
    }

    fn is_strong_enough(&self, states: &[[Vec<f64>; 3]]) -> bool {
        let Some(p) = self.parameters.first().map(Vec::len).filter(|_| self.most.iter().any(Option::is_some)) else {
            return true;
        };
        let regressor = self.model.regressor();
        let mut y = vec![0.0; self.most.len() * p];
        states.iter().all(|[q, dq, ddq]| {
            regressor.fill(q, dq, ddq, &mut y);
            let kept = |(k, most): (usize, &Option<f64>)| {
                let f = &self.friction[k];
                let rigid =
                    |parameters: &Vec<f64>| -> f64 { y[k * p..][..p].iter().zip(parameters).map(|(y, x)| y * x).sum() };
                let torques = self.parameters.iter().map(|parameters| rigid(parameters) + f.viscous * dq[k] + f.offset);
                most.is_none_or(|most| torques.into_iter().all(|torque| torque.abs() <= most))
            };
            self.most.iter().enumerate().all(kept)
        })
    }
}

impl Permission for PlanPermission<'_> {
    fn pose(&self, q: &[f64]) -> bool {
        self.is_free(q, &mut None)
    }

    fn motion(&self, trajectory: &ExcitingTrajectory) -> bool {
        let n = trajectory.centre.len();
        let half: Vec<f64> = match &trajectory.motion {
            JointMotion::Swing { half_range, .. } => half_range.clone(),
            JointMotion::Sweep { range, .. } => {
                (0..n).map(|k| if k == trajectory.fast { 0.5 * range } else { 0.0 }).collect()
            }
        };
        // q = centre + share * half range on the straight path, with a share from -1 to 1.
        let at = |share: f64| -> Vec<f64> { trajectory.centre.iter().zip(&half).map(|(c, h)| c + share * h).collect() };
        let longest = half.iter().fold(0.0_f64, |m, h| m.max(2.0 * h.abs()));
        let places = (longest / LARGEST_STEP_RAD_M).ceil() as usize;
        let places = places.clamp(*PLACES_ON_PATH.start(), *PLACES_ON_PATH.end());
        let on_the_path = |i: usize| 2.0 * i as f64 / places as f64 - 1.0;
        // Swing: dq = h p'(s) / T, ddq = h p''(s) / T^2; h: half range, p: profile, s = t / T, T: period. Sweep: at each place,
        // the largest velocity and acceleration of the sweep, in both directions.
        let states: Vec<[Vec<f64>; 3]> = match &trajectory.motion {
            JointMotion::Swing { profile, period, .. } => {
                let t = *period as f64 * trajectory.sample_time;
                let of = |i: usize| {
                    let (p, dp, ddp) = profile.at((i as f64 + 0.5) / TORQUE_INSTANTS as f64);
                    let times = |x: f64| half.iter().map(|h| h * x).collect::<Vec<f64>>();
                    [at(p), times(dp / t), times(ddp / (t * t))]
                };
                (0..TORQUE_INSTANTS).map(of).collect()
            }
            JointMotion::Sweep { velocity, acceleration, .. } => {
                let only = |x: f64| (0..n).map(|k| if k == trajectory.fast { x } else { 0.0 }).collect::<Vec<f64>>();
                let of = |(i, forth, up): (usize, f64, f64)| {
                    [at(on_the_path(i)), only(forth * velocity), only(up * acceleration)]
                };
                let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
                (0..=places).flat_map(|i| signs.map(|(forth, up)| (i, forth, up))).map(of).collect()
            }
        };
        let mut known = None;
        self.is_strong_enough(&states) && (0..=places).all(|i| self.is_free(&at(on_the_path(i)), &mut known))
    }
}
