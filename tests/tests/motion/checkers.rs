//! Tests that the Python checkers in docs/checkers prove the same motions as rist, and detect each kind of defect in a file.

use std::path::{Path, PathBuf};
use std::process::Command;

use tests::program::{Run, folder, has_python, rist, rist_done, run};
use tests::workspace;

/// An arm of three joints with a mesh, a cylinder, a box and a capsule as bodies, and a prismatic mimic finger.
const ARM: &str = r#"<robot name="arm">
  <link name="post"><collision><origin xyz="0 0 0.2"/><geometry><mesh filename="post.stl" scale="0.1 0.1 0.2"/></geometry></collision></link>
  <joint name="turn" type="revolute"><parent link="post"/><child link="column"/><origin xyz="0 0 0.6"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="2" effort="100"/><dynamics damping="0.5" friction="1"/></joint>
  <link name="column"><inertial><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial>
    <collision><geometry><cylinder radius="0.06" length="0.1"/></geometry></collision></link>
  <joint name="lift" type="revolute"><parent link="column"/><child link="upper"/><origin rpy="0.1 0 0" xyz="0 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2.5" velocity="2" effort="100"/></joint>
  <link name="upper"><inertial><origin xyz="0.25 0 0"/><mass value="3"/><inertia ixx="0.005" ixy="0" ixz="0" iyy="0.07" iyz="0" izz="0.07"/></inertial>
    <collision><origin xyz="0.25 0 0"/><geometry><box size="0.5 0.06 0.08"/></geometry></collision></link>
  <joint name="bend" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.5 0.02 0"/><axis xyz="0.6 0.8 0"/>
    <limit lower="-2.9" upper="2.9" velocity="3" effort="50"/></joint>
  <link name="fore"><inertial><origin xyz="0.2 0 0"/><mass value="1.5"/><inertia ixx="0.002" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.03"/></inertial>
    <collision><origin xyz="0.25 0 0" rpy="0 1.5707963267948966 0"/><geometry><capsule radius="0.04" length="0.5"/></geometry></collision></link>
  <joint name="grip" type="prismatic"><parent link="fore"/><child link="left"/><origin xyz="0.66 0 0"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.05" velocity="0.2" effort="20"/></joint>
  <link name="left"><inertial><mass value="0.1"/><inertia ixx="0.0001" ixy="0" ixz="0" iyy="0.0001" iyz="0" izz="0.0001"/></inertial>
    <collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="tip_of_left" type="fixed"><parent link="left"/><child link="tip"/><origin xyz="0.03 0 0.01" rpy="0.3 0 0.4"/></joint>
  <link name="tip"/>
  <joint name="other" type="prismatic"><parent link="fore"/><child link="right"/><origin xyz="0.6 0.01 0.08"/><axis xyz="0 -0.8 0.6"/>
    <limit lower="0" upper="0.04" velocity="0.2" effort="20"/><mimic joint="grip" multiplier="0.8"/></joint>
  <link name="right"><inertial><mass value="0.1"/><inertia ixx="0.0001" ixy="0" ixz="0" iyy="0.0001" iyz="0" izz="0.0001"/></inertial>
    <collision><geometry><sphere radius="0.01"/></geometry></collision></link>
</robot>"#;

const LIMITS: &str = "\
all: {power: 300}
margins:
  encoder_zero: 0.002
  tracking: {turn: 0.01, grip: 0.001}
  calibration: 0.001
  mesh: 0.0005
  payload: {link: tip, mass: 0.5, centre_of_mass: [0.02, 0, 0], inertia: {xx: 0.0001, yy: 0.0001, zz: 0.0001}}
space:
  floor: 0.05
  distance: 0.03
  walls: [{point: [0.9, 0, 0], normal: [-2, 0, 0]}]
  boxes: [{low: [-1.4, -1.2, 0], high: [2, 1.2, 2], links: [fore]}]
";

fn checker(folder: &Path, name: &str, arguments: &[&str]) -> Run {
    let script = workspace().join("docs/checkers").join(name);
    run(Command::new("python3").arg(script).args(arguments).current_dir(folder).env("PYTHONDONTWRITEBYTECODE", "1"))
}

/// A cube from -1 to 1 as an STL file in text form.
fn cube() -> String {
    let corner = |k: u8| [1, 2, 4].map(|bit| if k & bit == 0 { "-1" } else { "1" }).join(" ");
    let triangle = |k: u8| {
        format!(
            "facet normal 0 0 0\nouter loop\nvertex {}\nvertex {}\nvertex {}\nendloop\nendfacet\n",
            corner(k),
            corner(k ^ 1),
            corner(k ^ 6)
        )
    };
    format!("solid cube\n{}endsolid cube\n", (0..8).map(triangle).collect::<String>())
}

fn arm() -> PathBuf {
    let folder = folder("checkers");
    std::fs::write(folder.join("arm.urdf"), ARM).unwrap();
    std::fs::write(folder.join("post.stl"), cube()).unwrap();
    std::fs::write(folder.join("limits.yaml"), LIMITS).unwrap();
    folder
}

fn excite(folder: &Path, arguments: &[&str]) {
    let short = ["--period", "6", "--repetitions", "1", "--starts", "1", "--iterations", "10"];
    rist(folder, &[&["excite"][..], arguments, &short[..]].concat()).ended(0);
}

/// Python script: 900 points on an ellipsoid and 900 inside. The checker replaces the points by fewer vertices with a radius
/// around them. The script prints the number of vertices, the radius, and how far the original points are outside the vertices,
/// at most, in 5000 directions.
const REDUCED: &str = "
import numpy as np, check_motion
random = np.random.default_rng(1)
ball = random.standard_normal((900, 3))
ball *= [0.05, 0.06, 0.2] / np.linalg.norm(ball, axis=1)[:, None]
whole = np.r_[ball, ball * random.uniform(0, 1, (900, 1))]
kept, radius = check_motion.reduced(whole, 0.0)
along = random.standard_normal((5000, 3))
along /= np.linalg.norm(along, axis=1)[:, None]
print(len(kept), radius, ((along @ whole.T).max(1) - (along @ kept.T).max(1)).max())
";

/// The convex hulls of the checker must be at most 0.1 mm larger than the mesh, as the hulls of rist are. Larger hulls would
/// reject motions that rist proves.
#[test]
fn the_checker_makes_meshes_hardly_larger() {
    if !has_python("numpy") {
        return;
    }
    let found = run(Command::new("python3").args(["-B", "-c", REDUCED]).current_dir(workspace().join("docs/checkers")));
    let figures: Vec<f64> = found.out.split_whitespace().map(|x| x.parse().unwrap()).collect();
    let [kept, radius, outside] = figures[..] else { panic!("{}{}", found.out, found.err) };
    assert!(kept < 1000.0 && radius < 1e-4 && outside <= radius, "{kept} {radius} {outside}");
}

/// A rod moves between the posts of a fork. It is inside the convex hull of the fork, so the fork must be split into convex
/// pieces.
const FORK: &str = r#"<robot name="fork">
  <link name="fork"><collision><geometry><mesh filename="fork.obj"/></geometry></collision></link>
  <joint name="out" type="prismatic"><parent link="fork"/><child link="slide"/><axis xyz="0 1 0"/>
    <limit lower="-0.05" upper="0.05" velocity="0.5" effort="100"/></joint>
  <link name="slide"><inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
    <collision><origin xyz="0.25 0.05 0.6"/><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="along" type="prismatic"><parent link="slide"/><child link="rod"/><axis xyz="1 0 0"/>
    <limit lower="-0.08" upper="0.08" velocity="0.5" effort="100"/></joint>
  <link name="rod"><inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
    <collision><origin xyz="0.25 0.05 0.2"/><geometry><box size="0.1 0.02 0.1"/></geometry></collision></link>
</robot>"#;

/// The fork as an OBJ file of three boxes: a plate with a post at each end.
fn fork() -> String {
    let boxes = [
        ([0.0, 0.0, 0.0], [0.5, 0.1, 0.06]),
        ([0.0, 0.0, 0.06], [0.06, 0.1, 0.3]),
        ([0.44, 0.0, 0.06], [0.5, 0.1, 0.3]),
    ];
    let corner = |low: [f64; 3], high: [f64; 3], k: usize| {
        let [x, y, z] = [0, 1, 2].map(|i| if k >> i & 1 == 1 { high[i] } else { low[i] });
        format!("v {x} {y} {z}\n")
    };
    let of_box = |(low, high): ([f64; 3], [f64; 3])| (0..8).map(|k| corner(low, high, k)).collect::<String>();
    let sides = "f -8 -7 -5 -6\nf -4 -3 -1 -2\nf -8 -7 -3 -4\nf -6 -5 -1 -2\nf -8 -6 -2 -4\nf -7 -5 -1 -3\n";
    boxes.map(|one| of_box(one) + sides).concat()
}

/// rist and the checker split the mesh into convex pieces in different ways, and both prove the motion. If the posts are closer
/// together, both refuse it.
#[test]
fn a_rod_in_a_fork_is_proven_by_both() {
    let folder = folder("checkers_fork");
    std::fs::write(folder.join("fork.urdf"), FORK).unwrap();
    std::fs::write(folder.join("fork.obj"), fork()).unwrap();
    let note = "fork into 3";
    excite(&folder, &["fork.urdf", "--out", "motion.yaml"]);
    let motion = std::fs::read_to_string(folder.join("motion.yaml")).unwrap();
    assert!(motion.contains("rod and fork") && motion.contains(note), "{motion}");
    rist(&folder, &["check", "fork.urdf", "motion.yaml"]).ended(0);
    let narrow = fork().replace("0.44", "0.33");
    for (mesh, code, says) in [(fork(), 0, "distance"), (narrow, 1, "BROKEN: distance of rod and fork")] {
        std::fs::write(folder.join("fork.obj"), mesh).unwrap();
        if has_python("numpy") {
            checker(&folder, "check_motion.py", &["fork.urdf", "motion.yaml"]).told(code, &[says]);
        }
    }
    rist(&folder, &["check", "fork.urdf", "motion.yaml"]).ended(1);
}

/// Puts a defect into one of the files, runs the checker, and checks its exit code and message.
fn found_out(folder: &Path, defect: &Defect, motion: &str) {
    let Defect { file, from, to, code, says } = *defect;
    let texts = [("arm.urdf", ARM), ("motion.yaml", motion), ("limits.yaml", LIMITS)];
    let place = folder.join("defect");
    std::fs::create_dir_all(&place).unwrap();
    std::fs::copy(folder.join("post.stl"), place.join("post.stl")).unwrap();
    for (name, text) in texts {
        assert!(name != file || text.contains(from), "{name} has no `{from}`");
        let text = if name == file { text.replacen(from, to, 1) } else { text.to_string() };
        std::fs::write(place.join(name), text).unwrap();
    }
    println!("{from} -> {to}");
    checker(&place, "check_motion.py", &["arm.urdf", "motion.yaml", "--limits", "limits.yaml"]).told(code, &[says]);
}

struct Defect {
    file: &'static str,
    from: &'static str,
    to: &'static str,
    code: i32,
    says: &'static str,
}

const fn defect(file: &'static str, from: &'static str, to: &'static str, code: i32, says: &'static str) -> Defect {
    Defect { file, from, to, code, says }
}

/// Texts by which the test recognises the entries of `DEFECTS` that increase a margin: for the encoder zero, for the tracking
/// error (its entry names the joint `turn` first), for the calibration, and for the mass of the payload.
const MARGINS: [&str; 4] = ["encoder_zero", "turn: ", "calibration", "mass: 0.5"];

/// Defects in the files: one of each kind, with the expected exit code and message of the checker.
const DEFECTS: [Defect; 20] = [
    defect(
        "motion.yaml",
        "coordinate: turn\n  centre: ",
        "coordinate: turn\n  centre: 5 #",
        1,
        "BROKEN: position of turn",
    ),
    defect("limits.yaml", "all: {", "all: {velocity: 0.05, ", 1, "BROKEN: velocity of "),
    defect("limits.yaml", "all: {", "all: {acceleration: 0.1, ", 1, "BROKEN: acceleration of "),
    defect("limits.yaml", "all: {", "all: {jerk: 0.1, ", 1, "BROKEN: jerk of "),
    defect("motion.yaml", "blend_s: ", "blend_s: 0.02 #", 1, "BROKEN: acceleration of "),
    defect("arm.urdf", "<mass value=\"3\"/>", "<mass value=\"300\"/>", 1, "BROKEN: effort of lift"),
    defect("arm.urdf", "friction=\"1\"", "friction=\"95\"", 1, "BROKEN: effort of turn"),
    defect("limits.yaml", "power: 300", "power: 0.5", 1, "BROKEN: power of "),
    defect("arm.urdf", "radius=\"0.04\"", "radius=\"0.4\"", 1, "BROKEN: distance of fore and "),
    defect("arm.urdf", "scale=\"0.1 0.1 0.2\"", "scale=\"0.1 0.1 0.9\"", 1, "BROKEN: distance of "),
    defect("limits.yaml", "floor: 0.05", "floor: 1.2", 1, "BROKEN: region of fore at the floor"),
    defect("limits.yaml", "point: [0.9,", "point: [-0.9,", 1, "BROKEN: region of fore at wall 1 of the limits file"),
    defect(
        "limits.yaml",
        "low: [-1.4, -1.2,",
        "low: [-1.4, 1.1,",
        1,
        "BROKEN: region of fore at the least y of box 1 of the limits file",
    ),
    defect("limits.yaml", "encoder_zero: 0.002", "encoder_zero: {lift: 1}", 1, "BROKEN: position of lift"),
    defect("limits.yaml", "turn: 0.01", "turn: 0.5, bend: 0.2", 1, "BROKEN: region of fore at "),
    defect("limits.yaml", "calibration: 0.001", "calibration: 0.2", 1, "BROKEN: distance of "),
    defect("limits.yaml", "mass: 0.5", "mass: 60", 1, "BROKEN: effort with the payload of "),
    defect("motion.yaml", "      way: ", "      way: 0.001 #", 1, "BROKEN: stopping of "),
    defect(
        "motion.yaml",
        "subject: fore and post",
        "subject: fore and pest",
        1,
        "NOT PROVEN: distance of fore and pest",
    ),
    defect(
        "motion.yaml",
        "coordinate: turn\n  centre: ",
        "coordinate: turn\n  centre: .nan #",
        2,
        "a coefficient is no number",
    ),
];

#[test]
fn a_motion_is_proven_anew_without_rist_and_each_defect_is_found() {
    if !has_python("numpy") {
        return;
    }
    let folder = arm();
    excite(&folder, &["arm.urdf", "--limits", "limits.yaml", "--out", "motion.yaml"]);
    checker(&folder, "check_motion.py", &["arm.urdf", "motion.yaml", "--limits", "limits.yaml"]).told(
        0,
        &[
            "4 position, 4 velocity, 4 acceleration, 4 jerk, ",
            "stopping takes at most ",
            "4 effort, 4 power, ",
            " distance, ",
            " region; ",
        ],
    );
    let motion = std::fs::read_to_string(folder.join("motion.yaml")).unwrap();
    DEFECTS.iter().for_each(|defect| found_out(&folder, defect, &motion));
    // If the user requires a larger value of one of the `MARGINS`, rist also finds that the motion breaks a limit.
    for Defect { file, from, to, .. } in
        DEFECTS.iter().filter(|defect| MARGINS.iter().any(|key| defect.from.contains(key)))
    {
        assert_eq!(*file, "limits.yaml");
        std::fs::write(folder.join("wide.yaml"), LIMITS.replacen(from, to, 1)).unwrap();

        rist(&folder, &["check", "arm.urdf", "motion.yaml", "--limits", "wide.yaml"]).told(1, &["BROKEN: "]);
    }
    // Margins in the motion file are used if the user gives none, or if they are larger than the margins of the user.
    std::fs::write(folder.join("none.yaml"), &LIMITS[..LIMITS.find("margins:").unwrap()]).unwrap();
    for limits in ["none.yaml", "limits.yaml"] {
        let found = rist(&folder, &["check", "arm.urdf", "motion.yaml", "--limits", limits])
            .told(0, &["calibration: 0.001 m, the proof", "payload: none to 0.5 kg on tip", "cover stopping"]);
        assert!(!found.out.contains("assumed: margins"), "{limits}: {}", found.out);
    }
    // If a row is deleted from the certificate, this pair of links counts as not checked.
    let at = motion.find("- limit: distance\n  subject: fore and post\n").unwrap();
    let next = at + 1 + motion[at + 1..].find("\n- limit: ").unwrap();
    std::fs::write(folder.join("cut.yaml"), format!("{}{}", &motion[..at], &motion[next + 1..])).unwrap();
    let found = checker(&folder, "check_motion.py", &["arm.urdf", "cut.yaml", "--limits", "limits.yaml"]).ended(0);
    let unseen = ["NOT looked at: distance of post and fore: not in the certificate", "distance of fore and post: not"];
    assert!(unseen.iter().any(|said| found.out.contains(said)), "{}", found.out);
}

#[test]
fn a_spline_and_a_description_in_yaml_are_proven_anew() {
    if !has_python("numpy") {
        return;
    }
    let folder = folder("checkers-yaml");
    let models = workspace().join("models");
    for (model, spline) in [("puma560.yaml", true), ("panda.yaml", false), ("cartpole.yaml", true)] {
        let model = models.join(model).display().to_string();
        let motion: &[&str] = if spline { &["--motion", "spline"] } else { &[] };
        excite(&folder, &[&[model.as_str(), "--out", "motion.yaml"][..], motion].concat());
        checker(&folder, "check_motion.py", &[&model, "motion.yaml"]).ended(0);
        // The motion uses its limits almost fully. So if its period is shortened from 6 s to 4.5 s, it exceeds a limit.
        let text = std::fs::read_to_string(folder.join("motion.yaml")).unwrap();
        let period = text.lines().find(|line| line.starts_with("period_s: ")).unwrap();
        std::fs::write(folder.join("quick.yaml"), text.replacen(period, "period_s: 4.5", 1)).unwrap();
        checker(&folder, "check_motion.py", &[&model, "quick.yaml"]).told(1, &["BROKEN: "]);
    }
}

#[test]
fn a_plan_is_proven_anew_without_rist_and_each_defect_is_found() {
    if !has_python("numpy") {
        return;
    }
    let folder = folder("checkers-plan");
    let model = workspace().join("models/planar2r_vertical.yaml").display().to_string();
    rist_done(&folder, &format!("plan {model} -n 6 --starts 2 --nodes 60 --configurations 8 --out plan.yaml"));
    checker(&folder, "check_plan.py", &[&model, "plan.yaml"]).ended(0);
    let text = std::fs::read_to_string(folder.join("plan.yaml")).unwrap();
    let line = |key: &str| text.lines().find(|line| line.trim_start().starts_with(key)).unwrap();
    let after = |key: &str| &text[text.find(key).unwrap()..];
    let design: Vec<&str> = after("  designs:").lines().skip(1).take_while(|line| !line.contains("tree:")).collect();
    let flat: Vec<String> = design
        .iter()
        .map(|l| if l.contains('.') { format!("{}1.0", &l[..l.rfind(' ').unwrap() + 1]) } else { l.to_string() })
        .collect();
    // The line `candidate:` of an experiment. Such lines in the proof tree are indented more.
    let candidate = text.lines().find(|line| line.starts_with("  candidate: ")).unwrap();
    let (design, flat, candidate) = (design.join("\n"), flat.join("\n"), format!("\n{candidate}"));
    let equal = "\n  equal:\n";
    for (from, to, code, says) in [
        (line("d_efficiency_at_least: "), "d_efficiency_at_least: 0.9999999", 1, "NOT proven"),
        (design.as_str(), flat.as_str(), 1, "NOT proven"),
        (candidate.as_str(), "\n  candidate: 0", 1, " is not its candidate"),
        (equal, "\n  equal:\n  - - 9\n    - 0\n", 1, "candidates 9 and 0 are not equal"),
        (line("sample_time_s: "), "sample_time_s: x", 2, "cannot be read"),
    ] {
        assert!(text.contains(from), "{from}");
        std::fs::write(folder.join("defect.yaml"), text.replacen(from, to, 1)).unwrap();
        checker(&folder, "check_plan.py", &[&model, "defect.yaml"]).told(code, &[says]);
    }
}
