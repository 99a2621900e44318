//! Judges the inertial parameters of one body: what is impossible, and what is possible but hardly meant.
//!
//! For a body with inertia I_C about its centre of mass, the matrix S = (tr(I_C)/2) E - I_C must be positive definite (part
//! of the pseudo-inertia) [Wensing, Kim, Slotine 2018]. Its eigenvalues are half the margins of the triangle inequalities of
//! the principal moments. S/m is the matrix of second moments about the centre of mass, which the room of the shapes bounds.
//!
//! A body of mass m and density of at most rho has at least the radius of gyration of a ball with the same mass and the
//! density rho: sqrt(2/5) (3 m/(4 pi rho))^(1/3). rho is the density of the densest metal.

use std::f64::consts::PI;

use crate::body::Body;
use crate::finding::Mistake;
use crate::principal::principal_axes;
use crate::vector::norm;

/// A negative eigenvalue of S is allowed up to this magnitude, relative to the trace of I, because files contain rounded digits.
const EIGENVALUE_SLACK: f64 = 1e-4;
/// If a mass is above this, kg, its unit is probably g.
const LARGE_MASS_KG: f64 = 3000.0;
/// If a centre of mass is farther away than this, m, its unit is probably mm.
const FAR_CENTRE_M: f64 = 10.0;
/// If a radius of gyration is above this, m, the units are probably wrong.
const LARGE_RADIUS_M: f64 = 10.0;
/// Density of osmium, the densest metal, kg/m^3.
const LARGEST_DENSITY: f64 = 22_600.0;
/// The inertia counts as too small if the radius of gyration is below this fraction of the smallest possible one.
const POSSIBLE_RADIUS_SHARE: f64 = 0.5;
/// The inertia counts as zero if the radius of gyration is below this fraction of the smallest possible one: exporters write
/// 1e-20 for zero.
const ZERO_RADIUS_SHARE: f64 = 1e-4;
/// A body without inertia is suspicious if its mass is above this, kg. A lighter one is often only a marker of a frame.
const POINT_MASS_KG: f64 = 0.05;
/// Lowest and highest usual mean density of a whole link, kg/m^3: foam and solid steel.
const LINK_DENSITIES: (f64, f64) = (20.0, 12_000.0);
/// Largest usual distance of a centre of mass from the box of the shapes, as a multiple of its diagonal.
const CENTRE_MARGIN: f64 = 0.5;
/// Largest usual spread of the mass along an axis, as a multiple of the largest one in the box of the shapes: collision shapes
/// leave out motors and cables.
const WIDEST_SPREAD: f64 = 2.0;
/// Smallest usual spread of the mass along an axis, as a fraction of that of constant density: one heavy motor in a long link.
const NARROWEST_SPREAD: f64 = 0.2;
/// A body without shapes is too large if a rod with its inertia is longer than this multiple of the robot's longest chain.
const LONGEST_ROD: f64 = 2.0;
/// A moving body is too heavy if its mass is this multiple of the mass of all others together.
const HEAVIEST_SHARE: f64 = 5.0;
/// Number of other bodies from which on masses are compared.
const FEWEST_OTHERS: usize = 3;
/// A repaired body has at least this fraction of the mean mass of the others: a factor of 1000 moves a body much farther.
const LIGHTEST_REPAIR: f64 = 1.0 / 30.0;

/// One reason to doubt a body.
#[derive(Clone, Debug)]
pub(crate) struct Doubt {
    pub mistake: Mistake,
    pub fact: &'static str,
    pub evidence: String,
}

/// Whether a repaired body is plausible. It is judged by stricter bounds than a body of the file, because a repair that only
/// just fits is no evidence.
pub(crate) fn is_sound(body: &Body) -> bool {
    let (others, count) = body.others;
    let is_light = count >= FEWEST_OTHERS && body.mass * (count as f64) < LIGHTEST_REPAIR * others;
    let radius = (principal_axes(&body.inertia()).0[2].max(0.0) / body.mass).sqrt();
    !is_light && radius >= metal_radius(body.mass) && doubts(body).is_empty()
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
        if mass > POINT_MASS_KG {
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
    if mass == 1.0 && inertia == [1.0, 0.0, 0.0, 1.0, 0.0, 1.0] {
        doubt(Mistake::Placeholder, "1 kg and 1 1 1 kg m^2 are a placeholder of an exporter", String::new());
        return found;
    }
    let radius = (most.max(0.0) / mass).sqrt();
    if radius < POSSIBLE_RADIUS_SHARE * metal {
        let fact = "no metal is so dense that the mass has so small an inertia";
        doubt(Mistake::Units, fact, format!("{mass} kg with a radius of gyration of {radius:.1e} m"));
    }
    if mass > LARGE_MASS_KG {
        doubt(Mistake::Units, "no link is so heavy", format!("{mass} kg"));
    }
    let distance = norm(body.pose.position);
    if distance > FAR_CENTRE_M {
        let fact = "the centre of mass is far from the joint";
        doubt(Mistake::Units, fact, format!("{distance:.1} m"));
    }
    size_doubts(body, radius, &mut doubt);
    mass_doubts(body, &mut doubt);
    found
}

/// Why no body has the moments.
fn impossible([least, middle, most]: [f64; 3]) -> String {
    let [a, b, c] = [least, middle, most].map(|x| shown(x, 5));
    let why = if least < 0.0 {
        "none may be negative".to_string()
    } else {
        format!("the sum of the smaller two misses the largest by {}", shown(most - least - middle, 3))
    };
    format!("about the centre of mass {a}, {b}, {c} kg m^2, {why}")
}

/// Compares the spread of the mass with the room of the shapes, or with the robot if there is none.
fn size_doubts(body: &Body, radius: f64, doubt: &mut impl FnMut(Mistake, &'static str, String)) {
    let variance = body.variance();
    let spread = |k: usize| variance[[0, 3, 5][k]].max(0.0).sqrt();
    let Some(extent) = &body.extent else {
        let rod = (12.0 * principal_axes(&variance).0[2].max(0.0)).sqrt();
        if radius > LARGE_RADIUS_M || (body.link.is_some() && body.reach > 0.0 && rod > LONGEST_ROD * body.reach) {
            let text = format!(
                "{} kg with a radius of gyration of {radius:.3} m, a rod of {rod:.2} m, where the longest chain of joints is {:.2} m",
                body.mass, body.reach
            );
            doubt(Mistake::Size, "the inertia is too large for the robot", text);
        }
        return;
    };
    let centre = body.pose.position;
    let outside = extent.distance(centre);
    if outside > CENTRE_MARGIN * extent.diagonal() {
        let text = format!("by {outside:.3} m, of shapes {:.3} m across", extent.diagonal());
        return doubt(Mistake::CentreOutside, "the centre of mass lies outside the collision shapes", text);
    }
    let widest = |k: usize| extent.largest_variance(centre, k).max(1e-4 * extent.diagonal().powi(2)).sqrt();
    let axis = |of: &dyn Fn(usize) -> f64| (0..3).max_by(|a, b| of(*a).total_cmp(&of(*b))).unwrap_or(0);
    let wide = axis(&|k| spread(k) / widest(k));
    if spread(wide) > WIDEST_SPREAD * widest(wide) {
        let text = format!(
            "{} kg spread by {:.3} m along {}, where the collision shapes allow {:.3} m",
            body.mass,
            spread(wide),
            ["x", "y", "z"][wide],
            widest(wide)
        );
        return doubt(Mistake::Size, "the inertia is too large for the shapes", text);
    }
    let uniform = extent.uniform().0;
    let even = |k: usize| uniform[[0, 3, 5][k]].sqrt();
    // The widest axis alone is compared: what is thin may be a shell or a flange.
    let long = axis(&even);
    if spread(long) < NARROWEST_SPREAD * even(long) {
        let text = format!(
            "{} kg spread by {:.3} m along {}, where constant density gives {:.3} m",
            body.mass,
            spread(long),
            ["x", "y", "z"][long],
            even(long)
        );
        doubt(Mistake::Size, "the inertia is too small for the shapes", text);
    }
}

/// Compares the mass with the volume of the shapes and with the other bodies.
fn mass_doubts(body: &Body, doubt: &mut impl FnMut(Mistake, &'static str, String)) {
    if let Some(volume) = body.extent.as_ref().and_then(|e| e.volume) {
        let density = body.mass / volume;
        let text = || format!("{} kg in {volume:.2e} m^3 are {density:.3e} kg/m^3", body.mass);
        if density < LINK_DENSITIES.0 {
            doubt(Mistake::Density, "the mass is too small for the volume of the shapes", text());
        } else if density > LINK_DENSITIES.1 {
            doubt(Mistake::Density, "the mass is too large for the volume of the shapes", text());
        }
    }
    let (others, count) = body.others;
    if body.link.is_some() && count >= FEWEST_OTHERS && body.mass > HEAVIEST_SHARE * others {
        let text = format!("{} kg, the {count} others {} kg", body.mass, shown(others, 3));
        doubt(Mistake::MassBesideOthers, "the mass is far above that of all other bodies together", text);
    }
}

/// A number rounded to `digits` significant digits.
pub(crate) fn shown(x: f64, digits: usize) -> f64 {
    format!("{x:.*e}", digits - 1).parse().unwrap_or(x)
}
