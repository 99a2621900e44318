//! Replaces velocity and acceleration columns that are not the derivatives of the positions by such derivatives.

use crate::error::Error;
use crate::fit::search::{Decisions, Proposal, TriedVariant};
use crate::fit::signal_sources::sources;

/// Proposes derivatives of the positions for the velocity and acceleration columns that the log check rejects.
pub(crate) fn rates(tried: &mut TriedVariant<'_>) -> Result<Option<Proposal>, Error> {
    let mut options = tried.options.clone();
    let sentences = sources(&tried.looked()?.log_check, &mut options);
    Ok((!sentences.is_empty()).then(|| Proposal::given(options, Decisions { sentences, ..Decisions::default() })))
}
