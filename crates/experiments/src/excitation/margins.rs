//! What a proof has in hand as numbers, and what it has nothing in hand for.
//!
//! Where stopping begins at an instant, with the limits of acceleration, a joint of the velocity v stands after v/a s and
//! v^2/(2 a) rad (m). Taken is the velocity that is proven for the whole motion, so that this holds at each instant.

use claims::significant;
use serde::Serialize;

use crate::excitation::limits::{CoordinateLimits, LimitKind};
use crate::excitation::proof::CertificateRow;

/// How far a joint goes on after stopping begins, at most.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stopping {
    /// Its coordinate.
    pub coordinate: String,
    /// s.
    pub time_s: f64,
    /// rad (m).
    pub way: f64,
}

/// The margins of a certificate.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Margins {
    /// How much larger than the hull of its mesh a body may be, m, with its link; none: no mesh.
    pub mesh: Option<(f64, String)>,
    /// The coordinate that goes on longest, and the one that goes on farthest; none where no acceleration is limited.
    pub stopping: Vec<Stopping>,
}

/// What no proof of a motion has a margin for.
const NOTHING_FOR: &str = "encoder zeros, calibration, tracking errors, a payload that the description does not have";

impl Margins {
    /// From a certificate, its limits, and the greatest error of a mesh.
    pub fn new(
        rows: &[CertificateRow],
        limits: &[CoordinateLimits],
        names: &[String],
        mesh: Option<(f64, String)>,
    ) -> Margins {
        let one = |(name, limits): (&String, &CoordinateLimits)| {
            let row = rows.iter().find(|row| row.limit == LimitKind::Velocity && row.subject == *name)?;
            // The row has the end that is nearest to its limit.
            let (v, a) = (row.nowhere_beyond.abs(), limits.acceleration);
            a.is_finite().then(|| Stopping { coordinate: name.clone(), time_s: v / a, way: 0.5 * v * v / a })
        };
        let all: Vec<Stopping> = names.iter().zip(limits).filter_map(one).collect();
        let longest = all.iter().max_by(|a, b| a.time_s.total_cmp(&b.time_s));
        let farthest = all.iter().max_by(|a, b| a.way.total_cmp(&b.way)).filter(|far| Some(*far) != longest);
        Margins { mesh, stopping: longest.into_iter().chain(farthest).cloned().collect() }
    }

    /// In lines.
    pub fn text(&self) -> String {
        let mut text = String::new();
        if let Some((error, link)) = &self.mesh {
            text += &format!(
                "bodies of meshes: their hulls, made larger by at most {} mm ({link})\n",
                significant(1e3 * error, 2)
            );
        }
        for Stopping { coordinate, time_s, way } in &self.stopping {
            text += &format!(
                "stopping, at any instant, at the limit of acceleration: {coordinate} stands after {} s and {} rad (m)\n",
                significant(*time_s, 2),
                significant(*way, 2)
            );
        }
        text + &format!("no margin for: {NOTHING_FOR}\na proof of planning, and no safety function\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::proof::Kept;

    /// 2 rad/s at 4 rad/s^2 are half a second and half a rad; the other joint is quicker to stand.
    #[test]
    fn a_joint_stands_after_its_way() {
        let row = |subject: &str, v: f64| CertificateRow {
            limit: LimitKind::Velocity,
            subject: subject.into(),
            time_s: 1.0,
            value: v,
            bound: 3.0,
            nowhere_beyond: -v,
            kept: Kept::Proven,
            how: "Taylor enclosures".into(),
        };
        let limit = |acceleration: f64| CoordinateLimits {
            position: (-1.0, 1.0),
            velocity: 3.0,
            acceleration,
            jerk: 1e3,
            effort: None,
            power: None,
            locked: None,
        };
        let (rows, names) = ([row("q1", 2.0), row("q2", 1.0)], ["q1".to_string(), "q2".to_string()]);
        let of = |a: [f64; 2], mesh| Margins::new(&rows, &a.map(limit), &names, mesh);
        let found = of([4.0, 10.0], Some((0.0012, "hand".into())));
        assert_eq!(found.stopping, [Stopping { coordinate: "q1".into(), time_s: 0.5, way: 0.5 }]);
        let text = found.text();
        for said in ["larger by at most 1.2 mm (hand)", "q1 stands after 0.5 s and 0.5 rad (m)", "no safety function"] {
            assert!(text.contains(said), "{said}: {text}");
        }
        // The one longer, the other farther.
        let two = of([4.0, 1.9], None).stopping;
        assert_eq!(two.iter().map(|s| s.coordinate.as_str()).collect::<Vec<_>>(), ["q2", "q1"]);
        let none = of([f64::INFINITY; 2], None);
        assert!(none.stopping.is_empty() && !none.text().contains("stopping") && !none.text().contains("meshes"));
    }
}
