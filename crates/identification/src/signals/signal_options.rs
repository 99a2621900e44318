//! How signals become states: filters, derivatives, clock, window. Every field has a default.

use logs::Window;
use serde::{Deserialize, Serialize};

use crate::signals::butterworth::Butterworth;

/// How signals become states.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Signal {
    /// Cut-off of the low-pass on positions and velocities, Hz; by default the rule of `cutoff`.
    pub cutoff: Option<f64>,
    /// Cut-off of the low-pass on the torques, Hz; by default that of the positions.
    pub effort_cutoff: Option<f64>,
    /// Order of the low-pass; 0: no filter.
    pub order: usize,
    /// Keep every n-th sample; by default ten samples a period of the cut-off are kept.
    pub decimate: Option<usize>,
    /// Rate of the uniform clock to resample to, Hz; by default the rate of the log where its clock is not uniform.
    pub rate: Option<f64>,
    /// Keep the log's own clock even where it is not uniform.
    pub own_clock: bool,
    /// Where dq comes from.
    pub velocity: Velocity,
    /// Where ddq comes from.
    pub acceleration: Velocity,
    /// Time dropped at each end, s; by default one period of the cut-off, three where velocities are differentiated.
    pub border: Option<f64>,
    /// Use samples in this interval only.
    pub window: Option<Window>,
    /// Speed below which rows of a joint are dropped, rad/s; 0: none. By default the rows of a joint that stays
    /// where it is (`standstill`) are dropped where the model has dry friction.
    pub standstill: Option<f64>,
    /// Time by which the torques lag the positions, s: a [`possible_delay`].
    pub delay: f64,
    /// Make the columns of dry friction of a velocity with a cut-off of its own, and pass them through the filter of
    /// the torques. The filter then rounds their jumps at reversals as it rounds those of the torques.
    pub filtered_sign: bool,
    /// Cut-off of that velocity, Hz; by default `REVERSAL_CUTOFF_RATIO` times that of the torques.
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
            standstill: None,
            delay: 0.0,
            filtered_sign: true,
            reversal_cutoff: None,
        }
    }
}

/// Cut-off of the velocity that shows reversals, as a multiple of that of the torques.
pub(crate) const REVERSAL_CUTOFF_RATIO: f64 = 10.0;

/// Longest delay, s. A delay is a fault of a logger, and none is as long as a second.
const LONGEST_DELAY_S: f64 = 1.0;

/// Returns `seconds` where torques can lag positions by them.
///
/// Fails, saying what is expected, where they cannot.
pub fn possible_delay(seconds: f64) -> Result<f64, String> {
    // This is false for NaN too.
    let is_possible = seconds.abs() < LONGEST_DELAY_S;
    is_possible.then_some(seconds).ok_or_else(|| {
        format!("a delay of {seconds} s: seconds between -{LONGEST_DELAY_S} and {LONGEST_DELAY_S} are expected")
    })
}

impl Signal {
    /// One sample in so many is kept: `decimate`, or ten a period of the cut-off.
    pub(crate) fn decimation(&self, cutoff: f64, period: f64) -> usize {
        // The clocks of two logs differ in the last digits; the margin keeps a whole number of samples whole.
        let ten_a_period = if cutoff > 0.0 { (1.0 / (10.0 * cutoff * period) + 1e-6) as usize } else { 1 };
        self.decimate.unwrap_or(ten_a_period).max(1)
    }

    /// Time dropped at each end, s. There the filter guesses the signal, and differentiating doubles the error.
    pub(crate) fn border_of(&self, cutoff: f64, differentiated: bool) -> f64 {
        let periods = if differentiated { 3.0 } else { 1.0 };
        self.border.unwrap_or(if cutoff > 0.0 { periods / cutoff } else { 0.0 })
    }

    /// Time after which the ends of a signal have no more effect, s, for a `cutoff` in Hz and a `period` in s.
    pub(crate) fn memory(&self, cutoff: f64, period: f64) -> f64 {
        let slowest = match (self.order, self.effort_cutoff) {
            (0, _) => 0.0,
            (order, other) => Butterworth::memory(order, cutoff.min(other.unwrap_or(cutoff))),
        };
        slowest.max(self.border_of(cutoff, true)) + self.delay.abs() + 8.0 * period
    }
}

/// The source of a derivative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Velocity {
    /// The measured signal where the log has it.
    #[default]
    Auto,
    /// Measured; refused where the log has none.
    Measured,
    /// Differentiated, also where it was measured.
    Differentiated,
}
