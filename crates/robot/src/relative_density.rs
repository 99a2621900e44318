//! Compares the densities of the bodies of one robot: a mass with a slip of the decimal point stands out where the densities of
//! the others are known.
//!
//! x_i = ln(m_i/V_i); the centre of the x_i is their median, and their spread sigma = 1.4826 median |x_i - median|, which equals
//! the standard deviation for normal x_i [Rousseeuw, Croux 1993]. V: volume of the shapes, with the boxes of meshes.

use crate::body::Body;
use crate::body_doubt::{NEGLIGIBLE_SHARE, shown, spread};
use crate::extent::Extent;
use crate::finding::{Finding, Mistake};
use crate::vector::minus;

/// Number of bodies with shapes from which on densities are compared.
const FEWEST_BODIES: usize = 5;
/// The standard deviation of normal values, as a multiple of their median absolute deviation.
const NORMAL_SPREAD: f64 = 1.4826;
/// A density is an outlier from this number of spreads on, and from this factor on: an empty cover among motors is usual, and boxes
/// of meshes are larger than the bodies.
const OUTLIER_SPREADS: f64 = 5.0;
const OUTLIER_FACTOR: f64 = 15.0;

/// Adds the bodies whose density is far from the median. Bodies that have a finding are left out.
pub(crate) fn relative_density(bodies: &[Body], findings: &mut Vec<Finding>) {
    let is_known = |body: &Body| findings.iter().any(|f| f.subjects.contains(&body.name));
    let counts = |body: &&Body| body.mass > NEGLIGIBLE_SHARE * (body.mass + body.others.0) && !is_known(body);
    // Shapes may be a few points of contact or overlap: the room of a body is between their volumes and their box.
    let known: Vec<(&Body, [f64; 2])> = bodies
        .iter()
        .filter(counts)
        .filter_map(|body| {
            // A drawn part that is too small for the inertia does not show the whole body.
            let is_whole = |drawn: &&Extent| spread(&body.variance()) <= 0.5 * drawn.diagonal();
            let extent = body.extent.as_ref().or(body.drawn.as_ref().filter(is_whole))?;
            let box_volume: f64 = minus(extent.high, extent.low).iter().product();
            Some((
                body,
                [extent.outer_volume, box_volume.max(extent.outer_volume)].map(|volume| (body.mass / volume).ln()),
            ))
        })
        .collect();
    if known.len() < FEWEST_BODIES {
        return;
    }
    let centre = median(known.iter().map(|(_, x)| x[0]).collect());
    let spread = NORMAL_SPREAD * median(known.iter().map(|(_, x)| (x[0] - centre).abs()).collect());
    let bound = OUTLIER_FACTOR.ln().max(OUTLIER_SPREADS * spread);
    for (body, [of_shapes, of_box]) in known.iter() {
        let fact = if of_box - centre > bound {
            "the density is far above that of the other bodies"
        } else if centre - of_shapes > bound {
            "the density is far below that of the other bodies"
        } else {
            continue;
        };
        let off = if of_box - centre > bound { of_box } else { of_shapes };
        let text = format!(
            "{} kg are {:?} kg/m^3, {:?} times the median of {} bodies",
            shown(body.mass, 4),
            shown(off.exp(), 3),
            shown((off - centre).exp(), 2),
            known.len()
        );
        findings.push(Finding::new(&body.name, Mistake::Density, fact, text));
    }
}

fn median(mut x: Vec<f64>) -> f64 {
    x.sort_by(f64::total_cmp);
    0.5 * (x[(x.len() - 1) / 2] + x[x.len() / 2])
}

#[cfg(test)]
mod tests {
    use crate::format::read_urdf;
    use crate::lint::{Mistake, lint};

    /// The densities that are named in a chain of boxes with these masses; `tag`: collision or visual.
    fn found(tag: &str, masses: &[f64]) -> Vec<String> {
        let mut text = "<robot name=\"r\"><link name=\"b\"/>".to_string();
        for (k, mass) in masses.iter().enumerate() {
            let i = mass * 0.004;
            let before = if k == 0 { "b".into() } else { format!("l{}", k - 1) };
            text += &format!(
                "<link name=\"l{k}\"><inertial><mass value=\"{mass}\"/><inertia ixx=\"{i}\" ixy=\"0\" ixz=\"0\" iyy=\"{i}\" \
                 iyz=\"0\" izz=\"{i}\"/></inertial><{tag}><geometry><box size=\"0.2 0.1 0.1\"/></geometry></{tag}></link>\
                 <joint name=\"j{k}\" type=\"continuous\"><parent link=\"{before}\"/><child link=\"l{k}\"/>\
                 <origin xyz=\"0.3 0 0\"/><axis xyz=\"0 1 0\"/></joint>"
            );
        }
        let found = lint(&read_urdf(&(text + "</robot>"), "r.urdf").unwrap());
        found.iter().filter(|f| f.mistake == Mistake::Density).map(ToString::to_string).collect()
    }

    #[test]
    fn an_outlier_is_named_with_its_ratio() {
        for tag in ["collision", "visual"] {
            assert_eq!(found(tag, &[2.0, 1.5, 1.8, 1.2, 2.6, 3.5]), [""; 0], "{tag}");
            // 20 kg in 0.002 m^3; the median of 0.5, 0.6, 0.7, 0.8, 1 and 20 is 0.75 by the mean of the logarithms.
            let text = "l4: the density is far above that of the other bodies: 20 kg are 10000.0 kg/m^3, 27.0 times the median of 6 \
                        bodies";
            assert_eq!(found(tag, &[0.8, 0.6, 0.7, 0.5, 20.0, 1.0]), [text], "{tag}");
            let low = found(tag, &[2.0, 1.5, 1.8, 1.2, 0.1, 2.6]);
            assert!(low.len() == 1 && low[0].contains("l4: the density is far below"), "{tag}: {low:?}");
        }
        // Bodies that differ much among themselves, or few bodies, tell nothing.
        assert_eq!(found("collision", &[0.5, 1.5, 4.0, 1.2, 16.0, 0.3]), [""; 0]);
        assert_eq!(found("collision", &[2.0, 1.5, 1.8, 20.0]), [""; 0]);
    }
}
