//! Tests of `rist check` on motions from other programs (points in a table or in a JointTrajectory message), and on the
//! experiments of a plan.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use rist::request::PlanRequest;
use rist::{LimitsFile, Model};
use tests::bodied_robots::bodied_robots;
use tests::joint_log::described;
use tests::program::{self, LIMITED_ARM, Run, folder, rist, rist_done};
use tests::random::State;
use tests::{has, recursion};

/// Folder with an arm, a motion of this arm, and the motion as files for a controller. It is made once for all tests.
fn played() -> &'static Path {
    static MADE: OnceLock<PathBuf> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = folder("checked-points");
        let arm = LIMITED_ARM.replace("velocity: 5,", "velocity: 5, acceleration: 20,");
        std::fs::write(folder.join("arm.yaml"), arm).unwrap();
        let play = ["--play", "motion.csv", "--play", "ros.yaml", "--play", "ros.json"];
        let excite =
            ["excite", "arm.yaml", "--starts", "1", "--iterations", "20", "--repetitions", "1", "--period", "4"];
        rist(&folder, &[&excite[..], &play, &["--out", "motion.yaml"]].concat()).ended(0);
        folder
    })
}

fn check(folder: &Path, file: &str, arguments: &[&str]) -> Run {
    rist(folder, &[&["check", "arm.yaml", file][..], arguments].concat())
}

fn holds(run: &Run, code: i32, said: &[&str]) {
    assert_eq!(run.code, Some(code), "{}{}", run.out, run.err);
    said.iter().for_each(|said| {
        assert!(run.out.contains(said) || run.err.contains(said), "no `{said}` in {}{}", run.out, run.err)
    });
}

#[test]
fn played_files_are_proven_between_their_points() {
    let folder = played();
    let proven = "proven, between samples too: position of q1 and of q2, velocity of q1 and of q2, acceleration of q1 and of q2, effort";
    for file in ["motion.csv", "ros.yaml", "ros.json"] {
        let found = check(folder, file, &[]);
        holds(&found, 0, &[proven, " points over 5.", "quintic between them", "jerk of q1, q2: not looked at"]);
    }
    let found = check(folder, "motion.csv", &["--interpolation", "cubic"]);
    holds(&found, 0, &[proven, "cubic between them", "limit of jerk of q1, q2: not looked at"]);
    let found = check(folder, "motion.csv", &["--interpolation", "linear"]);
    holds(
        &found,
        0,
        &[
            "position of q1 and of q2, velocity of q1 and of q2;",
            "its velocity jumps at each",
            "effort of q1 and of q2",
        ],
    );
    std::fs::write(folder.join("slow.yaml"), "all: {velocity: 0.5}\n").unwrap();
    holds(&check(folder, "ros.json", &["--limits", "slow.yaml"]), 1, &["velocity of q1: ", " is beyond "]);
    std::fs::write(folder.join("weak.yaml"), "coordinates: {q1: {effort: 5}}\n").unwrap();
    holds(&check(folder, "motion.csv", &["--limits", "weak.yaml"]), 1, &["effort of q1: ", " is beyond "]);
    // The user gives a jerk limit, but with this interpolation the acceleration jumps. So the limit cannot be checked, and the
    // check fails.
    std::fs::write(folder.join("jerk.yaml"), "all: {jerk: 1000}\n").unwrap();
    let found = check(folder, "motion.csv", &["--limits", "jerk.yaml", "--interpolation", "cubic"]);
    holds(&found, 1, &["its acceleration jumps at each"]);
    holds(&check(folder, "motion.csv", &["--limits", "jerk.yaml"]), 0, &["jerk of q1 and of q2"]);
}

#[test]
fn peaks_between_points_and_files_of_moveit() {
    let folder = played();
    let file = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    // Both points have equal positions within the limits. But the velocities at the points carry q1 beyond 2 rad in between.
    file("peak.csv", "t,q_q1,q_q2,dq_q1,dq_q2\n0,1.9,0,2,0\n1,1.9,0,-2,0\n");
    let found = check(folder, "peak.csv", &[]);
    // The cubic 1.9 + 2 t - 2 t^2 has its maximum 2.4 rad at t = 0.5 s.
    holds(&found, 1, &["position of q1: 2.4 rad at 0.5 s is beyond 2 rad", "does not begin and end at rest"]);
    holds(&check(folder, "peak.csv", &["--interpolation", "linear"]), 0, &["linear between them"]);
    holds(&check(folder, "peak.csv", &["--interpolation", "quintic"]), 2, &["needs accelerations at the points"]);
    let moveit = r#"{"joint_trajectory": {"header": {"frame_id": "base"}, "joint_names": ["q2"], "points": [
        {"positions": [0.0], "velocities": [0.0], "accelerations": [0.0], "effort": [], "time_from_start": {"secs": 0, "nsecs": 0}},
        {"positions": [0.5], "velocities": [0.0], "accelerations": [0.0], "effort": [], "time_from_start": {"secs": 1, "nsecs": 0}}]},
        "multi_dof_joint_trajectory": {"joint_names": [], "points": []}}"#;
    file("moveit.json", moveit);
    holds(&check(folder, "moveit.json", &[]), 2, &["it does not say where q1 stands", "{locked: POSITION}"]);
    file("stands.yaml", "coordinates: {q1: {locked: 0.3}}\n");
    holds(&check(folder, "moveit.json", &["--limits", "stands.yaml"]), 0, &["2 points over 1.000 s, quintic"]);
    file("back.csv", "t,q_q1,q_q2\n0,0,0\n0,1,0\n");
    holds(&check(folder, "back.csv", &[]), 2, &["time does not go on from point 1"]);
    file("text.csv", "t,q_q1,q_q2\n0,0,0\n1,a,0\n");
    holds(&check(folder, "text.csv", &[]), 2, &["positions of q1 at point 2"]);
    file("short.csv", "t,q_q1\n0,0\n1,1\n");
    holds(&check(folder, "short.csv", &[]), 2, &["q2"]);
}

#[test]
fn a_plan_and_its_proof_are_checked() {
    let folder = played();
    rist_done(folder, "plan arm.yaml -n 6 --starts 2 --nodes 60 --configurations 8 --out plan.yaml");
    let found = check(folder, "plan.yaml", &[]);
    holds(&found, 0, &["e01: proven", "e06: proven", "proven again: D-efficiency at least 0."]);
    file_with(folder, "better.yaml", "d_efficiency_at_least: 0.", "d_efficiency_at_least: 0.99999");
    let better = check(folder, "better.yaml", &[]);
    holds(&better, 1, &["BROKEN: the file says D-efficiency at least 1.0000; its proof gives 0."]);
    std::fs::write(folder.join("weak_plan.yaml"), "all: {effort: 0.5}\n").unwrap();
    holds(&check(folder, "plan.yaml", &["--limits", "weak_plan.yaml"]), 1, &["e01: effort of "]);
    std::fs::write(folder.join("slow_plan.yaml"), "all: {acceleration: 0.5}\n").unwrap();
    holds(&check(folder, "plan.yaml", &["--limits", "slow_plan.yaml"]), 1, &["acceleration of "]);
    rist_done(folder, "plan arm.yaml -n 4 --starts 1 --configurations 4 --out short.yaml");
    let found = check(folder, "short.yaml", &[]);
    assert!(found.out.contains("it has no proof that could be found again"), "{}", found.out);
}

#[test]
fn a_plan_keeps_efforts_and_bodies() {
    let folder = folder("planned-limits");
    let robots = bodied_robots();
    let arm = robots.iter().find(|robot| robot.name == "ur5e").unwrap().urdf();
    // The torque limits are so low that a plan which keeps only the kinematic limits would exceed them.
    let arm = arm.replace("effort=\"80\"", "effort=\"12\"").replace("effort=\"250\"", "effort=\"60\"");
    let path = folder.join("ur5e.urdf");
    std::fs::write(&path, &arm).unwrap();
    let model = Model::parse(&arm, &path, &Default::default()).unwrap();
    let request = PlanRequest { experiments: 6, starts: 1, configurations: 8, ..PlanRequest::default() };
    let planned = rist::plan(&model, &request, &|_, _, _| ()).unwrap();
    let x = described(&model.robot);
    let mut most = 0.0_f64;
    for experiment in planned.plan.trajectories("plan").unwrap() {
        let reference = experiment.reference();
        for i in (0..reference.q[0].len()).step_by(7) {
            let of = |series: &[Vec<f64>]| series.iter().map(|x| x[i]).collect::<Vec<f64>>();
            let state = State { q: of(&reference.q), dq: of(&reference.dq), ddq: of(&reference.ddq) };
            let tau = recursion::torque(&model.robot, &state, &x);
            for (tau, coordinate) in tau.iter().zip(&model.robot.coordinates) {
                most = most.max(tau.abs() / coordinate.limits.effort.unwrap());
            }
        }
    }
    // The plan uses 0.9 of the effort limits, but only checks sampled instants. So slightly more is possible between them.
    assert!(most > 0.3 && most < 0.95, "{most}");
    assert!(planned.checked.iter().all(|(_, checked)| checked.is_proven()) && planned.checked.len() == 6);
    let last = planned.checked[0].1.claims().to_string();
    assert!(last.contains("distance of ") && last.contains("effort of 6"), "{last}");
    let limited = |text: &str| LimitsFile::from_yaml("limits.yaml", text).unwrap();
    for (text, said) in [
        ("all: {effort: 0.01}", "no motion keeps the limits"),
        ("all: {jerk: 5}", "acceleration of a bang-bang swing and of a sweep jumps"),
        ("coordinates: {elbow: {velocity: 1}}", "there is no coordinate `elbow`"),
    ] {
        let request = PlanRequest { limits: Some(limited(text)), ..request.clone() };
        let refused = rist::plan(&model, &request, &|_, _, _| ()).err().unwrap().to_string();
        assert!(refused.contains(said), "{text}: {refused}");
    }
    // A locked joint stands at the position in the limits file.
    let locked = PlanRequest { limits: Some(limited("coordinates: {joint2: {locked: -1.2}}")), ..request };
    let planned = rist::plan(&model, &locked, &|_, _, _| ()).unwrap().plan;
    assert!(planned.experiments.iter().all(|e| e.centre[1] == -1.2 && e.fast != "joint2"));
}

/// `rist visibility` predicts the uncertainties of the parameters for a motion file. For a played file and a log of this motion,
/// it predicts about the same. If a motion hardly moves a joint, it names this joint.
#[test]
fn what_a_file_tells_is_foreseen() {
    let folder = played();
    let told = |file: &str, arguments: &[&str]| {
        let run = rist(folder, &[&["--json", "visibility", "arm.yaml", file][..], arguments].concat()).ended(0);
        serde_json::from_str::<serde_json::Value>(&run.out).unwrap()
    };
    let deviations = |told: &serde_json::Value| -> Vec<f64> {
        told["parameters"].as_array().unwrap().iter().map(|p| p["deviation"].as_f64().unwrap()).collect()
    };
    let motion = program::motion(&folder.join("motion.yaml"));
    let of_motion = told("motion.yaml", &[]);
    // The standard deviations stated in the motion file are larger, because they also include encoder noise.
    for (found, own) in deviations(&of_motion).iter().zip(&motion.parameters) {
        let own = own.deviation.unwrap();
        assert!(*found <= own * (1.0 + 1e-9) && *found > 0.1 * own, "{found} {own}");
    }
    // The torque uncertainties are proportional to the torque noise.
    let purposes = |told: &serde_json::Value| -> Vec<f64> {
        told["purposes"].as_array().unwrap().iter().map(|p| p["deviation"].as_f64().unwrap()).collect()
    };
    let three_times = purposes(&told("motion.yaml", &["--noise", "0.03"]));
    for (one, three) in purposes(&of_motion).iter().zip(&three_times) {
        assert!((three / one - 3.0).abs() < 1e-9, "{one} {three}");
    }
    let whole = deviations(&told("ros.json", &[]));
    let positions: String = {
        let csv = std::fs::read_to_string(folder.join("motion.csv")).unwrap();
        csv.lines().map(|line| line.split(',').take(3).collect::<Vec<_>>().join(",") + "\n").collect()
    };
    std::fs::write(folder.join("none.csv"), positions).unwrap();
    let log = deviations(&told("none.csv", &[]));
    for ((whole, log), one) in whole.iter().zip(&log).zip(deviations(&of_motion)) {
        // Both files contain one period and the blends from rest and to rest. The filter removes the ends of the log.
        assert!(*whole < 1.1 * one && *log > 0.5 * whole && *log < 4.0 * one, "{whole} {log} {one}");
    }
    let still = "t,q_q1,q_q2,dq_q1,dq_q2,ddq_q1,ddq_q2\n0,0,0,0,0,0,0\n1,0.2,0,0,0,0,0\n";
    std::fs::write(folder.join("still.csv"), still).unwrap();
    let run = rist(folder, &["visibility", "arm.yaml", "still.csv"]).ended(0);
    has(
        &run.out,
        &["q2: it uses 0 % of its positions", "feedforward at the speed limits: not identifiable", "identifiable: "],
    );
    let run = rist(folder, &["visibility", "arm.yaml", "motion.yaml"]);
    has(&run.out, &["gravity compensation: uncertainty ", "none of them weak"]);
    rist(folder, &["visibility", "arm.yaml", "motion.yaml", "--friction", "auto"]).failed(2, &["auto needs a log"]);
}

#[test]
fn a_motion_goes_to_a_robot_and_back() {
    let folder = played();
    let play = |arguments: &[&str]| rist(folder, &[&["play", "arm.yaml", "motion.yaml"][..], arguments].concat());
    let from = ["--from", "q1=0.5,q2=-0.4", "--speed", "0.3", "--controller", "franka"];
    let run = play(&[&from[..], &["--out", "slow.csv", "--template", "head.csv"]].concat());
    holds(
        &run,
        0,
        &[
            "way there: proven",
            "motion: proven",
            "way back: proven",
            "not tried on a controller",
            "safety function",
            "warm-up: friction falls",
            "repetition: it begins and ends at rest",
            "stop where a joint strays from its set point",
            "stop where a torque is far above what is proven of it without dry friction, N m (N): q1 ",
            "a stop at the limits of acceleration takes q",
        ],
    );
    for never in ["where the robot stands is not given", "approach and return", "limit of"] {
        assert!(!run.out.replace("assumed: limit of", "").contains(never), "{never}: {}", run.out);
    }
    let (slow, quick) = (rows(folder, "slow.csv"), rows(folder, "motion.csv"));
    for row in [&slow[0], slow.last().unwrap()] {
        assert!(
            (row[1] - 0.5).abs() < 1e-9 && (row[2] + 0.4).abs() < 1e-9 && row[3..].iter().all(|x| *x == 0.0),
            "{row:?}"
        );
    }
    let most = |rows: &[Vec<f64>], c: usize| rows.iter().map(|row| row[c].abs()).fold(0.0, f64::max);
    // The motion is played with speed 0.3: the file still has 1000 rows per second, velocities are multiplied by 0.3,
    // accelerations by 0.09.
    assert!((slow[1][0] - slow[0][0] - 1e-3).abs() < 1e-9);
    for c in 3..5 {
        assert!((most(&slow, c) / most(&quick, c) - 0.3).abs() < 0.01, "{c}");
        assert!((most(&slow, c + 2) / most(&quick, c + 2) - 0.09).abs() < 0.005, "{c}");
    }
    // The positions have no jump where approach, motion and return meet.
    let jump = slow.windows(2).map(|w| (w[1][1] - w[0][1]).abs() / 1e-3).fold(0.0, f64::max);
    assert!(jump <= most(&slow, 3) * 1.001, "{jump}");
    holds(&check(folder, "slow.csv", &[]), 0, &["position of q1 and of q2"]);
    assert_eq!(std::fs::read_to_string(folder.join("head.csv")).unwrap(), "t,q_q1,q_q2,tau_q1,tau_q2\n");
    let run = play(&["--out", "ros2.yaml"]);
    holds(&run, 0, &["where the robot stands is not given (--from)", "way back: proven", "played again at once"]);
    let text = std::fs::read_to_string(folder.join("ros2.yaml")).unwrap();
    assert!(text.contains("# repetition: it begins and ends at rest at one pose") && !text.contains("NEVER"), "{text}");
    holds(&check(folder, "ros2.yaml", &[]), 0, &["quintic between them"]);
    std::fs::write(folder.join("slower.yaml"), "all: {velocity: 0.2}\n").unwrap();
    let broken = play(&["--limits", "slower.yaml", "--out", "never.yaml"]);
    holds(&broken, 1, &["motion: velocity of q1", "nothing is written"]);
    assert!(!folder.join("never.yaml").exists());
    holds(&play(&["--controller", "ur-e", "--out", "x.script"]), 2, &["six joints that turn; arm has 2 coordinates"]);
    holds(&play(&["--from", "q9=1", "--out", "x.yaml"]), 2, &["--from: there is no coordinate `q9`"]);
    holds(&play(&["--from", "q1=3", "--out", "x.yaml"]), 1, &["way there: position of q1: 3 rad"]);
}

fn rows(folder: &Path, name: &str) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    text.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect()
}

#[test]
fn what_may_be_played_again_keeps_its_limits_twice() {
    let folder = played();
    let once = rist(folder, &["play", "arm.yaml", "motion.yaml", "--controller", "franka", "--out", "once.csv"]);
    holds(&once, 0, &["way back: proven", "played again at once"]);
    let (quick, once) = (rows(folder, "motion.csv"), rows(folder, "once.csv"));
    let ends = [&quick[0], quick.last().unwrap()].map(|row| row[1..3].to_vec());
    assert!(ends[0].iter().zip(&ends[1]).any(|(a, b)| (a - b).abs() > 0.01), "{ends:?}");
    let again = once.iter().skip(1).map(|row| [&[row[0] + once.last().unwrap()[0]], &row[1..]].concat());
    let line = |row: &Vec<f64>| row.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n";
    let twice: String = once.iter().cloned().chain(again).map(|row| line(&row)).collect();
    std::fs::write(folder.join("twice.csv"), format!("t,q_q1,q_q2,dq_q1,dq_q2,ddq_q1,ddq_q2\n{twice}")).unwrap();
    holds(&check(folder, "twice.csv", &[]), 0, &["position of q1 and of q2"]);
}

fn file_with(folder: &Path, name: &str, from: &str, to: &str) {
    let text = std::fs::read_to_string(folder.join("plan.yaml")).unwrap();
    assert!(text.contains(from));
    std::fs::write(folder.join(name), text.replacen(from, to, 1)).unwrap();
}
