//! Drive gains: known, or estimated with the parameters.

use crate::error::Error;
use crate::fit::drive_gains::drive_gains;
use crate::fit::search::{Decisions, Proposal, TriedVariant};

/// Drive gains of the request and of the description, and an estimate of the missing ones.
pub(crate) fn gains(tried: &mut TriedVariant<'_>) -> Result<Option<Proposal>, Error> {
    let mut options = tried.options.clone();
    let gains = drive_gains(tried.model, tried.asked.logs, &tried.asked.request.gain, &mut options)?;
    Ok(Some(Proposal::given(options, Decisions { gains, ..Decisions::default() })))
}
