//! Compares the bodies of left and right limbs: mass, centre of mass, inertia and axis.
//!
//! I: inertia of the left body. Its mirror image, in the axes of the frame of the right link, is M I M with M of
//! [`crate::mirror_pairs`]: the products across the plane change their sign.

use crate::body::Body;
use crate::body_doubt::{doubts, shown};
use crate::finding::{Finding, Mistake, Repair, RepairedBody};
use crate::inertial::{Pose, turned_inertia};
use crate::mirror_pairs::MirrorPair;
use crate::principal::principal_axes;
use crate::robot::Robot;
use crate::vector::{Matrix3, Vector3, dot, minus, norm};

/// Masses of left and right may differ by this factor: one side has the computer or the cables.
const MASS_FACTOR: f64 = 1.5;
/// Largest usual distance (m) between the centre of mass of one side and the mirror image of the other centre.
const CENTRE_SLACK_M: f64 = 0.01;
/// A body counts as a copy of the body on the other side, and not as its mirror image, if the distance from its centre of mass
/// to the other body's centre of mass is at most this fraction of the distance to the mirror image of that centre.
const COPY_SHARE: f64 = 0.1;
/// Inertias of left and right count as different if at least one of the six numbers differs by more than this fraction of the
/// largest moment. Small differences are usual: one side has the computer or the cables.
const INERTIA_SHARE: f64 = 0.1;
/// `INERTIA_SHARE` for a body after a repair. It is smaller, because a repair must fit better than by chance.
const REPAIRED_SHARE: f64 = 0.02;
/// If no slip (usual mistake) explains the difference, it is reported only if two moments per mass differ by at least this
/// factor.
const INERTIA_FACTOR: f64 = 3.0;
/// The six numbers of an inertia: the name and the two axes of each number.
const SIX: [(&str, usize, usize); 6] =
    [("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2)];
/// Axes of left and right differ if the angle between them is above about this value, rad.
const AXIS_SLACK: f64 = 0.05;

/// Compares all pairs. If only one body of a pair is implausible, the mirror image of the other body is its repair.
pub(crate) fn compare(robot: &Robot, pairs: &[MirrorPair], bodies: &[Body], findings: &mut Vec<Finding>) {
    for pair in pairs {
        let own = |link| bodies.iter().find(|body| body.own && body.link == Some(link));
        axes(robot, pair, findings);
        let (Some(left), Some(right)) = (own(pair.left), own(pair.right)) else { continue };
        match ([left, right].map(is_usable), pair.signs) {
            ([true, true], _) => both(pair, left, right, findings),
            ([true, false], Some(signs)) => take_over(right, left, signs, findings),
            ([false, true], Some(signs)) => take_over(left, right, signs, findings),
            _ => {}
        }
    }
}

/// Whether a body has a mass, an inertia and no doubts, so that it can be compared.
fn is_usable(body: &Body) -> bool {
    body.mass > 0.0 && principal_axes(&body.inertia()).0[2] > 0.0 && doubts(body).is_empty()
}

/// Uses the mirror image of the good body as the repair in the findings on the bad body.
fn take_over(bad: &Body, good: &Body, signs: Vector3, findings: &mut [Finding]) {
    let image = image(good, signs);
    for finding in findings.iter_mut().filter(|finding| finding.subjects[0] == bad.name && finding.repair.is_none()) {
        let text = "the mirror image of the other side, which is plausible, is the repair".to_string();
        finding.repair = Some(Repair { text, bodies: vec![RepairedBody { name: bad.name.clone(), ..image.clone() }] });
    }
}

/// The mirror image of a body. Its inertial frame has the axes of the frame that the file gives the body.
fn image(body: &Body, signs: Vector3) -> RepairedBody {
    let in_file = turned_inertia(&body.inertia(), &body.pose.rotation);
    let inertia = std::array::from_fn(|k| in_file[k] * signs[SIX[k].1] * signs[SIX[k].2]);
    let position = [0, 1, 2].map(|i| signs[i] * body.pose.position[i]);
    let pose = Pose { position, ..Pose::IDENTITY };
    RepairedBody { name: body.name.clone(), mass: body.mass, pose, is_moved: true, inertia }
}

/// Compares two plausible bodies.
fn both(pair: &MirrorPair, left: &Body, right: &Body, findings: &mut Vec<Finding>) {
    let subject = format!("{} and {}", left.name, right.name);
    let finding = |fact: &str, evidence: String| Finding::new(&subject, Mistake::NotMirrored, fact, evidence);
    // The order is mass, centre of mass, inertia. Only the first difference is reported, because it may cause the later ones.
    let ratio = left.mass.max(right.mass) / left.mass.min(right.mass);
    if ratio > MASS_FACTOR {
        let [one, other] = [left, right].map(|body| shown(body.mass, 4));
        let text = format!("{one} kg and {other} kg, a factor of {ratio:.2}");
        let repair = "the values alone do not tell which is right: weigh one, and write its mirror image for the other";
        let repair = Some(Repair { text: repair.into(), bodies: vec![] });
        findings.push(Finding { repair, ..finding("left and right differ in mass", text) });
        return;
    }
    let Some(signs) = pair.signs else { return };
    let mirrored = image(left, signs);
    let off = norm(minus(right.pose.position, mirrored.pose.position));
    if off <= CENTRE_SLACK_M {
        findings.extend(inertias(&subject, left, right, signs));
        return;
    }
    // If the centre of the right body is the centre of the left body, a sign was forgotten when the values were copied. The
    // same part on both sides, mounted turned, also has equal centres, but without a mistake.
    let as_copy = norm(minus(right.pose.position, left.pose.position));
    if as_copy <= COPY_SHARE * off && !pair.is_turned_copy {
        let changed: Vec<&str> =
            ["x", "y", "z"].into_iter().zip(signs).filter(|(_, s)| *s < 0.0).map(|p| p.0).collect();
        // Let s be the diagonal of M. A product of inertia ij changes its sign in the mirror image if s_i s_j < 0.
        let odd: Vec<&str> = SIX.iter().filter(|(_, i, j)| signs[*i] * signs[*j] < 0.0).map(|six| six.0).collect();
        let odd = if odd.is_empty() { String::new() } else { format!(" and of {}", odd.join(", ")) };
        let fact = format!(
            "left and right are copies, not mirror images; with the sign of {} of the centre{odd} changed on one side they \
             are (that the same part is used on both sides is the other case)",
            changed.join(", ")
        );
        let text = format!("both centres at {:?} m", left.pose.position.map(|x| shown(x, 3)));
        findings.push(finding(&fact, text));
    }
}

/// Compares the inertias per mass, about the centres of mass and in the axes of the right link.
fn inertias(subject: &str, left: &Body, right: &Body, signs: Vector3) -> Option<Finding> {
    let per_mass = |body: &Body, signs| image(body, signs).inertia.map(|i| i / body.mass);
    let (wanted, given) = (per_mass(left, signs), per_mass(right, [1.0; 3]));
    let size = principal_axes(&wanted).0[2].max(principal_axes(&given).0[2]);
    let differ = |given: &[f64; 6], share: f64| -> Vec<usize> {
        (0..6).filter(|&k| (given[k] - wanted[k]).abs() > share * size).collect()
    };
    let different = differ(&given, INERTIA_SHARE);
    let [first, ..] = different[..] else { return None };
    let names = different.iter().map(|&k| SIX[k].0).collect::<Vec<_>>().join(", ");
    let is_turned = [left, right].iter().any(|body| body.pose.rotation != Pose::IDENTITY.rotation);
    let axes = if is_turned { ", in the axes of the link" } else { "" };
    let fact = format!("the inertias of left and right are no mirror images: {names} differ{axes}");
    let [mirrored, own] = [wanted, given].map(|six| shown(right.mass * six[first], 4));
    let evidence = format!("{} is {own}, mirrored {mirrored} kg m^2", SIX[first].0);
    let mut agreeing = slips(left, right, signs, &given, &wanted)
        .into_iter()
        .filter(|slip| differ(&slip.1, REPAIRED_SHARE).is_empty());
    let repair = match (agreeing.next(), agreeing.next()) {
        (Some((text, _)), None) => Some(Repair { text: format!("with {text} they are"), bodies: vec![] }),
        // Parts of both sides differ a little. If no slip explains the difference, only large differences count.
        _ if [0, 3, 5].into_iter().all(|k| given[k].max(wanted[k]) < INERTIA_FACTOR * given[k].min(wanted[k])) => {
            return None;
        }
        _ => None,
    };
    Some(Finding { repair, ..Finding::new(subject, Mistake::NotMirrored, fact, evidence) })
}

/// Usual mistakes (slips) on one side. Each has its name, and the six numbers of the right body per mass after the slip is
/// corrected.
fn slips(left: &Body, right: &Body, signs: Vector3, given: &[f64; 6], wanted: &[f64; 6]) -> Vec<(String, [f64; 6])> {
    let name = |k: usize| SIX[k].0;
    let mut found = Vec::new();
    // Slip 1: wrong signs of products of inertia (places 1, 2 and 4 of `SIX`).
    let changed: Vec<usize> = [1, 2, 4].into_iter().filter(|&k| given[k] * wanted[k] < 0.0).collect();
    if !changed.is_empty() {
        let names: Vec<&str> = changed.iter().map(|&k| name(k)).collect();
        let six = std::array::from_fn(|k| if changed.contains(&k) { -given[k] } else { given[k] });
        found.push((format!("the sign of {} changed on one side", names.join(", ")), six));
    }
    // Slip 2: two moments (places 0, 3 and 5) or two products exchanged.
    for (a, b) in [(0, 3), (0, 5), (3, 5), (1, 2), (1, 4), (2, 4)] {
        let mut six = *given;
        six.swap(a, b);
        found.push((format!("{} and {} of one side exchanged", name(a), name(b)), six));
    }
    // Slip 3: one number is wrong by a power of ten.
    for k in 0..6 {
        let power = (wanted[k] / given[k]).abs().log10().round();
        if power.is_finite() && power != 0.0 {
            let mut six = *given;
            six[k] *= 10f64.powf(power);
            found.push((
                format!(
                    "{} of one side in the decimals of the other, a factor of {}",
                    name(k),
                    10f64.powf(power.abs())
                ),
                six,
            ));
        }
    }
    // Slip 4: wrong rotation of the inertial frame. With R of the left body, the right body should have M R M.
    let across = |m: &Matrix3| [0, 1, 2].map(|i| [0, 1, 2].map(|j| signs[i] * signs[j] * m[i][j]));
    let mirrored = Body { pose: Pose { rotation: across(&left.pose.rotation), ..right.pose }, ..right.clone() };
    if mirrored.pose != right.pose {
        let text = "the inertial frame (rpy) of one side the mirror image of the other's".to_string();
        found.push((text, image(&mirrored, [1.0; 3]).inertia.map(|i| i / right.mass)));
    }
    found
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

    /// A body of a leg: mass, centre of mass, and one product of inertia. The moments are the moments of a box.
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

    /// Each slip on one side is named, with the numbers that differ. A difference that no slip explains is reported only if it
    /// is large.
    #[test]
    fn inertias_are_compared_with_the_mirror_image() {
        let legs = |right: [f64; 6], rpy: [&str; 2]| {
            let leg = |side: &str, y: f64, [xx, xy, xz, yy, yz, zz]: [f64; 6], rpy: &str| {
                format!(
                    "<link name=\"{side}_leg\"><inertial><origin xyz=\"0 {y} -0.1\" rpy=\"{rpy}\"/><mass value=\"2\"/><inertia \
                     ixx=\"{xx}\" ixy=\"{xy}\" ixz=\"{xz}\" iyy=\"{yy}\" iyz=\"{yz}\" izz=\"{zz}\"/></inertial></link>\
                     <joint name=\"{side}_hip\" type=\"continuous\"><parent link=\"pelvis\"/><child link=\"{side}_leg\"/>\
                     <origin xyz=\"0 {} 0\"/><axis xyz=\"0 1 0\"/></joint>",
                    10.0 * y
                )
            };
            let left = [0.02, 0.003, 0.002, 0.015, -0.004, 0.01];
            let text = [leg("l", 0.02, left, rpy[0]), leg("r", -0.02, right, rpy[1])].concat();
            let text = format!("<robot name=\"r\"><link name=\"pelvis\"/>{text}</robot>");
            let found = lint(&read_urdf(&text, "r.urdf").unwrap());
            found.iter().filter(|f| f.mistake == Mistake::NotMirrored).map(Finding::text).collect::<Vec<_>>().concat()
        };
        let none = ["0 0 0"; 2];
        let mirrored = [0.02, -0.003, 0.002, 0.015, 0.004, 0.01];
        assert_eq!(legs(mirrored, none), "");
        assert_eq!(legs(mirrored.map(|i| 1.08 * i), none), "");
        for (six, rpy, named) in [
            (
                [0.02, 0.003, 0.002, 0.015, -0.004, 0.01],
                none,
                "ixy, iyz differ: ixy is 0.003, mirrored -0.003 kg m^2; with the sign of ixy, iyz",
            ),
            (
                [0.02, -0.003, -0.002, 0.015, 0.004, 0.01],
                none,
                "ixz differ: ixz is -0.002, mirrored 0.002 kg m^2; with the sign of ixz changed",
            ),
            (
                [0.02, -0.003, 0.002, 0.01, 0.004, 0.015],
                none,
                "iyy, izz differ: iyy is 0.01, mirrored 0.015 kg m^2; with iyy and izz of one side",
            ),
            (
                [0.02, -0.003, 0.002, 0.015, 0.0004, 0.01],
                none,
                "iyz differ: iyz is 0.0004, mirrored 0.004 kg m^2; with iyz of one side in the decimals of the other, a factor of 10",
            ),
            (
                mirrored,
                ["0.4 0 0", "0.4 0 0"],
                "ixz, iyy, iyz, izz differ, in the axes of the link: ixz is 0.0006739, mirrored 0.00301 kg m^2",
            ),
            (
                mirrored,
                ["0.4 0 0", "0.4 0 0"],
                "with the inertial frame (rpy) of one side the mirror image of the other's they are",
            ),
            // No slip explains a factor of four.
            (mirrored.map(|i| 0.25 * i), none, "ixx, ixy, iyy, iyz, izz differ: ixx is 0.005, mirrored 0.02 kg m^2"),
        ] {
            let text = legs(six, rpy);
            assert!(text.contains(named), "{named}: {text}");
            assert_eq!(text.contains("; with "), six[0] == 0.02, "{text}");
        }
        // The inertial frame that is rotated in the opposite direction is the mirror image.
        assert_eq!(legs(mirrored, ["0.4 0 0", "-0.4 0 0"]), "");
        // Half of the moments is no finding, because the two sides may have different motors.
        assert_eq!(legs(mirrored.map(|i| 0.5 * i), none), "");
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
        // If both bodies of one side have the mass 0, this is one sentence with both names.
        let findings = legs([[THIGH, SHANK], [(0.0, [0.0; 3], 0.0), (0.0, [0.0; 3], 0.0)]], "0 1 0");
        let [finding] = &findings[..] else { panic!("{findings:#?}") };
        assert_eq!(
            (finding.mistake, &finding.subjects[..]),
            (Mistake::NoMass, &["r_thigh".to_string(), "r_shank".into()][..])
        );
        let repair = finding.repair.as_ref().unwrap();
        assert!(repair.text.contains("the mirror image of the other side"), "{}", repair.text);
        for (body, wanted) in repair.bodies.iter().zip([zero(MIRRORED[0]), zero(MIRRORED[1])]) {
            assert_eq!((body.mass, body.pose.position), (wanted.0, wanted.1));
        }
        assert!((repair.bodies[0].inertia[1] + 1e-4).abs() < 1e-18, "{:?}", repair.bodies[0].inertia);
    }
}
