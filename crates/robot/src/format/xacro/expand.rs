//! Writes a description with macros out, in the order of its elements, as Python's xacro does.
//!
//! A property is evaluated when it is first asked for, in the scope that it was defined in. A macro sees what its caller
//! sees. Blocks are written out before they are handed over.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::element::{Child, Element, read, write};
use super::expression;
use super::files::Files;
use super::parameters::{Parameter, parameters};
use super::value::{MAX_TEXT_BYTES, Names, Value, in_si};
use crate::error::Error;
use crate::format::node::Source;
use crate::format::shown::shown;

/// Most bytes of all texts that are made.
const MAX_BYTES: usize = 64 << 20;
/// Most elements and texts that are looked at.
const MAX_WORK: usize = 500_000;
/// Macros and includes that stand in one another.
const MAX_DEPTH: usize = 60;
/// Elements that stand in one another, those of macros counted.
const MAX_NESTED: usize = 300;

/// The text of a description written out. `arguments`: values of `$(arg)`; `packages`: folders of `$(find)`.
///
/// Fails, with file and line, on what is no xacro, on what asks the host, and on what grows beyond all robots.
pub(in crate::format) fn expanded(
    text: &str,
    file: &str,
    folder: Option<&Path>,
    arguments: &[(String, String)],
    packages: &[(String, PathBuf)],
) -> Result<String, Error> {
    let root = read(text, file)?;
    let mut expander = Expander {
        files: Files::new(folder, packages),
        arguments: arguments.iter().cloned().collect(),
        macros: BTreeMap::new(),
        scopes: vec![Scope::default()],
        declared: BTreeSet::new(),
        work: MAX_WORK,
        bytes: MAX_BYTES,
        nested: 0,
        depth: 0,
    };
    let mut out = Vec::new();
    expander.element(&root, &mut out)?;
    let mut written = String::new();
    out.iter().for_each(|child| write(child, MAX_BYTES, &mut written));
    let unused = arguments.iter().find(|(name, _)| !expander.declared.contains(name));
    match unused {
        Some((name, _)) => {
            let all: Vec<String> = expander.declared.into_iter().collect();
            let has = if all.is_empty() { "none".into() } else { all.join(", ") };
            Err(Source { file }
                .whole(format!("[arg]: the description has no argument `{}`; it has {has}", shown(name))))
        }
        None => Ok(written),
    }
}

/// A macro: its parameters with their defaults, and what it writes.
#[derive(Debug)]
struct Macro {
    parameters: Vec<Parameter>,
    body: Rc<Element>,
}

/// What a name stands for.
#[derive(Clone, Debug)]
enum Meaning {
    /// Not yet evaluated.
    Raw(String),
    Value(Value),
    Block(Vec<Child>),
    /// Being evaluated.
    Open,
}

#[derive(Default)]
struct Scope {
    names: BTreeMap<String, Meaning>,
}

struct Expander<'a> {
    files: Files<'a>,
    arguments: BTreeMap<String, String>,
    macros: BTreeMap<String, Rc<Macro>>,
    scopes: Vec<Scope>,
    /// Names of the arguments.
    declared: BTreeSet<String>,
    work: usize,
    /// Bytes of texts that may still be made.
    bytes: usize,
    /// Elements that stand in one another.
    nested: usize,
    depth: usize,
}

impl Expander<'_> {
    fn element(&mut self, element: &Rc<Element>, out: &mut Vec<Child>) -> Result<(), Error> {
        self.work = self.work.checked_sub(1).ok_or_else(|| {
            element.error(format!("more than {MAX_WORK} elements and texts are written out: no robot has so many"))
        })?;
        if self.nested == MAX_NESTED {
            return Err(element.error(format!("elements stand {MAX_NESTED} deep in each other: no robot is so deep")));
        }
        self.nested += 1;
        let done = if element.is_macro { self.own(element, out) } else { self.plain(element, out) };
        self.nested -= 1;
        done
    }

    /// An element that is written.
    fn plain(&mut self, element: &Rc<Element>, out: &mut Vec<Child>) -> Result<(), Error> {
        let mut attributes = Vec::with_capacity(element.attributes.len());
        for (name, value) in &element.attributes {
            attributes.push((name.clone(), self.text(value, element)?.text()));
        }
        let mut children = Vec::new();
        self.children(&element.children, element, &mut children)?;
        out.push(Child::Element(Rc::new(Element {
            tag: element.tag.clone(),
            is_macro: false,
            attributes,
            children,
            file: element.file.clone(),
            line: element.line,
        })));
        Ok(())
    }

    fn children(&mut self, children: &[Child], parent: &Element, out: &mut Vec<Child>) -> Result<(), Error> {
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

    /// An element of xacro itself, or the call of a macro.
    fn own(&mut self, element: &Rc<Element>, out: &mut Vec<Child>) -> Result<(), Error> {
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
                if truth == (element.tag == "if") {
                    self.children(&element.children, element, out)?;
                }
                Ok(())
            }
            "insert_block" => {
                let name = self.text(element.needed("name")?, element)?.text();
                let block = [format!("**{name}"), format!("*{name}")].into_iter().find_map(|name| self.block(&name));
                let block = block.ok_or_else(|| element.error(format!("there is no block `{}`", shown(&name))))?;
                self.children(&block, element, out)
            }
            "call" => {
                let name = self.text(element.needed("macro")?, element)?.text();
                self.call(&name, element, out)
            }
            name if self.macros.contains_key(name) => self.call(name, element, out),
            name @ ("element" | "attribute") => {
                Err(element.error(format!("<xacro:{name}> is not read: expand the file by `xacro`")))
            }
            name => Err(element.error(format!("there is no macro `{}`", shown(name)))),
        }
    }

    fn include(&mut self, element: &Rc<Element>, out: &mut Vec<Child>) -> Result<(), Error> {
        if element.attribute("ns").is_some() {
            return Err(element.error("<xacro:include ns=..> is not read: expand the file by `xacro`"));
        }
        let name = self.text(element.needed("filename")?, element)?.text();
        let (text, file) = match self.files.text(&name, &element.file) {
            Err(_) if element.attribute("optional").is_some_and(|o| Value::literal(o).truth() == Some(true)) => {
                return Ok(());
            }
            found => found.map_err(|e| element.error(e))?,
        };
        let root = read(&text, &file)?;
        self.deeper(element, |expander| expander.children(&root.children, &root, out))
    }

    /// Goes on within a macro or an included file.
    fn deeper(&mut self, element: &Element, go: impl FnOnce(&mut Self) -> Result<(), Error>) -> Result<(), Error> {
        if self.depth == MAX_DEPTH {
            return Err(element.error(format!("more than {MAX_DEPTH} macros and includes stand in one another")));
        }
        self.depth += 1;
        let done = go(self);
        self.depth -= 1;
        done
    }

    fn property(&mut self, element: &Rc<Element>) -> Result<(), Error> {
        let name = self.text(element.needed("name")?, element)?.text();
        let is_known = self.scopes.iter().any(|scope| scope.names.contains_key(&name));
        let meaning = match (element.attribute("value"), element.attribute("default")) {
            (None, Some(_)) if is_known => return Ok(()),
            (Some(raw), _) | (None, Some(raw)) => Meaning::Raw(raw.into()),
            (None, None) => Meaning::Block(element.children.clone()),
        };
        let name = if matches!(meaning, Meaning::Block(_)) { format!("**{name}") } else { name };
        let last = self.scopes.len() - 1;
        let (place, meaning) = match (element.attribute("scope"), meaning) {
            (None, meaning) => (last, meaning),
            // What goes out of a macro is evaluated within it.
            (Some(scope), Meaning::Raw(raw)) => {
                let value = self.text(&raw, element)?;
                (if scope == "global" { 0 } else { last.saturating_sub(1) }, Meaning::Value(literal(value)))
            }
            (Some(scope), meaning) => (if scope == "global" { 0 } else { last.saturating_sub(1) }, meaning),
        };
        self.scopes[place].names.insert(name, meaning);
        Ok(())
    }

    fn argument(&mut self, element: &Rc<Element>) -> Result<(), Error> {
        let name = self.text(element.needed("name")?, element)?.text();
        self.declared.insert(name.clone());
        if let (Some(default), false) = (element.attribute("default"), self.arguments.contains_key(&name)) {
            let value = self.text(default, element)?.text();
            self.arguments.insert(name, value);
        }
        Ok(())
    }

    fn define(&mut self, element: &Rc<Element>) -> Result<(), Error> {
        let name = element.needed("name")?;
        let name = name.strip_prefix("xacro:").unwrap_or(name);
        let parameters = parameters(element.attribute("params").unwrap_or("")).map_err(|e| element.error(e))?;
        self.macros.insert(name.into(), Rc::new(Macro { parameters, body: element.clone() }));
        Ok(())
    }

    fn call(&mut self, name: &str, element: &Rc<Element>, out: &mut Vec<Child>) -> Result<(), Error> {
        let called = self.macros.get(name).cloned();
        let called = called.ok_or_else(|| element.error(format!("there is no macro `{}`", shown(name))))?;
        let mut scope = Scope::default();
        for (key, value) in element.attributes.iter().filter(|(key, _)| element.tag != "call" || key != "macro") {
            if !called.parameters.iter().any(|parameter| parameter.name == *key) {
                let known: Vec<&str> = called.parameters.iter().map(|p| p.name.as_str()).collect();
                return Err(element.error(format!(
                    "the macro `{name}` has no parameter `{}`; it has {}",
                    shown(key),
                    known.join(", ")
                )));
            }
            scope.names.insert(key.clone(), Meaning::Value(literal(self.text(value, element)?)));
        }
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
                scope.names.insert(parameter.name.clone(), Meaning::Block(block));
            } else if !scope.names.contains_key(&parameter.name) {
                let forwarded = if parameter.forwards { self.known(&parameter.name, element)? } else { None };
                let value = match (forwarded, &parameter.default) {
                    (Some(value), _) => value,
                    (None, Some(default)) => literal(self.text(default, element)?),
                    (None, None) => return Err(missing()),
                };
                scope.names.insert(parameter.name.clone(), Meaning::Value(value));
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
        self.scopes.iter().rev().find_map(|scope| match scope.names.get(name) {
            Some(Meaning::Block(block)) => Some(block.clone()),
            _ => None,
        })
    }

    /// The value of a name; `None` where it has none.
    fn known(&mut self, name: &str, element: &Element) -> Result<Option<Value>, Error> {
        let Some(place) = (0..self.scopes.len()).rev().find(|&k| self.scopes[k].names.contains_key(name)) else {
            return Ok(None);
        };
        match self.scopes[place].names.get(name).cloned() {
            Some(Meaning::Value(value)) => Ok(Some(value)),
            Some(Meaning::Raw(raw)) => {
                self.scopes[place].names.insert(name.into(), Meaning::Open);
                // In the scope that it was defined in.
                let inner = self.scopes.split_off(place + 1);
                let value = self.deeper_value(element, |expander| expander.text(&raw, element));
                self.scopes.extend(inner);
                let value = literal(value?);
                self.scopes[place].names.insert(name.into(), Meaning::Value(value.clone()));
                Ok(Some(value))
            }
            Some(Meaning::Open) => Err(element.error(format!("the property `{}` stands for itself", shown(name)))),
            Some(Meaning::Block(_)) | None => Ok(None),
        }
    }

    fn deeper_value(
        &mut self,
        element: &Element,
        go: impl FnOnce(&mut Self) -> Result<Value, Error>,
    ) -> Result<Value, Error> {
        let mut found = Value::None;
        self.deeper(element, |expander| go(expander).map(|value| found = value))?;
        Ok(found)
    }

    /// A text with `${}` and `$()` in it; one that is nothing but `${}` keeps the kind of its value.
    fn text(&mut self, text: &str, element: &Element) -> Result<Value, Error> {
        let made = self.evaluated(text, element)?;
        let bytes = if let Value::Text(text) = &made { text.len() } else { 0 };
        self.bytes = self.bytes.checked_sub(bytes).ok_or_else(|| {
            element.error(format!("more than {MAX_BYTES} bytes of texts are written out: no robot has so many"))
        })?;
        Ok(made)
    }

    fn evaluated(&mut self, text: &str, element: &Element) -> Result<Value, Error> {
        self.work = self.work.checked_sub(1).ok_or_else(|| {
            element.error(format!("more than {MAX_WORK} elements and texts are written out: no robot has so many"))
        })?;
        let (mut parts, mut rest): (Vec<Value>, &str) = (Vec::new(), text);
        while let Some(at) = rest.find('$') {
            let (before, from) = rest.split_at(at);
            if !before.is_empty() {
                parts.push(Value::Text(before.into()));
            }
            let dollars = from.len() - from.trim_start_matches('$').len();
            let behind = &from[dollars..];
            let end = match behind.chars().next() {
                Some('{') => '}',
                Some('(') => ')',
                _ => {
                    parts.push(Value::Text(from[..dollars].into()));
                    rest = behind;
                    continue;
                }
            };
            // Two dollars stand for one.
            if dollars > 1 {
                parts.push(Value::Text(format!("{}{}", &from[1..dollars], &behind[..1])));
                rest = &behind[1..];
                continue;
            }
            let close = behind.find(end).ok_or_else(|| element.error(format!("`{}` is not closed", shown(from))))?;
            let inner = self.text(&behind[1..close], element)?.text();
            parts.push(if end == '}' { self.expression(&inner, element)? } else { self.command(&inner, element)? });
            rest = &behind[close + 1..];
        }
        if parts.is_empty() {
            return Ok(Value::Text(text.into()));
        }
        if !rest.is_empty() {
            parts.push(Value::Text(rest.into()));
        }
        if parts.len() == 1 {
            return Ok(parts.remove(0));
        }
        let whole: String = parts.iter().map(Value::text).collect();
        match whole.len() > MAX_TEXT_BYTES {
            true => Err(element.error(format!("a text of more than {MAX_TEXT_BYTES} bytes is none of a robot"))),
            false => Ok(Value::Text(whole)),
        }
    }

    fn expression(&mut self, text: &str, element: &Element) -> Result<Value, Error> {
        let mut known = Known { expander: self, element };
        expression::value(text, &mut known).map_err(|e| element.error(format!("${{{}}}: {e}", shown(text))))
    }

    /// `$(arg name)`, `$(find package)`; what asks the host is refused.
    fn command(&mut self, text: &str, element: &Element) -> Result<Value, Error> {
        let (command, name) = text.trim().split_once(char::is_whitespace).unwrap_or((text.trim(), ""));
        let name = name.trim();
        match command {
            "arg" => {
                // A file may use an argument that it does not declare: whoever reads it then has to give one.
                self.declared.insert(name.into());
                self.arguments.get(name).map(|value| Value::Text(value.clone())).ok_or_else(|| {
                    element.error(format!("the argument `{}` has no value: [arg={}=VALUE]", shown(name), shown(name)))
                })
            }
            "find" => self.files.package(name).map(Value::Text).map_err(|e| element.error(e)),
            "dirname" => {
                let folder = Path::new(&*element.file).parent().unwrap_or(Path::new(""));
                Ok(Value::Text(folder.display().to_string()))
            }
            other => Err(element.error(format!(
                "$({}) asks the machine that reads it, and is not answered here: expand the file by `xacro`",
                shown(other)
            ))),
        }
    }
}

/// Names as an expression asks for them.
struct Known<'a, 'b> {
    expander: &'a mut Expander<'b>,
    element: &'a Element,
}

impl Names for Known<'_, '_> {
    fn value(&mut self, name: &str) -> Result<Value, String> {
        let found = self.expander.known(name, self.element).map_err(|e| e.message)?;
        found.ok_or_else(|| format!("`{}` is not defined", shown(name)))
    }

    fn yaml(&mut self, file: &str) -> Result<Value, String> {
        let (text, file) = self.expander.files.text(file, &self.element.file)?;
        let node = Source { file: &file }.parse(&in_si(&text)).map_err(|e| e.to_string())?;
        Ok(Value::of_yaml(&node))
    }
}

/// A text that is a number or a truth, as that.
fn literal(value: Value) -> Value {
    if let Value::Text(text) = &value { Value::literal(text) } else { value }
}
