//! Finds usual mistakes in the inertial parameters of a description: values that no real body can have.
//!
//! For a body with inertia I_C about its centre of mass, the matrix S = (tr(I_C)/2) E - I_C (E: identity matrix) must be positive
//! definite; it is part of the pseudo-inertia [Wensing, Kim, Slotine 2018]. The triangle inequalities of the principal moments
//! mean that the eigenvalues of S are positive. If S is not positive definite, possible mistakes are tried: exchanged entries, or
//! an inertia about another point. A mistake cannot be found if the wrong values are also physically possible.
//!
//! Whether the values are correct for the real robot is not checked here; this is the task of identification.

use crate::inertial::{Part, Pose, transform_inertial};
use crate::inertial_conventions::inertial_conventions;
use crate::principal::principal_axes;
use crate::robot::{Link, Robot};

pub use crate::finding::{Finding, Mistake};

/// A negative eigenvalue of S is allowed up to this magnitude, relative to the trace of the inertia: the digits in a file are
/// rounded.
const EIGENVALUE_SLACK: f64 = 1e-4;
/// If a mass is above this, kg, its unit is probably g.
const LARGE_MASS_KG: f64 = 3000.0;
/// If a centre of mass is farther away than this, m, its unit is probably mm.
const FAR_CENTRE_M: f64 = 10.0;
/// If a radius of gyration is above this, m, the units are probably wrong.
const LARGE_RADIUS_M: f64 = 10.0;
/// If a radius of gyration is below this, m, the units are probably wrong.
const SMALL_RADIUS_M: f64 = 1e-4;

/// The findings on the inertial parameters of a robot, link by link.
pub fn lint(robot: &Robot) -> Vec<Finding> {
    let mut findings = Vec::new();
    for part in &robot.base.parts {
        about_centre(part, &Pose::IDENTITY, false, &mut findings);
    }
    for link in &robot.links {
        if link.parts.is_empty() {
            if let Some(x) = link.inertial {
                about_origin(&link.name, &x, &mut findings);
            }
            continue;
        }
        for part in &link.parts {
            about_centre(part, &link.file_frame, part.name == link.name, &mut findings);
            turned_frame(link, part, &mut findings);
        }
    }
    inertial_conventions(robot, &mut findings);
    findings.extend(robot.oddities.iter().cloned());
    findings
}

/// Checks a link whose parameters are given about the origin of its link frame.
fn about_origin(name: &str, x: &[f64; 10], findings: &mut Vec<Finding>) {
    let mut find = |mistake, text| findings.push(Finding { link: name.into(), mistake, text });
    let Some(part) = Part::from_parameters(name.into(), x, Pose::IDENTITY.rotation) else {
        if x.iter().any(|x| *x != 0.0) {
            find(Mistake::InertiaWithoutMass, "its mass is 0, its inertia or first moment is not".into());
        }
        return;
    };
    if part.mass < 0.0 {
        return find(Mistake::NegativeMass, format!("its mass is {} kg", part.mass));
    }
    units(&part, part.pose.position, &mut find);
    if possible(&part.inertia) {
        return;
    }
    impossible(&part.inertia, &mut find);
    let again = |changed: [f64; 10]| {
        Part::from_parameters(String::new(), &changed, Pose::IDENTITY.rotation).is_some_and(|p| possible(&p.inertia))
    };
    swaps(&x[..6], |six| again(with_inertia(x, six)), &mut find);
    let given: [f64; 6] = std::array::from_fn(|k| x[k]);
    if possible(&given) {
        let text = "taken about the centre of mass, the same six numbers are possible: were they never moved to the \
                    origin of the frame (I_O = I_C + m (c.c E - c c^T))?";
        find(Mistake::WrongPoint, text.into());
    }
}

/// Checks a body that is given about its centre of mass. `file_frame`: pose of the link's frame in the file, in our link frame.
/// `own`: whether the body is the link itself, so that this frame of the file is the frame of the body.
fn about_centre(part: &Part, file_frame: &Pose, own: bool, findings: &mut Vec<Finding>) {
    let mut find = |mistake, text| findings.push(Finding { link: part.name.clone(), mistake, text });
    if part.mass < 0.0 {
        return find(Mistake::NegativeMass, format!("its mass is {} kg", part.mass));
    }
    if part.mass == 0.0 {
        if part.inertia.iter().any(|i| *i != 0.0) {
            find(Mistake::InertiaWithoutMass, "its mass is 0, its inertia is not".into());
        }
        return;
    }
    let in_file = file_frame.inverse().compose(&part.pose);
    units(part, in_file.position, &mut find);
    if possible(&part.inertia) {
        return;
    }
    impossible(&part.inertia, &mut find);
    swaps(&part.inertia, |six| possible(&six), &mut find);
    // Tests one mistake: the shift m (c.c E - c c^T) from the origin to the centre of mass was subtracted twice. If so, the
    // inertia is possible after the shift is added once. c: vector from the origin of the file's frame, in the axes of the
    // inertia.
    let c = in_file.inverse().position;
    let mut x = [0.0; 10];
    x[..6].copy_from_slice(&part.inertia);
    x[9] = part.mass;
    let moved = transform_inertial(&x, &Pose { position: c, ..Pose::IDENTITY });
    let six: [f64; 6] = std::array::from_fn(|k| moved[k]);
    if own && c != [0.0; 3] && possible(&six) {
        let text = "with m (c.c E - c c^T) added, the six numbers are possible: was that taken off once too often on \
                    the way to the centre of mass?";
        find(Mistake::WrongPoint, text.into());
    }
}

fn with_inertia(x: &[f64; 10], six: [f64; 6]) -> [f64; 10] {
    let mut changed = *x;
    changed[..6].copy_from_slice(&six);
    changed
}

/// Exchanges two entries of the inertia for trial, and reports exchanges with which the body becomes possible.
fn swaps(given: &[f64], makes_sense: impl Fn([f64; 6]) -> bool, find: &mut impl FnMut(Mistake, String)) {
    let exchanged = |i: usize, j: usize| {
        let mut six = [0.0; 6];
        six.copy_from_slice(given);
        six.swap(i, j);
        six
    };
    if given[2] != given[4] && makes_sense(exchanged(2, 4)) {
        let text =
            format!("with Ixz = {} and Iyz = {} exchanged it is possible: are they swapped?", given[2], given[4]);
        find(Mistake::SwappedProducts, text);
    }
    if given[2] != given[3] && makes_sense(exchanged(2, 3)) {
        let text = format!(
            "with Ixz = {} and Iyy = {} exchanged it is possible: Pinocchio's order is Ixx Ixy Iyy Ixz Iyz Izz",
            given[2], given[3]
        );
        find(Mistake::SwappedOrder, text);
    }
}

/// A number rounded to `digits` significant digits.
fn shown(x: f64, digits: usize) -> f64 {
    format!("{x:.*e}", digits - 1).parse().unwrap_or(x)
}

fn impossible(six: &[f64; 6], find: &mut impl FnMut(Mistake, String)) {
    let [a, b, c] = principal_axes(six).0;
    let [least, middle, most] = [a, b, c].map(|x| shown(x, 5));
    let moments = format!("the principal moments about its centre of mass are {least}, {middle}, {most} kg m^2");
    if a < 0.0 {
        find(Mistake::NotPositive, format!("{moments}: none may be negative"));
    }
    if a + b < c {
        let text = format!("{moments}: the sum of the smaller two misses the largest by {}", shown(c - a - b, 3));
        find(Mistake::TriangleInequality, text);
    }
}

fn possible(six: &[f64; 6]) -> bool {
    let [a, b, c] = principal_axes(six).0;
    a + b - c >= -EIGENVALUE_SLACK * (a + b + c).abs() && a >= -EIGENVALUE_SLACK * c.abs()
}

fn units(part: &Part, centre: [f64; 3], find: &mut impl FnMut(Mistake, String)) {
    let distance = centre.iter().map(|x| x * x).sum::<f64>().sqrt();
    let radius = (principal_axes(&part.inertia).0[2].max(0.0) / part.mass).sqrt();
    if part.mass > LARGE_MASS_KG {
        find(Mistake::Units, format!("its mass is {} kg: are grams meant?", part.mass));
    }
    if distance > FAR_CENTRE_M {
        find(Mistake::Units, format!("its centre of mass lies {distance:.1} m from the joint: are millimetres meant?"));
    }
    if radius > LARGE_RADIUS_M || (radius > 0.0 && radius < SMALL_RADIUS_M) {
        let text = format!("its radius of gyration is {radius:.2e} m: are its inertia and its mass in kg m^2 and kg?");
        find(Mistake::Units, text);
    }
}

/// The inertial frame counts as not rotated if its rotation changes each entry of the inertia by at most this fraction of the
/// largest principal moment. Angles in files have six digits.
const ROUNDED_TURN_SHARE: f64 = 1e-6;

/// Reports a body whose inertial frame is rotated relative to the link frame, if this changes the entries of its inertia.
fn turned_frame(link: &Link, part: &Part, findings: &mut Vec<Finding>) {
    if part.name != link.name || part.mass <= 0.0 {
        return;
    }
    let in_file = link.file_frame.inverse().compose(&part.pose);
    let mut x = [0.0; 10];
    x[..6].copy_from_slice(&part.inertia);
    let turned = transform_inertial(&x, &Pose { position: [0.0; 3], ..in_file });
    let largest = principal_axes(&part.inertia).0[2].abs();
    let away = (0..6).map(|k| (turned[k] - x[k]).abs()).fold(0.0, f64::max);
    if away > ROUNDED_TURN_SHARE * largest {
        let text = format!(
            "its inertial frame is turned (rpy): whoever ignores that reads entries wrong by up to {} kg m^2, \
             {:.0} % of the largest principal moment",
            shown(away, 3),
            100.0 * away / largest
        );
        findings.push(Finding { link: part.name.clone(), mistake: Mistake::TurnedInertialFrame, text });
    }
}
