//! Requests for checks of logs, of estimates and of motions.

use experiments::excitation::limits::LimitsFile;
use identification::estimate::artefact::Estimate;
use identification::estimate::options::Options;

use super::Range;

/// Default cut-off of the low-pass on position and torque when motions of a plan are validated, Hz: twice the cut-off of the
/// equations; the range of figure 2 of the paper.
pub const MOTION_CUTOFF: f64 = 20.0;

request! {
    /// How logs are looked at before anything is fitted.
    pub struct DoctorRequest {
        /// YAML with any option of an identification.
        options: Option<Options> = None, value_name("FILE");
        /// Torque per unit of current of a drive, N m/A; below 0 where the current counts the other way [default: as the file says].
        gain: Vec<(String, f64)> = Vec::new(), range(Range::NonZero), value_name("COORDINATE=GAIN");
        /// Rows per second, of a log without a clock.
        rate: Option<f64> = None, range(Range::Positive), value_name("HZ");
    }
}

request! {
    /// How an estimate of experiments is held against motions; one from samples brings what it was made with.
    pub struct ValidateRequest {
        /// Torque per unit of current of a drive, N m/A [default: that of the estimate, that of the file, or 1].
        gain: Vec<(String, f64)> = Vec::new(), range(Range::NonZero), value_name("COORDINATE=GAIN");
        /// Cut-off of the low-pass on position and torque, Hz [default: MOTION_CUTOFF].
        cutoff: Option<f64> = None, default_from(format_args!("{MOTION_CUTOFF}, or that of the estimate")), range(Range::Positive), value_name("HZ");
    }
}

request! {
    /// What a motion is held to.
    pub struct CheckRequest {
        /// Limits of your own that the motion must keep too, as for `rist excite [limits]`; those that the file lacks are not
        /// assumed. What a motion may leave out, `space: {floor: none, accept: ..}`, counts in this file alone.
        limits: Option<LimitsFile> = None, value_name("FILE");
        /// An estimate of this model: efforts and powers are proved with its torques instead of the description's.
        after: Option<Estimate> = None, value_name("ESTIMATE");
    }
}
