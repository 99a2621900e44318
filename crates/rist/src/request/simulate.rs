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
        /// Torque per unit of current of a drive, N m/A [default: as the file says; where one is known, 1 for the others].
        gain: Vec<(String, f64)> = Vec::new(), range(Range::Positive), value_name("COORDINATE=GAIN");
        /// A known load (as of `rist identify`): every experiment is done again with it, e01_loaded.csv, ..
        load: Option<(PathBuf, KnownLoad)> = None, value_name("FILE");
        /// An estimate whose torques (inverse dynamics, no friction) the controller adds: identify -> feedforward -> repeat.
        feedforward: Option<Estimate> = None, value_name("FILE");
        /// Seed of the noise; the same seed gives the same logs.
        seed: u64 = 1;
        /// Neither noise nor rounding of the sensors.
        noise_free: bool = false;
    }
}
