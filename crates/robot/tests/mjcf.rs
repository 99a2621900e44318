//! Tests the MJCF reader: the torques must equal the torques of an independent Newton-Euler recursion for every form of a
//! model; unsuitable models are refused; data that are not read get notes.

mod recursion;

use robot::format::{AngleSnapping, Mimic, ReadOptions, parse_with, read_yaml};
use robot::{Drive, JointKind, Robot, RotorInertia};

fn options() -> ReadOptions<'static> {
    ReadOptions { angles: AngleSnapping::AsGiven, ..ReadOptions::default() }
}

fn read_as(text: &str, options: ReadOptions) -> Result<Robot, String> {
    parse_with(text, std::path::Path::new("arm.xml"), options).map_err(|e| e.to_string())
}

fn read(text: &str) -> Robot {
    read_as(text, options()).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn refused(text: &str) -> String {
    read_as(text, options()).map(|r| r.name).unwrap_err()
}

/// A model with one body and one hinge about its x axis. `compiler`, `body`: attributes of these elements. `inside`: the elements
/// inside the body.
fn one(compiler: &str, body: &str, inside: &str) -> String {
    format!(
        "<mujoco model=\"one\">\n<compiler {compiler}/>\n<worldbody>\n<body name=\"arm\" {body}>\n<joint name=\"turn\" \
         axis=\"1 0 0\"/>\n{inside}\n</body></worldbody></mujoco>"
    )
}

fn same(a: &Robot, b: &Robot) {
    assert_eq!(a.n_coordinates(), b.n_coordinates());
    for k in 0..4 {
        let state = |shift: f64| -> Vec<f64> {
            (0..a.n_coordinates()).map(|j| ((j + 3 * k) as f64 * 1.7 + shift).sin() * 1.3).collect()
        };
        let (q, dq, ddq) = (state(0.2), state(1.1), state(2.3));
        let (x, y) = (recursion::torque(a, &q, &dq, &ddq), recursion::torque(b, &q, &dq, &ddq));
        let scale = x.iter().fold(1e-3, |s: f64, x| s.max(x.abs()));
        for (x, y) in x.iter().zip(&y) {
            // Allowance for the rounding of two chains of frames.
            assert!((x - y).abs() <= 1e-12 * scale, "{x} {y}");
        }
    }
}

/// Each pair of models gives the same orientation, inertia or position in two different forms, so the robots must be equal.
#[test]
fn every_way_to_say_a_thing_is_the_same_robot() {
    let rod = "<inertial pos=\"0 0.1 0.2\" mass=\"2\" diaginertia=\"0.03 0.02 0.01\"/>";
    let root = 0.5f64.sqrt();
    let plain = read(&one("angle=\"radian\"", "euler=\"0 0 1.5707963267948966\"", rod));
    let turned = |body: &str| read(&one("", body, rod));
    let radians = |compiler: &str, body: &str| read(&one(&format!("angle=\"radian\" {compiler}"), body, rod));
    for other in [
        turned("euler=\"0 0 90\""),
        turned("quat=\"1 0 0 1\""),
        turned(&format!("quat=\"{root} 0 0 {root}\"")),
        turned("axisangle=\"0 0 3 90\""),
        turned("xyaxes=\"0 2 0 -1 1 0\""),
        radians("eulerseq=\"zxy\"", "euler=\"1.5707963267948966 0 0\""),
        radians("eulerseq=\"XYZ\"", "euler=\"0 0 1.5707963267948966\""),
    ] {
        same(&plain, &other);
    }
    // Intrinsic rotations in the order x y z equal extrinsic rotations in the order z y x.
    same(
        &radians("eulerseq=\"xyz\"", "euler=\"0.3 -0.4 0.5\""),
        &radians("eulerseq=\"ZYX\"", "euler=\"0.5 -0.4 0.3\""),
    );
    // `zaxis` gives z along (1, 1, 0) by the smallest rotation; `axisangle` gives the same rotation.
    same(&turned("zaxis=\"1 1 0\""), &turned("axisangle=\"-1 1 0 90\""));
    same(&turned("zaxis=\"0 0 -1\""), &turned("axisangle=\"1 0 0 180\""));
    // The same inertia is given once by principal moments with their axes, and once as a full matrix.
    let quarter = "<inertial pos=\"0 0.1 0.2\" quat=\"1 0 0 1\" mass=\"2\" diaginertia=\"0.02 0.03 0.01\"/>";
    let full = "<inertial pos=\"0 0.1 0.2\" mass=\"2\" fullinertia=\"0.03 0.02 0.01 0 0 0\"/>";
    for other in [quarter, full] {
        same(&read(&one("", "", rod)), &read(&one("", "", other)));
    }
}

/// The masses of bodies follow from their shapes. Expected values: inertials computed by hand.
#[test]
fn shapes_weigh_what_their_formulas_say() {
    let pi = std::f64::consts::PI;
    let inertial = |pos: &str, mass: f64, [xx, yy, zz]: [f64; 3]| {
        format!("<inertial pos=\"{pos}\" mass=\"{mass}\" diaginertia=\"{xx} {yy} {zz}\"/>")
    };
    let ball = |m: f64, r: f64| [0.4 * m * r * r; 3];
    let (r, h) = (0.1, 0.3);
    let (cylinder, balls) = (2.0 * pi * r * r * h, 4.0 / 3.0 * pi * r * r * r);
    let (c, b) = (3.0 * cylinder / (cylinder + balls), 3.0 * balls / (cylinder + balls));
    // Uses that the centre of mass of a half ball with radius r is at a distance of 3/8 r from its plane face.
    let across = c * (r * r / 4.0 + h * h / 3.0) + b * (0.4 * r * r + h * h + 0.75 * h * r);
    let along = c * r * r / 2.0 + b * 0.4 * r * r;
    for (geom, wanted) in [
        ("<geom size=\"0.1\" pos=\"0 0 1\" mass=\"5\"/>", inertial("0 0 1", 5.0, ball(5.0, 0.1))),
        ("<geom size=\"0.1\"/>", inertial("0 0 0", 1000.0 * balls, ball(1000.0 * balls, 0.1))),
        ("<geom type=\"box\" size=\"0.1 0.2 0.3\" density=\"100\"/>", {
            let m = 100.0 * 0.048;
            inertial("0 0 0", m, [0.13, 0.10, 0.05].map(|x| m * x / 3.0))
        }),
        ("<geom type=\"ellipsoid\" size=\"0.1 0.2 0.3\" mass=\"2\"/>", inertial("0 0 0", 2.0, [0.052, 0.04, 0.02])),
        ("<geom type=\"cylinder\" size=\"0.1 0.3\" mass=\"3\"/>", inertial("0 0 0", 3.0, [0.0975, 0.0975, 0.015])),
        ("<geom type=\"capsule\" fromto=\"0 0 0.7 0 0 0.1\" size=\"0.1\" mass=\"3\"/>", {
            inertial("0 0 0.4", 3.0, [across, across, along])
        }),
        ("<geom type=\"capsule\" fromto=\"0 0.1 0 0 0.7 0\" size=\"0.1\" mass=\"3\"/>", {
            inertial("0 0.4 0", 3.0, [across, along, across])
        }),
        // The second shape is in a group outside of `inertiagrouprange`, so its mass does not count. A plane never has a mass.
        (
            "<geom size=\"0.1\" mass=\"5\"/><geom size=\"9\" mass=\"1\" group=\"3\"/><geom type=\"plane\" size=\"1 1 1\"/>",
            inertial("0 0 0", 5.0, ball(5.0, 0.1)),
        ),
    ] {
        same(&read(&one("inertiagrouprange=\"0 2\"", "", geom)), &read(&one("", "", &wanted)));
    }
    let both = "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/><geom size=\"0.1\" mass=\"5\"/>";
    let of_shape = read(&one("", "", &inertial("0 0 0", 5.0, ball(5.0, 0.1))));
    same(&read(&one("inertiafromgeom=\"true\"", "", both)), &of_shape);
    assert_eq!(read(&one("", "", both)).links[0].inertial.unwrap()[9], 1.0);
    let x = |compiler: &str, inside: &str| read(&one(compiler, "", inside)).links[0].inertial.unwrap();
    let thin = inertial("0 0 0", 0.5, [0.1, 0.2, 0.9]);
    assert!((x("balanceinertia=\"true\"", &thin)[0] - 0.4).abs() < 1e-15);
    // The z axis of the link frame is the joint axis, which is the x axis of the body.
    assert_eq!(x("boundmass=\"2\" boundinertia=\"0.15\"", &thin)[..6], [0.2, 0.0, 0.0, 0.9, 0.0, 0.15]);
    assert_eq!((x("boundmass=\"2\"", &thin)[9], x("settotalmass=\"4\"", &thin)[9]), (2.0, 4.0));
    assert!((x("settotalmass=\"4\"", &thin)[3] - 7.2).abs() < 1e-14);
}

#[test]
fn a_mesh_weighs_by_what_it_encloses() {
    let corners: Vec<String> =
        (0..8).map(|k: u8| format!("{} {} {}", 2 * (k & 1), (k >> 1 & 1) * 2, (k >> 2 & 1) * 2)).collect();
    let faces = "0 2 3 0 3 1 4 5 7 4 7 6 0 1 5 0 5 4 2 6 7 2 7 3 0 4 6 0 6 2 1 3 7 1 7 5";
    for how in ["legacy", "exact"] {
        let text = one("", "", "<geom type=\"mesh\" mesh=\"m\" density=\"10\" pos=\"0 0 1\"/>").replace(
            "<worldbody>",
            &format!(
                "<asset><mesh name=\"m\" inertia=\"{how}\" scale=\"0.1 0.2 0.3\" refpos=\"1 1 1\" vertex=\"{}\" face=\"{faces}\"/>\
                 </asset><worldbody>",
                corners.join(" ")
            ),
        );
        let cuboid = one("", "", "<geom type=\"box\" size=\"0.1 0.2 0.3\" density=\"10\" pos=\"0 0 1\"/>");
        same(&read(&text), &read(&cuboid));
    }
}

const ARM: &str = r#"<mujoco model="arm">
  <compiler angle="radian"/>
  <default>
    <joint damping="0.1"/>
    <default class="wrist"><joint axis="0 1 0" armature="0.02" range="-1 2"/>
      <default class="soft"><joint frictionloss="0.3" damping="0.7"/></default></default>
    <motor ctrlrange="-2 2"/>
  </default>
  <worldbody>
    <body name="shoulder" pos="0 0 0.5" childclass="wrist">
      <inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.02 0.03"/>
      <joint name="pan" axis="0 0 1" class="main"/>
      <joint name="lift" pos="0.05 0 0.1"/>
      <frame pos="0.3 0 0" euler="0 0 0.4" childclass="soft">
        <body name="hand" pos="0 0 0.1">
          <joint name="reach" type="slide" axis="0.6 0 0.8" ref="0.2"/>
          <joint name="bend"/>
          <geom size="0.05" mass="0.4"/>
          <body name="tip" pos="0 0 0.2"><geom size="0.02" mass="0.1"/></body>
        </body>
      </frame>
    </body>
  </worldbody>
  <actuator><motor joint="pan" gear="50"/><position joint="lift" forcerange="-9 8"/></actuator>
  <sensor><jointpos joint="pan"/></sensor>
  <tendon><fixed><joint joint="pan" coef="1"/></fixed></tendon>
</mujoco>"#;

#[test]
fn joints_take_what_their_classes_and_actuators_say() {
    let robot = read(ARM);
    let names: Vec<&str> = robot.coordinates.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["pan", "lift", "reach", "bend"]);
    let joint = |k: usize| &robot.links[k].joint;
    assert_eq!((joint(0).friction.viscous, joint(0).rotor_inertia), (Some(0.1), RotorInertia::Absent));
    assert_eq!((joint(1).friction.viscous, joint(1).rotor_inertia), (Some(0.1), RotorInertia::Known(0.02)));
    assert_eq!((joint(2).friction.viscous, joint(2).friction.coulomb), (Some(0.7), Some(0.3)));
    assert_eq!((joint(2).kind, joint(3).kind), (JointKind::Prismatic, JointKind::Revolute));
    let limits = |k: usize| robot.coordinates[k].limits;
    assert_eq!((limits(0).position, limits(0).effort), (None, Some(100.0)));
    assert_eq!((limits(1).position, limits(1).effort), (Some((-1.0, 2.0)), Some(9.0)));
    // Links without a mass have known parameters: all are zero.
    assert_eq!(robot.links[0].inertial, Some([0.0; 10]));
    assert_eq!((robot.links[0].name.as_str(), robot.links[1].name.as_str()), ("shoulder_pan", "shoulder"));
    let parts: Vec<&str> = robot.links[3].parts.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(parts, ["hand", "tip"]);
    let notes: Vec<String> = robot.notes.iter().map(|n| format!("{}: {}", n.subject, n.text)).collect();
    let has = |text: &str| notes.iter().filter(|n| n.contains(text)).count();
    assert_eq!(has("sensor, tendon in the file: not read"), 1, "{notes:?}");
    let gears = "actuators: have gears in the file (pan 50): of a log with positions and torques of the motors say \
                 `transmission: {ratios: [50, 1, 1, 1]}`";
    assert_eq!(has(gears), 1, "{notes:?}");
}

/// Two joints in one body give the same robot as one joint each in two nested bodies. `ref` shifts the coordinate.
#[test]
fn several_joints_of_a_body_move_it_one_after_the_other() {
    let nested = r#"<mujoco><compiler angle="radian"/><worldbody>
      <body pos="0 0 0.5"><joint name="pan" axis="0 0 1"/><geom size="1e-3" mass="1e-300"/>
        <body pos="0.05 0 0.1"><joint name="lift" axis="0 1 0" armature="0.02"/>
          <inertial pos="0.05 0 -0.1" mass="1" diaginertia="0.01 0.02 0.03"/>
          <body pos="0.25 0 -0.1" euler="0 0 0.4"><body pos="0 0 0.1">
            <joint name="reach" type="slide" axis="0.6 0 0.8" armature="0.02"/><geom size="1e-3" mass="1e-300"/>
            <body><joint name="bend" axis="0 1 0" armature="0.02"/><geom size="0.05" mass="0.4"/>
              <geom pos="0 0 0.2" size="0.02" mass="0.1"/></body></body></body></body></body></worldbody></mujoco>"#;
    let (arm, nested) = (read(ARM), read(nested));
    let (q, dq, ddq) = ([0.3, -0.7, 0.4, 1.1], [1.2, 0.5, -0.8, 0.9], [0.1, -2.0, 3.0, 0.7]);
    let (mut shifted, tau) = (q, recursion::torque(&arm, &q, &dq, &ddq));
    shifted[2] -= 0.2;
    for (a, b) in tau.iter().zip(recursion::torque(&nested, &shifted, &dq, &ddq)) {
        assert!((a - b).abs() < 1e-13, "{a} {b}");
    }
}

#[test]
fn a_joint_equality_is_a_joint_that_follows() {
    let tied = |equality: &str| ARM.replace("<sensor>", &format!("<equality>{equality}</equality><sensor>"));
    let text = tied("<joint joint1=\"bend\" joint2=\"reach\" polycoef=\"0.1 -3 0 0 0\"/>");
    let (robot, free) = (read(&text), read(ARM));
    assert_eq!((robot.n_coordinates(), robot.links[3].joint.drive), (3, Drive::Passive));
    let (q, dq, ddq) = ([0.3, -0.7, 0.4], [1.2, 0.5, -0.8], [0.1, -2.0, 3.0]);
    // The equality means bend = 0.1 - 3 (reach - 0.2), because `reach` has the `ref` 0.2.
    let all = |v: [f64; 3], offset: f64| [v[0], v[1], v[2], -3.0 * v[2] + offset];
    let whole = recursion::torque(&free, &all(q, 0.7), &all(dq, 0.0), &all(ddq, 0.0));
    let found = recursion::torque(&robot, &q, &dq, &ddq);
    let wanted = [whole[0], whole[1], whole[2] - 3.0 * whole[3]];
    for (a, b) in found.iter().zip(wanted) {
        assert!((a - b).abs() < 1e-13, "{a} {b}");
    }
    let held = read(&tied("<joint joint1=\"bend\" polycoef=\"0.5\"/>"));
    assert_eq!((held.n_coordinates(), held.links[3].joint.drive), (3, Drive::Locked));
    let independent = ReadOptions { mimic: Mimic::Independent, ..options() };
    assert_eq!(read_as(&text, independent).unwrap().n_coordinates(), 4);
    let curve = refused(&tied("<joint joint1=\"bend\" joint2=\"reach\" polycoef=\"0 1 2\"/>"));
    assert!(curve.contains("ties `bend` to `reach` by a curve") && curve.contains("[mimic=independent]"), "{curve}");
    let weld = read(&tied("<weld name=\"w\" body1=\"tip\"/>"));
    assert!(weld.notes.iter().any(|n| n.subject == "weld `w`" && n.text.contains("is not read")), "{:?}", weld.notes);
}

/// A four-bar in MJCF and in YAML: at the same crank angle, the links have the same poses.
#[test]
fn a_connect_in_a_plane_is_a_loop() {
    let text = r#"<mujoco><worldbody>
  <body name="crank"><joint name="drive" axis="0 0 1"/><inertial pos="0.1 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
    <body name="coupler" pos="0 0.2 0"><joint name="c" axis="0 0 1"/><inertial pos="0.3 0 0" mass="1" diaginertia="0.1 0.1 0.1"/></body></body>
  <body name="rocker" pos="0.5 0 0"><joint name="r" axis="0 0 1"/><inertial pos="0 0.1 0" mass="1" diaginertia="0.1 0.1 0.1"/></body>
  </worldbody>
  <equality><connect name="pin" body1="coupler" body2="rocker" anchor="0.6 0.1 0"/></equality>
  <actuator><motor joint="drive"/></actuator></mujoco>"#;
    let robot = read(text);
    // Three angles are unknown: the undriven joints c and r, and the hinge of the `<connect>`. The sum of the angles around the
    // loop determines one of them, so two passive coordinates remain.
    assert_eq!((robot.n_coordinates(), robot.passive.len(), robot.loops.len()), (1, 2, 1));
    assert!(robot::closure::largest_gap(&robot, &robot.loops[0]).position > 0.1, "it closes at some places only");
    let parallelogram = read(&text.replace("anchor=\"0.6 0.1 0\"", "anchor=\"0.5 0 0\""));
    // Opposite sides of the loop are equal, so it is a parallelogram: the rocker has the angle of the crank, and nothing is
    // solved numerically.
    assert!(parallelogram.passive.is_empty(), "{:?}", parallelogram.passive);
    let yaml = read_yaml(
        "convention: khalil-kleinfinger\nname: p\nlinks:\n  - {link: 1, antecedent: base, theta: q1}\n  - {link: 2, antecedent: \
         base, d: 0.5, theta: q1, drive: passive}\n",
        "p.yaml",
    )
    .unwrap();
    let rocker = parallelogram.links.iter().position(|l| l.name == "rocker").unwrap();
    for q in [0.0, 0.4, -1.3] {
        let frame = parallelogram.link_poses(&[q])[rocker].compose(&parallelogram.links[rocker].file_frame);
        let wanted = yaml.link_poses(&[q])[1];
        for i in 0..3 {
            assert!((frame.rotation[i][0] - wanted.rotation[i][0]).abs() < 1e-12, "{q}: {frame:?} {wanted:?}");
        }
    }
    let spatial = read(&text.replace("<joint name=\"r\" axis=\"0 0 1\"/>", "<joint name=\"r\" axis=\"0 1 1\"/>"));
    assert!(spatial.loops.is_empty());
    assert!(spatial.notes.iter().any(|n| n.subject == "connect `pin`" && n.text.contains("cut open")));
}

#[test]
fn what_floats_is_asked_for() {
    let text = r#"<mujoco><worldbody><geom type="plane" size="1 1 1"/>
  <body name="trunk"><freejoint name="root"/><geom size="0.2" mass="9"/>
    <body name="leg"><joint name="hip"/><geom size="0.1" mass="1"/></body></body>
  <body name="ball"><freejoint/><geom size="0.1" mass="1"/></body></worldbody></mujoco>"#;
    assert!(refused(text).contains("arm.xml:2:22: the body is free to move"), "{}", refused(text));
    let robot = read_as(text, ReadOptions { floating_base: true, ..options() }).unwrap();
    assert_eq!((robot.n_coordinates(), robot.base.inertial.unwrap()[9]), (1, 9.0));
    assert!(robot.notes.iter().any(|n| n.text.contains("left out (ball)")), "{:?}", robot.notes);
    assert_eq!(robot.floating().n_coordinates(), 7);
    // Without the free joint, the arm is fixed to the ground. A separate floating object in the model is then ignored.
    let arm = text.replace("<freejoint name=\"root\"/>", "");
    assert_eq!(read(&arm).n_coordinates(), 1);
}

/// If a model has several robots, one of them can be read alone, with the option that the error message names.
#[test]
fn one_of_several_robots_is_chosen() {
    let text = r#"<mujoco><worldbody><body name="table"><geom size="1" mass="50"/></body>
  <body name="trunk"><freejoint/><geom size="0.2" mass="9"/>
    <body name="leg"><joint name="hip"/><geom size="0.1" mass="1"/></body></body>
  <body name="door"><joint name="hinge" axis="0 1 0"/><geom pos="1 0 0" size="0.1" mass="2"/></body></worldbody></mujoco>"#;
    let floating = ReadOptions { floating_base: true, ..options() };
    let message = read_as(text, floating).unwrap_err().to_string();
    assert!(message.contains("`trunk` floats while other joints hang on the world (door)"), "{message}");
    assert!(message.ends_with("[root=trunk]"), "{message}");
    let names = |robot: &Robot| robot.coordinates.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    let trunk = read_as(text, ReadOptions { root: Some("trunk"), ..floating }).unwrap();
    assert_eq!((names(&trunk), trunk.base.inertial.unwrap()[9]), (vec!["hip".to_string()], 9.0));
    let said = |robot: &Robot| robot.notes.iter().filter(|n| n.text.contains("not read are the other bodies")).count();
    assert_eq!(said(&trunk), 1, "{:?}", trunk.notes);
    // A robot that is fixed to the ground needs no floating base. Other objects that are fixed to the ground belong to its
    // base.
    let door = read_as(text, ReadOptions { root: Some("door"), ..options() }).unwrap();
    assert_eq!((names(&door), door.base.inertial.unwrap()[9], said(&door)), (vec!["hinge".to_string()], 50.0, 1));
    let message = read_as(text, ReadOptions { root: Some("table"), ..options() }).unwrap_err().to_string();
    assert!(message.contains("[root]: the world has no body `table` that moves; it has trunk, door"), "{message}");
    let two =
        text.replace("<joint name=\"hinge\" axis=\"0 1 0\"/>", "<freejoint/><body><joint/><geom size=\"1\"/></body>");
    let message = read_as(&two, floating).unwrap_err().to_string();
    assert!(message.contains("several robots float (trunk, door)") && message.ends_with("[root=trunk]"), "{message}");
    let one = read_as(&two, ReadOptions { root: Some("trunk"), ..floating }).unwrap();
    assert_eq!(names(&one), ["hip"]);
    // With one robot in the file, nothing is left out.
    assert_eq!(said(&read_as(ARM, ReadOptions { root: Some("shoulder"), ..options() }).unwrap()), 0);
    let urdf = parse_with("<robot/>", std::path::Path::new("r.urdf"), ReadOptions { root: Some("a"), ..options() });
    assert!(urdf.unwrap_err().to_string().contains("[root] chooses a robot of an MJCF"));
}

/// A shape that is fitted to a mesh needs no size. If its body has no inertial, the mass of the body is not known.
#[test]
fn a_shape_fitted_to_a_mesh_has_no_size() {
    let text = r#"<mujoco><asset><mesh name="m" file="m.obj"/></asset><worldbody><body name="arm"><joint name="j"/>
  <inertial pos="0.2 0 0" mass="2" diaginertia="0.02 0.02 0.01"/><geom type="capsule" mesh="m"/></body></worldbody></mujoco>"#;
    assert_eq!(read(text).links[0].inertial.unwrap()[9], 2.0);
    let message = refused(&text.replace("mesh=\"m\"/></body>", "/></body>"));
    assert!(message.contains("a capsule has 2 sizes above 0"), "{message}");
    let start = text.find("<inertial").unwrap();
    let end = text.find("<geom").unwrap();
    let message = refused(&format!("{}{}", &text[..start], &text[end..]));
    assert!(message.contains("fitted to a mesh, which is not read; or give the body an <inertial>"), "{message}");
}

/// Meshes and included files outside the folder of the model are read only if they are in the folder of a given package.
#[test]
fn a_package_allows_another_folder() {
    let here = std::env::temp_dir().join(format!("rist-mjcf-package-{}", std::process::id()));
    std::fs::create_dir_all(here.join("mjcf")).unwrap();
    std::fs::create_dir_all(here.join("meshes")).unwrap();
    let put = |name: &str, text: &str| std::fs::write(here.join(name), text).unwrap();
    put("meshes/m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    put("meshes/part.xml", "<mujocoinclude><asset><mesh name=\"m\" file=\"m.obj\"/></asset></mujocoinclude>");
    put(
        "mjcf/robot.xml",
        "<mujoco><compiler meshdir=\"../meshes\"/><include file=\"../meshes/part.xml\"/><worldbody><body name=\"arm\"><joint/>\
         <geom type=\"mesh\" mesh=\"m\"/></body></worldbody></mujoco>",
    );
    let path = here.join("mjcf/robot.xml");
    let message = robot::format::read_with(&path, options()).unwrap_err().to_string();
    let remedy = format!("[package=meshes={}]", here.join("mjcf/../meshes").display());
    assert!(message.contains("nothing is read without leave") && message.contains(&remedy), "{message}");
    // The package has the folder that the error message proposes.
    let packages = [("meshes".to_string(), here.join("mjcf/../meshes"))];
    let robot = robot::format::read_with(&path, ReadOptions { packages: &packages, ..options() }).unwrap();
    let mass = robot.links[0].inertial.unwrap()[9];
    assert!((mass - 1000.0 / 6.0).abs() < 1e-9, "{mass}");
    // The text that a writer gets has the content of an included file in place of its `<include>`.
    let text = std::fs::read_to_string(&path).unwrap();
    let written = |packages| {
        robot::format::without_macros(&text, &path, ReadOptions { packages, ..options() }).map_err(|e| e.to_string())
    };
    let part = "<include file=\"../meshes/part.xml\"/>";
    assert_eq!(written(&packages).unwrap(), text.replace(part, "<asset><mesh name=\"m\" file=\"m.obj\"/></asset>"));
    assert!(written(&[]).unwrap_err().contains("nothing is read without leave"));
    let others = [("others".to_string(), here.join("mjcf"))];
    assert!(robot::format::read_with(&path, ReadOptions { packages: &others, ..options() }).is_err());
    std::fs::remove_dir_all(&here).unwrap();
}

#[test]
fn what_is_not_read_is_named() {
    let body = |inside: &str| one("", "", inside);
    let deep = format!("<mujoco>{}{}</mujoco>", "<body>".repeat(400), "</body>".repeat(400));
    for (text, place, wanted) in [
        (body("<joint name=\"b\" type=\"ball\"/>"), "arm.xml:6:1", "is a ball"),
        (body("<replicate count=\"3\"/>"), "arm.xml:6:1", "mj_saveLastXML"),
        (body("<inertail mass=\"1\"/>"), "arm.xml:6:1", "did you mean <inertial>?"),
        (body("<inertial pos=\"0 0 0\" mas=\"1\"/>"), "arm.xml:6:1", "did you mean `mass`?"),
        (body("<geom type=\"bocks\"/>"), "arm.xml:6:1", "expected: sphere, capsule"),
        (body("<geom type=\"box\" size=\"1 1\"/>"), "arm.xml:6:1", "a box has 3 sizes above 0"),
        (body("<geom size=\"1\" class=\"nine\"/>"), "arm.xml:6:1", "no <default> has the class `nine`"),
        (body("<geom size=\"one\"/>"), "arm.xml:6:1", "holds `one`, which is no number"),
        (body("<geom type=\"mesh\" mesh=\"m\"/>"), "arm.xml:6:1", "there is no mesh `m`"),
        (body("<joint name=\"turn\"/>"), "arm.xml:6:1", "joint `turn` stands twice, first on line 5"),
        (body("<body name=\"arm\"/>"), "arm.xml:6:1", "body `arm` stands twice, first on line 4"),
        (one("coordinate=\"global\"", "", ""), "arm.xml:2:1", "with an older MuJoCo"),
        (one("eulerseq=\"abc\"", "", ""), "arm.xml:2:1", "three of the letters"),
        (one("", "quat=\"0 0 0 0\"", ""), "arm.xml:4:1", "is zero"),
        (one("", "quat=\"1 0 0 0\" euler=\"1 2 3\"", ""), "arm.xml:4:1", "one of them"),
        ("<mujoco/>".into(), "arm.xml:1:1", "describes no robot"),
        ("<mujocoinclude/>".into(), "arm.xml", "give the file with <mujoco> that includes it"),
        ("<sdf/>".into(), "arm.xml", "SDF is not read"),
        (deep, "arm.xml:1", "deep in each other"),
    ] {
        let message = refused(&text);
        assert!(message.starts_with(place) && message.contains(wanted), "{message}");
    }
}

/// A robot with one joint about y. Without rotors, M11 = 0.01 + 1 * 0.1^2 = 0.02 kg m^2. The actuators add rotor inertias.
fn geared(joint: &str, actuators: &str) -> Robot {
    read(&format!(
        "<mujoco><default><pid armature=\"3\"/></default><worldbody><body name=\"a\"><joint name=\"j\" axis=\"0 1 0\" {joint}/>
<inertial pos=\".1 0 0\" mass=\"1\" diaginertia=\".01 .01 .01\"/></body></worldbody><actuator>{actuators}</actuator></mujoco>"
    ))
}

/// Expected M11: 0.02 + armature of the joint + sum of gear^2 times armature of the actuators; damping in the same way. MuJoCo
/// 4.0 gives 0.31 and 0.7 for the first case.
#[test]
fn an_actuator_brings_its_rotor_and_its_damping() {
    let motor = "<motor joint=\"j\" gear=\"20\" armature=\"0.0005\" damping=\"0.001\"/>";
    let other = "<position joint=\"j\" kp=\"1\" gear=\"-10 2\" armature=\"0.001\"/>";
    let pid = "<pid joint=\"j\" kp=\"1\" gear=\"0.5\"/>";
    for (joint, actuators, rotor, viscous) in [
        ("armature=\".1\" damping=\".3\"", motor, 0.1 + 400.0 * 0.0005, Some(0.3 + 400.0 * 0.001)),
        ("", motor, 400.0 * 0.0005, Some(400.0 * 0.001)),
        ("", &format!("{motor}{other}"), 400.0 * 0.0005 + 100.0 * 0.001, Some(400.0 * 0.001)),
        ("", other, 100.0 * 0.001, None),
        // The `pid` actuator gets its armature of 3 from its default class.
        ("", pid, 0.25 * 3.0, None),
        ("", "<motor joint=\"j\" gear=\"0\" armature=\"2\"/>", 0.0, None),
    ] {
        let robot = geared(joint, actuators);
        let found = robot.links[0].joint.clone();
        let known = if let RotorInertia::Known(x) = found.rotor_inertia { x } else { 0.0 };
        assert!((known - rotor).abs() < 1e-15, "{actuators}: {known}");
        // A sum of two products has a rounding error of about 1e-17.
        let differ = |(a, b): (f64, f64)| (a - b).abs() > 1e-15;
        assert!(found.friction.viscous.is_some() == viscous.is_some(), "{actuators}");
        assert!(!found.friction.viscous.zip(viscous).is_some_and(differ), "{actuators}: {:?}", found.friction);
        assert!(!robot.notes.iter().any(|n| n.text.contains("not read")), "{:?}", robot.notes);
    }
    let said = |actuators: &str, text: &str| geared("", actuators).notes.iter().any(|n| n.text.contains(text));
    let polynomial = motor.replace("0.001", "0.001 0.2");
    assert!(said(&polynomial, "polynomial") && !said(motor, "polynomial"));
    let tendon = motor.replace("joint=\"j\"", "tendon=\"t\"");
    assert!(said(&tendon, "`armature` and `damping` are not read"));
    assert!(!said("<motor tendon=\"t\" gear=\"3\" armature=\"0\"/>", "are not read"));
}

/// With `inertiafromgeom`, a body keeps its `<inertial>` if its shapes have no mass, or belong to groups whose mass does not
/// count.
#[test]
fn a_body_without_a_shape_that_weighs_keeps_its_inertial() {
    let own = "<inertial pos=\"0.2 0 0\" mass=\"2\" diaginertia=\"0.02 0.02 0.01\"/>";
    let of = |compiler: &str, shape: &str| {
        let text = one(&format!("inertiafromgeom=\"true\" {compiler}"), "", &format!("{own}{shape}"));
        read(&text).links[0].inertial.unwrap()
    };
    let kept = of("", "");
    assert_eq!(kept[9], 2.0);
    for (compiler, shape) in [
        ("", "<geom size=\"0.3\" mass=\"0\"/>"),
        ("", "<geom size=\"0.3\" density=\"0\"/>"),
        ("inertiagrouprange=\"0 1\"", "<geom size=\"0.3\" group=\"2\"/>"),
    ] {
        assert_eq!(of(compiler, shape), kept, "{shape}");
    }
    // A shape with a mass replaces the `<inertial>`.
    assert_eq!(of("", "<geom size=\"0.3\" mass=\"5\"/>")[9], 5.0);
}

/// A `<joint>` of type free gets the armature of its default class, and a `<freejoint>` does not. MuJoCo uses this armature; our
/// reader does not, and adds a note.
#[test]
fn what_a_free_joint_has_of_its_class_is_named() {
    let of = |joint: &str| {
        let text = format!(
            "<mujoco><default><joint armature=\"0.1\"/></default><worldbody><body name=\"trunk\">{joint}
<inertial pos=\"0 0 0\" mass=\"2\"/><body name=\"leg\"><joint name=\"hip\" axis=\"0 1 0\"/><inertial pos=\"0 0 -0.1\" mass=\"0.5\"/>
</body></body></worldbody></mujoco>"
        );
        let robot = read_as(&text, ReadOptions { floating_base: true, ..options() }).unwrap();
        assert_eq!(robot.links[0].joint.rotor_inertia, RotorInertia::Known(0.1));
        robot.notes.iter().filter(|n| n.subject == "trunk").map(|n| n.text.clone()).collect::<String>()
    };
    let said = of("<joint name=\"root\" type=\"free\"/>");
    assert!(said.contains("`armature` 0.1 on its free joint, which is not read"), "{said}");
    assert_eq!(of("<freejoint name=\"root\"/>"), "");
    assert_eq!(of("<joint name=\"root\" type=\"free\" armature=\"0\"/>"), "");
}

#[test]
fn a_disabled_equality_ties_nothing() {
    let of = |flags: &str, active: &str| {
        read(&format!(
            "<mujoco>{flags}<worldbody><body name=\"a\"><joint name=\"j1\" axis=\"0 1 0\"/><geom size=\".1\"/>
<body name=\"b\" pos=\".3 0 0\"><joint name=\"j2\" axis=\"0 1 0\"/><geom size=\".1\"/></body></body></worldbody>
<equality><joint joint1=\"j2\" joint2=\"j1\" polycoef=\"0 2 0 0 0\" {active}/></equality></mujoco>"
        ))
    };
    let flag = |what: &str| format!("<option><flag {what}/></option>");
    for (flags, active, coordinates, said) in [
        ("".into(), "", 1, ""),
        (flag("equality=\"disable\""), "", 2, "disabled in the file (`equality` of <flag>)"),
        (flag("constraint=\"disable\""), "", 2, "disabled in the file (`constraint` of <flag>)"),
        (flag("equality=\"enable\""), "", 1, ""),
        // If there are several flags, the last one counts.
        (flag("equality=\"disable\"") + &flag("equality=\"enable\""), "", 1, ""),
        ("".into(), "active=\"false\"", 2, "not active"),
    ] {
        let robot = of(&flags, active);
        assert_eq!(robot.n_coordinates(), coordinates, "{flags}");
        let notes: String = robot.notes.iter().map(|n| n.text.clone()).collect();
        assert!(notes.contains(said) && (said.is_empty() == notes.is_empty()), "{notes}");
    }
    assert_eq!(of(&flag("gravity=\"disable\""), "").gravity_number(), [0.0; 3]);
}

#[test]
fn includes_stay_in_the_folder() {
    let folder = std::env::temp_dir().join(format!("rist-mjcf-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(folder.join("robot/parts")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    let model = |name: &str| {
        format!("<mujoco><worldbody><body name=\"a\"><joint/><include file=\"{name}\"/></body></worldbody></mujoco>")
    };
    let hand = "<mujocoinclude><geom size=\"0.1\" mass=\"3\"/><include file=\"nail.xml\"/></mujocoinclude>";
    write("robot/parts/hand.xml", hand);
    write("robot/parts/nail.xml", "<mujocoinclude><geom size=\"0.1\" mass=\"1\"/></mujocoinclude>");
    write("outside.xml", "<mujocoinclude/>");
    write("robot/self.xml", "<mujocoinclude><include file=\"self.xml\"/></mujocoinclude>");
    write("robot/bad.xml", "<mujocoinclude>\n<geom size=\"x\"/></mujocoinclude>");
    let read = |name: &str| {
        write("robot/arm.xml", &model(name));
        robot::format::read_with(&folder.join("robot/arm.xml"), options()).map_err(|e| e.to_string())
    };
    assert_eq!(read("parts/hand.xml").unwrap().links[0].inertial.unwrap()[9], 4.0);
    for (name, wanted) in [
        ("../outside.xml", "outside"),
        ("/etc/passwd", "outside"),
        ("absent.xml", "there is no"),
        ("self.xml", "includes itself"),
        ("bad.xml", "bad.xml:2:1: `size`"),
    ] {
        let message = read(name).map(|r| r.name).unwrap_err();
        assert!(message.contains(wanted), "{name}: {message}");
    }
    std::fs::remove_dir_all(folder).unwrap();
    let piped = parse_with(&model("x.xml"), std::path::Path::new("-"), options()).map(|r| r.name).unwrap_err();
    assert!(piped.to_string().contains("has no folder to include from"), "{piped}");
}
