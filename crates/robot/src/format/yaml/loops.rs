//! Reads the loops of a YAML description: pairs of frames that coincide in every configuration.

use super::convention::Convention;
use super::link::{Draft, find_link, joint_kind, passive_coordinate, placement};
use crate::closure;
use crate::error::Error;
use crate::format::expression::KnownNames;
use crate::format::node::{DescriptionFile, Node};
use crate::robot::{JointKind, Loop, LoopFrame, PassiveCoordinate, Robot};

/// The keys of a loop frame, except the keys of its placement.
const FRAME_KEYS: [&str; 3] = ["antecedent", "joint", "start"];

/// Reads `loops: [{cut: {..}, twin: {..}}]`: the frames on both sides of the cut of each loop. By default, a cut is a revolute
/// joint and a twin is fixed to its link. A cut without a variable gets a passive coordinate.
pub(super) fn loops(
    source: DescriptionFile,
    node: &Node,
    names: &KnownNames,
    drafts: &[Draft],
    convention: Convention,
    passive: &mut Vec<PassiveCoordinate>,
) -> Result<Vec<Loop>, Error> {
    if !convention.has_loops() {
        let message = "loops are written with `convention: khalil-kleinfinger` or `craig`, whose frames stand at the near \
                       ends of links";
        return Err(source.at(node, message));
    }
    let mut loops = Vec::new();
    for (k, item) in node.list(source, "`loops`")?.iter().enumerate() {
        let fields = item.fields(source, "a loop", &["cut", "twin"])?;
        let mut frame = |key: &str, kind| {
            loop_frame(source, fields.require(key)?, names, drafts, (k, convention), key, kind, passive)
        };
        loops.push(Loop { cut: frame("cut", JointKind::Revolute)?, twin: frame("twin", JointKind::Fixed)? });
    }
    Ok(loops)
}

fn loop_frame(
    source: DescriptionFile,
    node: &Node,
    names: &KnownNames,
    drafts: &[Draft],
    (k, convention): (usize, Convention),
    key: &str,
    default: JointKind,
    passive: &mut Vec<PassiveCoordinate>,
) -> Result<LoopFrame, Error> {
    let what = format!("the {key} of loop {}", k + 1);
    let keys = [&FRAME_KEYS[..2], convention.placement_keys(), &FRAME_KEYS[2..]].concat();
    let fields = node.fields(source, &what, &keys)?;
    let carrier = fields.require("antecedent")?;
    let word = carrier.word(source, "`antecedent`")?;
    let antecedent =
        find_link(drafts, &word, drafts.len()).map_err(|e| source.at(carrier, format!("antecedent of {what}: {e}")))?;
    let kind = joint_kind(source, &fields, default)?;
    let kinds = (kind, convention);
    let unknown = passive_coordinate(source, names, &fields, kinds, &format!("{key}{}", k + 1), passive)?;
    let (geometry, variable) = placement(source, names, &fields, &what, kinds, unknown)?;
    Ok(LoopFrame { antecedent, geometry, kind, variable })
}

/// Fails if a loop does not close. The message states the gap.
pub(super) fn check_closure(source: DescriptionFile, node: Option<&Node>, robot: &Robot) -> Result<(), Error> {
    let Some(node) = node else { return Ok(()) };
    let items = node.list(source, "`loops`")?;
    closure::check(robot).map_err(|(k, message)| source.at(&items[k], message))
}

/// Fails if a passive joint has no expression for its variable and belongs to no loop, because nothing determines its motion.
pub(super) fn check_passive(source: DescriptionFile, robot: &Robot, drafts: &[Draft]) -> Result<(), Error> {
    let mut in_loop = vec![false; robot.links.len()];
    for frame in robot.loops.iter().flat_map(|l| [&l.cut, &l.twin]) {
        for j in std::iter::successors(frame.antecedent, |&j| robot.link(j).antecedent) {
            in_loop[j.0] = true;
        }
    }
    for (j, (link, draft)) in robot.links.iter().zip(drafts).enumerate() {
        let unknown = link.joint.variable.terms.iter().any(|t| t.0.0 >= robot.n_coordinates());
        if unknown && !in_loop[j] {
            let message = format!(
                "{} of passive link {} is missing, and no loop passes through it: nothing says how it moves",
                draft.variable_key(),
                draft.label
            );
            return Err(source.at(draft.node, message));
        }
    }
    Ok(())
}
