//! Finds the left and the right limbs of a robot: pairs of links that are mirror images by their names, their place in the tree
//! and their frames at q = 0.
//!
//! M_i = diag(+-1, +-1, +-1) with det M_i = -1 maps a vector in the frame of the left link to the mirrored vector in the frame
//! of the right link: R_right M_i = S R_left, where S = E - 2 n n^T is the reflection in the plane of the robot with the normal
//! n.

use crate::inertial::Pose;
use crate::robot::{LinkId, Robot};
use crate::vector::{Matrix3, Vector3, dot, minus, norm, plus_scaled, product, scaled, transposed, turned};

/// A left and a right link that are mirror images of each other.
#[derive(Clone, Debug, PartialEq)]
pub struct MirrorPair {
    /// The link with the name of the left side.
    pub left: LinkId,
    /// The link with the name of the right side.
    pub right: LinkId,
    /// The signs of M_i. Coordinate k of a point of the left link, in the frame that the file gives this link, is multiplied by
    /// sign k to get the mirrored point of the right link. `None` if the frames are not mirror images at q = 0.
    pub signs: Option<Vector3>,
    /// Whether both limbs are the same part, mounted in two orientations. Then the bodies are copies, even if their frames are
    /// also mirror images.
    pub is_turned_copy: bool,
}

/// Words for the left side, each with the word for the right side. A short word counts only if it is separated from the rest of
/// the name.
const SIDES: [(&str, &str); 11] = [
    ("left", "right"),
    ("l", "r"),
    ("fl", "fr"),
    ("rl", "rr"),
    ("hl", "hr"),
    ("bl", "br"),
    ("lf", "rf"),
    ("lh", "rh"),
    ("lb", "rb"),
    ("lr", "rr"),
    ("lm", "rm"),
];
/// Two frames count as mirror images if their origins deviate from mirrored positions by at most this length (m) plus a share
/// (the next constant) of the distance between the two origins. Files give lengths to the millimetre.
const ORIGIN_SLACK_M: f64 = 2e-3;
const ORIGIN_SLACK_SHARE: f64 = 0.02;
/// Largest deviation of an entry of M_i from 0 or +-1. It allows for files that give angles to the hundredth of a rad.
const TURN_SLACK: f64 = 0.02;

/// The possible names of the link on the right side: for every way to exchange the words for the sides in a name, the changed
/// name. Empty if the name has no word for the left side.
fn right_names(name: &str) -> Vec<String> {
    let found = left_words(name);
    let exchange = |words: &[(usize, &str, &str)]| {
        let mut changed = name.to_string();
        for (at, word, other) in words.iter().rev() {
            let given = &name[*at..at + word.len()];
            let other: String = match given.chars().all(char::is_uppercase) {
                true => other.to_uppercase(),
                false if given.starts_with(char::is_uppercase) => other[..1].to_uppercase() + &other[1..],
                false => (*other).to_string(),
            };
            changed.replace_range(*at..at + word.len(), &other);
        }
        changed
    };
    let mut names = vec![exchange(&found)];
    names.extend(found.iter().map(|word| exchange(std::slice::from_ref(word))));
    names.retain(|changed| changed != name);
    names
}

/// The words for the left side in a name. For each: its position, the word itself, and the corresponding word for the right
/// side.
fn left_words(name: &str) -> Vec<(usize, &'static str, &'static str)> {
    let lower = name.to_ascii_lowercase();
    let bytes = name.as_bytes();
    // A word ends before a character that is not a letter. It also ends before a capital letter if the letter before or after
    // the capital is small.
    let is_edge = |at: usize| {
        let letter = |k: usize| bytes.get(k).filter(|b| b.is_ascii_alphabetic()).copied();
        let before = at.checked_sub(1).and_then(letter);
        let (Some(before), Some(here)) = (before, letter(at)) else { return true };
        let next_is_small = letter(at + 1).is_some_and(|b| b.is_ascii_lowercase());
        here.is_ascii_uppercase() && (before.is_ascii_lowercase() || next_is_small)
    };
    let mut found: Vec<(usize, &str, &str)> = Vec::new();
    for (left, right) in SIDES {
        for (at, _) in lower.match_indices(left) {
            let is_word = is_edge(at) && is_edge(at + left.len());
            let is_new = found.iter().all(|(other, word, _)| at + left.len() <= *other || other + word.len() <= at);
            if is_new && (is_word || left == SIDES[0].0) {
                found.push((at, left, right));
            }
        }
    }
    found.sort_unstable();
    found
}

/// The pairs of mirrored links of a robot; a pair follows the pair of its antecedents. Two limbs are mirrored only if they have
/// the same joints and start at the same link or at a mirrored pair.
pub fn mirror_pairs(robot: &Robot) -> Vec<MirrorPair> {
    let poses = robot.link_poses(&vec![0.0; robot.n_variables()]);
    let poses: Vec<Pose> = poses.iter().zip(&robot.links).map(|(pose, link)| pose.compose(&link.file_frame)).collect();
    let mut pairs: Vec<MirrorPair> = Vec::new();
    // `planes`: for each pair, a point of its mirror plane and the normal. `limbs`: for each pair, the index of the first pair
    // of its limb.
    let mut planes: Vec<(Vector3, Vector3)> = Vec::new();
    let mut limbs: Vec<usize> = Vec::new();
    for left in robot.link_ids() {
        let link = robot.link(left);
        for name in right_names(&link.name) {
            let Some(right) = robot.link_ids().find(|&j| robot.link(j).name == name && j != left) else { continue };
            let other = robot.link(right);
            let before = (link.antecedent, other.antecedent);
            let of_before = pairs.iter().position(|pair| (Some(pair.left), Some(pair.right)) == before);
            if link.joint.kind != other.joint.kind || (of_before.is_none() && before.0 != before.1) {
                continue;
            }
            let (p, q) = (poses[left.0].position, poses[right.0].position);
            let plane = match of_before {
                Some(k) => planes[k],
                None => match plane_between(p, q) {
                    Some(plane) => plane,
                    None => continue,
                },
            };
            let off = norm(minus(reflected(p, plane), q));
            let far = norm(minus(p, q));
            let is_image = off <= ORIGIN_SLACK_M + ORIGIN_SLACK_SHARE * far;
            let signs = if is_image { signs(&poses[left.0].rotation, &poses[right.0].rotation, plane.1) } else { None };
            // The frame of the last link of a limb does not show on which side the body lies. So for this link, three minus
            // signs (a reflection in a point) are not accepted as a mirror image.
            let is_last = !robot.links.iter().any(|link| link.antecedent == Some(left));
            let signs = signs.filter(|signs| !is_last || signs.iter().filter(|s| **s < 0.0).count() == 1);
            let limb = of_before.map_or(pairs.len(), |k| limbs[k]);
            let is_copy = match link.antecedent.zip(other.antecedent).filter(|_| of_before.is_some()) {
                Some((i, j)) => {
                    let [step, other] = [(i, left), (j, right)].map(|(a, b)| poses[a.0].inverse().compose(&poses[b.0]));
                    off_by(&step, &other) <= TURN_SLACK
                }
                None => off_by(&poses[left.0], &Pose { position: p, ..poses[right.0] }) > TURN_SLACK,
            };
            pairs.push(MirrorPair { left, right, signs, is_turned_copy: is_copy });
            pairs[limb].is_turned_copy &= is_copy;
            planes.push(plane);
            limbs.push(limb);
            break;
        }
    }
    for k in 0..pairs.len() {
        pairs[k].is_turned_copy = pairs[limbs[k]].is_turned_copy;
    }
    pairs
}

/// The largest difference between two poses: of a position coordinate (m) or of an entry of the rotation matrix.
fn off_by(a: &Pose, b: &Pose) -> f64 {
    let rows = (0..3).flat_map(|i| minus(a.rotation[i], b.rotation[i])).chain(minus(a.position, b.position));
    rows.fold(0.0, |most, x| most.max(x.abs()))
}

/// The plane in the middle between two points. `None` if the plane is not parallel to two axes of the base, because then the
/// points are not mirror images.
fn plane_between(p: Vector3, q: Vector3) -> Option<(Vector3, Vector3)> {
    let apart = minus(p, q);
    let along = (0..3)
        .find(|&k| apart[k].abs() > ORIGIN_SLACK_M && apart[k].abs() >= (1.0 - ORIGIN_SLACK_SHARE) * norm(apart))?;
    let normal = [0, 1, 2].map(|k| if k == along { 1.0 } else { 0.0 });
    Some((plus_scaled(q, apart, 0.5), normal))
}

fn reflected(p: Vector3, (point, normal): (Vector3, Vector3)) -> Vector3 {
    plus_scaled(p, normal, -2.0 * dot(minus(p, point), normal))
}

/// The diagonal of M_i = R_right^T S R_left; `None` if this matrix is not diagonal.
fn signs(left: &Matrix3, right: &Matrix3, normal: Vector3) -> Option<Vector3> {
    let reflection: Matrix3 = [0, 1, 2].map(|i| {
        let unit = [0, 1, 2].map(|k| if k == i { 1.0 } else { 0.0 });
        plus_scaled(unit, scaled(normal, normal[i]), -2.0)
    });
    let m = product(&transposed(right), &product(&reflection, left));
    let near = |i: usize, j: usize| (m[i][j].abs() - if i == j { 1.0 } else { 0.0 }).abs() <= TURN_SLACK;
    let is_diagonal = (0..3).all(|i| (0..3).all(|j| near(i, j)));
    is_diagonal.then(|| [0, 1, 2].map(|i| m[i][i].signum()))
}

impl MirrorPair {
    /// The axis of a link's joint in the frame that the file gives the link.
    pub(crate) fn axis(robot: &Robot, link: LinkId) -> Vector3 {
        turned(&transposed(&robot.link(link).file_frame.rotation), [0.0, 0.0, 1.0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::read_urdf;

    #[test]
    fn words_of_the_sides_are_exchanged() {
        for (name, right) in [
            ("l_thigh", Some("r_thigh")),
            ("FL_hip", Some("FR_hip")),
            ("leg_left_1_link", Some("leg_right_1_link")),
            ("LHipPitch", Some("RHipPitch")),
            ("LeftArm", Some("RightArm")),
            ("leftshoulder", Some("rightshoulder")),
            ("RL_calf", Some("RR_calf")),
            ("arm-L", Some("arm-R")),
            ("wheel", None),
            ("r_thigh", None),
            ("elbow", None),
            ("L1", Some("R1")),
        ] {
            assert_eq!(right_names(name).first().map(String::as_str), right, "{name}");
        }
        // The left finger of a left hand. On the right hand, the corresponding finger may be named right or left.
        assert_eq!(right_names("left_l_finger"), ["right_r_finger", "right_l_finger", "left_r_finger"]);
    }

    fn legs(right_knee: &str, rpy: &str) -> Vec<Option<Vector3>> {
        let leg = |side: &str, hip: &str, knee: &str, rpy: &str| {
            let link = |name: &str| format!("<link name=\"{side}_{name}\"/>");
            let joint = |name: &str, parent: &str, child: &str, at: &str, axis: &str| {
                format!(
                    "<joint name=\"{side}_{name}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"{side}_{child}\"/>\
                     <origin xyz=\"{at}\" rpy=\"{rpy}\"/><axis xyz=\"{axis}\"/></joint>"
                )
            };
            let thigh = format!("{side}_thigh");
            [
                link("thigh"),
                link("shank"),
                joint("hip", "b", "thigh", hip, "1 0 0"),
                joint("knee", &thigh, "shank", knee, "0 1 0"),
            ]
            .concat()
        };
        let text = format!(
            "<robot name=\"r\"><link name=\"b\"/>{}{}</robot>",
            leg("l", "0 0.1 0", "0.02 0.01 -0.2", "0 0 0"),
            leg("r", "0 -0.1 0", right_knee, rpy)
        );
        mirror_pairs(&read_urdf(&text, "r.urdf").unwrap()).into_iter().map(|pair| pair.signs).collect()
    }

    #[test]
    fn legs_are_pairs_and_frames_tell_the_signs() {
        let across = Some([1.0, -1.0, 1.0]);
        assert_eq!(legs("0.02 -0.01 -0.2", "0 0 0"), [across, across]);
        assert_eq!(legs("0.02 -0.01 -0.3", "0 0 0"), [across, None]);
        // The right thigh is rotated by half a turn about x, so its y and z axes point in the opposite direction, and the axis
        // of the knee too.
        assert_eq!(legs("0.02 0.01 0.2", "3.14159265358979 0 0"), [Some([1.0, 1.0, -1.0]), across]);
        assert_eq!(legs("0.02 -0.01 -0.2", "0.3 0 0")[0], None);
    }

    /// The same arm on both sides, rotated by 45 degrees. The frames of the two arms are mirror images as long as the arm is
    /// flat.
    #[test]
    fn one_limb_in_two_orientations_is_a_copy() {
        let found = |right_elbow: &str, turns: [&str; 2]| {
            let arm = |side: &str, y: f64, rpy: &str, elbow: &str| {
                format!(
                    "<link name=\"{side}_arm\"/><link name=\"{side}_hand\"/><joint name=\"{side}_j\" type=\"continuous\"><parent \
                     link=\"b\"/><child link=\"{side}_arm\"/><origin xyz=\"0 {y} 0\" rpy=\"{rpy}\"/></joint><joint \
                     name=\"{side}_k\" type=\"continuous\"><parent link=\"{side}_arm\"/><child link=\"{side}_hand\"/><origin \
                     xyz=\"{elbow}\"/><axis xyz=\"0 1 0\"/></joint>"
                )
            };
            let arms = [arm("l", 0.2, turns[0], "0.3 0.05 0"), arm("r", -0.2, turns[1], right_elbow)].concat();
            let text = format!("<robot name=\"r\"><link name=\"b\"/>{arms}</robot>");
            let pairs = mirror_pairs(&read_urdf(&text, "r.urdf").unwrap());
            pairs.iter().map(|pair| pair.is_turned_copy).collect::<Vec<_>>()
        };
        let turned = ["0 0 0.8", "0 0 -0.8"];
        assert_eq!(found("0.3 0.05 0", turned), [true, true]);
        // An arm with a mirrored elbow is a different part. And without a rotation, only the bodies could distinguish left and
        // right.
        assert_eq!(found("0.3 -0.05 0", turned), [false, false]);
        assert_eq!(found("0.3 0.05 0", ["0 0 0"; 2]), [false, false]);
    }
}
