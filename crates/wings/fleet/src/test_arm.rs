//! Helpers for unit tests: the pendulum of `experiments`, empty sums, and data of a log.

use identification::estimate::claims::hypotheses::UndeterminedMechanics;
use identification::estimate::options::Options;
use linear_model::reference::ModelReference;

use crate::accumulator::Accumulator;
use crate::replicate::LogAccount;
use crate::settings::Settings;
pub(crate) use pendulum::Pendulum;

#[path = "../../../experiments/src/pendulum.rs"]
mod pendulum;
#[path = "../../../identification/src/test_states.rs"]
mod test_states;

pub(crate) fn empty(options: &Options) -> Accumulator {
    let model = ModelReference { name: "arm".into(), fingerprint: "1".into() };
    Accumulator::new(Settings::new(&Pendulum::new(), model, None, options, UndeterminedMechanics::default()).unwrap())
}

/// Data of a log with this number of rows, 10 ms apart.
pub(crate) fn account(name: String, digest: u64, rows: usize) -> LogAccount {
    let (digest, duration) = (format!("{digest:016x}"), 0.01 * rows as f64);
    LogAccount { name, digest, rows, kept: rows, samples: rows, duration, period: 0.01 }
}
