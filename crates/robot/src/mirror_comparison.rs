//! Compares the bodies of left and right limbs: mass, centre of mass and axis.

use crate::body::Body;
use crate::body_doubt::{doubts, shown};
use crate::finding::{Finding, Mistake, Repair, RepairedBody};
use crate::inertial::{Pose, transform_inertial};
use crate::mirror_pairs::MirrorPair;
use crate::principal::principal_axes;
use crate::robot::Robot;
use crate::vector::{Vector3, dot, minus, norm};

/// Masses of left and right may differ by this factor: one side has the computer or the cables.
const MASS_FACTOR: f64 = 1.5;
/// Largest usual distance of a centre of mass from the image of the other, m.
const CENTRE_SLACK_M: f64 = 0.01;
/// Largest deviation, relative to the distance of the two candidates, up to which a body is the copy of the other one.
const COPY_SHARE: f64 = 0.1;
/// Axes of left and right differ if their angle is above about this, rad.
const AXIS_SLACK: f64 = 0.05;

/// Compares all pairs. Bodies that are the only implausible one of a pair get the mirror image of the other as their repair.
pub(crate) fn compare(robot: &Robot, pairs: &[MirrorPair], bodies: &[Body], findings: &mut Vec<Finding>) {
    for pair in pairs {
        let own = |link| bodies.iter().find(|body| body.own && body.link == Some(link));
        axes(robot, pair, findings);
        let (Some(left), Some(right)) = (own(pair.left), own(pair.right)) else { continue };
        let empty = [left, right].map(|body| !is_usable(body));
        match empty {
            [true, true] => {}
            [false, false] => both(pair, left, right, findings),
            [left_is_empty, _] => {
                let (bad, good) = if left_is_empty { (left, right) } else { (right, left) };
                if let Some(signs) = pair.signs {
                    take_over(bad, good, signs, findings);
                }
            }
        }
    }
}

/// Whether a body has a mass and an inertia that can exist and fit the body.
fn is_usable(body: &Body) -> bool {
    body.mass > 0.0 && principal_axes(&body.inertia()).0[2] > 0.0 && doubts(body).is_empty()
}

/// Adds the mirror image of the good body as the repair of the findings on the other one.
fn take_over(bad: &Body, good: &Body, signs: Vector3, findings: &mut [Finding]) {
    let image = image(good, signs);
    for finding in findings.iter_mut().filter(|finding| finding.subjects[0] == bad.name && finding.repair.is_none()) {
        let text = "the mirror image of the other side, which is plausible, is the repair".to_string();
        finding.repair = Some(Repair { text, bodies: vec![RepairedBody { name: bad.name.clone(), ..image.clone() }] });
    }
}

/// The mirror image of a body, with the axes of its frame of the file.
fn image(body: &Body, signs: Vector3) -> RepairedBody {
    let mut x = [0.0; 10];
    x[..6].copy_from_slice(&body.inertia());
    let in_file = transform_inertial(&x, &Pose { position: [0.0; 3], ..body.pose });
    let inertia = std::array::from_fn(|k| {
        let (i, j) = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)][k];
        in_file[k] * signs[i] * signs[j]
    });
    let position = [0, 1, 2].map(|i| signs[i] * body.pose.position[i]);
    let pose = Some(Pose { position, ..Pose::IDENTITY });
    RepairedBody { name: body.name.clone(), mass: body.mass, pose, inertia }
}

/// Compares two plausible bodies.
fn both(pair: &MirrorPair, left: &Body, right: &Body, findings: &mut Vec<Finding>) {
    let subject = format!("{} and {}", left.name, right.name);
    let mut find = |fact: &str, evidence| findings.push(Finding::new(&subject, Mistake::NotMirrored, fact, evidence));
    let ratio = left.mass.max(right.mass) / left.mass.min(right.mass);
    if ratio > MASS_FACTOR {
        let [one, other] = [left, right].map(|body| shown(body.mass, 4));
        let text = format!("{one} kg and {other} kg, a factor of {ratio:.2}");
        find("left and right differ in mass; the values alone do not tell which is right", text);
        return;
    }
    let Some(signs) = pair.signs else { return };
    let mirrored = image(left, signs);
    let wanted = mirrored.pose.map_or([0.0; 3], |pose| pose.position);
    let off = norm(minus(right.pose.position, wanted));
    if off <= CENTRE_SLACK_M {
        return;
    }
    let as_copy = norm(minus(right.pose.position, left.pose.position));
    if as_copy <= COPY_SHARE * off {
        let changed: String =
            ["x", "y", "z"].into_iter().zip(signs).filter(|(_, s)| *s < 0.0).map(|(k, _)| k).collect();
        let odd: Vec<&str> = [("ixy", 0, 1), ("ixz", 0, 2), ("iyz", 1, 2)]
            .into_iter()
            .filter(|(_, i, j)| signs[*i] * signs[*j] < 0.0)
            .map(|(name, _, _)| name)
            .collect();
        let fact = format!(
            "left and right are copies, not mirror images; with the sign of {} of the centre and of {} changed on one side they \
             are (that the same part is used on both sides is the other case)",
            changed.chars().map(String::from).collect::<Vec<_>>().join(", "),
            odd.join(", ")
        );
        let text = format!("both centres at {:?} m", left.pose.position.map(|x| shown(x, 3)));
        find(&fact, text);
    }
}

fn axes(robot: &Robot, pair: &MirrorPair, findings: &mut Vec<Finding>) {
    let Some(signs) = pair.signs else { return };
    let axis = MirrorPair::axis(robot, pair.left);
    let other = MirrorPair::axis(robot, pair.right);
    let image = [0, 1, 2].map(|i| signs[i] * axis[i]);
    if dot(image, other).abs() < 1.0 - 0.5 * AXIS_SLACK * AXIS_SLACK {
        let subject = [pair.left, pair.right].map(|link| robot.link(link).joint.name.as_str()).join(" and ");
        let text = format!("{axis:.3?} and {other:.3?}");
        let fact = "the axes of left and right are no mirror images";
        findings.push(Finding::new(&subject, Mistake::NotMirrored, fact, text));
    }
}

#[cfg(test)]
mod tests {
    use crate::format::read_urdf;
    use crate::lint::{Finding, Mistake, lint};

    /// A body of a leg: mass, centre and products; the moments are those of a box.
    type Part = (f64, [f64; 3], f64);

    fn legs([left, right]: [[Part; 2]; 2], right_axis: &str) -> Vec<Finding> {
        let body = |name: &str, (mass, [x, y, z], product): Part| {
            let i = mass * 0.002;
            format!(
                "<link name=\"{name}\"><inertial><origin xyz=\"{x} {y} {z}\"/><mass value=\"{mass}\"/><inertia ixx=\"{i}\" \
                 ixy=\"{product}\" ixz=\"0\" iyy=\"{i}\" iyz=\"0\" izz=\"{i}\"/></inertial></link>"
            )
        };
        let joint = |name: &str, parent: &str, child: &str, at: &str, axis: &str| {
            format!(
                "<joint name=\"{name}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
                 <origin xyz=\"{at}\"/><axis xyz=\"{axis}\"/></joint>"
            )
        };
        let text = [
            body("pelvis", (4.0, [0.0; 3], 0.0)),
            body("l_thigh", left[0]),
            body("l_shank", left[1]),
            body("r_thigh", right[0]),
            body("r_shank", right[1]),
            joint("l_hip", "pelvis", "l_thigh", "0 0.1 -0.1", "1 0 0"),
            joint("l_knee", "l_thigh", "l_shank", "0 0 -0.2", "0 1 0"),
            joint("r_hip", "pelvis", "r_thigh", "0 -0.1 -0.1", "1 0 0"),
            joint("r_knee", "r_thigh", "r_shank", "0 0 -0.2", right_axis),
        ]
        .concat();
        lint(&read_urdf(&format!("<robot name=\"r\">{text}</robot>"), "r.urdf").unwrap())
    }

    const THIGH: Part = (0.75, [0.01, 0.02, -0.06], 1e-4);
    const SHANK: Part = (1.26, [0.0, 0.01, -0.15], 2e-4);
    const MIRRORED: [Part; 2] = [(0.75, [0.01, -0.02, -0.06], -1e-4), (1.26, [0.0, -0.01, -0.15], -2e-4)];

    #[test]
    fn mirror_images_have_no_finding() {
        assert_eq!(legs([[THIGH, SHANK], MIRRORED], "0 1 0"), []);
        assert_eq!(legs([[THIGH, SHANK], MIRRORED], "0 -1 0"), []);
    }

    #[test]
    fn copies_and_masses_and_axes_are_one_sentence_each() {
        let copies = legs([[THIGH, SHANK], [THIGH, SHANK]], "0 1 0");
        let text = copies[0].to_string();
        assert!(copies.len() == 1 && text.contains("sign of y of the centre and of ixy, iyz"), "{copies:#?}");
        assert!(text.starts_with("l_thigh and r_thigh, l_shank and r_shank: left and right are copies"), "{text}");
        let light = (0.165, MIRRORED[0].1, 0.0);
        let uneven = legs([[THIGH, SHANK], [light, MIRRORED[1]]], "0 1 0");
        assert!(
            uneven.len() == 1 && uneven[0].text().contains("0.75 kg and 0.165 kg, a factor of 4.55"),
            "{uneven:#?}"
        );
        let axes = legs([[THIGH, SHANK], MIRRORED], "1 0 0");
        assert_eq!(
            axes.iter().map(|f| (f.mistake, f.subjects[0].as_str())).collect::<Vec<_>>(),
            [(Mistake::NotMirrored, "l_knee and r_knee")]
        );
    }

    #[test]
    fn a_side_without_inertia_gets_the_image_of_the_other() {
        let zero = |part: Part| (part.0, part.1, 0.0);
        let text = legs([[THIGH, SHANK], MIRRORED], "0 1 0");
        assert_eq!(text, []);
        // A mass of 0 on both bodies of one side is one sentence with both names.
        let findings = legs([[THIGH, SHANK], [(0.0, [0.0; 3], 0.0), (0.0, [0.0; 3], 0.0)]], "0 1 0");
        let [finding] = &findings[..] else { panic!("{findings:#?}") };
        assert_eq!(
            (finding.mistake, &finding.subjects[..]),
            (Mistake::NoMass, &["r_thigh".to_string(), "r_shank".into()][..])
        );
        let repair = finding.repair.as_ref().unwrap();
        assert!(repair.text.contains("the mirror image of the other side"), "{}", repair.text);
        for (body, wanted) in repair.bodies.iter().zip([zero(MIRRORED[0]), zero(MIRRORED[1])]) {
            assert_eq!((body.mass, body.pose.unwrap().position), (wanted.0, wanted.1));
        }
        assert!((repair.bodies[0].inertia[1] + 1e-4).abs() < 1e-18, "{:?}", repair.bodies[0].inertia);
    }
}
