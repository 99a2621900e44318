//! The end of a command that does not succeed.

use std::fmt;
use std::io::Write;
use std::process::ExitCode;

/// A message for the user and an exit code: 2 for input that cannot be used, 1 for a verdict against input that was used.
pub struct Failure {
    message: String,
    code: u8,
}

impl Failure {
    pub fn new(message: impl fmt::Display) -> Failure {
        Failure { message: message.to_string(), code: 2 }
    }

    /// A failure whose work is done and printed: the outcome is a no.
    pub fn verdict(message: impl fmt::Display) -> Failure {
        Failure { message: message.to_string(), code: 1 }
    }

    pub fn report(&self) -> ExitCode {
        eprintln!("rist: {self}");
        ExitCode::from(self.code)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl From<rist::Error> for Failure {
    fn from(e: rist::Error) -> Failure {
        if e.is_verdict() { Failure::verdict(e) } else { Failure::new(e) }
    }
}

impl From<robot::Error> for Failure {
    fn from(e: robot::Error) -> Failure {
        Failure::new(e)
    }
}

impl From<logs::Error> for Failure {
    fn from(e: logs::Error) -> Failure {
        Failure::new(e)
    }
}

/// Prints to standard output; a reader that went away (`rist ... | head`) is no failure.
pub fn print(text: &str) -> Result<(), Failure> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Failure::new(format_args!("standard output: {e}"))),
        _ => Ok(()),
    }
}
