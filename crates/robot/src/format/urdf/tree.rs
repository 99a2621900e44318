//! Builds the tree of a URDF: its root, its moving links in order, and the links fixed to each of them.
//!
//! The order is depth first, and the joints below a link (also fixed ones) are sorted by name. Pinocchio and other programs that
//! sort the joints of a URDF get the same order.

use std::collections::BTreeMap;

use urdf_rs::JointType;

use super::text::{Checked, JointMark, Position};
use crate::angle_snap::{self, AngleSnapping};
use crate::error::Error;
use crate::format::node::DescriptionFile;
use crate::format::reframe::JointPlacement;
use crate::format::shown::shown;
use crate::inertial::Pose;
use crate::robot::Note;
use crate::value::Value;
use gate::suggestion::did_you_mean;

/// A moving link: its joint, and the links that are fixed to it.
#[derive(Clone, Debug)]
pub(super) struct MovingLink {
    /// Index of the joint in the joints of the file.
    pub joint: usize,
    pub given: JointPlacement,
    /// Index and pose of each link that the joint carries, including the moving link itself. Poses are in the joint frame;
    /// the order is the order of the file.
    pub carried: Vec<(usize, Pose)>,
}

/// All links of a robot, grouped by the moving link that carries them.
pub(super) struct MovingLinks {
    /// The moving links; an antecedent (parent) precedes its successors.
    pub moving: Vec<MovingLink>,
    /// Index and pose of the root link and of each link fixed to it. Poses are in the root frame.
    pub rooted: Vec<(usize, Pose)>,
}

/// Groups the links of a robot. `floating`: whether the base floats; then a robot without joints is allowed.
pub(super) fn moving_links(
    source: DescriptionFile,
    checked: &Checked,
    model: &urdf_rs::Robot,
    angles: AngleSnapping,
    floating: bool,
    snapped: &mut Vec<Note>,
) -> Result<MovingLinks, Error> {
    let link_index: BTreeMap<&str, usize> = model.links.iter().enumerate().map(|(k, l)| (l.name.as_str(), k)).collect();
    let tree = Tree::new(source, checked, model, &link_index)?;
    let mut moving: Vec<MovingLink> = Vec::new();
    let mut rooted = vec![(tree.root, Pose::IDENTITY)];
    let mut reached = vec![false; model.joints.len()];
    // Each entry of the stack has a joint to visit, the moving link that carries the joint (`None`: the root), and the pose of
    // the joint's parent link in the joint frame of this moving link.
    let mut stack: Vec<(usize, Option<usize>, Pose)> = Vec::new();
    let push = |link: usize, carrier, pose, stack: &mut Vec<_>| {
        stack.extend(tree.below[link].iter().rev().map(|&j| (j, carrier, pose)));
    };
    push(tree.root, None, Pose::IDENTITY, &mut stack);
    while let Some((j, carrier, parent)) = stack.pop() {
        reached[j] = true;
        let joint = &model.joints[j];
        let child = tree.child[j];
        let pose = parent.compose(&origin(joint, angles, snapped));
        let pose = Pose { rotation: angle_snap::exact(&pose.rotation), ..pose };
        if joint.joint_type == JointType::Fixed {
            carrier.map_or(&mut rooted, |i| &mut moving[i].carried).push((child, pose));
            push(child, carrier, pose, &mut stack);
            continue;
        }
        let axis = angle_snap::unit_axis(*joint.axis.xyz, angles).ok_or_else(|| {
            let message = format!("the axis of joint `{}` is zero: it needs a direction", shown(&joint.name));
            source.place(mark(checked, joint).map_or((0, 0), |m| m.axis_at), message)
        })?;
        note_axis(joint, axis, snapped);
        let prismatic = joint.joint_type == JointType::Prismatic;
        let given = JointPlacement { antecedent: carrier, pose, axis, prismatic };
        moving.push(MovingLink { joint: j, given, carried: vec![(child, Pose::IDENTITY)] });
        push(child, Some(moving.len() - 1), Pose::IDENTITY, &mut stack);
    }
    if let Some(j) = reached.iter().position(|r| !r) {
        let circle = tree.circle(model, j);
        let message = format!("the joints {} form a circle that nothing connects to the base", circle.join(", "));
        return Err(source.place(mark(checked, &model.joints[j]).map_or((0, 0), |m| m.at), message));
    }
    if moving.is_empty() && !floating {
        return Err(source.place(checked.at, "no joint of the robot moves; its base may float: [floating_base=true]"));
    }
    for carried in moving.iter_mut().map(|link| &mut link.carried).chain([&mut rooted]) {
        carried.sort_by_key(|c| c.0);
    }
    Ok(MovingLinks { moving, rooted })
}

/// Largest number of joints that are followed when a circle of joints is searched.
const MAX_CIRCLE_JOINTS: usize = 1000;
/// Number of joints of a circle that a message lists.
const LISTED_JOINTS: usize = 5;

struct Tree {
    /// Index of the only link that is no child of a joint.
    root: usize,
    /// For each link, indices of the joints that have it as parent, sorted by name.
    below: Vec<Vec<usize>>,
    /// For each joint, index of its parent link.
    parent: Vec<usize>,
    /// For each joint, index of its child link.
    child: Vec<usize>,
}

impl Tree {
    fn new(
        source: DescriptionFile,
        checked: &Checked,
        model: &urdf_rs::Robot,
        link_index: &BTreeMap<&str, usize>,
    ) -> Result<Tree, Error> {
        let mut below: Vec<Vec<usize>> = vec![Vec::new(); model.links.len()];
        let mut above: Vec<Option<usize>> = vec![None; model.links.len()];
        let (mut parents, mut children) = (Vec::new(), Vec::new());
        // Finds the joint above each link, and the joints below each link.
        for (j, joint) in model.joints.iter().enumerate() {
            let find = |role: &str, name: &str, at: fn(&JointMark) -> Position| {
                link_index.get(name).copied().ok_or_else(|| {
                    let meant = did_you_mean(name, link_index.keys().copied());
                    let message =
                        format!("the {role} of joint `{}` is no link: `{}`{meant}", shown(&joint.name), shown(name));
                    source.place(mark(checked, joint).map_or((0, 0), at), message)
                })
            };
            let parent = find("parent", &joint.parent.link, |m| m.parent_at)?;
            let child = find("child", &joint.child.link, |m| m.child_at)?;
            if let Some(first) = above[child].replace(j) {
                let message = format!(
                    "link `{}` has two parents: it is the child of joint `{}` and of joint `{}`; a URDF is a tree, a \
                     description in YAML has loops",
                    shown(&joint.child.link),
                    shown(&model.joints[first].name),
                    shown(&joint.name)
                );
                return Err(source.place(mark(checked, joint).map_or((0, 0), |m| m.child_at), message));
            }
            below[parent].push(j);
            parents.push(parent);
            children.push(child);
        }
        // As in Pinocchio, the joints of a link are sorted by name.
        for joints in &mut below {
            joints.sort_by_key(|&j| &model.joints[j].name);
        }
        let roots: Vec<usize> = (0..model.links.len()).filter(|&l| above[l].is_none()).collect();
        let at = |l: usize| checked.links.get(&model.links[l].name).map_or(checked.at, |m| m.at);
        let tree = |root| Tree { root, below, parent: parents, child: children };
        match roots[..] {
            [root] => Ok(tree(root)),
            [] if model.links.is_empty() => Err(source.place(checked.at, "the robot has no link")),
            [] => {
                let circle = tree(0).circle(model, 0).join(", ");
                let message = format!(
                    "every link is a child, so the joints {circle} form a circle and there is no base; a description in YAML has loops"
                );
                Err(source.place(checked.at, message))
            }
            [first, second, ..] => {
                let message = format!(
                    "a robot has one root, found `{}` and `{}`: join them with a joint",
                    shown(&model.links[first].name),
                    shown(&model.links[second].name)
                );
                Err(source.place(at(second), message))
            }
        }
    }

    /// Names of the joints that form the circle above a joint, for a message.
    fn circle(&self, model: &urdf_rs::Robot, start: usize) -> Vec<String> {
        let above: BTreeMap<usize, usize> = self.child.iter().enumerate().map(|(j, &link)| (link, j)).collect();
        let mut seen: Vec<usize> = Vec::new();
        let mut at = Some(start);
        while let Some(j) = at {
            if let Some(k) = seen.iter().position(|&s| s == j) {
                let names = seen[k..].iter().rev().map(|&j| format!("`{}`", shown(&model.joints[j].name)));
                return names.collect();
            }
            seen.push(j);
            // For a very long circle, the message lists only the first joints.
            if seen.len() > MAX_CIRCLE_JOINTS {
                break;
            }
            at = above.get(&self.parent[j]).copied();
        }
        seen.iter().take(LISTED_JOINTS).map(|&j| format!("`{}`", shown(&model.joints[j].name))).collect()
    }
}

fn mark<'a>(checked: &'a Checked, joint: &urdf_rs::Joint) -> Option<&'a JointMark> {
    checked.joints.get(&joint.name)
}

/// Pose of the joint frame in the frame of the parent link. Rounded angles are replaced by exact ones, with notes.
fn origin(joint: &urdf_rs::Joint, angles: AngleSnapping, snapped: &mut Vec<Note>) -> Pose {
    let given = *joint.origin.rpy;
    let rpy: [Value; 3] = given.map(|angle| angle_snap::given_angle(angle, angles));
    for ((name, given), taken) in ["roll", "pitch", "yaw"].into_iter().zip(given).zip(&rpy) {
        snapped.extend(angle_snap::note_of(&joint.name, name, given, taken));
    }
    let position = joint.origin.xyz.map(|x| angle_snap::given_length(x, angles));
    Pose { rotation: angle_snap::rotation(&rpy), position }
}

fn note_axis(joint: &urdf_rs::Joint, axis: [f64; 3], snapped: &mut Vec<Note>) {
    let given = *joint.axis.xyz;
    let largest = given.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    // The axis was set to a coordinate axis if it has exactly one entry that is not zero. If other entries were set to zero to
    // achieve this, a note is added.
    let along = axis.iter().filter(|x| **x != 0.0).count() == 1;
    let left_out =
        given.iter().zip(axis).any(|(g, a)| a == 0.0 && g.abs() > angle_snap::UNNOTED_DIFFERENCE_RAD * largest);
    if along && left_out {
        let text = format!("axis {given:?} is taken as {axis:?}");
        snapped.push(Note { subject: joint.name.clone(), text });
    }
}
