//! Reads a file of any format. The extension determines the format; for standard input (`-`) the start of the text does.

use std::io;
use std::path::Path;
use std::sync::OnceLock;

use gate::source::{self, Source};

use super::mjcf::read_mjcf_with;
use super::names;
use super::par::read_par_with;
use super::urdf::read_urdf_with;
use super::xacro;
use super::xml::root_tag;
use super::yaml::read_yaml_with;
use crate::error::{Error, Place};
use crate::format::options::ReadOptions;
use crate::robot::Robot;

/// Largest file, bytes: no robot needs a larger one, and the memory of a reader is a multiple of its text.
const MAX_FILE_BYTES: u64 = 16 << 20;

/// Reads the robot described by the file at `path`; its extension determines the format (`yaml`, `yml`:
/// YAML; `urdf`, `xml`, `mjcf`: URDF or MJCF, by its first element; `xacro`: URDF with macros; `par`: SYMORO, in UTF-8 or
/// Latin-1).
///
/// Fails when the file cannot be read, is larger than 16 MiB, is not in its encoding, or does not describe
/// a robot.
pub fn read(path: &Path) -> Result<Robot, Error> {
    read_with(path, ReadOptions::default())
}

/// Reads the robot described by the file at `path` as [`read`], with options.
pub fn read_with(path: &Path, options: ReadOptions) -> Result<Robot, Error> {
    parse_with(&text_of(path)?, path, options)
}

/// Reads the robot that a text describes, as [`read_with`] reads it from the file at `path`: the extension determines the
/// format, and messages contain the name. The only opened files are files included by an MJCF, and the meshes that give the
/// masses of its bodies, below the folder of `path`.
///
/// Fails when the text is larger than 16 MiB or does not describe a robot.
pub fn parse_with(text: &str, path: &Path, options: ReadOptions) -> Result<Robot, Error> {
    let format = DescriptionFormat::of(path, text)?;
    if text.len() as u64 > MAX_FILE_BYTES {
        return Err(whole_file(&path.display().to_string(), "the text is larger than 16 MiB".into()));
    }
    format.parse(text, path, options)
}

/// The text without macros: the expanded URDF for a xacro, else the text itself.
///
/// Fails where a xacro cannot be expanded.
pub fn without_macros(text: &str, path: &Path, options: ReadOptions) -> Result<String, Error> {
    match DescriptionFormat::of(path, text)? {
        DescriptionFormat::Xacro => {
            xacro::expanded(text, &path.display().to_string(), path.parent(), options.arguments, options.packages)
        }
        _ => Ok(text.into()),
    }
}

/// The text of a description, as [`read_with`] reads it from the file at `path`.
///
/// Fails when the file cannot be read, is larger than 16 MiB, or is not in its encoding.
pub fn text_of(path: &Path) -> Result<String, Error> {
    // The format of standard input is known only after it is read.
    decoded(path, is_standard_input(path) || DescriptionFormat::of(path, "")? == DescriptionFormat::Par)
}

/// Whether a path is `-`, standard input.
fn is_standard_input(path: &Path) -> bool {
    path.as_os_str() == "-"
}

#[derive(Clone, Copy, PartialEq)]
enum DescriptionFormat {
    Yaml,
    Urdf,
    Mjcf,
    Par,
    Xacro,
}

/// The extensions of the formats that are read.
pub const READ_EXTENSIONS: &str = ".yaml, .yml, .urdf, .xacro, .xml, .mjcf or .par";

/// Formats of robots that are not read, by extension or first element, with the remedy.
const CONVERTED: [(&str, &str); 4] = [
    (
        "sdf",
        "an SDF is not read: give the URDF or MJCF that it was made from, or convert it, for instance by `sdf2urdf` of sdformat_tools",
    ),
    ("usd", "USD is not read: give the URDF or MJCF that it was made from"),
    ("usda", "USD is not read: give the URDF or MJCF that it was made from"),
    ("mjb", "a compiled model of MuJoCo: write it out as XML, mujoco.mj_saveLastXML(\"FILE.xml\", model)"),
];

impl DescriptionFormat {
    /// The format from the extension; for standard input from the start of the text: an XML tag, or the comment of a .par
    /// file. The first element distinguishes the formats of XML. Fails for other formats.
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
            "urdf" | "xml" | "mjcf" => DescriptionFormat::of_xml(text).or_else(refused),
            "par" => Ok(DescriptionFormat::Par),
            "xacro" => Ok(DescriptionFormat::Xacro),
            other => match CONVERTED.iter().find(|known| known.0 == other) {
                Some((_, remedy)) => refused(remedy.to_string()),
                None => refused(format!("a robot is described by a {READ_EXTENSIONS} file, not by `.{other}`")),
            },
        }
    }

    /// URDF or MJCF; fails where the first element belongs to another known format.
    fn of_xml(text: &str) -> Result<DescriptionFormat, String> {
        match root_tag(text) {
            "mujoco" => Ok(DescriptionFormat::Mjcf),
            "mujocoinclude" => {
                Err("a part of an MJCF, to be included: give the file with <mujoco> that includes it".into())
            }
            tag => match CONVERTED.iter().find(|known| known.0 == tag) {
                Some((_, remedy)) => Err(remedy.to_string()),
                None => Ok(DescriptionFormat::Urdf),
            },
        }
    }

    fn parse(self, text: &str, path: &Path, options: ReadOptions) -> Result<Robot, Error> {
        let file_name = path.display().to_string();
        let robot = match self {
            DescriptionFormat::Yaml => read_yaml_with(text, &file_name, options),
            DescriptionFormat::Urdf => read_urdf_with(text, &file_name, options),
            DescriptionFormat::Mjcf => {
                let folder = if is_standard_input(path) { None } else { path.parent() };
                read_mjcf_with(text, &file_name, folder, options)
            }
            DescriptionFormat::Par => read_par_with(text, &file_name, options),
            DescriptionFormat::Xacro => {
                let text = without_macros(text, path, options)?;
                read_urdf_with(&text, &format!("{file_name}, written out"), options)
            }
        };
        let robot = robot.map(names::shown)?;
        match names::too_long(&robot) {
            None => Ok(robot),
            Some(message) => Err(whole_file(&file_name, message)),
        }
    }
}

/// The text of a file in UTF-8: a description, options, an artefact.
///
/// Fails when the file cannot be read, is larger than 16 MiB (a device may have no end), or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, Error> {
    decoded(path, false)
}

/// The bytes of standard input, stored because it can be read only once and a description may be read twice.
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
        // A byte of Latin-1 is the character with this code point.
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
