//! The torques and powers of the drives as a wall that a descent stays within.
//!
//! With S instants a period, and a sum over all coordinates at the instants of the period and of the blends,
//!
//! T = -1/S sum log((u - v) / u) + log((u + v) / u)
//!
//! | v | u |
//! |---|---|
//! | tau = Y X + FV dq + OFF, N m (N) | share effort - FS |
//! | P = tau dq + FS abs(dq), W | share power |
//!
//! At rest P is zero and the wall flat, so that T has a continuous slope where abs(dq) has none.

use crate::excitation::limits::{CoordinateLimits, LimitKind};
use crate::excitation::proof::DescribedFriction;

/// Share of their bound that torques and powers keep at samples. The rest is for what they do in between.
const BOUND_SHARE_AT_SAMPLES: f64 = 0.995;

/// Torques of the description that a motion must keep within.
#[derive(Clone, Debug)]
pub struct TorqueWall {
    /// Base parameters, in the order of the regressor.
    pub parameters: Vec<f64>,
    /// One per coordinate.
    pub friction: Vec<DescribedFriction>,
    /// Share of the limits of effort and power.
    pub share: f64,
}

/// A quantity of a coordinate at an instant that has a bound.
struct Held {
    limit: LimitKind,
    value: f64,
    bound: f64,
    /// Slopes of the value along tau and along dq.
    along: [f64; 2],
}

impl TorqueWall {
    /// The bounded quantities of coordinate k at velocity `dq`; `rigid`: Y X.
    fn held(&self, k: usize, limits: &CoordinateLimits, dq: f64, rigid: f64) -> impl Iterator<Item = Held> {
        let f = self.friction[k];
        let dry = f.coulomb.abs();
        let tau = rigid + f.viscous * dq + f.offset;
        let effort = limits.effort.map(|effort| Held {
            limit: LimitKind::Effort,
            value: tau,
            bound: BOUND_SHARE_AT_SAMPLES * (self.share * effort - dry),
            along: [1.0, 0.0],
        });
        let power = limits.power.map(|power| Held {
            limit: LimitKind::Power,
            value: tau * dq + dry * dq.abs(),
            bound: BOUND_SHARE_AT_SAMPLES * self.share * power,
            along: [dq, tau + dry * dq.signum()],
        });
        effort.into_iter().chain(power)
    }

    /// The greatest quantity over its bound, with its coordinate and limit; `None` where nothing is bounded.
    ///
    /// `states`: q, dq, ddq after each other, instant after instant. `rigid`: Y X of each coordinate, instant after instant.
    pub fn greatest(
        &self,
        limits: &[CoordinateLimits],
        states: &[f64],
        rigid: &[f64],
    ) -> Option<(f64, usize, LimitKind)> {
        let n = limits.len();
        let mut greatest: Option<(f64, usize, LimitKind)> = None;
        for (state, rigid) in states.chunks_exact(3 * n).zip(rigid.chunks_exact(n)) {
            for k in 0..n {
                for held in self.held(k, &limits[k], state[n + k], rigid[k]) {
                    let share = if held.bound > 0.0 { held.value.abs() / held.bound } else { f64::INFINITY };
                    if greatest.is_none_or(|g| share > g.0) {
                        greatest = Some((share, k, held.limit));
                    }
                }
            }
        }
        greatest
    }

    /// The sum of T with the weight of each instant, by what its bounds are times, with its slopes along the torque and the velocity of each coordinate, instant after instant;
    /// `None` where a quantity is beyond its bound. `reliefs`: what the bounds are times, one per instant.
    pub fn value(
        &self,
        limits: &[CoordinateLimits],
        weight: impl Fn(f64) -> f64,
        (states, rigid): (&[f64], &[f64]),
        reliefs: &[f64],
    ) -> Option<(f64, Vec<[f64; 2]>)> {
        let n = limits.len();
        let mut value = 0.0;
        let mut slopes = Vec::with_capacity(states.len() / 3);
        for ((state, rigid), relief) in states.chunks_exact(3 * n).zip(rigid.chunks_exact(n)).zip(reliefs) {
            for k in 0..n {
                let mut along = [0.0; 2];
                for held in self.held(k, &limits[k], state[n + k], rigid[k]) {
                    let held = Held { bound: relief * held.bound, ..held };
                    let weight = weight(*relief);
                    let (above, below) = (held.bound - held.value, held.bound + held.value);
                    if !(above > 0.0 && below > 0.0) {
                        return None;
                    }
                    value -= weight * (above / held.bound * (below / held.bound)).ln();
                    let slope = weight * (1.0 / above - 1.0 / below);
                    let [along_tau, along_dq] = held.along.map(|x| slope * x);
                    along[0] += along_tau;
                    along[1] += along_tau * self.friction[k].viscous + along_dq;
                }
                slopes.push(along);
            }
        }
        Some((value, slopes))
    }

    /// The quantities from `least_share` of their bounds on.
    pub(crate) fn near(
        &self,
        limits: &[CoordinateLimits],
        states: &[f64],
        rigid: &[f64],
        reliefs: &[f64],
        least_share: f64,
    ) -> Vec<HeldDrive> {
        let n = limits.len();
        let mut near = vec![];
        let instants = states.chunks_exact(3 * n).zip(rigid.chunks_exact(n)).zip(reliefs);
        for (instant, ((state, rigid), relief)) in instants.enumerate() {
            for coordinate in 0..n {
                for held in self.held(coordinate, &limits[coordinate], state[n + coordinate], rigid[coordinate]) {
                    let Held { limit, value, bound, along: [along_tau, along_dq] } = held;
                    let along = [along_tau, along_tau * self.friction[coordinate].viscous + along_dq];
                    let drive =
                        HeldDrive { instant, coordinate, limit, value, bound: relief * bound, relief: *relief, along };
                    if drive.share() >= least_share {
                        near.push(drive);
                    }
                }
            }
        }
        near
    }
}

/// A torque or a power of a coordinate at an instant, with its bound.
#[derive(Clone, Copy)]
pub(crate) struct HeldDrive {
    /// Place of the instant among those that are looked at.
    pub(crate) instant: usize,
    pub(crate) coordinate: usize,
    pub(crate) limit: LimitKind,
    pub(crate) value: f64,
    pub(crate) bound: f64,
    /// What the bound is times.
    pub(crate) relief: f64,
    /// Slopes of the value along Y X and along dq.
    pub(crate) along: [f64; 2],
}

impl HeldDrive {
    pub(crate) fn is_power(&self) -> bool {
        self.limit == LimitKind::Power
    }

    /// Its size over its bound.
    pub(crate) fn share(&self) -> f64 {
        if self.bound > 0.0 { self.value.abs() / self.bound } else { f64::INFINITY }
    }
}
