//! What the program says: the result on standard output, as text or as JSON; notes and progress on standard error.
//!
//! Colours stand where a terminal is, and there only. What takes longer than a second says on a terminal what it is at,
//! in a line that it takes away again.

use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use anstream::AutoStream;
use anstyle::{AnsiColor, Style};
use clap::{Args, ColorChoice};
use rist::gate::shown;
use rist::request::spelling::{Reader, spelled};
use serde_json::Value;

use crate::failure::Failure;

/// How the program speaks, for every command.
#[derive(Args, Clone, Copy, Default)]
#[command(next_help_heading = "Terminal")]
pub(crate) struct TerminalArguments {
    /// Print the result as JSON
    #[arg(long, global = true)]
    pub json: bool,

    /// Print the result and errors alone, no notes and no progress
    #[arg(long, short, global = true)]
    pub quiet: bool,

    /// Colours; NO_COLOR in the environment turns them off too
    #[arg(long, global = true, value_name = "WHEN", default_value_t = ColorChoice::Auto, hide_short_help = true)]
    pub color: ColorChoice,
}

/// Set once, before anything is said.
static ARGUMENTS: OnceLock<TerminalArguments> = OnceLock::new();

/// Decides how everything after it is said.
pub(crate) fn set(arguments: TerminalArguments) {
    match arguments.color {
        ColorChoice::Auto => anstream::ColorChoice::Auto,
        ColorChoice::Always => anstream::ColorChoice::Always,
        ColorChoice::Never => anstream::ColorChoice::Never,
    }
    .write_global();
    // A second call would change nothing; there is one, in main.
    let _ = ARGUMENTS.set(arguments);
}

fn arguments() -> TerminalArguments {
    ARGUMENTS.get().copied().unwrap_or_default()
}

/// Whether the result is wanted as JSON.
pub(crate) fn is_json() -> bool {
    arguments().json
}

/// Prints the result of a command: `text`, or what `json` makes where --json asks for it.
pub(crate) fn print_result(
    text: impl Display,
    json: impl FnOnce() -> Result<Value, serde_json::Error>,
) -> Result<(), Failure> {
    print_folded(text, columns(), json)
}

/// As [`print_result`], each line as it is: it is meant for a file.
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
        let text = spelled(&text.to_string(), Reader::Program);
        return print(&shown::lines(&in_columns(&text, columns)));
    }
    match json() {
        Ok(value) => print(&shown::json(&spelled(&format!("{value:#}\n"), Reader::Program))),
        Err(e) => Err(Failure::new(format_args!("the result cannot be written as JSON: {e}"))),
    }
}

/// Prints to standard output; a reader that went away (`rist ... | head`) is no failure.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let _at = took_away();
    match AutoStream::auto(io::stdout()).write_all(coloured(text).as_bytes()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(Failure::new(format_args!("standard output: {e}"))),
        _ => Ok(()),
    }
}

/// Says on standard error what the user should know beside the result.
pub(crate) fn note(text: impl Display) {
    if !arguments().quiet {
        let text = spelled(&format!("note: {text}\n"), Reader::Program);
        complain(&in_columns(&text, columns()));
    }
}

/// Columns that sentences are folded at where no terminal says less.
const MOST_COLUMNS: usize = 100;
/// A narrower terminal folds by itself.
const FEWEST_COLUMNS: usize = 40;

/// Columns of standard output: what COLUMNS in the environment says, else those of the terminal, at most 100.
fn columns() -> usize {
    let asked = std::env::var("COLUMNS").ok().and_then(|text| text.parse().ok());
    let of_terminal = || {
        let out = io::stdout();
        let found = out.is_terminal().then(|| terminal_size::terminal_size_of(&out)).flatten();
        found.map_or(MOST_COLUMNS, |(width, _)| usize::from(width.0).min(MOST_COLUMNS))
    };
    asked.unwrap_or_else(of_terminal).max(FEWEST_COLUMNS)
}

/// The text with its sentences folded; lines of tables, which have several blanks between their cells, stay.
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
        // What follows stands below the words of a bullet, and two columns in elsewhere.
        let hang = format!("\n{:1$}", "", indent + 2);
        out += &start[..indent];
        out += &folded(words, columns - (indent + 2).min(columns / 2)).join(&hang);
        out += end;
    }
    out
}

/// The words of a text in lines of at most so many characters; a longer word has a line of its own.
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

/// What a step says beside its result, as lines before it; nothing where notes are not wanted.
pub(crate) fn notes(texts: &[String]) -> String {
    let texts = if arguments().quiet { &[] } else { texts };
    texts.iter().map(|text| format!("note: {text}\n")).collect()
}

/// Says on standard error how far a search is.
pub(crate) fn progress(text: impl Display) {
    if !arguments().quiet {
        complain(&format!("{text}\n"));
    }
}

/// Writes to standard error; where that is closed, nobody is there to be told.
pub(crate) fn complain(text: &str) {
    let _at = took_away();
    let _ = AutoStream::auto(io::stderr()).write_all(coloured(&shown::lines(text)).as_bytes());
}

/// Words at the start of a line that stand out.
const COLOURED_WORDS: [(&str, AnsiColor); 5] = [
    ("trust: yes", AnsiColor::Green),
    ("trust: with care", AnsiColor::Yellow),
    ("trust: no", AnsiColor::Red),
    ("note:", AnsiColor::Cyan),
    ("rist:", AnsiColor::Red),
];

/// The text with its words in colours, which a stream that is no terminal leaves out.
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

/// What the program is at.
struct At {
    what: String,
    since: Instant,
    /// Whether a line about it stands on the terminal.
    shown: bool,
}

static AT: Mutex<Option<At>> = Mutex::new(None);

/// A second of silence is what a person takes for granted.
const LONGEST_SILENCE: Duration = Duration::from_secs(1);
const WATCH_INTERVAL: Duration = Duration::from_millis(250);
/// Back to the start of the line, and the line away.
const ERASE_LINE: &str = "\r\x1b[K";

fn at() -> MutexGuard<'static, Option<At>> {
    AT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes the line of what the program is at away, until the guard is dropped.
fn took_away() -> MutexGuard<'static, Option<At>> {
    let mut now = at();
    if let Some(at) = now.as_mut().filter(|at| at.shown) {
        at.shown = false;
        let _ = io::stderr().write_all(ERASE_LINE.as_bytes());
    }
    now
}

/// From now on the program is at this: `reading log.csv`. Shown on a terminal while it takes more than a second.
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
        *took_away() = Some(At { what: what.to_string(), since: Instant::now(), shown: false });
    }
}

/// Nothing is at work any more.
pub(crate) fn rest() {
    *took_away() = None;
}

/// Ends with the program.
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
