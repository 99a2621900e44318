//! A description of a robot, read as YAML, as URDF and as .par with every option of its reader.
//!
//! Law: what was read is written as YAML, that is read again, and what is written then is the same text. Only the bound on
//! the length of an expression may refuse it.
#![no_main]

use std::path::Path;

use foreign::write_par;
use libfuzzer_sys::fuzz_target;
use rist::ModelOptions;
use rist::describe::description::parse_robot;
use robot::Robot;
use robot::format::{AngleSnapping, Mimic, read_yaml, write_urdf, write_yaml};

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let other = ModelOptions {
        mimic: Mimic::Independent,
        angles: AngleSnapping::AsGiven,
        floating_base: true,
        ..ModelOptions::default()
    };
    for path in ["robot.yaml", "robot.urdf", "robot.par"] {
        let _ = parse_robot(text, Path::new(path), &other);
        if let Ok(robot) = parse_robot(text, Path::new(path), &ModelOptions::default()) {
            written(&robot);
        }
    }
});

fn written(robot: &Robot) {
    let (text, _) = write_yaml(robot);
    let again = match read_yaml(&text, "again.yaml") {
        Ok(again) => again,
        // With blanks around its signs an expression is longer; `rist convert` says so.
        Err(e) if e.message.contains("an expression of more than") => return,
        Err(e) => panic!("what was written is not read: {e}\n{text}"),
    };
    // A value that the description left open has become one like any other.
    let generic = "   # generic: the description gave no value";
    assert_eq!(write_yaml(&again).0, text.replace(generic, ""));
    let _ = (write_urdf(robot), write_par(robot), robot::lint::lint(robot));
}
