//! The wings that this program was built with: their requests, and what is said of those that it lacks.

use std::ffi::OsString;

use rist::request::{WingRequests, register_wings};

/// Commands of each wing, and whether the program has it.
const WINGS: [(&str, &[&str], bool); 3] = [
    ("fleet", &["accumulate", "merge", "solve", "compare"], cfg!(feature = "fleet")),
    ("formulas", &["derive"], cfg!(feature = "formulas")),
    ("statics", &["postures", "wrench"], cfg!(feature = "statics")),
];

/// Makes the requests of the wings known, before a text is spelled. The program does so itself; a package does when it is loaded.
pub fn register() {
    let all: Vec<WingRequests> = vec![
        #[cfg(feature = "fleet")]
        ::fleet::requests,
        #[cfg(feature = "formulas")]
        ::formulas::requests,
        #[cfg(feature = "statics")]
        ::statics::requests,
    ];
    register_wings(all);
}

/// What is missing, where the first word of a command line is a command of a wing that this program lacks.
pub(crate) fn of_absent(words: &[OsString]) -> Option<String> {
    let command = words.get(1)?.to_str()?;
    let (wing, ..) = WINGS.iter().find(|(_, commands, is_here)| !is_here && commands.contains(&command))?;
    Some(format!(
        "{command} is of the wing {wing}, which this program was built without; build it with --features {wing}"
    ))
}
