//! Copies the docstrings of the Python package from its Rust sources to its stub file, where editors find them.
//!
//! A stub (.pyi) declares the classes and functions of the package. The macro `artefact!` generates methods that several
//! classes have in common.

use std::collections::{BTreeMap, BTreeSet};

/// The docstrings of the methods.
#[derive(Default)]
pub struct Docstrings {
    /// The lines of each docstring, by class and method name.
    lines: BTreeMap<(String, String), Vec<String>>,
    /// Classes that also have the methods that the macro `artefact!` generates.
    artefacts: BTreeSet<String>,
}

/// The class name inside the macro `artefact!`.
const ANY_ARTEFACT: &str = "$name";

impl Docstrings {
    /// Adds the docstrings of a source: of methods in `#[pymethods]` and in `artefact!`.
    pub fn add(&mut self, source: &str) {
        let (mut class, mut doc): (Option<String>, Vec<String>) = (None, Vec::new());
        let mut lines = source.lines().peekable();
        while let Some(line) = lines.next() {
            let text = line.trim();
            if let Some(said) = text.strip_prefix("///") {
                doc.push(said.strip_prefix(' ').unwrap_or(said).into());
            } else if text == "#[pymethods]" {
                let head = lines.next().unwrap_or_default().trim();
                class = head.strip_prefix("impl ").and_then(|rest| rest.strip_suffix(" {")).map(String::from);
                doc.clear();
            } else if line == "artefact! {" {
                class = lines.next().map(|name| name.trim().trim_end_matches(',').into());
                self.artefacts.extend(class.clone());
                doc.clear();
            } else if line == "}" {
                class = None;
                doc.clear();
            } else if let (Some(class), Some(name)) = (&class, method(text)) {
                if !doc.is_empty() {
                    self.lines.insert((class.clone(), name.into()), std::mem::take(&mut doc));
                }
            } else if !text.starts_with("#[") {
                doc.clear();
            }
        }
    }

    fn of(&self, class: &str, name: &str) -> Option<&Vec<String>> {
        let of = |class: &str| self.lines.get(&(class.into(), name.into()));
        of(class).or_else(|| self.artefacts.contains(class).then(|| of(ANY_ARTEFACT))?)
    }

    /// Returns the stub in which each method has its docstring. The docstrings of overloads and of `__init__` are not changed.
    pub fn in_stub(&self, stub: &str) -> String {
        let (mut written, mut class, mut is_overload) = (String::new(), "", false);
        let mut lines = stub.lines().peekable();
        while let Some(line) = lines.next() {
            if let Some(rest) = line.strip_prefix("class ") {
                class = rest.split(['(', ':']).next().unwrap_or_default();
            } else if !line.is_empty() && !line.starts_with(' ') {
                class = "";
            }
            let name = line.strip_prefix("    def ").and_then(|rest| rest.split('(').next());
            let doc = name.filter(|name| *name != "__init__" && !is_overload).and_then(|name| self.of(class, name));
            is_overload = line == "    @overload";
            let Some(doc) = doc else {
                written += &format!("{line}\n");
                continue;
            };
            // Reads up to the end of the signature, and skips the old docstring.
            let mut head = line.to_string();
            while let Some(next) = lines.next_if(|_| !ends(&head)) {
                head += &format!("\n{next}");
            }
            let mut is_inside = lines.peek().is_some_and(|next| next.starts_with("        \"\"\""));
            while is_inside && let Some(old) = lines.next() {
                is_inside = !(old.ends_with("\"\"\"") && old.trim() != "\"\"\"");
            }
            let head = head.trim_end_matches(" ...");
            let doc = doc.join("\n        ").replace("\n        \n", "\n\n");
            written += &format!("{head}\n        \"\"\"{doc}\"\"\"\n");
        }
        written
    }
}

/// The name of the method whose definition starts on this line; `None` if none starts.
fn method(line: &str) -> Option<&str> {
    let rest = line.trim_start_matches("pub ").strip_prefix("fn ")?;
    rest.split(['(', '<']).next()
}

/// Whether the signature of a method ends with this text.
fn ends(head: &str) -> bool {
    head.contains(") -> ") && (head.ends_with(':') || head.ends_with(": ..."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_say_what_their_sources_say() {
        let mut docs = Docstrings::default();
        docs.add("/// No method.\nfn free() {}\n#[pymethods]\nimpl Arm {\n    /// One.\n    ///\n    /// Two.\n    #[getter]\n    fn name(&self) -> &str {\n        \"\"\n    }\n    fn bare(&self) {}\n}\n");
        docs.add("macro_rules! artefact {\n        #[pymethods]\n        impl $name {\n            /// Of all.\n            fn save(&self) {}\n        }\n}\nartefact! {\n    Plan,\n    /// Long.\n    fn move_it(&self, at: f64) {}\n}\n");
        let stub = "class Arm:\n    \"\"\"An arm.\"\"\"\n\n    @property\n    def name(self) -> str: ...\n    def bare(self) -> None: ...\n\nclass Plan:\n    def save(self) -> None:\n        \"\"\"Old\n        one.\"\"\"\n    def move_it(\n        self,\n        at: float,\n    ) -> None: ...\ndef free() -> None: ...\n";
        let expected = "class Arm:\n    \"\"\"An arm.\"\"\"\n\n    @property\n    def name(self) -> str:\n        \"\"\"One.\n\n        Two.\"\"\"\n    def bare(self) -> None: ...\n\nclass Plan:\n    def save(self) -> None:\n        \"\"\"Of all.\"\"\"\n    def move_it(\n        self,\n        at: float,\n    ) -> None:\n        \"\"\"Long.\"\"\"\ndef free() -> None: ...\n";
        assert_eq!(docs.in_stub(stub), expected);
        assert_eq!(docs.in_stub(expected), expected);
    }
}
