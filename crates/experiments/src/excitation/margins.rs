//! The error margins that a proof covers, the margins that it assumes to be zero, and the distance and time of stopping.

use claims::significant;
use serde::{Deserialize, Serialize};

use crate::excitation::error_margins::{ErrorMargins, narrowed};
use crate::excitation::fitting::Obligations;
use crate::excitation::limits::{AskedLimits, CoordinateLimits};
use crate::excitation::proof::CertificateRow;
use crate::excitation::stopping::{StoppingMotions, stops};
use crate::excitation::trajectory::Trajectory;
use claims::{LeftOut, LeftOutTopic};

/// The limits with position ranges narrowed by the greatest position error of each joint, according to `margins`.
///
/// Fails if no position range of a joint remains, or if a joint is locked outside its narrowed range.
pub fn with_margins(
    margins: &ErrorMargins,
    names: &[String],
    limits: &[CoordinateLimits],
) -> Result<Vec<CoordinateLimits>, String> {
    let one = |((limits, name), by): ((&CoordinateLimits, &String), f64)| {
        let refused = |what: String| format!("coordinate {name}: {what}");
        let position = narrowed(limits.position, by).map_err(refused)?;
        let found = CoordinateLimits { position, ..limits.clone() };
        let locked = found.locked.filter(|q| !(position.0..=position.1).contains(q));
        locked
            .map_or(Ok(found), |q| Err(refused(format!("locked at {q}, within the margins of its limits of position"))))
    };
    limits.iter().zip(names).zip(margins.of_joints(names)).map(one).collect()
}

/// Narrows the requested position limits of a joint at both ends by `by`, its greatest position error, rad (m). The other limits
/// are unchanged.
///
/// Fails if no position range remains.
pub fn asked_with_margins(asked: AskedLimits, by: f64) -> Result<AskedLimits, String> {
    let position = asked.position.map(|position| narrowed(position, by)).transpose()?;
    Ok(AskedLimits { position, ..asked })
}

/// Statement for users of what a certificate means.
pub const STATEMENT: &str = "a proof of planning, and no safety function";

/// The margins that a certificate covers or assumes to be zero.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Margins {
    /// The error margins that the certificate covers. A margin that is not given is assumed to be zero.
    pub errors: ErrorMargins,
    /// Greatest distance (m) by which the body of a mesh in the proof exceeds the convex hull of the mesh, with the name of its
    /// link. The certificate uses this larger body. `None`: no body is a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<(f64, String)>,
    /// The greatest distance and time that the robot needs to stop, from any instant of the motion.
    pub stopping: StoppingMotions,
    /// Statement for users of what the certificate means.
    pub statement: String,
}

impl Margins {
    /// Computes the margins of a certificate (`rows`) along a trajectory. `mesh`: the greatest distance (m) by which the body
    /// of a mesh exceeds the convex hull of the mesh, with the name of its link.
    pub fn new(
        positions: &dyn Trajectory,
        rows: &[CertificateRow],
        obligations: &Obligations,
        errors: &ErrorMargins,
        mesh: Option<(f64, String)>,
    ) -> Margins {
        let Obligations { limits, names, surroundings, .. } = obligations;
        let stopping = stops(positions, rows, limits, names, *surroundings);
        Margins { errors: errors.clone(), mesh, stopping, statement: STATEMENT.into() }
    }

    /// The margins as text for users.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for (name, given) in self.errors.words() {
            text += &match given {
                Some(given) => format!("{name}: {given}, the proof has room for it\n"),
                None => format!("{name}: assumed 0\n"),
            };
        }
        if let Some((error, link)) = &self.mesh {
            text += &format!(
                "bodies of meshes: their hulls, made larger by at most {} mm ({link})\n",
                significant(1e3 * error, 2)
            );
        }
        text + &self.stopping.text() + STATEMENT + "\n"
    }
}

/// Reports the margins that are not given, and are therefore assumed to be zero, as an omitted check. `None` if all are given.
pub fn left_out(errors: &ErrorMargins) -> Option<LeftOut> {
    let missing: Vec<&str> = errors.words().into_iter().filter(|(_, x)| x.is_none()).map(|(key, _)| key).collect();
    let what = format!("{} 0 (margins of a limits file give them)", is_listed(&missing));
    (!missing.is_empty()).then(|| LeftOut::assumed(LeftOutTopic::Margin, vec![], what, "default"))
}

/// A list of names with its verb: `a is`, `a and b are`, `a, b and c are`.
fn is_listed(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [one] => format!("{one} is"),
        [first @ .., last] => format!("{} and {last} are", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::gap_proof::tests::Rod;
    use crate::excitation::motion::tests::motions;
    use crate::excitation::search::tests::limits;
    use linear_model::yaml;

    fn read(text: &str) -> ErrorMargins {
        yaml::read(text).unwrap()
    }

    #[test]
    fn what_is_not_given_is_said() {
        let said = |text: &str| {
            let found = left_out(&read(text));
            found.map(|out| match out.why {
                claims::LeftOutReason::Assumed { what, by } => format!("{by}: {what}"),
                other => panic!("{other:?}"),
            })
        };
        let all = said("{}").unwrap();
        assert!(all.starts_with("default: encoder zero, tracking, calibration, mesh and payload are 0"), "{all}");
        let payload = "payload: {link: hand, mass: 1, centre_of_mass: [0, 0, 0]}";
        let one = said(&format!("{{encoder_zero: 0, tracking: 0, calibration: 0, {payload}}}")).unwrap();
        assert!(one.starts_with("default: mesh is 0"), "{one}");
        assert_eq!(said(&format!("{{encoder_zero: 0, tracking: 0, calibration: 0, mesh: 0, {payload}}}")), None);
    }

    fn limit(acceleration: f64, position: f64) -> CoordinateLimits {
        limits((-position, position), [100.0, acceleration, 1e9])
    }

    #[test]
    fn stopping_is_that_of_samples() {
        let names = ["q1".to_string(), "q2".to_string()];
        let a = [4.0, 9.0];
        for motion in motions() {
            let limits = [limit(a[0], 20.0), limit(a[1], 30.0)];
            let (mut way, mut reach, mut height) = ([0.0_f64; 2], [0.0_f64; 2], f64::NEG_INFINITY);
            for i in 0..=100_000 {
                let at = motion.at(motion.duration() * f64::from(i) / 100_000.0);
                for k in 0..2 {
                    let own = 0.5 * at[k][1] * at[k][1].abs() / a[k];
                    way[k] = way[k].max(own.abs());
                    reach[k] = reach[k].max((at[k][0] + own).abs());
                    if k == 0 {
                        height = height.max(at[0][0].sin()).max((at[0][0] + own).sin());
                    }
                }
            }
            let rod = Rod::new(height + 30.0);
            let obligations = Obligations { limits: &limits, names: &names, torque: None, surroundings: Some(&rod) };
            let rows = obligations.certificate(&motion);
            let found = Margins::new(&motion, &rows, &obligations, &ErrorMargins::default(), None);
            let far = if way[0] > way[1] { 0 } else { 1 };
            let first = &found.stopping.joints[0];
            let (v, at) = (first.velocity, motion.at(first.at_s)[far][1]);
            assert!((v.abs() - at.abs()).abs() < 1e-3 * v.abs(), "{first:?} {at}");
            assert!(first.coordinate == names[far] && first.path >= way[far] && first.path < way[far] * 1.001 + 1e-9);
            let rooms = [20.0 - reach[0], 30.0 - reach[1]];
            let room = found.stopping.positions.as_ref().unwrap();
            let expected = rooms[0].min(rooms[1]);
            assert!(room.room <= expected + 1e-9 && room.room > expected - 0.1, "{room:?} {rooms:?}");
            // The position limits and the wall are far beyond the stop positions, so stopping is covered.
            let bodies = found.stopping.bodies.as_ref().unwrap();
            assert!((bodies.covered, bodies.distances) == (1, 1) && bodies.least.room <= 30.0, "{bodies:?}");
            let text = found.text();
            let whole =
                ["encoder zero: assumed 0\n", "cover stopping at any instant", "covers stopping at any", STATEMENT];
            assert!(whole.iter().all(|said| text.contains(said)), "{text}");
            // The position limit of q1 is 0.01 rad before its farthest stop position, and the wall is 1 mm below the highest stop
            // position of the rod. So neither covers stopping.
            let near = [limit(a[0], reach[0] - 1e-2), limit(a[1], 30.0)];
            let near_rod = Rod::new(height - 1e-3);
            let obligations = Obligations { limits: &near, names: &names, torque: None, surroundings: Some(&near_rod) };
            let text = Margins::new(&motion, &rows, &obligations, &ErrorMargins::default(), None).text();
            assert!(text.contains("do not cover stopping: q1 goes up to 0.01"), "{text}");
            assert!(text.contains("for 0 of 1 distances, not for region of rod at the wall"), "{text}");
        }
    }

    #[test]
    fn nothing_is_said_of_stopping_without_a_limit() {
        let names = ["q1".to_string(), "q2".to_string()];
        let limits = [limit(f64::INFINITY, 1.0), limit(f64::INFINITY, 1.0)];
        let motion = &motions()[0];
        let obligations = Obligations { limits: &limits, names: &names, torque: None, surroundings: None };
        let found = Margins::new(motion, &[], &obligations, &read("mesh: 0.002"), Some((0.0012, "hand".into())));
        let text = found.text();
        assert!(found.stopping == StoppingMotions::default() && !text.contains("stopping"), "{text}");
        assert!(text.contains("larger by at most 1.2 mm (hand)") && text.contains("mesh: 0.002 m, the proof has room"));
        assert!(text.ends_with("no safety function\n"), "{text}");
    }
}
