//! The distances between bodies as a barrier, which keeps the steps of a minimizer free of collisions.
//!
//! The barrier S is evaluated at N instants of the motion. r: distance of two solids, minus their bound, minus their reserve
//! (additional distance for the motion between the instants). w: value of r below which the barrier acts. With s = r / w:
//!
//! S = -1/N sum [log s + (1 - s) + (1 - s)^2 / 2]   over all pairs of solids with s < 1, at all instants
//!
//! S tends to infinity at r = 0, like a logarithm. At s = 1 its first and second derivative are zero.

use std::cell::{RefCell, RefMut};

use crate::excitation::gap_proof::{GapCache, Surroundings};
use crate::excitation::motion::MotionShape;
use crate::excitation::near_gaps::NearGaps;

/// The distance barrier acts on two solids whose distance exceeds its lower bound by less than this value, m.
const BARRIER_RANGE_M: f64 = 0.05;
/// Instants per period and harmonic (a harmonic has two coefficients per coordinate). Between two instants, dt apart, a body
/// with the acceleration a deviates by up to a dt^2 / 8 from the interpolated distance. Example: in the highest of eight
/// harmonics of a period of ten seconds, a body with 2 m/s deviates by 2 mm, half of a reserve.
const INSTANTS_PER_HARMONIC: usize = 32;
/// Number of instants in each blend (motion from rest to the Fourier series, or back) at which the distance barrier is evaluated.
const DISTANCE_INSTANTS_PER_BLEND: usize = 24;
/// Least number of instants per period at which the distance barrier is evaluated.
const MIN_INSTANTS_PER_PERIOD: usize = 200;
/// Least distance of two bodies minus its bound at the start of a descent, in multiples of the reserve of the pair (additional
/// distance that a search keeps).
const INITIAL_RESERVES: f64 = 2.0;

/// Intermediate results of the distance computation at each instant, which make the next evaluation faster.
///
/// Each start of a search (descent from one initial motion) has its own data, so its result is independent of other starts.
#[derive(Default)]
pub struct Seen(RefCell<Vec<GapCache>>);

/// The barrier S of the distances between bodies.
#[derive(Clone)]
pub struct DistanceBarrier<'a> {
    surroundings: &'a dyn Surroundings,
    /// Basis functions at each instant: position of a coordinate per unit of each coefficient.
    instants: Vec<Vec<f64>>,
}

impl<'a> DistanceBarrier<'a> {
    /// Makes the barrier for motions of this shape.
    pub fn new(surroundings: &'a dyn Surroundings, shape: &MotionShape) -> DistanceBarrier<'a> {
        let count = (INSTANTS_PER_HARMONIC * (shape.size() / 2)).max(MIN_INSTANTS_PER_PERIOD);
        let of_blends = (0..DISTANCE_INSTANTS_PER_BLEND).map(|i| i as f64 / DISTANCE_INSTANTS_PER_BLEND as f64);
        DistanceBarrier { surroundings, instants: shape.rows(0, count, of_blends) }
    }

    /// `height` times the barrier S. `None` if a distance minus its reserve is not positive, or if the value is above `at_most`.
    ///
    /// `positions` computes the coordinates from the basis functions at an instant. `along` receives these basis functions, with
    /// the gradient of `height` S by the coordinates at the instant. Each distance on which the barrier acts is added to `felt`.
    pub(crate) fn value(
        &self,
        seen: &Seen,
        positions: &dyn Fn(&[f64]) -> Vec<f64>,
        height: f64,
        at_most: f64,
        felt: &mut NearGaps,
        along: &mut dyn FnMut(&[f64], &[f64]),
    ) -> Option<f64> {
        let weight = height / self.instants.len() as f64;
        let mut value = 0.0;
        // The barrier S and its gradient dS/dq at each instant; both are zero if no two bodies are near each other.
        let mut seen = self.seen(seen);
        for (instant, (row, known)) in self.instants.iter().zip(seen.iter_mut()).enumerate() {
            let q = positions(row);
            let (mut total, mut is_near, mut is_kept) = (vec![0.0; q.len()], false, true);
            self.surroundings.near(&q, BARRIER_RANGE_M, known, &mut |gap, room, slope| {
                let reserve = self.surroundings.gaps()[gap].reserve;
                let width = BARRIER_RANGE_M - reserve;
                let s = (room - reserve) / width;
                if s.is_nan() || s <= 0.0 {
                    is_kept = false;
                } else if s < 1.0 {
                    is_near = true;
                    value -= s.ln() + (1.0 - s) + 0.5 * (1.0 - s).powi(2);
                    // The derivative of -(log s + (1 - s) + (1 - s)^2 / 2) by the distance, times height / N.
                    let rate = weight * (2.0 - s - 1.0 / s) / width;
                    total.iter_mut().zip(slope).for_each(|(t, x)| *t += rate * x);
                    felt.push(instant, room - reserve, weight * (s.powi(-2) - 1.0) / width.powi(2), slope);
                }
            });
            // S has no negative terms, so a partial sum above `at_most` stays above it.
            if !(is_kept && weight * value <= at_most) {
                return None;
            }
            if is_near {
                along(row, &total);
            }
        }
        Some(weight * value)
    }

    /// The basis functions at each instant of the barrier, one row per instant.
    pub(crate) fn rows(&self) -> &[Vec<f64>] {
        &self.instants
    }

    /// The gap (limited distance) with the least ratio of room to reserve, where room is the distance minus its bound. Returns
    /// this room (m) and the index of the gap. `None` if no two solids are near each other.
    pub fn nearest(&self, seen: &Seen, positions: &dyn Fn(&[f64]) -> Vec<f64>) -> Option<(f64, usize)> {
        let mut nearest: Option<(f64, usize)> = None;
        let mut seen = self.seen(seen);
        for (row, known) in self.instants.iter().zip(seen.iter_mut()) {
            self.nearest_at(&positions(row), known, &mut nearest);
        }
        nearest
    }

    /// The intermediate results of the previous evaluation, one entry per instant.
    fn seen<'s>(&self, seen: &'s Seen) -> RefMut<'s, Vec<GapCache>> {
        let mut seen = seen.0.borrow_mut();
        seen.resize_with(self.instants.len(), || None);
        seen
    }

    /// Replaces `nearest` by the nearest gap at configuration `q` if this gap has a smaller ratio of room (distance minus its
    /// bound) to reserve.
    pub fn nearest_at(&self, q: &[f64], known: &mut GapCache, nearest: &mut Option<(f64, usize)>) {
        let beside_reserve = |(room, gap): (f64, usize)| room / self.surroundings.gaps()[gap].reserve;
        self.surroundings.near(q, BARRIER_RANGE_M, known, &mut |gap, room, _| {
            if nearest.is_none_or(|n| beside_reserve((room, gap)) < beside_reserve(n)) {
                *nearest = Some((room, gap));
            }
        });
    }

    /// Whether the distance of the nearest gap is large enough for the start of a descent. `nearest`: distance minus its bound
    /// (m) and index of the gap; `None`: no bodies are near each other, so the distance is large enough.
    pub fn is_inside(&self, nearest: Option<(f64, usize)>) -> bool {
        nearest.is_none_or(|(room, gap)| room > INITIAL_RESERVES * self.surroundings.gaps()[gap].reserve)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::fourier_series::FourierSeries;
    use crate::excitation::gap_proof::tests::Rod;
    use crate::excitation::near_gaps::EnforcedGap;

    #[test]
    fn bends_are_those_of_differences() {
        let rod = Rod::new(0.72);
        let series = FourierSeries { period: 5.0, blend: 1.0, harmonics: 2 };
        let wall = DistanceBarrier::new(&rod, &MotionShape::Fourier(series));
        let felt_at = |x: &[f64]| {
            let positions = |row: &[f64]| vec![row.iter().zip(x).map(|(b, x)| b * x).sum()];
            let (seen, mut felt, mut slopes) = (Seen::default(), NearGaps::default(), vec![]);
            let value =
                wall.value(&seen, &positions, 0.1, f64::INFINITY, &mut felt, &mut |_, slope| slopes.push(slope[0]));
            ((value, wall.nearest(&seen, &positions)), felt, slopes)
        };
        let at = |x: &[f64]| felt_at(x).0;
        let x = [0.3, 0.3, -0.2, 0.2, 0.4];
        let (value, nearest) = at(&x);
        assert!(value.unwrap() > 0.0 && wall.is_inside(nearest), "{value:?} {nearest:?}");
        // Here `bend` (second derivative of the barrier) must equal the change of its first derivative per change of the
        // distance.
        let moved = |h: f64| {
            let (_, felt, slopes) = felt_at(&x.map(|x| x * (1.0 + h)));
            let rate =
                |((held, slope), along): ((&EnforcedGap, &[f64]), &f64)| (held.room, along / slope[0], held.bend);
            felt.rooms().zip(&slopes).map(rate).collect::<Vec<_>>()
        };
        let (before, here, after) = (moved(-1e-6), moved(0.0), moved(1e-6));
        assert!(!here.is_empty() && before.len() == here.len() && after.len() == here.len());
        for ((before, here), after) in before.iter().zip(&here).zip(&after) {
            let difference = (after.1 - before.1) / (after.0 - before.0);
            assert!((here.2 - difference).abs() < 1e-5 * here.2.max(1.0), "{here:?} {difference}");
        }
        assert!(at(&[1.5, 0.0, 0.0, 0.0, 0.0]).0.is_none());
        assert!(at(&[0.0; 5]).1.is_none());
    }
}
