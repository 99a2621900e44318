//! Expands the macros of a xacro file, in the order of its elements, as the Python program xacro does.
//!
//! A property is evaluated at its first use, in the scope of its definition. A macro can use all names of its caller. A block
//! (XML elements that a caller passes to a macro) is expanded before it is passed.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::element::{Child, XacroElement, read, write};
use super::expression;
use super::files::Files;
use super::parameters::{Parameter, parameters};
use super::value::{MAX_TEXT_BYTES, NameSource, XacroValue, in_si};
use crate::error::Error;
use crate::format::node::DescriptionFile;
use crate::format::shown::shown;
use crate::robot::Note;

/// Largest total size of all expanded texts, bytes.
const MAX_EXPANDED_BYTES: usize = 64 << 20;
/// Largest number of expanded elements and texts.
const MAX_EXPANDED_NODES: usize = 500_000;
/// Largest depth of nested macro calls and includes.
const MAX_CALL_DEPTH: usize = 60;
/// Largest depth of nested elements, including the elements of macros.
const MAX_ELEMENT_DEPTH: usize = 300;

/// Elements for other programs. Their content does not matter for the robot, so they may name packages that do not exist here.
const ELEMENTS_OF_OTHERS: [&str; 4] = ["gazebo", "ros2_control", "transmission", "visual"];

/// Expands a xacro text to XML, with notes. `arguments`: values for `$(arg)`. `packages`: folders for `$(find)`.
///
/// Fails, with file and line, if the text is no xacro, if it exceeds the bounds of this file, or if it needs data of the
/// computer, for example an environment variable.
pub(in crate::format) fn expanded(
    text: &str,
    file: &str,
    folder: Option<&Path>,
    arguments: &[(String, String)],
    packages: &[(String, PathBuf)],
) -> Result<(String, Vec<Note>), Error> {
    let root = read(text, file)?;
    let mut expander = Expander {
        files: Files::new(folder, packages),
        arguments: arguments.iter().cloned().collect(),
        macros: BTreeMap::new(),
        scopes: vec![Scope::default()],
        declared: BTreeSet::new(),
        work: MAX_EXPANDED_NODES,
        bytes: MAX_EXPANDED_BYTES,
        nested: 0,
        depth: 0,
        of_others: 0,
        notes: Vec::new(),
    };
    let mut out = Vec::new();
    expander.element(&root, &mut out)?;
    let mut written = String::new();
    out.iter().for_each(|child| write(child, MAX_EXPANDED_BYTES, &mut written));
    // A given argument that the description neither declares nor uses is probably misspelt. All names are known only now,
    // because a macro or an included file may declare arguments too.
    let unused = arguments.iter().find(|(name, _)| !expander.declared.contains(name));
    match unused {
        Some((name, _)) => {
            let all: Vec<String> = expander.declared.into_iter().collect();
            let has = if all.is_empty() { "none".into() } else { all.join(", ") };
            Err(DescriptionFile { file }
                .whole(format!("[arg]: the description has no argument `{}`; it has {has}", shown(name))))
        }
        None => Ok((written, expander.notes)),
    }
}

/// A macro: its parameters with defaults, and the elements that replace its calls.
#[derive(Debug)]
struct Macro {
    parameters: Vec<Parameter>,
    body: Rc<XacroElement>,
}

/// The meaning of a name in a scope.
#[derive(Clone, Debug)]
enum Meaning {
    /// A property that was not evaluated yet: its text.
    Raw(String),
    Value(XacroValue),
    Block(Vec<Child>),
    /// A property that is being evaluated. If its value is needed during the evaluation, its definition is circular.
    Open,
}

/// The meanings of the names in a scope.
type Scope = BTreeMap<String, Meaning>;

struct Expander<'a> {
    files: Files<'a>,
    arguments: BTreeMap<String, String>,
    macros: BTreeMap<String, Rc<Macro>>,
    scopes: Vec<Scope>,
    /// Names of the arguments that are declared or used in the file.
    declared: BTreeSet<String>,
    /// Number of elements and texts that may still be expanded.
    work: usize,
    /// Number of bytes of text that may still be created.
    bytes: usize,
    /// Current depth of nested elements.
    nested: usize,
    /// Current depth of nested macro calls and includes.
    depth: usize,
    /// Number of elements of other programs around the current element.
    of_others: usize,
    notes: Vec<Note>,
}

impl Expander<'_> {
    /// Counts an element or a text.
    fn spend(&mut self, element: &XacroElement) -> Result<(), Error> {
        let many =
            || format!("more than {MAX_EXPANDED_NODES} elements and texts are written out: no robot has so many");
        self.work = self.work.checked_sub(1).ok_or_else(|| element.error(many()))?;
        Ok(())
    }

    fn element(&mut self, element: &Rc<XacroElement>, out: &mut Vec<Child>) -> Result<(), Error> {
        self.spend(element)?;
        if self.nested == MAX_ELEMENT_DEPTH {
            return Err(
                element.error(format!("elements stand {MAX_ELEMENT_DEPTH} deep in each other: no robot is so deep"))
            );
        }
        self.nested += 1;
        let done = if element.is_macro { self.own(element, out) } else { self.plain(element, out) };
        self.nested -= 1;
        done
    }

    /// Expands an ordinary element, which is written to the output.
    fn plain(&mut self, element: &Rc<XacroElement>, out: &mut Vec<Child>) -> Result<(), Error> {
        let is_of_others = usize::from(ELEMENTS_OF_OTHERS.contains(&element.tag.as_str()));
        self.of_others += is_of_others;
        let mut attributes = Vec::with_capacity(element.attributes.len());
        for (name, value) in &element.attributes {
            attributes.push((name.clone(), self.text(value, element)?.text()));
        }
        let mut children = Vec::new();
        self.children(&element.children, element, &mut children)?;
        self.of_others -= is_of_others;
        out.push(Child::Element(Rc::new(XacroElement {
            tag: element.tag.clone(),
            is_macro: false,
            attributes,
            children,
            file: element.file.clone(),
            line: element.line,
        })));
        Ok(())
    }

    fn children(&mut self, children: &[Child], parent: &XacroElement, out: &mut Vec<Child>) -> Result<(), Error> {
        for child in children {
            match child {
                Child::Element(element) => self.element(element, out)?,
                Child::Text(text) => {
                    let text = self.text(text, parent)?.text();
                    out.push(Child::Text(text));
                }
            }
        }
        Ok(())
    }

    /// Executes an element of xacro itself, or calls a macro.
    fn own(&mut self, element: &Rc<XacroElement>, out: &mut Vec<Child>) -> Result<(), Error> {
        match element.tag.as_str() {
            "include" => self.include(element, out),
            "property" => self.property(element),
            "arg" => self.argument(element),
            "macro" => self.define(element),
            "if" | "unless" => {
                let value = self.text(element.needed("value")?, element)?;
                let truth = value.truth().ok_or_else(|| {
                    element.error(format!(
                        "`value` of <xacro:{}> is `{}`: true or false is expected",
                        element.tag,
                        shown(&value.text())
                    ))
                })?;
                // Content that the condition does not choose is not expanded, so it may contain names that are not defined.
                if truth == (element.tag == "if") {
                    self.children(&element.children, element, out)?;
                }
                Ok(())
            }
            "insert_block" => {
                let name = self.text(element.needed("name")?, element)?.text();
                // A scope has a block as `**name` (only the content of an element) or `*name` (the element with its content).
                let block = [format!("**{name}"), format!("*{name}")].into_iter().find_map(|name| self.block(&name));
                let block = block.ok_or_else(|| element.error(format!("there is no block `{}`", shown(&name))))?;
                self.children(&block, element, out)
            }
            "call" => {
                let name = self.text(element.needed("macro")?, element)?.text();
                self.call(&name, element, out)
            }
            // Every other element of xacro is the call of a macro with this name.
            name if self.macros.contains_key(name) => self.call(name, element, out),
            name @ ("element" | "attribute") => {
                Err(element.error(format!("<xacro:{name}> is not read: expand the file by `xacro`")))
            }
            name => Err(element.error(format!("there is no macro `{}`", shown(name)))),
        }
    }

    fn include(&mut self, element: &Rc<XacroElement>, out: &mut Vec<Child>) -> Result<(), Error> {
        if element.attribute("ns").is_some() {
            return Err(element.error("<xacro:include ns=..> is not read: expand the file by `xacro`"));
        }
        let name = self.text(element.needed("filename")?, element)?.text();
        let (text, file) = match self.files.text(&name, &element.file) {
            Err(_) if element.attribute("optional").is_some_and(|o| XacroValue::literal(o).truth() == Some(true)) => {
                return Ok(());
            }
            found => found.map_err(|e| element.error(e))?,
        };
        let root = read(&text, &file)?;
        self.deeper(element, |expander| expander.children(&root.children, &root, out))
    }

    /// Expands the content of a macro or an included file by `go`. Fails if macros and includes are nested too deep.
    fn deeper<T>(
        &mut self,
        element: &XacroElement,
        go: impl FnOnce(&mut Self) -> Result<T, Error>,
    ) -> Result<T, Error> {
        if self.depth == MAX_CALL_DEPTH {
            return Err(element.error(format!("more than {MAX_CALL_DEPTH} macros and includes stand in one another")));
        }
        self.depth += 1;
        let done = go(self);
        self.depth -= 1;
        done
    }

    fn property(&mut self, element: &Rc<XacroElement>) -> Result<(), Error> {
        let name = self.text(element.needed("name")?, element)?.text();
        let is_known = self.scopes.iter().any(|scope| scope.contains_key(&name));
        let meaning = match (element.attribute("value"), element.attribute("default")) {
            (None, Some(_)) if is_known => return Ok(()),
            (Some(raw), _) | (None, Some(raw)) => Meaning::Raw(raw.into()),
            (None, None) => Meaning::Block(element.children.clone()),
        };
        let name = if matches!(meaning, Meaning::Block(_)) { format!("**{name}") } else { name };
        let last = self.scopes.len() - 1;
        let is_lazy = element.attribute("lazy_eval").and_then(|lazy| XacroValue::literal(lazy).truth()) != Some(false);
        let (place, meaning) = match (element.attribute("scope"), meaning) {
            (None, Meaning::Raw(raw)) if !is_lazy => (last, Meaning::Value(literal(self.text(&raw, element)?))),
            (None, meaning) => (last, meaning),
            // A property that a macro defines for an outer scope (attribute `scope`) is evaluated inside the macro.
            (Some(scope), Meaning::Raw(raw)) => {
                let value = self.text(&raw, element)?;
                (if scope == "global" { 0 } else { last.saturating_sub(1) }, Meaning::Value(literal(value)))
            }
            (Some(scope), meaning) => (if scope == "global" { 0 } else { last.saturating_sub(1) }, meaning),
        };
        self.scopes[place].insert(name, meaning);
        Ok(())
    }

    fn argument(&mut self, element: &Rc<XacroElement>) -> Result<(), Error> {
        let name = self.text(element.needed("name")?, element)?.text();
        self.declared.insert(name.clone());
        if let (Some(default), false) = (element.attribute("default"), self.arguments.contains_key(&name)) {
            let value = self.text(default, element)?.text();
            self.arguments.insert(name, value);
        }
        Ok(())
    }

    fn define(&mut self, element: &Rc<XacroElement>) -> Result<(), Error> {
        let name = element.needed("name")?;
        let name = name.strip_prefix("xacro:").unwrap_or(name);
        let parameters = parameters(element.attribute("params").unwrap_or("")).map_err(|e| element.error(e))?;
        self.macros.insert(name.into(), Rc::new(Macro { parameters, body: element.clone() }));
        Ok(())
    }

    fn call(&mut self, name: &str, element: &Rc<XacroElement>, out: &mut Vec<Child>) -> Result<(), Error> {
        let called = self.macros.get(name).cloned();
        let called = called.ok_or_else(|| element.error(format!("there is no macro `{}`", shown(name))))?;
        let mut scope = Scope::default();
        // In `<xacro:call macro="..">`, the attribute `macro` is the name of the macro and not an argument.
        for (key, value) in element.attributes.iter().filter(|(key, _)| element.tag != "call" || key != "macro") {
            if !called.parameters.iter().any(|parameter| parameter.name == *key) {
                let known: Vec<&str> = called.parameters.iter().map(|p| p.name.as_str()).collect();
                return Err(element.error(format!(
                    "the macro `{name}` has no parameter `{}`; it has {}",
                    shown(key),
                    known.join(", ")
                )));
            }
            scope.insert(key.clone(), Meaning::Value(literal(self.text(value, element)?)));
        }
        // The blocks are expanded before the scope of the macro is added, so their names have the meanings of the caller.
        let mut blocks = Vec::new();
        self.children(&element.children, element, &mut blocks)?;
        let mut blocks =
            blocks.into_iter().filter_map(|child| if let Child::Element(block) = child { Some(block) } else { None });
        for parameter in &called.parameters {
            let missing = || {
                element
                    .error(format!("the macro `{name}` is called without `{}`", parameter.name.trim_start_matches('*')))
            };
            if parameter.name.starts_with('*') {
                let block = blocks.next().ok_or_else(missing)?;
                let block =
                    if parameter.name.starts_with("**") { block.children.clone() } else { vec![Child::Element(block)] };
                scope.insert(parameter.name.clone(), Meaning::Block(block));
            } else if !scope.contains_key(&parameter.name) {
                // Without an argument, a parameter `name:=^` gets the value of `name` at the caller. The default is used last.
                let forwarded = if parameter.forwards { self.known(&parameter.name, element)? } else { None };
                let value = match (forwarded, &parameter.default) {
                    (Some(value), _) => value,
                    (None, Some(default)) => literal(self.text(default, element)?),
                    (None, None) => return Err(missing()),
                };
                scope.insert(parameter.name.clone(), Meaning::Value(value));
            }
        }
        self.deeper(element, |expander| {
            expander.scopes.push(scope);
            let done = expander.children(&called.body.children, &called.body, out);
            expander.scopes.pop();
            done
        })
    }

    fn block(&self, name: &str) -> Option<Vec<Child>> {
        self.scopes.iter().rev().find_map(|scope| match scope.get(name) {
            Some(Meaning::Block(block)) => Some(block.clone()),
            _ => None,
        })
    }

    /// The value of a property or argument name; `None` if the name has no value.
    fn known(&mut self, name: &str, element: &XacroElement) -> Result<Option<XacroValue>, Error> {
        let Some(place) = (0..self.scopes.len()).rev().find(|&k| self.scopes[k].contains_key(name)) else {
            return Ok(None);
        };
        match self.scopes[place].get(name).cloned() {
            Some(Meaning::Value(value)) => Ok(Some(value)),
            Some(Meaning::Raw(raw)) => {
                self.scopes[place].insert(name.into(), Meaning::Open);
                // A property is evaluated in the scope of its definition. So the scopes inside this scope are removed during the
                // evaluation.
                let inner = self.scopes.split_off(place + 1);
                let value = self.deeper(element, |expander| expander.text(&raw, element));
                self.scopes.extend(inner);
                let value = literal(value?);
                self.scopes[place].insert(name.into(), Meaning::Value(value.clone()));
                Ok(Some(value))
            }
            Some(Meaning::Open) => Err(element.error(format!("the property `{}` stands for itself", shown(name)))),
            Some(Meaning::Block(_)) | None => Ok(None),
        }
    }

    /// Evaluates a text with `${}` and `$()` in it. A text that consists only of one `${}` keeps the type of its value.
    fn text(&mut self, text: &str, element: &XacroElement) -> Result<XacroValue, Error> {
        let made = self.evaluated(text, element)?;
        let bytes = if let XacroValue::Text(text) = &made { text.len() } else { 0 };
        self.bytes = self.bytes.checked_sub(bytes).ok_or_else(|| {
            element
                .error(format!("more than {MAX_EXPANDED_BYTES} bytes of texts are written out: no robot has so many"))
        })?;
        Ok(made)
    }

    fn evaluated(&mut self, text: &str, element: &XacroElement) -> Result<XacroValue, Error> {
        self.spend(element)?;
        let (mut parts, mut rest): (Vec<XacroValue>, &str) = (Vec::new(), text);
        while let Some(at) = rest.find('$') {
            let (before, from) = rest.split_at(at);
            if !before.is_empty() {
                parts.push(XacroValue::Text(before.into()));
            }
            let dollars = from.len() - from.trim_start_matches('$').len();
            let behind = &from[dollars..];
            let end = match behind.chars().next() {
                Some('{') => '}',
                Some('(') => ')',
                _ => {
                    parts.push(XacroValue::Text(from[..dollars].into()));
                    rest = behind;
                    continue;
                }
            };
            // Of two or more dollar signs, one is dropped, and the bracket after them is ordinary text.
            if dollars > 1 {
                parts.push(XacroValue::Text(format!("{}{}", &from[1..dollars], &behind[..1])));
                rest = &behind[1..];
                continue;
            }
            let close = behind.find(end).ok_or_else(|| element.error(format!("`{}` is not closed", shown(from))))?;
            let inner = self.text(&behind[1..close], element)?.text();
            parts.push(if end == '}' { self.expression(&inner, element)? } else { self.command(&inner, element)? });
            rest = &behind[close + 1..];
        }
        if parts.is_empty() {
            return Ok(XacroValue::Text(text.into()));
        }
        if !rest.is_empty() {
            parts.push(XacroValue::Text(rest.into()));
        }
        if parts.len() == 1 {
            return Ok(parts.remove(0));
        }
        let whole: String = parts.iter().map(XacroValue::text).collect();
        match whole.len() > MAX_TEXT_BYTES {
            true => Err(element.error(format!("a text of more than {MAX_TEXT_BYTES} bytes is none of a robot"))),
            false => Ok(XacroValue::Text(whole)),
        }
    }

    fn expression(&mut self, text: &str, element: &XacroElement) -> Result<XacroValue, Error> {
        let mut known = NameLookup { expander: self, element, is_eval: false };
        expression::value(text, &mut known).map_err(|e| element.error(format!("${{{}}}: {e}", shown(text))))
    }

    /// The value of an argument. A file may use an argument that it does not declare; then the user must give its value.
    fn argument_value(&mut self, name: &str) -> Result<XacroValue, String> {
        self.declared.insert(name.into());
        let value = self.arguments.get(name).map(|value| XacroValue::Text(value.clone()));
        value.ok_or_else(|| format!("the argument `{}` has no value: [arg={}=VALUE]", shown(name), shown(name)))
    }

    /// Evaluates `$(arg name)`, `$(eval expression)`, `$(find package)` and `$(dirname)`. Commands that need data of the host
    /// are refused.
    fn command(&mut self, text: &str, element: &XacroElement) -> Result<XacroValue, Error> {
        let (command, name) = text.trim().split_once(char::is_whitespace).unwrap_or((text.trim(), ""));
        let name = name.trim();
        match command {
            "arg" => self.argument_value(name).map_err(|e| element.error(e)),
            "eval" => {
                let mut known = NameLookup { expander: self, element, is_eval: true };
                let value = expression::value(name, &mut known);
                // As in xacro, the result is a text.
                let value = value.map(|value| XacroValue::Text(value.text()));
                value.map_err(|e| element.error(format!("$(eval {}): {e}", shown(name))))
            }
            "find" => match self.files.package(name) {
                Err(_) if self.of_others > 0 => Ok(XacroValue::Text(format!("$(find {name})"))),
                found => found.map(XacroValue::Text).map_err(|e| element.error(e)),
            },
            "dirname" => {
                let folder = Path::new(&*element.file).parent().unwrap_or(Path::new(""));
                Ok(XacroValue::Text(folder.display().to_string()))
            }
            other => Err(element.error(format!(
                "$({}) asks the machine that reads it, and is not answered here: expand the file by `xacro`",
                shown(other)
            ))),
        }
    }
}

/// Source of names and files for an expression: it looks them up in the expander.
struct NameLookup<'a, 'b> {
    expander: &'a mut Expander<'b>,
    element: &'a XacroElement,
    /// Whether the expression is of `$(eval)`, where names are arguments; otherwise they are properties.
    is_eval: bool,
}

impl NameSource for NameLookup<'_, '_> {
    fn value(&mut self, name: &str) -> Result<XacroValue, String> {
        if self.is_eval {
            let is_constant = name == "pi" && !self.expander.arguments.contains_key(name);
            return if is_constant { Ok(XacroValue::Number(PI)) } else { self.argument(name) };
        }
        let found = self.expander.known(name, self.element).map_err(|e| e.message)?;
        found.ok_or_else(|| format!("`{}` is not defined", shown(name)))
    }

    fn yaml(&mut self, file: &str) -> Result<XacroValue, String> {
        let (text, file) = self.expander.files.text(file, &self.element.file)?;
        let (node, twice) = DescriptionFile { file: &file }.parse_last_key(&in_si(&text)).map_err(|e| e.to_string())?;
        if let Some(twice) = twice {
            let note = Note { subject: file, text: format!("{twice}; the last value counts, as for PyYAML") };
            self.expander.notes.extend((!self.expander.notes.contains(&note)).then_some(note));
        }
        Ok(XacroValue::of_yaml(&node))
    }

    fn argument(&mut self, name: &str) -> Result<XacroValue, String> {
        self.expander.argument_value(name).map(literal)
    }
}

/// If the value is a text that spells a number or a boolean, converts it to this number or boolean.
fn literal(value: XacroValue) -> XacroValue {
    if let XacroValue::Text(text) = &value { XacroValue::literal(text) } else { value }
}
