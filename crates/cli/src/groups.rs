//! The commands in the order of use, by what they are for: the flags that most people need, and an example each.
//!
//! They stand in `groups.txt`: a group behind `#`; a command, with the flags that `--help` shows (`all`, `own`: not how a
//! description is read, or these); command lines, each with what it is for below it.

/// A step of the work, with its commands in the order of use.
pub(crate) struct Group {
    pub title: &'static str,
    pub commands: Vec<CommandHelp>,
}

/// What help says of a command.
pub(crate) struct CommandHelp {
    pub name: &'static str,
    /// The flags that `--help` shows.
    pub shown: Shown,
    /// Command lines, with what they are for.
    pub examples: Vec<(&'static str, &'static str)>,
}

/// The flags that `--help` shows; `--help-all` shows all.
pub(crate) enum Shown {
    /// All of them.
    All,
    /// Its own, not how a description is read.
    Own,
    /// These.
    Only(Vec<&'static str>),
}

/// The groups of `groups.txt`.
pub(crate) fn groups() -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for line in include_str!("groups.txt").lines().filter(|line| !line.is_empty()) {
        let commands = groups.last_mut().map(|group| &mut group.commands);
        match (line.strip_prefix("# "), line.split_once(": "), commands) {
            (Some(title), ..) => groups.push(Group { title, commands: Vec::new() }),
            (None, Some((name, shown)), Some(commands)) if !line.starts_with(' ') => {
                let shown = match shown {
                    "all" => Shown::All,
                    "own" => Shown::Own,
                    flags => Shown::Only(flags.split(' ').collect()),
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
