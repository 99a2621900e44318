//! Tests of the default clearances and of motions in narrow places. If a request is refused, the message states how many poses
//! break each limit. A remedy is printed only if the program has tried it.

use std::path::{Path, PathBuf};

use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::space_limits::Floor;
use tests::has;
use tests::program::{self, Run, folder, rist};

const QUICK: [&str; 8] = ["--starts", "2", "--iterations", "10", "--period", "5", "--repetitions", "1"];
const BODY: &str = r#"<inertial><origin xyz="0.2 0.01 0.02"/><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.04"/></inertial>"#;

/// URDF of an arm with two joints on a post. At the zero pose the ball on the forearm is 10 cm below the floor. `bend`: position
/// limits of the elbow; `more`: further links and joints.
fn arm(bend: &str, more: &str) -> String {
    format!(
        r#"<robot name="arm"><link name="post"><collision><origin xyz="0 0 0.1"/><geometry><cylinder radius="0.05" length="0.2"/></geometry></collision></link>
  <joint name="turn" type="revolute"><parent link="post"/><child link="upper"/><origin xyz="0 0 0.3"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="2" effort="100"/></joint>
  <link name="upper">{BODY}<collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.06 0.06"/></geometry></collision></link>
  <joint name="bend" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.5 0 0"/><axis xyz="0 1 0"/>
    <limit {bend} velocity="2" effort="100"/></joint>
  <link name="fore">{BODY}<collision><origin xyz="0.3 0 -0.3"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  {more}</robot>"#
    )
}

fn written(name: &str, text: &str) -> PathBuf {
    let here = folder(name);
    std::fs::write(here.join("arm.urdf"), text).unwrap();
    here
}

fn excite(here: &Path, more: &[&str]) -> Run {
    rist(here, &[&["excite", "arm.urdf", "--out", "motion.yaml"], &QUICK[..], more].concat())
}

fn motion(here: &Path) -> ExcitingMotion {
    program::motion(&here.join("motion.yaml"))
}

/// By default, a motion stays at least 2 cm above the plane of the base if possible, even if the zero pose is below the plane.
/// Links stay 2 cm apart, and joints stay 0.02 rad away from their position limits. The check proves these clearances.
#[test]
fn room_that_a_person_would_want() {
    let here = written("kept_room", &arm(r#"lower="-2.5" upper="2.5""#, ""));
    let run = excite(&here, &[]).ended(0);
    let said = run.out.replace("\n  ", " ");
    let parts = [
        "joints keep 0.02 rad, or 2 % of their room, to the ends of their positions",
        "links keep 0.02 m to each other and the floor of the base, or half of the room that they have (space: {spacing: 0.02}",
        "floor at z = 0 m",
    ];
    has(&said, &parts);
    let found = motion(&here);
    let bound = |subject: &str| found.certificate.iter().find(|row| row.subject == subject).unwrap().bound;
    assert_eq!((bound("fore at the floor"), bound("fore and post")), (0.02, 0.02));
    assert_eq!((found.space.floor, found.space.spacing), (Some(Floor::At(0.0)), Some(0.02)));
    assert_eq!(found.joints[1].limits.position, (-2.48, 2.48));
    rist(&here, &["check", "arm.urdf", "motion.yaml"]).ended(0);

    // The user can turn off each default clearance. Clearances that the user gives are used as they are.
    let limits = "margins: {tracking: 0}\nspace: {distance: 0.01, floor: none}";
    std::fs::write(here.join("limits.yaml"), limits).unwrap();
    let run = excite(&here, &["--limits", "limits.yaml"]);
    assert!(run.code == Some(0) && !run.out.contains(" keep 0.02 "), "{}{}", run.out, run.err);
    assert_eq!(
        (motion(&here).joints[1].limits.position, motion(&here).space.floor),
        ((-2.5, 2.5), Some(Floor::NOWHERE))
    );
}

#[test]
fn a_floor_that_leaves_no_motion_is_none() {
    // The ball on the forearm is always 4 to 10 cm below the plane of the base. So the plane is not used as a floor.
    let here = written("kept_no_floor", &arm(r#"lower="-0.05" upper="0.1""#, ""));
    let run = excite(&here, &[]).ended(0);
    let said = run.out.replace("\n  ", " ");
    assert!(said.contains("no floor, lowest point -0.1") && said.contains("NOT looked at: floor"), "{said}");
}

/// Two links that meet at a joint have a constant gap of 2 mm. Margins and a required distance do not apply to them, and the
/// output says so.
#[test]
fn sides_of_a_joint_need_no_margin() {
    let collar = r#"<joint name="fix" type="fixed"><parent link="upper"/><child link="collar"/></joint>
  <link name="collar"><collision><origin xyz="0 0 -0.048"/><geometry><cylinder radius="0.05" length="0.1"/></geometry></collision></link>"#;
    let here = written("kept_sides", &arm(r#"lower="-2.5" upper="0.5""#, collar));
    for limits in
        ["margins: {encoder_zero: 0.002, tracking: 0.01, calibration: 0.001, mesh: 0.0005}", "space: {distance: 0.02}"]
    {
        std::fs::write(here.join("limits.yaml"), limits).unwrap();
        let run = excite(&here, &["--limits", "limits.yaml"]).ended(0);
        let said = run.out.replace('\n', " ").replace("  ", " ");
        has(&said, &["they are the sides of one joint, and 1000 poses change their distance by less than"]);
        let own = motion(&here);
        let row = own.certificate.iter().find(|row| row.subject == "collar and post").unwrap();
        assert!(row.margin == 0.0 && (row.bound - 0.001).abs() < 1e-9, "{row:?}");
    }
}

/// If a request is refused, the message states how many poses break each limit. If the message contains a remedy (a change of
/// the limits), the request with exactly this change gives a motion. If no remedy helps, the message contains none.
#[test]
fn a_refusal_counts_and_its_remedy_was_tried() {
    // Two fingers with a largest opening of 2 cm.
    let finger = |name: &str, sign: i32| {
        format!(
            r#"<joint name="{name}_slide" type="prismatic"><parent link="fore"/><child link="{name}"/><origin xyz="0.6 0 -0.3"/><axis xyz="0 {sign} 0"/>
    <limit lower="0" upper="0.01" velocity="0.1" effort="20"/></joint>
  <link name="{name}"><inertial><mass value="0.1"/><inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial><collision><origin xyz="0 {sign}e-2 0"/><geometry><box size="0.02 0.02 0.02"/></geometry></collision></link>"#
        )
    };
    let here =
        written("kept_refusal", &arm(r#"lower="-2.5" upper="0.5""#, &(finger("left", 1) + &finger("right", -1))));
    let limits = |text: &str| std::fs::write(here.join("limits.yaml"), text).unwrap();
    limits("space: {distance: 0.03}");
    let run = excite(&here, &["--limits", "limits.yaml"]).ended(2);
    let said = &run.err;
    assert!(
        said.contains("of 300 poses within the limits 0 keep all of them") && !said.contains("no motion keeps"),
        "{said}"
    );
    assert!(said.contains("broken are distance of right and left (0.03 m) in 300"), "{said}");
    assert!(said.contains("tried, and a motion is proven: space without `distance: 0.0300`"), "{said}");
    limits("{}");
    excite(&here, &["--limits", "limits.yaml"]).ended(0);

    // The box is above the arm and cannot be reached.
    limits("space: {boxes: [{low: [-1, -1, 2], high: [1, 1, 3], links: [fore]}]}");
    let run = excite(&here, &["--limits", "limits.yaml"]).ended(2);
    let said = &run.err;
    assert!(
        said.contains("region of fore at the least z of the box (0 m) in 300") && !said.contains("tried"),
        "{said}"
    );
}

/// An impossible velocity limit is replaced by a default, and a message names the joint. A gripper whose stroke is too short for
/// its velocity limit still gets a motion.
#[test]
fn velocities_beyond_reach() {
    let fast = arm(r#"lower="-2.5" upper="2.5""#, "").replacen(r#"velocity="2""#, r#"velocity="1e6""#, 1);
    let here = written("kept_fast", &fast);
    let run = excite(&here, &[]).ended(0);
    let said = run.out.replace("\n  ", " ");
    assert!(said.contains("turn: a velocity of 1e6 rad/s is no limit, 1.0000 rad/s assumed"), "{said}");

    let gripper = r#"<joint name="grip" type="prismatic"><parent link="fore"/><child link="finger"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.02" velocity="5" effort="20"/></joint>
  <link name="finger"><inertial><mass value="0.1"/><inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial></link>"#;
    let here = written("kept_gripper", &arm(r#"lower="-2.5" upper="2.5""#, gripper));
    excite(&here, &[]).ended(0);
}

/// An arm may start folded, exactly at a position limit of the description. A start slightly beyond the limit is refused.
#[test]
fn the_way_from_a_folded_pose() {
    let here = written("kept_folded", &arm(r#"lower="-2.5" upper="0""#, ""));
    excite(&here, &["--limits", "limits.yaml"]).ended(2);
    std::fs::write(here.join("limits.yaml"), "space: {floor: none}").unwrap();
    excite(&here, &["--limits", "limits.yaml"]).ended(0);
    let play = |from: &str| {
        let asked = ["--controller", "ros2", "--limits", "limits.yaml", "--out", "way.yaml", "--from", from];
        rist(&here, &[&["play", "arm.urdf", "motion.yaml"], &asked[..]].concat())
    };
    play("turn=0.2,bend=0").ended(0);
    // A start 1e-5 rad beyond the limit is refused.
    play("turn=0.2,bend=1e-5").failed(1, &["way there: position of bend"]);
}

/// Ctrl-C ends the program during the search for a motion, during the proof, and during a plan. The robot has two arms of eight
/// joints each.
#[cfg(unix)]
#[test]
fn ctrl_c_ends_many_coordinates() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};
    let link = |side: &str, k: usize, parent: &str| {
        let axis = ["0 0 1", "0 1 0"][k % 2];
        let (y, length) = (if side == "l" { 0.4 } else { -0.4 }, if k == 0 { 0.0 } else { 0.15 });
        let origin = if k == 0 { format!("0 {y} 0.5") } else { format!("{length} 0 0.02") };
        format!(
            r#"<joint name="{side}{k}" type="revolute"><parent link="{parent}"/><child link="{side}link{k}"/><origin xyz="{origin}"/><axis xyz="{axis}"/>
  <limit lower="-2" upper="2" velocity="2" effort="200"/></joint>
  <link name="{side}link{k}">{BODY}<collision><origin xyz="0.06 0 0"/><geometry><box size="0.1 0.05 0.05"/></geometry></collision></link>"#
        )
    };
    let arms: String = ["l", "r"]
        .iter()
        .flat_map(|side| {
            (0..8).map(move |k| {
                let parent = if k == 0 { "base".into() } else { format!("{side}link{}", k - 1) };
                link(side, k, &parent)
            })
        })
        .collect();
    let here = written("kept_ctrl_c", &format!(r#"<robot name="two"><link name="base"/>{arms}</robot>"#));
    for (arguments, after) in [
        (vec!["excite", "arm.urdf", "--out", "m.yaml"], [2, 8]),
        (vec!["plan", "arm.urdf", "-n", "20", "--configurations", "20"], [2, 8]),
    ] {
        for seconds in after {
            let quiet = |command: &mut Command| command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            let mut running = quiet(Command::new(program::program()).args(&arguments).current_dir(&here));
            std::thread::sleep(Duration::from_secs(seconds));
            let asked = Instant::now();
            let id = running.id().to_string();
            assert!(
                Command::new("kill").args(["-INT", &id]).status().unwrap().success(),
                "{arguments:?} ended by itself"
            );
            while running.try_wait().unwrap().is_none() {
                // Without Ctrl-C the search runs for minutes. It ends one second after Ctrl-C on an idle machine, and later on a
                // busy one, so this is no test of a time.
                assert!(asked.elapsed() < Duration::from_secs(60), "{arguments:?} after {seconds} s");
                std::thread::sleep(Duration::from_millis(20));
            }
        }
    }
}
