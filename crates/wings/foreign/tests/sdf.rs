//! Tests of the SDF reader. An SDF and a URDF of the same robot give the same robot. Unsupported elements are refused, or a
//! note names them.

#[path = "../../../robot/tests/recursion/mod.rs"]
mod recursion;

use foreign::read_sdf;
use robot::Robot;
use robot::format::{AngleSnapping, Mimic, ReadOptions, read_urdf_with};

fn options() -> ReadOptions<'static> {
    ReadOptions { angles: AngleSnapping::AsGiven, ..ReadOptions::default() }
}

const URDF: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="one"><inertial><origin xyz="0.1 0.02 0.03" rpy="0.3 0.2 0.1"/><mass value="2"/>
    <inertia ixx="0.03" ixy="0.001" ixz="0.002" iyy="0.04" iyz="0.003" izz="0.05"/></inertial></link>
  <link name="two"><inertial><origin xyz="0 0.1 0.2"/><mass value="1.5"/>
    <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>
  <link name="tool"><inertial><origin xyz="0.05 0 0"/><mass value="0.4"/>
    <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.003"/></inertial></link>
  <link name="three"><inertial><origin xyz="0.02 0 0"/><mass value="0.3"/>
    <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="one"/><origin xyz="0.1 0.2 0.3" rpy="0.4 -0.5 0.6"/>
    <axis xyz="0 0.6 0.8"/><limit lower="-1" upper="2" effort="30" velocity="4"/><dynamics damping="0.7" friction="0.2"/></joint>
  <joint name="slide" type="prismatic"><parent link="one"/><child link="two"/><origin xyz="0.3 0 0.1" rpy="0 0.7 0"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.5" effort="10" velocity="1"/></joint>
  <joint name="weld" type="fixed"><parent link="two"/><child link="tool"/><origin xyz="0 0 0.2" rpy="0 0 0.3"/></joint>
  <joint name="wrist" type="revolute"><parent link="tool"/><child link="three"/><origin xyz="0 0.1 0"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="5" velocity="9"/><mimic joint="turn" multiplier="-2" offset="0.1"/></joint>
</robot>"#;

/// The robot with frames relative to each other, and axes in other frames.
const SDF: &str = r#"<?xml version="1.0"?>
<sdf version="1.9"><world name="w"><gravity>0 0 -9.81</gravity><model name="arm">
  <link name="base"/>
  <frame name="mount" attached_to="base"><pose degrees="true">0.1 0.2 0.3 22.918311805232932 -28.64788975654116 34.37746770784939</pose></frame>
  <joint name="hold" type="fixed"><parent>world</parent><child>base</child></joint>
  <link name="one"><pose relative_to="mount"/><inertial><pose>0.1 0.02 0.03 0.3 0.2 0.1</pose><mass>2</mass>
    <inertia><ixx>0.03</ixx><ixy>0.001</ixy><ixz>0.002</ixz><iyy>0.04</iyy><iyz>0.003</iyz><izz>0.05</izz></inertia></inertial></link>
  <joint name="turn" type="revolute"><parent>mount</parent><child>one</child><axis><xyz expressed_in="mount">0 0.6 0.8</xyz>
    <limit><lower>-1</lower><upper>2</upper><effort>30</effort><velocity>4</velocity></limit>
    <dynamics><damping>0.7</damping><friction>0.2</friction></dynamics></axis></joint>
  <link name="two"><pose relative_to="slide">0 0 -0.05 0 0 0</pose><inertial><pose>0 0.1 0.25 0 0 0</pose><mass>1.5</mass>
    <inertia><ixx>0.02</ixx><ixy>0</ixy><ixz>0</ixz><iyy>0.02</iyy><iyz>0</iyz><izz>0.01</izz></inertia></inertial></link>
  <joint name="slide" type="prismatic"><pose relative_to="one">0.3 0 0.1 0 0.7 0</pose><parent>one</parent><child>two</child>
    <axis><xyz>2 0 0</xyz><limit><lower>0</lower><upper>0.5</upper><effort>10</effort><velocity>1</velocity></limit></axis></joint>
  <link name="tool"><pose relative_to="two" rotation_format="quat_xyzw">0 0 0.25 0 0 0.14943813247359922 0.9887710779360422</pose>
    <inertial><pose>0.05 0 0 0 0 0</pose><mass>0.4</mass>
    <inertia><ixx>0.001</ixx><iyy>0.002</iyy><izz>0.003</izz></inertia></inertial></link>
  <joint name="weld" type="fixed"><parent>two</parent><child>tool</child></joint>
  <link name="three"><pose relative_to="tool">0 0.1 0 0 0 0</pose><inertial><pose>0.02 0 0 0 0 0</pose><mass>0.3</mass>
    <inertia><ixx>0.001</ixx><iyy>0.001</iyy><izz>0.001</izz></inertia></inertial></link>
  <joint name="wrist" type="revolute"><parent>tool</parent><child>three</child><axis><xyz>0 1 0</xyz>
    <limit><lower>-3</lower><upper>3</upper><effort>5</effort><velocity>9</velocity></limit>
    <mimic joint="turn"><multiplier>-2</multiplier><offset>0.5</offset><reference>-0.2</reference></mimic></axis></joint>
</model></world></sdf>"#;

fn read(text: &str) -> Robot {
    read_sdf(text, "arm.sdf", options()).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn refused(text: &str) -> String {
    read_sdf(text, "arm.sdf", options()).map(|robot| robot.name).unwrap_err().to_string()
}

fn same_torque(sdf: &Robot, urdf: &Robot) {
    assert_eq!(sdf.coordinates, urdf.coordinates);
    let n = urdf.n_coordinates();
    for seed in 1..4 {
        let state = |k: usize| -> Vec<f64> { (0..n).map(|i| (1.7 * (seed * (i + 3) + k) as f64).sin()).collect() };
        let (q, dq, ddq) = (state(0), state(5), state(9));
        let expected = recursion::torque(urdf, &q, &dq, &ddq);
        for (a, b) in recursion::torque(sdf, &q, &dq, &ddq).iter().zip(expected) {
            // Allowance for the rounding of some hundred operations on torques of 30 N m, and of a quaternion with 17 digits.
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }
}

#[test]
fn an_sdf_is_the_robot_of_its_urdf() {
    let (sdf, urdf) = (read(SDF), read_urdf_with(URDF, "arm.urdf", options()).unwrap());
    same_torque(&sdf, &urdf);
    let names = |robot: &Robot| robot.links.iter().map(|link| link.name.clone()).collect::<Vec<_>>();
    assert_eq!((names(&sdf), sdf.name.as_str()), (names(&urdf), "arm"));
    assert_eq!(sdf.links[0].joint.friction, urdf.links[0].joint.friction);
    assert!(sdf.notes.iter().all(|note| note.subject == "base"), "{:?}", sdf.notes);
    let free = ReadOptions { mimic: Mimic::Independent, ..options() };
    same_torque(&read_sdf(SDF, "arm.sdf", free).unwrap(), &read_urdf_with(URDF, "arm.urdf", free).unwrap());
}

/// Before version 1.7, poses are in the frame of the model. Axes are in this frame too if the version or an element says so.
#[test]
fn poses_and_axes_of_old_versions_are_of_the_model() {
    let body = "<inertial><pose>0.1 0.2 0 0 0 0</pose><mass>1</mass><inertia><ixx>0.1</ixx><iyy>0.2</iyy><izz>0.3</izz></inertia></inertial>";
    let axis = |version: &str, xyz: &str, more: &str| {
        format!(
            "<sdf version='{version}'><model name='m'><pose>0 0 1 0 0 0</pose><link name='a'><pose>0 0 0.5 0 0 0</pose></link>\
             <link name='b'><pose>0.1 0 0.7 0 0 1.5707963267948966</pose>{body}</link><joint name='j' type='revolute'>\
             <parent>a</parent><child>b</child><axis><xyz>{xyz}</xyz>{more}<limit><lower>-1e16</lower><upper>1e16</upper></limit></axis>\
             </joint></model></sdf>"
        )
    };
    let urdf = "<robot name='m'><link name='a'/><link name='b'><inertial><origin xyz='0.1 0.2 0'/><mass value='1'/><inertia ixx='0.1' \
                ixy='0' ixz='0' iyy='0.2' iyz='0' izz='0.3'/></inertial></link><joint name='j' type='continuous'><parent link='a'/>\
                <child link='b'/><origin xyz='0.1 0 0.2' rpy='0 0 1.5707963267948966'/><axis xyz='1 0 0'/></joint></robot>";
    let urdf = read_urdf_with(urdf, "m.urdf", options()).unwrap();
    let of_model = "<use_parent_model_frame>true</use_parent_model_frame>";
    for text in
        [axis("1.4", "0 1 0", ""), axis("1.6", "0 1 0", of_model), axis("1.6", "1 0 0", ""), axis("1.11", "1 0 0", "")]
    {
        same_torque(&read(&text), &urdf);
    }
    let robot = read(&axis("1.6", "1 0 0", ""));
    assert!(
        robot.notes.iter().any(|n| n.subject == "base" && n.text.contains("no joint holds `a`")),
        "{:?}",
        robot.notes
    );
    assert!(robot.notes.iter().any(|n| n.subject == "a" && n.text.contains("has no inertial")), "{:?}", robot.notes);
    // If the base floats, the frame of the base is the frame of the root link.
    let floating = ReadOptions { floating_base: true, ..options() };
    let floats = read_sdf(
        &axis("1.6", "1 0 0", "").replace("</pose></link>", &format!("</pose>{body}</link>")),
        "m.sdf",
        floating,
    );
    let floats = floats.unwrap();
    assert_eq!((floats.base.inertial.unwrap()[9], floats.floating().n_coordinates()), (1.0, 7));
    assert!(floats.notes.iter().all(|note| note.subject != "base"));
}

#[test]
fn what_is_not_read_is_said() {
    let with = |what: &str| read(&SDF.replace("<link name=\"base\"/>", &format!("<link name=\"base\"/>{what}")));
    let said = |robot: &Robot, text: &str| robot.notes.iter().filter(|note| note.text.contains(text)).count();
    let plain = read(SDF);
    let loop_ = "<joint name='bar' type='ball'><parent>one</parent><child>three</child></joint>";
    for (what, text) in
        [(loop_, "closes a loop at `three`"), ("<plugin name='p' filename='f'/>", "not read of the SDF: plugin")]
    {
        assert_eq!((said(&with(what), text), said(&plain, text)), (1, 0), "{what}");
        same_torque(&with(what), &plain);
    }
    let spring = SDF.replace("<damping>", "<spring_stiffness>3</spring_stiffness><damping>");
    assert_eq!((said(&read(&spring), "has a spring"), said(&plain, "has a spring")), (1, 0));
    let auto = SDF.replacen("<inertial>", "<inertial auto='true'>", 1);
    assert_eq!((said(&read(&auto), "(`auto`)"), read(&auto).links[0].inertial), (1, None));
}

#[test]
fn one_of_several_models_is_chosen() {
    let gate = "<model name='gate'><link name='a'/><link name='b'/><joint name='h' type='revolute'><parent>a</parent>\
                <child>b</child></joint></model>";
    let both = SDF.replace("</world>", &format!("{gate}<model name='box'><link name='c'/></model></world>"));
    assert!(
        refused(&both).contains("several models have joints (arm, gate): one is chosen, [root=arm]"),
        "{}",
        refused(&both)
    );
    let of = |root: &'static str| read_sdf(&both, "arm.sdf", ReadOptions { root: Some(root), ..options() });
    same_torque(&of("arm").unwrap(), &read(SDF));
    assert_eq!(of("gate").unwrap().coordinates[0].name, "h");
    assert!(of("box").unwrap_err().to_string().contains("no joint of the robot moves"));
    assert!(of("tree").unwrap_err().to_string().contains("no model `tree`; it has arm, gate, box"));
    // A model without joints is no robot, so the user need not choose between it and the robot.
    let beside = SDF.replace("</world>", "<model name='box'><link name='c'/></model></world>");
    let robot = read(&beside);
    assert!(robot.notes.iter().any(|n| n.text.contains("not read are the other models (box)")), "{:?}", robot.notes);
}

#[test]
fn what_is_no_robot_is_refused() {
    let replaced = |old: &str, new: &str| {
        assert!(SDF.contains(old), "{old}");
        refused(&SDF.replacen(old, new, 1))
    };
    for (old, new, wanted) in [
        ("</sdf>", "", "arm.sdf:"),
        ("<mass>2</mass>", "<mass>two</mass>", "arm.sdf:6: <mass> is `two`; expected are 1 finite numbers"),
        ("<mass>2</mass>", "<mass>-2</mass>", "the mass of `one` is -2 kg"),
        ("<mass>2</mass>", "<mass>1e99</mass>", "finite numbers"),
        ("relative_to=\"two\"", "relative_to=\"tow\"", "there is no frame `tow`"),
        ("relative_to=\"mount\"", "relative_to=\"three\"", "is relative to itself"),
        ("attached_to=\"base\"", "attached_to=\"mount\"", "is relative to itself"),
        ("type=\"revolute\"", "type=\"ball\"", "joint `turn` is of type `ball`"),
        ("0 0.6 0.8", "0 0 0", "the axis of joint `turn` is zero"),
        ("<parent>tool</parent>", "", "joint `wrist` has no <parent>"),
        ("<parent>tool</parent>", "<parent>three</parent>", "a link against itself"),
        ("<parent>mount</parent>", "<parent>three</parent>", "is not connected to the base"),
        ("joint=\"turn\"", "joint=\"trun\"", "mimics `trun`, which is no joint that moves (did you mean `turn`?)"),
        ("joint=\"turn\"", "joint=\"wrist\"", "run in a circle"),
        ("<link name=\"base\"/>", "<link name=\"base\"/><link name=\"base\"/>", "the name `base` stands twice"),
        ("<link name=\"base\"/>", "<link name=\"base\"/><link name=\"far\"/>", "a robot has one root, found far"),
        ("<link name=\"base\"/>", "<link name=\"base\"/><include/>", "<include> in a model is not read"),
        ("0.14943813247359922 0.9887710779360422", "0 0", "a quaternion of zeros"),
        ("<sdf version=\"1.9\">", "<sdf version=\"1.9\"><!DOCTYPE a>", "not valid XML"),
    ] {
        let message = replaced(old, new);
        assert!(message.contains(wanted), "{new}: {message}");
    }
    for text in ["", "<sdf/>", "<sdf><model/></sdf>", "<sdf><model name='m'><link/></model></sdf>", "<robot/>"] {
        assert!(read_sdf(text, "m.sdf", options()).is_err(), "{text}");
    }
    let floating = ReadOptions { floating_base: true, ..options() };
    let message = read_sdf(SDF, "arm.sdf", floating).unwrap_err().to_string();
    assert!(message.contains("holds the model to the world"), "{message}");
    let values = [("L".to_string(), 1.0)];
    assert!(read_sdf(SDF, "arm.sdf", ReadOptions { values: &values, ..options() }).is_err());
}

/// Damaged texts are read or refused; none causes a panic.
#[test]
fn damaged_texts_do_not_panic() {
    for k in (0..SDF.len()).step_by(3) {
        for cut in [1, 7, 40] {
            let end = (k + cut).min(SDF.len());
            let _ = read_sdf(&format!("{}{}", &SDF[..k], &SDF[end..]), "arm.sdf", options());
            let _ = read_sdf(&format!("{}{}", &SDF[..end], &SDF[k..]), "arm.sdf", options());
        }
    }
}
