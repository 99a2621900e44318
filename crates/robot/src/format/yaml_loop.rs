//! The loops of a YAML description: pairs of frames that coincide wherever the robot goes.

use super::expression::Names;
use super::node::{Node, Source};
use super::yaml::find_link;
use super::yaml_link::{Draft, joint_kind, placement};
use crate::closure;
use crate::error::Error;
use crate::link::{JointKind, Loop, LoopFrame, Robot};

const FRAME_KEYS: [&str; 8] = ["antecedent", "joint", "gamma", "b", "alpha", "d", "theta", "r"];

/// Reads `loops: [{cut: {..}, twin: {..}}]`; a cut moves as a revolute joint unless it says
/// otherwise, a twin is fixed to its link.
pub(super) fn loops(source: Source, node: &Node, names: &Names, drafts: &[Draft]) -> Result<Vec<Loop>, Error> {
    let mut loops = Vec::new();
    for (k, item) in node.list(source, "`loops`")?.iter().enumerate() {
        let fields = item.fields(source, "a loop", &["cut", "twin"])?;
        let frame = |key: &str, kind| loop_frame(source, fields.require(key)?, names, drafts, k, key, kind);
        loops.push(Loop { cut: frame("cut", JointKind::Revolute)?, twin: frame("twin", JointKind::Fixed)? });
    }
    Ok(loops)
}

fn loop_frame(
    source: Source,
    node: &Node,
    names: &Names,
    drafts: &[Draft],
    k: usize,
    key: &str,
    default: JointKind,
) -> Result<LoopFrame, Error> {
    let what = format!("the {key} of loop {}", k + 1);
    let fields = node.fields(source, &what, &FRAME_KEYS)?;
    let carrier = fields.require("antecedent")?;
    let word = carrier.word(source, "`antecedent`")?;
    let antecedent =
        find_link(drafts, &word, drafts.len()).map_err(|e| source.at(carrier, format!("antecedent of {what}: {e}")))?;
    let kind = joint_kind(source, &fields, default)?;
    let (geometry, variable) = placement(source, names, &fields, &what, kind)?;
    Ok(LoopFrame { antecedent, geometry, kind, variable })
}

/// Refuses loops that do not close, with the distance left.
pub(super) fn check_closure(source: Source, node: Option<&Node>, robot: &Robot) -> Result<(), Error> {
    let Some(node) = node else { return Ok(()) };
    for (k, item) in node.list(source, "`loops`")?.iter().enumerate() {
        let gap = closure::largest_gap(robot, &robot.loops[k]);
        if gap.position > closure::TOLERANCE || gap.orientation > closure::TOLERANCE {
            let at: Vec<String> = gap.q.iter().map(|x| format!("{x:.3}")).collect();
            let message = format!(
                "loop {} does not close: its cut and twin frames are {:.3e} m and {:.3e} rad apart at q = [{}]; both \
                 must stay below {:e}",
                k + 1,
                gap.position,
                gap.orientation,
                at.join(", "),
                closure::TOLERANCE
            );
            return Err(source.at(item, message));
        }
    }
    Ok(())
}
