//! Tests of .par files: their content, and the relations of passive joints that follow from loops.

use std::path::Path;

use robot::{Drive, JointKind, Robot, RotorInertia, closure, format};

fn testdata(name: &str) -> Robot {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/par").join(name);
    format::read(&path).unwrap_or_else(|e| panic!("{e}"))
}

fn read(text: &str) -> Robot {
    format::read_par(text, "t.par").unwrap_or_else(|e| panic!("{e}"))
}

/// theta or r of every link and cut as text.
fn variables(robot: &Robot) -> Vec<String> {
    let name = |k| robot.coordinate_name(k).to_string();
    let links = robot.links.iter().map(|l| (&l.joint.variable, l.joint.kind, &l.geometry));
    let cuts = robot.loops.iter().map(|l| (&l.cut.variable, l.cut.kind, &l.cut.geometry));
    let text = |(variable, kind, geometry): (&robot::Affine, JointKind, &robot::ModifiedDh)| {
        let constant = if kind == JointKind::Prismatic { &geometry.r } else { &geometry.theta };
        variable.text(constant, &robot.symbols, &name)
    };
    links.chain(cuts).map(text).collect()
}

#[test]
fn sr400_has_one_parallelogram() {
    let robot = testdata("sr400.par");
    let names: Vec<&str> = robot.coordinates.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["th1", "th2", "th4", "th5", "th6", "th7"]);
    assert!(robot.passive.is_empty());
    let found = variables(&robot);
    assert_eq!(found[2], "th7 - th2 - pi/2");
    assert_eq!(found[7], "th2 - th7");
    assert_eq!(robot.links[2].joint.drive, Drive::Passive);
    assert!(robot.symbols.iter().all(|s| s.generic));
    assert_eq!(robot.gravity_number(), [0.0, 0.0, -9.81]);
    assert!(robot.notes.iter().any(|n| n.subject == "symbols" && n.text.contains("generic")), "{:?}", robot.notes);
}

/// A passive joint may move by any multiple of its variable: the relations between the joints stay the same.
#[test]
fn a_passive_joint_may_move_by_a_multiple_of_its_variable() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/par/parallelogram4bar.par");
    let text = std::fs::read_to_string(path).unwrap();
    let found = variables(&read(&text));
    assert!(found.contains(&"-th1".to_string()), "{found:?}");
    for multiple in ["th2/2", "-th2", "3*th2"] {
        assert_eq!(variables(&read(&text.replace("th2", multiple))), found, "{multiple}");
    }
}

/// The robot RACE has three parallelograms with common links. The relations that the reader finds from its loops must equal the
/// relations in models/race.yaml.
#[test]
fn race_finds_its_passive_joints() {
    let robot = testdata("race.par");
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
    let yaml = format::read(&models.join("race.yaml")).unwrap();
    let renamed = |text: &String| {
        let text = text.replace("q1", "th1").replace("q2", "th2").replace("q3", "th8");
        let mut words: Vec<String> = text.replace("- ", "-").replace("+ ", "").split(' ').map(str::to_string).collect();
        words.sort();
        words
    };
    let found: Vec<_> = variables(&robot).iter().map(&renamed).collect();
    let given: Vec<_> = variables(&yaml).iter().map(&renamed).collect();
    assert_eq!(found, given);
    for one in &robot.loops {
        let gap = closure::largest_gap(&robot, one);
        assert!(gap.position < 1e-12 && gap.orientation < 1e-12, "{gap:?}");
    }
}

#[test]
fn old_files_are_read() {
    let robot = testdata("old_style.par");
    assert_eq!((robot.name.as_str(), robot.links.len()), ("old_style", 2));
    assert_eq!(variables(&robot), ["q1 - pi/2", "r2"]);
    assert_eq!(robot.links[0].geometry.alpha.as_multiple_of_pi(&robot.symbols), Some((1, 4)));
    assert_eq!(robot.links[1].joint.kind, JointKind::Prismatic);
    assert_eq!(robot.links[1].geometry.d.number(&robot.symbols), 0.3);
    assert_eq!(robot.gravity_number(), [0.0, 0.0, -9.81]);
    let generic: Vec<&str> = robot.symbols.iter().filter(|s| s.generic).map(|s| s.name.as_str()).collect();
    assert_eq!(generic, ["G3"]);
    // A rotor inertia of 0 means that there is none. The inertial parameters of a link are known only if all ten are known.
    let rotors: Vec<RotorInertia> = robot.links.iter().map(|l| l.joint.rotor_inertia).collect();
    assert_eq!(rotors, [RotorInertia::Absent, RotorInertia::Known(0.02)]);
    assert_eq!(robot.links[0].joint.friction.viscous, Some(0.4));
    assert!(robot.links.iter().all(|l| l.inertial.is_none()));
    let told = |subject: &str| robot.notes.iter().any(|n| n.subject == subject);
    assert!(told("link 1") && told("FX") && told("symbols"), "{:?}", robot.notes);
}

/// The loop of a general four-bar has only one affine relation, from its orientation: it gives the angle of the cut from two
/// passive joints. These two joints stay passive coordinates.
#[test]
fn a_general_four_bar_keeps_its_passive_coordinates() {
    let robot = read(
        "NL = 3\nNJ = 4\nType = 2\nant = {0, 1, 0, 3, 2}\nsigma = {0, 0, 0, 0, 2}\nmu = {1, 0, 0, 0, 0}\n\
         d = {0, L1, L2, L3, L4}\ntheta = {th1, th2, th3, th4, 0}\n",
    );
    let names: Vec<&str> = robot.passive.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["th2", "th3"]);
    assert_eq!(variables(&robot), ["th1", "th2", "th3", "th1 + th2 - th3"]);
    assert!(robot.is_implicit(&robot.loops[0]));
}

/// In YAML, the variables of passive joints may be omitted; they follow from the loops. A constant that is no integer combination
/// of symbols becomes a number.
#[test]
fn yaml_leaves_passive_joints_to_the_loops() {
    let text = "convention: khalil-kleinfinger\nname: x\nsymbols: {A: 0.3, B: 0.2, C: 0.4}\nlinks:\n\
                \x20 - {link: 1, antecedent: base, theta: q1}\n\
                \x20 - {link: 2, antecedent: 1, drive: passive, d: A, theta: q2 + pi}\n\
                \x20 - {link: 3, antecedent: base, drive: passive, d: B}\n\
                loops:\n  - cut: {antecedent: 3, d: A}\n    twin: {antecedent: 2, d: B}\n";
    let error = format::read_yaml(text, "x.yaml").unwrap_err().to_string();
    assert!(error.contains("`q2`"), "{error}");
    let robot = format::read_yaml(&text.replace(", theta: q2 + pi", ""), "x.yaml").unwrap();
    assert_eq!(variables(&robot), ["q1", "-q1", "q1", "-q1"]);
    // The side on the base is not along x. Its angle is the angle of the vector (B, C), which is no combination of symbols.
    let base = "gamma: 'atan2(C, B)', d: sqrt(B*B + C*C)";
    let twin = "gamma: 0.1, d: sqrt(B*B + C*C)";
    let askew = text.replace(", theta: q2 + pi", "").replace("passive, d: B", &format!("passive, {base}"));
    let robot = format::read_yaml(&askew.replace("2, d: B", &format!("2, {twin}")), "x.yaml").unwrap();
    let inexact = robot.notes.iter().filter(|n| n.text.contains("these lengths only")).count();
    assert!(inexact > 0 && robot.passive.is_empty(), "{:?}", robot.notes);
}

/// Reads the unchanged sample files of OpenSYMORO.
#[test]
fn the_samples_of_opensymoro_are_read() {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let folder = std::env::var_os("RIST_SHARED").map_or(shared, std::path::PathBuf::from).join("models/par");
    let Ok(files) = std::fs::read_dir(&folder) else {
        println!("skipped: ../shared is absent");
        return;
    };
    for file in files.map(|f| f.unwrap().path()) {
        let robot = format::read(&file).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(Some(robot.name.as_str()), file.file_stem().and_then(|s| s.to_str()));
        assert!(robot.passive.is_empty() && robot.n_coordinates() == 6);
    }
}

/// A frame may be placed on a loop frame. The robot is the same as if the frame were placed on the link that carries the loop
/// frame.
#[test]
fn a_frame_on_the_frame_of_a_loop_stands_on_its_link() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/robots/two_loops_on_one_frame.par");
    let text = std::fs::read_to_string(path).unwrap();
    let robot = read(&text);
    assert!(robot.passive.is_empty(), "{:?}", robot.notes);
    let twin = &robot.loops[1].twin;
    assert_eq!(twin.antecedent, robot.loops[0].twin.antecedent);
    // The frame is placed on the link of the twin, or on the cut instead of the twin. Cut and twin coincide, so the robot is the
    // same.
    let on_link = text.replace("3, 6, 11}", "3, 6, 6}").replace("L, H, 0}", "L, H, H}");
    let on_link = on_link.replace("0, 0, 0, pi/3}", "0, 0, 0, 0}").replace("th10, 0, 0}", "th10, 0, pi/3}");
    let on_cut = text.replace("3, 6, 11}", "3, 6, 9}");
    for same in [on_link, on_cut] {
        let other = read(&same);
        assert_eq!(variables(&robot), variables(&other));
        let q = [0.3, -0.2, 0.5, 0.7];
        let poses = robot.link_poses(&q);
        let (a, b) = (poses.last().unwrap(), other.link_poses(&q));
        assert!((0..3).all(|i| (a.position[i] - b.last().unwrap().position[i]).abs() < 1e-14));
        let theirs = &other.loops[1].twin;
        let (a, b) = (twin.geometry.pose(&robot.symbols, 0.0, 0.0), theirs.geometry.pose(&other.symbols, 0.0, 0.0));
        assert_eq!((twin.antecedent, a), (theirs.antecedent, b));
    }
    // A frame that cannot be placed is refused, and the message says what to do. Angles in degrees are refused, as in YAML.
    let alphas = "pi/2, 0, 0, 0, 0, 0}";
    for (from, to, wanted) in [
        ("3, 6, 11}", "3, 6, 12}", ["t.par:7:41: the antecedents of frame 12 run in a circle", ""]),
        (alphas, "pi/2, 0, 0, 0, 0.1, 0.2}", ["(* Value ", "or place frame 12 from link 6"]),
        (alphas, "90, 0, 0, 0, 0, 0}", ["is 90.0000 rad, more than a whole turn: angles of a .par are in rad", ""]),
    ] {
        let message = format::read_par(&text.replace(from, to), "t.par").unwrap_err().to_string();
        assert!(wanted.iter().all(|wanted| message.contains(wanted)), "{message}");
    }
}
