//! Finds the elements of an MJCF by the names that a robot gives these elements.
//!
//! The reader of MJCF gives names to elements without a name, for example
//! `BODY_joint`. Names of a robot may have a prefix that the file lacks (`panda_link1` for `link1`).

use gate::shown;
use logs::Error;
use roxmltree::{Document, Node};

/// The element inside `<worldbody>` with this tag and name, or with the part of the name after its first `_`.
pub(super) fn found<'a, 'd>(document: &'a Document<'d>, tag: &str, name: &str) -> Option<Node<'a, 'd>> {
    let world = document.descendants().find(|n| n.has_tag_name("worldbody"))?;
    // The robot stores names in printable form.
    let is_named = |n: &Node, name: &str| n.attribute("name").is_some_and(|found| shown::line(found) == name);
    let of = |name: &str| world.descendants().find(|n| n.has_tag_name(tag) && is_named(n, name));
    of(name).or_else(|| unnamed(&world, tag, name)).or_else(|| of(name.split_once('_')?.1))
}

/// The element without a name that the reader of MJCF calls `name`: `BODY_joint`, `BODY_joint2`, or `body3` for the third body.
fn unnamed<'a, 'd>(world: &Node<'a, 'd>, tag: &str, name: &str) -> Option<Node<'a, 'd>> {
    if tag == "body" {
        let number: usize = name.strip_prefix("body")?.parse().ok()?;
        let body = world.descendants().filter(|n| n.has_tag_name("body")).nth(number.checked_sub(1)?)?;
        return Some(body).filter(|body| !body.has_attribute("name"));
    }
    let (body, number) = name.rsplit_once("_joint")?;
    let number = if number.is_empty() { 1 } else { number.parse().ok()? };
    let body = world.descendants().find(|n| n.has_tag_name("body") && n.attribute("name") == Some(body));
    let body = body.or_else(|| unnamed(world, "body", name.rsplit_once("_joint")?.0))?;
    let mut joints = body.children().filter(|n| n.has_tag_name(tag) && !n.has_attribute("name"));
    joints.nth(usize::checked_sub(number, 1)?)
}

pub(super) fn element<'a, 'd>(
    document: &'a Document<'d>,
    tag: &str,
    name: &str,
    file: &str,
) -> Result<Node<'a, 'd>, Error> {
    found(document, tag, name).ok_or_else(|| {
        let named = document.descendants().filter(|n| n.has_tag_name(tag)).filter_map(|n| n.attribute("name"));
        let names = named.map(shown::line).collect::<Vec<_>>().join(", ");
        Error::at(file, 0, format!("there is no <{tag} name=\"{name}\">; there are {names}"))
    })
}
