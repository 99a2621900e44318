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
        /// Torque per unit of current of a drive, N m/A; below 0 where the current counts the other way [default: as the file says].
        gain: Vec<(String, f64)> = Vec::new(), range(Range::NonZero), value_name("COORDINATE=GAIN");
        /// A hobby arm or its servo, whose units, zeros and gains are taken where nothing else gives them: so101, koch, wx250s,
        /// vx300s, openmanipulator-x, xm430-w350, ..; with the form of the positions as so101:degrees, :normalised, :counts or
        /// :radians.
        arm: Option<String> = None, value_name("ARM[:FORM]");
        /// Rows per second, of a log without a clock.
        rate: Option<f64> = None, range(Range::Positive), value_name("HZ");
    }
}

request! {
    /// Options for validating on motions an estimate from the experiments of a plan. An estimate from samples stores its own
    /// options, so it needs none here.
    pub struct ValidateRequest {
        /// Torque per unit of current of a drive, N m/A [default: that of the estimate, that of the file, or 1].
        gain: Vec<(String, f64)> = Vec::new(), range(Range::NonZero), value_name("COORDINATE=GAIN");
        /// Cut-off of the low-pass on position and torque, Hz [default: MOTION_CUTOFF].
        cutoff: Option<f64> = None, default_from(format_args!("{MOTION_CUTOFF}, or that of the estimate")), range(Range::Positive), value_name("HZ");
    }
}

words! {
    /// The filter of the observer of external torques.
    pub enum ObserverOrder {
        /// K / (s + K).
        First = "first" "First order: the time constant is 1 / GAIN",
        /// w^2 / (s^2 + sqrt(2) w s + w^2).
        Second = "second" "Second order, damping 0.7, natural frequency GAIN: less noise, a later answer",
    }
}

request! {
    /// Options for replaying a log through observer, load and drift, as a robot would run them.
    pub struct ReplayRequest {
        /// Logs without contact, in which the noise of the observer is measured [default: the logs of the estimate].
        reference: Vec<PathBuf> = Vec::new(), value_name("LOGS");
        /// False alarms an hour that are accepted.
        alarms: f64 = 1.0, range(Range::Positive), value_name("PER_HOUR");
        /// Gain of the observer, 1/s.
        observer_gain: f64 = 50.0, range(0.1..=1e4), value_name("GAIN");
        /// Filter of the observer.
        order: ObserverOrder = ObserverOrder::First;
        /// Link or frame that carries a load [default: the last link].
        load_on: Option<String> = None, value_name("LINK");
        /// Largest mass of a load, kg.
        largest_load: f64 = 10.0, range(Range::Positive), value_name("KG");
        /// Link or frame on which the force and the moment of each contact are computed, at its origin and in its axes.
        wrench_on: Option<String> = None, value_name("LINK");
        /// Take the numbers even of an estimate whose verdict is no.
        anyway: bool = false;
    }
}

request! {
    /// The requirements that a motion is checked against.
    pub struct CheckRequest {
        /// Limits of your own that the motion must keep too, as for `rist excite [limits]`; those that the file lacks are not
        /// assumed. What a motion may leave out, `space: {floor: none, accept: ..}`, counts in this file alone.
        limits: Option<LimitsFile> = None, value_name("FILE");
        /// An estimate of this model: efforts and powers are proved with its torques instead of the description's.
        after: Option<Estimate> = None, value_name("ESTIMATE");
    }
}
