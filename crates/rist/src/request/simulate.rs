//! The options (request) of `rist simulate`, which simulates the logs of a motion or of a plan.

use std::path::PathBuf;

use identification::estimate::artefact::Estimate;
use linear_model::known_load::KnownLoad;

use super::Range;

request! {
    /// Options for simulating motions.
    pub struct SimulateRequest {
        /// Number of validation motions.
        validation: usize = 10, range(0..=1000);
        /// Drive gain (torque per current), N m/A [default: as in the file; if only some gains are known, 1 for the others].
        gain: Vec<(String, f64)> = Vec::new(), range(Range::Positive), value_name("COORDINATE=GAIN");
        /// A known load, in a file as for [load] of `rist identify`. Every experiment is repeated with this load:
        /// e01_loaded.csv, ..
        load: Option<(PathBuf, KnownLoad)> = None, value_name("FILE");
        /// An estimate from which the controller computes feedforward torques (inverse dynamics without friction). So you can
        /// repeat: identify, then simulate with feedforward.
        feedforward: Option<Estimate> = None, value_name("FILE");
        /// Seed of the noise; the same seed gives the same logs.
        seed: u64 = 1;
        /// Simulate sensors without noise and without rounding.
        noise_free: bool = false;
    }
}
