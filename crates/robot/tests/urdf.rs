//! Conversion of URDF frames: every joint keeps its pose of the file, and many geometry parameters are zero.

use std::fmt::Write;

use random::SplitMix;
use robot::{JointKind, Robot, format};

fn read(body: &str) -> Robot {
    format::read_urdf(&format!("<robot name=\"t\">{body}</robot>"), "t.urdf").unwrap_or_else(|e| panic!("{e}"))
}

fn links(names: &[&str]) -> String {
    names.iter().map(|n| format!("<link name=\"{n}\"/>")).collect()
}

fn joint(name: &str, kind: &str, parent: &str, child: &str, place: [&str; 3]) -> String {
    let [xyz, rpy, axis] = place;
    format!(
        "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
         <origin xyz=\"{xyz}\" rpy=\"{rpy}\"/><axis xyz=\"{axis}\"/></joint>"
    )
}

/// gamma, b, alpha, d, theta, r of a link as numbers, rad and m.
fn geometry(robot: &Robot, j: usize) -> [f64; 6] {
    let g = &robot.links[j].geometry;
    [&g.gamma, &g.b, &g.alpha, &g.d, &g.theta, &g.r].map(|v| v.number(&robot.symbols))
}

/// Random trees with generic, parallel, opposite, intersecting and coincident axes can be read. The reader itself compares
/// each converted robot with its file, and fails if they differ.
#[test]
fn random_trees_are_reframed() {
    let mut generator = SplitMix(7);
    let mut random = |n: u32| (generator.bits() % u64::from(n)) as u32;
    let lengths = ["0 0 0", "0.3 0 0", "0 -0.2 0", "0 0 0.4", "0.1 0.2 -0.3", "0 0.25 0.1"];
    let angles = ["0 0 0", "1.5708 0 0", "0 -1.5708 0", "0.7854 0 1.5708", "0.3 -0.2 1.1", "0 3.14159 0"];
    let axes = ["0 0 1", "0 0 -1", "1 0 0", "0 1 0", "1 1 0", "0.2 -0.7 0.4"];
    let kinds = ["revolute", "revolute", "continuous", "prismatic", "fixed"];
    for _ in 0..300 {
        let n = 2 + random(8);
        let mut body = String::from("<link name=\"l0\"/>");
        for j in 1..=n {
            let parent = format!("l{}", if random(3) == 0 { random(j) } else { j - 1 });
            let place = [lengths[random(6) as usize], angles[random(6) as usize], axes[random(6) as usize]];
            let kind = if j == 1 { "revolute" } else { kinds[random(5) as usize] };
            let _ = write!(
                body,
                "<link name=\"l{j}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>"
            );
            body += &joint(&format!("j{j}"), kind, &parent, &format!("l{j}"), place);
        }
        let robot = read(&body);
        for link in &robot.links {
            let mass: f64 = link.parts.iter().map(|p| p.mass).sum();
            assert_eq!(link.inertial.unwrap()[9], mass);
        }
    }
}

#[test]
fn angles_are_snapped_and_told() {
    let body = links(&["a", "b", "c"])
        + &joint("one", "continuous", "a", "b", ["0 0 0", "1.5707 0 0", "0 0 1"])
        + &joint("two", "continuous", "b", "c", ["0.2 0 0", "1.57079632679 0 -0.7854", "0 1e-7 1"]);
    let robot = read(&body);
    let notes: Vec<String> =
        robot.notes.iter().chain(&robot.snapped).map(|n| format!("{}: {}", n.subject, n.text)).collect();
    let told = |part: &str| notes.iter().any(|n| n.contains(part));
    assert!(told("one: roll 1.5707 is taken as pi/2"), "{notes:?}");
    assert!(told("two: yaw -0.7854 is taken as -pi/4") && told("two: axis"), "{notes:?}");
    assert!(!told("two: roll"), "{notes:?}");
}

#[test]
fn parallel_and_opposite_axes() {
    let body = links(&["a", "b", "c", "d"])
        + &joint("one", "continuous", "a", "b", ["0 0 0.1", "0 0 0", "0 0 1"])
        + &joint("two", "continuous", "b", "c", ["0.3 0 0.05", "0 0 0", "0 0 -1"])
        + &joint("three", "continuous", "c", "d", ["0 0 0.2", "0 0 0", "0 0 -1"]);
    let robot = read(&body);
    let pi = std::f64::consts::PI;
    // Heights along parallel axes have no effect on the torques. So r of every link is zero, although the joints have heights in
    // the file.
    assert_eq!(geometry(&robot, 0), [0.0; 6]);
    assert_eq!(geometry(&robot, 1), [0.0, 0.0, pi, 0.3, 0.0, 0.0]);
    assert_eq!(geometry(&robot, 2), [0.0; 6]);
}

#[test]
fn the_ur5_comes_out_as_its_table() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/ur5.urdf");
    let robot = format::read(&path).unwrap();
    let right = std::f64::consts::FRAC_PI_2;
    let table = [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.089159],
        [0.0, 0.0, right, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, -0.425, 0.0, 0.0],
        [0.0, 0.0, 0.0, -0.39225, 0.0, 0.10915],
        [0.0, 0.0, right, 0.0, 0.0, 0.09465],
        [0.0, 0.0, -right, 0.0, 0.0, 0.0],
    ];
    for (j, row) in table.iter().enumerate() {
        assert_eq!(geometry(&robot, j), *row, "{j}");
    }
}

#[test]
fn fixed_links_are_lumped_and_absent_inertials_told() {
    let inertial = "<inertial><origin xyz=\"0 0.1 0\" rpy=\"0.3 0 0\"/><mass value=\"2\"/>\
                    <inertia ixx=\"0.1\" ixy=\"0.01\" ixz=\"0\" iyy=\"0.2\" iyz=\"0\" izz=\"0.25\"/></inertial>";
    let body = links(&["a", "b", "e"])
        + &format!("<link name=\"c\">{inertial}</link><link name=\"d\">{inertial}</link>")
        + &joint("one", "continuous", "a", "b", ["0 0 0", "0 0 0", "0 0 1"])
        + &joint("slide", "prismatic", "b", "c", ["0 0 0.3", "0 0 0", "1 0 0"])
        + &joint("weld", "fixed", "c", "d", ["0.5 0 0", "0 0 1.5707963", "0 0 1"])
        + &joint("tip", "fixed", "d", "e", ["0.5 0 0", "0 0 0", "0 0 1"]);
    let robot = read(&body);
    let labels: Vec<&str> = robot.links.iter().map(|l| l.label.as_str()).collect();
    assert_eq!(labels, ["one", "slide"]);
    assert_eq!((robot.links[0].inertial, robot.links[1].joint.kind), (None, JointKind::Prismatic));
    assert_eq!(robot.links[1].parts.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(), ["c", "d"]);
    // First moments about the joint frame of the file: the centres of mass of c and d are at (0, 0.1, 0) and (0.5 - 0.1, 0, 0) m.
    let link = &robot.links[1];
    let x = robot::transform_inertial(&link.inertial.unwrap(), &link.file_frame.inverse());
    for (found, wanted) in x[6..].iter().zip([0.8, 0.2, 0.0, 4.0]) {
        assert!((found - wanted).abs() < 1e-6, "{x:?}");
    }
    assert!(robot.notes.iter().any(|n| n.subject == "b" && n.text.contains("no inertial")));
    assert!(robot.notes.iter().any(|n| n.subject == "slide" && n.text.contains("no limit")));
    let name = robot::StandardParameter::all(&robot)[0].display(&robot).to_string();
    assert_eq!(name, "XX_one");
}

const GRIPPER: &str = "<joint name=\"left\" type=\"prismatic\"><parent link=\"b\"/><child link=\"c\"/>\
    <origin xyz=\"0 0 0.1\"/><axis xyz=\"0 1 0\"/><limit lower=\"0\" upper=\"0.04\" effort=\"1\" velocity=\"1\"/></joint>\
    <joint name=\"right\" type=\"prismatic\"><parent link=\"b\"/><child link=\"d\"/><mimic joint=\"left\" multiplier=\"-2\" offset=\"0.01\"/>\
    <origin xyz=\"0 0 0.1\"/><axis xyz=\"0 1 0\"/><limit lower=\"-0.05\" upper=\"0.04\" effort=\"1\" velocity=\"1\"/></joint>\
    <joint name=\"thumb\" type=\"revolute\"><parent link=\"d\"/><child link=\"e\"/><mimic joint=\"right\" multiplier=\"3\" offset=\"0.5\"/>\
    <axis xyz=\"1 0 0\"/><limit lower=\"-9\" upper=\"9\" effort=\"1\" velocity=\"1\"/></joint>";

/// q_right = 0.01 - 2 q_left and q_thumb = 0.5 + 3 q_right. The reader itself compares the converted robot with the file at
/// random positions.
#[test]
fn mimic_joints_follow() {
    let body = links(&["a", "b", "c", "d", "e"])
        + &joint("one", "continuous", "a", "b", ["0 0 0", "0 0 0", "0 0 1"])
        + GRIPPER;
    let robot = read(&body);
    let names: Vec<&str> = robot.coordinates.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["one", "left"]);
    let moves: Vec<(&str, Vec<f64>)> =
        robot.links.iter().map(|l| (l.label.as_str(), l.joint.variable.terms.iter().map(|t| t.1).collect())).collect();
    assert_eq!(moves, [("one", vec![1.0]), ("left", vec![1.0]), ("right", vec![-2.0]), ("thumb", vec![-6.0])]);
    assert!((robot.links[3].geometry.theta.number(&[]).rem_euclid(std::f64::consts::TAU) - 0.53).abs() < 1e-12);
    // The follower's limits -0.05 <= 0.01 - 2 q <= 0.04 also limit its leader q, whose own limits are 0 <= q <= 0.04.
    let (low, high) = robot.coordinates[1].limits.position.unwrap();
    assert!((low, (high - 0.03).abs() < 1e-12) == (0.0, true), "{low} {high}");

    let text = format!("<robot name=\"t\">{body}</robot>");
    let options = format::ReadOptions { mimic: format::Mimic::Independent, ..format::ReadOptions::default() };
    let robot = format::read_urdf_with(&text, "t.urdf", options).unwrap();
    assert_eq!(robot.n_coordinates(), 4);
    assert!(robot.notes.iter().any(|n| n.subject == "right" && n.text.contains("mimics")));
    let circle = text.replace(
        "<axis xyz=\"0 1 0\"/><limit lower=\"0\"",
        "<mimic joint=\"thumb\"/><axis xyz=\"0 1 0\"/><limit lower=\"0\"",
    );
    let message = format::read_urdf(&circle, "t.urdf").unwrap_err().to_string();
    assert!(message.contains("run in a circle"), "{message}");
}

#[test]
fn a_link_or_a_joint_without_a_name_is_refused() {
    let moved = |name: &str| {
        links(&["a", "b"])
            + &joint("one", "revolute", "a", "b", ["0 0 0", "0 0 0", "0 0 1"]).replace("name=\"one\"", name)
    };
    for (body, what) in [
        ("<link name=\"a\"/><link name=\" \"/>".to_string(), "`name` in <link> of link ` ` is empty"),
        ("<link/>".to_string(), "<link> of the robot has no `name`"),
        (moved(""), "<joint> of the robot has no `name`"),
        (moved("name=\"\""), "`name` in <joint> of joint `` is empty"),
    ] {
        let error = format::read_urdf(&format!("<robot name=\"t\">{body}</robot>"), "t.urdf").expect_err(&body);
        assert!(error.to_string().starts_with("t.urdf:1:") && error.to_string().ends_with(what), "{error}");
    }
}

/// An XML reader turns a line break in an attribute into a blank. The limits that are stored by the joint's name must still be
/// found.
#[test]
fn a_joint_named_with_a_line_break_keeps_its_limits() {
    let moved = "<joint name=\"j&#10;1\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/>\
                 <limit lower=\"-1\" upper=\"2\" effort=\"30\" velocity=\"4\"/></joint>";
    let robot = read(&(links(&["a", "b"]) + moved));
    assert_eq!(robot.coordinates[0].name, "j\n1");
    assert_eq!(robot.coordinates[0].limits.position, Some((-1.0, 2.0)));
    assert_eq!(robot.coordinates[0].limits.effort, Some(30.0));
    let (written, notes) = format::write_urdf(&robot);
    let again = format::read_urdf(&written, "written.urdf").unwrap();
    assert_eq!(again.coordinates[0].limits.position, Some((-1.0, 2.0)));
    assert_eq!(again.coordinates[0].name != "j\n1", notes.iter().any(|n| n.subject == "j\n1"), "{notes:?}");
}
