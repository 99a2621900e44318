//! Fuzz target for robot models, read as YAML, URDF and .par with every option of the reader.
//!
//! Property: a robot that was read is written as YAML; the text is read and written again without a change. The reader may refuse
//! the text only because an expression in it is too long.
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
        // The written expression has blanks around its operators, so it may be longer than the reader allows; `rist convert`
        // reports this.
        Err(e) if e.message.contains("an expression of more than") => return,
        Err(e) => panic!("what was written is not read: {e}\n{text}"),
    };
    // A value that the file lacked is written as a number with a note. When the text is read and written again, the note is gone.
    let generic = "   # generic: the description gave no value";
    assert_eq!(write_yaml(&again).0, text.replace(generic, ""));
    let _ = (write_urdf(robot), write_par(robot), robot::lint::lint(robot));
}
