//! Reads a description file of any format. The file extension determines the format. For standard input (`-`), the start of the
//! text determines it.

use std::io;
use std::path::Path;
use std::sync::OnceLock;

use gate::source::{self, Source};

use super::description::{self, ReadDescription};
use super::mjcf::{Folders, read_mjcf_with, without_includes};
use super::names;
use super::par::read_par_with;
use super::urdf::{self, read_urdf_with};
use super::xacro;
use super::xml::root_tag;
use super::yaml::read_yaml_with;
use crate::error::{Error, Place};
use crate::format::options::ReadOptions;
use crate::robot::{Note, Robot};

/// Largest size of a file, bytes. No robot description is larger, and a reader needs several times this size as memory.
const MAX_FILE_BYTES: u64 = 16 << 20;

/// Reads a robot from the file at `path`. The extension determines the format. `yaml`, `yml`: YAML. `urdf`, `xml`, `mjcf`:
/// URDF or MJCF, by the first element. `xacro`: URDF with macros. `par`: SYMORO, in UTF-8 or Latin-1.
///
/// Fails if the file cannot be read, is larger than 16 MiB, has a wrong encoding, or does not describe a robot.
pub fn read(path: &Path) -> Result<Robot, Error> {
    read_with(path, ReadOptions::default())
}

/// Reads a robot from the file at `path` as [`read`] does, with options.
pub fn read_with(path: &Path, options: ReadOptions) -> Result<Robot, Error> {
    parse_with(&text_of(path)?, path, options)
}

/// Reads a robot from a text. The extension of `path` determines the format, and messages contain its name. Other files are
/// opened only for an MJCF (included files, and meshes for the masses of bodies) and for a xacro (included files). Such files
/// must be below the folder of `path`; the included files of a xacro may also be below the folders of given packages.
///
/// Fails if the text is larger than 16 MiB or does not describe a robot.
pub fn parse_with(text: &str, path: &Path, options: ReadOptions) -> Result<Robot, Error> {
    let format = DescriptionFormat::of(path, text)?;
    if text.len() as u64 > MAX_FILE_BYTES {
        return Err(whole_file(&path.display().to_string(), "the text is larger than 16 MiB".into()));
    }
    format.parse(text, path, options)
}

/// Expands the macros of a text: the result is the URDF for a xacro, the text with its included files for an MJCF, and the text
/// itself for other formats.
///
/// Fails if a xacro cannot be expanded, or if a file of an MJCF cannot be read.
pub fn without_macros(text: &str, path: &Path, options: ReadOptions) -> Result<String, Error> {
    match DescriptionFormat::of(path, text)? {
        DescriptionFormat::Xacro => Ok(expanded(text, path, options)?.0),
        DescriptionFormat::Mjcf => {
            let top = if is_standard_input(path) { None } else { path.parent() };
            without_includes(text, &path.display().to_string(), Folders { top, packages: options.packages })
        }
        DescriptionFormat::Urdf => Ok(urdf::repaired(text).map_or_else(|| text.into(), |(text, _)| text)),
        _ => Ok(text.into()),
    }
}

fn expanded(text: &str, path: &Path, options: ReadOptions) -> Result<(String, Vec<Note>), Error> {
    xacro::expanded(text, &path.display().to_string(), path.parent(), options.arguments, options.packages)
}

/// Reads the text of a description from the file at `path`, without interpreting it.
///
/// Fails if the file cannot be read, is larger than 16 MiB, or has a wrong encoding.
pub fn text_of(path: &Path) -> Result<String, Error> {
    // The format of standard input is unknown before the text is read, so Latin-1 is accepted.
    decoded(path, is_standard_input(path) || matches!(DescriptionFormat::of(path, "")?, DescriptionFormat::Par))
}

/// Whether the path is `-`, which means standard input.
fn is_standard_input(path: &Path) -> bool {
    path.as_os_str() == "-"
}

#[derive(Clone, Copy)]
enum DescriptionFormat {
    Yaml,
    Urdf,
    Mjcf,
    Par,
    Xacro,
    /// A format that another package reads.
    Registered(ReadDescription),
}

/// The file extensions that can be read, as text for messages.
pub const READ_EXTENSIONS: &str = ".yaml, .yml, .urdf, .xacro, .xml, .mjcf, .sdf or .par";

/// Robot formats that cannot be read, by extension or first element, each with advice for the user.
const CONVERTED: [(&str, &str); 4] = [
    ("sdf", "an SDF is not read by this program: give the URDF or MJCF that it was made from"),
    ("usd", "USD is not read: give the URDF or MJCF that it was made from"),
    ("usda", "USD is not read: give the URDF or MJCF that it was made from"),
    ("mjb", "a compiled model of MuJoCo: write it out as XML, mujoco.mj_saveLastXML(\"FILE.xml\", model)"),
];

impl DescriptionFormat {
    /// The format of a description. A file extension determines it, and for XML also the first element (URDF, MJCF or xacro).
    /// Standard input has no extension: an XML tag or the comment of a .par file at its start determines the format. Fails for
    /// other formats.
    fn of(path: &Path, text: &str) -> Result<DescriptionFormat, Error> {
        let refused = |message: String| Err(whole_file(&path.display().to_string(), message));
        if is_standard_input(path) {
            let start = text.trim_start_matches('\u{feff}').trim_start();
            return match start {
                _ if start.starts_with('<') => DescriptionFormat::of_xml(text).or_else(refused),
                _ if start.starts_with("(*") => Ok(DescriptionFormat::Par),
                _ => Ok(DescriptionFormat::Yaml),
            };
        }
        if path.is_dir() {
            return refused(format!("a directory; a robot is described by a {READ_EXTENSIONS} file"));
        }
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        match extension.as_str() {
            "yaml" | "yml" => Ok(DescriptionFormat::Yaml),
            "urdf" | "xml" | "mjcf" | "world" => DescriptionFormat::of_xml(text).or_else(refused),
            "par" => Ok(DescriptionFormat::Par),
            "xacro" => Ok(DescriptionFormat::Xacro),
            other => match DescriptionFormat::other(other) {
                Some(found) => found.or_else(refused),
                None => refused(format!("a robot is described by a {READ_EXTENSIONS} file, not by `.{other}`")),
            },
        }
    }

    /// Determines by the first element whether an XML is URDF or MJCF. Fails if the element belongs to another known format.
    fn of_xml(text: &str) -> Result<DescriptionFormat, String> {
        match root_tag(text) {
            "mujoco" => Ok(DescriptionFormat::Mjcf),
            "mujocoinclude" => {
                Err("a part of an MJCF, to be included: give the file with <mujoco> that includes it".into())
            }
            tag => DescriptionFormat::other(tag).unwrap_or(Ok(DescriptionFormat::Urdf)),
        }
    }

    /// A format that another package reads, found by its extension or first element. `Err`: a remedy, if the format is known
    /// but cannot be read. `None`: the format is not known.
    fn other(name: &str) -> Option<Result<DescriptionFormat, String>> {
        if let Some(reader) = description::reader(name) {
            return Some(reader.read.map(DescriptionFormat::Registered).map_err(str::to_string));
        }
        CONVERTED.iter().find(|known| known.0 == name).map(|(_, remedy)| Err(remedy.to_string()))
    }

    fn parse(self, text: &str, path: &Path, options: ReadOptions) -> Result<Robot, Error> {
        let file_name = path.display().to_string();
        if options.root.is_some() && !matches!(self, DescriptionFormat::Mjcf | DescriptionFormat::Registered(_)) {
            return Err(whole_file(&file_name, "[root] chooses a robot of an MJCF or an SDF".into()));
        }
        let robot = match self {
            DescriptionFormat::Yaml => read_yaml_with(text, &file_name, options),
            DescriptionFormat::Urdf => read_urdf_with(text, &file_name, options)
                .map_err(|error| with_macros_remedy(error, text, path, options)),
            DescriptionFormat::Mjcf => {
                let folder = if is_standard_input(path) { None } else { path.parent() };
                read_mjcf_with(text, &file_name, folder, options)
            }
            DescriptionFormat::Par => read_par_with(text, &file_name, options),
            DescriptionFormat::Registered(read) => read(text, &file_name, options),
            DescriptionFormat::Xacro => {
                let (text, mut notes) = expanded(text, path, options)?;
                read_urdf_with(&text, &format!("{file_name}, written out"), options).map(|mut robot| {
                    robot.notes.append(&mut notes);
                    robot
                })
            }
        };
        let robot = robot.map(names::shown)?;
        match names::too_long(&robot) {
            None => Ok(robot),
            Some(message) => Err(whole_file(&file_name, message)),
        }
    }
}

/// The error for a URDF. If the text has macros, the error also says what the user can do.
fn with_macros_remedy(error: Error, text: &str, path: &Path, options: ReadOptions) -> Error {
    if !error.message.contains(urdf::IS_A_MACRO) {
        return error;
    }
    // Standard input has no file name, so a xacro may come without its extension. The remedy is a file name with the extension
    // `.xacro`.
    let name = path.file_stem().map_or("robot".into(), |stem| stem.display().to_string());
    let remedy = match DescriptionFormat::Xacro.parse(text, path, options) {
        Ok(_) => format!("; called {name}.xacro, it is read"),
        Err(other) => format!("; called {name}.xacro, it would be refused too: {}", other.message),
    };
    Error { message: error.message + &remedy, ..error }
}

/// Reads a text file in UTF-8: a description, options or an artefact.
///
/// Fails if the file cannot be read, is larger than 16 MiB (a device may have no end), or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, Error> {
    decoded(path, false)
}

/// The bytes of standard input. They are stored, because standard input can be read only once but a description may
/// be read twice.
fn standard_input() -> io::Result<&'static [u8]> {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    if let Some(bytes) = BYTES.get() {
        return Ok(bytes);
    }
    let bytes = Source::standard_input().whole(MAX_FILE_BYTES)?;
    Ok(BYTES.get_or_init(|| bytes))
}

fn decoded(path: &Path, may_be_latin: bool) -> Result<String, Error> {
    let file_name = &path.display().to_string();
    let fail = |e: io::Error| match e.kind() {
        io::ErrorKind::NotFound => whole_file(file_name, "there is no such file".into()),
        io::ErrorKind::FileTooLarge => whole_file(file_name, "the file is larger than 16 MiB".into()),
        _ => whole_file(file_name, format!("the file cannot be read: {e}")),
    };
    let bytes = match is_standard_input(path) {
        true => standard_input().map_err(fail)?.to_vec(),
        false => source::read(path, MAX_FILE_BYTES).map_err(fail)?,
    };
    if may_be_latin && std::str::from_utf8(&bytes).is_err() {
        // In Latin-1, a byte is the code point of its character.
        return Ok(bytes.iter().map(|&b| char::from(b)).collect());
    }
    String::from_utf8(bytes).map_err(|e| {
        let line = 1 + e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count();
        let message = "the text is not UTF-8: save the file in that encoding".to_string();
        Error { place: Place { file: file_name.clone(), line, column: 0 }, message }
    })
}

fn whole_file(file: &str, message: String) -> Error {
    Error { place: Place { file: file.into(), line: 0, column: 0 }, message }
}
