//! Makes the verdict on an estimate that was computed from sums (triangles added over logs) instead of from logs.
//!
//! Sums contain no logs, so the log check is not part of this verdict.

use identification::estimate::artefact::Estimate;
use identification::estimate::verdict::{Evidence, Verdict};
use rist::fit::unsure_torques::{Noise, UnsureTorques};
use rist::fit::verdict::evidence;
use rist::{Error, Model};

use crate::accumulator::Accumulator;
use crate::sums::check_sums;

/// Solves the sums: returns the estimate, and a verdict for each use of the torques. `model` must be the model of the sums.
///
/// Fails if the sums are of another model, or if they have no estimate.
pub fn sums_verdict(model: &Model, sums: &Accumulator) -> Result<(Estimate, Verdict), Error> {
    check_sums(model, sums)?;
    let (mut fit, faults) = sums.fit()?;
    let (noise, options) = (Noise::of(&fit), &sums.settings().options);
    let unsure = UnsureTorques::inflation(&mut fit.estimate, noise, None, &faults, model, options);
    let verdict = Verdict::of(&Evidence {
        opens_in_any_motion: unsure.opens_in_any_motion,
        faults: &faults,
        ..evidence(&fit.estimate, None)
    });
    Ok((fit.estimate, verdict))
}
