//! Tests of impossible requests: without a long search, the message names the limit, its coordinate and a remedy. If the limits
//! inside a motion file were loosened, the motion is still checked against the description and the limits of the user.

use std::path::{Path, PathBuf};

use experiments::excitation::artefact::ExcitingMotion;
use tests::program::{LIMITED_ARM, Run, folder, motion, rist};
use tests::{has, workspace};

const QUICK: [&str; 8] = ["--starts", "1", "--iterations", "3", "--period", "5", "--repetitions", "1"];

fn arm(name: &str) -> PathBuf {
    let here = folder(name);
    std::fs::write(here.join("arm.yaml"), LIMITED_ARM).unwrap();
    here
}

/// Runs `excite`, which must be refused with these phrases.
fn refused(here: &Path, arguments: &[&str], said: &[&str]) {
    rist(here, &[&["excite", "arm.yaml"], arguments].concat()).failed(2, said);
}

/// Options (times, numbers) with which no motion is possible: the message names the option.
#[test]
fn impossible_times_get_an_answer() {
    let here = arm("impossible_times");
    let few = ["--starts", "1", "--iterations", "3"];
    for (more, said) in [
        (vec!["--period", "0"], vec!["--period must be a positive number, not 0"]),
        (vec!["--blend", "0"], vec!["--blend must be a positive number, not 0"]),
        (vec!["--repetitions", "0"], vec!["--repetitions is 0; expected is a number from 1 up"]),
        // More samples than a file can hold: refused before the search.
        (
            vec!["--period", "5", "--repetitions", "1000000000"],
            vec!["1.0e12 samples", "--period, --blend or --repetitions"],
        ),
        // With this short period, no parameter is identifiable.
        (
            vec!["--period", "0.1", "--rate", "1000", "--harmonics", "1"],
            vec!["separates the parameters", "nearest is its limit of ", "choose another --period"],
        ),
    ] {
        refused(&here, &[&few[..], &more].concat(), &said);
    }
}

/// Limits with which no motion is possible: the message names the coordinate and the limit.
#[test]
fn impossible_limits_get_an_answer() {
    let here = arm("impossible_limits");
    for (limits, said) in [
        ("all: {locked: 0}", vec!["every coordinate is locked: unlock one in the limits file"]),
        (
            "coordinates: {q2: {position: [1.5, 1]}}",
            vec!["coordinate q2: the limits of position are empty: from 1.5 to 1"],
        ),
        ("coordinates: {q2: {position: [-3, 1]}}", vec!["coordinate q2: position -3 to 1", "only tighten"]),
        ("coordinates: {q1: {velocity: 6}}", vec!["coordinate q1: velocity 6 of the limits file is above 5"]),
        (
            "coordinates: {q2: {velocity: 0}}",
            vec!["coordinate q2: the limit of velocity allows no motion: 0", "(locked: holds still)"],
        ),
        (
            "coordinates: {q2: {jerk: .inf}}",
            vec!["coordinate q2: the limit of jerk allows no motion: inf", "positive number"],
        ),
        ("coordinates: {q1: {locked: 3}}", vec!["coordinate q1: locked at 3, outside its limits of position, -2 to 2"]),
        (
            "coordinates: {q1: {effort: 0.01}}",
            vec!["no motion keeps the effort limit of q1: even a tiny one takes ", "--effort-share"],
        ),
        ("coordinates: {q1: {power: 1e-6}}", vec!["no motion keeps the power limit of q1"]),
        ("all: {acceleration: 1e-9}", vec!["a blend 1.2500e10 s (by the limits of velocity and acceleration"]),
        ("all: {jerk: 1e-9}", vec!["separates the parameters: q2, the slowest", "its limit of jerk"]),
        (
            "coordinates: {q2: {position: [1, 1.0000001]}}",
            vec![
                "q2, the slowest",
                "its limit of position: raise it",
                "tried, and a motion is proven: coordinates: {q2: {locked: 1}}",
            ],
        ),
        ("coordinates: {q3: {velocity: 1}}", vec!["there is no coordinate `q3`; there are q1, q2"]),
        ("speed: 3", vec!["limits.yaml", "unknown field `speed`"]),
    ] {
        std::fs::write(here.join("limits.yaml"), limits).unwrap();
        refused(&here, &[&["--limits", "limits.yaml"], &QUICK[..]].concat(), &said);
    }
    let small = ["--effort-share", "0.001", "--starts", "1", "--iterations", "3"];
    refused(&here, &small, &["tried, and a motion is proven: --effort-share 0.9"]);
    refused(&here, &["--limits", "nothing.yaml"], &["nothing.yaml: there is no such file"]);
    refused(&here, &["--out", "m.yaml", "--report", "m.yaml"], &["m.yaml: two outputs have this name"]);
}

/// Limits of a UR5 that users reported. Each is either refused with the reason, or gives a motion whose last line of output names
/// this limit.
#[test]
fn limits_of_an_arm_are_read_or_refused() {
    let here = folder("limits_of_an_arm");
    let ur5 = workspace().join("models/ur5.urdf").display().to_string();
    let run = |limits: &str| {
        std::fs::write(here.join("limits.yaml"), limits).unwrap();
        rist(&here, &[&["excite", &ur5, "--limits", "limits.yaml"], &QUICK[..]].concat())
    };
    for (limits, said) in [
        ("coordinates: {elbow: {position: [1, 1]}}", "position of 6"),
        ("coordinates: {shoulder_lift: {effort: 5}}", "effort of 6"),
        ("space: {floor: 0.0}", "floor at z = 0 m"),
        ("space: {walls: [{point: [0,0,0], normal: [1,0,0]}]}", "region of 4"),
    ] {
        let run = run(limits).ended(0);
        let last = run.out.split("\n\n").last().unwrap_or_default().replace("\n  ", " ");
        assert!(last.starts_with("proven, ") && last.contains(said), "{limits}: {last}");
    }
    for (limits, said) in [
        ("coordinates: {elbow: {position: [8, 9]}}", "elbow: position 8 to 9 of the limits file exceeds -6.28"),
        ("all: {velocity: .nan}", "shoulder_pan: the limit of velocity allows no motion: NaN"),
        ("coordinates: {shoulder_lift: {effort: 0}}", "shoulder_lift: the limit of effort allows no motion: 0"),
        ("all: {power: 0.001}", "no motion keeps the power limit of elbow"),
        ("space: {floor: 3}", "shoulder is 2.9108 m beyond the floor, and no joint that is not locked moves it away"),
        ("space: {floor: 3}", "space: {floor: 0.088} is below it"),
        ("space: {walls: [{point: [0,0,0], normal: [0,0,0]}]}", "the wall: normal [0.0, 0.0, 0.0]"),
        ("space: {boxes: [{low: [1,1,1], high: [0,0,0]}]}", "the box: it is empty along x: from 1 to 0"),
        (
            "space: {boxes: [{low: [-0.05,-0.05,0], high: [0.05,0.05,0.3]}]}",
            "the limits of position leave no place that is free, or the limit is too tight",
        ),
        (
            "space: {boxes: [{low: [-1,-1,-1], high: [1,1,1], links: [hand]}]}",
            "there is no link `hand`; there are base, ",
        ),
        ("space: {distance: -1}", "space: distance is -1; expected are metres, 0 or more"),
        ("space: {distance: 10}", "distance: not looked at, because the description has no collision geometry"),
        ("all: {slowed: 0}", "shoulder_pan: slowed is a factor above 0 and at most 1, not 0"),
        ("all: {slowed: 0.000001}", "a blend 7.5000e5 s"),
        ("all: {jerk: 0.000000001}", "nearest is its limit of jerk: raise it"),
    ] {
        let run = run(limits).failed(2, &[said]);
        // For boxes and walls the message must not give advice about pairs of links.
        let is_place = limits.contains("boxes") || limits.contains("walls");
        assert!(!is_place || !run.err.contains("inf") && !run.err.contains("sign the pair"), "{limits}: {}", run.err);
    }
}

/// Some exporters write a <limit> of zeros if they know no limits; then the joint may move. If such a limit has a nonzero
/// velocity, the joint is locked.
#[test]
fn a_limit_of_zeros_holds_nothing_still() {
    let here = folder("limits_of_zeros");
    let arm = |limit: &str| {
        let link = |name: &str| {
            format!(
                "<link name='{name}'><inertial><origin xyz='0.1 0 0.1'/><mass value='1'/>\
                 <inertia ixx='0.01' iyy='0.02' izz='0.02' ixy='0' ixz='0' iyz='0'/></inertial></link>"
            )
        };
        format!(
            "<robot name='r'><link name='b'/>{}{}<joint name='j1' type='revolute'><parent link='b'/><child link='l1'/>\
             <axis xyz='0 1 0'/>{limit}</joint><joint name='j2' type='revolute'><parent link='l1'/><child link='l2'/>\
             <origin xyz='0 0 0.3'/><axis xyz='0 1 0'/>{limit}</joint></robot>",
            link("l1"),
            link("l2")
        )
    };
    for (limit, code, said) in [
        ("<limit lower='0' upper='0' effort='0' velocity='0'/>", 0, "has a <limit> of zeros alone: taken as unlimited"),
        ("<limit lower='0' upper='0' effort='5' velocity='1'/>", 2, "every coordinate is locked"),
    ] {
        std::fs::write(here.join("arm.urdf"), arm(limit)).unwrap();
        let run = rist(&here, &[&["excite", "arm.urdf"], &QUICK[..]].concat());
        let inspected = rist(&here, &["inspect", "arm.urdf"]);
        assert_eq!(run.code, Some(code), "{limit}: {}{}", run.out, run.err);
        let all = [run.out, run.err, inspected.out, inspected.err].concat();
        assert!(all.replace("\n", " ").contains(said), "{limit}: {all}");
    }
}

/// A motion of the arm, made with the limits file made.yaml.
fn found(name: &str) -> (PathBuf, ExcitingMotion) {
    let here = arm(name);
    std::fs::write(here.join("made.yaml"), "all: {velocity: 2, acceleration: 8, jerk: 150, power: 60}\n").unwrap();
    let out = ["--limits", "made.yaml", "--out", "motion.yaml"];
    rist(&here, &[&["excite", "arm.yaml"], &QUICK[..], &out].concat()).ended(0);
    let motion = motion(&here.join("motion.yaml"));
    (here, motion)
}

/// A motion that is designed after an estimate contains the identified torques. `rist check` does not trust them. The last line
/// of its output says so, and a forged file gives the same proof.
#[test]
fn torques_of_the_motions_own_file_prove_nothing() {
    let (here, _) = found("own_torques");
    let out = ["--limits", "made.yaml", "--after", "estimate.yaml", "--out", "after.yaml"];
    for step in [
        &["simulate", "arm.yaml", "motion.yaml", "--out", "logs"][..],
        &["identify", "arm.yaml", "logs/motion.csv", "--out", "estimate.yaml"],
        &[&["excite", "arm.yaml"], &QUICK[..], &out].concat(),
    ] {
        let run = rist(&here, step);
        assert!(matches!(run.code, Some(0 | 1)), "{step:?}: {}", run.err);
    }
    let mut motion = motion(&here.join("after.yaml"));
    let identified = motion.identified.as_mut().expect("the torques that it was made with");
    identified.parameters.iter_mut().for_each(|x| *x = 0.0);
    identified.friction.iter_mut().for_each(|friction| *friction = Default::default());
    std::fs::write(here.join("forged.yaml"), motion.to_yaml().unwrap()).unwrap();
    let check = |arguments: &[&str]| rist(&here, &[&["check", "arm.yaml"], arguments].concat());

    let (own, forged) = (check(&["after.yaml"]), check(&["forged.yaml"]));
    let assumed =
        "effort of a robot with the torques of its description: assumed by the description: the motion was made";
    for run in [&own, &forged] {
        assert_eq!(run.code, own.code, "{}{}", run.out, run.err);
        assert!(run.out.contains(assumed), "{}", run.out);
        let last = run.out.lines().last().unwrap_or_default();
        assert!(last.contains("; assumed: ") && last.contains("effort"), "{last}");
    }
    let proof =
        |run: &Run| run.out.lines().filter(|line| line.contains("proven")).map(String::from).collect::<Vec<_>>();
    assert_eq!(proof(&own), proof(&forged));
    let after = check(&["after.yaml", "--after", "estimate.yaml"]);
    assert!(matches!(after.code, Some(0 | 1)) && !after.out.contains(assumed), "{}{}", after.out, after.err);
}

/// A motion file with absurd numbers is refused, because to play or prove it would take an endless time.
#[test]
fn motions_of_absurd_size_are_refused() {
    let (here, motion) = found("absurd");
    type Change = fn(&mut ExcitingMotion);
    let changes: [(Change, &str); 4] = [
        (|m| m.rate_hz = 1e-6, "rate_hz is 1e-6; a controller has 1 to 20000 Hz"),
        (|m| m.rate_hz = f64::NAN, "rate_hz is NaN"),
        (|m| m.joints[1].cosine = vec![1e-3; 20_000], "q2 has 20000 harmonics; at most 100 are read"),
        (|m| m.joints[0].centre = 1e308, "q1 moves by 1e308 rad (m)"),
    ];
    for (change, sentence) in changes {
        let mut absurd = motion.clone();
        change(&mut absurd);
        std::fs::write(here.join("absurd.yaml"), absurd.to_yaml().unwrap()).unwrap();
        for command in
            [&["check", "arm.yaml", "absurd.yaml"][..], &["simulate", "arm.yaml", "absurd.yaml", "--out", "d"]]
        {
            rist(&here, command).failed(2, &[sentence]);
        }
    }
}

/// `rist check` states where each limit comes from. It also checks the limits file of the user.
#[test]
fn a_check_says_whose_limits_it_proves() {
    let (here, motion) = found("own_limits");
    let run = |arguments: &[&str]| rist(&here, &[&["check", "arm.yaml"], arguments].concat());
    let plain = run(&["motion.yaml"]).ended(0);
    let parts = [
        "position      as in the motion's file, tighter than the others",
        "velocity      as in the motion's file, tighter than the others",
        "acceleration  as in the motion's file alone",
        "jerk          as in the motion's file alone",
        "effort        as in the description",
        "power         as in the motion's file alone",
        "limit of acceleration, jerk, power: assumed by the motion's file: a limit that stands nowhere else is as ",
        "distance: not looked at, because the description has no collision geometry; ",
        "floor: not looked at, because the description has no collision geometry, ",
        "; assumed: limit of 3, margins; NOT looked at: distance, floor, approach and return\n",
        "effort and power are held to 0.9 of their limits",
    ];
    has(&plain.out, &parts);
    // If the original limits file is given, every limit is in it, and none is taken from the motion file alone.
    let whole = run(&["motion.yaml", "--limits", "made.yaml"]).told(0, &["jerk          as in the limits file"]);
    assert!(!whole.out.contains("assumed by the motion's file"), "{}", whole.out);
    assert!(
        whole.out.ends_with("; assumed: margins; NOT looked at: distance, floor, approach and return\n"),
        "{}",
        whole.out
    );

    // The motion file is changed: larger amplitudes and looser limits. Its own limits do not show this, but the limits file of
    // the user does.
    let mut loosened = motion.clone();
    let limits = &mut loosened.joints[0].limits;
    (limits.velocity, limits.acceleration, limits.jerk, limits.power) = (4.0, 1e3, 1e6, None);
    let joint = &mut loosened.joints[0];
    joint.cosine.iter_mut().chain(&mut joint.sine).for_each(|x| *x *= 1.3);
    loosened.effort_share = 1.0;
    std::fs::write(here.join("loose.yaml"), loosened.to_yaml().unwrap()).unwrap();
    let unnoticed = run(&["loose.yaml"]);
    assert!(!unnoticed.err.contains("acceleration of q1"), "{}", unnoticed.err);

    run(&["loose.yaml", "--limits", "made.yaml"]).failed(1, &["acceleration of q1: ", " is beyond "]);

    // Limits that the limits file of the user does not mention are not reported as broken. A motion file with looser limits than
    // the description is refused.
    std::fs::write(here.join("own.yaml"), "coordinates: {q2: {power: 1e-3}}\nspace: {floor: 3}\n").unwrap();
    let held = run(&["motion.yaml", "--limits", "own.yaml"]);
    assert!(held.err.contains("beyond the floor"), "{}", held.err);
    std::fs::write(here.join("own.yaml"), "coordinates: {q2: {power: 1e-3}}\n").unwrap();
    let held = run(&["motion.yaml", "--limits", "own.yaml"]).ended(1);
    assert!(held.err.contains("power of q2: ") && !held.err.contains("jerk of"), "{}", held.err);
    for (limits, said) in
        [("all: {velocity: 6}", "coordinate q1: velocity 6"), ("coordinates: {q7: {jerk: 1}}", "`q7`")]
    {
        std::fs::write(here.join("own.yaml"), limits).unwrap();
        run(&["motion.yaml", "--limits", "own.yaml"]).failed(2, &[said]);
    }
    let json = rist(&here, &["check", "arm.yaml", "motion.yaml", "--limits", "made.yaml", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json.out).unwrap();
    let rows = json["limits"].as_array().unwrap();
    let jerk = rows.iter().find(|row| row["limit"] == "jerk" && row["coordinate"] == "q2").unwrap();
    assert!(rows.len() == 12 && jerk["origin"] == "limits_file" && jerk["bounds"][1] == 150.0, "{json}");
}

/// A coordinate that the motion file calls locked must not move in it. A file with more samples than allowed is refused.
#[test]
fn a_motion_file_that_contradicts_itself_is_refused() {
    let (here, motion) = found("contradictions");
    let check = |change: &dyn Fn(&mut ExcitingMotion)| {
        let mut motion = motion.clone();
        change(&mut motion);
        std::fs::write(here.join("changed.yaml"), motion.to_yaml().unwrap()).unwrap();
        rist(&here, &["check", "arm.yaml", "changed.yaml"])
    };

    check(&|m| m.joints[1].limits.locked = Some(0.0)).failed(1, &["position of q2: ", "is beyond "]);
    check(&|m| m.repetitions = 1_000_000_000).failed(2, &["samples; at most 4e6 are taken"]);
    std::fs::write(here.join("own.yaml"), "coordinates: {q2: {locked: 0.5}}\n").unwrap();
    rist(&here, &["check", "arm.yaml", "motion.yaml", "--limits", "own.yaml"]).failed(1, &["position of q2: "]);
}
