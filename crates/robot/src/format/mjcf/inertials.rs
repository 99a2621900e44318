//! Reads the inertial parameters of a body: from its `<inertial>`, or computed from its shapes.

use super::compiler::{Compiler, InertiaFromGeom};
use super::defaults::View;
use super::masses::Volume;
use super::meshes::Meshes;
use crate::angle_snap;
use crate::collision::{Collision, CollisionShape};
use crate::error::Error;
use crate::format::jointed::sum;
use crate::format::shown::shown;
use crate::inertial::{Part, Pose};
use crate::principal::principal_axes;
use crate::robot::Note;
use crate::vector::{Vector3, minus, norm, plus, product, scaled, transposed};

/// A shape (`<geom>`) of a body, with its pose in the frame of the body.
pub(super) struct MjcfShape<'a> {
    pub view: View<'a>,
    pub kind: &'static str,
    pub pose: Pose,
    /// Half lengths and radii, as in MJCF, m.
    pub size: Vector3,
}

/// The types of `<geom>`, each with the number of sizes that it needs.
const KINDS: [(&str, usize); 9] = [
    ("sphere", 1),
    ("capsule", 2),
    ("cylinder", 2),
    ("ellipsoid", 3),
    ("box", 3),
    ("plane", 0),
    ("hfield", 0),
    ("mesh", 0),
    ("sdf", 0),
];

/// Density of a shape for which the file gives neither mass nor density, kg/m^3.
const WATER_DENSITY: f64 = 1000.0;
/// The two end points in the attribute `fromto` of a shape must have at least this distance, m.
const SMALLEST_FROMTO_M: f64 = 1e-12;

impl<'a> MjcfShape<'a> {
    /// Reads a `<geom>`. `frame`: pose of the `<frame>` around it, relative to the body.
    pub(super) fn new(
        view: View<'a>,
        frame: &Pose,
        compiler: &Compiler,
        snapped: &mut Vec<Note>,
    ) -> Result<MjcfShape<'a>, Error> {
        let words = KINDS.map(|k| k.0);
        let (kind, needed) = KINDS[view.choice("type", &words)?.unwrap_or(0)];
        let given = view.numbers("size", 1, 3)?.unwrap_or_default();
        let mut size = [0, 1, 2].map(|i| given.get(i).copied().unwrap_or(0.0));
        let mut own =
            Pose { rotation: compiler.orientation(view, snapped)?, position: view.vector("pos")?.unwrap_or([0.0; 3]) };
        let mut has = given.len();
        if let Some(ends) = view.vector::<6>("fromto")? {
            let (from, to) = ([ends[0], ends[1], ends[2]], [ends[3], ends[4], ends[5]]);
            let along = minus(from, to);
            let length = norm(along);
            if length < SMALLEST_FROMTO_M {
                return Err(view.element.error(format!("`fromto` of {} has no length", view.element.called())));
            }
            own = Pose {
                rotation: angle_snap::exact(&super::compiler::to_z(scaled(along, 1.0 / length))),
                position: scaled(plus(from, to), 0.5),
            };
            let half = length / 2.0;
            size = match kind {
                "capsule" | "cylinder" => [size[0], half, 0.0],
                // The first size of a box or an ellipsoid is used for both width and depth.
                _ => [size[0], size[0], half],
            };
            has = has.max(if has > 0 { 3 } else { 0 });
        }
        // A shape that is fitted to a mesh takes its size from the mesh.
        if view.get("mesh").is_none() && (has < needed || size[..needed].iter().any(|x| *x <= 0.0)) {
            let message = format!("{}: a {kind} has {needed} sizes above 0 in `size`", view.element.called());
            return Err(view.element.error(message));
        }
        Ok(MjcfShape { view, kind, pose: frame.compose(&own), size })
    }

    /// The volume of the shape. `None` if its type has no volume. Fails if the volume cannot be computed.
    fn volume(&self, meshes: &Meshes) -> Result<Option<Volume>, String> {
        let [a, b, c] = self.size;
        if self.view.flag("shellinertia").map_err(|e| e.message)? == Some(true) && self.kind != "mesh" {
            return Err("it weighs by its surface (`shellinertia`), which is not read".into());
        }
        Ok(Some(match (self.kind, self.view.get("mesh")) {
            ("plane" | "hfield", _) => return Ok(None),
            ("mesh", Some(name)) => meshes.volume(name)?,
            ("mesh", None) => return Err("it is a mesh and names none".into()),
            ("sdf", _) => return Err("it is a field of distances, whose volume is not read".into()),
            (_, Some(_)) => return Err("it is a shape fitted to a mesh, which is not read".into()),
            ("sphere", _) => Volume::sphere(a),
            ("capsule", _) => Volume::capsule(a, b),
            ("cylinder", _) => Volume::cylinder(a, b),
            ("ellipsoid", _) => Volume::ellipsoid([a, b, c]),
            _ => Volume::cuboid([a, b, c]),
        }))
    }

    /// The inertial of the shape. `None` if it has no mass.
    fn part(&self, meshes: &Meshes) -> Result<Option<Part>, Error> {
        let (mass, density) = (self.view.number("mass")?, self.view.number("density")?.unwrap_or(WATER_DENSITY));
        if mass == Some(0.0) || (mass.is_none() && density == 0.0) {
            return Ok(None);
        }
        let called = self.view.element.called();
        let volume = self.volume(meshes).map_err(|what| {
            let remedy = "or give the body an <inertial>, as mujoco.mj_saveLastXML writes one";
            self.view.element.error(format!(
                "the mass of the body follows from its shapes, which cannot be computed: {called}: {what}; {remedy}"
            ))
        })?;
        let Some(volume) = volume else { return Ok(None) };
        Ok(Some(volume.part(&self.pose, mass.map_or(density, |mass| mass / volume.volume))))
    }

    /// The shape for collisions; and whether the shape is only drawn, and so excluded from all collisions.
    pub(super) fn collision(&self, body: &str, meshes: &Meshes) -> Result<(Collision, bool), Error> {
        let is_off = |name: &str| Ok::<bool, Error>(self.view.number(name)? == Some(0.0));
        let is_drawn = is_off("contype")? && is_off("conaffinity")?;
        let [a, b, c] = self.size;
        let unread =
            |reason: String| CollisionShape::Unread { reason: format!("line {}: {reason}", self.view.element.at().0) };
        let shape = match (self.kind, self.view.get("mesh")) {
            ("mesh", Some(name)) => match meshes.file(name) {
                Ok((file, scale)) => CollisionShape::Mesh { file, scale },
                Err(reason) => unread(reason),
            },
            (kind, Some(_)) => unread(format!("a {kind} fitted to a mesh is not read")),
            ("box", _) => CollisionShape::Box { size: [a, b, c].map(|x| 2.0 * x) },
            ("sphere", _) => CollisionShape::Sphere { radius: a },
            ("cylinder", _) => CollisionShape::Cylinder { radius: a, length: 2.0 * b },
            ("capsule", _) => CollisionShape::Capsule { radius: a, length: 2.0 * b },
            (kind, _) => unread(format!("a {kind} is not read")),
        };
        Ok((Collision { link: body.to_string(), pose: self.pose, shape }, is_drawn))
    }
}

/// The inertial of a body. `None` if the file gives none.
pub(super) fn part(
    name: &str,
    inertial: Option<View>,
    shapes: &[MjcfShape],
    compiler: &Compiler,
    meshes: &Meshes,
    snapped: &mut Vec<Note>,
) -> Result<Option<Part>, Error> {
    let from_shapes = match compiler.inertia_from_geom {
        InertiaFromGeom::Never => false,
        InertiaFromGeom::Always => true,
        InertiaFromGeom::Auto => inertial.is_none(),
    };
    let mut parts = Vec::new();
    for shape in shapes.iter().filter(|_| from_shapes) {
        let group = shape.view.number("group")?.unwrap_or(0.0);
        if group >= compiler.groups.0 && group <= compiler.groups.1 {
            parts.extend(shape.part(meshes)?);
        }
    }
    let part = match inertial {
        // If no shape has a mass, MuJoCo keeps the `<inertial>` of the body.
        Some(inertial) if parts.is_empty() => Some(explicit(inertial, compiler, snapped)?),
        _ => sum(&parts).and_then(|x| Part::from_parameters(name.to_string(), &x, Pose::IDENTITY.rotation)),
    };
    let part = part.unwrap_or(Part { name: name.into(), pose: Pose::IDENTITY, mass: 0.0, inertia: [0.0; 6] });
    let part = bounded(Part { name: name.to_string(), ..part }, compiler);
    Ok(Some(part).filter(|part| part.mass != 0.0 || part.inertia.iter().any(|i| *i != 0.0)))
}

/// Reads an `<inertial>` element. Fails if it is incomplete or contradictory.
fn explicit(view: View, compiler: &Compiler, snapped: &mut Vec<Note>) -> Result<Part, Error> {
    let require = |x: Option<f64>| x.ok_or_else(|| view.element.error("<inertial> has no `mass`"));
    let mass = require(view.number("mass")?)?;
    let position = view.vector("pos")?.ok_or_else(|| view.element.error("<inertial> has no `pos`"))?;
    let rotation = compiler.orientation(view, snapped)?;
    let (diagonal, full) = (view.vector::<3>("diaginertia")?, view.vector::<6>("fullinertia")?);
    let is_turned = super::defaults::ORIENTATIONS.iter().any(|name| view.get(name).is_some());
    let inertia = match (diagonal, full) {
        (Some(_), Some(_)) => {
            return Err(view.element.error("<inertial> has `diaginertia` and `fullinertia`: one of them"));
        }
        (Some([xx, yy, zz]), None) => [xx, 0.0, 0.0, yy, 0.0, zz],
        (None, Some(_)) if is_turned => {
            let message = "<inertial> has `fullinertia` and an orientation, which MuJoCo refuses: one of them";
            return Err(view.element.error(message));
        }
        (None, Some([xx, yy, zz, xy, xz, yz])) => [xx, xy, xz, yy, yz, zz],
        (None, None) => [0.0; 6],
    };
    if mass < 0.0 {
        return Err(view
            .element
            .error(format!("the mass of <inertial> is {} kg: no body has it", shown(&mass.to_string()))));
    }
    Ok(Part { name: String::new(), pose: Pose { rotation, position }, mass, inertia })
}

/// Applies the bounds of `<compiler>` to an inertial: the least mass and the least principal moments. With `balanceinertia`,
/// moments that violate the triangle inequality are replaced by their mean.
fn bounded(mut part: Part, compiler: &Compiler) -> Part {
    part.mass = part.mass.max(compiler.least_mass);
    if compiler.least_inertia <= 0.0 && !compiler.balances {
        return part;
    }
    let (moments, axes) = principal_axes(&part.inertia);
    let mut moments = moments.map(|i| i.max(compiler.least_inertia));
    let [a, b, c] = moments;
    if compiler.balances && (a + b < c || a + c < b || b + c < a) {
        moments = [(a + b + c) / 3.0; 3];
    }
    let diagonal = [0, 1, 2].map(|i| [0, 1, 2].map(|j| if i == j { moments[i] } else { 0.0 }));
    let m = product(&product(&axes, &diagonal), &transposed(&axes));
    part.inertia = [m[0][0], m[0][1], m[0][2], m[1][1], m[1][2], m[2][2]];
    part
}
