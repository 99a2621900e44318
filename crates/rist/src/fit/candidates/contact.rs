//! Leaves out the rows of contact, if the request asks for this.
//!
//! Rows of contact are rows in which the residual is an outlier.

use crate::error::Error;
use crate::fit::contact::Contacts;
use crate::fit::search::{Decisions, Proposal, TriedVariant};

/// Proposes a fit without the rows of contact. `None` if the request does not ask for such a fit.
pub(crate) fn contact(tried: &mut TriedVariant<'_>) -> Result<Option<Proposal>, Error> {
    let (model, logs) = (tried.model, tried.asked.logs);
    if !tried.asked.request.leave_out_contact {
        return Ok(None);
    }
    let none = |why: &str| Decisions { sentences: vec![format!("{why}: no row is left out")], ..Decisions::default() };
    if tried.looked()?.log_check.has_changed_load() {
        return Ok(Some(Proposal::given(tried.options.clone(), none("the load changes, which is no contact"))));
    }
    let found = Contacts::of_logs(model, logs, &tried.options)?;
    let sentences = found.sentences(model, logs).into_iter().map(|sentence| format!("left out: {sentence}")).collect();
    let decided = match found.events.is_empty() {
        true => none("no contact was found"),
        false => Decisions { sentences, ..Decisions::default() },
    };
    Ok(Some(Proposal::given(found.options, decided)))
}
