//! Judges the inertial parameters of one body: finds values that are impossible, and values that are possible but probably not
//! intended.
//!
//! For a body with inertia I_C about its centre of mass, the matrix S = (tr(I_C)/2) E - I_C must be positive definite (part of
//! the pseudo-inertia) [Wensing, Kim, Slotine 2018]. Its eigenvalues are half the margins of the triangle inequalities of the
//! principal moments. S/m is the matrix of second moments about the centre of mass. The extent of the shapes bounds S/m.
//!
//! A body of mass m and density of at most rho has at least the radius of gyration of a ball with the same mass and the
//! density rho: sqrt(2/5) (3 m/(4 pi rho))^(1/3). rho is the density of the densest metal.

use std::f64::consts::PI;

use crate::body::Body;
use crate::finding::Mistake;
use crate::principal::principal_axes;
use crate::vector::{minus, norm};

/// A negative eigenvalue of S is allowed up to this magnitude, relative to the trace of I, because files contain rounded digits.
const EIGENVALUE_SLACK: f64 = 1e-4;
/// A mass above this value (kg) is probably given in g.
const LARGE_MASS_KG: f64 = 3000.0;
/// A centre of mass that is farther away than this value (m) is probably given in mm.
const FAR_CENTRE_M: f64 = 10.0;
/// If a radius of gyration is above this value (m), the units are probably wrong.
const LARGE_RADIUS_M: f64 = 10.0;
/// Density of osmium, the densest metal, kg/m^3.
const LARGEST_DENSITY: f64 = 22_600.0;
/// The inertia counts as too small if the radius of gyration is below this fraction of the smallest possible one.
const POSSIBLE_RADIUS_SHARE: f64 = 0.5;
/// The inertia counts as zero if the radius of gyration is below this fraction of the smallest possible one: exporters write
/// 1e-20 for zero.
const ZERO_RADIUS_SHARE: f64 = 1e-4;
/// A body without inertia is suspicious if its mass is above this value, kg. A lighter body is often only a marker of a frame.
const POINT_MASS_KG: f64 = 0.05;
/// Lowest and highest usual mean density of a whole link, kg/m^3: the lightest foam and solid lead.
const LINK_DENSITIES: (f64, f64) = (10.0, 12_000.0);
/// Largest usual distance of a centre of mass from the bounding box of the shapes, as a multiple of the diagonal of this box.
/// The factor allows for files that give the shapes of only a part of a link.
const CENTRE_MARGIN: f64 = 1.0;
/// Largest usual radius of the mass distribution (root mean square distance from the centre of mass), as a multiple of half the
/// diagonal of the bounding box of the shapes. For exact shapes the limit would be one; but collision shapes leave out motors
/// and cables.
const WIDEST_SPREAD: f64 = 2.0;
/// Smallest usual radius of the mass distribution (root mean square distance from the centre of mass), as a fraction of the
/// radius that the shapes would have with constant density. The fraction is small because a link may be long and light, with
/// one heavy motor that has most of the mass.
const NARROWEST_SPREAD: f64 = 0.2;
/// `NARROWEST_SPREAD` is multiplied by this factor for meshes, of which only the bounding box is known: for example, the arms
/// of a multicopter fill only a small part of their bounding box.
const MESH_SHARE: f64 = 0.5;
/// The value that replaces `NARROWEST_SPREAD` for a body after a repair. This bound is stricter.
const SOUND_SPREAD: f64 = 0.4;
/// A body that is fixed to another body and lighter than this fraction of the robot is not compared with shapes and other
/// bodies. The reason: many files have frames and sensors with masses that only have to be positive.
pub const NEGLIGIBLE_SHARE: f64 = 5e-3;
/// A body without shapes is too large if a rod with its inertia is longer than this multiple of the robot's longest chain.
const LONGEST_ROD: f64 = 2.0;
/// The last body of a branch is too heavy if its mass exceeds this multiple of the mass of all other bodies together.
const HEAVIEST_SHARE: f64 = 5.0;
/// Masses are compared if there are at least this number of other bodies.
const FEWEST_OTHERS: usize = 3;
/// A repaired body must have at least this fraction of the mean mass of the other bodies. If a repair divides the mass by 1000
/// by mistake, the body is much lighter than this.
const LIGHTEST_REPAIR: f64 = 1.0 / 30.0;

/// A moment below this fraction of the largest moment is a rounding error.
const ROUNDING: f64 = 1e-9;

/// One reason to doubt a body.
#[derive(Clone, Debug)]
pub(crate) struct Doubt {
    pub mistake: Mistake,
    pub fact: &'static str,
    pub evidence: String,
}

/// Whether the radius of the mass distribution of a repaired body is plausible: above the radius of a heavy core, and below the
/// radius of a hollow shell.
fn fits_well(body: &Body) -> bool {
    let Some(extent) = &body.extent else { return true };
    let [given, even] = [body.variance(), extent.uniform().0].map(|second| spread(&second));
    given <= 0.5 * extent.diagonal() && given >= SOUND_SPREAD * even
}

/// Radius of the mass distribution (root mean square distance from the centre of mass), m. `second`: matrix of second moments
/// divided by the mass.
pub(crate) fn spread(second: &[f64; 6]) -> f64 {
    (second[0] + second[3] + second[5]).max(0.0).sqrt()
}

/// Whether a repaired body is plausible. Its bounds are stricter than the bounds for a body of the file, because a repair that
/// only just fits is no evidence.
pub(crate) fn is_sound(body: &Body) -> bool {
    let (others, count) = body.others;
    let is_light = count >= FEWEST_OTHERS && body.mass * (count as f64) < LIGHTEST_REPAIR * others;
    let radius = (principal_axes(&body.inertia()).0[2].max(0.0) / body.mass).sqrt();
    !is_light && radius >= metal_radius(body.mass) && doubts(body).is_empty() && fits_well(body)
}

/// Radius of gyration of a ball of the densest metal, m.
fn metal_radius(mass: f64) -> f64 {
    (0.4f64).sqrt() * (3.0 * mass / (4.0 * PI * LARGEST_DENSITY)).cbrt()
}

/// The reasons to doubt a body, the worst first; empty if the body is plausible.
pub(crate) fn doubts(body: &Body) -> Vec<Doubt> {
    let mut found = Vec::new();
    let mut doubt = |mistake, fact, evidence| found.push(Doubt { mistake, fact, evidence });
    let inertia = body.inertia();
    let [least, middle, most] = principal_axes(&inertia).0;
    let mass = body.mass;
    if mass < 0.0 {
        doubt(Mistake::NegativeMass, "the mass is negative", format!("{mass} kg"));
        return found;
    }
    if mass == 0.0 {
        if inertia.iter().any(|i| *i != 0.0) {
            let moments = format!("up to {} kg m^2", shown(most, 3));
            doubt(Mistake::InertiaWithoutMass, "the mass is 0, the inertia is not", moments);
        }
        return found;
    }
    let metal = metal_radius(mass);
    let size = inertia.iter().fold(0.0f64, |largest, i| largest.max(i.abs()));
    if (size / mass).sqrt() <= ZERO_RADIUS_SHARE * metal {
        if mass > POINT_MASS_KG && body.turns {
            let fact = "the inertia is 0 though the mass is not: a point weighs so";
            doubt(Mistake::MassWithoutInertia, fact, format!("{mass} kg"));
        }
        return found;
    }
    if least < -EIGENVALUE_SLACK * most.abs()
        || least + middle - most < -EIGENVALUE_SLACK * (least + middle + most).abs()
    {
        doubt(Mistake::Impossible, "no body has these moments of inertia", impossible([least, middle, most]));
        return found;
    }
    if inertia == [1.0, 0.0, 0.0, 1.0, 0.0, 1.0] {
        let fact = "moments of 1 1 1 kg m^2 are a placeholder of an exporter";
        doubt(Mistake::Placeholder, fact, format!("of {mass} kg"));
        return found;
    }
    let radius = (most.max(0.0) / mass).sqrt();
    if radius < POSSIBLE_RADIUS_SHARE * metal {
        let fact = "no metal is so dense that the mass has so small an inertia";
        doubt(Mistake::Units, fact, format!("{} kg with a radius of gyration of {radius:.1e} m", shown(mass, 4)));
    }
    if mass > LARGE_MASS_KG {
        doubt(Mistake::Units, "no link is so heavy", format!("{mass} kg"));
    }
    let distance = norm(body.pose.position);
    if distance > FAR_CENTRE_M {
        let fact = "the centre of mass is far from the joint";
        doubt(Mistake::Units, fact, format!("{distance:.1} m"));
    }
    if !body.own && mass < NEGLIGIBLE_SHARE * (mass + body.others.0) {
        return found;
    }
    // If the shapes are too small for the mass, they show only a part of the body, or they are a mere placeholder. Then the
    // size is not compared.
    if !mass_doubts(body, &mut doubt) {
        size_doubts(body, radius, &mut doubt);
    }
    found
}

/// The reason why no body can have these principal moments, as a clause.
fn impossible([least, middle, most]: [f64; 3]) -> String {
    let size = most.abs().max(least.abs());
    let [a, b, c] = [least, middle, most].map(|x| if x.abs() < ROUNDING * size { 0.0 } else { shown(x, 5) });
    let why = if a < 0.0 {
        "none may be negative".to_string()
    } else {
        format!("the sum of the smaller two misses the largest by {}", shown(most - least - middle, 3))
    };
    format!("about the centre of mass {a}, {b}, {c} kg m^2, {why}")
}

/// Compares the radius of the mass distribution with the extent of the shapes, or with the size of the robot if there are no
/// shapes.
fn size_doubts(body: &Body, radius: f64, doubt: &mut impl FnMut(Mistake, &'static str, String)) {
    let variance = body.variance();
    let Some(extent) = &body.extent else {
        // A thin rod of length l has the variance l^2 / 12 along its axis. rod: the length for which this is the largest
        // variance of the body.
        let rod = (12.0 * principal_axes(&variance).0[2].max(0.0)).sqrt();
        if radius > LARGE_RADIUS_M || (body.link.is_some() && body.reach > 0.0 && rod > LONGEST_ROD * body.reach) {
            let text = format!(
                "{} kg with a radius of gyration of {radius:.3} m, a rod of {rod:.2} m, where the longest chain of joints is {:.2} m",
                shown(body.mass, 4),
                body.reach
            );
            doubt(Mistake::Size, "the inertia is too large for the robot", text);
        }
        return;
    };
    let outside = extent.distance(body.pose.position);
    let diagonal = extent.diagonal();
    if outside > CENTRE_MARGIN * diagonal {
        let text = format!("by {outside:.3} m, of shapes {diagonal:.3} m across");
        return doubt(Mistake::CentreOutside, "the centre of mass lies outside the collision shapes", text);
    }
    // given: radius of the mass distribution of the body; even: the radius for constant density in the shapes.
    let (given, even) = (spread(&variance), spread(&extent.uniform().0));
    let text = format!(
        "{} kg at a mean distance of {given:.3} m from their centre, constant density has {even:.3} m, the shapes are {diagonal:.3} m across",
        shown(body.mass, 4)
    );
    if given > WIDEST_SPREAD * 0.5 * diagonal {
        doubt(Mistake::Size, "the inertia is too large for the shapes", text);
    } else if given < NARROWEST_SPREAD * even * if extent.volume.is_some() { 1.0 } else { MESH_SHARE } {
        doubt(Mistake::Size, "the inertia is too small for the shapes", text);
    }
}

/// Compares the mass with the volume of the shapes and with the other bodies. Returns whether the shapes are too small for the
/// mass.
fn mass_doubts(body: &Body, doubt: &mut impl FnMut(Mistake, &'static str, String)) -> bool {
    let mut is_small = false;
    if let Some((extent, volume)) = body.extent.as_ref().and_then(|e| Some((e, e.volume?))) {
        let density = body.mass / volume;
        // Shapes may be a few points of contact. Their bounding box is as large as the body, so its volume is used for the
        // upper limit.
        let box_volume: f64 = minus(extent.high, extent.low).iter().product();
        let text = || format!("{} kg in {volume:.2e} m^3 are {:?} kg/m^3", shown(body.mass, 4), shown(density, 3));
        if density < LINK_DENSITIES.0 {
            doubt(Mistake::Density, "the mass is too small for the volume of the shapes", text());
        } else if body.mass > LINK_DENSITIES.1 * box_volume {
            doubt(Mistake::Density, "the mass is too large for the volume of the shapes", text());
            is_small = true;
        }
    }
    let (others, count) = body.others;
    if body.is_last && count >= FEWEST_OTHERS && body.mass > HEAVIEST_SHARE * others {
        let text = format!("{} kg, the {count} others {} kg", shown(body.mass, 4), shown(others, 4));
        doubt(Mistake::MassBesideOthers, "the mass is far above that of all other bodies together", text);
    }
    is_small
}

/// A number rounded to `digits` significant digits.
pub(crate) fn shown(x: f64, digits: usize) -> f64 {
    format!("{x:.*e}", digits - 1).parse().unwrap_or(x)
}
