//! Prints the verdict at the end of a command, and determines the exit code.
//!
//! The verdict states whether to trust an estimate: yes, with care, or no. If it is no, the exit code is 1.

use std::path::Path;

use rist::Estimate;
use rist::fit::verdict::{Trust, UseVerdict, Verdict};
use serde_json::{Value, json};

use crate::artefact::write_file;
use crate::failure::Failure;
use crate::terminal::print_result;

/// The verdict as JSON.
pub(crate) fn as_json(verdict: &Verdict) -> Value {
    let Verdict { trust, found, reasons, next, uses, claims } = verdict;
    let of_use = |u: &UseVerdict| {
        let worst = u.worst_joint.as_ref().map(|(name, share)| json!({"joint": name, "error": share}));
        json!({"use": u.name, "trust": u.trust.word(), "torque_error": u.error, "worst": worst})
    };
    json!({
        "trust": trust.word(),
        "found": found,
        "reasons": reasons,
        "next": next,
        "uses": uses.iter().map(of_use).collect::<Vec<_>>(),
        "claims": claims,
    })
}

/// Prints an estimate with its verdict. If `out` is given, also writes the estimate to `out`. Fails with exit code 1 if the
/// verdict is no.
pub(crate) fn conclude(estimate: &Estimate, verdict: &Verdict, out: Option<&Path>) -> Result<(), Failure> {
    print_result(format_args!("{estimate}\n{verdict}"), || {
        Ok(json!({"estimate": serde_json::to_value(estimate)?, "verdict": as_json(verdict)}))
    })?;
    if let Some(out) = out {
        write_file(out, estimate.to_yaml()?)?;
    }
    refused(verdict, false)
}

/// Fails with exit code 1 if the verdict is no. If files for a simulator were requested but not written (`withheld`), the verdict
/// on the bodies for a simulator counts instead.
pub(crate) fn refused(verdict: &Verdict, withheld: bool) -> Result<(), Failure> {
    let (trust, reasons) = match withheld {
        true => verdict.of_bodies(),
        false => (verdict.trust, verdict.reasons.clone()),
    };
    if trust != Trust::No {
        return Ok(());
    }
    let files = if withheld { "; nothing is written for a simulator (--anyway writes it)" } else { "" };
    Err(Failure::verdict(format_args!("not to be trusted: {}{files}", reasons.join("; "))))
}
