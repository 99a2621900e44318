//! Builds the help of the program: commands in the order of use, with the most frequent flags and examples.
//!
//! `--help` (and `-h`) has at most 60 lines: the purpose of a command, the flags of [`groups`], and an example. `--help-all`
//! has all flags with their full texts. In both, the flags that all commands share (options of the description and of the
//! terminal) come last.

use clap::{Arg, ArgAction, Command};
use rist::ModelOptions;
use rist::request::Request;

use crate::groups::ShownFlags::{All, Only, Own};
use crate::groups::{CommandGroup, CommandHelp, groups};
use crate::terminal::folded;

/// The first three commands for a new user with a description and a log, each with its purpose.
const FIRST_STEPS: [(&str, &str); 3] = [
    ("rist doctor robot.urdf log.csv", "does the log belong to the robot?"),
    ("rist identify robot.urdf log.csv --report page.html", "parameters, a verdict, a page that shows both"),
    ("rist excite robot.urdf --out motion.yaml --play motion.csv", "if there is no log yet: a motion to record"),
];

/// Largest width of the help, characters.
pub(crate) const COLUMNS: usize = 100;
const SHARED_HEADING: &str = "How the description is read";
const TERMINAL_HEADING: &str = "Terminal";

/// Arranges the help of the program: commands in groups, flags in the defined order.
pub(crate) fn arranged(program: Command) -> Command {
    let groups = groups_of(&program);
    let list = list(&program, &groups);
    let helps = groups.into_iter().flat_map(|group| group.commands);
    let program = helps.fold(program, |program, help| program.mut_subcommand(help.name, |command| of(&help, command)));
    program
        .disable_help_flag(true)
        .arg(Arg::new("help").short('h').long("help").action(ArgAction::HelpShort).help("Print this help"))
        .arg(Arg::new("help_all").long("help-all").action(ArgAction::HelpLong).help("Print the option for colours too"))
        .help_template(format!("{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{list}\nOptions:\n{{options}}"))
}

/// The groups with the commands that this build contains. Wings (optional packages) may be missing.
fn groups_of(program: &Command) -> Vec<CommandGroup> {
    let mut groups = groups();
    groups.iter_mut().for_each(|group| group.commands.retain(|help| program.find_subcommand(help.name).is_some()));
    groups.retain(|group| !group.commands.is_empty());
    groups
}

/// The list of all commands in groups, followed by the first steps.
fn list(program: &Command, groups: &[CommandGroup]) -> String {
    let styles = program.get_styles();
    let (header, literal) = (styles.get_header(), styles.get_literal());
    let width = groups.iter().flat_map(|group| &group.commands).map(|help| help.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for group in groups {
        text += &format!("{header}{}:{header:#}\n", group.title);
        for CommandHelp { name, .. } in &group.commands {
            let about =
                program.find_subcommand(name).and_then(Command::get_about).map_or(String::new(), |a| a.to_string());
            let about = folded(&about, COLUMNS - width - 4).join(&format!("\n{:1$}", "", width + 4));
            text += &format!("  {literal}{name}{literal:#}{:1$}  {about}\n", "", width - name.len());
        }
    }
    text += &format!("\n{header}To begin with:{header:#}\n{}", examples(&FIRST_STEPS));
    text + "\nrist COMMAND --help has the most frequent flags, and examples; --help-all has every flag.\n"
}

/// Formats examples: each command line with its purpose below.
fn examples(of: &[(&str, &str)]) -> String {
    of.iter().map(|(line, what)| format!("  {line}\n      {what}\n")).collect()
}

/// Arranges the flags of a command: first its own flags, then options of the description, then options of the terminal.
fn of(help: &CommandHelp, command: Command) -> Command {
    let shared: Vec<&str> = ModelOptions::fields().iter().map(|field| field.name).collect();
    let is_shared = |arg: &Arg| shared.contains(&arg.get_id().as_str());
    let is_shown = |arg: &Arg| match &help.shown {
        All => true,
        Own => !is_shared(arg),
        Only(names) => arg.is_positional() || names.contains(&arg.get_id().as_str()),
    };
    let (of_description, own): (Vec<Arg>, Vec<Arg>) = command.get_arguments().cloned().partition(is_shared);
    let of_description = of_description.into_iter().map(|arg| arg.help_heading(SHARED_HEADING));
    let args = own.into_iter().chain(of_description).map(|arg| {
        let is_hidden = !is_shown(&arg);
        arg.hide_short_help(is_hidden)
    });
    let args: Vec<Arg> = args.collect();
    let hidden = args.iter().filter(|arg| arg.is_hide_short_help_set()).count();
    let flag = |id, long, action, text: String| {
        let flag = Arg::new(id).long(long).action(action).help(text);
        flag.help_heading(TERMINAL_HEADING).display_order(LAST_DISPLAY_ORDER)
    };
    let all = match hidden {
        0 => "Print every flag with its full text".to_string(),
        1 => "Print every flag, 1 more than here".to_string(),
        more => format!("Print every flag, {more} more than here"),
    };
    // clap keeps the order in which arguments were added, so the command is built again from its parts.
    let mut arranged = Command::new(help.name).args(args).groups(command.get_groups().cloned());
    if let Some(about) = command.get_about() {
        arranged = arranged.about(about.clone());
    }
    if let Some(about) = command.get_long_about() {
        arranged = arranged.long_about(about.clone());
    }
    let heading = if help.examples.len() == 1 { "Example:" } else { "Examples:" };
    arranged
        .disable_help_flag(true)
        .arg(flag("help", "help", ArgAction::HelpShort, "Print this help".into()).short('h'))
        .arg(flag("help_all", "help-all", ArgAction::HelpLong, all))
        .after_help(format!("{heading}\n{}", examples(&help.examples).trim_end()))
}

/// Display order of a flag that is listed last among the flags of the terminal.
const LAST_DISPLAY_ORDER: usize = 1000;

#[cfg(test)]
mod tests {
    use clap::CommandFactory;
    use clap::error::ErrorKind;

    use super::*;

    /// The program with a fixed text width, which does not depend on the terminal of the test.
    fn program() -> Command {
        arranged(crate::Arguments::command()).term_width(COLUMNS)
    }

    #[test]
    fn a_command_that_is_not_built_in_is_not_listed() {
        let merge = Command::new("merge").about("Merge sums");
        let help = arranged(Command::new("rist").subcommand(merge)).render_help().to_string();
        assert!(help.contains("  merge  Merge sums"), "{help}");
        assert!(!help.contains("postures") && !help.contains("wrench"), "{help}");
    }

    fn helps() -> impl Iterator<Item = CommandHelp> {
        groups().into_iter().flat_map(|group| group.commands)
    }

    /// The help that the program prints for the command line `line`.
    fn help(line: &[&str]) -> String {
        let asked = program().try_get_matches_from(line).expect_err("help is no command");
        assert_eq!(asked.kind(), ErrorKind::DisplayHelp, "{asked}");
        asked.to_string()
    }

    #[test]
    fn every_command_stands_in_one_group() {
        let mut names: Vec<&str> = helps().map(|help| help.name).collect();
        let program = crate::Arguments::command();
        let mut commands: Vec<&str> = program.get_subcommands().map(Command::get_name).collect();
        names.sort_unstable();
        commands.sort_unstable();
        assert_eq!(names, commands);
        assert!(names.len() > 15);
    }

    #[test]
    fn help_fits_a_screen_and_a_half() {
        let lines = |text: &str| text.lines().map(str::to_string).collect::<Vec<_>>();
        let all = helps().map(|entry| (entry.name, help(&["rist", entry.name, "--help"])));
        for (name, text) in all.chain([("rist", help(&["rist", "--help"]))]) {
            let lines = lines(&text);
            assert!(lines.len() <= 60, "rist {name} --help: {} lines\n{text}", lines.len());
            for line in lines {
                assert!(line.chars().count() <= COLUMNS, "rist {name} --help: {line}");
            }
        }
    }

    #[test]
    fn all_help_has_every_flag_in_a_hundred_columns() {
        let program = crate::Arguments::command();
        for entry in helps() {
            let text = help(&["rist", entry.name, "--help-all"]);
            let command = program.find_subcommand(entry.name).expect("it is in one group");
            for flag in command.get_arguments().filter_map(|arg| arg.get_long()) {
                let flag = format!("--{flag}");
                let is_there = text.lines().any(|line| line.split_whitespace().take(2).any(|word| word == flag));
                assert!(is_there, "rist {} --help-all has no {flag}\n{text}", entry.name);
            }
            for line in text.lines() {
                assert!(line.chars().count() <= COLUMNS, "rist {} --help-all: {line}", entry.name);
            }
            if let Only(names) = &entry.shown {
                let known = |name: &&str| command.get_arguments().any(|arg| arg.get_id() == name);
                let unknown: Vec<_> = names.iter().filter(|name| !known(name)).collect();
                assert!(unknown.is_empty(), "rist {} has no {unknown:?}", entry.name);
            }
        }
    }

    #[test]
    fn shared_flags_come_last() {
        for entry in helps() {
            let text = help(&["rist", entry.name, "--help-all"]);
            let headings: Vec<&str> =
                text.lines().filter(|line| line.ends_with(':') && !line.starts_with(' ')).collect();
            let place = |heading: &str| headings.iter().position(|line| line.trim_end_matches(':') == heading);
            let terminal = place(TERMINAL_HEADING).expect("every command has it");
            assert!(headings[terminal + 1..].iter().all(|line| line.starts_with("Example")), "{headings:?}");
            if let Some(shared) = place(SHARED_HEADING) {
                assert_eq!(shared + 1, terminal, "rist {}: {headings:?}", entry.name);
            }
        }
    }

    #[test]
    fn every_command_has_an_example_that_parses() {
        let parsed = |line: &str| {
            let words = line.split_whitespace().take_while(|word| *word != ">");
            program().try_get_matches_from(words).unwrap_or_else(|e| panic!("{line}\n{e}"))
        };
        for entry in helps() {
            let mut is_there = false;
            for &(line, what) in &entry.examples {
                let command = parsed(line).subcommand_name().map(str::to_string);
                is_there |= command.as_deref() == Some(entry.name);
                assert!(!what.is_empty() && line.len() <= COLUMNS - 2, "{line}");
            }
            assert!(is_there, "rist {} has no example of its own", entry.name);
        }
        for (line, _) in FIRST_STEPS {
            parsed(line);
        }
    }
}
