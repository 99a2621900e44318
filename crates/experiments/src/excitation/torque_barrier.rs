//! The limits of torques and powers as a logarithmic barrier T, which keeps the steps of a minimizer inside the limits.
//!
//! S: number of instants in a period. The sum is over all coordinates, at the instants of the period and of the blends (motions
//! from rest and to rest). v: value of a torque or power; u: bound of v.
//!
//! T = -1/S sum [log((u - v) / u) + log((u + v) / u)]
//!
//! | v | u |
//! |---|---|
//! | tau = Y X + FV dq + OFF, N m (N) | share effort - FS |
//! | P = tau dq + FS abs(dq), W | share power |
//!
//! Y: regressor; X: its parameters; FV, OFF, FS: viscous, constant and dry friction; share: usable share of a limit. At rest P is
//! zero and the barrier is flat; therefore T has a continuous gradient although abs(dq) has none.

use crate::excitation::limits::{CoordinateLimits, LimitKind};
use crate::excitation::proof::NominalFriction;

/// Share of their bounds that torques and powers may use at sampled instants; the rest of the bound covers peaks between them.
const BOUND_SHARE_AT_SAMPLES: f64 = 0.995;

/// The logarithmic barrier T of the nominal torques and powers of a robot.
#[derive(Clone, Debug)]
pub struct TorqueBarrier {
    /// Values of the base parameters, in the order of the regressor.
    pub parameters: Vec<f64>,
    /// Friction coefficients, one per coordinate.
    pub friction: Vec<NominalFriction>,
    /// Share of the effort and power limits that a motion may use.
    pub share: f64,
}

/// A torque or power of a coordinate at an instant, with its bound.
struct BoundedQuantity {
    limit: LimitKind,
    value: f64,
    bound: f64,
    /// Derivatives of the value by the torque tau and by the velocity dq.
    along: [f64; 2],
}

impl TorqueBarrier {
    /// The limited quantities of coordinate k at velocity `dq`: torque and power, as far as they are limited. `rigid`: torque of
    /// this coordinate without friction, N m (N).
    fn bounded_quantities(
        &self,
        k: usize,
        limits: &CoordinateLimits,
        dq: f64,
        rigid: f64,
    ) -> impl Iterator<Item = BoundedQuantity> {
        let f = self.friction[k];
        let dry = f.coulomb.abs();
        let tau = rigid + f.viscous * dq + f.offset;
        let effort = limits.effort.map(|effort| BoundedQuantity {
            limit: LimitKind::Effort,
            value: tau,
            bound: BOUND_SHARE_AT_SAMPLES * (self.share * effort - dry),
            along: [1.0, 0.0],
        });
        let power = limits.power.map(|power| BoundedQuantity {
            limit: LimitKind::Power,
            value: tau * dq + dry * dq.abs(),
            bound: BOUND_SHARE_AT_SAMPLES * self.share * power,
            along: [dq, tau + dry * dq.signum()],
        });
        effort.into_iter().chain(power)
    }

    /// The greatest ratio of a torque or power to its bound, over all instants, with the coordinate and the kind of limit. `None`
    /// if no torque or power is limited.
    ///
    /// `states`: (q, dq, ddq), instant after instant. `rigid`: torque of each coordinate without friction, instant after instant.
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
                for held in self.bounded_quantities(k, &limits[k], state[n + k], rigid[k]) {
                    let share = if held.bound > 0.0 { held.value.abs() / held.bound } else { f64::INFINITY };
                    if greatest.is_none_or(|g| share > g.0) {
                        greatest = Some((share, k, held.limit));
                    }
                }
            }
        }
        greatest
    }

    /// The value of the torque barrier T, with its derivatives by torque and velocity of each coordinate, instant after instant.
    /// `None` if a torque or power exceeds its bound. `reliefs`: factors by which the bounds are temporarily raised, one per
    /// instant. `weight` computes the weight of an instant in the sum from its factor.
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
                for held in self.bounded_quantities(k, &limits[k], state[n + k], rigid[k]) {
                    let held = BoundedQuantity { bound: relief * held.bound, ..held };
                    let weight = weight(*relief);
                    // Distances to the upper and the lower bound. The barrier is infinite if one of them is not positive.
                    let (above, below) = (held.bound - held.value, held.bound + held.value);
                    if !(above > 0.0 && below > 0.0) {
                        return None;
                    }
                    value -= weight * (above / held.bound * (below / held.bound)).ln();
                    let slope = weight * (1.0 / above - 1.0 / below);
                    // The torque tau contains FV dq (viscous friction), so the derivative by tau also contributes to the
                    // derivative by dq.
                    let [along_tau, along_dq] = held.along.map(|x| slope * x);
                    along[0] += along_tau;
                    along[1] += along_tau * self.friction[k].viscous + along_dq;
                }
                slopes.push(along);
            }
        }
        Some((value, slopes))
    }

    /// The torques and powers, at all instants, whose magnitude is at least `least_share` of their bound.
    pub(crate) fn near(
        &self,
        limits: &[CoordinateLimits],
        states: &[f64],
        rigid: &[f64],
        reliefs: &[f64],
        least_share: f64,
    ) -> Vec<EnforcedDrive> {
        let n = limits.len();
        let mut near = vec![];
        let instants = states.chunks_exact(3 * n).zip(rigid.chunks_exact(n)).zip(reliefs);
        for (instant, ((state, rigid), relief)) in instants.enumerate() {
            for coordinate in 0..n {
                for held in
                    self.bounded_quantities(coordinate, &limits[coordinate], state[n + coordinate], rigid[coordinate])
                {
                    let BoundedQuantity { limit, value, bound, along: [along_tau, along_dq] } = held;
                    // The torque tau also depends on dq by viscous friction: d tau / d dq = FV.
                    let along = [along_tau, along_tau * self.friction[coordinate].viscous + along_dq];
                    let drive = EnforcedDrive {
                        instant,
                        coordinate,
                        limit,
                        value,
                        bound: relief * bound,
                        relief: *relief,
                        along,
                    };
                    // `share` is the ratio of the value to its bound, which `relief` may have raised.
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
pub(crate) struct EnforcedDrive {
    /// Index of the instant among all instants at which torques are evaluated.
    pub(crate) instant: usize,
    pub(crate) coordinate: usize,
    pub(crate) limit: LimitKind,
    pub(crate) value: f64,
    pub(crate) bound: f64,
    /// Factor by which the bound is temporarily raised; 1: not raised. It is already included in `bound`.
    pub(crate) relief: f64,
    /// Derivatives of the value by the torque without friction and by the velocity dq.
    pub(crate) along: [f64; 2],
}

impl EnforcedDrive {
    pub(crate) fn is_power(&self) -> bool {
        self.limit == LimitKind::Power
    }

    /// The ratio of the value's magnitude to the bound; infinite if the bound is not positive.
    pub(crate) fn share(&self) -> f64 {
        if self.bound > 0.0 { self.value.abs() / self.bound } else { f64::INFINITY }
    }
}
