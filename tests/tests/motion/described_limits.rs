//! Tests of limits in a URDF that do not belong to the joints of coordinates (soft limits, limits of joints that follow), and of
//! questions about suspicious numbers.

use tests::has;
use tests::program::{folder, rist};

/// An arm with unusual limits. Joint 1 has limits in degrees. Joint 2 has soft limits; a third joint follows it (mimic), three
/// times as fast, and has a low torque limit.
const ARM: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="l1"><inertial><origin xyz="0.1 0.01 0.02"/><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
  <link name="l2"><inertial><origin xyz="0.1 0.01 0.02"/><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
  <link name="f"><inertial><origin xyz="0.1 0.01 0.02"/><mass value="1"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
  <joint name="j1" type="revolute"><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/><limit lower="-900" upper="900" velocity="2" effort="90"/></joint>
  <joint name="j2" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0.3 0 0"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="2" effort="90"/>
    <safety_controller soft_lower_limit="-0.3" soft_upper_limit="3" k_position="10"/></joint>
  <joint name="jf" type="revolute"><parent link="l2"/><child link="f"/><origin xyz="0.3 0 0"/><axis xyz="0 1 0"/><limit lower="-20" upper="20" velocity="0.9" effort="0.5"/>
    <mimic joint="j2" multiplier="-3"/></joint>
</robot>"#;

/// The numbers after a key of a motion file, in the order of the file.
fn numbers(text: &str, key: &str) -> Vec<f64> {
    let behind = text.split(key).skip(1).map(|rest| rest.split([',', '}', '\n']).next().unwrap().trim());
    behind.filter_map(|number| number.parse().ok()).collect()
}

#[test]
fn limits_of_followers_soft_limits_and_turns_are_heeded() {
    let folder = folder("described-limits");
    std::fs::write(folder.join("arm.urdf"), ARM).unwrap();
    for seed in ["1", "2", "3"] {
        let excite = ["excite", "arm.urdf", "--starts", "1", "--iterations", "10", "--period", "4", "--seed", seed];
        let run = rist(&folder, &[&excite[..], &["--out", "m.yaml"]].concat()).ended(0);
        let said = run.out + &run.err;
        let parts = [
            "j1: positions from -900 to 900 rad are more than two turns: are degrees meant?",
            "j2 has soft limits (<safety_controller>): held to positions from -0.3 to 2",
            "effort of jf",
            "only a part of that joint's torque",
        ];
        has(&said, &parts);
        assert!(!said.contains("j2: positions from"), "{said}");
        let text = std::fs::read_to_string(folder.join("m.yaml")).unwrap();
        let (centres, velocities) = (numbers(&text, "centre:"), numbers(&text, "velocity:"));
        assert!(centres[0].abs() < 4.0 && centres[1] > -0.3, "{centres:?}");
        // The follower has a velocity limit of 0.9 rad/s and the multiplier 3. So its leading joint may move with 0.3 rad/s.
        assert!(velocities.contains(&2.0) && velocities.iter().any(|v| (v - 0.3).abs() < 1e-12), "{velocities:?}");
    }
}

#[test]
fn a_simulation_beyond_the_limits_says_so() {
    let folder = folder("simulated-beyond");
    std::fs::write(folder.join("arm.urdf"), ARM.replace("900", "2")).unwrap();
    let excite = ["excite", "arm.urdf", "--starts", "1", "--iterations", "10", "--period", "4"];
    rist(&folder, &[&excite[..], &["--out", "m.yaml"]].concat()).ended(0);
    let simulate = |motion: &str| {
        let run = rist(&folder, &["simulate", "arm.urdf", motion, "--out", "logs", "--validation", "0"]).ended(0);
        run.out + &run.err
    };
    let inside = simulate("m.yaml");
    assert!(!inside.contains("of the description (`rist check`)"), "{inside}");
    let text = std::fs::read_to_string(folder.join("m.yaml")).unwrap();
    let centre = text.split("centre:").nth(1).unwrap().split([',', '\n']).next().unwrap();
    std::fs::write(folder.join("far.yaml"), text.replacen(&format!("centre:{centre}"), "centre: 50", 1)).unwrap();
    let beyond = simulate("far.yaml");
    has(&beyond, &["motion: position of j1: ", " rad is beyond 2 of the description"]);
    assert!(!beyond.contains("position of j2"), "{beyond}");
}
