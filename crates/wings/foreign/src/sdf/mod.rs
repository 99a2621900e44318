//! Reads the links, joints and inertials of a model in an SDF (.sdf, .world), the format of Gazebo.
//!
//! The frame of the base is the frame of the world, or of the model if the file has no world. If no joint connects the model to
//! the world, the first link of the model is fixed to the world at its pose in the file, like the root link of a URDF. Links
//! without an inertial, for which Gazebo takes 1 kg, have unknown parameters. frames.rs has the poses, joints.rs the joints,
//! tree.rs the tree of links.
//!
//! Read: `pose` with `relative_to`, `degrees` and `rotation_format`; `frame`; revolute, continuous, prismatic and fixed joints
//! with axis, limits, damping, friction and `mimic`; gravity of the world. Not read, with a note: joints that close a loop, springs,
//! and the other elements of links and models. Refused: `include`, models in the model, and joints with two axes or none.

mod element;
mod frames;
mod joints;
mod tree;

use roxmltree::{Document, Node, ParsingOptions};

use element::{Mistake, child, children, is_true, name, note, numbers, wrong};
use frames::Frames;
use robot::format::{ReadOptions, RobotDescription};
use robot::xml_bounds::{MAX_ATTRIBUTES_PER_ELEMENT, MAX_XML_NODES, crowded};
use robot::{Error, Part, Place, Robot};

/// Largest number of links; a URDF has the same limit.
const MAX_LINKS: usize = 2000;
/// Gravity if the file does not give it, m/s^2. Other formats without gravity have the same default.
const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// Reads a robot from the text of an SDF. `file`: name of the file in errors.
///
/// The file must have one model, or the options must name one of its models. The links of this model must be a tree of
/// revolute, prismatic and fixed joints, and all numbers must be finite. Otherwise fails with the line of the mistake.
pub fn read(text: &str, file: &str, options: ReadOptions) -> Result<Robot, Error> {
    read_model(text, options)
        .map_err(|Mistake { line, message }| Error { place: Place { file: file.into(), line, column: 0 }, message })?
        .robot(file, options)
}

fn read_model(text: &str, options: ReadOptions) -> Result<RobotDescription, Mistake> {
    if let Some((line, _)) = crowded(text) {
        let message = format!("an element has more than {MAX_ATTRIBUTES_PER_ELEMENT} attributes");
        return Err(Mistake { line, message });
    }
    let parsing = ParsingOptions { nodes_limit: MAX_XML_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, parsing)
        .map_err(|e| Mistake { line: e.pos().row as usize, message: format!("not valid XML: {e}") })?;
    let root = document.root_element();
    if root.tag_name().name() != "sdf" {
        return Err(wrong(root, format!("an SDF begins with <sdf>, found <{}>", root.tag_name().name())));
    }
    let worlds = || children(root, "world");
    let models: Vec<Node> = worlds().chain([root]).flat_map(|owner| children(owner, "model")).collect();
    let moving = |model: &Node| children(*model, "joint").any(|joint| joint.attribute("type") != Some("fixed"));
    let named = |nodes: &[Node]| nodes.iter().map(|n| name(*n)).collect::<Vec<_>>().join(", ");
    // The model is chosen in this order: the model that the user names, the only model, the only model with a moving joint.
    let robots: Vec<Node> = match options.root {
        Some(root) => models.iter().copied().filter(|model| name(*model) == root).collect(),
        None if models.len() == 1 => models.clone(),
        None => models.iter().copied().filter(moving).collect(),
    };
    let model = match (robots[..].first(), robots.len(), options.root) {
        (Some(model), 1, _) => *model,
        (_, _, Some(asked)) => {
            return Err(wrong(root, format!("[root]: the file has no model `{asked}`; it has {}", named(&models))));
        }
        (Some(first), ..) => {
            let message =
                format!("several models have joints ({}): one is chosen, [root={}]", named(&robots), name(*first));
            return Err(wrong(*first, message));
        }
        (None, ..) => return Err(wrong(root, "the file has no <model> with joints")),
    };
    let mut described = RobotDescription { name: name(model).into(), ..RobotDescription::default() };
    let left: Vec<Node> = models.iter().copied().filter(|other| *other != model).collect();
    if !left.is_empty() {
        note(&mut described, name(model), format!("is read alone; not read are the other models ({})", named(&left)));
    }
    let gravity = worlds().find_map(|world| child(world, "gravity"));
    described.gravity = gravity.map_or(Ok(GRAVITY), numbers)?;
    model_into(model, &mut described, options)?;
    Ok(described)
}

fn model_into(model: Node, described: &mut RobotDescription, options: ReadOptions) -> Result<(), Mistake> {
    for (tag, remedy) in [
        ("include", "write it out, `gz sdf -p FILE`, and give the model itself"),
        ("model", "a robot is one model: move its links and joints into the outer one"),
    ] {
        if let Some(node) = child(model, tag) {
            return Err(wrong(node, format!("<{tag}> in a model is not read: {remedy}")));
        }
    }
    if let Some(extra) = children(model, "link").nth(MAX_LINKS) {
        return Err(wrong(extra, format!("more than {MAX_LINKS} links are no robot")));
    }
    let frames = Frames::of(model, described, options.angles)?;
    // The bodies have the order of the links, because `grow` pairs both lists.
    let mut bodies = Vec::new();
    for link in children(model, "link") {
        bodies.push((frames.pose(name(link))?, part(link, described, options)?));
    }
    tree::grow(model, &frames, bodies, described, options)?;
    // Each kind of ignored element is named once, in one note on the model.
    let mut others: Vec<&str> = Vec::new();
    let owners = [model].into_iter().chain(children(model, "link")).chain(children(model, "joint"));
    for other in owners.flat_map(|owner| owner.children().filter(Node::is_element)) {
        let tag = other.tag_name().name();
        if ["collision", "sensor", "plugin", "gripper", "battery", "particle_emitter"].contains(&tag)
            && !others.contains(&tag)
        {
            others.push(tag);
        }
    }
    if !others.is_empty() {
        note(described, name(model), format!("not read of the SDF: {}", others.join(", ")));
    }
    Ok(())
}

/// The inertial of a link in the frame of the link; `None` if the file does not give it.
fn part(link: Node, described: &mut RobotDescription, options: ReadOptions) -> Result<Option<Part>, Mistake> {
    let Some(inertial) = child(link, "inertial") else {
        note(described, name(link), "has no inertial: unknown here, where Gazebo takes 1 kg and 1 kg m^2".into());
        return Ok(None);
    };
    if inertial.attribute("auto").is_some_and(is_true) {
        note(described, name(link), "has an inertial from its shapes (`auto`), which is not read: unknown here".into());
        return Ok(None);
    }
    let pose = frames::stated(inertial, described, options.angles)?.0;
    let mass = child(inertial, "mass").map_or(Ok([1.0]), numbers)?[0];
    let inertia = child(inertial, "inertia");
    let entry = |tag: &str, missing: f64| match inertia.and_then(|inertia| child(inertia, tag)) {
        Some(node) => numbers::<1>(node).map(|[x]| x),
        None => Ok(missing),
    };
    let inertia = [
        entry("ixx", 1.0)?,
        entry("ixy", 0.0)?,
        entry("ixz", 0.0)?,
        entry("iyy", 1.0)?,
        entry("iyz", 0.0)?,
        entry("izz", 1.0)?,
    ];
    if mass < 0.0 {
        return Err(wrong(inertial, format!("the mass of `{}` is {mass} kg: no body has it", name(link))));
    }
    Ok(Some(Part { name: name(link).into(), pose, mass, inertia }))
}
