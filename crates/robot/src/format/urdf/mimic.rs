//! Reads the `<mimic>` elements of a URDF.

use std::collections::BTreeMap;

use super::text::Checked;
use crate::error::Error;
use crate::format::follows::{Follows, resolved};
use crate::format::node::DescriptionFile;
use crate::format::options::Mimic;
use crate::format::shown::shown;
use gate::suggestion::did_you_mean;

/// For each joint of the file, its relation to the joint that it follows (the leader). A joint that mimics no other follows
/// itself.
pub(super) fn followed(
    source: DescriptionFile,
    checked: &Checked,
    model: &urdf_rs::Robot,
    mimic: Mimic,
) -> Result<Vec<Follows>, Error> {
    let index: BTreeMap<&str, usize> = model.joints.iter().enumerate().map(|(k, j)| (j.name.as_str(), k)).collect();
    let place = |j: usize| checked.joints.get(&model.joints[j].name).map_or((0, 0), |m| m.mimic_at);
    let mut next: Vec<Option<Follows>> = Vec::with_capacity(model.joints.len());
    for (j, joint) in model.joints.iter().enumerate() {
        // If mimic joints are read as independent coordinates, no leader is searched.
        let Some(tag) = joint.mimic.as_ref().filter(|_| mimic == Mimic::Constraint) else {
            next.push(None);
            continue;
        };
        let Some(&leader) = index.get(tag.joint.as_str()) else {
            let meant = did_you_mean(&tag.joint, index.keys().copied());
            let (name, other) = (shown(&joint.name), shown(&tag.joint));
            let remedy = "with [mimic=independent] each is a coordinate of its own";
            let message = format!("joint `{name}` mimics `{other}`, which is no joint{meant}; {remedy}");
            return Err(source.place(place(j), message));
        };
        let (multiplier, offset) = (tag.multiplier.unwrap_or(1.0), tag.offset.unwrap_or(0.0));
        next.push(Some(Follows { leader, multiplier, offset }));
    }
    resolved(&next, |j| &model.joints[j].name).map_err(|(j, message)| source.place(place(j), message))
}
