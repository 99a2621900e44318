//! Compares the densities of the bodies of one robot. If the decimal point of a mass is misplaced, the density of this body
//! differs much from the densities of the other bodies.
//!
//! x_i = ln(m_i/V_i), m_i: mass; V_i: volume of the shapes, with the bounding boxes of meshes. The centre of the x_i is their
//! median. Their spread is sigma = 1.4826 median |x_i - median|, which equals the standard deviation for normal x_i
//! [Rousseeuw, Croux 1993].

use crate::body::Body;
use crate::body_doubt::{NEGLIGIBLE_SHARE, shown, spread};
use crate::extent::Extent;
use crate::finding::{Finding, Mistake};
use crate::vector::minus;

/// Densities are compared if at least this number of bodies have shapes.
const FEWEST_BODIES: usize = 5;
/// The standard deviation of normal values, as a multiple of their median absolute deviation.
const NORMAL_SPREAD: f64 = 1.4826;
/// A density is an outlier if it deviates from the centre by at least this number of spreads and by at least `OUTLIER_FACTOR`.
/// The limits are wide, because an empty cover among motors is usual, and the boxes of meshes are larger than the bodies.
const OUTLIER_SPREADS: f64 = 5.0;
const OUTLIER_FACTOR: f64 = 15.0;

/// Adds a finding for each body whose density is far from the median. Bodies that already have a finding are left out.
pub(crate) fn relative_density(bodies: &[Body], findings: &mut Vec<Finding>) {
    let is_known = |body: &Body| findings.iter().any(|f| f.subjects.contains(&body.name));
    let counts = |body: &&Body| body.mass > NEGLIGIBLE_SHARE * (body.mass + body.others.0) && !is_known(body);
    // Shapes may be a few points of contact, or may overlap. So the volume of a body is between the sum of the shapes' volumes
    // and the volume of their bounding box.
    let known: Vec<(&Body, [f64; 2])> = bodies
        .iter()
        .filter(counts)
        .filter_map(|body| {
            // If the visual shapes are too small for the inertia, they do not show the whole body and are not used.
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

    /// The findings on densities for a chain of boxes with these masses; `tag`: collision or visual.
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
        // If the bodies differ much from each other, or if there are few bodies, no density is an outlier.
        assert_eq!(found("collision", &[0.5, 1.5, 4.0, 1.2, 16.0, 0.3]), [""; 0]);
        assert_eq!(found("collision", &[2.0, 1.5, 1.8, 20.0]), [""; 0]);
    }
}
