//! Reads the XML elements of an MJCF and of the files that it includes, with their places in the text.
//!
//! An included file is searched first in the folder of the description, then in the folder of the file that includes it. It
//! must be inside the folder of the description or of a given package. Each file is read only once, so includes cannot repeat
//! without end.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use gate::source;

use crate::error::{Error, Place};
use crate::format::node::DescriptionFile;
use crate::format::shown::shown;
use crate::format::xml::document;

/// Largest depth of nested elements; no real robot needs more. It bounds the recursion of the functions that read elements.
const MAX_ELEMENT_DEPTH: usize = 300;
/// Largest total size of all included files, bytes.
const MAX_INCLUDED_BYTES: u64 = 16 << 20;
/// Largest number of elements of a description and its included files together.
const MAX_ELEMENTS: usize = 500_000;

/// An XML element with its attributes and children, without comments and text.
#[derive(Clone, Debug)]
pub(super) struct MjcfElement {
    pub tag: String,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<MjcfElement>,
    file: Rc<str>,
    line: usize,
    column: usize,
}

impl MjcfElement {
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|a| a.0 == name).map(|a| a.1.as_str())
    }

    pub(super) fn children<'a>(&'a self, tag: &'a str) -> impl Iterator<Item = &'a MjcfElement> {
        self.children.iter().filter(move |child| child.tag == tag)
    }

    /// Whether the last `<flag>` element with the attribute `name` sets it to `disable`.
    pub(super) fn disables(&self, name: &str) -> bool {
        let flags = self.children("option").flat_map(|option| option.children("flag"));
        flags.filter_map(|flag| flag.attribute(name)).last() == Some("disable")
    }

    pub(super) fn at(&self) -> (usize, usize) {
        (self.line, self.column)
    }

    pub(super) fn error(&self, message: impl Into<String>) -> Error {
        let place = Place { file: self.file.to_string(), line: self.line, column: self.column };
        Error { place, message: message.into() }
    }

    /// The element as text for a message: `joint `elbow``, or `<joint>` if it has no name.
    pub(super) fn called(&self) -> String {
        match self.attribute("name") {
            Some(name) => format!("{} `{}`", self.tag, shown(name)),
            None => format!("<{}>", self.tag),
        }
    }
}

/// Reads the root element of a description. Each `<include>` is replaced by the elements of its file.
///
/// `folders`: the folders in which included files may be opened.
pub(super) fn read(text: &str, file: &str, folders: Folders) -> Result<MjcfElement, Error> {
    let mut reader = MjcfReader { folders, included: Vec::new(), bytes: MAX_INCLUDED_BYTES, elements: MAX_ELEMENTS };
    let root = reader.file(text, file, folders.top, 0)?;
    if root.tag != "mujoco" {
        return Err(root.error(format!("an MJCF begins with <mujoco>, found <{}>", shown(&root.tag))));
    }
    Ok(root)
}

/// The folders in which the files that a description names may be opened.
#[derive(Clone, Copy)]
pub(in crate::format) struct Folders<'a> {
    /// The folder of the description. `None`: the text is not from a file, so it names no other file.
    pub top: Option<&'a Path>,
    /// Name and folder of each given package.
    pub packages: &'a [(String, PathBuf)],
}

/// The text of a description with the content of its included files.
///
/// Fails if a file cannot be read.
pub(in crate::format) fn without_includes(text: &str, file: &str, folders: Folders) -> Result<String, Error> {
    if !text.contains("<include") {
        return Ok(text.into());
    }
    let mut reader = MjcfReader { folders, included: Vec::new(), bytes: MAX_INCLUDED_BYTES, elements: MAX_ELEMENTS };
    reader.written_out(text, file, folders.top, 0)
}

struct MjcfReader<'a> {
    folders: Folders<'a>,
    included: Vec<PathBuf>,
    /// Number of bytes of included files that may still be read.
    bytes: u64,
    /// Number of elements that may still be read.
    elements: usize,
}

impl MjcfReader<'_> {
    fn file(&mut self, text: &str, file: &str, folder: Option<&Path>, depth: usize) -> Result<MjcfElement, Error> {
        let document = document(DescriptionFile { file }, text, "an MJCF")?;
        let mut found = Vec::new();
        self.element(document.root_element(), &Rc::from(file), folder, depth, &mut found)?;
        match found.pop() {
            Some(root) if found.is_empty() => Ok(root),
            _ => Err(DescriptionFile { file }.error(1, 0, "an <include> stands inside <mujoco>, not around it")),
        }
    }

    fn element(
        &mut self,
        node: roxmltree::Node,
        file: &Rc<str>,
        folder: Option<&Path>,
        depth: usize,
        siblings: &mut Vec<MjcfElement>,
    ) -> Result<(), Error> {
        let at = node.document().text_pos_at(node.range().start);
        let mut element = MjcfElement {
            tag: node.tag_name().name().to_string(),
            attributes: node.attributes().map(|a| (a.name().to_string(), a.value().to_string())).collect(),
            children: Vec::new(),
            file: file.clone(),
            line: at.row as usize,
            column: at.col as usize,
        };
        // This function calls itself once for each level of the file, so the depth must be bounded.
        if depth > MAX_ELEMENT_DEPTH {
            return Err(
                element.error(format!("elements stand {MAX_ELEMENT_DEPTH} deep in each other: no robot is so deep"))
            );
        }
        // The count goes over the description and all included files together.
        self.elements = self.elements.checked_sub(1).ok_or_else(|| {
            element.error(format!("more than {MAX_ELEMENTS} elements, with those of included files, are no robot"))
        })?;
        // The elements of the included file take the place of the `<include>` among its siblings.
        if element.tag == "include" {
            siblings.append(&mut self.include(&element, folder, depth)?);
            return Ok(());
        }
        for child in node.children().filter(roxmltree::Node::is_element) {
            self.element(child, file, folder, depth + 1, &mut element.children)?;
        }
        siblings.push(element);
        Ok(())
    }

    /// Reads the elements of an included file, which replace the `<include>`.
    fn include(
        &mut self,
        element: &MjcfElement,
        folder: Option<&Path>,
        depth: usize,
    ) -> Result<Vec<MjcfElement>, Error> {
        let name = element.attribute("file").unwrap_or("");
        let (text, shown_name, own) = self.opened(name, folder).map_err(|what| element.error(what))?;
        let root = self.file(&text, &shown_name, Some(&own), depth + 1)?;
        if !["mujoco", "mujocoinclude"].contains(&root.tag.as_str()) {
            return Err(
                root.error(format!("an included file begins with <mujocoinclude>, found <{}>", shown(&root.tag)))
            );
        }
        Ok(root.children)
    }

    /// The text of an included file, its name for messages, and its folder.
    fn opened(&mut self, name: &str, folder: Option<&Path>) -> Result<(String, String, PathBuf), String> {
        let fail = |what: &str| format!("<include file=\"{}\">: {what}", shown(name));
        let top = self.folders.top.ok_or_else(|| fail("what comes by standard input has no folder to include from"))?;
        let path = self.folders.find(folder.unwrap_or(top), name).map_err(|what| fail(&what))?;
        if self.included.contains(&path) {
            return Err(fail("the file is included twice, or includes itself"));
        }
        let bytes = source::read(&path, self.bytes).map_err(|e| fail(&format!("the file cannot be read: {e}")))?;
        self.bytes -= bytes.len() as u64;
        let text =
            String::from_utf8(bytes).map_err(|_| fail("the text is not UTF-8: save the file in that encoding"))?;
        let own = path.parent().map(Path::to_path_buf).unwrap_or_default();
        self.included.push(path);
        Ok((text, top.join(name).display().to_string(), own))
    }

    /// The text with the content of its included files; comments, order and spacing stay.
    fn written_out(&mut self, text: &str, file: &str, folder: Option<&Path>, depth: usize) -> Result<String, Error> {
        let source = DescriptionFile { file };
        let document = document(source, text, "an MJCF")?;
        let (mut out, mut from) = (String::new(), 0);
        for node in document.descendants().filter(|node| node.has_tag_name("include")) {
            let name = node.attribute("file").unwrap_or("");
            let line = document.text_pos_at(node.range().start).row as usize;
            let too_deep = || Err(format!("more than {MAX_ELEMENT_DEPTH} files include one another"));
            let opened = if depth > MAX_ELEMENT_DEPTH { too_deep() } else { self.opened(name, folder) };
            let (part, name, own) = opened.map_err(|what| source.error(line, 0, what))?;
            let inner = self.written_out(&part, &name, Some(&own), depth + 1)?;
            out += &text[from..node.range().start];
            out += &content(&inner, &name)?;
            from = node.range().end;
        }
        Ok(out + &text[from..])
    }
}

/// The text inside the root element.
fn content(text: &str, file: &str) -> Result<String, Error> {
    let document = document(DescriptionFile { file }, text, "an MJCF")?;
    let root = document.root_element();
    let ends = root.first_child().zip(root.last_child());
    Ok(ends.map_or(String::new(), |(first, last)| text[first.range().start..last.range().end].to_string()))
}

impl Folders<'_> {
    /// The path of a file that a description names. It is searched in the folder of the description, then in `beside`, and
    /// must be inside the folder of the description or of a package.
    pub(super) fn find(&self, beside: &Path, name: &str) -> Result<PathBuf, String> {
        let folder = |path: &Path| if path.as_os_str().is_empty() { PathBuf::from(".") } else { path.to_path_buf() };
        let top = folder(self.top.unwrap_or(Path::new("")));
        let places = [top.join(name), folder(beside).join(name)];
        let found = places.iter().find(|path| path.is_file()).or(places.iter().find(|path| path.exists()));
        let found = found.unwrap_or(&places[0]);
        if let Some(why) = source::no_file(found) {
            return Err(why);
        }
        let mut allowed = self.packages.iter().map(|(_, folder)| folder.as_path()).chain([top.as_path()]);
        match found.canonicalize() {
            Ok(full) if allowed.any(|folder| folder.canonicalize().is_ok_and(|folder| full.starts_with(folder))) => {
                Ok(full)
            }
            full => {
                let own = found.parent().unwrap_or(found).display();
                let folder =
                    full.ok().and_then(|full| Some(full.parent()?.file_name()?.to_string_lossy().into_owned()));
                // Only a relative path can be fixed by giving the folder as a package. An absolute path names a place on this
                // computer.
                let remedy = match folder.filter(|_| Path::new(name).is_relative()) {
                    Some(folder) => format!(" without leave: [package={folder}={own}]"),
                    None => ": copy it there".into(),
                };
                Err(format!("it stands outside {}, where nothing is read{remedy}", top.display()))
            }
        }
    }
}
