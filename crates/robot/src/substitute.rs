//! Plausible moments of inertia for a body whose mistake is not known.
//!
//! | finding on the body | substitute |
//! |---|---|
//! | the triangle inequality of the principal moments is violated by a small amount | the nearest possible moments |
//! | impossible moments, no moments, or moments that do not fit the shapes | mass times the moments of the shapes with constant density |
//!
//! S = (tr(I)/2) E - I is the matrix of second moments of a body with the inertia I about its centre of mass. If I has the
//! principal moments a <= b <= c with c = a + b + d, S has the negative eigenvalue -d/2. The nearest positive semidefinite
//! matrix (in the Frobenius norm) has zero instead [Higham 1988]:
//!
//! ```text
//! I' = I + d/2 (E - v v')          v: principal axis of c
//! ```
//! a and b grow by d/2, and c stays. A substitute is offered only if the body with it is plausible.

use crate::body::{Body, shifted};
use crate::body_doubt::{is_sound, shown};
use crate::finding::{Finding, Mistake, Repair, RepairedBody};
use crate::inertial::turned_inertia;
use crate::principal::principal_axes;
use crate::vector::transposed;

/// Number of significant digits of the moments.
const DIGITS: usize = 12;

/// The violation d of the triangle inequality is small up to this fraction of the largest moment.
const SMALL_VIOLATION: f64 = 0.1;

/// Gives findings without a repair a substitute, if there is one.
pub(crate) fn substitute(bodies: &[Body], findings: &mut [Finding]) {
    use Mistake::{Impossible, MassWithoutInertia, Size};
    let open = findings.iter_mut().filter(|finding| finding.repair.is_none());
    for finding in open.filter(|finding| matches!(finding.mistake, Impossible | MassWithoutInertia | Size)) {
        let Some(body) = bodies.iter().find(|body| body.name == finding.subjects[0]) else { continue };
        let nearest = nearest(body).map(|inertia| ("the nearest possible moments", inertia));
        let candidates =
            [nearest, of_shapes(body).map(|inertia| ("the moments of its shapes with constant density", inertia))];
        let rounded = |(name, inertia): (&'static str, [f64; 6])| (name, inertia.map(|i| shown(i, DIGITS)));
        let sound = candidates.into_iter().flatten().map(rounded).find(|(_, inertia)| is_sound(&with(body, inertia)));
        finding.repair = sound.map(|(name, inertia)| repair(body, finding.mistake, name, inertia));
    }
}

fn repair(body: &Body, mistake: Mistake, name: &str, inertia: [f64; 6]) -> Repair {
    let cause =
        if mistake == Mistake::MassWithoutInertia { "" } else { "the values alone do not determine the cause; " };
    let body = RepairedBody { name: body.name.clone(), mass: body.mass, pose: body.pose, is_moved: false, inertia };
    Repair { text: format!("{cause}{name} are plausible"), bodies: vec![body] }
}

/// The body with another inertia about its centre of mass.
fn with(body: &Body, inertia: &[f64; 6]) -> Body {
    let given = if body.about_origin { shifted(inertia, body.mass, body.pose.position) } else { *inertia };
    Body { given, ..body.clone() }
}

/// The nearest possible inertia about the centre of mass; `None` if the violation is not small.
fn nearest(body: &Body) -> Option<[f64; 6]> {
    let inertia = body.inertia();
    let ([least, middle, most], axes) = principal_axes(&inertia);
    let violation = most - least - middle;
    if least < 0.0 || violation <= 0.0 || violation > SMALL_VIOLATION * most {
        return None;
    }
    let [x, y, z] = axes.map(|row| row[2]);
    let across = [1.0 - x * x, -x * y, -x * z, 1.0 - y * y, -y * z, 1.0 - z * z];
    Some(std::array::from_fn(|k| inertia[k] + 0.5 * violation * across[k]))
}

/// The inertia of the shapes with constant density and the mass of the body, in the axes of the inertial frame.
fn of_shapes(body: &Body) -> Option<[f64; 6]> {
    let [xx, xy, xz, yy, yz, zz] = body.extent.as_ref()?.uniform().0;
    let in_file = [yy + zz, -xy, -xz, xx + zz, -yz, xx + yy].map(|i| body.mass * i);
    Some(turned_inertia(&in_file, &transposed(&body.pose.rotation)))
}

#[cfg(test)]
mod tests {
    use crate::format::read_urdf;
    use crate::lint::{Finding, lint};

    /// The findings on a body, and the inertia of the substitute.
    fn found(inertial: &str, shape: &str) -> (Vec<Finding>, [f64; 6]) {
        let text = format!(
            "<robot name=\"r\"><link name=\"b\"/><link name=\"l\"><inertial>{inertial}</inertial>{shape}</link>\
             <joint name=\"j\" type=\"continuous\"><parent link=\"b\"/><child link=\"l\"/><axis xyz=\"0 1 0\"/></joint></robot>"
        );
        let findings = lint(&read_urdf(&text, "r.urdf").unwrap_or_else(|e| panic!("{e}")));
        let body = findings.iter().find_map(|finding| finding.repair.as_ref()?.bodies.first());
        let inertia = body.unwrap_or_else(|| panic!("{findings:#?}")).inertia;
        (findings, inertia)
    }

    /// I = diag(0.01, 0.02, 0.0327) violates the inequality by d = 0.0027, so the two smaller moments grow by 0.00135.
    #[test]
    fn the_nearest_possible_moments_are_flat() {
        let (_, nearest) = found(
            "<mass value=\"2\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.02\" iyz=\"0\" izz=\"0.0327\"/>",
            "",
        );
        let off = |k: usize, wanted: f64| (nearest[k] - wanted).abs();
        let moments = off(0, 0.01135).max(off(3, 0.02135)).max(off(5, 0.0327));
        assert!(moments < 1e-15 && off(1, 0.0).max(off(2, 0.0)).max(off(4, 0.0)) < 1e-15, "{nearest:?}");
    }

    /// The inertial frame is turned by a right angle about z, and the shape is a box: m/12 of the squares of its sides.
    #[test]
    fn the_moments_of_a_box_are_in_the_axes_of_the_inertial_frame() {
        let (findings, of_box) = found(
            "<origin rpy=\"0 0 1.5707963267948966\"/><mass value=\"1.2\"/>\
             <inertia ixx=\"0.7\" ixy=\"0\" ixz=\"0\" iyy=\"0.7\" iyz=\"0\" izz=\"0.7\"/>",
            "<collision><geometry><box size=\"0.1 0.2 0.3\"/></geometry></collision>",
        );
        let wanted = [0.1 * (0.01 + 0.09), 0.0, 0.0, 0.1 * (0.04 + 0.09), 0.0, 0.1 * (0.01 + 0.04)];
        let off = of_box.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-15, "{of_box:?}");
        let text = findings[0].text();
        assert!(text.contains("the moments of its shapes with constant density are plausible"), "{text}");
    }
}
