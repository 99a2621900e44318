//! Replaces names of fields in texts by the spelling of the reader: as flags, Python keywords or JSON keys.
//!
//! In JSON a field is written by its name: `effort_share`, `delay: auto`.
//!
//! | text of a library | program | Python |
//! |---|---|---|
//! | `[effort_share]` | `--effort-share` | `effort_share=` |
//! | `[delay=auto]` | `--delay auto` | `delay='auto'` |
//! | `[validation=0]` | `--validation 0` | `validation=0` |
//! | `[anyway=true]` | `--anyway` | `anyway=True` |
//! | `[gain=q1=11.5]` | `--gain q1=11.5` | `gain={'q1': 11.5}` |
//! | `[gain=q1=11+-2]` | `--gain q1=11+-2` | `gain={'q1': (11, 2)}` |
//! | `[ripple=q1=6,12]` | `--ripple q1=6,12` | `ripple={'q1': [6, 12]}` |
//! | `[options.columns.torque]` | `--options: columns: torque` | `options={'columns': {'torque': ..}}` |
//! | `[:doctor]`, a step | `rist doctor` | `rist.doctor` |
//! | `[:validate MODEL LOG]` | `rist validate MODEL LOG` | `rist.validate(model, log)` |
//!
//! Only names of fields and steps are replaced, and only if they are separate words. Other brackets stay, for example `[-2, 2]`
//! and the file name `log[gain].csv`.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

use serde_json::Value;

use super::{Field, all_fields, number};
use crate::error::Step;

/// The reader for whom a text is written. It decides how options are spelled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Audience {
    /// A program in Rust: the text stays as it is.
    #[default]
    Library,
    /// A user of the command line.
    Program,
    /// A user of Python.
    Python,
    /// A user of JSON.
    Json,
}

/// Flags of the program that texts may name, in addition to the fields of requests. Most of them are for files to read or write.
const FLAGS_OF_FILES: [&str; 19] = [
    "after",
    "anyway",
    "date",
    "estimate",
    "feedforward",
    "into",
    "like",
    "limits",
    "load",
    "method",
    "options",
    "out",
    "plan",
    "backlash",
    "report",
    "series",
    "validate",
    "write_mjcf",
    "write_urdf",
];

fn is_field(name: &str) -> bool {
    static NAMES: OnceLock<BTreeSet<&'static str>> = OnceLock::new();
    NAMES.get_or_init(|| all_fields().iter().map(|field| field.name).chain(FLAGS_OF_FILES).collect()).contains(name)
}

/// The flag of the field `name`, with its dashes.
fn flag_of(name: &str) -> String {
    static OTHERS: OnceLock<BTreeMap<&'static str, String>> = OnceLock::new();
    let is_other = |field: &Field| field.flag_name() != field.name.replace('_', "-");
    let others = OTHERS.get_or_init(|| {
        all_fields().iter().filter(|field| is_other(field)).map(|field| (field.name, field.flag_name())).collect()
    });
    let flag = others.get(name).cloned().unwrap_or_else(|| name.replace('_', "-"));
    format!("--{flag}")
}

/// The text with its fields and steps spelled for `reader`.
pub fn spelled(text: &str, reader: Audience) -> String {
    if reader == Audience::Library {
        return text.into();
    }
    let mut spelled = String::new();
    let mut rest = text;
    while let Some((before, behind)) = rest.split_once('[') {
        spelled.push_str(before);
        let found = to_closing_bracket(behind).and_then(|(inside, rest)| Some((bracket(inside, reader)?, rest)));
        match found.filter(|(_, behind)| is_word(&spelled, behind)) {
            Some((word, behind)) => {
                spelled.push_str(&word);
                rest = behind;
            }
            None => {
                spelled.push('[');
                rest = behind;
            }
        }
    }
    spelled + rest
}

/// Splits a text at the bracket that closes an open one. A value may have brackets itself, such as the name `J 1 [rad]`.
fn to_closing_bracket(behind: &str) -> Option<(&str, &str)> {
    let mut open = 0;
    let closes = |(_, c): &(usize, char)| {
        open += i32::from(*c == '[') - i32::from(*c == ']');
        open < 0
    };
    let (at, _) = behind.char_indices().find(closes)?;
    Some((&behind[..at], &behind[at + 1..]))
}

/// The spelling of the text `inside` brackets; `None` if it is neither a field nor a step.
fn bracket(inside: &str, reader: Audience) -> Option<String> {
    if let Some(inside) = inside.strip_prefix(':') {
        let (word, given) = inside.split_once(' ').unwrap_or((inside, ""));
        let step = Step::named(word)?;
        return Some(match reader {
            Audience::Python => step.in_python(given),
            _ => spelled(&step.in_program(given), reader),
        });
    }
    let (name, more) = field(inside)?;
    Some(written(name, more, reader))
}

/// Splits a text into the name of a field and the text after the name; `None` if it does not start with a field.
fn field(inside: &str) -> Option<(&str, &str)> {
    let end = inside.find(|c: char| !(c.is_ascii_lowercase() || c == '_')).unwrap_or(inside.len());
    let (name, more) = inside.split_at(end);
    (is_field(name) && (more.is_empty() || more.starts_with(['=', '.']))).then_some((name, more))
}

/// Whether a name in brackets is a separate word, and not part of a name or a path. `before`, `behind`: the text around the
/// brackets.
fn is_word(before: &str, behind: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || "_-/.~".contains(c);
    // A full stop behind the bracket may end a sentence, so it is ignored.
    let behind = behind.trim_start_matches('.');
    !before.ends_with(is_part) && !behind.starts_with(is_part)
}

fn written(name: &str, more: &str, reader: Audience) -> String {
    let (value, keys) = (more.strip_prefix('='), more.strip_prefix('.'));
    match reader {
        Audience::Library => format!("[{name}{more}]"),
        Audience::Program => {
            let flag = flag_of(name);
            match (value, keys) {
                (Some("true"), _) | (None, None) => flag,
                (Some(value), _) => format!("{flag} {}", quoted(value)),
                (_, Some(keys)) => format!("{flag}: {}", keys.replace('.', ": ")),
            }
        }
        Audience::Json => format!("`{name}{}`", more.replace('=', ": ")),
        Audience::Python => match (value, keys) {
            (Some(value), _) => format!("{name}={}", literal(value)),
            (_, Some(keys)) => {
                let keys: Vec<&str> = keys.split('.').collect();
                let open: String = keys.iter().map(|key| format!("{{'{key}': ")).collect();
                format!("{name}={open}..{}", "}".repeat(keys.len()))
            }
            _ => format!("{name}="),
        },
    }
}

/// Writes a value of a command line with quotes, if a shell would change it.
fn quoted(value: &str) -> String {
    let is_special = |c: char| c.is_whitespace() || "'\"$`\\&|;<>()[]*?#".contains(c);
    if value.contains(is_special) { format!("'{}'", value.replace('\'', "'\\''")) } else { value.into() }
}

/// Writes a value of a command line as a Python literal.
fn literal(value: &str) -> String {
    let pieces: Vec<&str> = value.split(',').collect();
    if value.contains('=') {
        // In `q1=6,12,q2=3`, the number 12 has no name, so it belongs to q1. `..` stands for further names.
        let mut by_name: Vec<(&str, Vec<String>)> = Vec::new();
        for piece in pieces {
            match (piece.split_once('='), by_name.last_mut()) {
                (Some((name, x)), Some((last, numbers))) if *last == name => numbers.push(plain(x)),
                (Some((name, x)), _) => by_name.push((name, vec![plain(x)])),
                (None, Some((_, numbers))) if piece != ".." => numbers.push(plain(piece)),
                (None, _) => by_name.push(("", Vec::new())),
            }
        }
        let one = |(name, numbers): &(&str, Vec<String>)| match numbers.as_slice() {
            [] => "..".into(),
            [one] => format!("'{name}': {one}"),
            _ => format!("'{name}': [{}]", numbers.join(", ")),
        };
        return format!("{{{}}}", by_name.iter().map(one).collect::<Vec<String>>().join(", "));
    }
    match pieces.as_slice() {
        [one] => plain(one),
        _ => format!("[{}]", pieces.into_iter().map(plain).collect::<Vec<_>>().join(", ")),
    }
}

/// Writes one value as a Python literal: a number as it is, `true` as `True`, `a+-b` as the tuple `(a, b)`, any other text in
/// quotes. The value must contain neither a comma nor `NAME=`.
fn plain(value: &str) -> String {
    if let Some((number, deviation)) = value.split_once("+-") {
        return format!("({number}, {deviation})");
    }
    match value {
        "true" => "True".into(),
        number if number.parse::<f64>().is_ok() => number.into(),
        text => format!("'{text}'"),
    }
}

/// Writes values of a request as flags of a command line, each with a space before it.
pub fn flags(given: &[(&'static str, Value)]) -> String {
    let mut text = String::new();
    for (name, value) in given {
        let flag = format!(" {}", flag_of(name));
        let word = |value: &Value| match value {
            Value::String(word) => word.clone(),
            Value::Number(x) => number(x.as_f64().unwrap_or(f64::NAN)),
            other => other.to_string(),
        };
        match value {
            Value::Bool(_) | Value::Null => text += &flag,
            Value::Object(by_name) => {
                by_name.iter().for_each(|(name, x)| text += &format!("{flag} {name}={}", word(x)))
            }
            Value::Array(list) => {
                text += &format!("{flag} {}", list.iter().map(word).collect::<Vec<String>>().join(","));
            }
            one => text += &format!("{flag} {}", word(one)),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_spelled_as_their_reader_writes_them() {
        // Each entry: a text, its spelling for the program, its spelling for Python.
        for (text, program, python) in [
            ("[rate] is 0", "--rate is 0", "rate= is 0"),
            ("([:doctor] says more)", "(rist doctor says more)", "(rist.doctor says more)"),
            (
                "[:validate MODEL LOG], [:nothing]",
                "rist validate MODEL LOG, [:nothing]",
                "rist.validate(model, log), [:nothing]",
            ),
            (
                "try [options.columns.torque]",
                "try --options: columns: torque",
                "try options={'columns': {'torque': ..}}",
            ),
            ("([anyway=true] writes it)", "(--anyway writes it)", "(anyway=True writes it)"),
            ("[steps=3], [method=iv]", "--steps 3, --method iv", "steps=3, method='iv'"),
            ("[plan=q1=11+-2]", "--plan q1=11+-2", "plan={'q1': (11, 2)}"),
            ("[plan=q1=6,12]", "--plan q1=6,12", "plan={'q1': [6, 12]}"),
            (
                "[gain=q1=6,12,q2=3]; [gain=q1=2,..]",
                "--gain q1=6,12,q2=3; --gain q1=2,..",
                "gain={'q1': [6, 12], 'q2': 3}; gain={'q1': 2, ..}",
            ),
            ("log[gain].csv: [gain].", "log[gain].csv: --gain.", "log[gain].csv: gain=."),
            (
                "logs/[rate]/a [rate].csv [rate]..",
                "logs/[rate]/a [rate].csv --rate..",
                "logs/[rate]/a [rate].csv rate=..",
            ),
            (
                "by [lock=J 1 [rad]=0,x_=0], or [lock=a'b=0]",
                "by --lock 'J 1 [rad]=0,x_=0', or --lock 'a'\\''b=0'",
                "by lock={'J 1 [rad]': 0, 'x_': 0}, or lock={'a'b': 0}",
            ),
            ("[backlash=q1,q2]", "--backlash q1,q2", "backlash=['q1', 'q2']"),
            ("[-2, 2] [x] [default: 3] [rate", "[-2, 2] [x] [default: 3] [rate", "[-2, 2] [x] [default: 3] [rate"),
        ] {
            assert_eq!(spelled(text, Audience::Program), program);
            assert_eq!(spelled(text, Audience::Python), python);
        }
    }
}
