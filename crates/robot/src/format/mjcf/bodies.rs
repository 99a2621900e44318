//! Reads the bodies of a model: the pose of each body in its parent, and its joints, shapes and inertial.
//!
//! A `<frame>` is not a body: its pose applies to the elements inside it. The world is the first body. The other bodies follow
//! depth first in the order of the file, which is also the order of MuJoCo's coordinates.

use super::compiler::Compiler;
use super::defaults::{Defaults, View};
use super::element::MjcfElement;
use super::inertials::MjcfShape;
use crate::error::Error;
use crate::format::budget::MAX_LINKS;
use crate::format::shown::shown;
use crate::inertial::Pose;
use crate::robot::Note;
use gate::suggestion::{did_you_mean, nearest};

pub(super) struct MjcfBody<'a> {
    pub name: String,
    pub element: &'a MjcfElement,
    /// Index of the parent body; `None` for the world.
    pub parent: Option<usize>,
    /// Pose of the body's frame in the parent's frame, with the joints at their positions in the file.
    pub pose: Pose,
    /// The joints of the body. Each has the pose of the `<frame>` around it, relative to the body.
    pub joints: Vec<(View<'a>, Pose)>,
    pub inertial: Option<View<'a>>,
    pub shapes: Vec<MjcfShape<'a>>,
    /// The sites on the body: name and pose of each.
    pub sites: Vec<(String, Pose)>,
}

/// The elements that may occur inside a body.
const CHILDREN: [&str; 10] =
    ["body", "frame", "joint", "freejoint", "inertial", "geom", "site", "camera", "light", "plugin"];
/// Elements that generate bodies from other files, or by copying. The reader refuses them.
const MAKERS: [&str; 4] = ["attach", "replicate", "composite", "flexcomp"];
/// The valid attributes of some elements. An attribute that is similar to one of them, but not equal, is misspelt.
const ATTRIBUTES: [(&str, &str); 4] = [
    ("body", "name childclass pos quat axisangle euler xyaxes zaxis mocap gravcomp user sleep"),
    ("inertial", "pos quat axisangle euler xyaxes zaxis mass diaginertia fullinertia"),
    (
        "joint",
        "name class type group pos axis springdamper limited actuatorfrclimited solreflimit solimplimit solreffriction \
         solimpfriction stiffness range actuatorfrcrange actuatorgravcomp margin ref springref armature damping \
         frictionloss user",
    ),
    ("freejoint", "name group align"),
];

/// Reads the bodies of all `<worldbody>` elements.
pub(super) fn bodies<'a>(
    root: &'a MjcfElement,
    defaults: &'a Defaults,
    compiler: &'a Compiler,
    snapped: &mut Vec<Note>,
) -> Result<Vec<MjcfBody<'a>>, Error> {
    let mut walk = BodyWalk { defaults, compiler, snapped, bodies: Vec::new() };
    let world = root.children("worldbody").next().unwrap_or(root);
    walk.bodies.push(MjcfBody::new("world".into(), world, None, Pose::IDENTITY));
    for worldbody in root.children("worldbody") {
        walk.inside(worldbody, 0, worldbody.attribute("childclass"), &Pose::IDENTITY)?;
    }
    if walk.bodies.len() == 1 {
        return Err(root.error("the model has no <body> in a <worldbody>: it describes no robot"));
    }
    Ok(walk.bodies)
}

impl<'a> MjcfBody<'a> {
    fn new(name: String, element: &'a MjcfElement, parent: Option<usize>, pose: Pose) -> MjcfBody<'a> {
        MjcfBody { name, element, parent, pose, joints: vec![], inertial: None, shapes: vec![], sites: vec![] }
    }
}

struct BodyWalk<'a, 'n> {
    defaults: &'a Defaults,
    compiler: &'a Compiler,
    snapped: &'n mut Vec<Note>,
    bodies: Vec<MjcfBody<'a>>,
}

impl<'a> BodyWalk<'a, '_> {
    /// Reads the children of an element: of a body, or of a `<frame>` with pose `frame` relative to the body.
    fn inside(
        &mut self,
        element: &'a MjcfElement,
        body: usize,
        class: Option<&'a str>,
        frame: &Pose,
    ) -> Result<(), Error> {
        for child in &element.children {
            check_attributes(child)?;
            let view = self.defaults.view(child, class);
            match child.tag.as_str() {
                "body" => self.body(child, body, class, frame)?,
                // The children of a `<frame>` belong to the body around the frame, so the body stays the same. Only the
                // pose and the class of the defaults change.
                "frame" => {
                    let own = frame.compose(&self.placed(View::bare(child))?);
                    self.inside(child, body, child.attribute("childclass").or(class), &own)?;
                }
                "joint" | "freejoint" => self.bodies[body].joints.push((view?, *frame)),
                "inertial" if body == 0 => return Err(child.error("the world has no <inertial>")),
                "inertial" if self.bodies[body].inertial.is_some() => {
                    return Err(child.error(format!("body `{}` has two <inertial>", shown(&self.bodies[body].name))));
                }
                "inertial" => self.bodies[body].inertial = Some(View::bare(child)),
                "geom" => {
                    let shape = MjcfShape::new(view?, frame, self.compiler, self.snapped)?;
                    self.bodies[body].shapes.push(shape);
                }
                "site" => {
                    let pose = frame.compose(&self.placed(view?)?);
                    let name = child.attribute("name").unwrap_or("").to_string();
                    self.bodies[body].sites.push((name, pose));
                }
                tag if MAKERS.contains(&tag) => {
                    let message = format!(
                        "<{tag}> is not read: let MuJoCo write it out, mujoco.mj_saveLastXML(\"flat.xml\", model), and give \
                         that file"
                    );
                    return Err(child.error(message));
                }
                // Other elements are ignored, except those whose names are nearly equal to the name of a known element.
                tag => {
                    let other = (!CHILDREN.contains(&tag)).then(|| nearest(tag, CHILDREN)).flatten();
                    if let Some(meant) = other {
                        return Err(child.error(format!("unknown element <{}>: did you mean <{meant}>?", shown(tag))));
                    }
                }
            }
        }
        Ok(())
    }

    fn body(
        &mut self,
        element: &'a MjcfElement,
        parent: usize,
        class: Option<&'a str>,
        frame: &Pose,
    ) -> Result<(), Error> {
        if self.bodies.len() > MAX_LINKS {
            return Err(element.error(format!("more than {MAX_LINKS} bodies are no robot")));
        }
        let name = match element.attribute("name").filter(|name| !name.is_empty()) {
            Some(name) => name.to_string(),
            None => format!("body{}", self.bodies.len()),
        };
        if let Some(first) = self.bodies.iter().find(|body| body.name == name) {
            let line = first.element.at().0;
            return Err(element.error(format!("body `{}` stands twice, first on line {line}", shown(&name))));
        }
        let pose = frame.compose(&self.placed(View::bare(element))?);
        self.bodies.push(MjcfBody::new(name, element, Some(parent), pose));
        let own = self.bodies.len() - 1;
        self.inside(element, own, element.attribute("childclass").or(class), &Pose::IDENTITY)
    }

    fn placed(&mut self, view: View) -> Result<Pose, Error> {
        let position = view.vector("pos")?.unwrap_or([0.0; 3]);
        Ok(Pose { rotation: self.compiler.orientation(view, self.snapped)?, position })
    }
}

/// Fails if an attribute is misspelt, because it would otherwise be ignored without notice.
fn check_attributes(element: &MjcfElement) -> Result<(), Error> {
    let Some((_, known)) = ATTRIBUTES.iter().find(|e| e.0 == element.tag) else { return Ok(()) };
    let known = || known.split_whitespace();
    for (name, _) in &element.attributes {
        if !known().any(|k| k == name) && nearest(name, known()).is_some() {
            let meant = did_you_mean(name, known());
            let message = format!("{} has no attribute `{}`{meant}", element.called(), shown(name));
            return Err(element.error(message));
        }
    }
    Ok(())
}
