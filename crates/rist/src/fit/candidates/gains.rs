//! Decides on the drive gains: known, or estimated with the parameters.
//!
//! A drive gain is the torque per unit of current of a drive.

use crate::error::Error;
use crate::fit::drive_gains::drive_gains;
use crate::fit::search::{Decisions, Proposal, TriedVariant};

/// Takes the drive gains of the request and of the description as known, and estimates the missing gains.
pub(crate) fn gains(tried: &mut TriedVariant<'_>) -> Result<Option<Proposal>, Error> {
    let mut options = tried.options.clone();
    let gains = drive_gains(tried.model, tried.asked.logs, &tried.asked.request.gain, &mut options)?;
    Ok(Some(Proposal::given(options, Decisions { gains, ..Decisions::default() })))
}
