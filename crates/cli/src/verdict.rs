//! How a command ends whose verdict is no.

use rist::verdict::{Trust, Verdict};

use crate::failure::Failure;

/// A failure with exit code 1 where the verdict is no; `withheld`: files were asked for and are not written.
pub fn refused(verdict: &Verdict, withheld: bool) -> Result<(), Failure> {
    if verdict.trust != Trust::No {
        return Ok(());
    }
    let files = if withheld { "; nothing is written for a simulator (--anyway writes it)" } else { "" };
    Err(Failure::verdict(format_args!("not to be trusted: {}{files}", verdict.reasons.join("; "))))
}
