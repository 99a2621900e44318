//! Reads the groups of commands for the help, in the order of use, with the most frequent flags and examples of each command.
//!
//! Format of `groups.txt`: a line `# TITLE` starts a group. A line `COMMAND: FLAGS` lists the flags that `--help` shows: `all`,
//! `own` (all except the options of the description), or names. Examples follow: a command line, then a line with its purpose.

/// A group of commands for one stage of the work.
pub(crate) struct CommandGroup {
    pub title: &'static str,
    pub commands: Vec<CommandHelp>,
}

/// Data for the help of one command.
pub(crate) struct CommandHelp {
    pub name: &'static str,
    /// The flags that `--help` shows.
    pub shown: ShownFlags,
    /// Examples: command lines, each with its purpose.
    pub examples: Vec<(&'static str, &'static str)>,
}

/// Selects the flags that `--help` shows. `--help-all` shows all flags.
pub(crate) enum ShownFlags {
    /// All flags.
    All,
    /// All flags except the options of the description.
    Own,
    /// Only these flags.
    Only(Vec<&'static str>),
}

/// Reads the groups from `groups.txt`.
pub(crate) fn groups() -> Vec<CommandGroup> {
    let mut groups: Vec<CommandGroup> = Vec::new();
    for line in include_str!("groups.txt").lines().filter(|line| !line.is_empty()) {
        let commands = groups.last_mut().map(|group| &mut group.commands);
        match (line.strip_prefix("# "), line.split_once(": "), commands) {
            (Some(title), ..) => groups.push(CommandGroup { title, commands: Vec::new() }),
            (None, Some((name, shown)), Some(commands)) if !line.starts_with(' ') => {
                let shown = match shown {
                    "all" => ShownFlags::All,
                    "own" => ShownFlags::Own,
                    flags => ShownFlags::Only(flags.split(' ').collect()),
                };
                commands.push(CommandHelp { name, shown, examples: Vec::new() });
            }
            (None, _, Some(commands)) => {
                let Some(command) = commands.last_mut() else { continue };
                match (line.starts_with("        "), command.examples.last_mut()) {
                    (true, Some(example)) => example.1 = line.trim(),
                    _ => command.examples.push((line.trim(), "")),
                }
            }
            _ => {}
        }
    }
    groups
}
