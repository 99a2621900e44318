//! Compares the bodies of left and right limbs: mass, centre of mass, inertia and axis.

use crate::body::Body;
use crate::body_doubt::doubts;
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
        let text = format!("{} kg and {} kg, a factor of {ratio:.2}", left.mass, right.mass);
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
        let text = format!("both centres at {:?} m", left.pose.position);
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
