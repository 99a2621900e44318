//! Checks that the links, and the pairs of links, exist that the user names in the rules for distances.

use robot::JointKind;

use crate::clearance::Clearance;
use crate::gaps::ClearanceRules;

impl Clearance {
    /// Fails if a rule names an unknown link.
    pub(crate) fn check_names(&self, rules: &ClearanceRules) -> Result<(), String> {
        let known = |name: &str| {
            self.bodies.iter().any(|b| b.name == name || b.carrier == name || b.frames.iter().any(|f| f == name))
        };
        let pairs = rules.accepted.iter().flat_map(|(a, b, _)| [a, b]);
        let walls = rules.half_spaces.iter().filter_map(|h| h.links.as_ref()).flatten();
        match pairs.chain(walls).find(|name| !known(name)) {
            None => Ok(()),
            Some(name) => {
                let names: Vec<&str> = self.bodies.iter().map(|b| b.name.as_str()).collect();
                Err(format!("there is no link `{name}`; there are {}", names.join(", ")))
            }
        }
    }

    /// Fails if a pair of links that the user accepts does not exist: both links need bodies, and a joint must move them relative
    /// to each other.
    pub(crate) fn check_accepted(&self, rules: &ClearanceRules) -> Result<(), String> {
        let is_moved =
            |joints: [Vec<usize>; 2]| joints.iter().flatten().any(|&j| self.tree.kind(j) != JointKind::Fixed);
        for (a, b, _) in &rules.accepted {
            let fault = match [a, b].map(|name| self.bodies.iter().find(|body| body.name == *name)) {
                [Some(body), Some(other)] if is_moved(self.between(body.link, other.link)) => continue,
                [Some(_), Some(_)] => "no joint moves them against each other".to_string(),
                found => {
                    let bare: Vec<&str> =
                        [a, b].into_iter().zip(found).filter(|(_, f)| f.is_none()).map(|(n, _)| n.as_str()).collect();
                    format!("{} has no body of its own", bare.join(", nor "))
                }
            };
            return Err(format!(
                "space: accept has [{a}, {b}], which is no pair that is looked at: {fault}; leave it out"
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gaps::tests::{ARM, clearance_of};

    #[test]
    fn an_accepted_pair_is_one() {
        let accepting = |a: &str, b: &str| ClearanceRules {
            accepted: vec![(a.into(), b.into(), "a cover is soft".into())],
            ..ClearanceRules::default()
        };
        let still = ARM.replace("</robot>", "<joint name=\"f\" type=\"fixed\"><parent link=\"hand\"/><child link=\"tip\"/></joint><link name=\"tip\"><collision><geometry><sphere radius=\"0.01\"/></geometry></collision></link></robot>");
        let unpaired = |a, b| clearance_of(&still, &accepting(a, b)).err();
        assert_eq!(unpaired("tip", "post"), None);
        for (a, b, why) in [
            ("tip", "hand", "no joint moves them against each other"),
            ("fore", "fore", "no joint moves them against each other"),
            ("base", "fore", "base has no body of its own"),
        ] {
            let said = format!("space: accept has [{a}, {b}], which is no pair that is looked at: {why}; leave it out");
            assert_eq!(unpaired(a, b), Some(said));
        }
    }
}
