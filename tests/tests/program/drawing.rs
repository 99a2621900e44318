//! Tests that the script of an HTML page draws the links of a robot at the poses that rist computes.

use rist::request::{InspectRequest, ModelOptions};
use robot::{JointKind, LoopFrame, Pose, Robot};
use serde_json::{Value, json};
use tests::loops::{LOOPS, loop_path};
use tests::model_path;
use tests::program::node;
use tests::random::Random;

const SCRIPT: &str = concat!(
    include_str!("../../../crates/report/templates/dom.js"),
    include_str!("../../../crates/report/templates/drawing.js"),
    include_str!("../../../crates/report/templates/loops.js")
);
/// Number of tested configurations per robot.
const STATES: usize = 5;
/// Tolerance for poses: the page stores numbers with nine decimals, and the errors of ten links add up.
const AS_DRAWN: f64 = 1e-7;

/// The data of the robot in a page, as its script reads them.
fn on_the_page(html: &str) -> Value {
    let (_, rest) = html.split_once("<script type=\"application/json\">").expect("the page draws the robot");
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

/// The output of the page's script for these cases; `None` if there is no JavaScript engine.
fn run_by_node(cases: &Value) -> Option<Value> {
    let main = "
        const cases = JSON.parse(require('fs').readFileSync(0, 'utf8'));
        const poses = (robot, x) => Drawing.kinematics.poses(robot, x);
        console.log(JSON.stringify(cases.map(({ robot, at, values, to }) => ({
            poses: values.map(x => poses(robot, x)),
            followed: to.map(x => Loops.follow(robot, at, x)),
        }))));";
    node(&format!("{SCRIPT}{main}"), cases)
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap_or_else(|| panic!("{value}")).iter().map(|x| x.as_f64().unwrap()).collect()
}

fn flat(pose: &Pose) -> Vec<f64> {
    (0..3).flat_map(|r| [pose.rotation[r][0], pose.rotation[r][1], pose.rotation[r][2], pose.position[r]]).collect()
}

fn of_loop(robot: &Robot, frame: &LoopFrame, poses: &[Pose], x: &[f64]) -> Pose {
    let value = frame.variable.number(x, &robot.symbols);
    let (angle, length) = match frame.kind {
        JointKind::Revolute => (value, 0.0),
        JointKind::Prismatic => (0.0, value),
        JointKind::Fixed => (0.0, 0.0),
    };
    let ahead = frame.geometry.pose(&robot.symbols, angle, length);
    frame.antecedent.map_or(ahead, |i| poses[i.0].compose(&ahead))
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn a_page_draws_the_robot_where_it_is() {
    let shipped = ["ur5.yaml", "panda.yaml", "stanford.yaml", "sr400.par", "tree.yaml", "ur5.urdf"].map(model_path);
    // The largest robot is skipped: its derivation takes long, and it has no kind of joint that the others do not have.
    let small = LOOPS.iter().filter(|one| one.1 < 100).map(|one| loop_path(one.0));
    let mut random = Random(40);
    let mut robots: Vec<Robot> = Vec::new();
    let mut cases: Vec<Value> = Vec::new();
    for path in shipped.into_iter().chain(small) {
        let robot = robot::format::read(&path).unwrap();
        let found = rist::inspect(robot, &path, &ModelOptions::default(), &InspectRequest::default()).unwrap();
        let drawn = on_the_page(&found.html());
        let robot = found.model.robot;
        let n = robot.n_variables();
        let values: Vec<Vec<f64>> = (0..STATES).map(|_| (0..n).map(|_| 2.0 * random.unit()).collect()).collect();
        let at: Vec<f64> = drawn["variables"].as_array().unwrap().iter().map(|v| v["at"].as_f64().unwrap()).collect();
        // The steps are so small that every loop still closes.
        let near = |random: &mut Random| -> Vec<f64> { at.iter().map(|x| x + 0.01 * random.unit()).collect() };
        let to: Vec<Vec<f64>> = (0..STATES).map(|_| near(&mut random)).collect();
        cases.push(json!({"robot": drawn, "at": at, "values": values, "to": to}));
        robots.push(robot);
    }
    let Some(said) = run_by_node(&Value::from(cases.clone())) else { return };
    for ((robot, case), said) in robots.iter().zip(&cases).zip(said.as_array().unwrap()) {
        for (x, poses) in case["values"].as_array().unwrap().iter().zip(said["poses"].as_array().unwrap()) {
            let expected: Vec<f64> = robot.link_poses(&numbers(x)).iter().flat_map(flat).collect();
            let found: Vec<f64> = poses.as_array().unwrap().iter().flat_map(numbers).collect();
            assert!(apart(&found, &expected) < AS_DRAWN, "{}", robot.name);
        }
        let n = robot.n_coordinates();
        for (to, x) in case["to"].as_array().unwrap().iter().zip(said["followed"].as_array().unwrap()) {
            let (to, mut x) = (numbers(to), numbers(x));
            // The tolerance is needed because the numbers are written as JSON text and read again.
            assert!(apart(&x[..n], &to[..n]) < 1e-14, "{}: the coordinates are those asked for", robot.name);
            x.resize(robot.n_variables(), 0.0);
            let poses = robot.link_poses(&x);
            for one in robot.loops.iter().filter(|one| robot.is_implicit(one)) {
                let [cut, twin] = [&one.cut, &one.twin].map(|frame| flat(&of_loop(robot, frame, &poses, &x)));
                assert!(apart(&cut, &twin) < AS_DRAWN, "{}: a loop is open by {:e}", robot.name, apart(&cut, &twin));
            }
        }
    }
}
