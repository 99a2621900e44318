//! Computes the columns of effects other than friction, and the motion of links behind springs, gaps and eccentric encoders.
//!
//! Delay, ripple and springs in parallel with the motor are linear in their unknowns. For each other effect, Y(q) X is
//! linearised about the present size u of the effect:
//!   Y(theta - u e) X = Y(q) X + C (u' - u),   C_j = [Y_j(q - s e_k) - Y_j(q)] X / s
//! theta: position of the motors; q = theta - u e: position of the links; e_k: deflection of joint k per unit of u; u': the new
//! size; s: a small step. An elastic joint has two e_k: the torque of the joint and, for the damping, the rate of this torque.
//! The fit is repeated until u' equals u (`search`).
//!
//! tau_k is the torque after the friction of the motor. If the joint moves, tau_k is the torque of the drive minus the friction
//! of the fit. If the joint is locked, its friction is unknown, and tau_k is Y_k(q) X. In this model the spring transmits the
//! whole torque of the joint. So an estimated rotor inertia is on the link side of the spring, whereas in the robot it is on
//! the motor side.

use experiments::plan::measured_motion::MeasuredMotion;
use numerics::fourier::harmonic_derivatives;

use crate::spectrum::harmonics::JointSpectrum;
use crate::spectrum::rist_mh::data::HarmonicData;
use crate::spectrum::rist_mh::effects::Effect;
use crate::spectrum::rist_mh::fit::IterationState;

/// Largest deflection of a joint for a finite difference, rad: far above rounding, and small enough for linearity.
const LARGEST_DIFFERENCE_STEP_RAD: f64 = 1e-5;

/// Width of tanh(torque / width), which describes how a link crosses its gap, divided by the rms torque.
const GAP_CROSSING_TORQUE_SHARE: f64 = 0.1;

impl HarmonicData<'_> {
    /// Number of columns of all effects.
    pub(crate) fn effect_columns(&self) -> usize {
        self.effects.iter().map(|e| e.columns()).sum()
    }

    /// Whether an effect makes the positions of links differ from the encoders.
    pub(crate) fn has_yielding(&self) -> bool {
        self.effects.iter().any(|e| e.moved().is_some())
    }

    /// Sets the effects and computes their columns from the record. The columns of springs and gaps are zero until
    /// [`HarmonicData::yield_by`] is called.
    pub(crate) fn lay(&mut self, effects: &[Effect]) {
        if self.has_yielding() {
            // All joints are made rigid again: the links move with the motors.
            for (experiment, motion) in self.motions.iter().enumerate() {
                let Some(columns) = motion.as_ref().map(|motion| motion.regressor_columns(self.regressor)) else {
                    continue;
                };
                let of = self.spectra.iter_mut().filter(|s| s.experiment == experiment);
                of.for_each(|s| s.take_columns(&columns[s.joint]));
            }
        }
        self.effects = effects.to_vec();
        self.effect_rows = self.spectra.iter().map(|s| self.record_columns(s)).collect();
    }

    /// The columns of the effects of a spectrum, `[row][column]`, N m per unit.
    fn record_columns(&self, s: &JointSpectrum) -> Vec<Vec<f64>> {
        let gain = self.gain[s.joint];
        let mut rows = vec![Vec::with_capacity(self.effect_columns()); s.rows.len()];
        for effect in &self.effects {
            match *effect {
                Effect::Delay => rows.iter_mut().zip(s.delay_column()).for_each(|(row, d)| row.push(-gain * d)),
                Effect::Ripple { joint, periods } if joint == s.joint => {
                    rows.iter_mut().zip(s.ripple_rows(periods, gain)).for_each(|(row, c)| row.extend(c));
                }
                Effect::Spring { joint } if joint == s.joint => {
                    rows.iter_mut().zip(s.position_rows()).for_each(|(row, q)| row.extend(q));
                }
                other => rows.iter_mut().for_each(|row| row.resize(row.len() + other.columns(), 0.0)),
            }
        }
        rows
    }

    /// Sets the motion of the links from the fitted springs and gaps, and linearises the columns about this motion.
    pub(crate) fn yield_by(&mut self, fit: &IterationState) {
        let sizes = fit.x[fit.layout.effects()].to_vec();
        let motions = std::mem::take(&mut self.motions);
        for (experiment, motion) in motions.iter().enumerate() {
            if let Some(motion) = motion {
                self.yield_experiment(experiment, motion, &sizes, fit);
            }
        }
        self.motions = motions;
    }

    fn yield_experiment(&mut self, experiment: usize, motor: &MeasuredMotion, sizes: &[f64], fit: &IterationState) {
        let Some(first) = self.spectra.iter().find(|s| s.experiment == experiment) else { return };
        // X: the base parameters including the known load of this experiment.
        let total: Vec<f64> = (0..self.p).map(|c| fit.x[c] + first.load.get(c).copied().unwrap_or(0.0)).collect();
        let (h, highest) = (first.sample_time, first.kept);
        let yields = self.yields(experiment, motor, &total, fit, (h, highest));
        // The motion of the links is q = theta - u e. theta: motion of the motors, u: size of an effect (spring, gap or
        // eccentric encoder), e: deflection of the joint per unit of u.
        let moved = |by: &dyn Fn(usize) -> f64, from: &MeasuredMotion| {
            let mut q = from.q.clone();
            for (column, joint, e) in &yields {
                q[*joint].iter_mut().zip(e).for_each(|(q, e)| *q -= by(*column) * e);
            }
            MeasuredMotion::by_harmonics(&q, h, highest)
        };
        let links = moved(&|column| sizes[column], motor);
        let columns = links.regressor_columns(self.regressor);
        let torque = |columns: &[Vec<f64>]| -> Vec<f64> {
            (0..links.len()).map(|i| columns.iter().zip(&total).map(|(c, x)| c[i] * x).sum()).collect()
        };
        // Finite differences at the motion of the links: C_j = [Y_j(q - s e_k) - Y_j(q)] X / s (symbols: see the module).
        let at: Vec<Vec<f64>> = columns.iter().map(|c| torque(c)).collect();
        let mut slopes: Vec<(usize, Vec<Vec<f64>>)> = Vec::new();
        for (column, _, e) in &yields {
            let largest = e.iter().fold(0.0_f64, |m, e| m.max(e.abs()));
            let step = LARGEST_DIFFERENCE_STEP_RAD / largest.max(f64::MIN_POSITIVE);
            let stepped = moved(&|c| if c == *column { step } else { 0.0 }, &links);
            let there = stepped.regressor_columns(self.regressor);
            let slope = |j: usize| torque(&there[j]).iter().zip(&at[j]).map(|(b, a)| (b - a) / step).collect();
            slopes.push((*column, (0..self.n).map(slope).collect()));
        }
        // The rows are set for the motion of the links: C is the column of the effect, and -C u is added to the known torque.
        for (s, rows) in self.spectra.iter_mut().zip(&mut self.effect_rows).filter(|(s, _)| s.experiment == experiment)
        {
            s.take_columns(&columns[s.joint]);
            for (column, slope) in &slopes {
                let found = s.rows_of(std::slice::from_ref(&slope[s.joint]), 1);
                for (r, found) in found.iter().enumerate() {
                    rows[r][*column] = found[0];
                    s.known[r] -= found[0] * sizes[*column];
                }
            }
        }
    }

    /// For each unknown of an elastic joint, a gap or an eccentric encoder: its column, its joint, and the deflection of the
    /// joint per unit of the unknown at each sample.
    fn yields(
        &self,
        experiment: usize,
        motor: &MeasuredMotion,
        total: &[f64],
        fit: &IterationState,
        (step, highest): (f64, usize),
    ) -> Vec<(usize, usize, Vec<f64>)> {
        let mut found = Vec::new();
        let mut column = 0;
        let mut rigid = None;
        for effect in &self.effects {
            if let Effect::Eccentric { joint } = *effect {
                let (sin, cos) = motor.q[joint].iter().map(|q| q.sin_cos()).unzip();
                found.push((column, joint, cos));
                found.push((column + 1, joint, sin));
            } else if let Some(joint) = effect.moved() {
                let spectrum = self.spectra.iter().position(|s| s.experiment == experiment && s.joint == joint);
                // tau_k: if the joint moves, the torque of the drive minus friction; if the joint is locked, the torque of the
                // model.
                let torque = match spectrum {
                    Some(e) => fit.behind_friction(&self.spectra[e], e, self),
                    None => {
                        let columns = rigid.get_or_insert_with(|| motor.regressor_columns(self.regressor));
                        let of = |i: usize| columns[joint].iter().zip(total).map(|(c, x)| c[i] * x).sum();
                        (0..motor.len()).map(of).collect()
                    }
                };
                // The unknown of a gap has one column, which follows from the sign of the torque. A spring has two unknowns:
                // one for the torque, and one for the rate of the torque.
                if let Effect::Play { .. } = effect {
                    found.push((column, joint, sides(&torque)));
                } else {
                    let [torque, rate, _] = harmonic_derivatives(&torque, step, highest);
                    found.push((column, joint, torque));
                    found.push((column + 1, joint, rate.iter().map(|r| -r).collect()));
                }
            }
            column += effect.columns();
        }
        found
    }
}

/// The position of the link in its gap, from -1/2 to 1/2, by the sign of the torque.
fn sides(torque: &[f64]) -> Vec<f64> {
    let square = torque.iter().map(|t| t * t).sum::<f64>() / torque.len().max(1) as f64;
    let width = GAP_CROSSING_TORQUE_SHARE * square.sqrt();
    torque.iter().map(|t| if width > 0.0 { 0.5 * (t / width).tanh() } else { 0.0 }).collect()
}

impl IterationState {
    /// The torque of a drive minus the friction of its joint, N m, at each sample of the mean period.
    fn behind_friction(&self, s: &JointSpectrum, spectrum: usize, data: &HarmonicData) -> Vec<f64> {
        let gain = data.gain[s.joint];
        let friction = &self.x[self.layout.friction(s.joint)];
        let scale = self.scale(spectrum);
        let columns = s.friction_series(&self.shape, gain);
        let of = |(i, c): (usize, &f64)| {
            gain * c - scale * columns.iter().zip(friction).map(|(column, f)| column[i] * f).sum::<f64>()
        };
        s.drive.iter().enumerate().map(of).collect()
    }
}
