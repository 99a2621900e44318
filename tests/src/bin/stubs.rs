//! Writes the documentation of request fields: signatures and docstrings of Python functions, their stubs, and the tables of
//! docs/files.md. With `--check`, it only compares. `cargo xtask stubs` calls it.
//!
//! Positional arguments, results and all other paragraphs of a docstring are not changed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use calibration::CalibrateRequest;
use fleet::{CompareRequest, SumsRequest};
use rist::request::spelling::{Audience, spelled};
use rist::request::{
    CheckRequest, DoctorRequest, ExciteRequest, Field, Flag, Method, MethodRequest, ModelOptions, PlanRequest,
    PointsFiles, Range, ReplayRequest, Request, SimulateRequest, ValidateRequest, number, requests,
};
use serde_json::Value;
use statics::WrenchRequest;
use tests::docstrings::Docstrings;
use tests::register_wings;

const STUB: &str = "crates/python/python/rist/__init__.pyi";
const PAGE: &str = "docs/files.md";
const FROM: &str = "<!-- from here: cargo xtask stubs -->\n";
const TO: &str = "<!-- to here -->\n";
/// Largest number of characters in a line of documentation.
const WIDTH: usize = 118;

/// A keyword argument of a Python function.
#[derive(Clone)]
struct Keyword {
    name: String,
    of_type: String,
    default: String,
    doc: String,
}

impl Keyword {
    fn of_field(field: &Field) -> Keyword {
        let (default, shown) = match literal(&field.default) {
            default if default == "None" => (default, String::new()),
            default => (default.clone(), format!(" [default: {default}]")),
        };
        let doc = format!("{}{shown}", spelled(&field.doc, Audience::Python));
        Keyword { name: field.name.into(), of_type: field.shape.python.clone(), default, doc }
    }

    /// An argument that exists only in Python: it is a Python object, so its type differs from the type of the request field.
    fn own(name: &str, of_type: &str, default: &str, doc: &str) -> Keyword {
        Keyword { name: name.into(), of_type: of_type.into(), default: default.into(), doc: doc.into() }
    }
}

/// A Python function that takes the fields of a request as keyword arguments.
struct Function {
    /// Name in Python, for example `Model.read`.
    name: &'static str,
    file: &'static str,
    keywords: Vec<Keyword>,
}

impl Function {
    fn new(name: &'static str, file: &'static str, fields: &[Field], own: Vec<Keyword>) -> Function {
        let mut keywords: Vec<Keyword> = Vec::new();
        for field in fields {
            if keywords.iter().all(|k| k.name != field.name) {
                keywords.push(Keyword::of_field(field));
            }
        }
        for own in own {
            match keywords.iter_mut().find(|k| k.name == own.name) {
                Some(found) => *found = own,
                None => keywords.push(own),
            }
        }
        Function { name, file, keywords }
    }

    /// The class (if it is a method), the name in Python, and the name in Rust.
    fn names(&self) -> (Option<&str>, &str, &str) {
        match self.name.split_once('.') {
            Some((class, "__init__")) => (Some(class), "__init__", "new"),
            Some((class, name)) => (Some(class), name, name),
            None => (None, self.name, self.name),
        }
    }
}

fn functions() -> Vec<Function> {
    let progress =
        || Keyword::own("progress", "Progress | None", "None", "Called with (done, all, text) during the work");
    let estimate = |name: &str, doc: &str| Keyword::own(name, "Estimate | None", "None", doc);
    let all: Vec<Field> = Method::all().flat_map(Method::fields).chain(MethodRequest::fields()).collect();
    let of_identify = vec![
        Keyword::own("loaded", "Logs", "()", "Logs with a load on the last link; the load is identified too"),
        Keyword::own("validate", "Logs", "()", "Logs that are not fitted, but predicted, for the verdict"),
        Keyword::own("plan", "ExperimentPlan | Path | None", "None", "The plan whose experiments are in the logs"),
    ];
    let rotors = ModelOptions::fields().into_iter().find(|field| field.name == "rotor_inertia");
    let of_identify = of_identify.into_iter().chain(rotors.as_ref().map(Keyword::of_field)).collect();
    let of_simulate = vec![
        Keyword::own("out", "Path | None", "None", "Directory to which the logs are written"),
        estimate("feedforward", "Estimate from which the controller computes feedforward torques"),
        progress(),
    ];
    let after = estimate("after", "The motion excites the parameters that this estimate leaves uncertain");
    let proved_after = estimate("after", "The torques in the proofs of effort and power follow from this estimate");
    let of_check = [CheckRequest::fields(), PointsFiles::fields()].concat();
    vec![
        Function::new("Model.__init__", "model.rs", &ModelOptions::fields(), Vec::new()),
        Function::new("Model.read", "model.rs", &ModelOptions::fields(), Vec::new()),
        Function::new("Model.parse", "model.rs", &ModelOptions::fields(), Vec::new()),
        Function::new("Accumulator.__init__", "fleet.rs", &SumsRequest::fields(), Vec::new()),
        Function::new("compare", "fleet.rs", &CompareRequest::fields(), Vec::new()),
        Function::new("identify", "identify.rs", &all, of_identify),
        Function::new("validate", "validation.rs", &ValidateRequest::fields(), Vec::new()),
        Function::new("doctor", "identify.rs", &DoctorRequest::fields(), Vec::new()),
        Function::new("replay", "replay.rs", &ReplayRequest::fields(), Vec::new()),
        Function::new("Monitor.__init__", "monitor.rs", &ReplayRequest::fields(), Vec::new()),
        Function::new("calibrate", "calibrate.rs", &CalibrateRequest::fields(), Vec::new()),
        Function::new("wrench", "wrench.rs", &WrenchRequest::fields(), Vec::new()),
        Function::new("plan", "experiments.rs", &PlanRequest::fields(), vec![progress()]),
        Function::new("simulate", "experiments.rs", &SimulateRequest::fields(), of_simulate),
        Function::new("excite", "experiments.rs", &ExciteRequest::fields(), vec![after, progress()]),
        Function::new("check", "experiments.rs", &of_check, vec![proved_after]),
    ]
}

/// A default value in Python notation. An empty value is written as None.
fn literal(value: &Value) -> String {
    match value {
        Value::Bool(true) => "True".into(),
        Value::Bool(false) => "False".into(),
        Value::String(word) => format!("'{word}'"),
        Value::Number(x) => x.to_string(),
        _ => "None".into(),
    }
}

/// Divides a text into lines of limited length. All lines except the first are indented.
fn wrapped(text: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.last_mut().expect("one line");
        if last.is_empty() {
            *last = word.into();
        } else if last.len() + 1 + word.len() + 8 > WIDTH {
            lines.push(format!("  {word}"));
        } else {
            *last += &format!(" {word}");
        }
    }
    lines
}

fn paragraph(keywords: &[Keyword]) -> Vec<String> {
    let of_one = |k: &Keyword| wrapped(&format!("- {}: {}", k.name, k.doc));
    ["Options:".to_string()].into_iter().chain(keywords.iter().flat_map(of_one)).collect()
}

/// Returns the Rust source in which signature and docstring of this function are replaced, and the new docstring.
fn in_source(text: &str, function: &Function) -> Result<(String, Vec<String>), String> {
    let (class, _, rust) = function.names();
    let missing = |what: &str| format!("crates/python/src/{}: {what} of {} is missing", function.file, function.name);
    let lines: Vec<&str> = text.lines().collect();
    let starts = [format!("fn {rust}("), format!("fn {rust}<")];
    let is_start = |line: &&str| starts.iter().any(|start| line.trim().trim_start_matches("pub ").starts_with(start));
    let at = lines.iter().position(is_start).ok_or_else(|| missing("the function"))?;
    let signed = |i: &usize| lines[*i].contains("text_signature = \"(");
    let signature = (0..at).rev().take(4).find(signed).ok_or_else(|| missing("the text_signature"))?;
    let (before, _) = lines[signature].split_once("*, ").ok_or_else(|| missing("`*, ` in the text_signature"))?;
    let defaults: Vec<String> = function.keywords.iter().map(|k| format!("{}={}", k.name, k.default)).collect();
    let signed = format!("{before}*, {})\")]", defaults.join(", "));
    let is_doc = |line: &str| line.trim().starts_with("///");
    // In Python, the arguments of a constructor are documented in the docstring of its class.
    let end = match class.filter(|_| rust == "new") {
        None => (0..signature).rev().find(|&i| is_doc(lines[i])).map_or(signature, |i| i + 1),
        Some(class) => {
            let head = lines.iter().position(|line| *line == format!("pub struct {class} {{"));
            let head = head.ok_or_else(|| missing("the class"))?;
            (0..head).rev().find(|&i| is_doc(lines[i])).map_or(head, |i| i + 1)
        }
    };
    let start = (0..end).rev().find(|&i| !is_doc(lines[i])).map_or(0, |i| i + 1);
    let indent: String = lines[start].chars().take_while(|c| *c == ' ').collect();
    let said = |line: &&str| line.trim().trim_start_matches("///").strip_prefix(' ').unwrap_or("").to_string();
    let doc = with_options(lines[start..end].iter().map(said).collect(), &function.keywords);
    let written = doc.iter().map(|line| format!("{indent}/// {line}").trim_end().to_string());
    let head = lines[..start].iter().map(ToString::to_string);
    let rest = lines.iter().enumerate().skip(end).map(|(i, line)| match i == signature {
        true => signed.clone(),
        false => line.to_string(),
    });
    let all: Vec<String> = head.chain(written).chain(rest).collect();
    Ok((all.join("\n") + "\n", doc))
}

/// Returns a docstring in which the paragraph on the options is replaced, or appended if there was none.
fn with_options(doc: Vec<String>, keywords: &[Keyword]) -> Vec<String> {
    let found = paragraph(keywords);
    let Some(start) = doc.iter().position(|line| line.starts_with("Options")) else {
        return doc.into_iter().chain([String::new()]).chain(found).collect();
    };
    let length = doc[start..].iter().position(String::is_empty).unwrap_or(doc.len() - start);
    [&doc[..start], &found[..], &doc[start + length..]].concat()
}

fn in_stub(text: &str, function: &Function, doc: &[String]) -> Result<String, String> {
    let (class, python, _) = function.names();
    let missing = |what: &str| format!("{STUB}: {what} of {} is missing", function.name);
    let behind = class.map_or(Some(0), |class| text.find(&format!("class {class}:")));
    let behind = behind.ok_or_else(|| missing("the class"))?;
    let indent = if class.is_some() { "    " } else { "" };
    let head = format!("\n{indent}def {python}(");
    let start = behind + text[behind..].find(&head).ok_or_else(|| missing("the function"))? + 1;
    let (positional, _) = text[start..].split_once("*,").ok_or_else(|| missing("`*,`"))?;
    // The arguments end at the result type.
    let close = start + text[start..].find(") -> ").ok_or_else(|| missing("the result"))?;
    let colon = close + text[close..].find(":").ok_or_else(|| missing("the result"))?;
    let result = &text[close..=colon];
    let rest = &text[colon + 1..];
    let rest = match rest.strip_prefix(" ...") {
        Some(rest) => rest,
        None => rest.splitn(3, "\"\"\"").nth(2).ok_or_else(|| missing("the docstring"))?,
    };
    let (name, positional) = positional.split_once('(').ok_or_else(|| missing("`(`"))?;
    let positional = positional.split(',').map(str::trim).filter(|x| !x.is_empty()).map(String::from);
    let keywords = function.keywords.iter().map(|k| match k.default.as_str() {
        "()" => format!("{}: {} = ()", k.name, k.of_type),
        "None" if !k.of_type.ends_with("| None") => format!("{}: {} | None = None", k.name, k.of_type),
        default => format!("{}: {} = {}", k.name, k.of_type, default.replace('\'', "\"")),
    });
    let arguments: String =
        positional.chain(["*".into()]).chain(keywords).map(|x| format!("{indent}    {x},\n")).collect();
    // The docstring of a class is written as the docstring of `__init__`.
    let doc = doc.join(&format!("\n{indent}    ")).replace(&format!("\n{indent}    \n"), "\n\n");
    let head = &text[..start];
    Ok(format!("{head}{name}(\n{arguments}{indent}{result}\n{indent}    \"\"\"{doc}\"\"\"{rest}"))
}

fn tables() -> String {
    let mut text = String::new();
    for (name, fields) in requests() {
        text += &format!("\n### {name}\n\n| option | is | default | range |\n|---|---|---|---|\n");
        for field in fields {
            let default = match &field.default {
                Value::Number(x) => number(x.as_f64().unwrap_or(f64::NAN)),
                Value::String(word) => format!("`{word}`"),
                _ => String::new(),
            };
            let range = match field.range {
                Range::Any => String::new(),
                Range::Between(from, to) => format!("{} to {}", number(from), number(to)),
                Range::From(from) => format!("from {}", number(from)),
                Range::Positive => "above 0".into(),
                Range::NonZero => "not 0".into(),
                Range::Share => "above 0, at most 1".into(),
            };
            let words: Vec<String> = field.shape.words.iter().map(|(word, _)| format!("`{word}`")).collect();
            let words = if words.is_empty() { String::new() } else { format!(": {}", words.join(", ")) };
            let switch = if matches!(field.shape.flag, Flag::Switch) { " (a switch)" } else { "" };
            let doc = spelled(&field.doc, Audience::Json).replace('|', "\\|");
            text += &format!("| `{}` | {doc}{words}{switch} | {default} | {range} |\n", field.name);
        }
    }
    text + "\n"
}

/// Returns a page in which the tables between its two marks are replaced.
fn in_page(text: &str) -> Result<String, String> {
    let missing = || format!("{PAGE}: the lines `{}` and `{}` are missing", FROM.trim(), TO.trim());
    let (before, rest) = text.split_once(FROM).ok_or_else(missing)?;
    let (_, after) = rest.split_once(TO).ok_or_else(missing)?;
    Ok(format!("{before}{FROM}{}{TO}{after}", tables()))
}

fn read(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

fn sources(root: &Path) -> Result<Vec<PathBuf>, String> {
    let folder = Path::new("crates/python/src");
    let entries = std::fs::read_dir(root.join(folder)).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut found: Vec<PathBuf> = entries.filter_map(|entry| Some(folder.join(entry.ok()?.file_name()))).collect();
    found.sort();
    Ok(found)
}

fn run(is_check: bool) -> Result<(), String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut files: BTreeMap<PathBuf, String> = BTreeMap::new();
    let mut stub = read(&root.join(STUB))?;
    for function in functions() {
        let path = Path::new("crates/python/src").join(function.file);
        let text = files.get(&path).cloned().map_or_else(|| read(&root.join(&path)), Ok)?;
        let (text, doc) = in_source(&text, &function)?;
        stub = in_stub(&stub, &function, &doc)?;
        files.insert(path, text);
    }
    let mut docs = Docstrings::default();
    for source in sources(&root)? {
        docs.add(files.get(&source).unwrap_or(&read(&root.join(&source))?));
    }
    files.insert(STUB.into(), docs.in_stub(&stub));
    files.insert(PAGE.into(), in_page(&read(&root.join(PAGE))?)?);
    for (path, text) in files {
        let file = root.join(&path);
        match (read(&file)? == text, is_check) {
            (true, _) => {}
            (false, false) => std::fs::write(&file, text).map_err(|e| format!("{}: {e}", file.display()))?,
            (false, true) => {
                let path = path.display();
                return Err(format!(
                    "{path} is not what the requests say; run `cargo xtask stubs`, and look at the difference"
                ));
            }
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    register_wings();
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let is_check = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => false,
        ["--check"] => true,
        _ => {
            eprintln!("stubs takes `--check`, or nothing");
            return ExitCode::FAILURE;
        }
    };
    match run(is_check) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}
