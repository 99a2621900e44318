//! Replaces velocity and acceleration columns of a log by derivatives of the positions, if the columns contradict the
//! positions.
//!
//! The log check compares the columns with the derivatives of the positions.

use crate::error::Error;
use crate::fit::search::{Decisions, Proposal, TriedVariant};
use crate::fit::signal_sources::sources;

/// Proposes derivatives of the positions instead of the velocity and acceleration columns that the log check rejects.
pub(crate) fn rates(tried: &mut TriedVariant<'_>) -> Result<Option<Proposal>, Error> {
    let mut options = tried.options.clone();
    let sentences = sources(&tried.looked()?.log_check, &mut options);
    Ok((!sentences.is_empty()).then(|| Proposal::given(options, Decisions { sentences, ..Decisions::default() })))
}
