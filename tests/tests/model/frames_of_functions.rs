//! Tests that functions of a link use the link frame of the description file, that several functions in one file compile, and
//! that names of a robot cannot inject code.

use modeling::{Derivation, LinkFrame, RobotFunction};
use rist::Model;
use rist::describe::evaluation::{Evaluation, ManyStates};
use robot::{Pose, Robot, format};
use tests::evaluated;
use tests::random::Random;

const ARM: &str = "<robot name='arm'><link name='base'/>
<link name='upper'/><joint name='shoulder' type='continuous'><parent link='base'/><child link='upper'/>
<origin xyz='0.1 0.2 0.3' rpy='0.4 0 0.2'/><axis xyz='0 1 0'/></joint>
<link name='fore-arm'/><joint name='elbow' type='continuous'><parent link='upper'/><child link='fore-arm'/>
<origin xyz='0.5 -0.1 0.2' rpy='0 0.7 0.1'/><axis xyz='0.6 0 0.8'/></joint>
<link name='flange'/><joint name='mount' type='fixed'><parent link='fore-arm'/><child link='flange'/>
<origin xyz='0.3 0.1 -0.2' rpy='0.5 -0.2 0.9'/></joint></robot>";

fn arm() -> Robot {
    format::read_urdf(ARM, "arm.urdf").unwrap_or_else(|e| panic!("{e}"))
}

/// Pose of a frame of `ARM`, computed from the origins and axes of the URDF: Rz(yaw) Ry(pitch) Rx(roll), then the rotation by q.
fn file_pose(q: &[f64], frame: &str) -> Pose {
    let rpy = |r: [f64; 3]| {
        let about = |axis: usize, angle: f64| {
            let (s, c) = angle.sin_cos();
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut m = [[0.0; 3]; 3];
            (m[axis][axis], m[i][i], m[j][j], m[i][j], m[j][i]) = (1.0, c, c, -s, s);
            Pose { rotation: m, position: [0.0; 3] }
        };
        about(2, r[2]).compose(&about(1, r[1])).compose(&about(0, r[0]))
    };
    let at = |position: [f64; 3], angles: [f64; 3]| Pose { position, ..rpy(angles) };
    // Rotation about axis `a` by the formula of Rodrigues.
    let turned = |a: [f64; 3], angle: f64| {
        let (s, c) = angle.sin_cos();
        let across = [[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]];
        let entry = |i: usize, j: usize| (if i == j { c } else { 0.0 }) + (1.0 - c) * a[i] * a[j] + s * across[i][j];
        Pose { rotation: [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j))), position: [0.0; 3] }
    };
    let upper = at([0.1, 0.2, 0.3], [0.4, 0.0, 0.2]).compose(&turned([0.0, 1.0, 0.0], q[1]));
    let fore_arm = upper.compose(&at([0.5, -0.1, 0.2], [0.0, 0.7, 0.1])).compose(&turned([0.6, 0.0, 0.8], q[0]));
    match frame {
        "upper" => upper,
        "fore-arm" => fore_arm,
        _ => fore_arm.compose(&at([0.3, 0.1, -0.2], [0.5, -0.2, 0.9])),
    }
}

#[test]
fn frames_of_a_urdf_are_the_files() {
    let robot = arm();
    assert_eq!(LinkFrame::names(&robot), ["upper", "fore-arm", "flange"]);
    let of = |name: &str| robot.coordinates.iter().position(|c| c.name == name).unwrap();
    let (shoulder, elbow) = (of("shoulder"), of("elbow"));
    let mut derivation = Derivation::new(&robot).unwrap();
    let mut random = Random(5);
    for name in ["upper", "fore-arm", "flange", "elbow"] {
        let frame = LinkFrame::named(&robot, name).unwrap();
        let (pose, jacobian) = (derivation.pose(frame.clone()), derivation.jacobian(frame.clone()));
        let external = derivation.external_torque(frame);
        for _ in 0..5 {
            let q = [random.unit(), random.unit()];
            let seen = |q: &[f64]| file_pose(&[q[elbow], q[shoulder]], if name == "elbow" { "fore-arm" } else { name });
            let (t, wanted) = (evaluated(&pose, &[&q]), seen(&q));
            for r in 0..3 {
                for c in 0..4 {
                    let entry = if c < 3 { wanted.rotation[r][c] } else { wanted.position[r] };
                    // Rounding of a chain of about ten rotations.
                    assert!((t[4 * r + c] - entry).abs() < 1e-13, "{name} {r} {c}: {} {entry}", t[4 * r + c]);
                }
            }
            let j = evaluated(&jacobian, &[&q]);
            // Central differences: truncation h^2 and rounding 1e-16 / h.
            let h = 1e-5;
            for k in 0..2 {
                let moved = |step: f64| {
                    let mut q = q;
                    q[k] += step;
                    seen(&q)
                };
                let (a, b) = (moved(-h), moved(h));
                let rate: [f64; 3] = std::array::from_fn(|i| (b.position[i] - a.position[i]) / (2.0 * h));
                for axis in 0..3 {
                    let in_frame: f64 = (0..3).map(|i| wanted.rotation[i][axis] * rate[i]).sum();
                    assert!((j[2 * axis + k] - in_frame).abs() < 1e-8, "{name}: {} {in_frame}", j[2 * axis + k]);
                }
                // R^T dR/dq is the skew-symmetric matrix of the angular velocity in the frame.
                let spin = |i: usize, c: usize| -> f64 {
                    let rate = |r: usize| (b.rotation[r][c] - a.rotation[r][c]) / (2.0 * h);
                    (0..3).map(|r| wanted.rotation[r][i] * rate(r)).sum()
                };
                for (axis, found) in [spin(2, 1), spin(0, 2), spin(1, 0)].into_iter().enumerate() {
                    assert!((j[2 * (3 + axis) + k] - found).abs() < 1e-8, "{name}: spin {axis}");
                }
            }
            let wrench: [f64; 6] = std::array::from_fn(|_| random.unit());
            let tau = evaluated(&external, &[&q, &wrench]);
            for k in 0..2 {
                let wanted: f64 = (0..6).map(|r| j[2 * r + k] * wrench[r]).sum();
                assert!((tau[k] - wanted).abs() < 1e-14);
            }
        }
    }
}

fn written(robot: &Robot, functions: &[RobotFunction]) -> String {
    codegen::rust_file(&modeling::module(robot, functions).unwrap_or_else(|e| panic!("{e}")), "a test")
}

#[test]
fn functions_carry_their_link_and_stand_once() {
    let robot = arm();
    let frame = |name: &str| LinkFrame::named(&robot, name).unwrap();
    let pose = |name: &str| RobotFunction::of_link("pose").unwrap()(frame(name));
    let jacobian = RobotFunction::of_link("jacobian").unwrap()(frame("fore-arm"));
    let gravity = RobotFunction::of_robot("gravity").unwrap();
    let asked = [pose("upper"), pose("flange"), pose("flange"), jacobian, gravity.clone(), gravity];
    let text = written(&robot, &asked);
    for function in ["pose_upper", "pose_flange", "jacobian_fore_arm", "gravity"] {
        assert_eq!(text.matches(&format!("pub fn {function}<")).count(), 1, "{function}");
    }
    assert!(text.contains("the frame is that of the robot's file"));
    assert_eq!(LinkFrame::named(&robot, "hand"), None);
    let khalil = tests::model("rx90.yaml");
    let third = LinkFrame::named(&khalil, "3").unwrap();
    assert!(written(&khalil, &[RobotFunction::of_link("pose").unwrap()(third)]).contains("the frame is Khalil's"));
}

/// The operation counts in the doc comment equal the number of operations in the generated code.
#[test]
fn counts_are_those_of_the_code() {
    let of_entries = "inertia_matrix_entries<";
    for (file, word, name) in [("ur5.yaml", "inertia-matrix", of_entries), ("sr400.par", "gravity", "gravity<")] {
        let text = written(&tests::model(file), &[RobotFunction::of_robot(word).unwrap()]);
        let counts: Vec<usize> = text
            .lines()
            .filter(|line| line.starts_with("/// ") && line.ends_with("sin_cos."))
            .flat_map(|line| line[4..].split(", "))
            .map(|count| count.split(' ').next().unwrap().parse().unwrap())
            .collect();
        let body = text.split("pub fn ").find(|part| part.starts_with(name)).unwrap();
        let body = body.split("\n}").next().unwrap();
        let sums = body.matches(" + ").count() + body.matches(" - ").count();
        let found =
            [body.matches(".mul_add(").count(), body.matches(" * ").count() + body.matches(" / ").count(), sums];
        assert_eq!(found, counts[..3], "{file} {name}");
    }
}

#[test]
fn nothing_of_a_name_becomes_code() {
    let mut robot = tests::model("planar2r.yaml");
    robot.name = "r\nfn pwned() {}\r\u{2028}fn pwned() {}".into();
    robot.source = Some("here\n#[no_mangle]\nfn pwned() {}".into());
    robot.coordinates[0].name = "q1\nfn pwned() {}".into();
    let text = written(&robot, &[]);
    for line in text.lines().filter(|line| line.contains("pwned")) {
        let harmless = line.starts_with("//")
            || line.trim_start().starts_with('"')
            || line.contains(": &str = \"")
            || line.contains("= [\"");
        assert!(harmless, "{line}");
    }
}

/// Inverse geometry gives configurations for poses. One of them is the configuration from which the pose was computed. The
/// function is called by its name and needs only poses.
#[test]
fn configurations_are_evaluated_from_poses() {
    tests::register_wings();
    let model = Model::read(tests::model_path("ur5.yaml")).unwrap();
    let q: Vec<f64> = (0..30).map(|k| (1.3 * f64::from(k)).sin()).collect();
    let at = |name: &str, states: ManyStates, size: usize| {
        let mut outputs = vec![0.0; 5 * size];
        Evaluation::of_function(&model, name).unwrap().fill(&model, &states, &mut outputs).unwrap();
        outputs
    };
    let pose = at("pose=6", ManyStates { q: &q, ..ManyStates::default() }, 12);
    let back = at("inverse-geometry=6", ManyStates { others: &[("t", &pose)], ..ManyStates::default() }, 96);
    for (q, back) in q.chunks(6).zip(back.chunks(96)) {
        let off = |k: usize| {
            let angle = |j: usize| back[6 * k + j].atan2(back[48 + 6 * k + j]);
            (0..6).map(|j| (q[j] - angle(j)).sin().abs()).fold(0.0, f64::max)
        };
        assert!((0..8).map(off).any(|off| off < 1e-6), "{q:?}");
    }
}
