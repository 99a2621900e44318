//! Joints that follow another joint (their leader): q = multiplier q_leader + offset. If joints follow each other in a chain,
//! the leader of each of them is the joint at the end of the chain, which follows no other joint.

use crate::angle_snap::{computed_angle, computed_length};
use crate::format::shown::shown;
use crate::robot::{Coordinate, Limits, ModifiedDh};
use crate::value::Value;

/// The relation of a joint to its leader: its position is multiplier times the leader's position plus offset, rad or m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::format) struct Follows {
    /// Index of the leader among the joints of the file.
    pub leader: usize,
    pub multiplier: f64,
    pub offset: f64,
}

impl Follows {
    /// Adds the offset of this joint to its geometry: to r of a prismatic joint, or to theta of a revolute joint.
    pub(in crate::format) fn shift(&self, geometry: &mut ModifiedDh, prismatic: bool) {
        if self.offset == 0.0 {
            return;
        }
        let shifted = |value: &Value| value.number(&[]) + self.offset;
        match prismatic {
            true => geometry.r = computed_length(shifted(&geometry.r)),
            false => geometry.theta = computed_angle(shifted(&geometry.theta)),
        }
    }

    /// Narrows the limits of the leader's coordinate, so that this joint, which follows it, stays within its limits `own` too.
    pub(in crate::format) fn narrow(&self, leader: &mut Coordinate, own: Limits) {
        if self.multiplier == 0.0 {
            return;
        }
        let slower = |leader: &mut Option<f64>, own: Option<f64>| {
            let own = own.map(|x| x / self.multiplier.abs());
            *leader = leader.map_or(own, |x| Some(own.map_or(x, |own| x.min(own))));
        };
        slower(&mut leader.limits.velocity, own.velocity);
        slower(&mut leader.limits.acceleration, own.acceleration);
        let Some((low, high)) = own.position else { return };
        let at = |x: f64| (x - self.offset) / self.multiplier;
        let (a, b) = (at(low).min(at(high)), at(low).max(at(high)));
        let (low, high) = leader.limits.position.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let narrowed = (low.max(a), high.min(b));
        if narrowed.0 <= narrowed.1 {
            leader.limits.position = Some(narrowed);
        }
    }
}

/// For each joint, its relation to its final leader (the joint that follows no other). `next`: relation of each joint to the
/// joint that it follows directly. `name`: name of a joint.
///
/// Fails with a joint and a message if joints follow each other in a circle, or if factors overflow.
pub(in crate::format) fn resolved<'a>(
    next: &[Option<Follows>],
    name: impl Fn(usize) -> &'a str,
) -> Result<Vec<Follows>, (usize, String)> {
    let mut follows = Vec::with_capacity(next.len());
    for start in 0..next.len() {
        let mut at = Follows { leader: start, multiplier: 1.0, offset: 0.0 };
        let mut steps = 0;
        // From q = m q_l + o and q_l = m' q_n + o' follows q = m m' q_n + (o + m o'). m: multiplier; o: offset; l: leader so
        // far; n: the joint that l follows.
        while let Some(on) = next[at.leader] {
            at = Follows {
                leader: on.leader,
                multiplier: at.multiplier * on.multiplier,
                offset: at.offset + at.multiplier * on.offset,
            };
            steps += 1;
            // A chain without a circle has fewer steps than there are joints.
            if steps > next.len() {
                let name = shown(name(start));
                let message =
                    format!("joint `{name}` mimics joints that run in a circle: none of them moves by itself");
                return Err((start, message));
            }
        }
        if !(at.multiplier.is_finite() && at.offset.is_finite()) {
            let name = shown(name(start));
            return Err((start, format!("the mimic factors of joint `{name}` have no finite product")));
        }
        follows.push(at);
    }
    Ok(follows)
}
