//! Finds values of a description that are physically possible but probably not intended: placeholders, copies, masses that do
//! not fit the shape, limits without effect.
//!
//! A body of mass m and density of at most rho has at least the radius of gyration of a ball with the same mass and the
//! density rho: sqrt(2/5) (3 m/(4 pi rho))^(1/3). rho is the density of the densest metal.

use std::f64::consts::PI;

use crate::collision::{Collision, CollisionShape};
use crate::finding::{Finding, Mistake};
use crate::inertial::{Part, Pose};
use crate::principal::principal_axes;
use crate::robot::{Drive, JointKind, Robot};
use crate::vector::{Vector3, norm, plus, turned};

/// Density of osmium, the densest metal, kg/m^3.
const LARGEST_DENSITY: f64 = 22_600.0;
/// If the radius of gyration is below this fraction of the smallest possible radius, the units are probably wrong.
const POSSIBLE_RADIUS_SHARE: f64 = 0.5;
/// Lowest and highest usual mean density of a whole link, kg/m^3: foam and solid steel.
const LINK_DENSITIES: (f64, f64) = (20.0, 12_000.0);
/// Largest usual distance of a centre of mass from the collision shapes, as a multiple of the diagonal of their bounding box.
const CENTRE_MARGIN: f64 = 0.5;
/// Largest usual radius of gyration, as a multiple of the diagonal of the collision shapes. A body inside the shapes has at most
/// one; two allows for rough shapes.
const RADIUS_MARGIN: f64 = 2.0;
/// A body without inertia is suspicious if its mass is above this, kg. A lighter body is often only the marker of a frame.
const POINT_MASS_KG: f64 = 0.05;
/// A limit of at least this absolute value means that there is no limit, rad or m.
const NO_LIMIT: f64 = 1e5;
/// If at least this number of bodies have the same mass and inertia, they count as copies of one body.
const FEWEST_COPIES: usize = 3;
/// Two full turns, rad. A larger position limit is probably in degrees.
pub const DEGREES_LIMIT_RAD: f64 = 4.0 * PI + 1e-6;

/// Adds the findings on the bodies of all links, then the finding on copied bodies, then the findings on the limits.
pub(crate) fn inertial_conventions(robot: &Robot, findings: &mut Vec<Finding>) {
    let links = robot.links.iter().map(|link| (&link.parts, &link.collisions));
    let bodies: Vec<(&Part, Vec<&Collision>)> = std::iter::once((&robot.base.parts, &robot.base.collisions))
        .chain(links)
        .flat_map(|(parts, shapes)| {
            parts.iter().map(|part| (part, shapes.iter().filter(|s| s.link == part.name).collect()))
        })
        .collect();
    for (part, shapes) in &bodies {
        let find = |mistake, text| findings.push(Finding { link: part.name.clone(), mistake, text });
        of_body(part, shapes, find);
    }
    copied(&bodies.iter().map(|body| body.0).collect::<Vec<_>>(), findings);
    limits(robot, findings);
}

fn of_body(part: &Part, shapes: &[&Collision], mut find: impl FnMut(Mistake, String)) {
    let mass = part.mass;
    if mass == 0.0 && !shapes.is_empty() && part.inertia.iter().all(|i| *i == 0.0) {
        find(Mistake::ShapeWithoutMass, "its mass is 0, though it has a collision shape".into());
    }
    if mass <= 0.0 {
        return;
    }
    let largest = principal_axes(&part.inertia).0[2];
    if mass > POINT_MASS_KG && part.inertia.iter().all(|i| *i == 0.0) {
        return find(
            Mistake::MassWithoutInertia,
            format!("its mass is {mass} kg, its inertia is 0: a point weighs so"),
        );
    }
    if mass == 1.0 && part.inertia == [1.0, 0.0, 0.0, 1.0, 0.0, 1.0] {
        return find(Mistake::Placeholder, "1 kg and 1 1 1 kg m^2: a placeholder of an exporter".into());
    }
    // Compares the radius of gyration with its lower bound for the densest metal.
    let radius = (largest.max(0.0) / mass).sqrt();
    let least = (0.4f64).sqrt() * (3.0 * mass / (4.0 * PI * LARGEST_DENSITY)).cbrt();
    if radius > 0.0 && radius < POSSIBLE_RADIUS_SHARE * least {
        let text = format!(
            "{mass} kg with a radius of gyration of {radius:.1e} m: no metal is so dense; are g or mm in its figures?"
        );
        return find(Mistake::Units, text);
    }
    // Compares density, centre of mass and radius of gyration with the collision shapes.
    let Some((low, high, volume)) = extent(shapes) else { return };
    let diagonal = norm([0, 1, 2].map(|i| high[i] - low[i]));
    let density = mass / volume;
    if density < LINK_DENSITIES.0 || density > LINK_DENSITIES.1 {
        let text = format!("{mass} kg in collision shapes of {volume:.2e} m^3 are {density:.2e} kg/m^3: no link is so");
        find(Mistake::Density, text);
    }
    let centre = part.pose.position;
    let outside = norm([0, 1, 2].map(|i| (low[i] - centre[i]).max(centre[i] - high[i]).max(0.0)));
    if outside > CENTRE_MARGIN * diagonal {
        let text = format!(
            "its centre of mass lies {outside:.3} m outside its collision shapes, which are {diagonal:.3} m across"
        );
        find(Mistake::CentreOutside, text);
    } else if radius > RADIUS_MARGIN * diagonal {
        let text =
            format!("its radius of gyration is {radius:.2} m, and its collision shapes are {diagonal:.3} m across");
        find(Mistake::Units, text);
    }
}

/// Lowest and highest corner of the bounding box of the shapes, m, and their total volume, m^3, in the frame of their link.
/// `None` if a shape is a mesh or could not be read, or if the volume is zero.
fn extent(shapes: &[&Collision]) -> Option<(Vector3, Vector3, f64)> {
    let (mut low, mut high, mut volume) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], 0.0);
    for shape in shapes {
        let (half, own) = match shape.shape {
            CollisionShape::Box { size: [x, y, z] } => ([x / 2.0, y / 2.0, z / 2.0], x * y * z),
            CollisionShape::Cylinder { radius: r, length } => ([r, r, length / 2.0], PI * r * r * length),
            CollisionShape::Capsule { radius: r, length } => {
                ([r, r, length / 2.0 + r], PI * r * r * (length + 4.0 / 3.0 * r))
            }
            CollisionShape::Sphere { radius: r } => ([r; 3], 4.0 / 3.0 * PI * r * r * r),
            CollisionShape::Mesh { .. } | CollisionShape::Unread { .. } => return None,
        };
        volume += own;
        let Pose { rotation, position } = &shape.pose;
        for k in 0..8 {
            let corner = [0, 1, 2].map(|i| if k >> i & 1 == 1 { half[i] } else { -half[i] });
            let corner = plus(turned(rotation, corner), *position);
            for i in 0..3 {
                (low[i], high[i]) = (low[i].min(corner[i]), high[i].max(corner[i]));
            }
        }
    }
    (volume > 0.0).then_some((low, high, volume))
}

/// Finds out whether most links have the same mass and inertia.
fn copied(parts: &[&Part], findings: &mut Vec<Finding>) {
    let heavy: Vec<&&Part> = parts.iter().filter(|part| part.mass > 0.0).collect();
    let alike = |a: &Part| heavy.iter().filter(|b| (b.mass, b.inertia) == (a.mass, a.inertia)).count();
    let Some(most) = heavy.iter().max_by_key(|part| alike(part)) else { return };
    let count = alike(most);
    if count >= FEWEST_COPIES && 2 * count > heavy.len() {
        let text = format!(
            "{count} of {} links have its mass, {} kg, and its inertia: were they copied?",
            heavy.len(),
            most.mass
        );
        findings.push(Finding { link: most.name.clone(), mistake: Mistake::Copied, text });
    }
}

fn limits(robot: &Robot, findings: &mut Vec<Finding>) {
    for link in robot.links.iter().filter(|link| link.joint.drive == Drive::Actuated) {
        let [(k, _)] = link.joint.variable.terms[..] else { continue };
        let Some((low, high)) = robot.coordinates.get(k.0).and_then(|c| c.limits.position) else { continue };
        let farthest = low.abs().max(high.abs());
        let text = if low > high {
            format!("its lower limit {low} is above its upper limit {high}")
        } else if farthest >= NO_LIMIT {
            format!("its limits are {low} and {high}: a search for a motion takes them at their word")
        } else if link.joint.kind == JointKind::Revolute && farthest > DEGREES_LIMIT_RAD {
            format!("its limits are {low} and {high} rad: are degrees meant?")
        } else {
            continue;
        };
        findings.push(Finding { link: link.joint.name.clone(), mistake: Mistake::Limits, text });
    }
}

#[cfg(test)]
mod tests {
    use crate::format::read_urdf;
    use crate::lint::{Mistake, lint};

    fn found(inertial: &str, geometry: &str, limit: &str) -> Vec<Mistake> {
        let link = |name: &str| {
            let shape = if geometry.is_empty() { "".into() } else { format!("<collision>{geometry}</collision>") };
            format!("<link name=\"{name}\"><inertial>{inertial}</inertial>{shape}</link>")
        };
        let text = format!(
            "<robot name=\"r\"><link name=\"b\"/>{}<joint name=\"j\" type=\"revolute\"><parent link=\"b\"/><child link=\"a\"/>\
             <limit {limit} effort=\"1\" velocity=\"1\"/></joint></robot>",
            link("a")
        );
        lint(&read_urdf(&text, "r.urdf").unwrap()).into_iter().map(|f| f.mistake).collect()
    }

    fn body(mass: f64, centre: &str, i: f64) -> String {
        format!(
            "<origin xyz=\"{centre}\"/><mass value=\"{mass}\"/><inertia ixx=\"{i}\" ixy=\"0\" ixz=\"0\" iyy=\"{i}\" iyz=\"0\" \
             izz=\"{i}\"/>"
        )
    }

    const BOX: &str = "<geometry><box size=\"0.3 0.2 0.2\"/></geometry>";
    const LIMIT: &str = "lower=\"-2\" upper=\"2\"";

    #[test]
    fn each_habit_is_found_and_a_sound_body_has_none() {
        let mesh = "<geometry><mesh filename=\"a.stl\"/></geometry>";
        for (inertial, geometry, limit, wanted) in [
            (body(8.0, "0 0 0", 0.06), BOX, LIMIT, vec![]),
            (body(0.0, "0 0 0", 0.0), BOX, LIMIT, vec![Mistake::ShapeWithoutMass]),
            (body(0.0, "0 0 0", 0.0), "", LIMIT, vec![]),
            (body(50.0, "0 0 0", 0.0), BOX, LIMIT, vec![Mistake::MassWithoutInertia]),
            (body(1.0, "0 0 0", 1.0), BOX, LIMIT, vec![Mistake::Placeholder]),
            (body(0.008, "0 0 0", 6e-5), BOX, LIMIT, vec![Mistake::Density]),
            (body(8.0, "1.5 0 0", 0.06), BOX, LIMIT, vec![Mistake::CentreOutside]),
            (body(8.0, "0 0 0", 16.0), BOX, LIMIT, vec![Mistake::Units]),
            (body(150.0, "0 0 0", 1e-4), mesh, LIMIT, vec![Mistake::Units]),
            (body(8.0, "1.5 0 0", 0.06), mesh, LIMIT, vec![]),
            (body(8.0, "0 0 0", 0.06), BOX, "lower=\"2\" upper=\"-2\"", vec![Mistake::Limits]),
            (body(8.0, "0 0 0", 0.06), BOX, "lower=\"-170\" upper=\"170\"", vec![Mistake::Limits]),
            (body(8.0, "0 0 0", 0.06), BOX, "lower=\"-999999\" upper=\"999999\"", vec![Mistake::Limits]),
        ] {
            assert_eq!(found(&inertial, geometry, limit), wanted, "{inertial} {limit}");
        }
    }

    #[test]
    fn one_body_in_most_links_is_a_copy() {
        let text = |masses: [f64; 4]| {
            let mut text = "convention: craig\nname: r\nlinks:\n".to_string();
            for k in 1..=4 {
                let before = if k == 1 { "base".into() } else { (k - 1).to_string() };
                text += &format!("- {{link: {k}, antecedent: {before}, alpha: pi/2, a: 0.3, theta: q{k}}}\n");
            }
            text += "standard_parameters:\n";
            for (k, mass) in masses.into_iter().enumerate() {
                let body = format!("mass: {mass}, centre_of_mass: [0.1, 0, 0], inertia: {{xx: 0.1, yy: 0.1, zz: 0.1}}");
                text += &format!("  {}: {{{body}}}\n", k + 1);
            }
            text
        };
        let urdf = |masses| {
            let (text, _) = crate::format::write_urdf(&crate::format::read_yaml(&text(masses), "r.yaml").unwrap());
            lint(&read_urdf(&text, "r.urdf").unwrap()).into_iter().map(|f| f.mistake).collect::<Vec<_>>()
        };
        assert_eq!(urdf([2.0, 2.0, 2.0, 5.0]), [Mistake::Copied]);
        assert_eq!(urdf([2.0, 2.0, 3.0, 5.0]), []);
    }
}
