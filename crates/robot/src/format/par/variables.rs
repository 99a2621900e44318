//! Determines which names in a .par file are joint variables and which are constants.
//!
//! The file does not distinguish them. A name that occurs in a constant (gamma, b, alpha, d, the r of a revolute joint, gravity,
//! the value of a symbol) is a constant. If a remaining name occurs in the variable of an actuated joint, it is the coordinate of
//! this joint. If it occurs in the variable of a passive joint, it is the passive coordinate of this joint, unless it is the
//! coordinate of another joint: then the passive joint follows the other joint. If several names remain in the variable of a
//! joint, the name that ends with the number of the joint is used (`th4` in `th4 - DEL` of joint 4).

use std::collections::BTreeSet;

use super::table::text;
use crate::error::Error;
use crate::format::expression::identifiers;
use crate::format::node::{DescriptionFile, Node};
use crate::robot::Robot;
use crate::value::CoordinateId;

/// A joint for which the name of its variable must be determined.
pub(super) struct Mover<'a> {
    /// Number of the joint's frame.
    pub frame: usize,
    pub actuated: bool,
    pub variable: &'a Node,
}

/// The name of the own variable of each joint in `movers`. `None` for a joint that follows other joints or does not move. Fails
/// if several names are possible.
pub(super) fn own_variables(
    source: DescriptionFile,
    movers: &[Mover],
    constants: &BTreeSet<&str>,
) -> Result<Vec<Option<String>>, Error> {
    let mut own: Vec<Option<String>> = vec![None; movers.len()];
    let names = |m: &Mover| -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for word in identifiers(text(m.variable)).filter(|w| !constants.contains(w)) {
            if !names.iter().any(|n| n == word) {
                names.push(word.to_string());
            }
        }
        names
    };
    for actuated in [true, false] {
        for k in (0..movers.len()).filter(|&k| movers[k].actuated == actuated) {
            let mover = &movers[k];
            let candidates = names(mover);
            let owner = |name: &String| own.iter().position(|o| o.as_ref() == Some(name));
            let free: Vec<&String> = candidates.iter().filter(|n| owner(n).is_none()).collect();
            let numbered = || free.iter().find(|n| number_of(n) == Some(mover.frame)).copied();
            own[k] = match (&free[..], candidates.first()) {
                ([], Some(taken)) if actuated => {
                    let first = owner(taken).map_or(0, |i| movers[i].frame);
                    let message = format!(
                        "`{taken}` is the variable of joint {first} already: give joint {} its own, or mu = 0 where it \
                         follows",
                        mover.frame
                    );
                    return Err(source.at(mover.variable, message));
                }
                ([], _) => None,
                // Some names in the expression are variables of other joints, so this joint follows these joints. The only
                // remaining name is then a constant angle, not a variable of this joint.
                ([_], _) if free.len() < candidates.len() && numbered().is_none() => None,
                ([name], _) => Some((*name).clone()),
                _ => match numbered() {
                    Some(name) => Some(name.clone()),
                    None if free.len() < candidates.len() => None,
                    None => {
                        let listed: Vec<&str> = free.iter().map(|n| n.as_str()).collect();
                        let message = format!(
                            "which of `{}` is the variable of joint {}? Give one of them its number (th{})",
                            listed.join("`, `"),
                            mover.frame,
                            mover.frame
                        );
                        return Err(source.at(mover.variable, message));
                    }
                },
            };
        }
    }
    Ok(own)
}

/// Scales each passive coordinate so that its joint moves by the coordinate itself, not by a multiple (`-th2`, `2*th2`). The
/// scale of a passive coordinate is arbitrary, and the relations between passive joints are searched in the units of the joints.
pub(super) fn passive_by_its_joint(robot: &mut Robot) {
    let n = robot.n_coordinates();
    for k in (0..robot.passive.len()).map(|p| CoordinateId(n + p)) {
        let of_links = robot.links.iter().map(|link| &link.joint.variable);
        let of_loops = robot.loops.iter().flat_map(|one| [&one.cut.variable, &one.twin.variable]);
        let own = of_links.chain(of_loops).find_map(|variable| match variable.terms[..] {
            [(of, multiple)] if of == k => Some(multiple),
            _ => None,
        });
        let Some(multiple) = own.filter(|multiple| *multiple != 1.0) else { continue };
        let of_links = robot.links.iter_mut().map(|link| &mut link.joint.variable);
        let of_loops = robot.loops.iter_mut().flat_map(|one| [&mut one.cut.variable, &mut one.twin.variable]);
        let terms = of_links.chain(of_loops).flat_map(|variable| &mut variable.terms);
        terms.filter(|(of, _)| *of == k).for_each(|(_, c)| *c /= multiple);
    }
}

/// The number at the end of a name: 12 for `th12`.
fn number_of(name: &str) -> Option<usize> {
    let digits = name
        .rfind(|c: char| !c.is_ascii_digit())
        .map_or(0, |at| at + name[at..].chars().next().map_or(1, char::len_utf8));
    name[digits..].parse().ok()
}
