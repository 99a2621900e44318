//! Which effect the model lacks, where it lacks something: late torques, ripple, springs, eccentric encoders, joints that
//! bend, play.
//!
//! Each candidate joins the fit with the columns of `effects`, all joints at once, and everything else is chosen again.
//! Two figures judge it, both against the noise that was measured: the share that it takes away of what chi^2 per freedom is
//! above 1, which noise alone gives,
//!   1 - (chi_1^2 / nu_1 - 1) / (chi_0^2 / nu_0 - 1),
//! and how likely it is that its m columns take as much from a residual that has nothing to do with them,
//!   F = ((chi_0^2 - chi_1^2) / m) / (chi_1^2 / nu_1) ~ F(m, nu_1).
//! The candidate with the largest share is the cause, if it takes at least `NAMED_CAUSE_SHARE` and F is beyond
//! `SIGNIFICANCE_LEVEL`.
//!
//! The share decides. What a model lacks is no noise, so over some hundred rows F lets pass any column that resembles
//! it a little. A cause that leaves half of the residual where it was is at most one of several. F protects where the
//! rows are few. Its level is one in a thousand. For ripple as many periods are tried as a joint can show, and the
//! level is that of all of them together (Bonferroni).
//!
//! A spring and a gap look alike where the torque has nearly two values only, as in a bang-bang motion. Play is then
//! told from the spring behind it only where its gap is wider than what the spring yields.
//!
//! Ripple of k periods a turn is tried at a joint on two conditions. The motions of the joint hold half a period, k
//! range(q) >= pi, since less may be taken for gravity. The equations reach it, k rms(dq) <= 2 pi f for their highest
//! frequency f.

use linear_model::friction::periodic::FrictionShape;
use numerics::student::exceeded;
use numerics::vector::dot;

use crate::estimate::passport::{Basis, square};
use crate::spectrum::rist_mh::data::{HarmonicData, HarmonicOptions};
use crate::spectrum::rist_mh::effects::{Effect, EffectSize};
use crate::spectrum::rist_mh::fit::Fit;
use crate::spectrum::rist_mh::misfit::Misfit;

/// Share of chi^2 per freedom above that of noise that a cause must take away to be named. With half it explains more than all others
/// together.
pub(crate) const NAMED_CAUSE_SHARE: f64 = 0.5;
/// Probability of an F by chance below which columns count.
pub(crate) const SIGNIFICANCE_LEVEL: f64 = 1e-3;
/// Most periods a turn that are tried. No encoder resolves ripple of more.
const MAX_RIPPLE_PERIODS_PER_TURN: usize = 1024;
/// A joint is named only where its size is beyond this many deviations, which is `SIGNIFICANCE_LEVEL` of a normal
/// error.
const NAMED_JOINT_SIGMAS: f64 = 3.3;
/// A joint is named only where its columns carry this share of what those of the strongest joint carry. Less is a trace
/// of another joint.
const TRACE_CARRIED_SHARE: f64 = 0.02;

/// What the model most likely lacks.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// The effect by joint, with its sizes; only joints that show it.
    pub effects: Vec<EffectSize>,
    /// Frequency of each effect, Hz: of a spring and the inertia behind it, with the motor held. `None` where it is no
    /// spring.
    pub frequency: Vec<Option<f64>>,
    /// Share of chi^2 per freedom above that of noise that it takes away.
    pub explained: f64,
    /// By how much the base parameters move with it.
    pub shift: Vec<f64>,
}

impl HarmonicData<'_> {
    /// The cause of what `fit` leaves; `None` where none of the candidates is good enough.
    pub(crate) fn cause(&self, fit: &Fit, left: &Misfit, options: &HarmonicOptions) -> Option<Cause> {
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

    /// The cause that a fit with these effects finds; `None` where chance may have done it.
    fn with(&self, effects: &[Effect], fit: &Fit, left: &Misfit, options: &HarmonicOptions) -> Option<Cause> {
        let all = [&options.effects, effects].concat();
        let options = HarmonicOptions { effects: all, ..options.clone() };
        let mut data = self.clone();
        let with = data.fitted(&options)?;
        let misfit = data.squares_left(&with);
        let columns: usize = effects.iter().map(|e| e.columns()).sum();
        let f = (left.chi_square - misfit.chi_square) / columns as f64 / misfit.total;
        // Not a number is no evidence.
        let is_beyond = exceeded(f, columns as f64, misfit.freedom) < SIGNIFICANCE_LEVEL;
        let explained = 1.0 - (misfit.total - 1.0).max(0.0) / (left.total - 1.0);
        if !is_beyond || !explained.is_finite() {
            return None;
        }
        let sizes: Vec<EffectSize> = data.effect_sizes(&with).split_off(options.effects.len() - effects.len());
        let carried: Vec<f64> = sizes.iter().map(|size| data.carried(&with, size)).collect();
        let most = carried.iter().copied().fold(0.0, f64::max);
        let is_told = |(size, carried): (&EffectSize, &f64)| {
            // What a joint yields, the width of a gap and the stiffness of a spring are positive. Another sign is something
            // else, and damping alone is no spring.
            let is_positive = size.effect.is_positive();
            let told = if is_positive { 1 } else { size.values.len() };
            let beyond = |(x, s): (&f64, &f64)| {
                if is_positive { *x > NAMED_JOINT_SIGMAS * s } else { x.abs() > NAMED_JOINT_SIGMAS * s }
            };
            *carried >= TRACE_CARRIED_SHARE * most && size.values.iter().zip(&size.deviations).take(told).any(beyond)
        };
        let named: Vec<bool> = sizes.iter().zip(&carried).map(is_told).collect();
        let mut named = named.into_iter();
        let told: Vec<EffectSize> = sizes.into_iter().filter(|_| named.next() == Some(true)).collect();
        let frequency = told.iter().map(|size| data.frequency(size, &with.x)).collect();
        let shift = (0..self.p).map(|c| with.x[c] - fit.x[c]).collect();
        (!told.is_empty()).then_some(Cause { effects: told, frequency, explained, shift })
    }

    /// Weighted squares of what an effect adds to the model.
    fn carried(&self, fit: &Fit, size: &EffectSize) -> f64 {
        let place = self.effects.iter().position(|e| *e == size.effect).unwrap_or(0);
        let first: usize = self.effects[..place].iter().map(|e| e.columns()).sum();
        let of = |(rows, deviation): (&Vec<Vec<f64>>, &Vec<f64>)| -> f64 {
            let row =
                |(row, s): (&Vec<f64>, &f64)| (dot(&row[first..first + size.values.len()], &size.values) / s).powi(2);
            rows.iter().zip(deviation).map(row).sum()
        };
        self.effect_rows.iter().zip(&fit.deviation).map(of).sum()
    }

    /// sqrt(K / M) / 2 pi of a spring, M the mean inertia behind it over the experiments that move it.
    fn frequency(&self, size: &EffectSize, x: &[f64]) -> Option<f64> {
        let (Effect::Elastic { joint }, Some(&yielding)) = (size.effect, size.values.first()) else { return None };
        let moved: Vec<f64> =
            self.spectra.iter().filter(|s| s.joint == joint).map(|s| s.inertia(&x[..self.p])).collect();
        let inertia = moved.iter().sum::<f64>() / moved.len().max(1) as f64;
        let square = 1.0 / (yielding * inertia);
        (square.is_finite() && square > 0.0).then(|| square.sqrt() / std::f64::consts::TAU)
    }

    /// The joints with ripple, and its periods a turn.
    ///
    /// The ripple is looked for beside the friction of equation (5) alone, since drift and load would take it up. The
    /// joint and the periods that explain most go first. Then each joint is looked at again beside the others.
    fn ripples(&self, shape: &FrictionShape, options: &HarmonicOptions) -> Vec<Effect> {
        let plain = HarmonicOptions { ends: options.ends, ..HarmonicOptions::plain() };
        let shape = FrictionShape { rest_velocity: shape.rest_velocity, ..FrictionShape::ASYMMETRIC };
        // What a fit without ripple leaves of its rows.
        let fit = Fit::new(self, &shape, &plain, self.deviations(None));
        let (mut rows, mut left) = (Vec::new(), Vec::new());
        fit.each_equation(self, |_, row, known, y| {
            left.push(y - known - dot(row, &fit.x));
            rows.push(row.to_vec());
        });
        // Waves are judged beside the columns of the fit and the waves of the other joints.
        let columns: Vec<Vec<f64>> = (0..fit.x.len()).map(|c| rows.iter().map(|row| row[c]).collect()).collect();
        let mut found: Vec<Option<Wave>> = vec![None; self.n];
        let look = |joint: usize, found: &[Option<Wave>]| {
            let others = found.iter().enumerate().filter(|(k, _)| *k != joint).filter_map(|(_, wave)| wave.as_ref());
            let others = others.flat_map(|wave| wave.columns.iter());
            let basis = Basis::of(columns.iter().chain(others).cloned().collect());
            self.wave(joint, &fit, options, &basis, &left)
        };
        // One joint after the other, the one whose ripple explains most first.
        for _ in 0..self.n {
            let open = (0..self.n).filter(|&j| found[j].is_none());
            let waves = open.filter_map(|j| Some((j, look(j, &found)?)));
            let Some((joint, wave)) = waves.reduce(|a, b| if b.1.explained > a.1.explained { b } else { a }) else {
                break;
            };
            found[joint] = Some(wave);
        }
        // Each joint once more: the first was found while the others were still without ripple.
        for joint in 0..self.n {
            found[joint] = look(joint, &found);
        }
        let effect = |(joint, wave): (usize, &Wave)| Effect::Ripple { joint, periods: wave.periods as f64 };
        found.iter().enumerate().filter_map(|(j, wave)| Some((j, wave.as_ref()?))).map(effect).collect()
    }

    /// The ripple of a joint that explains most of `left` beside the columns of `basis`; `None` where it may be chance.
    fn wave(&self, joint: usize, fit: &Fit, options: &HarmonicOptions, basis: &Basis, left: &[f64]) -> Option<Wave> {
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

    /// The periods a turn that the motion of a joint can show.
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

    /// The columns of ripple of a joint, weighted as the rows of the fit.
    fn wave_columns(&self, joint: usize, periods: f64, fit: &Fit, rows: usize) -> Vec<Vec<f64>> {
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

/// Ripple of one joint, and the squares that it explains.
#[derive(Clone)]
struct Wave {
    periods: usize,
    explained: f64,
    columns: Vec<Vec<f64>>,
}
