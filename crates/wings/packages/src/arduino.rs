//! The package for microcontrollers: the C file in float, and a sketch for drives on a CAN bus.
//!
//! A package is a folder that runs an identified model on a robot.

use rist::Error;

use crate::names::comment;
use crate::parts::{PackageFile, PackageParts};

/// The files of the package. Fails if the functions of the robot cannot be derived.
pub(crate) fn files(parts: &PackageParts) -> Result<Vec<PackageFile>, Error> {
    // The Arduino IDE requires that the folder of a sketch has the name of the sketch.
    let (prefix, upper) = (&parts.prefix, parts.prefix.to_ascii_uppercase());
    let mut files = parts.c_files(&format!("{prefix}/"), &[])?;
    // The IDE passes no definitions to the compiler, so the header itself says float.
    let header = files.iter_mut().filter(|file| file.path.ends_with(".h"));
    header.for_each(|file| {
        file.text = file.text.replace(&format!("#define {upper}_REAL double"), &format!("#define {upper}_REAL float"));
    });
    let more = [("JOINT_LIST", comment(&parts.model.regressor().coordinates().join(", ")))];
    for (path, template) in [
        (format!("{prefix}/{prefix}.ino"), include_str!("../templates/arduino/sketch.ino")),
        ("README.md".into(), include_str!("../templates/arduino/README.md")),
    ] {
        files.push(PackageFile { path, text: parts.filled(template, &more) });
    }
    Ok(files)
}
