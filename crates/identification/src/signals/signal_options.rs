//! The options for converting the signals of a log into states (q, dq, ddq, tau): filters, derivatives, clock, window. Every
//! field has a default. A low-pass filters the signals; its cut-off is in Hz.

use logs::Window;
use serde::{Deserialize, Serialize};

use crate::signals::butterworth::Butterworth;

/// The options for converting signals into states.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Signal {
    /// Cut-off of the low-pass for positions and velocities, Hz. `None`: the default cut-off, computed by module `cutoff`.
    pub cutoff: Option<f64>,
    /// Cut-off of the low-pass for torques, Hz. `None`: the cut-off for positions.
    pub effort_cutoff: Option<f64>,
    /// Order of the low-pass; 0: no filter.
    pub order: usize,
    /// Decimation n: every n-th sample is kept. `None`: n is chosen so that ten samples per period of the cut-off are kept.
    pub decimate: Option<usize>,
    /// Rate of the uniform clock for resampling, Hz. `None`: a log with a uniform clock is not resampled, and another log gets
    /// its mean rate.
    pub rate: Option<f64>,
    /// Whether the log keeps its own clock, even if this clock is not uniform.
    pub own_clock: bool,
    /// Source of the velocities dq.
    pub velocity: Velocity,
    /// Source of the accelerations ddq.
    pub acceleration: Velocity,
    /// Time dropped at each end of a record, s. `None`: one period of the cut-off, or three if velocities are differentiated.
    pub border: Option<f64>,
    /// Interval of the log whose samples are used. `None`: all samples.
    pub window: Option<Window>,
    /// Intervals whose samples are left out, for example contact.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub leave_out: Vec<LeftOutInterval>,
    /// Speed below which the rows of a joint are left out, rad/s (m/s); 0: no row is left out. `None`: if the model has dry
    /// friction, the rows of a joint at standstill (detected by module `standstill`) are left out.
    pub standstill: Option<f64>,
    /// Delay of the torques relative to the positions, s. The value must be a [`possible_delay`].
    pub delay: f64,
    /// Whether the columns of dry friction are computed from a velocity with a higher cut-off, and then filtered like the
    /// torques. Then the filter smooths the jumps of the columns and of the torques at reversals equally.
    pub filtered_sign: bool,
    /// Cut-off of the velocity for `filtered_sign`, Hz. `None`: `REVERSAL_CUTOFF_RATIO` times the cut-off for torques, but
    /// limited if the velocity is differentiated from positions.
    pub reversal_cutoff: Option<f64>,
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
            leave_out: Vec::new(),
            standstill: None,
            delay: 0.0,
            filtered_sign: true,
            reversal_cutoff: None,
        }
    }
}

/// An interval of a log whose samples are left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeftOutInterval {
    /// Name of the log, as given.
    pub log: String,
    /// Start and end, s, by the clock of the log.
    pub seconds: [f64; 2],
}

impl LeftOutInterval {
    fn contains(&self, t: f64) -> bool {
        t >= self.seconds[0] && t <= self.seconds[1]
    }
}

/// Ratio of the cut-off of the velocity for reversals to the cut-off for torques.
pub(crate) const REVERSAL_CUTOFF_RATIO: f64 = 10.0;

/// Longest accepted delay, s. A delay is caused by a logger and is shorter than a second.
const LONGEST_DELAY_S: f64 = 1.0;
/// Default number of samples per period of the cut-off.
const SAMPLES_PER_CUTOFF_PERIOD: f64 = 10.0;
/// Margin that is added to a number of samples before rounding down. The clocks of two logs differ in the last digits. With the
/// margin, a whole number of samples is rounded to the same number for both logs.
const WHOLE_SAMPLE_MARGIN: f64 = 1e-6;
/// Default time dropped at each end if velocities are differentiated, in periods of the cut-off.
const DIFFERENTIATED_BORDER_PERIODS: f64 = 3.0;
/// Number of samples that are added to the memory of the filter, because differences and interpolation use neighbouring samples.
const MEMORY_MARGIN_SAMPLES: f64 = 8.0;

/// Returns `seconds` if it is a possible delay of the torques relative to the positions (magnitude below 1 s).
///
/// Otherwise fails; the message states the expected range.
pub fn possible_delay(seconds: f64) -> Result<f64, String> {
    // For NaN, the comparison is false too.
    let is_possible = seconds.abs() < LONGEST_DELAY_S;
    is_possible.then_some(seconds).ok_or_else(|| {
        format!("a delay of {seconds} s: seconds between -{LONGEST_DELAY_S} and {LONGEST_DELAY_S} are expected")
    })
}

impl Signal {
    /// Whether the sample at time t, s, of the log with this name is left out.
    pub(crate) fn leaves_out(&self, log: &str, t: f64) -> bool {
        self.leave_out.iter().any(|interval| interval.log == log && interval.contains(t))
    }

    /// Decimation n: every n-th sample is kept. n is the option `decimate`. Without this option, n gives ten samples per period
    /// of `cutoff`, Hz. `period`: time between samples, s.
    pub(crate) fn decimation(&self, cutoff: f64, period: f64) -> usize {
        let samples = 1.0 / (SAMPLES_PER_CUTOFF_PERIOD * cutoff * period);
        let by_cutoff = if cutoff > 0.0 { (samples + WHOLE_SAMPLE_MARGIN) as usize } else { 1 };
        self.decimate.unwrap_or(by_cutoff).max(1)
    }

    /// Time dropped at each end of a record, s. Samples at the ends are dropped because the filter extrapolates the signal
    /// there, and differentiation increases the error. `cutoff`: Hz.
    pub(crate) fn border_of(&self, cutoff: f64, differentiated: bool) -> f64 {
        let periods = if differentiated { DIFFERENTIATED_BORDER_PERIODS } else { 1.0 };
        self.border.unwrap_or(if cutoff > 0.0 { periods / cutoff } else { 0.0 })
    }

    /// Time after which the effect of the ends of a record is negligible, s. `cutoff`: Hz; `period`: time between samples, s.
    pub(crate) fn memory(&self, cutoff: f64, period: f64) -> f64 {
        let slowest = match (self.order, self.effort_cutoff) {
            (0, _) => 0.0,
            (order, other) => Butterworth::memory(order, cutoff.min(other.unwrap_or(cutoff))),
        };
        slowest.max(self.border_of(cutoff, true)) + self.delay.abs() + MEMORY_MARGIN_SAMPLES * period
    }
}

/// The source of a velocity or an acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Velocity {
    /// The measured signal if the log has it, otherwise the derivative.
    #[default]
    Auto,
    /// The measured signal. A log without this signal is an error.
    Measured,
    /// The derivative, even if the log has the measured signal.
    Differentiated,
}
