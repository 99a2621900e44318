//! Reads a file of any format. Its extension tells the format; for standard input (`-`) the start of the text tells it.

use std::io;
use std::path::Path;
use std::sync::OnceLock;

use gate::source::{self, Source};

use super::names;
use super::par::read_par_with;
use super::urdf::read_urdf_with;
use super::yaml::read_yaml_with;
use crate::error::{Error, Place};
use crate::format::options::ReadOptions;
use crate::robot::Robot;

/// Larger files are refused: no robot needs them, and a reader's memory is a multiple of its text.
const MAX_FILE_BYTES: u64 = 16 << 20;

/// Reads the robot described by the file at `path`; its extension tells the format (`yaml`, `yml`:
/// YAML; `urdf`, `xml`: URDF; `par`: SYMORO, in UTF-8 or Latin-1).
///
/// Fails when the file cannot be read, is larger than 16 MiB, is not in its encoding, or does not describe
/// a robot.
pub fn read(path: &Path) -> Result<Robot, Error> {
    read_with(path, ReadOptions::default())
}

/// As [`read`], with options.
pub fn read_with(path: &Path, options: ReadOptions) -> Result<Robot, Error> {
    parse_with(&text_of(path)?, path, options)
}

/// Reads the robot that a text describes, as [`read_with`] reads it from the file at `path`: the extension tells the
/// format, and the name stands in messages. No file is opened.
///
/// Fails when the text is larger than 16 MiB or does not describe a robot.
pub fn parse_with(text: &str, path: &Path, options: ReadOptions) -> Result<Robot, Error> {
    let format = DescriptionFormat::of(path, text)?;
    if text.len() as u64 > MAX_FILE_BYTES {
        return Err(whole_file(&path.display().to_string(), "the text is larger than 16 MiB".into()));
    }
    format.parse(text, path, options)
}

/// The text of a description, as [`read_with`] takes it from the file at `path`.
///
/// Fails when the file cannot be read, is larger than 16 MiB, or is not in its encoding.
pub fn text_of(path: &Path) -> Result<String, Error> {
    // The format of standard input shows only after it is read.
    decoded(path, is_standard_input(path) || DescriptionFormat::of(path, "")? == DescriptionFormat::Par)
}

/// `-` is standard input, as elsewhere.
fn is_standard_input(path: &Path) -> bool {
    path.as_os_str() == "-"
}

#[derive(Clone, Copy, PartialEq)]
enum DescriptionFormat {
    Yaml,
    Urdf,
    Par,
}

impl DescriptionFormat {
    /// The format by the extension. That of standard input is told by its start: an XML tag, or the comment of a .par
    /// file.
    fn of(path: &Path, text: &str) -> Result<DescriptionFormat, Error> {
        if is_standard_input(path) {
            let start = text.trim_start_matches('\u{feff}').trim_start();
            return Ok(match start {
                _ if start.starts_with('<') => DescriptionFormat::Urdf,
                _ if start.starts_with("(*") => DescriptionFormat::Par,
                _ => DescriptionFormat::Yaml,
            });
        }
        if path.is_dir() {
            let message = "a directory; a robot is described by a .yaml, .yml, .urdf, .xml or .par file".into();
            return Err(whole_file(&path.display().to_string(), message));
        }
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        match extension.as_str() {
            "yaml" | "yml" => Ok(DescriptionFormat::Yaml),
            "urdf" | "xml" => Ok(DescriptionFormat::Urdf),
            "par" => Ok(DescriptionFormat::Par),
            _ => {
                let message =
                    format!("a robot is described by a .yaml, .yml, .urdf, .xml or .par file, not by `.{extension}`");
                Err(whole_file(&path.display().to_string(), message))
            }
        }
    }

    fn parse(self, text: &str, path: &Path, options: ReadOptions) -> Result<Robot, Error> {
        let file_name = path.display().to_string();
        let robot = match self {
            DescriptionFormat::Yaml => read_yaml_with(text, &file_name, options),
            DescriptionFormat::Urdf => read_urdf_with(text, &file_name, options),
            DescriptionFormat::Par => read_par_with(text, &file_name, options),
        };
        let robot = robot.map(names::shown)?;
        match names::too_long(&robot) {
            None => Ok(robot),
            Some(message) => Err(whole_file(&file_name, message)),
        }
    }
}

/// The text of a file in UTF-8 that a person or a program wrote about a robot: a description, options, an artefact.
///
/// Fails when the file cannot be read, is larger than 16 MiB (a device is without end), or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, Error> {
    decoded(path, false)
}

/// The bytes of standard input, kept because it can be read only once and a description may be read twice.
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
        // A byte of Latin-1 is a character of the same number.
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
