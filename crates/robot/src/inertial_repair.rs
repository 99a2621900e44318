//! Tries usual mistakes of descriptions (slips) on a body that is impossible or implausible. A slip is named only if its
//! correction, and no other one, makes the body plausible.

use crate::body::{Body, shifted};
use crate::body_doubt::{doubts, is_sound, shown};
use crate::finding::{Mistake, Repair, RepairedBody};
use crate::robot::Format;
use crate::vector::{norm, scaled};

/// A centre of mass can be in mm only if its distance from the origin is at least this value, m.
const NEAREST_CENTRE_IN_MM: f64 = 2.0;
/// A mass can be in g only if it is at least this value.
const LEAST_MASS_IN_G: f64 = 10.0;
/// Two corrections have the same result if the results differ by less than this value, relative to the largest moment.
const SAME_SHARE: f64 = 1e-6;

/// The function that corrects a slip of a body; it returns `None` if this body cannot have the slip.
type Undo = Box<dyn Fn(&Body) -> Option<Body>>;

/// A slip (usual mistake of a description), and the clause that names its correction.
struct Slip {
    text: String,
    undo: Undo,
    /// Whether the numbers of the file determine all numbers of the repaired body.
    is_determined: bool,
}

/// Orders in which the six numbers may have been written into the file by mistake. Entry k belongs to the k-th of xx xy xz yy
/// yz zz. It is the index of the place in the file (in the order xx xy xz yy yz zz) that contains this number.
const ORDERS: [(&str, [usize; 6]); 3] = [
    ("Ixz and Iyz exchanged", [0, 1, 4, 3, 2, 5]),
    ("the six taken in Pinocchio's order, xx xy yy xz yz zz", [0, 1, 3, 2, 4, 5]),
    ("the six taken in MuJoCo's order, xx yy zz xy xz yz", [0, 3, 4, 1, 5, 2]),
];
/// As in `ORDERS`: a file writer used the order of a URDF for an MJCF, whose order is xx yy zz xy xz yz.
const URDF_IN_MJCF: (&str, [usize; 6]) =
    ("the six taken in the order of a URDF, xx xy xz yy yz zz", [0, 3, 5, 1, 2, 4]);

/// Usual confusions of units. The three numbers are the factors for mass, lengths and inertia.
const UNITS: [(&str, [f64; 3]); 10] = [
    ("the mass in g", [1e-3, 1.0, 1.0]),
    ("1000 times the mass (it may be in t)", [1e3, 1.0, 1.0]),
    ("the centre of mass in mm", [1.0, 1e-3, 1.0]),
    ("the inertia in g m^2", [1.0, 1.0, 1e-3]),
    ("the inertia in kg mm^2", [1.0, 1.0, 1e-6]),
    ("the inertia in g mm^2", [1.0, 1.0, 1e-9]),
    ("mass and inertia in g and g m^2", [1e-3, 1.0, 1e-3]),
    ("mass and inertia in g and g mm^2", [1e-3, 1.0, 1e-9]),
    ("centre and inertia in mm and kg mm^2", [1.0, 1e-3, 1e-6]),
    ("all in g and mm", [1e-3, 1e-3, 1e-9]),
];

/// The only repair that makes a body plausible; `None` if there is no such repair, or more than one.
pub(crate) fn repair(body: &Body, format: Format) -> Option<Repair> {
    if doubts(body).first().is_none_or(|doubt| doubt.mistake == Mistake::Placeholder) {
        return None;
    }
    let mut found: Option<(Slip, Body)> = None;
    for slip in slips(format) {
        let Some(changed) = (slip.undo)(body).filter(is_sound) else { continue };
        match &found {
            Some((_, first)) if !is_same(first, &changed) => return None,
            Some(_) => {}
            None => found = Some((slip, changed)),
        }
    }
    let (slip, changed) = found?;
    let text = format!("with {} that is plausible", slip.text);
    if !slip.is_determined {
        let text = format!("{text}, and Izz has to be written (Ixx {}, Iyy {})", changed.given[0], changed.given[3]);
        return Some(Repair { text, bodies: Vec::new() });
    }
    let (pose, is_moved, inertia) = (changed.pose, changed.pose != body.pose, changed.inertia());
    Some(Repair {
        text,
        bodies: vec![RepairedBody { name: changed.name, mass: changed.mass, pose, is_moved, inertia }],
    })
}

fn is_same(a: &Body, b: &Body) -> bool {
    let largest = a.given.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let near = |x: f64, y: f64| (x - y).abs() <= SAME_SHARE * largest;
    a.mass == b.mass && a.pose == b.pose && a.given.iter().zip(&b.given).all(|(x, y)| near(*x, *y))
}

fn slips(format: Format) -> Vec<Slip> {
    let orders = if format == Format::Mjcf { vec![ORDERS[0], URDF_IN_MJCF] } else { ORDERS.to_vec() };
    let mut all: Vec<Slip> =
        orders.into_iter().map(|(text, order)| slip(text, move |b| with(b, order.map(|k| b.given[k])))).collect();
    all.push(Slip { is_determined: false, ..slip("the six taken as the first two rows of the matrix", two_rows) });
    all.push(slip("the signs of the negative moments changed", positive_moments));
    all.push(slip("the inertia taken about the origin of the frame instead of the centre of mass", about_origin));
    all.push(slip("the inertia taken about the centre of mass instead of the origin of the frame", about_centre));
    all.push(slip("m (c.c E - c c^T) added, which was taken off once too often,", taken_off_twice));
    all.push(slip("the parallel-axis terms of its shapes added", of_shapes));
    for (text, [mass, length, inertia]) in UNITS {
        all.push(slip(text, move |b| in_units(b, mass, length, inertia)));
    }
    all
}

fn slip(text: &str, undo: impl Fn(&Body) -> Option<Body> + 'static) -> Slip {
    Slip { text: text.into(), undo: Box::new(undo), is_determined: true }
}

/// The body with other inertia numbers; `None` if these numbers are the same as before.
fn with(body: &Body, given: [f64; 6]) -> Option<Body> {
    (given != body.given).then(|| Body { given, ..body.clone() })
}

/// Corrects this slip: the file has xx xy xz yx yy yz (the first two rows of the matrix) in the places of the six numbers. It
/// is recognised by two equal numbers, xy and yx. The missing zz is set to a value that is possible.
fn two_rows(body: &Body) -> Option<Body> {
    let [xx, xy, xz, yx, yy, yz] = body.given;
    (xy == yx && xy != yy).then(|| Body { given: [xx, xy, xz, yy, yz, xx.max(yy)], ..body.clone() })
}

fn positive_moments(body: &Body) -> Option<Body> {
    let [xx, xy, xz, yy, yz, zz] = body.given;
    with(body, [xx.abs(), xy, xz, yy.abs(), yz, zz.abs()])
}

/// Corrects this slip: the format needs numbers about the centre of mass, but the file gives them about the origin.
fn about_origin(body: &Body) -> Option<Body> {
    if body.about_origin { None } else { moved(body, -1.0) }
}

/// Corrects this slip: the format needs numbers about the origin, but the file gives them about the centre of mass.
fn about_centre(body: &Body) -> Option<Body> {
    if body.about_origin { moved(body, 1.0) } else { None }
}

/// Corrects this slip: the shift to the centre of mass was made twice. If half of the shift already makes the body plausible,
/// many shifts do so, and the numbers do not show which shift is right. Then the result is `None`.
fn taken_off_twice(body: &Body) -> Option<Body> {
    let is_shown = !body.about_origin && !moved(body, 0.5).is_some_and(|half| is_sound(&half));
    if is_shown { moved(body, 1.0) } else { None }
}

fn moved(body: &Body, times: f64) -> Option<Body> {
    if !body.own || (body.about_origin && times < 0.0) {
        return None;
    }
    with(body, shifted(&body.given, times * body.mass, body.centre_from_origin()))
}

/// Corrects this slip: the moments are about the centres of the single shapes, so the parallel-axis terms for the distances
/// between the centres are missing.
fn of_shapes(body: &Body) -> Option<Body> {
    let [xx, xy, xz, yy, yz, zz] = body.extent.as_ref()?.uniform().1;
    let is_parallel = body.pose.rotation == crate::inertial::Pose::IDENTITY.rotation;
    let added = [yy + zz, -xy, -xz, xx + zz, -yz, xx + yy];
    if is_parallel { with(body, std::array::from_fn(|k| body.given[k] + body.mass * added[k])) } else { None }
}

fn in_units(body: &Body, mass: f64, length: f64, inertia: f64) -> Option<Body> {
    // Parameters about the origin contain first moments. So a changed mass moves the centre of mass, unless mass and inertia
    // have the same factor.
    let is_moved = body.about_origin && mass != inertia;
    let position = scaled(body.pose.position, if is_moved { length / mass } else { length });
    // A centre of mass in mm is at a distance that no body has. A centre that is only outside its shapes has another cause.
    let is_far = length == 1.0 || (body.own && norm(body.pose.position) > NEAREST_CENTRE_IN_MM);
    let is_new = is_far && (mass >= 1.0 || body.mass > LEAST_MASS_IN_G);
    let pose = crate::inertial::Pose { position, ..body.pose };
    is_new.then(|| Body {
        mass: shown(mass * body.mass, 15),
        given: body.given.map(|x| shown(inertia * x, 15)),
        pose,
        ..body.clone()
    })
}

#[cfg(test)]
mod tests {
    use crate::format::read_urdf;
    use crate::lint::{Finding, Mistake, lint};

    /// The findings on the last body of an arm whose other bodies are plausible: 3, 2 and 1.5 kg, with joints 0.7 m apart.
    fn found(inertial: &str, shapes: &str) -> Vec<Finding> {
        let sound = |mass: f64| inertial_of(mass, "0.1 0.02 0.05", [0.02, 0.001, 0.002, 0.03, 0.0005, 0.025]);
        let link = |name: &str, inertial: &str, shapes: &str| {
            format!("<link name=\"{name}\"><inertial>{inertial}</inertial>{shapes}</link>")
        };
        let joint = |name: &str, parent: &str, child: &str, at: &str| {
            format!(
                "<joint name=\"{name}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
                 <origin xyz=\"{at}\"/><axis xyz=\"0 1 0\"/></joint>"
            )
        };
        let bodies = [link("b", &sound(3.0), ""), link("l1", &sound(2.0), ""), link("l2", &sound(1.5), "")];
        let joints =
            [joint("j1", "b", "l1", "0 0 0.1"), joint("j2", "l1", "l2", "0 0 0.2"), joint("j3", "l2", "l3", "0.4 0 0")];
        let text =
            format!("<robot name=\"r\">{}{}{}</robot>", bodies.concat(), link("l3", inertial, shapes), joints.concat());
        lint(&read_urdf(&text, "r.urdf").unwrap_or_else(|e| panic!("{e}")))
    }

    fn inertial_of(mass: f64, centre: &str, [xx, xy, xz, yy, yz, zz]: [f64; 6]) -> String {
        format!(
            "<origin xyz=\"{centre}\"/><mass value=\"{mass}\"/><inertia ixx=\"{xx}\" ixy=\"{xy}\" ixz=\"{xz}\" iyy=\"{yy}\" \
             iyz=\"{yz}\" izz=\"{zz}\"/>"
        )
    }

    const CUBE: &str = "<collision><geometry><box size=\"0.1 0.1 0.1\"/></geometry></collision>";

    /// Each slip was made on a plausible body. Its correction must give the plausible body again.
    #[test]
    fn the_slip_that_was_made_is_named_and_undone() {
        let two = "<collision><geometry><box size=\"0.06 0.06 0.06\"/></geometry></collision><collision><origin xyz=\"0.4 0 0\"/>\
                   <geometry><box size=\"0.06 0.06 0.06\"/></geometry></collision>";
        let oblique = [0.004, -0.0005, 0.0021, 0.005, 0.0002, 0.0025];
        let [xx, xy, xz, yy, yz, zz] = oblique;
        let cube = [0.002, 0.0, 0.0, 0.002, 0.0, 0.002];
        for (mass, centre, given, shapes, named, repaired) in [
            (0.9, "0 0 0.1", [xx, yy, zz, xy, xz, yz], "", "MuJoCo's order", Some((0.9, oblique))),
            (0.9, "0 0 0.1", [xx, xy, yy, xz, yz, zz], "", "Pinocchio's order", Some((0.9, oblique))),
            (2.0, "0 0 0", [0.02, -0.003, 0.0, -0.003, 0.03, 0.0], "", "the first two rows of the matrix", None),
            (0.8, "0 0 0.1", [-xx, xy, xz, -yy, yz, zz], "", "the signs of the negative moments", Some((0.8, oblique))),
            (
                2.0,
                "0.2 0 0",
                [0.0012, 0.0, 0.0, 0.0012, 0.0, 0.0012],
                two,
                "parallel-axis terms of its shapes",
                Some((2.0, [0.0012, 0.0, 0.0, 0.0812, 0.0, 0.0812])),
            ),
            (
                1.2,
                "0 0 0.1",
                [0.0001, 0.0, 0.0, 0.0001, 0.0, 0.02],
                "",
                "taken off once too often",
                Some((1.2, [0.0121, 0.0, 0.0, 0.0121, 0.0, 0.02])),
            ),
            (0.0012, "0 0 0", cube, CUBE, "1000 times the mass", Some((1.2, cube))),
            (1200.0, "0 0 0", cube, CUBE, "the mass in g", Some((1.2, cube))),
            (1.2, "0 0 0", cube.map(|i| 1e6 * i), CUBE, "the inertia in kg mm^2", Some((1.2, cube))),
            (1.2, "0 0 0", cube.map(|i| 1e9 * i), CUBE, "the inertia in g mm^2", Some((1.2, cube))),
            (1.2, "0 30 0", cube, CUBE, "the centre of mass in mm", Some((1.2, cube))),
        ] {
            let findings = found(&inertial_of(mass, centre, given), shapes);
            assert!(findings.len() == 1 && findings[0].subjects == ["l3"], "{named}: {findings:#?}");
            assert!(findings[0].text().contains(named), "{named}: {}", findings[0].text());
            let bodies = &findings[0].repair.as_ref().unwrap().bodies;
            assert_eq!(bodies.first().map(|body| body.mass), repaired.map(|r| r.0), "{named}");
            for (body, (_, inertia)) in bodies.iter().zip(repaired) {
                let off = body.inertia.iter().zip(inertia).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < 1e-12, "{named}: {:?}", body.inertia);
            }
        }
    }

    /// If no repair or several repairs are plausible, the numbers do not show the cause. Some of these bodies have a
    /// substitute ([`crate::substitute`]).
    #[test]
    fn no_cause_is_named_where_the_values_do_not_determine_one() {
        let cube = [0.002, 0.0, 0.0, 0.002, 0.0, 0.002];
        for (mass, centre, given, shapes, substitute) in [
            // The triangle inequality is violated by a small amount: nearly any shift of the centre would satisfy it.
            (2.0, "0.1 0.02 0.05", [0.01, 0.0, 0.0, 0.02, 0.0, 0.0327], "", "the nearest possible moments"),
            // The violation is not small.
            (2.0, "0 0 0", [0.01, 0.0, 0.0, 0.02, 0.0, 0.0347], "", ""),
            // No wrong unit explains 1.5 kg m^2 instead of the 0.0125 kg m^2 of the box.
            (7.5, "0 0 0", [1.5, 0.0, 0.0, 1.5, 0.0, 1.5], CUBE, "the moments of its shapes"),
            // A placeholder is not a number in a wrong unit.
            (0.6, "0 0 0", [1.0, 0.0, 0.0, 1.0, 0.0, 1.0], CUBE, ""),
            (42.9, "0 0 0", cube.map(|i| 150.0 * i), "", ""),
            // Moments rounded to zero.
            (2.0, "0 0 0", [0.0; 6], "", ""),
            (2.0, "0 0 0", [0.0; 6], CUBE, "the moments of its shapes"),
        ] {
            let findings = found(&inertial_of(mass, centre, given), shapes);
            let text = findings[0].text();
            assert!(findings.len() == 1, "{given:?}: {findings:#?}");
            let bodies = findings[0].repair.as_ref().map_or(0, |repair| repair.bodies.len());
            assert_eq!(bodies, usize::from(!substitute.is_empty()), "{text}");
            assert!(text.contains(substitute), "{text}");
            let is_asked = matches!(findings[0].mistake, Mistake::Impossible | Mistake::Size);
            assert_eq!(text.contains("do not determine the cause"), is_asked, "{text}");
        }
        assert_eq!(found(&inertial_of(0.8, "0.1 0 0", cube), CUBE), []);
    }
}
