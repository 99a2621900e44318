//! A simulator's file, into which bodies, friction and rotor inertia are written: a URDF, and an MJCF of a known robot.
//!
//! Laws: what was written is read again, with the bodies that were written; written once more it is the same text.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rist::write_back::body::JointDynamics;
use rist::write_back::mjcf::mjcf;
use rist::write_back::mjcf_into::mjcf_into;
use rist::write_back::urdf::write_back;
use robot::format::read_urdf;
use robot::{LinkId, Robot};

/// The robot whose bodies go into an MJCF.
const ARM: &str = include_str!("../corpus/write_back/arm.urdf");

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Ok(robot) = read_urdf(text, "robot.urdf") {
        let (bodies, joints) = (bodies(&robot), joints(&robot));
        let _ = mjcf(&robot, &bodies, &joints);
        if let Ok(written) = write_back(text, "robot.urdf", &robot, &bodies, &joints) {
            let again = match read_urdf(&written.text, "again.urdf") {
                Ok(again) => again,
                Err(e) => panic!("what was written is not read: {e}\n{}", written.text),
            };
            for (id, ten) in &bodies {
                let found = again.link(*id).inertial.expect("a body that was written");
                let mut pairs = ten.iter().zip(&found);
                // A body is written about its centre of mass and moved back.
                let size = ten.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
                assert!(pairs.all(|(a, b)| (a - b).abs() <= 1e-9 * size), "{ten:?} {found:?}\n{}", written.text);
            }
        }
    }
    let arm = read_urdf(ARM, "arm.urdf").expect("the arm is read");
    let (bodies, joints) = (bodies(&arm), joints(&arm));
    if let Ok(written) = mjcf_into(text, "robot.xml", &arm, &bodies, &joints, false) {
        let again = mjcf_into(&written.text, "again.xml", &arm, &bodies, &joints, false);
        let again = again.unwrap_or_else(|e| panic!("what was written is not read: {e}\n{}", written.text));
        assert_eq!(again.text, written.text);
    }
});

/// The bodies of a description; a link without inertials is a ball of 2 kg.
fn bodies(robot: &Robot) -> Vec<(LinkId, [f64; 10])> {
    let ball = [0.02, 0.0, 0.0, 0.02, 0.0, 0.02, 0.0, 0.0, 0.0, 2.0];
    robot.link_ids().map(|id| (id, robot.link(id).inertial.unwrap_or(ball))).collect()
}

fn joints(robot: &Robot) -> Vec<JointDynamics> {
    let joint = |name: &String| JointDynamics { joint: name.clone(), damping: 0.5, friction: 0.2, armature: 0.01 };
    robot.coordinates.iter().map(|c| joint(&c.name)).collect()
}
