//! `rist completions` and `rist man`: writes shell completions and manual pages, generated from the arguments.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;

use crate::artefact::{make_directory, write_file};
use crate::failure::Failure;
use crate::terminal::print;

/// Print the completions for a shell
///
/// For bash: rist completions bash > ~/.local/share/bash-completion/completions/rist
#[derive(Args)]
pub(crate) struct CompletionArguments {
    /// The shell
    shell: Shell,
}

/// Write the manual pages of the program and its commands
#[derive(Args)]
pub(crate) struct ManualArguments {
    /// Directory for the pages; it is created if it does not exist
    #[arg(long, value_name = "DIRECTORY", default_value = "man")]
    out: PathBuf,
}

/// Prints the shell completions of `command`.
pub(crate) fn completions(arguments: &CompletionArguments, mut command: Command) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "rist", &mut text);
    print(&String::from_utf8_lossy(&text))
}

/// Writes rist.1 and one page per command, for example rist-identify.1.
pub(crate) fn manual(arguments: &ManualArguments, command: Command) -> Result<(), Failure> {
    make_directory(&arguments.out)?;
    let mut command = command.disable_help_subcommand(true);
    // `build` sets the names of the pages of subcommands.
    command.build();
    for part in command.get_subcommands().chain([&command]) {
        let manual = clap_mangen::Man::new(part.clone());
        let place = arguments.out.join(manual.get_filename());
        let mut page = Vec::new();
        manual.render(&mut page).map_err(|e| Failure::new(format_args!("{}: {e}", place.display())))?;
        write_file(&place, &page)?;
    }
    Ok(())
}
