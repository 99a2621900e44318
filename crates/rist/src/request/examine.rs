//! The options (requests) of the commands that check logs, estimates and motions.
//!
//! A request is a struct with all options of a command; each field is one option.

use std::path::PathBuf;

use experiments::excitation::limits::LimitsFile;
use identification::estimate::artefact::Estimate;
use identification::estimate::options::Options;

use super::Range;

/// Default cut-off, Hz, of the low-pass on position and torque that validates an estimate on motions. It is twice the default
/// cut-off of the spectrum methods. Figure 2 of [Vandanjon, Gautier, Desbats 1995] shows frequencies up to this value.
pub const MOTION_CUTOFF: f64 = 20.0;

request! {
    /// Options for checking logs before a fit.
    pub struct DoctorRequest {
        /// YAML with any option of an identification.
        options: Option<Options> = None, value_name("FILE");
        /// Drive gain (torque per current), N m/A; negative if the current counts in the opposite direction [default: as in the
        /// file].
        gain: Vec<(String, f64)> = Vec::new(), range(Range::NonZero), value_name("COORDINATE=GAIN");
        /// A hobby arm or its servo: so101, koch, wx250s, vx300s, openmanipulator-x, xm430-w350 and others. Units, zeros and
        /// gains of this arm are used where nothing else gives them. The form of the positions may follow the name:
        /// so101:degrees, :normalised, :counts or :radians.
        arm: Option<String> = None, value_name("ARM[:FORM]");
        /// Rows per second (Hz) of a log without a clock.
        rate: Option<f64> = None, range(Range::Positive), value_name("HZ");
    }
}

request! {
    /// Options for validating on motions an estimate from the experiments of a plan. An estimate from samples stores its own
    /// options, so it needs none here.
    pub struct ValidateRequest {
        /// Drive gain (torque per current), N m/A [default: from the estimate; otherwise from the description; otherwise 1].
        gain: Vec<(String, f64)> = Vec::new(), range(Range::NonZero), value_name("COORDINATE=GAIN");
        /// Cut-off of the low-pass on position and torque, Hz [default: MOTION_CUTOFF].
        cutoff: Option<f64> = None, default_from(format_args!("{MOTION_CUTOFF}; an estimate from samples uses its own cut-off")), range(Range::Positive), value_name("HZ");
    }
}

words! {
    /// The filter of the observer of external torques.
    pub enum ObserverOrder {
        /// K / (s + K).
        First = "first" "First order, with the time constant 1 / GAIN",
        /// w^2 / (s^2 + sqrt(2) w s + w^2).
        Second = "second" "Second order, with damping 0.7 and natural frequency GAIN: less noise, but a later response",
    }
}

request! {
    /// Options for replaying a log through observer, load and drift, as a robot would run them.
    pub struct ReplayRequest {
        /// Logs without contact, from which the noise of the observer is measured [default: the logs of the estimate].
        reference: Vec<PathBuf> = Vec::new(), value_name("LOGS");
        /// Accepted number of false alarms per hour.
        alarms: f64 = 1.0, range(Range::Positive), value_name("PER_HOUR");
        /// Gain of the observer of external torques, 1/s.
        observer_gain: f64 = 50.0, range(0.1..=1e4), value_name("GAIN");
        /// Filter of the observer of external torques.
        order: ObserverOrder = ObserverOrder::First;
        /// Link or frame that carries a load [default: the last link].
        load_on: Option<String> = None, value_name("LINK");
        /// Largest possible mass of a load, kg.
        largest_load: f64 = 10.0, range(Range::Positive), value_name("KG");
        /// Link or frame for the force and the moment of each contact: both are computed at the origin and in the axes of this
        /// frame.
        wrench_on: Option<String> = None, value_name("LINK");
        /// Use the estimate even if its verdict is no. Otherwise the estimate is refused.
        anyway: bool = false;
    }
}

request! {
    /// The requirements that a motion is checked against.
    pub struct CheckRequest {
        /// YAML with further limits that the motion must keep, in the form of [limits] of `rist excite`. A limit that is not in
        /// this file is not assumed. A check is left out (`space: {floor: none, accept: ..}`) only if this file says so.
        limits: Option<LimitsFile> = None, value_name("FILE");
        /// An estimate of this model. The torques in the proofs of effort and power then follow from the estimate, not from the
        /// description.
        after: Option<Estimate> = None, value_name("ESTIMATE");
    }
}
