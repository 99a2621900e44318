//! Registers the wings (optional packages) of this build, and defines the error texts for missing wings.

use std::ffi::OsString;

use rist::DescriptionFormat;
use rist::wings::{DescriptionReader, DescriptionWriter, FunctionOfLink, LogFormat, LogReader, MeshFormat, Wing};

/// The error text for a feature that this build does not contain. `$found`: name of the file content that needs the feature.
macro_rules! without {
    ($found:literal, $feature:literal) => {
        concat!($found, ": ", without!($feature))
    };
    ($feature:literal) => {
        concat!(
            "this program was built without the feature `",
            $feature,
            "`; the programs and wheels of a release have it, and docs/how-to/install.md says how to build one"
        )
    };
}

/// Each wing (optional package): its name; its commands, or the flag that it adds to a command; whether this build contains the
/// wing; and the error text for a build without the wing.
const WINGS: [(&str, &[&str], bool, &str); 6] = [
    ("calibration", &["calibrate"], cfg!(feature = "calibration"), without!("calibration")),
    ("fleet", &["accumulate", "merge", "solve", "compare"], cfg!(feature = "fleet"), without!("fleet")),
    ("formulas", &["derive"], cfg!(feature = "formulas"), without!("formulas")),
    ("inspection", &["visibility"], cfg!(feature = "inspection"), without!("inspection")),
    ("packages", &["generate --as"], cfg!(feature = "packages"), without!("packages")),
    ("statics", &["postures", "wrench"], cfg!(feature = "statics"), without!("statics")),
];

/// Registers the wings. Wings must be registered before a text is printed or a file is read. The program registers them at its
/// start, and the package for Python registers them when it is loaded.
pub fn register() {
    rist::wings::register(vec![
        #[cfg(feature = "calibration")]
        ::calibration::wing(),
        #[cfg(feature = "fleet")]
        ::fleet::wing(),
        #[cfg(feature = "foreign")]
        ::foreign::wing(),
        #[cfg(feature = "formulas")]
        ::formulas::wing(),
        #[cfg(feature = "inspection")]
        ::inspection::wing(),
        #[cfg(feature = "packages")]
        ::packages::wing(),
        #[cfg(feature = "research")]
        ::research::wing(),
        #[cfg(feature = "statics")]
        ::statics::wing(),
        absent(),
    ]);
}

/// A wing whose functions return an error text if this build does not contain them.
fn absent() -> Wing {
    // Files that need a missing feature are recognised by their first bytes. The error then names the feature.
    let mut wing = Wing::default();
    let mut log = |magic: &'static [u8], what: &'static str, is_recording: bool| {
        wing.log_formats.push(LogFormat { name: "", magic, reader: LogReader::Absent { what, is_recording } });
    };
    if cfg!(not(feature = "foreign")) {
        log(b"ARROW1\0\0", without!("an Arrow or Feather file", "foreign"), false);
        log(b"\xff\xff\xff\xff", without!("an Arrow stream", "foreign"), false);
        log(b"MATLAB 5.0 MAT", without!("a .mat of version 5", "foreign"), false);
        log(b"xl/workbook.xml", without!("a workbook of Excel", "foreign"), false);
    }
    if cfg!(not(feature = "rosbag2-sqlite")) {
        let what = concat!(
            without!("a rosbag2 in sqlite3", "rosbag2-sqlite"),
            "; or convert it: `mcap convert IN.db3 OUT.mcap`"
        );
        log(b"SQLite format 3\0", what, true);
    }
    if cfg!(not(feature = "foreign")) {
        wing.mesh_formats.push(MeshFormat { extension: "dae", vertices: Err(without!("a Collada mesh", "foreign")) });
        let read = Err(without!("an SDF", "foreign"));
        wing.description_readers.push(DescriptionReader { extension: "sdf", read });
        let write = Err(without!("[to=par]", "foreign"));
        wing.writers.push(DescriptionWriter { format: DescriptionFormat::Par, write });
    }
    // Functions and steps of a missing wing fail with an error that names the feature.
    if cfg!(not(feature = "formulas")) {
        let absent = |word| FunctionOfLink {
            word,
            sentence: [""; 2],
            derive: |_, _, _| Err(without!("formulas").into()),
            has_reference: false,
        };
        wing.functions = ["jacobian-determinant", "inverse-geometry"].map(absent).into();
    }
    if cfg!(not(feature = "inspection")) {
        wing.points = Some(Err(without!("inspection")));
    }
    if cfg!(not(feature = "research")) {
        wing.in_loop = Some(Err(without!("research")));
        wing.prove_plan = Some(Err(without!("research")));
        wing.find_proof = Some(Err(without!("research")));
    }
    wing
}

/// The error text for a command line that needs a missing wing, because its command or one of its flags belongs to the wing.
/// `words`: the command line. The command is the first word that is no flag.
pub(crate) fn of_absent(words: &[OsString]) -> Option<String> {
    let command = words.iter().skip(1).filter_map(|word| word.to_str()).find(|word| !word.starts_with('-'))?;
    let is_flag = |word: &OsString, flag: &str| {
        word.to_str()
            .is_some_and(|word| word == flag || word.strip_prefix(flag).is_some_and(|rest| rest.starts_with('=')))
    };
    let is_it = |of_wing: &&&str| match of_wing.split_once(' ') {
        Some((of, flag)) => of == command && words.iter().any(|word| is_flag(word, flag)),
        None => **of_wing == command,
    };
    let absent = WINGS.iter().filter(|(_, _, is_here, _)| !is_here);
    let mut found = absent.filter_map(|(_, commands, _, said)| Some((commands.iter().find(is_it)?, said)));
    found.next().map(|(command, said)| format!("{command}: {said}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_of_wings_are_those_of_the_program() {
        let program = crate::program();
        for (wing, commands, is_here, _) in WINGS {
            for command in commands {
                let (name, flag) = command.split_once(" --").unwrap_or((command, ""));
                let found = program.find_subcommand(name);
                let has = |found: &clap::Command| found.get_arguments().any(|a| a.get_long() == Some(flag));
                assert_eq!(found.is_some_and(|found| flag.is_empty() || has(found)), is_here, "{wing}: {command}");
                let words = ["rist", "--json"].into_iter().chain(command.split(' ')).map(OsString::from);
                let words: Vec<OsString> = words.collect();
                assert_eq!(of_absent(&words).is_some(), !is_here, "{wing}: {command}");
            }
        }
    }
}
