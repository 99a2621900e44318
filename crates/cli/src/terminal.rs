//! Prints results on standard output, as text or as JSON, and notes and progress on standard error.
//!
//! Colours are used only on a terminal. If work takes longer than a second, its name is shown on the terminal, in a line that
//! is erased afterwards.

use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use anstream::AutoStream;
use anstyle::{AnsiColor, Style};
use clap::{Args, ColorChoice};
use rist::gate::shown;
use rist::request::spelling::{Audience, spelled};
use serde_json::Value;

use crate::failure::Failure;

/// How the program speaks, for every command.
#[derive(Args, Clone, Copy, Default)]
#[command(next_help_heading = "Terminal")]
pub(crate) struct TerminalArguments {
    /// Print the result as JSON
    #[arg(long, global = true)]
    pub json: bool,

    /// Print only the result and errors, no notes and no progress
    #[arg(long, short, global = true)]
    pub quiet: bool,

    /// When to print colours; the environment variable NO_COLOR turns them off too
    #[arg(long, global = true, value_name = "WHEN", default_value_t = ColorChoice::Auto, hide_short_help = true)]
    pub color: ColorChoice,
}

/// The command-line arguments for output. They are set once, before any output.
static ARGUMENTS: OnceLock<TerminalArguments> = OnceLock::new();

/// Sets colours and form (text or JSON) of all later output.
pub(crate) fn set(arguments: TerminalArguments) {
    match arguments.color {
        ColorChoice::Auto => anstream::ColorChoice::Auto,
        ColorChoice::Always => anstream::ColorChoice::Always,
        ColorChoice::Never => anstream::ColorChoice::Never,
    }
    .write_global();
    // Only the first call has an effect. It happens at the start of the program.
    let _ = ARGUMENTS.set(arguments);
}

fn arguments() -> TerminalArguments {
    ARGUMENTS.get().copied().unwrap_or_default()
}

/// Whether the result is printed as JSON.
pub(crate) fn is_json() -> bool {
    arguments().json
}

/// Prints the result of a command: `text`, or with --json the value of `json`.
pub(crate) fn print_result(
    text: impl Display,
    json: impl FnOnce() -> Result<Value, serde_json::Error>,
) -> Result<(), Failure> {
    print_folded(text, columns(), json)
}

/// Prints the result of a command like [`print_result`], but without folding lines, because users paste this text into a file.
pub(crate) fn print_lines(
    text: impl Display,
    json: impl FnOnce() -> Result<Value, serde_json::Error>,
) -> Result<(), Failure> {
    print_folded(text, usize::MAX, json)
}

fn print_folded(
    text: impl Display,
    columns: usize,
    json: impl FnOnce() -> Result<Value, serde_json::Error>,
) -> Result<(), Failure> {
    if !is_json() {
        let text = spelled(&text.to_string(), Audience::Program);
        return print(&shown::lines(&in_columns(&text, columns)));
    }
    match json() {
        Ok(value) => print(&shown::json(&spelled(&format!("{value:#}\n"), Audience::Program))),
        Err(e) => Err(Failure::new(format_args!("the result cannot be written as JSON: {e}"))),
    }
}

/// Prints to standard output. A closed pipe (`rist ... | head`) counts as success.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let _at = took_away();
    match AutoStream::auto(io::stdout()).write_all(coloured(text).as_bytes()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(Failure::new(format_args!("standard output: {e}"))),
        _ => Ok(()),
    }
}

/// Prints a note for the user on standard error.
pub(crate) fn note(text: impl Display) {
    if !arguments().quiet {
        let text = spelled(&format!("note: {text}\n"), Audience::Program);
        complain(&in_columns(&text, columns()));
    }
}

/// Largest width to which sentences are folded, characters. If the terminal is narrower, the width of the terminal is used.
const LARGEST_WIDTH: usize = 100;
/// Smallest width to which sentences are folded, characters. A narrower terminal breaks the lines itself.
const SMALLEST_WIDTH: usize = 40;

/// Width of the output, characters: from the environment variable COLUMNS, otherwise from the terminal, at most 100.
fn columns() -> usize {
    let asked = std::env::var("COLUMNS").ok().and_then(|text| text.parse().ok());
    let of_terminal = || {
        let out = io::stdout();
        let found = out.is_terminal().then(|| terminal_size::terminal_size_of(&out)).flatten();
        found.map_or(LARGEST_WIDTH, |(width, _)| usize::from(width.0).min(LARGEST_WIDTH))
    };
    asked.unwrap_or_else(of_terminal).max(SMALLEST_WIDTH)
}

/// Folds the long lines of a text. Lines of tables are kept; a table is recognised by several spaces between its cells.
fn in_columns(text: &str, columns: usize) -> String {
    let mut out = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let (start, end) = (line.trim_end_matches('\n'), &line[line.trim_end_matches('\n').len()..]);
        let words = start.trim_start();
        let indent = start.len() - words.len();
        if start.chars().count() <= columns || words.contains("  ") {
            out += line;
            continue;
        }
        // All lines but the first are indented by two more characters than the first line.
        let hang = format!("\n{:1$}", "", indent + 2);
        out += &start[..indent];
        out += &folded(words, columns - (indent + 2).min(columns / 2)).join(&hang);
        out += end;
    }
    out
}

/// Splits a text into lines of at most `columns` characters; a longer word gets its own line.
pub(crate) fn folded(text: &str, columns: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= columns => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

/// Notes of a step as lines to print before its result. Empty with --quiet.
pub(crate) fn notes(texts: &[String]) -> String {
    let texts = if arguments().quiet { &[] } else { texts };
    texts.iter().map(|text| format!("note: {text}\n")).collect()
}

/// Prints the progress of a search on standard error.
pub(crate) fn progress(text: impl Display) {
    if !arguments().quiet {
        complain(&format!("{text}\n"));
    }
}

/// Writes to standard error. Write errors, for example of a closed stream, are ignored.
pub(crate) fn complain(text: &str) {
    let _at = took_away();
    let _ = AutoStream::auto(io::stderr()).write_all(coloured(&shown::lines(text)).as_bytes());
}

/// Words that get a colour at the start of a line.
const COLOURED_WORDS: [(&str, AnsiColor); 5] = [
    ("trust: yes", AnsiColor::Green),
    ("trust: with care", AnsiColor::Yellow),
    ("trust: no", AnsiColor::Red),
    ("note:", AnsiColor::Cyan),
    ("rist:", AnsiColor::Red),
];

/// Adds colours to the words in `COLOURED_WORDS`. For a stream that is no terminal, the colours are removed later.
fn coloured(text: &str) -> String {
    let line = |line: &str| match COLOURED_WORDS.iter().find(|(word, _)| line.starts_with(word)) {
        Some((word, color)) => {
            let style = Style::new().bold().fg_color(Some((*color).into()));
            format!("{style}{word}{style:#}{}", &line[word.len()..])
        }
        None => line.to_string(),
    };
    text.split_inclusive('\n').map(line).collect()
}

/// The current work of the program, shown on the terminal.
struct ProgressState {
    what: String,
    since: Instant,
    /// Whether a line about this work is on the terminal now.
    shown: bool,
}

static AT: Mutex<Option<ProgressState>> = Mutex::new(None);

/// The name of the current work is shown if the work takes longer than this time.
const LONGEST_SILENCE: Duration = Duration::from_secs(1);
const WATCH_INTERVAL: Duration = Duration::from_millis(250);
/// Moves the cursor to the start of the line and erases the line.
const ERASE_LINE: &str = "\r\x1b[K";

fn at() -> MutexGuard<'static, Option<ProgressState>> {
    AT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Erases the line about the current work. It is not shown again until the returned guard is dropped.
fn took_away() -> MutexGuard<'static, Option<ProgressState>> {
    let mut now = at();
    if let Some(at) = now.as_mut().filter(|at| at.shown) {
        at.shown = false;
        let _ = io::stderr().write_all(ERASE_LINE.as_bytes());
    }
    now
}

/// Sets the text for the current work, for example `reading log.csv`. The terminal shows this text after one second.
pub(crate) fn at_work(what: impl Display) {
    static WATCH: OnceLock<bool> = OnceLock::new();
    let is_watched = *WATCH.get_or_init(|| {
        let is_seen = !arguments().quiet && io::stderr().is_terminal();
        if is_seen {
            thread::spawn(watch);
        }
        is_seen
    });
    if is_watched {
        *took_away() = Some(ProgressState { what: what.to_string(), since: Instant::now(), shown: false });
    }
}

/// Erases the line about the current work, because the work has ended.
pub(crate) fn rest() {
    *took_away() = None;
}

/// Updates the line about the current work every 250 ms, until the program ends.
fn watch() {
    loop {
        thread::sleep(WATCH_INTERVAL);
        if let Some(at) = at().as_mut().filter(|at| at.since.elapsed() > LONGEST_SILENCE) {
            at.shown = true;
            let line = format!("{ERASE_LINE}{}, {} s", shown::line(&at.what), at.since.elapsed().as_secs());
            let _ = io::stderr().write_all(line.as_bytes());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_are_folded_and_tables_are_not() {
        let row = format!("a  {}", "1.0  ".repeat(30));
        let text = format!("found: {}\n  - {}\n{row}\n\nshort\n", "one two ".repeat(20), "three ".repeat(30));
        let folded = in_columns(&text, 60);
        let words = |text: &str| text.split_whitespace().map(str::to_string).collect::<Vec<_>>();
        assert_eq!(words(&folded), words(&text));
        assert!(folded.lines().all(|line| line.len() <= 60 || line == row), "{folded}");
        let has = |text: &str| folded.contains(text);
        assert!(has("\n    three") && (has("\n  two") || has("\n  one")), "{folded}");
        assert_eq!(in_columns(&text, 1000), text);
        assert_eq!(in_columns(&"x".repeat(90), 60), "x".repeat(90));
    }

    #[test]
    fn words_at_the_start_of_a_line_are_coloured() {
        let text = "found: x\ntrust: no\n  - note: y\nnotes: z\n";
        let seen = coloured(text);
        assert!(seen.starts_with("found: x\n\u{1b}[1m\u{1b}[31mtrust: no\u{1b}[0m\n  - note: y\nnotes: z"), "{seen:?}");
        assert_eq!(anstream::adapter::strip_str(&seen).to_string(), text);
    }
}
