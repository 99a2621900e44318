//! Decides whether the torques are shifted by a delay relative to the positions. The delay is searched if the request asks for
//! a delay, or if the log check finds one. In the second case, the delay is kept only if it lowers the error on held-out data.
//!
//! Held-out data are segments of the logs that are left out of the fit and predicted.

use identification::estimate::delay::{Delay, estimate_delay};
use identification::estimate::hypothesis::Hypothesis;
use identification::estimate::log_check::finding::Fault;
use identification::estimate::options::Options;
use identification::estimate::topics::DELAY_TAKEN;
use logs::LogSource;

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::search::{
    Decisions, Evidence, Proposal, TriedVariant, Variant, WORTHWHILE_ERROR_RATIO, error_on_parts,
};

/// Proposes the delay with the smallest residual of the torques. `None` if the user gives a delay, or if the log check finds no
/// delay.
pub(crate) fn delay(tried: &mut TriedVariant<'_>) -> Result<Option<Proposal>, Error> {
    let (model, logs, request) = (tried.model, tried.asked.logs, tried.asked.request);
    if request.finds_delay() {
        let (options, delay) = found_delay(model, logs, &tried.options)?;
        return Ok(Some(Proposal::given(options, Decisions { delay: Some(delay), ..Decisions::default() })));
    }
    let is_free = request.rows.signals.delay.is_none() && tried.options.signal.delay == 0.0;
    if !is_free
        || !tried.looked()?.log_check.findings.iter().any(|f| matches!(f.fault, Fault::Of(Hypothesis::Late(_), _)))
    {
        return Ok(None);
    }
    // If the residual has no minimum over the delay, the torques are not shifted. The log check reports the missing minimum.
    let Ok((options, found)) = found_delay(model, logs, &tried.options) else { return Ok(None) };
    let errors = [error_on_parts(model, logs, &tried.options)?, error_on_parts(model, logs, &options)?];
    let sentence = format!(
        "the torques come {:.1} ms later than the positions, and are shifted back: the held-out error is {:.4} instead of {:.4} ([delay=0] keeps them)",
        1e3 * found.seconds,
        errors[1],
        errors[0]
    );
    let evidence = Evidence::Errors { errors, limit: WORTHWHILE_ERROR_RATIO };
    let mut proposal = Proposal::mending(Variant { model: None, options }, evidence, DELAY_TAKEN, sentence);
    proposal.found.delay = Some(found);
    Ok(Some(proposal))
}

/// The delay with the smallest residual, and the options that contain this delay. Fails if the residual still falls at the end
/// of the searched range.
fn found_delay(model: &Model, logs: &[LogSource], options: &Options) -> Result<(Options, Delay), Error> {
    let delay = estimate_delay(model.regressor(), logs, options)?;
    if delay.at_the_end {
        return Err(Error::verdict(format_args!(
            "delay {:.4} s: residual {} {:.4}, without it {:.4}; the search ends there, but the \
             residual still falls: the delay is longer, or no delay explains these logs; look at units, signs and \
             drive gains, or give the delay",
            delay.seconds,
            delay.rows(),
            delay.residual,
            delay.residual_without
        )));
    }
    let mut late = options.clone();
    late.signal.delay = delay.seconds;
    Ok((late, delay))
}
