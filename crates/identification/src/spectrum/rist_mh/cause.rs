//! The effect that the model most likely lacks: late torques, ripple, springs, eccentric encoders, elastic joints, play.
//!
//! Each candidate is added to the fit with its columns (`effects`), for all joints at once. Friction and weights are then
//! chosen again. Two numbers decide; both are computed with the measured noise. The misfit of a fit is (chi^2 per degree of
//! freedom) - 1, because noise alone gives 1. The first number is the share of the misfit that the candidate explains (0:
//! without, 1: with the candidate; nu: degrees of freedom),
//!   1 - (chi_1^2 / nu_1 - 1) / (chi_0^2 / nu_0 - 1).
//! The second number is the probability that the m columns of the candidate explain as much of an independent residual by
//! chance, from
//!   F = ((chi_0^2 - chi_1^2) / m) / (chi_1^2 / nu_1) ~ F(m, nu_1).
//! The candidate with the largest share is the cause, if the share is at least `NAMED_CAUSE_SHARE` and F is significant at
//! `SIGNIFICANCE_LEVEL`.
//!
//! The share is the stronger criterion. The residual is not noise, so with some hundred rows any column with a small
//! correlation has a significant F. A cause that explains less than half is at most one of several causes. F is needed if there
//! are few rows. The significance level of F is one in a thousand. For ripple many numbers of periods are tried, and the level
//! holds for all of them together (Bonferroni).
//!
//! The columns of an elastic joint and of play are correlated if the torque has nearly two values only, as in a bang-bang
//! motion. Then play can be distinguished from the spring only if its gap is wider than the deflection of the spring.
//!
//! Ripple of k periods per turn is tried at a joint under two conditions. The motions of the joint cover at least half a
//! period, k range(q) >= pi, because in a smaller range the ripple is correlated with gravity. The ripple is within the band of
//! the equations, k rms(dq) <= 2 pi f, f: highest frequency of the equations.

use linear_model::friction::periodic::FrictionShape;
use numerics::student::exceeded;
use numerics::vector::dot;

use crate::estimate::log_check::{Basis, square};
use crate::spectrum::rist_mh::data::{HarmonicData, HarmonicOptions};
use crate::spectrum::rist_mh::effects::{Effect, EffectSize};
use crate::spectrum::rist_mh::fit::IterationState;
use crate::spectrum::rist_mh::misfit::Misfit;

/// A cause is named if it explains at least this share of the misfit. The misfit is chi^2 per degree of freedom minus 1,
/// because noise alone gives 1. A cause that explains half of the misfit explains at least as much as all other effects
/// together.
pub(crate) const NAMED_CAUSE_SHARE: f64 = 0.5;
/// Columns are significant if the probability that chance gives their F statistic is below this value.
pub(crate) const SIGNIFICANCE_LEVEL: f64 = 1e-3;
/// Largest number of ripple periods per turn that is tried. No encoder resolves more periods.
const MAX_RIPPLE_PERIODS_PER_TURN: usize = 1024;
/// A joint is named if an unknown of its effect exceeds this many standard deviations. A normal error exceeds this limit by
/// chance with the probability `SIGNIFICANCE_LEVEL`.
const NAMED_JOINT_SIGMAS: f64 = 3.3;
/// A joint is named if the sum of squared torques of its effect is at least this share of the largest sum of all joints. A
/// smaller torque is attributed to the effect at another joint.
const LEAST_SQUARE_SHARE: f64 = 0.02;

/// The effect that the model most likely lacks.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// The effect at each joint, with its size. Only joints with a significant size are listed.
    pub effects: Vec<EffectSize>,
    /// For each entry of `effects`: natural frequency of an elastic joint, Hz, where the motor is locked and the inertia behind
    /// the joint oscillates. `None` for other effects.
    pub frequency: Vec<Option<f64>>,
    /// Share of the misfit that the effect explains. The misfit is chi^2 per degree of freedom minus 1, because noise alone
    /// gives 1.
    pub explained: f64,
    /// Change of each base parameter when the effect is added to the model.
    pub shift: Vec<f64>,
}

impl HarmonicData<'_> {
    /// The effect that the model most likely lacks, found from the residual of `fit`. `left`: misfit of `fit`. `None` if no
    /// candidate meets both criteria of the module.
    pub(crate) fn cause(&self, fit: &IterationState, left: &Misfit, options: &HarmonicOptions) -> Option<Cause> {
        let joints = 0..self.n;
        let mut candidates: Vec<Vec<Effect>> = vec![
            vec![Effect::Delay],
            self.ripples(&fit.shape, options),
            joints.clone().map(|joint| Effect::Spring { joint }).collect(),
            joints.clone().map(|joint| Effect::Eccentric { joint }).collect(),
            joints.clone().map(|joint| Effect::Elastic { joint }).collect(),
            joints.map(|joint| Effect::Play { joint }).collect(),
        ];
        candidates.iter_mut().for_each(|effects| effects.retain(|e| !options.effects.contains(e)));
        let tried = candidates.iter().filter(|effects| !effects.is_empty());
        let found = tried.filter_map(|effects| self.with(effects, fit, left, options));
        found
            .reduce(|a, b| if b.explained > a.explained { b } else { a })
            .filter(|cause| cause.explained >= NAMED_CAUSE_SHARE)
    }

    /// The cause that a fit with the additional `effects` gives. `None` if the effects are not significant.
    fn with(
        &self,
        effects: &[Effect],
        fit: &IterationState,
        left: &Misfit,
        options: &HarmonicOptions,
    ) -> Option<Cause> {
        let all = [&options.effects, effects].concat();
        let options = HarmonicOptions { effects: all, ..options.clone() };
        let mut data = self.clone();
        let with = data.fitted(&options)?;
        let misfit = data.residual_squares(&with);
        let columns: usize = effects.iter().map(|e| e.columns()).sum();
        let f = (left.chi_square - misfit.chi_square) / columns as f64 / misfit.total;
        // If the probability is NaN, the columns are not significant.
        let is_beyond = exceeded(f, columns as f64, misfit.freedom) < SIGNIFICANCE_LEVEL;
        let explained = 1.0 - (misfit.total - 1.0).max(0.0) / (left.total - 1.0);
        if !is_beyond || !explained.is_finite() {
            return None;
        }
        let sizes: Vec<EffectSize> = data.effect_sizes(&with).split_off(options.effects.len() - effects.len());
        let carried: Vec<f64> = sizes.iter().map(|size| data.carried(&with, size)).collect();
        let most = carried.iter().copied().fold(0.0, f64::max);
        let is_significant = |(size, carried): (&EffectSize, &f64)| {
            // Compliance, width of a gap and stiffness are positive. A negative value means that another effect is present.
            // Damping without compliance is not a spring, so damping alone is not tested.
            let is_positive = size.effect.is_positive();
            let tested = if is_positive { 1 } else { size.values.len() };
            let beyond = |(x, s): (&f64, &f64)| {
                if is_positive { *x > NAMED_JOINT_SIGMAS * s } else { x.abs() > NAMED_JOINT_SIGMAS * s }
            };
            *carried >= LEAST_SQUARE_SHARE * most && size.values.iter().zip(&size.deviations).take(tested).any(beyond)
        };
        let named: Vec<bool> = sizes.iter().zip(&carried).map(is_significant).collect();
        let mut named = named.into_iter();
        let significant: Vec<EffectSize> = sizes.into_iter().filter(|_| named.next() == Some(true)).collect();
        let frequency = significant.iter().map(|size| data.frequency(size, &with.x)).collect();
        let shift = (0..self.p).map(|c| with.x[c] - fit.x[c]).collect();
        (!significant.is_empty()).then_some(Cause { effects: significant, frequency, explained, shift })
    }

    /// The sum of the weighted squares of the torque that an effect contributes.
    fn carried(&self, fit: &IterationState, size: &EffectSize) -> f64 {
        let place = self.effects.iter().position(|e| *e == size.effect).unwrap_or(0);
        let first: usize = self.effects[..place].iter().map(|e| e.columns()).sum();
        let of = |(rows, deviation): (&Vec<Vec<f64>>, &Vec<f64>)| -> f64 {
            let row =
                |(row, s): (&Vec<f64>, &f64)| (dot(&row[first..first + size.values.len()], &size.values) / s).powi(2);
            rows.iter().zip(deviation).map(row).sum()
        };
        self.effect_rows.iter().zip(&fit.deviation).map(of).sum()
    }

    /// Natural frequency sqrt(K / M) / 2 pi of an elastic joint with locked motor, Hz. K: stiffness; M: inertia behind the
    /// joint, as a mean over the experiments with this joint. `None` for other effects.
    fn frequency(&self, size: &EffectSize, x: &[f64]) -> Option<f64> {
        let (Effect::Elastic { joint }, Some(&yielding)) = (size.effect, size.values.first()) else { return None };
        let moved: Vec<f64> =
            self.spectra.iter().filter(|s| s.joint == joint).map(|s| s.inertia(&x[..self.p])).collect();
        let inertia = moved.iter().sum::<f64>() / moved.len().max(1) as f64;
        let square = 1.0 / (yielding * inertia);
        (square.is_finite() && square > 0.0).then(|| square.sqrt() / std::f64::consts::TAU)
    }

    /// The joints with ripple, each with its number of periods per turn.
    ///
    /// In this search, friction is only asymmetric viscous and Coulomb friction, because other friction terms (drift, load) are
    /// correlated with ripple. Joints are selected one after the other: in each step, the joint and the number of periods that
    /// explain most of the residual. Then each joint is searched again, with the ripple of the other joints included.
    fn ripples(&self, shape: &FrictionShape, options: &HarmonicOptions) -> Vec<Effect> {
        let plain = HarmonicOptions { ends: options.ends, ..HarmonicOptions::plain() };
        let shape = FrictionShape { rest_velocity: shape.rest_velocity, ..FrictionShape::ASYMMETRIC };
        // The residuals `left` belong to a fit without ripple.
        let fit = IterationState::new(self, &shape, &plain, self.deviations(None));
        let (mut rows, mut left) = (Vec::new(), Vec::new());
        fit.each_equation(self, |_, row, known, y| {
            left.push(y - known - dot(row, &fit.x));
            rows.push(row.to_vec());
        });
        // Ripple columns are made orthogonal to the columns of the fit and to the ripple columns of the other joints.
        let columns: Vec<Vec<f64>> = (0..fit.x.len()).map(|c| rows.iter().map(|row| row[c]).collect()).collect();
        let mut found: Vec<Option<Wave>> = vec![None; self.n];
        let look = |joint: usize, found: &[Option<Wave>]| {
            let others = found.iter().enumerate().filter(|(k, _)| *k != joint).filter_map(|(_, wave)| wave.as_ref());
            let others = others.flat_map(|wave| wave.columns.iter());
            let basis = Basis::of(columns.iter().chain(others).cloned().collect());
            self.wave(joint, &fit, options, &basis, &left)
        };
        // Forward selection of joints: the joint with the largest explained sum of squares is first.
        for _ in 0..self.n {
            let open = (0..self.n).filter(|&j| found[j].is_none());
            let waves = open.filter_map(|j| Some((j, look(j, &found)?)));
            let Some((joint, wave)) = waves.reduce(|a, b| if b.1.explained > a.1.explained { b } else { a }) else {
                break;
            };
            found[joint] = Some(wave);
        }
        // Each joint is searched again, because the first joints were found without the ripple of the other joints.
        for joint in 0..self.n {
            found[joint] = look(joint, &found);
        }
        let effect = |(joint, wave): (usize, &Wave)| Effect::Ripple { joint, periods: wave.periods as f64 };
        found.iter().enumerate().filter_map(|(j, wave)| Some((j, wave.as_ref()?))).map(effect).collect()
    }

    /// The ripple of a joint that explains most of the residual `left`. `basis`: columns to which ripple columns are made
    /// orthogonal. `None` if the ripple is not significant.
    fn wave(
        &self,
        joint: usize,
        fit: &IterationState,
        options: &HarmonicOptions,
        basis: &Basis,
        left: &[f64],
    ) -> Option<Wave> {
        let left = basis.without(left.to_vec());
        let tried = self.periods(joint, options);
        let of = |periods: usize| {
            let columns = self.wave_columns(joint, periods as f64, fit, left.len());
            let own = Basis::of(columns.iter().map(|column| basis.without(column.clone())).collect());
            Wave { periods, explained: square(&left) - square(&own.without(left.clone())), columns }
        };
        let best = tried.clone().map(of).reduce(|a, b| if b.explained > a.explained { b } else { a })?;
        let m = best.columns.len() as f64;
        let freedom = left.len() as f64 - basis.len() as f64 - m;
        let f = best.explained / m / ((square(&left) - best.explained) / freedom);
        (exceeded(f, m, freedom) * (tried.count() as f64) < SIGNIFICANCE_LEVEL).then_some(best)
    }

    /// The numbers of ripple periods per turn that are tried for a joint. These numbers are limited by the range and the speed
    /// of the joint, and by the band of the equations.
    fn periods(&self, joint: usize, options: &HarmonicOptions) -> std::ops::Range<usize> {
        let of_joint = || self.spectra.iter().filter(|s| s.joint == joint);
        let ends =
            of_joint().map(|s| s.range()).fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        let range = ends.1 - ends.0;
        let slowest = of_joint().map(|s| s.speed()).fold(f64::INFINITY, f64::min);
        let turn = std::f64::consts::TAU;
        let most = (turn * options.band.equations / slowest).min(MAX_RIPPLE_PERIODS_PER_TURN as f64);
        let least = (0.5 * turn / range).ceil().max(1.0);
        least as usize..(most as usize + 1).max(least as usize)
    }

    /// The columns of ripple of a joint over all rows, with the weights of the fit.
    fn wave_columns(&self, joint: usize, periods: f64, fit: &IterationState, rows: usize) -> Vec<Vec<f64>> {
        let mut columns = vec![vec![0.0; rows]; Effect::Ripple { joint, periods }.columns()];
        let mut first = 0;
        for (s, deviation) in self.spectra.iter().zip(&fit.deviation) {
            if s.joint == joint {
                for (r, row) in s.ripple_rows(periods, self.gain[joint]).iter().enumerate() {
                    columns.iter_mut().zip(row).for_each(|(column, x)| column[first + r] = x / deviation[r]);
                }
            }
            first += s.rows.len();
        }
        columns
    }
}

/// Ripple of one joint, and the sum of weighted squares that the ripple explains.
#[derive(Clone)]
struct Wave {
    periods: usize,
    explained: f64,
    columns: Vec<Vec<f64>>,
}
