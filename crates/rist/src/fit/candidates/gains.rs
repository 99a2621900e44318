//! Drive gains: known, or estimated with the parameters.

use crate::error::Error;
use crate::fit::drive_gains::drive_gains;
use crate::fit::search::{Decisions, Proposal, Tried};

/// Those of the request and of the description, and an estimate of the others.
pub(crate) fn gains(tried: &mut Tried<'_>) -> Result<Option<Proposal>, Error> {
    let mut options = tried.options.clone();
    let gains = drive_gains(tried.model, tried.asked.logs, &tried.asked.request.gain, &mut options)?;
    Ok(Some(Proposal::given(options, Decisions { gains, ..Decisions::default() })))
}
