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
        let t = match clock(self.log, signal)? {
            None => self.log.t.clone(),
            Some(clock) => {
                let series = [Some(&mut self.q), self.dq.as_mut(), self.ddq.as_mut(), Some(&mut self.tau)];
                for x in series.into_iter().flatten().flatten() {
                    *x = interpolate(&self.log.t, x, &clock);
                }
                clock
            }
        };
        if signal.delay != 0.0 {
            let later: Vec<f64> = t.iter().map(|t| t + signal.delay).collect();
            for x in &mut self.tau {
                *x = interpolate(&t, x, &later);
            }
        }
        Ok(t)
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
        let pass = |f: &Option<Butterworth>, x: Vec<Vec<f64>>| match f {
            Some(f) => f.zero_phase(x),
            None => x,
        };
        let decimate = signal.decimation(cutoff, period);
        let differentiated = self.dq.is_none() || signal.velocity == Velocity::Differentiated;
        let border = signal.border_of(cutoff, differentiated);
        let chosen = chosen_samples(self.log, &t, border, signal.window, decimate);
        let rows = |x: &[Vec<f64>]| chosen.iter().flat_map(|&r| x.iter().map(move |x| x[r])).collect::<Vec<f64>>();
        let derivative =
            |wish: Velocity, measured: Option<Vec<Vec<f64>>>, of: &[Vec<f64>], name: &str| match (wish, measured) {
                (Velocity::Measured, None) => {
                    Err(at(format!("the log has no measured {name}; differentiate it instead")))
                }
                (Velocity::Differentiated, _) | (_, None) => Ok(of.iter().map(|x| gradient(x, &t)).collect()),
                (_, Some(x)) => Ok(pass(&low, x)),
            };
        // Each series goes as soon as its samples are chosen.
        let torques = |tau: Vec<Vec<f64>>| rows(&pass(&low_effort, tau));
        let motion = |q: Vec<Vec<f64>>, dq: Option<Vec<Vec<f64>>>, ddq: Option<Vec<Vec<f64>>>| {
            let q = pass(&low, q);
            let still: Vec<bool> = match signal.standstill {
                None => {
                    let still: Vec<Vec<bool>> = q.iter().map(|q| standstill(q, period)).collect();
                    chosen.iter().flat_map(|&r| still.iter().map(move |still| still[r])).collect()
                }
                Some(_) => Vec::new(),
            };
            let dq = derivative(signal.velocity, dq, &q, "velocity")?;
            let q = rows(&q);
            let ddq = rows(&derivative(signal.acceleration, ddq, &dq, "acceleration")?);
            let turning =
                |c: &Coupling| dq[c.motor].iter().zip(&dq[c.joint]).map(|(&m, &k)| c.direction(m, k)).collect();
            let turning: Vec<Vec<f64>> = self.couplings.iter().map(turning).collect();
            let direction: Vec<Vec<f64>> = dq.iter().map(|v| v.iter().map(|&v| sign(v)).collect()).collect();
            let dq = rows(&dq);
            let smooth = |x: Vec<Vec<f64>>| if signal.filtered_sign { pass(&low_effort, x) } else { x };
            let (direction, motor_direction) = (rows(&smooth(direction)), rows(&smooth(turning)));
            let used = match signal.standstill {
                Some(speed) => dq.iter().map(|dq| dq.abs() > speed || speed == 0.0).collect(),
                None => still.iter().map(|still| !still).collect(),
            };
            Ok(States { q, dq, ddq, direction, motor_direction, used, ..States::default() })
        };
        let (q, dq, ddq, tau) = (self.q, self.dq, self.ddq, self.tau);
        let (motion, tau) = match t.len() < PARALLEL {
            true => (motion(q, dq, ddq), torques(tau)),
            false => std::thread::scope(|scope| {
                let torques = scope.spawn(|| torques(tau));
                let motion = motion(q, dq, ddq);
                // Nothing in it can fail; where it does, so does this.
                (motion, torques.join().unwrap_or_else(|cause| std::panic::resume_unwind(cause)))
            }),
        };
        Ok(States {
            n: self.log.coordinates.len(),
            t: chosen.iter().map(|&r| t[r]).collect(),
            tau,
            cutoff,
            effort_cutoff,
            period: period * decimate as f64,
            f95: content.f95,
            ..motion?
        })
    }
}

/// With fewer samples than this, a second thread does not pay.
const PARALLEL: usize = 20_000;

/// The uniform clock that signals are to be brought to; `None` where they stay on their own.
fn clock(log: &Log, signal: &Signal) -> Result<Option<Vec<f64>>, Error> {
    if (log.report.uniform || signal.own_clock) && signal.rate.is_none() {
        return Ok(None);
    }
    let period = signal.rate.map_or(log.report.period, |r| 1.0 / r);
    uniform_clock(&log.t, period).map(Some).ok_or_else(|| {
        let duration = log.report.duration;
        let message = format!("a clock of {:.3} Hz over {duration:.3} s is not usable", 1.0 / period);
        Error::at(&log.name, 0, message)
    })
}

/// Adds the motion of a log with joint positions q. A row that repeats all positions of the one before is no sample: the
/// log missed one.
pub(crate) fn add_motion(
    log: &Log,
    mut q: Vec<Vec<f64>>,
    signal: &Signal,
    energy: &mut MotionEnergy,
) -> Result<(), Error> {
    let t = &log.t;
    let fresh = |&r: &usize| r == 0 || q.iter().any(|q| q[r] != q[r - 1]);
    let fresh: Vec<usize> = (0..t.len()).filter(fresh).collect();
    if fresh.len() < t.len() {
        let of = |x: &[f64]| fresh.iter().map(|&r| x[r]).collect::<Vec<f64>>();
        let at = of(t);
        for q in &mut q {
            *q = interpolate(&at, &of(q), t);
        }
    }
    let clock = clock(log, signal)?;
    if let Some(clock) = &clock {
        for q in &mut q {
            *q = interpolate(t, q, clock);
        }
    }
    energy.push(&q, step(clock.as_ref().unwrap_or(t)));
    Ok(())
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
