//! URDF texts that are unusual but accepted by other readers. The reader accepts each of them too, or reports it in a note.

use std::path::Path;

use robot::Robot;
use robot::format::{ReadOptions, parse_with};

const LINKS: &str = "<link name=\"world\"/><link name=\"trunk\"><inertial><mass value=\"3\"/><inertia ixx=\"1\" ixy=\"0\" \
                     ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link><link name=\"arm\"/>";
const ARM: &str = "<joint name=\"turn\" type=\"revolute\"><parent link=\"trunk\"/><child link=\"arm\"/><limit lower=\"-1\" \
                   upper=\"1\" effort=\"2\" velocity=\"3\"/></joint>";

fn read(joints: &str, floating_base: bool) -> Result<Robot, String> {
    let text = format!("<robot name=\"r\">\n{LINKS}\n{joints}</robot>");
    let options = ReadOptions { floating_base, ..ReadOptions::default() };
    parse_with(&text, Path::new("r.urdf"), options).map_err(|e| e.to_string())
}

fn root(kind: &str) -> String {
    format!("<joint name=\"root\" type=\"{kind}\"><parent link=\"world\"/><child link=\"trunk\"/></joint>\n{ARM}")
}

#[test]
fn a_root_that_floats_is_the_base_where_that_is_asked_for() {
    for kind in ["floating", "planar"] {
        let refused = read(&root(kind), false).map(|r| r.name).unwrap_err();
        assert!(refused.contains("[floating_base=true]"), "{refused}");
        let robot = read(&root(kind), true).unwrap();
        assert_eq!((robot.n_coordinates(), robot.base.inertial.unwrap()[9]), (1, 3.0));
        assert!(robot.notes.iter().any(|n| n.subject == "root" && n.text.contains("lets the base float")));
    }
    // A floating joint that does not carry the base is refused.
    let elsewhere = format!("{}{}", root("fixed").replace(ARM, ""), ARM.replace("revolute", "floating"));
    let refused = read(&elsewhere, true).map(|r| r.name).unwrap_err();
    assert!(refused.contains("joint `turn` is floating: only revolute"), "{refused}");
}

#[test]
fn what_stands_twice_or_is_missing_is_taken_as_others_take_it() {
    let twice = root("fixed")
        .replace("<child link=\"arm\"/>", "<child link=\"arm\"/><origin xyz=\"1 0 0\"/><origin xyz=\"2 0 0\"/>");
    let robot = read(&twice, false).unwrap();
    assert_eq!(robot.link_poses(&[0.0])[0].compose(&robot.links[0].file_frame).position, [1.0, 0.0, 0.0]);
    let notes = &robot.notes;
    assert!(notes.iter().any(|n| n.subject == "joint `turn`" && n.text.contains("again on line 4")), "{notes:?}");
    let unlimited = read(&root("fixed").replace(" velocity=\"3\"", ""), false).unwrap();
    assert_eq!(unlimited.coordinates[0].limits.velocity, None);
    assert!(unlimited.notes.iter().any(|n| n.text.contains("without a velocity")));
    assert!(read(&root("fixed"), false).unwrap().notes.iter().all(|n| !n.text.contains("without a velocity")));
}

/// A loop in a URDF extension is not read, and each such loop gets a note.
#[test]
fn loops_that_an_extension_states_are_named() {
    for (extension, name) in [
        ("<constraint name=\"close\" type=\"revolute\"><child link=\"trunk\"/></constraint>", "close"),
        ("<loop_joint name=\"close\" type=\"revolute\"><predecessor link=\"arm\"/></loop_joint>", "close"),
        ("<gazebo><joint name=\"close\" type=\"revolute\"><parent>arm</parent></joint></gazebo>", "close"),
        ("<drake:linear_bushing_rpy xmlns:drake=\"d\"/>", "<linear_bushing_rpy>"),
    ] {
        let robot = read(&format!("{}{extension}", root("fixed")), false).unwrap();
        let said: Vec<_> = robot.notes.iter().filter(|n| n.text.contains("closes a loop, which is not read")).collect();
        assert!(said.len() == 1 && said[0].subject == name, "{extension}: {:?}", robot.notes);
    }
    let gazebo = format!("{}<gazebo reference=\"arm\"><mu1>0.2</mu1></gazebo>", root("fixed"));
    assert!(read(&gazebo, false).unwrap().notes.iter().all(|n| !n.text.contains("loop")));
}

/// Refused files that are not in testdata/broken. Each error message must tell the user what to do.
#[test]
fn refusals_of_the_field_name_the_way_out() {
    let here = std::env::var_os("RIST_SHARED").map(std::path::PathBuf::from);
    let shared = here.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"));
    let folder = shared.join("findings/inputs/field");
    if !folder.is_dir() {
        return println!("NOT looked at: no folder of shared inputs");
    }
    for (name, wanted) in [
        ("doctype.urdf", "take the <!DOCTYPE> out"),
        ("num_comma.urdf", "`0,4` is not a finite number: numbers have a point"),
        ("num_commasep.urdf", "blanks between them"),
        ("num_pi.urdf", "a .xacro has expressions"),
        ("num_inf_limit.urdf", "leave out a limit that there is not"),
        ("num_inf_effort.urdf", "leave out a limit that there is not"),
        ("num_nan_mass.urdf", "is not a finite number"),
        ("mimic_self.urdf", "none of them moves by itself"),
        ("spherical.urdf", "a chain of revolute and prismatic ones"),
    ] {
        let error = robot::format::read(&folder.join(name)).expect_err(name).to_string();
        assert!(error.contains(wanted), "{error}");
    }
    for name in [
        "mimic_offset.urdf",
        "mimic_fixed.urdf",
        "axis_neg.urdf",
        "axis_nonunit.urdf",
        "continuous_limits.urdf",
        "ros2_control.urdf",
        "transmission.urdf",
        "transmission_drake.urdf",
        "dh/craig.yaml",
        "dh/standard.yaml",
    ] {
        let robot = robot::format::read(&folder.join(name)).unwrap_or_else(|e| panic!("{e}"));
        assert!((2..=3).contains(&robot.n_coordinates()), "{name}");
    }
}
