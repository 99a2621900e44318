//! Writes advice for playing a motion: warm-up, repetition, when to stop.
//!
//! All numbers come from the proofs of the played motions. No warm-up time is given, since no time suits every robot.

use claims::significant;
use experiments::excitation::limits::LimitKind;
use experiments::excitation::margins::Margins;
use experiments::excitation::motion::Motion;
use experiments::excitation::proof::CertificateRow;
use experiments::motion::reference_motion::Reference;

use crate::motion::checking::Checked;

/// Two set points count as equal if they differ by less than this value, rad (m): the last digit of an encoder of 22 bits.
const LARGEST_SET_POINT_STEP_RAD_M: f64 = 1e-6;

/// Advice for the user, as sentences. `played`: the set points of all played segments; `parts`: the proofs of these segments,
/// among them `motion`; `names`: the coordinates.
pub(crate) fn advice(
    motion: &Motion,
    played: &Reference,
    parts: &[(&'static str, Checked)],
    names: &[String],
) -> Vec<String> {
    // The motion can be repeated at once only if the last set point equals the first.
    let jumps = jumps(played, names);
    let again = if jumps.is_empty() {
        "it begins and ends at rest at one pose, so that it can be played again at once".to_string()
    } else {
        format!(
            "NEVER play it again at once: from its last set point to its first the joints would jump, rad (m): {}; the straight way \
             back is not proven, so plan one ([from] plays the ways from and to another pose)",
            jumps.join(", ")
        )
    };
    let mut advice_lines = vec![
        "warm-up: friction falls while joints get warm: play it until the torques of two plays one after the other agree, and \
         record then"
            .to_string(),
        format!(
            "repetition: {again}; a play has {} periods of {} s, and each further play adds as much information to a log",
            motion.repetitions,
            significant(motion.shape.period(), 4)
        ),
    ];
    // When to stop: limits for tracking error and torque, and the stopping distance.
    let margins = parts.iter().find(|(part, _)| *part == "motion").map(|(_, checked)| &checked.margins);
    advice_lines.extend(margins.map(|margins| stop_where_it_strays(margins, names)));
    advice_lines.extend(stop_where_it_strains(parts, names));
    advice_lines.extend(margins.and_then(stopping));
    advice_lines
}

/// The joints that would jump if the motion were repeated at once, each with the jump, rad (m).
pub(crate) fn jumps(played: &Reference, names: &[String]) -> Vec<String> {
    let ends = played.q.iter().zip(names).filter_map(|(q, name)| Some((name, q.first()? - q.last()?)));
    let far = ends.filter(|(_, jump)| jump.abs() > LARGEST_SET_POINT_STEP_RAD_M);
    far.map(|(name, jump)| format!("{name} {}", significant(jump, 3))).collect()
}

/// Advice on the largest tracking error. The proof holds only if the tracking error stays within its margin.
fn stop_where_it_strays(margins: &Margins, names: &[String]) -> String {
    let given = |name: &String| margins.errors.tracking_of(name).map(|x| format!("{name} {x}"));
    let given: Option<Vec<String>> = names.iter().map(given).collect();
    match given {
        Some(all) => format!(
            "stop where a joint is farther from its set point than the proof has room for, rad (m): {}",
            all.join(", ")
        ),
        None => {
            "stop where a joint strays from its set point: the proof assumes that it does not (margins: tracking: in \
                 [limits=FILE] gives it room)"
                .into()
        }
    }
}

/// Advice on the largest torque: the proven bound of each joint over all segments, N m (N). `None` if no torque is proven.
fn stop_where_it_strains(parts: &[(&'static str, Checked)], names: &[String]) -> Option<String> {
    let rows = || parts.iter().flat_map(|(_, checked)| &checked.certificate);
    let most = |name: &String| -> Option<String> {
        let own = |row: &&CertificateRow| row.limit == LimitKind::Effort && row.subject == *name;
        // The certificate contains torques without dry friction.
        let torque = rows().filter(own).map(|row| row.nowhere_beyond.abs()).reduce(f64::max)?;
        Some(format!("{name} {}", significant(torque, 3)))
    };
    let all: Vec<String> = names.iter().filter_map(most).collect();
    (!all.is_empty()).then(|| {
        format!(
            "stop where a torque is far above what is proven of it without dry friction, N m (N): {}: something is in the way, or the \
             description is of another robot",
            all.join(", ")
        )
    })
}

fn stopping(margins: &Margins) -> Option<String> {
    let joint = margins.stopping.joints.first()?;
    Some(format!(
        "a stop at the limits of acceleration takes {} up to {} rad (m) farther, in {} s",
        joint.coordinate,
        significant(joint.path, 2),
        significant(joint.time_s, 2)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use experiments::excitation::motion::MotionShape;
    use experiments::excitation::quintic_spline::QuinticSpline;

    #[test]
    fn only_what_ends_where_it_begins_is_played_again_at_once() {
        let shape = MotionShape::Spline(QuinticSpline { period: 4.0, spans: 9 });
        let motion = Motion { rate: 100.0, repetitions: 2, shape, joints: vec![] };
        let names = ["q1".to_string(), "q2".to_string()];
        let advice_lines = |last: f64| {
            let played = Reference { q: vec![vec![0.3, 1.0, 0.3], vec![0.1, 0.5, last]], ..Reference::default() };
            advice(&motion, &played, &[], &names).join("\n")
        };
        for (last, says, never) in [
            (0.1, "can be played again at once", "NEVER"),
            (0.1 + 1e-9, "can be played again at once", "jump"),
            (
                0.74,
                "NEVER play it again at once: from its last set point to its first the joints would jump, rad (m): q2 -0.64;",
                "one pose",
            ),
        ] {
            let advice_lines = advice_lines(last);
            assert!(advice_lines.contains(says) && !advice_lines.contains(never), "{last}: {advice_lines}");
        }
    }
}
