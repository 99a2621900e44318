//! Slopes in place of velocity and acceleration columns that are none.

use crate::error::Error;
use crate::fit::search::{Decisions, Proposal, Tried};
use crate::fit::signal_sources::sources;

/// What the log check says of the columns.
pub(crate) fn rates(tried: &mut Tried<'_>) -> Result<Option<Proposal>, Error> {
    let mut options = tried.options.clone();
    let sentences = sources(&tried.looked()?.passport, &mut options);
    Ok((!sentences.is_empty()).then(|| Proposal::given(options, Decisions { sentences, ..Decisions::default() })))
}
