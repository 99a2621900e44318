//! Makes claims (statements with their evidence) on the velocity and acceleration columns of a log: whether they agree with the
//! derivatives of position and velocity.
//!
//! If a column contains another signal, rist differentiates the positions or velocities instead, and the claim states this
//! assumption. If a column agrees, the claim states the smallest error that would have been detected. A column that is absent or
//! not used has no claim.

use claims::{Claim, Figure, Outcome, Subject};

use crate::estimate::digits::significant;
use crate::estimate::log_check::{JointCheck, LIKELY_ACCELERATION_SIZES, LogCheck, TIMELY_S};
use crate::estimate::topics::{ACCELERATION, ORDER, VELOCITY, at, cannot_tell};

/// The smallest detectable lag of a velocity column is the accepted lag `TIMELY_S` plus this many standard deviations of the lag.
const SIGNIFICANT_LAG_SIGMAS: f64 = 5.0;

/// The claims on velocity columns, acceleration columns, and the order of the columns of a log.
pub(crate) fn claims_of_columns(log_check: &LogCheck) -> Vec<Claim> {
    velocity(log_check).into_iter().chain(acceleration(log_check)).chain(order(log_check)).collect()
}

/// Claims on the order of columns, if columns are assigned to joints by their place and not by their names. A wrong order is
/// a finding of the log check and not a claim here.
fn order(log_check: &LogCheck) -> Vec<Claim> {
    if !log_check.is_by_place || log_check.joints.len() < 2 {
        return Vec::new();
    }
    let named = |joints: &[usize]| joints.iter().map(|&k| log_check.joints[k].coordinate.as_str()).collect::<Vec<_>>();
    let pair = |[a, b]: &[Vec<usize>; 2]| format!("{} for {}", named(a).join(", "), named(b).join(", "));
    let hidden = &log_check.hidden_exchanges;
    let is_open = |k: usize| !log_check.has_description() || hidden.iter().flatten().any(|joints| joints.contains(&k));
    let (open, known): (Vec<usize>, Vec<usize>) = (0..log_check.joints.len()).partition(|&k| is_open(k));
    let subject = |joints: &[usize]| at(ORDER, joints.iter().map(|&k| &log_check.joints[k].coordinate));
    let agrees = Outcome::Agrees { smallest: Figure::new(2.0, "exchanged columns") };
    let mut claims = Vec::new();
    if !known.is_empty() {
        claims.push(Claim::new(subject(&known), agrees));
    }
    if !open.is_empty() {
        let why = match hidden.is_empty() {
            true => {
                "the columns are given by their place, and the description has no inertials to hold them against".into()
            }
            false => format!(
                "the columns are given by their place, and the description would not show an exchange of {}",
                hidden.iter().map(pair).collect::<Vec<_>>().join("; ")
            ),
        };
        claims.push(cannot_tell(subject(&open), why, "columns that carry the names of the joints"));
    }
    claims
}

fn assumed(subject: Subject, what: String) -> Claim {
    Claim::new(subject, Outcome::Assumed { what, by: "default".into() })
}

fn velocity(log_check: &LogCheck) -> Option<Claim> {
    let middle = log_check.velocity_lag().filter(|_| log_check.measured.velocity)?;
    let known: Vec<&JointCheck> = log_check.joints.iter().filter(|j| j.velocity_lag.is_some()).collect();
    let subject = at(VELOCITY, known.iter().map(|j| &j.coordinate));
    if middle.abs() > TIMELY_S {
        let what = format!(
            "the slopes of the positions are the velocities, because the columns lag them by {} ms",
            significant(1e3 * middle)
        );
        return Some(assumed(subject, what));
    }
    // The claim is about the median lag of the joints. The uncertainty of this median is taken as the median of the standard
    // deviations of the lags.
    let mut deviations: Vec<f64> = known.iter().map(|j| j.velocity_lag_deviation).collect();
    deviations.sort_by(f64::total_cmp);
    let deviation = deviations.get(deviations.len() / 2)?;
    let smallest = Figure::new((1e3 * (TIMELY_S + SIGNIFICANT_LAG_SIGMAS * deviation)).ceil(), "ms of lag");
    Some(Claim::new(subject, Outcome::Agrees { smallest }))
}

fn acceleration(log_check: &LogCheck) -> Vec<Claim> {
    if !log_check.measured.acceleration {
        return Vec::new();
    }
    let known = |is_wrong: bool| {
        let is_known = |j: &&JointCheck| j.acceleration.is_some() && j.wrong_acceleration == is_wrong;
        log_check.joints.iter().filter(is_known).collect::<Vec<&JointCheck>>()
    };
    let [right, wrong] = [known(false), known(true)];
    let mut claims = Vec::new();
    if let Some((correlation, size)) = wrong.first().and_then(|j| j.acceleration) {
        // If the acceleration column of one joint is wrong, no acceleration column is used.
        let what = format!(
            "the slopes of the velocities are the accelerations, because the column of {} has a correlation of {correlation:.2} \
             with that slope and {} times its size",
            wrong[0].coordinate,
            significant(size)
        );
        claims.push(assumed(at(ACCELERATION, wrong.iter().map(|j| &j.coordinate)), what));
    } else if !right.is_empty() {
        let smallest = Figure::new(LIKELY_ACCELERATION_SIZES.end, "times the slope");
        claims.push(Claim::new(at(ACCELERATION, right.iter().map(|j| &j.coordinate)), Outcome::Agrees { smallest }));
    }
    claims
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::log_check::Measured;

    fn joint(name: &str, lag: Option<f64>, acceleration: Option<(f64, f64)>, is_wrong: bool) -> JointCheck {
        JointCheck {
            coordinate: name.into(),
            velocity_lag: lag,
            velocity_lag_deviation: 1e-4,
            acceleration,
            wrong_acceleration: is_wrong,
            ..JointCheck::default()
        }
    }

    fn said(joints: &[JointCheck], velocity: bool, acceleration: bool) -> Vec<String> {
        let measured = Measured { velocity, acceleration };
        let log_check = LogCheck { joints: joints.to_vec(), measured, ..LogCheck::default() };
        claims_of_columns(&log_check).iter().map(Claim::to_string).collect()
    }

    #[test]
    fn columns_are_told_with_their_evidence() {
        let good = [joint("q1", Some(2e-4), Some((0.99, 1.0)), false), joint("q2", None, Some((0.9, 1.1)), false)];
        assert_eq!(
            said(&good, true, true),
            [
                "velocity column of q1: agrees; a fault of 2 ms of lag would have shown",
                "acceleration column of q1, q2: agrees; a fault of 2 times the slope would have shown"
            ]
        );
        let bad = [joint("q1", Some(0.016), Some((0.1, 9.0)), true), joint("q2", Some(0.015), Some((0.9, 1.1)), false)];
        let found = said(&bad, true, true);
        assert!(found[0].contains("q1, q2: assumed by default"), "{found:?}");
        assert!(found[0].contains("lag them by 16.0 ms"), "{found:?}");
        assert!(found[1].starts_with("acceleration column of q1: assumed"), "{found:?}");
        assert!(found[1].contains("correlation of 0.10 with that slope and 9"), "{found:?}");
    }

    #[test]
    fn nothing_is_said_of_what_was_not_looked_at() {
        let joints = [joint("q1", Some(0.016), Some((0.1, 9.0)), true)];
        assert!(said(&joints, false, false).is_empty());
        assert!(said(&[joint("q1", None, None, false)], true, true).is_empty());
        assert_eq!(said(&joints, true, false).len(), 1);
    }
}
