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

/// What is missing, where the first word of a command line that is no flag is a command of a wing that this program lacks.
pub(crate) fn of_absent(words: &[OsString]) -> Option<String> {
    let command = words.iter().skip(1).filter_map(|word| word.to_str()).find(|word| !word.starts_with('-'))?;
    let (wing, ..) = WINGS.iter().find(|(_, commands, is_here)| !is_here && commands.contains(&command))?;
    Some(format!(
        "{command} is of the wing {wing}, which this program was built without; build it with --features {wing}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_of_wings_are_those_of_the_program() {
        let program = crate::program();
        for (wing, commands, is_here) in WINGS {
            for command in commands {
                assert_eq!(program.find_subcommand(command).is_some(), is_here, "{wing}: {command}");
                let words = ["rist", "--json", command].map(OsString::from);
                assert_eq!(of_absent(&words).is_some(), !is_here, "{wing}: {command}");
            }
        }
    }
}
