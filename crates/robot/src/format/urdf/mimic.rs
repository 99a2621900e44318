//! Mimic joints: q = multiplier q_other + offset, through chains of them down to a coordinate.

use std::collections::BTreeMap;

use super::shown::shown;
use super::text::Checked;
use crate::angle_snap::{computed_angle, computed_length};
use crate::error::Error;
use crate::format::node::Source;
use crate::format::options::Mimic;
use crate::format::suggestion::did_you_mean;
use crate::robot::{Coordinate, Limits, ModifiedDh};
use crate::value::Value;

/// A joint's position: multiplier times that of a joint that mimics nobody, plus offset, rad or m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Follows {
    /// Index in the file's joints.
    pub leader: usize,
    pub multiplier: f64,
    pub offset: f64,
}

impl Follows {
    /// Puts the constant part where the geometry has it.
    pub(super) fn shift(&self, geometry: &mut ModifiedDh, prismatic: bool) {
        if self.offset == 0.0 {
            return;
        }
        let shifted = |value: &Value| value.number(&[]) + self.offset;
        match prismatic {
            true => geometry.r = computed_length(shifted(&geometry.r)),
            false => geometry.theta = computed_angle(shifted(&geometry.theta)),
        }
    }

    /// Narrows the range of the coordinate to where this joint's own limits hold.
    pub(super) fn narrow(&self, leader: &mut Coordinate, own: Limits) {
        let Some((low, high)) = own.position else { return };
        if self.multiplier == 0.0 {
            return;
        }
        let at = |x: f64| (x - self.offset) / self.multiplier;
        let (a, b) = (at(low).min(at(high)), at(low).max(at(high)));
        let (low, high) = leader.limits.position.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let narrowed = (low.max(a), high.min(b));
        if narrowed.0 <= narrowed.1 {
            leader.limits.position = Some(narrowed);
        }
    }
}

/// What each joint of the file follows. A joint that mimics no other follows itself.
pub(super) fn followed(
    source: Source,
    checked: &Checked,
    model: &urdf_rs::Robot,
    mimic: Mimic,
) -> Result<Vec<Follows>, Error> {
    let index: BTreeMap<&str, usize> = model.joints.iter().enumerate().map(|(k, j)| (j.name.as_str(), k)).collect();
    let place = |j: usize| checked.joints.get(&model.joints[j].name).map_or((0, 0), |m| m.mimic_at);
    let mut next: Vec<Option<Follows>> = Vec::with_capacity(model.joints.len());
    for (j, joint) in model.joints.iter().enumerate() {
        // Where mimic joints are read as coordinates of their own, no leader is looked up.
        let Some(tag) = joint.mimic.as_ref().filter(|_| mimic == Mimic::Constraint) else {
            next.push(None);
            continue;
        };
        let Some(&leader) = index.get(tag.joint.as_str()) else {
            let meant = did_you_mean(&tag.joint, index.keys().copied());
            let (name, other) = (shown(&joint.name), shown(&tag.joint));
            return Err(source.place(place(j), format!("joint `{name}` mimics `{other}`, which is no joint{meant}")));
        };
        let (multiplier, offset) = (tag.multiplier.unwrap_or(1.0), tag.offset.unwrap_or(0.0));
        next.push(Some(Follows { leader, multiplier, offset }));
    }
    let mut follows = Vec::with_capacity(next.len());
    for start in 0..next.len() {
        let mut at = Follows { leader: start, multiplier: 1.0, offset: 0.0 };
        let mut steps = 0;
        while let Some(on) = next[at.leader] {
            at = Follows {
                leader: on.leader,
                multiplier: at.multiplier * on.multiplier,
                offset: at.offset + at.multiplier * on.offset,
            };
            steps += 1;
            if steps > next.len() {
                let name = shown(&model.joints[start].name);
                let message =
                    format!("joint `{name}` mimics joints that run in a circle: none of them moves by itself");
                return Err(source.place(place(start), message));
            }
        }
        if !(at.multiplier.is_finite() && at.offset.is_finite()) {
            let name = shown(&model.joints[start].name);
            return Err(
                source.place(place(start), format!("the mimic factors of joint `{name}` have no finite product"))
            );
        }
        follows.push(at);
    }
    Ok(follows)
}
