//! Adds links of unknown shape to the list of what is not checked.

use crate::clearance::Clearance;
use claims::{LeftOut, LeftOutTopic};

impl Clearance {
    /// Lists the bodies that cannot be checked: bodies with a mesh that cannot be read, and bodies without geometry.
    pub(crate) fn leave_out_unknown_links(&mut self) {
        let unread = self.bodies.iter().filter(|b| !b.missing.is_empty());
        let unread = unread.map(|b| {
            let remedy = "a mesh that can be read";
            LeftOut::not_looked_at(LeftOutTopic::Distance, vec![b.name.clone()], b.missing.join("; "), remedy)
        });
        let bare = self.bodies.iter().filter(|b| b.link.is_some() && !b.has_geometry);
        let bare: Vec<String> = bare.map(|b| b.name.clone()).collect();
        let moving = self.bodies.iter().filter(|b| b.link.is_some()).count();
        let of = if bare.len() == moving { vec![] } else { bare.clone() };
        let why = match of.is_empty() {
            true => "the description has no collision geometry",
            false => "the description has no collision geometry of them",
        };
        let bare = (!bare.is_empty())
            .then(|| LeftOut::not_looked_at(LeftOutTopic::Distance, of, why, "collision geometry in the description"));
        let found: Vec<LeftOut> = unread.chain(bare).collect();
        self.left_out.extend(found);
    }
}
