//! Finds torque peaks between the instants of a search, and adds bounds for them to the search.
//!
//! A search bounds torques only at its own instants. Between them, a torque of a chain of thirty joints reaches 1.12 times its
//! bound. If the motion were scaled down by this excess, nearly nothing would remain, because most of the torque is gravity. So
//! before each descent the peaks between the instants are found and bounded too, as in the exchange methods of semi-infinite
//! programs [Hettich, Kortanek 1993].
//!
//! A peak that already exceeds its bound gets a temporary bound slightly above the peak. This temporary bound is lowered as the
//! descents proceed.

use std::collections::{BTreeMap, BTreeSet};

use crate::excitation::problem::Prepared;

/// Number of instants of the finer time grid per instant of the search.
const FINER_FACTOR: usize = 8;
/// If a torque at an instant of the search exceeds this share of its bound, the finer instants around it are evaluated.
const EVALUATED_SHARE: f64 = 0.85;
/// A torque peak between the instants gets a bound if it exceeds this share of its limit.
const PEAK_SHARE: f64 = 0.93;
/// A torque below this share of its bound counts as within the bound: the remaining distance is large enough for a step of the
/// minimizer.
const WITHIN_SHARE: f64 = 0.9995;
/// Ratio of the temporary bound of a torque peak to the value of the peak.
const TEMPORARY_BOUND_RATIO: f64 = 1.005;

/// The bounded torque peaks of one start of a search: numbers of their instants in the finer time grid, with the factors by which
/// their bounds are temporarily raised.
#[derive(Default)]
pub(crate) struct Watched {
    reliefs: BTreeMap<usize, f64>,
    /// Whether a torque was near its bound when peaks were last searched.
    is_pressed: bool,
}

impl Watched {
    /// Whether a torque is near its bound, so that peaks must soon be searched again.
    pub(crate) fn is_pressed(&self) -> bool {
        self.is_pressed
    }

    /// The greatest factor by which the bound of a torque peak is temporarily raised; 1 if no peak exceeds its bound.
    pub(crate) fn relief(&self) -> f64 {
        self.reliefs.values().copied().fold(1.0, f64::max)
    }

    /// The search problem with additional bounds: at the torque peaks of the motion with the scaled coefficients x, and at the
    /// earlier peaks. `None` if there are no peaks.
    pub(crate) fn renewed<'p>(&mut self, prepared: &Prepared<'p>, x: &[f64]) -> Option<Prepared<'p>> {
        let wall = prepared.problem.torque?;
        let limits = prepared.problem.limits;
        let near = |instants: &[usize]| {
            let rows: Vec<[Vec<f64>; 3]> =
                instants.iter().map(|at| prepared.finer_instant(*at, FINER_FACTOR)).collect();
            let mut near = vec![vec![]; instants.len()];
            for (first, part) in rows.chunks(prepared.problem.samples.max(1)).enumerate() {
                let states = prepared.states_at(part, x);
                let rigid = prepared.rigid_torques(&states);
                let held = wall.near(limits, &states, &rigid, &vec![1.0; part.len()], EVALUATED_SHARE);
                for held in held {
                    near[first * prepared.problem.samples + held.instant]
                        .push((2 * held.coordinate + usize::from(held.is_power()), held.share()));
                }
            }
            near
        };
        let own: Vec<usize> = prepared.own_instants(FINER_FACTOR).collect();
        let near_own = near(&own);
        self.is_pressed = near_own.iter().any(|near| !near.is_empty());
        let looked_at: BTreeSet<usize> = own
            .iter()
            .zip(&near_own)
            .filter(|(_, near)| !near.is_empty())
            .flat_map(|(at, _)| {
                (1 - FINER_FACTOR as isize..FINER_FACTOR as isize)
                    .filter_map(|by| prepared.neighbour(*at, by, FINER_FACTOR))
            })
            .collect();
        let looked_at: Vec<usize> = looked_at.into_iter().collect();
        let shares: BTreeMap<usize, Vec<(usize, f64)>> = looked_at.iter().copied().zip(near(&looked_at)).collect();
        let of = |at: Option<usize>, which: usize| {
            let all = at.and_then(|at| shares.get(&at)).into_iter().flatten();
            all.filter(|(k, _)| *k == which).map(|(_, share)| *share).fold(0.0, f64::max)
        };
        let own: BTreeSet<usize> = own.into_iter().collect();
        let greatest = |at: usize| shares.get(&at).into_iter().flatten().map(|(_, share)| *share).fold(0.0, f64::max);
        for (&at, all) in shares.iter().filter(|(at, _)| !own.contains(at)) {
            let is_peak = all.iter().any(|&(k, share)| {
                let [before, after] = [-1, 1].map(|by| of(prepared.neighbour(at, by, FINER_FACTOR), k));
                share >= PEAK_SHARE && share >= before && share > after
            });
            if is_peak {
                self.reliefs.entry(at).or_insert(f64::INFINITY);
            }
        }
        self.reliefs.retain(|at, _| greatest(*at) > 0.0 || self.is_pressed && prepared.is_halfway(*at, FINER_FACTOR));
        if self.is_pressed {
            // In the next steps of the descent, new peaks may appear anywhere. Additional bounds halfway between the instants
            // of the search reduce the excess of such peaks to a quarter.
            prepared.halfway_instants(FINER_FACTOR).for_each(|at| _ = self.reliefs.entry(at).or_insert(f64::INFINITY));
        }
        // If a torque is already within its bound, the bound is not raised.
        let above = |share: f64| if share < WITHIN_SHARE { 1.0 } else { TEMPORARY_BOUND_RATIO * share };
        self.reliefs.iter_mut().for_each(|(at, relief)| *relief = relief.min(above(greatest(*at))));
        if self.reliefs.is_empty() {
            return None;
        }
        let mut watching = prepared.clone();
        watching.watch(self.reliefs.iter().map(|(at, relief)| (prepared.finer_instant(*at, FINER_FACTOR), *relief)));
        Some(watching)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::criterion::SearchObjective;
    use crate::excitation::fourier_series::FourierSeries;
    use crate::excitation::limits::CoordinateLimits;
    use crate::excitation::motion::MotionShape;
    use crate::excitation::problem::Problem;
    use crate::excitation::search::tests::{pendulum_limits, pendulum_torque};
    use crate::pendulum::Pendulum;

    /// Checks that a peak between six instants per period is found and gets a bound above it. A motion far from its bounds gets
    /// none.
    #[test]
    fn a_peak_between_instants_is_watched() {
        let (arm, wall) = (Pendulum::new(), pendulum_torque());
        let of_effort = |effort: f64| [CoordinateLimits { effort: Some(effort), ..pendulum_limits() }];
        let x = [0.0, 0.7, 0.55, 0.0, 0.0];
        let seen = |limits: &[CoordinateLimits]| {
            let problem = Problem {
                regressor: &arm,
                friction: &[],
                limits,
                noise: &[0.1],
                aim: SearchObjective::Determinant,
                torque: Some(&wall),
                columns: &[true; 3],
                shape: MotionShape::Fourier(FourierSeries { period: 5.0, blend: 0.0, harmonics: 2 }),
                samples: 6,
                surroundings: None,
                prior: &[],
            };
            let prepared = Prepared::new(&problem);
            let finest = (0..FINER_FACTOR * problem.samples)
                .map(|at| prepared.finer_instant(at, FINER_FACTOR))
                .collect::<Vec<_>>();
            let states = prepared.states_at(&finest, &x);
            let truth = wall.greatest(limits, &states, &prepared.rigid_torques(&states)).unwrap().0;
            let mut watched = Watched::default();
            let renewed = watched.renewed(&prepared, &x).map(|p| p.greatest_torque(&x).unwrap().0);
            (prepared.greatest_torque(&x).unwrap().0, truth, renewed, watched)
        };
        let (alone, ..) = seen(&of_effort(12.0));
        // At the instants of the search the torque reaches 0.97 of this effort limit; between them it exceeds the limit.
        let effort = of_effort((12.0 - 0.2 / 0.9) * alone / 0.97 + 0.2 / 0.9);
        let (alone, truth, renewed, watched) = seen(&effort);
        assert!((alone - 0.97).abs() < 1e-9 && truth > 1.0, "{alone} {truth}");
        assert!((renewed.unwrap() - truth).abs() < 1e-12, "{renewed:?} {truth}");
        assert!((watched.relief() - TEMPORARY_BOUND_RATIO * truth).abs() < 1e-12 && watched.is_pressed());
        let (_, truth, renewed, watched) = seen(&of_effort(1000.0));
        assert!(truth < EVALUATED_SHARE && renewed.is_none() && !watched.is_pressed() && watched.relief() == 1.0);
    }
}
