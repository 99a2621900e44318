//! Writes the meaning of a base parameter in words, from its rule: `first moment of forearm along x, with what wrist_1
//! to tool add to it`.
//!
//! A base parameter is a standard parameter plus multiples of absorbed standard parameters. Absorbed parameters of the same
//! link are named one by one. For absorbed parameters of other links, only the links are named; the rule has the coefficients.

use robot::{Inertial, LinkId, Robot, StandardParameter};

use crate::base::base_parameters::{BaseParameters, WeakParameter};

impl BaseParameters {
    /// The meaning in words of base parameter number k of `robot`.
    pub fn meaning(&self, robot: &Robot, k: usize) -> String {
        let base = &self.base[k];
        let own = self.standard[base.column];
        let mut text = standard_meaning(robot, own);
        let others: Vec<(StandardParameter, f64)> =
            base.terms.iter().skip(1).map(|t| (self.standard[t.parameter], t.coefficient)).collect();
        let same = others.iter().filter(|(p, _)| p.link == own.link);
        let same: Vec<String> = same.map(|&(p, factor)| joined(own.inertial, p.inertial, factor)).collect();
        if !same.is_empty() {
            text += &format!(", {}", same.join(", "));
        }
        let mut links: Vec<LinkId> = others.iter().map(|(p, _)| p.link).filter(|link| *link != own.link).collect();
        links.sort_unstable_by_key(|link| link.0);
        links.dedup();
        if !links.is_empty() {
            let adds = if links.len() == 1 { "adds" } else { "add" };
            text += &format!(", with what {} {adds} to it", listed(robot, &links));
        }
        text
    }

    /// The evidence for the rank of the regressor of `robot` in a finite field, as text, with the columns that are too weak in
    /// every motion.
    pub fn evidence_of_rank(&self, robot: &Robot) -> String {
        let weak = |w: &WeakParameter| format!("{} ({:.0e})", self.standard[w.column].display(robot), w.share);
        let weak: Vec<String> = self.weak.iter().map(weak).collect();
        match (weak.len(), self.rank.exact.rank()) {
            (1.., Some(exact)) => format!(
                "at other lengths and angles of this structure {exact} columns are independent; so weak that no motion shows \
                 them, and left out, {}: {}. That changes a torque by {:.0e} of the largest of a parameter at most",
                if weak.len() == 1 { "is" } else { "are" },
                weak.join(" "),
                self.rank.left_out
            ),
            _ => self.rank.exact.to_string(),
        }
    }
}

/// The meaning of a standard parameter in words: `moment of inertia of forearm about x`.
pub fn standard_meaning(robot: &Robot, parameter: StandardParameter) -> String {
    let link = called(robot, parameter.link);
    match parameter.inertial {
        Inertial::M => format!("mass of {link}"),
        Inertial::Ia => format!("rotor inertia of the motor of joint {}", robot.link(parameter.link).joint.name),
        inertial if inertial.is_first_moment() => format!("first moment of {link} along {}", axis(inertial)),
        Inertial::Xx | Inertial::Yy | Inertial::Zz => {
            format!("moment of inertia of {link} about {}", axis(parameter.inertial))
        }
        Inertial::Xy => format!("product of inertia of {link}, x with y"),
        Inertial::Xz => format!("product of inertia of {link}, x with z"),
        _ => format!("product of inertia of {link}, y with z"),
    }
}

fn axis(inertial: Inertial) -> &'static str {
    match inertial {
        Inertial::Xx | Inertial::Mx => "x",
        Inertial::Yy | Inertial::My => "y",
        _ => "z",
    }
}

/// The phrase for a parameter of the same link that a base parameter absorbs. `own`: the kind of the base parameter; `other`,
/// `factor`: the kind and the coefficient of the absorbed parameter.
fn joined(own: Inertial, other: Inertial, factor: f64) -> String {
    let is_moment = |i: Inertial| matches!(i, Inertial::Xx | Inertial::Yy | Inertial::Zz);
    match other {
        Inertial::Ia => "with its rotor".into(),
        other if is_moment(own) && is_moment(other) && factor == -1.0 => format!("less that about {}", axis(other)),
        other if is_moment(own) && is_moment(other) && factor == 1.0 => format!("with that about {}", axis(other)),
        other => format!("with its {}", other.letters()),
    }
}

fn called(robot: &Robot, link: LinkId) -> String {
    let name = &robot.link(link).name;
    if name.chars().all(|c| c.is_ascii_digit()) { format!("link {name}") } else { name.clone() }
}

/// A list of links as text: `a`, `a and b`, `a to d` if each is the antecedent of the next, `a, b and 4 more`.
fn listed(robot: &Robot, links: &[LinkId]) -> String {
    let name = |i: usize| called(robot, links[i]);
    let last = links.len() - 1;
    let in_a_row = links.windows(2).all(|pair| robot.link(pair[1]).antecedent == Some(pair[0]));
    match links.len() {
        1 => name(0),
        2 => format!("{} and {}", name(0), name(1)),
        _ if in_a_row => format!("{} to {}", name(0), name(last)),
        3 => format!("{}, {} and {}", name(0), name(1), name(2)),
        _ => format!("{}, {} and {} more", name(0), name(1), links.len() - 2),
    }
}
