//! From the signals of a log to states: filtered positions, velocities, accelerations and torques.
//!
//! q and tau pass a zero-phase low-pass (`butterworth`). dq is the measured velocity, filtered in the same way, or the
//! central difference of q; ddq is the central difference of dq. Then every `decimate`-th sample is kept, without the
//! ends. The same filter on both sides of tau = Y(q, dq, ddq) X keeps the equation true
//! to the first order [Gautier 1997]. Where a joint stands still its row is dropped: stiction is
//! not in the model.
//!
//! Friction columns jump with sign(dq). The filter rounds the jumps of the torques, so the signs go
//! through it too. On measured robots this lowers the residual by 3 to 17 % for the same columns.
//!
//! The default cut-off is that of `cutoff`. Not here: transmissions (`transmission`), friction (`model::friction`).

use logs::{Effort, Error, Log, Window};

use crate::model::coupling::Coupling;
use crate::model::friction::terms::sign;
use crate::model::states::States;
use crate::signals::butterworth::Butterworth;
use crate::signals::cutoff;
use crate::signals::cutoff::{FrequencyContent, MotionEnergy};
use crate::signals::resample::{interpolate, uniform_clock};
use crate::signals::signal_options::{Signal, Velocity};
use crate::signals::standstill::standstill;
use crate::signals::velocity_check::check_velocity;

/// Signals of a log as joint torques and joint positions: `Log` after its transmission.
pub struct JointSignals<'a> {
    /// The log behind them.
    pub log: &'a Log,
    /// rad (m), one series a coordinate.
    pub q: Vec<Vec<f64>>,
    /// rad/s (m/s), where measured.
    pub dq: Option<Vec<Vec<f64>>>,
    /// rad/s^2 (m/s^2), where measured.
    pub ddq: Option<Vec<Vec<f64>>>,
    /// N m (N).
    pub tau: Vec<Vec<f64>>,
    /// Motors that turn with a joint beside their own.
    pub couplings: Vec<Coupling>,
}

impl<'a> JointSignals<'a> {
    /// A log that is already on the joint side.
    pub fn direct(log: &'a Log) -> Result<JointSignals<'a>, Error> {
        if log.effort_is == Effort::Current {
            let message = "the log holds motor currents; drive gains (N m/A) are needed to make torques of them";
            return Err(Error::at(&log.name, 0, message));
        }
        let (q, dq, ddq, tau) = (log.q.clone(), log.dq.clone(), log.ddq.clone(), log.effort.clone());
        Ok(JointSignals { log, q, dq, ddq, tau, couplings: Vec::new() })
    }

    /// The signals on a uniform clock, torques without their delay; returns the clock.
    fn on_clock(&mut self, signal: &Signal) -> Result<Vec<f64>, Error> {
        let report = &self.log.report;
        let mut t = self.log.t.clone();
        if (!report.uniform && !signal.own_clock) || signal.rate.is_some() {
            let period = signal.rate.map_or(report.period, |r| 1.0 / r);
            let clock = uniform_clock(&t, period).ok_or_else(|| {
                let duration = report.duration;
                let message = format!("a clock of {:.3} Hz over {duration:.3} s is not usable", 1.0 / period);
                Error::at(&self.log.name, 0, message)
            })?;
            let series = [Some(&mut self.q), self.dq.as_mut(), self.ddq.as_mut(), Some(&mut self.tau)];
            for x in series.into_iter().flatten().flatten() {
                *x = interpolate(&t, x, &clock);
            }
            t = clock;
        }
        if signal.delay != 0.0 {
            let later: Vec<f64> = t.iter().map(|t| t + signal.delay).collect();
            for x in &mut self.tau {
                *x = interpolate(&t, x, &later);
            }
        }
        Ok(t)
    }

    /// Adds the motion. A row that repeats all positions of the one before is no sample: the log missed one.
    pub(crate) fn add_motion(mut self, signal: &Signal, energy: &mut MotionEnergy) -> Result<(), Error> {
        let t = &self.log.t;
        let fresh = |&r: &usize| r == 0 || self.q.iter().any(|q| q[r] != q[r - 1]);
        let fresh: Vec<usize> = (0..t.len()).filter(fresh).collect();
        if fresh.len() < t.len() {
            let of = |x: &[f64]| fresh.iter().map(|&r| x[r]).collect::<Vec<f64>>();
            let at = of(t);
            for q in &mut self.q {
                *q = interpolate(&at, &of(q), t);
            }
        }
        let period = step(&self.on_clock(signal)?);
        energy.push(&self.q, period);
        Ok(())
    }

    /// Filters, differentiates and decimates; `content`: of all that is fitted together, where it was looked at.
    ///
    /// Fails when a cut-off is not below half the rate, or a measured signal is asked for that is not there.
    pub fn states(mut self, signal: &Signal, content: Option<&FrequencyContent>) -> Result<States, Error> {
        let t = self.on_clock(signal)?;
        let at = |message: String| Error::at(&self.log.name, 0, message);
        let period = step(&t);
        if let Some(dq) = self.dq.as_ref().filter(|_| signal.velocity != Velocity::Differentiated) {
            check_velocity(&self.log.name, &self.log.coordinates, &t, &self.q, dq, period)?;
        }
        let content = content.cloned().unwrap_or_else(|| cutoff::rule(&self.q, period));
        let cutoff = if signal.order == 0 { 0.0 } else { signal.cutoff.unwrap_or(content.cutoff) };
        let effort_cutoff = if signal.order == 0 { 0.0 } else { signal.effort_cutoff.unwrap_or(cutoff) };
        let filter = |cutoff: f64| -> Result<Option<Butterworth>, Error> {
            if signal.order == 0 {
                return Ok(None);
            }
            let rate = 1.0 / period;
            Butterworth::low_pass(signal.order, cutoff, rate).map(Some).ok_or_else(|| {
                at(format!("a low-pass of order {} at {cutoff} Hz: the order is 1 to 20 and the cut-off between 0 and half the rate, {:.3} Hz", signal.order, 0.5 * rate))
            })
        };
        let (low, low_effort) = (filter(cutoff)?, filter(effort_cutoff)?);
        let pass = |f: &Option<Butterworth>, x: Vec<Vec<f64>>| -> Vec<Vec<f64>> {
            match f {
                Some(f) => x.iter().map(|x| f.zero_phase(x)).collect(),
                None => x,
            }
        };
        let q = pass(&low, self.q);
        let derivative =
            |wish: Velocity, measured: Option<Vec<Vec<f64>>>, of: &[Vec<f64>], name: &str| match (wish, measured) {
                (Velocity::Measured, None) => {
                    Err(at(format!("the log has no measured {name}; differentiate it instead")))
                }
                (Velocity::Differentiated, _) | (_, None) => Ok(of.iter().map(|x| gradient(x, &t)).collect()),
                (_, Some(x)) => Ok(pass(&low, x)),
            };
        let differentiated = self.dq.is_none() || signal.velocity == Velocity::Differentiated;
        let dq = derivative(signal.velocity, self.dq, &q, "velocity")?;
        let ddq = derivative(signal.acceleration, self.ddq, &dq, "acceleration")?;
        let tau = pass(&low_effort, self.tau);
        let mut direction: Vec<Vec<f64>> = dq.iter().map(|v| v.iter().map(|&v| sign(v)).collect()).collect();
        let turning = |c: &Coupling| dq[c.motor].iter().zip(&dq[c.joint]).map(|(&m, &k)| c.direction(m, k)).collect();
        let mut motor_direction: Vec<Vec<f64>> = self.couplings.iter().map(turning).collect();
        if signal.filtered_sign {
            (direction, motor_direction) = (pass(&low_effort, direction), pass(&low_effort, motor_direction));
        }
        let decimate = signal.decimation(cutoff, period);
        let border = signal.border_of(cutoff, differentiated);
        let chosen = chosen_samples(self.log, &t, border, signal.window, decimate);
        let still: Vec<Vec<bool>> = match signal.standstill {
            None => q.iter().map(|q| standstill(q, period)).collect(),
            Some(_) => Vec::new(),
        };
        let rows = |x: &[Vec<f64>]| chosen.iter().flat_map(|&r| x.iter().map(move |x| x[r])).collect::<Vec<f64>>();
        let (q, dq, ddq, tau) = (rows(&q), rows(&dq), rows(&ddq), rows(&tau));
        Ok(States {
            n: self.log.coordinates.len(),
            t: chosen.iter().map(|&r| t[r]).collect(),
            used: match signal.standstill {
                Some(speed) => dq.iter().map(|dq| dq.abs() > speed || speed == 0.0).collect(),
                None => chosen.iter().flat_map(|&r| still.iter().map(move |still| !still[r])).collect(),
            },
            direction: rows(&direction),
            motor_direction: rows(&motor_direction),
            q,
            dq,
            ddq,
            tau,
            cutoff,
            effort_cutoff,
            period: period * decimate as f64,
            f95: content.f95,
        })
    }
}

/// Time between samples, s.
fn step(t: &[f64]) -> f64 {
    (t[t.len() - 1] - t[0]) / (t.len() - 1) as f64
}

/// Every `decimate`-th sample inside the windows, away from the ends.
fn chosen_samples(log: &Log, t: &[f64], border: f64, window: Option<Window>, decimate: usize) -> Vec<usize> {
    let (mut first, mut last) = (t[0] + border, t[t.len() - 1] - border);
    for window in log.window.into_iter().chain(window) {
        match window {
            Window::Seconds(a, b) => (first, last) = (first.max(a), last.min(b)),
            Window::Rows(a, b) => {
                let inside = |row: &usize| (a..=b).contains(row);
                match (log.rows.iter().position(inside), log.rows.iter().rposition(inside)) {
                    (Some(a), Some(b)) => (first, last) = (first.max(log.t[a]), last.min(log.t[b])),
                    _ => return Vec::new(),
                }
            }
        }
    }
    let inside = |&r: &usize| t[r] >= first && t[r] <= last;
    (0..t.len()).filter(inside).step_by(decimate).collect()
}

/// dx/dt: central differences of second order on any clock, one-sided at the two ends.
///
/// With steps a before and b after: (a^2 x+ + (b^2 - a^2) x - b^2 x-) / (a b (a + b)), as
/// `numpy.gradient(x, t)`.
pub fn gradient(x: &[f64], t: &[f64]) -> Vec<f64> {
    let n = x.len();
    if n < 2 {
        return vec![0.0; n];
    }
    let slope = |i: usize, j: usize| (x[j] - x[i]) / (t[j] - t[i]);
    let mut d = Vec::with_capacity(n);
    d.push(slope(0, 1));
    for i in 1..n - 1 {
        let (a, b) = (t[i] - t[i - 1], t[i + 1] - t[i]);
        d.push((a * a * x[i + 1] + (b * b - a * a) * x[i] - b * b * x[i - 1]) / (a * b * (a + b)));
    }
    d.push(slope(n - 2, n - 1));
    d
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Figures of `numpy.gradient(z, t)`, NumPy 2.4.6.
    #[test]
    fn gradient_agrees_with_numpy() {
        let d = gradient(&[1.0, 2.0, 0.0, 5.0, 3.0], &[0.0, 0.1, 0.25, 0.3, 0.5]);
        for (d, e) in d.into_iter().zip([10.0, 0.6666666666666661, 71.66666666666669, 78.00000000000003, -10.0]) {
            assert!((d - e).abs() < 1e-12, "{d} {e}");
        }
    }

    #[test]
    fn gradient_of_a_parabola_is_exact_inside() {
        let t: Vec<f64> = (0..30).map(|i| (i as f64).powf(1.2)).collect();
        let x: Vec<f64> = t.iter().map(|t| 3.0 * t * t - t).collect();
        for (i, d) in gradient(&x, &t).into_iter().enumerate().take(29).skip(1) {
            assert!((d - (6.0 * t[i] - 1.0)).abs() < 1e-9);
        }
    }
}
