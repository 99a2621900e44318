//! Fields in texts, as the reader of the text writes them.
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
//!
//! Only names of fields are spelled. Other brackets, such as `[-2, 2]`, stay.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use super::all_fields;

/// Who reads a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reader {
    /// A person at a command line.
    Program,
    /// A person who writes Python.
    Python,
}

/// What the program has beside the fields of requests: files that it reads and writes.
const OF_FILES: [&str; 19] = [
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
    "play",
    "report",
    "series",
    "validate",
    "write_mjcf",
    "write_urdf",
];

fn is_field(name: &str) -> bool {
    static NAMES: OnceLock<BTreeSet<&'static str>> = OnceLock::new();
    NAMES.get_or_init(|| all_fields().iter().map(|field| field.name).chain(OF_FILES).collect()).contains(name)
}

/// The text with its fields as `reader` writes them.
pub fn spelled(text: &str, reader: Reader) -> String {
    let mut spelled = String::new();
    let mut rest = text;
    while let Some((before, behind)) = rest.split_once('[') {
        spelled.push_str(before);
        match field(behind) {
            Some((name, more, length)) => {
                spelled.push_str(&written(name, more, reader));
                rest = &behind[length..];
            }
            None => {
                spelled.push('[');
                rest = behind;
            }
        }
    }
    spelled + rest
}

/// The name of the field at the start of a text, what follows it, and the length up to behind the bracket.
fn field(text: &str) -> Option<(&str, &str, usize)> {
    let (inside, _) = text.split_once(']')?;
    let end = inside.find(|c: char| !(c.is_ascii_lowercase() || c == '_')).unwrap_or(inside.len());
    let (name, more) = inside.split_at(end);
    (is_field(name) && (more.is_empty() || more.starts_with(['=', '.']))).then_some((name, more, inside.len() + 1))
}

fn written(name: &str, more: &str, reader: Reader) -> String {
    let (value, keys) = (more.strip_prefix('='), more.strip_prefix('.'));
    match reader {
        Reader::Program => {
            let flag = format!("--{}", name.replace('_', "-"));
            match (value, keys) {
                (Some("true"), _) | (None, None) => flag,
                (Some(value), _) => format!("{flag} {value}"),
                (_, Some(keys)) => format!("{flag}: {}", keys.replace('.', ": ")),
            }
        }
        Reader::Python => match (value, keys) {
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

/// A value of a command line as a literal of Python.
fn literal(value: &str) -> String {
    if let Some((name, value)) = value.split_once('=') {
        return format!("{{'{name}': {}}}", literal(value));
    }
    if let Some((number, deviation)) = value.split_once("+-") {
        return format!("({number}, {deviation})");
    }
    let is_number = |text: &str| text.parse::<f64>().is_ok();
    match value {
        "true" => "True".into(),
        number if is_number(number) => number.into(),
        list if list.contains(',') && list.split(',').all(is_number) => format!("[{}]", list.replace(',', ", ")),
        text => format!("'{text}'"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_spelled_as_their_reader_writes_them() {
        for (text, program, python) in [
            ("[rate] is 0", "--rate is 0", "rate= is 0"),
            (
                "try [options.columns.torque]",
                "try --options: columns: torque",
                "try options={'columns': {'torque': ..}}",
            ),
            ("([anyway=true] writes it)", "(--anyway writes it)", "(anyway=True writes it)"),
            ("[steps=3], [method=iv]", "--steps 3, --method iv", "steps=3, method='iv'"),
            ("[plan=q1=11+-2]", "--plan q1=11+-2", "plan={'q1': (11, 2)}"),
            ("[plan=q1=6,12]", "--plan q1=6,12", "plan={'q1': [6, 12]}"),
            ("[-2, 2] [x] [default: 3] [rate", "[-2, 2] [x] [default: 3] [rate", "[-2, 2] [x] [default: 3] [rate"),
        ] {
            assert_eq!(spelled(text, Reader::Program), program);
            assert_eq!(spelled(text, Reader::Python), python);
        }
    }
}
