//! The tree of the links of a model, from its base outwards.
//!
//! The joint that carries a link connects the link to its parent. A second joint to the same link closes a loop and is not
//! read. A floating base is a base with six coordinates.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::element::{Mistake, children, note, wrong};
use super::frames::{Frames, WORLD, links};
use super::joints::{JointType, SdfJoint, joints};
use gate::suggestion::did_you_mean;
use robot::format::{DescriptionBody, DescriptionJoint, ReadOptions, RobotDescription};
use robot::vector::turned_back;
use robot::{Part, Pose};

/// Adds the joints and bodies of a model. `bodies`: pose in the model and inertial of each link, in the order of the file.
///
/// Fails if the links form no tree, or if a joint that carries a link has another type.
pub(super) fn grow<'a>(
    model: Node<'a, 'a>,
    frames: &Frames<'a>,
    bodies: Vec<(Pose, Option<Part>)>,
    described: &mut RobotDescription,
    options: ReadOptions,
) -> Result<(), Mistake> {
    let links = links(model);
    let Some(first) = links.first().copied() else { return Err(wrong(model, "the model has no link")) };
    let joints = joints(model, frames)?;
    let above = above(&joints, first, described)?;
    let (is_held, root) = root(model, &links, &joints, &above, options, described)?;
    // The base frame is the frame of the world, or of the link that floats.
    let base = if options.floating_base { frames.pose(root)? } else { frames.pose(WORLD)? };
    if options.floating_base {
        let world = frames.pose(WORLD)?.inverse().compose(&base);
        described.gravity = turned_back(&world.rotation, described.gravity);
    }
    let mut parts: BTreeMap<&str, (Pose, Option<Part>)> = links.iter().copied().zip(bodies).collect();
    // Each entry: a link, the joint that carries it, and the pose of the frame of this joint in the model.
    let mut stack = vec![(if is_held { WORLD } else { root }, None, base)];
    let mut index = BTreeMap::new();
    while let Some((link, carrier, frame)) = stack.pop() {
        if let Some((pose, part)) = parts.remove(link) {
            let one = DescriptionBody { name: link.into(), pose: frame.inverse().compose(&pose), part };
            carrier.map_or(&mut described.base, |k: usize| &mut described.joints[k].bodies).push(one);
        }
        for (k, joint) in joints.iter().enumerate().rev() {
            let child = joint.child.unwrap_or(first);
            if joint.parent.unwrap_or(first) != link || above.get(child) != Some(&k) {
                continue;
            }
            if joint.kind == JointType::Fixed {
                stack.push((child, carrier, frame));
            } else {
                let pose = frames.pose(joint.name())?;
                index.insert(joint.name(), described.joints.len());
                let one = moving(joint, child, frames, (carrier, &frame, &pose), described)?;
                described.joints.push(one);
                stack.push((child, Some(described.joints.len() - 1), pose));
            }
        }
    }
    if let Some(link) = links.iter().find(|link| parts.contains_key(**link)) {
        return Err(wrong(model, format!("link `{link}` is not connected to the base")));
    }
    follow(&joints, &index, options, described)
}

/// For each link, the joint that carries it. If a second joint leads to the same link, this joint closes a loop.
fn above<'a>(
    joints: &[SdfJoint<'a>],
    first: &'a str,
    described: &mut RobotDescription,
) -> Result<BTreeMap<&'a str, usize>, Mistake> {
    let mut above: BTreeMap<&str, usize> = BTreeMap::new();
    // Joints of readable types come first, so that a joint of another type does not carry a link if this can be avoided.
    let mut order: Vec<usize> = (0..joints.len()).collect();
    order.sort_by_key(|k| joints[*k].kind == JointType::Other);
    for k in order {
        let joint = &joints[k];
        let child = joint.child.unwrap_or(first);
        if child == WORLD || child == joint.parent.unwrap_or(first) {
            return Err(wrong(
                joint.node,
                format!("joint `{}` moves the world, or a link against itself", joint.name()),
            ));
        }
        if above.contains_key(child) {
            let text = format!("closes a loop at `{child}`, which is not read: the robot is taken cut open there");
            note(described, joint.name(), text);
            continue;
        }
        if joint.kind == JointType::Other {
            let kind = joint.node.attribute("type").unwrap_or("");
            let message = format!(
                "joint `{}` is of type `{kind}`; revolute, continuous, prismatic and fixed ones are read",
                joint.name()
            );
            return Err(wrong(joint.node, message));
        }
        above.insert(child, k);
    }
    Ok(above)
}

/// Whether a joint fixes the model to the world, and the root link.
fn root<'a>(
    model: Node<'a, 'a>,
    links: &[&'a str],
    joints: &[SdfJoint<'a>],
    above: &BTreeMap<&'a str, usize>,
    options: ReadOptions,
    described: &mut RobotDescription,
) -> Result<(bool, &'a str), Mistake> {
    // Without a joint to the world, the only link that no joint carries is the root. With such a joint, joints must carry all
    // links: the tree then begins at the world, and the returned link is not used.
    let is_held = joints.iter().any(|joint| joint.parent == Some(WORLD));
    let free: Vec<&str> = links.iter().copied().filter(|link| !above.contains_key(link)).collect();
    match (is_held, &free[..]) {
        (true, []) if options.floating_base => {
            let joint = children(model, "joint").next().unwrap_or(model);
            Err(wrong(
                joint,
                "a joint holds the model to the world, so its base does not float: leave out [floating_base]",
            ))
        }
        (true, []) => Ok((true, links[0])),
        (false, [root]) => {
            if !options.floating_base {
                let text = format!(
                    "no joint holds `{root}` to the world: it is taken as fixed, as of a URDF, unless a floating base is asked for"
                );
                note(described, "base", text);
            }
            Ok((false, root))
        }
        (false, []) => Err(wrong(model, "every link is the child of a joint, so there is no base")),
        _ => {
            let message = format!("a robot has one root, found {}: join them by fixed joints", free.join(", "));
            Err(wrong(model, if is_held { format!("{message}, or to the world") } else { message }))
        }
    }
}

/// Describes a joint that moves. `antecedent`, `carrier`: index and pose of the joint that carries this joint; `pose`: pose of
/// this joint. Both poses are in the frame of the model.
fn moving(
    joint: &SdfJoint,
    child: &str,
    frames: &Frames,
    (antecedent, carrier, pose): (Option<usize>, &Pose, &Pose),
    described: &mut RobotDescription,
) -> Result<DescriptionJoint, Mistake> {
    let (limits, friction) = joint.dynamics(described)?;
    let at = joint.node.document().text_pos_at(joint.node.range().start);
    Ok(DescriptionJoint {
        name: joint.name().into(),
        at: (at.row as usize, at.col as usize),
        antecedent,
        pose: carrier.inverse().compose(pose),
        axis: joint.axis(frames, pose)?,
        prismatic: joint.kind == JointType::Prismatic,
        follows: None,
        limits,
        friction,
        link: child.into(),
        bodies: Vec::new(),
    })
}

/// Lets the joints with `<mimic>` follow their leaders.
fn follow(
    joints: &[SdfJoint],
    index: &BTreeMap<&str, usize>,
    options: ReadOptions,
    described: &mut RobotDescription,
) -> Result<(), Mistake> {
    for joint in joints {
        let Some(k) = index.get(joint.name()) else { continue };
        let Some((leader, multiplier, offset)) = joint.mimics(options, described)? else { continue };
        let Some(found) = index.get(leader) else {
            let meant = did_you_mean(leader, index.keys().copied());
            let message = format!("joint `{}` mimics `{leader}`, which is no joint that moves{meant}", joint.name());
            return Err(wrong(joint.node, message));
        };
        described.joints[*k].follows = Some((*found, multiplier, offset));
    }
    Ok(())
}
