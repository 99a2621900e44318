//! Reads the inertial parameters in a YAML description.
//!
//! A link has either XX .. M about the origin of its frame, or its mass, its centre of mass and the inertia about the centre
//! of mass. The frame is the link frame in the convention of the file.

use super::convention::Convention;
use crate::error::Error;
use crate::format::expression::KnownNames;
use crate::format::node::{DescriptionFile, Fields, Node};
use crate::inertial::{Part, Pose, transform_inertial};
use crate::parameter::Inertial;
use crate::robot::{Link, RotorInertia};
use gate::suggestion::did_you_mean;

/// The keys of a body that is given by its mass, centre of mass and inertia.
const BODY_KEYS: [&str; 3] = ["mass", "centre_of_mass", "inertia"];
/// The keys of the six entries of an inertia matrix.
pub(super) const ENTRIES: [&str; 6] = ["xx", "xy", "xz", "yy", "yz", "zz"];

/// Reads `standard_parameters`. `places`: for each link, the pose of its frame in the file's convention, in our link frame.
pub(super) fn standard_parameters(
    source: DescriptionFile,
    node: &Node,
    names: &KnownNames,
    convention: Convention,
    places: &[Pose],
    links: &mut [Link],
) -> Result<(), Error> {
    let letters = Inertial::BODY.map(Inertial::letters);
    let valid: Vec<&str> = letters.iter().copied().chain(["IA"]).chain(BODY_KEYS).collect();
    for (key, value) in node.map(source, "`standard_parameters`")? {
        let labels: Vec<String> = links.iter().map(|l| l.label.clone()).collect();
        let Some(j) = labels.iter().position(|l| *l == key.text) else {
            let meant = did_you_mean(&key.text, labels.iter().map(String::as_str));
            return Err(source.at_key(key, format!("no link is called `{}`{meant}", key.text)));
        };
        let what = format!("the standard parameters of link {}", key.text);
        let fields = value.fields(source, &what, &valid)?;
        // One key of the form about the centre of mass selects this form. Then a key of the other form is a contradiction.
        let about_centre = BODY_KEYS.iter().any(|key| fields.get(key).is_some());
        let x = match (about_centre, letters.iter().find_map(|key| fields.get(key))) {
            (true, Some(other)) => {
                let message = "is given about its origin (XX .. M) and about its centre of mass (mass, centre_of_mass, \
                               inertia): one of them";
                return Err(source.at(other, format!("link {} {message}", key.text)));
            }
            (true, None) => body(source, &fields, names, convention)?,
            (false, _) => {
                let mut x = [0.0; 10];
                for (x, letters) in x.iter_mut().zip(letters) {
                    *x = names.number(source, letters, fields.require(letters)?)?;
                }
                x
            }
        };
        // The file gives the parameters in the link frame of its own convention. They are transformed to our link frame.
        links[j].inertial = Some(if places[j] == Pose::IDENTITY { x } else { transform_inertial(&x, &places[j]) });
        if let Some(node) = fields.get("IA") {
            links[j].joint.rotor_inertia = RotorInertia::Known(names.number(source, "IA", node)?);
        }
    }
    Ok(())
}

/// XX .. M of a body that is given by its mass, centre of mass and inertia.
fn body(
    source: DescriptionFile,
    fields: &Fields,
    names: &KnownNames,
    convention: Convention,
) -> Result<[f64; 10], Error> {
    let mass = names.number(source, "`mass`", fields.require("mass")?)?;
    let node = fields.require("centre_of_mass")?;
    let [x, y, z] = node.list(source, "`centre_of_mass`")? else {
        return Err(source.at(node, format!("`centre_of_mass` is [x, y, z], found {}", node.kind())));
    };
    let mut position = [0.0; 3];
    for (position, node) in position.iter_mut().zip([x, y, z]) {
        *position = convention.length(names.number(source, "`centre_of_mass`", node)?);
    }
    let mut inertia = [0.0; 6];
    if let Some(node) = fields.get("inertia") {
        let entries = node.fields(source, "`inertia`", &ENTRIES)?;
        for (inertia, key) in inertia.iter_mut().zip(ENTRIES) {
            *inertia = entries.get(key).map_or(Ok(0.0), |node| names.number(source, key, node))?;
        }
    }
    let pose = Pose { position, ..Pose::IDENTITY };
    Ok(Part { name: String::new(), pose, mass, inertia }.parameters())
}
