//! From the signals of a log to states: filtered positions, velocities, accelerations and torques.
//!
//! q, tau -> zero-phase low-pass (`butterworth`); dq the measured velocity, filtered alike, or the
//! central difference of q; ddq the central difference of dq; then every `decimate`-th sample,
//! without the ends. The same filter on both sides of tau = Y(q, dq, ddq) X keeps the equation true
//! to the first order [Gautier 1997]. Where a joint stands still its row is dropped: stiction is
//! not in the model.
//!
//! Friction columns jump with sign(dq); the filter rounds the jumps of the torques, so the signs go
//! through it too. On the measured sets of `dataset` this lowers the residual by 3 to 17 % for the
//! same columns.
//!
//! Default cut-off: `cutoff::rule`. Not here: transmissions (`transmission`), friction (`friction`).

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::butterworth::Butterworth;
use crate::cutoff::{self, FrequencyContent};
use crate::friction::sign;
use crate::log::{Effort, Log};
use crate::plausible::check_velocity;
use crate::resample::{interpolate, uniform_clock};
use crate::standstill::standstill;
use crate::transmission::Coupling;

/// How signals become states.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Signal {
    /// Hz, of the low-pass on positions and velocities; without it the rule of `cutoff`.
    pub cutoff: Option<f64>,
    /// Hz, of the low-pass on the torques; without it that of the positions.
    pub effort_cutoff: Option<f64>,
    /// Order of the low-pass; 0: no filter.
    pub order: usize,
    /// Keep every n-th sample; without it ten samples a period of the cut-off.
    pub decimate: Option<usize>,
    /// Hz, of the uniform clock to resample to; without it that of the log when it is not uniform.
    pub rate: Option<f64>,
    /// Keep the log's own clock even where it is not uniform.
    pub own_clock: bool,
    pub velocity: Velocity,
    pub acceleration: Velocity,
    /// s dropped at each end; without it one period of the cut-off, three where velocities are differentiated.
    pub border: Option<f64>,
    /// Use samples in this interval only.
    pub window: Option<Window>,
    /// rad/s: rows of a joint slower than this are dropped; 0: none. Without it those of a joint that stays
    /// where it is (`standstill`), where the model has dry friction.
    pub standstill: Option<f64>,
    /// s by which the torques lag the positions.
    pub delay: f64,
    /// Pass sign(dq) through the filter of the torques before it becomes a column: the torques'
    /// jumps at reversals are rounded by their filter, and so are the column's.
    pub filtered_sign: bool,
}

impl Default for Signal {
    fn default() -> Signal {
        Signal {
            cutoff: None,
            effort_cutoff: None,
            order: 4,
            decimate: None,
            rate: None,
            own_clock: false,
            velocity: Velocity::Auto,
            acceleration: Velocity::Auto,
            border: None,
            window: None,
            standstill: None,
            delay: 0.0,
            filtered_sign: true,
        }
    }
}

impl Signal {
    /// Every how manieth sample is kept.
    pub(crate) fn decimation(&self, cutoff: f64, period: f64) -> usize {
        let ten_a_period = if cutoff > 0.0 { (1.0 / (10.0 * cutoff * period)) as usize } else { 1 };
        self.decimate.unwrap_or(ten_a_period).max(1)
    }

    /// s dropped at each end: there the filter guesses the signal, and differences double the error.
    fn border_of(&self, cutoff: f64, differentiated: bool) -> f64 {
        let periods = if differentiated { 3.0 } else { 1.0 };
        self.border.unwrap_or(if cutoff > 0.0 { periods / cutoff } else { 0.0 })
    }

    /// s after which nothing is left of the ends of a signal, for `cutoff` and `period` in s.
    pub(crate) fn memory(&self, cutoff: f64, period: f64) -> f64 {
        let slowest = match (self.order, self.effort_cutoff) {
            (0, _) => 0.0,
            (order, other) => Butterworth::memory(order, cutoff.min(other.unwrap_or(cutoff))),
        };
        slowest.max(self.border_of(cutoff, true)) + self.delay.abs() + 8.0 * period
    }
}

/// Where a derivative comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Velocity {
    /// Measured where the log has it.
    #[default]
    Auto,
    Measured,
    Differentiated,
}

/// An interval of a log, ends included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Window {
    /// s, in the log's time.
    Seconds(f64, f64),
    /// Rows of the file, from 1.
    Rows(usize, usize),
}

/// Samples ready for the regressor: row r of each n-column array is one instant.
#[derive(Clone, Debug, Default)]
pub struct States {
    /// Coordinates.
    pub n: usize,
    pub t: Vec<f64>,
    /// rad, rad/s, rad/s^2, N m (A); sample by sample, n each.
    pub q: Vec<f64>,
    pub dq: Vec<f64>,
    pub ddq: Vec<f64>,
    pub tau: Vec<f64>,
    /// sign(dq) or that sign filtered; then the directions of coupled motors, one a coupling.
    pub direction: Vec<f64>,
    pub motor_direction: Vec<f64>,
    /// Whether the row of joint j at sample r counts.
    pub used: Vec<bool>,
    /// Hz, the cut-offs in force; 0: none.
    pub cutoff: f64,
    pub effort_cutoff: f64,
    /// s between samples.
    pub period: f64,
    /// Hz, a coordinate: 95 % of the energy of its velocity lies below.
    pub f95: Vec<f64>,
}

impl States {
    pub fn len(&self) -> usize {
        self.t.len()
    }

    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }
}

/// Signals of a log as joint torques and joint positions: `Log` after its transmission.
pub struct JointSignals<'a> {
    pub log: &'a Log,
    pub q: Vec<Vec<f64>>,
    pub dq: Option<Vec<Vec<f64>>>,
    pub ddq: Option<Vec<Vec<f64>>>,
    pub tau: Vec<Vec<f64>>,
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

    /// How fast the motion is; and s between the samples of its clock.
    pub(crate) fn content(mut self, signal: &Signal) -> Result<(FrequencyContent, f64), Error> {
        let period = step(&self.on_clock(signal)?);
        Ok((cutoff::rule(&self.q, period), period))
    }

    /// Filters, differentiates and decimates.
    ///
    /// Fails when a cut-off is not below half the rate, or a measured signal is asked for that is not there.
    pub fn states(mut self, signal: &Signal) -> Result<States, Error> {
        let t = self.on_clock(signal)?;
        let at = |message: String| Error::at(&self.log.name, 0, message);
        let period = step(&t);
        if let Some(dq) = self.dq.as_ref().filter(|_| signal.velocity != Velocity::Differentiated) {
            check_velocity(&self.log.name, &self.log.coordinates, &t, &self.q, dq, period)?;
        }
        let content = cutoff::rule(&self.q, period);
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

/// s between samples.
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
