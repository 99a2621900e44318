//! Writes a robot as a URDF. The link frames are Khalil's, so every joint turns about its own z axis.
//!
//! The `<origin>` of a joint is the pose iTj of its link frame j in the antecedent's frame i at q = 0. It includes the constant
//! part of the joint variable. Inertias are about the centre of mass, in the axes of the link frame. A URDF is a tree with
//! numbers: loops are cut, and symbols become their values. A joint becomes a mimic joint if it follows exactly one other joint
//! by a factor and an offset.

use crate::inertial::{Matrix3, Part, Pose};
use crate::robot::{Drive, JointKind, Limits, Link, LinkId, Note, Robot, RotorInertia};
use crate::value::CoordinateId;

/// Returns the URDF text of a robot, and notes on properties that a URDF cannot express.
pub fn write_urdf(robot: &Robot) -> (String, Vec<Note>) {
    let names = unique(robot.links.iter().map(|l| carried(&l.name)), "base");
    let joints = unique(robot.links.iter().map(|l| carried(joint_name(robot, l))), "");
    let mut writer = Writer { robot, names, joints, text: String::new(), notes: Vec::new() };
    writer.line(format!("<?xml version=\"1.0\"?>\n<robot name=\"{}\">", escaped(&carried(&robot.name))));
    writer.line("  <link name=\"base\"/>".into());
    for j in robot.link_ids() {
        writer.link(j);
        writer.joint(j);
    }
    writer.line("</robot>".into());
    writer.tell_of_the_robot();
    (writer.text, writer.notes)
}

/// The URDF text written so far, and the notes.
struct Writer<'a> {
    robot: &'a Robot,
    /// Unique names of the links, in the order of the links.
    names: Vec<String>,
    /// Unique names of the joints, in the order of the links.
    joints: Vec<String>,
    text: String,
    notes: Vec<Note>,
}

impl Writer<'_> {
    fn line(&mut self, line: String) {
        self.text += &line;
        self.text.push('\n');
    }

    fn note(&mut self, subject: &str, text: String) {
        self.notes.push(Note { subject: subject.into(), text });
    }

    /// Writes `<link>` with its `<inertial>` about the centre of mass, in the axes of the link frame.
    fn link(&mut self, j: LinkId) {
        let link = self.robot.link(j);
        self.line(format!("  <link name=\"{}\">", escaped(&self.names[j.0])));
        match link.inertial.map(|x| (x, Part::from_parameters(link.name.clone(), &x, Pose::IDENTITY.rotation))) {
            None => self.note(&link.name, "its parameters are unknown: no <inertial> is written".into()),
            Some((x, None)) => {
                if x.iter().any(|x| *x != 0.0) {
                    let text = "has inertia but no mass, which a URDF cannot say: no <inertial> is written";
                    self.note(&link.name, text.into());
                }
            }
            Some((_, Some(part))) => {
                let [x, y, z] = part.pose.position;
                let [xx, xy, xz, yy, yz, zz] = part.inertia;
                self.line("    <inertial>".into());
                self.line(format!("      <origin xyz=\"{x} {y} {z}\" rpy=\"0 0 0\"/>"));
                self.line(format!("      <mass value=\"{}\"/>", part.mass));
                let products = format!("ixy=\"{xy}\" ixz=\"{xz}\" iyy=\"{yy}\" iyz=\"{yz}\"");
                self.line(format!("      <inertia ixx=\"{xx}\" {products} izz=\"{zz}\"/>"));
                self.line("    </inertial>".into());
            }
        }
        self.line("  </link>".into());
    }

    /// Writes `<joint>`: its pose at q = 0 in the frame of its antecedent, its axis, its limits and its dynamics.
    fn joint(&mut self, j: LinkId) {
        let link = self.robot.link(j);
        let moves = !link.joint.variable.terms.is_empty() && link.joint.kind != JointKind::Fixed;
        let limits = self.limits_of(j);
        let kind = match link.joint.kind {
            _ if !moves => "fixed",
            JointKind::Prismatic => "prismatic",
            _ if range(&limits).is_some() => "revolute",
            _ => "continuous",
        };
        let pose = link.geometry.pose(&self.robot.symbols, 0.0, 0.0);
        let [x, y, z] = pose.position;
        let [roll, pitch, yaw] = roll_pitch_yaw(&pose.rotation);
        self.line(format!("  <joint name=\"{}\" type=\"{kind}\">", escaped(&self.joints[j.0])));
        self.line(format!("    <origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/>"));
        let parent = link.antecedent.map_or("base", |i| self.names[i.0].as_str());
        self.line(format!("    <parent link=\"{}\"/>", escaped(parent)));
        self.line(format!("    <child link=\"{}\"/>", escaped(&self.names[j.0])));
        if moves {
            self.axis_and_limit(j, limits);
        }
        self.dynamics(j);
        if link.joint.drive == Drive::Passive && moves {
            self.mimic(j);
        }
        self.line("  </joint>".into());
    }

    /// The limits of the coordinate that moves the joint. No limits if the joint is not actuated or several coordinates move it.
    fn limits_of(&self, j: LinkId) -> Limits {
        let joint = &self.robot.link(j).joint;
        match (joint.drive, &joint.variable.terms[..]) {
            (Drive::Actuated, [(CoordinateId(k), _)]) => {
                self.robot.coordinates.get(*k).map(|c| c.limits).unwrap_or_default()
            }
            _ => Limits::default(),
        }
    }

    fn axis_and_limit(&mut self, j: LinkId, limits: Limits) {
        let joint = &self.robot.link(j).joint;
        let name = self.joints[j.0].clone();
        // If the joint variable is the coordinate times a negative factor, the axis is reversed.
        let against = joint.drive == Drive::Actuated && joint.variable.terms[0].1 < 0.0;
        self.line(format!("    <axis xyz=\"0 0 {}\"/>", if against { "-1" } else { "1" }));
        let mut attributes = String::new();
        if let Some((low, high)) = range(&limits) {
            attributes += &format!("lower=\"{low}\" upper=\"{high}\" ");
        } else if joint.kind == JointKind::Prismatic {
            attributes += "lower=\"-1000\" upper=\"1000\" ";
            self.note(&name, "slides without limits, which a URDF asks for: +-1000 m are written".into());
        }
        let [effort, velocity] = [limits.effort, limits.velocity].map(|x| x.unwrap_or(0.0));
        self.line(format!("    <limit {attributes}effort=\"{effort}\" velocity=\"{velocity}\"/>"));
        if limits.acceleration.is_some() {
            self.note(&name, "its limit of acceleration is not carried".into());
        }
    }

    /// Writes `<dynamics>` (friction), and adds notes on properties of the drive that a URDF cannot express.
    fn dynamics(&mut self, j: LinkId) {
        let joint = &self.robot.link(j).joint;
        let name = self.joints[j.0].clone();
        let friction = joint.friction;
        if friction.viscous.is_some() || friction.coulomb.is_some() {
            let attribute = |key: &str, x: Option<f64>| x.map_or(String::new(), |x| format!(" {key}=\"{x}\""));
            let (damping, dry) = (attribute("damping", friction.viscous), attribute("friction", friction.coulomb));
            self.line(format!("    <dynamics{damping}{dry}/>"));
        }
        if friction.offset.is_some() || joint.drive_gain.is_some() {
            self.note(&name, "the offset of its friction and its drive gain are not carried".into());
        }
        if joint.rotor_inertia.is_modelled() {
            let value = match joint.rotor_inertia {
                RotorInertia::Known(x) => format!(" ({x} kg m^2)"),
                _ => String::new(),
            };
            self.note(&name, format!("a URDF has no rotor inertia: IA{value} is not carried"));
        }
    }

    /// Writes `<mimic>` if the joint follows one coordinate that has its own joint.
    fn mimic(&mut self, j: LinkId) {
        let leader = match &self.robot.link(j).joint.variable.terms[..] {
            [(k, c)] => self.robot.joint_of(*k).map(|leader| (self.joints[leader.0].clone(), c)),
            _ => None,
        };
        match leader {
            Some((name, c)) => {
                self.line(format!("    <mimic joint=\"{}\" multiplier=\"{c}\" offset=\"0\"/>", escaped(&name)));
            }
            None => {
                let text = "follows several coordinates, which a URDF cannot say: written as free";
                self.note(&self.joints[j.0].clone(), text.into());
            }
        }
    }

    fn tell_of_the_robot(&mut self) {
        let robot = self.robot;
        for (j, link) in robot.links.iter().enumerate() {
            if self.names[j] != link.name {
                self.note(&link.name, format!("the link is called {} in the file", self.names[j]));
            }
            let joint = joint_name(robot, link);
            if self.joints[j] != joint && !joint.is_empty() {
                self.note(joint, format!("the joint is called {} in the file", self.joints[j]));
            }
        }
        if carried(&robot.name) != robot.name {
            self.note("name", format!("the robot is called {} in the file", carried(&robot.name)));
        }
        for l in 1..=robot.loops.len() {
            self.note(&format!("loop {l}"), "a URDF is a tree: the loop is written cut open".into());
        }
        if robot.gravity_number() != [0.0, 0.0, -9.81] {
            let [x, y, z] = robot.gravity_number();
            self.note("gravity", format!("a URDF has none: ({x}, {y}, {z}) m/s^2 is not carried"));
        }
        if !robot.symbols.is_empty() {
            let names: Vec<&str> = robot.symbols.iter().map(|s| s.name.as_str()).collect();
            self.note("symbols", format!("written as numbers: {}", names.join(", ")));
        }
    }
}

/// The name of the coordinate, if the joint is actuated and only this coordinate moves it; otherwise the name of the joint.
fn joint_name<'a>(robot: &'a Robot, link: &'a Link) -> &'a str {
    match (link.joint.drive, &link.joint.variable.terms[..]) {
        (Drive::Actuated, [(k, _)]) => robot.coordinate_name(*k),
        _ => &link.joint.name,
    }
}

/// The position limits; `None` unless both are finite.
fn range(limits: &Limits) -> Option<(f64, f64)> {
    limits.position.filter(|p| p.0.is_finite() && p.1.is_finite())
}

/// If cos(pitch) is below this value, roll and yaw turn about the same line up to rounding.
const UPRIGHT_COSINE: f64 = 1e-12;

/// Roll, pitch and yaw (rad) of a rotation matrix R = Rz(yaw) Ry(pitch) Rx(roll).
pub fn roll_pitch_yaw(r: &Matrix3) -> [f64; 3] {
    let across = r[0][0].hypot(r[1][0]);
    let pitch = (-r[2][0]).atan2(across);
    if across > UPRIGHT_COSINE {
        [r[2][1].atan2(r[2][2]), pitch, r[1][0].atan2(r[0][0])]
    } else {
        // Roll and yaw rotate about the same line here, so only their combined angle is known: roll is set to zero.
        [0.0, pitch, (-r[0][1]).atan2(r[1][1])]
    }
}

fn unique(names: impl Iterator<Item = String>, taken: &str) -> Vec<String> {
    let mut all: Vec<String> = vec![taken.into()];
    for mut name in names {
        while all.contains(&name) {
            name.push('_');
        }
        all.push(name);
    }
    all.split_off(1)
}

/// Replaces control characters (also line breaks, which XML reads as blanks) and characters that XML forbids by underscores.
fn carried(name: &str) -> String {
    name.chars().map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { '_' } else { c }).collect()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
