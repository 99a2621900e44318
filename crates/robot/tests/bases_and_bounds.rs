//! Tests of the base as a body with inertial parameters, of mimic joints without a leader, and of the range of numbers.

use robot::format::{Mimic, ReadOptions, read_urdf, read_urdf_with, read_yaml, write_yaml};

const ONE_BODY: &str = "<robot name='drone'><link name='frame'><inertial><origin xyz='0 0 0.1'/><mass value='2'/>\
    <inertia ixx='0.02' iyy='0.03' izz='0.025' ixy='0' ixz='0' iyz='0'/></inertial></link></robot>";

#[test]
fn a_root_has_a_body_and_may_be_all_there_is() {
    let refused = read_urdf(ONE_BODY, "drone.urdf").unwrap_err().to_string();
    assert!(refused.contains("[floating_base=true]"), "{refused}");
    let options = ReadOptions { floating_base: true, ..ReadOptions::default() };
    let robot = read_urdf_with(ONE_BODY, "drone.urdf", options).unwrap();
    let floating = robot.floating();
    let base = floating.links[6].inertial.unwrap();
    // A mass of 2 kg at z = 0.1 m: I_xx = 0.02 + m z^2, MZ = m z.
    for (found, wanted) in base.iter().zip([0.04, 0.0, 0.0, 0.05, 0.0, 0.025, 0.0, 0.0, 0.2, 2.0]) {
        assert!((found - wanted).abs() < 1e-15, "{base:?}");
    }
    let impossible = ONE_BODY.replace("ixx='0.02'", "ixx='-0.02'");
    let robot = read_urdf_with(&impossible, "drone.urdf", options).unwrap();
    let errors = |f: &robot::lint::Finding| f.severity() == robot::lint::Severity::Error;
    assert!(robot::lint::lint(&robot).iter().any(errors), "the root is looked at too");
}

#[test]
fn independent_mimics_need_no_leader() {
    let text = "<robot name='m'><link name='a'/><link name='b'/><joint name='j' type='continuous'><parent link='a'/>\
                <child link='b'/><axis xyz='0 0 1'/><mimic joint='absent'/></joint></robot>";
    assert!(read_urdf(text, "m.urdf").unwrap_err().to_string().contains("absent"));
    let options = ReadOptions { mimic: Mimic::Independent, ..ReadOptions::default() };
    assert_eq!(read_urdf_with(text, "m.urdf", options).unwrap().n_coordinates(), 1);
}

#[test]
fn numbers_beyond_any_robot_are_refused() {
    let yaml = |gravity: &str, d: &str| {
        let text = format!(
            "convention: khalil-kleinfinger\nname: one\ngravity: [0, 0, {gravity}]\nlinks:\n  - {{link: 1, antecedent: \
             base, d: {d}, theta: q1}}\n"
        );
        read_yaml(&text, "one.yaml").map(|_| ()).map_err(|e| e.to_string())
    };
    assert_eq!(yaml("-9.81", "0.3"), Ok(()));
    for refused in [yaml("-1e200", "0.3"), yaml("-9.81", "1e16")] {
        assert!(refused.unwrap_err().contains("no robot has a number beyond"));
    }
    let urdf = |mass: &str| read_urdf(&ONE_BODY.replace("value='2'", &format!("value='{mass}'")), "m.urdf");
    assert!(urdf("1e20").unwrap_err().to_string().contains("beyond"));
    let links: String = (0..2001).map(|k| format!("<link name='l{k}'/>")).collect();
    let many = read_urdf(&format!("<robot name='m'>{links}</robot>"), "m.urdf").unwrap_err().to_string();
    assert!(many.contains("more than 2000 links"), "{many}");
}

/// A robot is written as YAML and read again. YAML would read its names as other types (`true`, `1.0`), and it has a loop that is
/// solved numerically.
#[test]
fn what_is_written_is_read_again() {
    let text = "convention: khalil-kleinfinger\nname: fourbar\nlinks:\n  - {link: 1, antecedent: base, theta: q1}\n  - \
                {link: 2, antecedent: 1, d: 0.3, drive: passive, start: 1.0}\n  - {link: 3, antecedent: base, d: 0.5, \
                drive: passive, start: 2.0}\nloops:\n  - cut: {antecedent: 2, d: 0.4}\n    twin: {antecedent: 3, d: \
                0.35}\n";
    let mut robot = read_yaml(text, "fourbar.yaml").unwrap();
    for (name, labels) in [("true", ["null", "1.0", "0x10"]), ("1e5", ["007", "No", "1_000"])] {
        robot.name = name.into();
        for (link, label) in robot.links.iter_mut().zip(labels) {
            link.label = label.into();
            link.joint.name = label.into();
            link.name = label.into();
        }
        let written = write_yaml(&robot).0;
        let again = read_yaml(&written, "again.yaml").unwrap_or_else(|e| panic!("{e}\n{written}"));
        assert_eq!(again.name, robot.name);
        assert_eq!(again.links.iter().map(|l| l.name.as_str()).collect::<Vec<_>>(), labels);
        assert_eq!(again.passive.iter().map(|p| p.start).collect::<Vec<_>>(), [1.0, 2.0]);
    }
}

/// In a URDF, the velocity limit of a mimic joint, divided by |multiplier|, also limits its leader. Soft position limits narrow
/// the position limits of the joint.
#[test]
fn followers_and_soft_limits_narrow_a_coordinate() {
    let read = |soft: &str, velocity: &str| {
        let text = format!(
            "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>\
             <joint name='j' type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/>\
             <limit lower='-2' upper='2' velocity='2' effort='1'/>{soft}</joint>\
             <joint name='f' type='revolute'><parent link='b'/><child link='c'/><axis xyz='0 0 1'/>\
             <limit lower='-20' upper='20' velocity='{velocity}' effort='0.5'/><mimic joint='j' multiplier='-4'/></joint></robot>"
        );
        read_urdf(&text, "r.urdf").unwrap_or_else(|e| panic!("{e}"))
    };
    let both = "<safety_controller soft_lower_limit='-1' soft_upper_limit='3' k_position='1' k_velocity='1'/>";
    let gains = "<safety_controller k_velocity='10'/>";
    let nothing = "<safety_controller soft_lower_limit='-3' soft_upper_limit='3'/>";
    for (soft, low, velocity, slower) in [(both, -1.0, "2", 0.5), (gains, -2.0, "16", 2.0), (nothing, -2.0, "0", 2.0)] {
        let robot = read(soft, velocity);
        let limits = robot.coordinates[0].limits;
        assert_eq!((limits.position, limits.velocity, limits.effort), (Some((low, 2.0)), Some(slower), Some(1.0)));
        assert_eq!(robot.notes.iter().any(|note| note.text.contains("soft limits")), low == -1.0, "{:?}", robot.notes);
        assert_eq!(robot.links.iter().map(|l| l.joint.follower_effort).collect::<Vec<_>>(), [None, Some(0.5)]);
    }
}
