//! Whether undoing the faults that were found mends a log: they are undone, and the log is looked at again.
//!
//! Undoing one fault may uncover another, which is then undone with it. The faults are named where nothing is contradicted any
//! more. Where something still is, something is wrong, and its cause is not known.

use crate::estimate::digits::percent;
use crate::estimate::passport::change::Change;
use crate::estimate::passport::finding::{Fault, Finding};
use crate::estimate::passport::report::{JointPassport, Passport};
use crate::estimate::passport::search::MAX_MISTAKES;

/// Times that a log is looked at again: the faults that were found, and twice those that they uncover.
const LOOKS: usize = 3;

/// A joint is wrong where the description leaves more than this of its torque, in squares, with the slope of a right joint.
const WRONG_JOINT_MISFIT: f64 = 0.5;

/// Share of the torques that the description leaves, in squares, from which on the robot is another.
pub(super) const FOREIGN_ROBOT_MISFIT: f64 = 0.6;
/// What to do about a log of another robot.
pub(super) const OTHER_ROBOT: &str = "no single sign, zero, unit or exchange of columns mends it: look for another model, another \
                                      tool or mounting (gravity), or several mistakes at once";

/// Slopes of joints that are described: bodies may be wrong by a factor of two.
const SLOPES: (f64, f64) = (0.5, 2.0);

/// An explanation leaves as little as another where it leaves at most so many times as much, in squares.
pub const AS_WELL_RATIO: f64 = 1.5;

/// The passport of a log whose findings were tried. `again` looks at the log with changes done.
///
/// Of the explanations that mend the log, those of the fewest faults count, and of these the one that leaves least; what leaves
/// as little is named beside it.
pub(super) fn tried(mut first: Passport, again: impl Fn(&[Change]) -> Passport) -> Passport {
    if !first.is_gross() {
        return first;
    }
    let explanations = std::iter::once(first.findings.clone()).chain(std::mem::take(&mut first.others));
    let mut mended: Vec<Vec<Finding>> = Vec::new();
    for findings in explanations {
        let fewest = mended.first().map_or(MAX_MISTAKES, |found| found.iter().map(mistakes).sum());
        if let Some(found) = mends(&first, findings, fewest, &again) {
            mended.retain(|other| other.len() <= found.len());
            mended.push(found);
        }
    }
    let left = |found: &Vec<Finding>| found.iter().find_map(|f| f.tried).map_or(f64::INFINITY, |shares| shares[1]);
    mended.sort_by(|a, b| left(a).total_cmp(&left(b)));
    let least = mended.first().map_or(f64::INFINITY, &left);
    mended.retain(|found| left(found) <= AS_WELL_RATIO * least);
    if mended.is_empty() {
        first.leave_unidentified();
        return first;
    }
    let others: Vec<Finding> = first.findings.drain(..).filter(|f| !f.fault.is_gross()).collect();
    for found in mended {
        let is_known =
            |f: &Finding| first.findings.iter().any(|known| known.fault == f.fault && known.joints == f.joints);
        if !found.iter().all(is_known) {
            let instead = first.findings.last().map_or(0, |last| last.instead + 1);
            first.findings.extend(found.into_iter().map(|f| Finding { instead, ..f }));
        }
    }
    first.findings.extend(others);
    first
}

/// As how many mistakes a finding counts: gains of each joint explain much of anything.
fn mistakes(finding: &Finding) -> usize {
    if finding.fault == Fault::NoTorque { MAX_MISTAKES } else { 1 }
}

/// The gross findings of an explanation, with those that undoing them uncovers, where at most so many mend the log.
fn mends(
    first: &Passport,
    findings: Vec<Finding>,
    most: usize,
    again: &impl Fn(&[Change]) -> Passport,
) -> Option<Vec<Finding>> {
    let (mut found, mut new) = (Vec::<Finding>::new(), findings);
    for _ in 0..LOOKS {
        new.retain(|f| f.fault.is_gross());
        // What needs another log is said as it is.
        let count = found.iter().chain(&new).map(mistakes).sum::<usize>();
        if new.iter().any(|f| f.undo.is_empty()) || count > most {
            return None;
        }
        found.append(&mut new);
        let undo: Vec<Change> = found.iter().flat_map(|f| f.undo.iter().copied()).collect();
        let passport = again(&undo);
        if !passport.is_gross() {
            let shares = [first.unexplained(), passport.unexplained()];
            found.iter_mut().for_each(|f| f.tried = Some(shares));
            return Some(found);
        }
        new = passport.findings;
    }
    None
}

impl Passport {
    /// The share of the torques, joints alike and in squares, that the description does not explain with a slope that errors of
    /// its bodies allow.
    pub fn unexplained(&self) -> f64 {
        let all: Vec<f64> = self.joints.iter().filter_map(JointPassport::misfit).collect();
        all.iter().sum::<f64>() / all.len().max(1) as f64
    }

    /// Puts an explanation before the findings that mend the log as well; what forbids no estimate is in both.
    pub fn put_before(&mut self, explanation: Vec<Finding>) {
        let others = self.findings.drain(..).filter(|f| f.fault.is_gross());
        let others = others.map(|f| Finding { instead: f.instead + 1, ..f }).collect::<Vec<_>>();
        self.findings = explanation.into_iter().chain(others).collect();
    }

    /// Withdraws causes that were undone in vain: what they leave is said with them.
    fn leave_unidentified(&mut self) {
        let (vain, others): (Vec<Finding>, Vec<Finding>) =
            self.findings.drain(..).partition(|f| f.fault.is_gross() && !f.undo.is_empty());
        self.findings = others;
        if vain.is_empty() {
            return;
        }
        let is_wrong = |j: &&JointPassport| j.misfit().is_some_and(|misfit| misfit > WRONG_JOINT_MISFIT);
        let mut joints: Vec<String> = self.joints.iter().filter(is_wrong).map(|j| j.coordinate.clone()).collect();
        if joints.is_empty() {
            joints = vain.iter().flat_map(|f| f.joints.iter().cloned()).collect();
        }
        let candidates: Vec<String> = vain.iter().map(Finding::statement).collect();
        let evidence = format!(
            "the description leaves {} of the torques (joints alike); tried, and not enough: {}",
            percent(self.unexplained()),
            candidates.join("; ")
        );
        if self.findings.iter().any(|f| f.fault == Fault::OtherRobot) {
            return;
        }
        if self.unexplained() > FOREIGN_ROBOT_MISFIT {
            self.findings.insert(0, Finding::of_all(Fault::OtherRobot, evidence, OTHER_ROBOT));
            return;
        }
        let remedy =
            "log these joints one at a time, slowly and through their range: that tells zeros, signs and columns";
        self.findings.insert(0, Finding::of(Fault::Unidentified, joints, evidence, remedy));
    }
}

impl JointPassport {
    /// What the description leaves of the joint's torque, in squares, with a slope that errors of its bodies allow; `None`
    /// without a description.
    fn misfit(&self) -> Option<f64> {
        let (slope, share) = (self.slope?, self.share?);
        let allowed = slope.clamp(SLOPES.0, SLOPES.1);
        // The description explains slope^2 xx = share yy; with another slope it misses (slope - allowed)^2 xx.
        let missed = if slope == 0.0 { 0.0 } else { share * ((slope - allowed) / slope).powi(2) };
        Some((1.0 - share + missed).min(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::hypothesis::Hypothesis;

    /// A log of two joints, of which these are wrong.
    fn log(faults: &[Hypothesis]) -> Passport {
        let slope = |k: usize| if faults.iter().any(|f| f.joint() == Some(k)) { -1.0 } else { 1.0 };
        let joint = |k: usize| JointPassport {
            coordinate: format!("j{}", k + 1),
            slope: Some(slope(k)),
            share: Some(0.9),
            ..JointPassport::default()
        };
        // Only the first one is seen until it is undone.
        let seen = faults.first().map(|&of| {
            let joints = of.joints().iter().map(|k| format!("j{}", k + 1)).collect();
            Finding::of(Fault::Of(of, 0.0), joints, String::new(), "").undone_by(vec![Change::of(of)])
        });
        Passport { joints: vec![joint(0), joint(1)], findings: seen.into_iter().collect(), ..Passport::default() }
    }

    fn without(faults: &[Hypothesis], changes: &[Change]) -> Passport {
        let left: Vec<Hypothesis> = faults.iter().filter(|f| !changes.iter().any(|c| c.of == **f)).copied().collect();
        log(&left)
    }

    #[test]
    fn what_a_remedy_uncovers_is_tried_with_it() {
        let (first, second) = (Hypothesis::TorqueSign(0), Hypothesis::MotionSign(1));
        for faults in [vec![first], vec![first, second]] {
            let found = tried(log(&faults), |changes| without(&faults, changes));
            assert_eq!(found.findings.len(), faults.len());
            for (finding, of) in found.findings.iter().zip(&faults) {
                assert_eq!(finding.fault, Fault::Of(*of, 0.0));
                let [before, after] = finding.tried.unwrap();
                assert!(after < before && (after - 0.1).abs() < 1e-12, "{before} {after}");
            }
        }
        assert!(tried(log(&[]), |_| unreachable!("nothing is to be tried")).findings.is_empty());
    }

    #[test]
    fn an_explanation_is_put_before_another() {
        let saturated = || Finding::of(Fault::Saturated(0.1), vec!["j2".into()], String::new(), "");
        let mut passport = log(&[Hypothesis::TorqueSign(0)]);
        passport.findings.push(saturated());
        passport.put_before(vec![Finding::of(Fault::Mount(1.0), Vec::new(), String::new(), ""), saturated()]);
        let found: Vec<(Fault, usize)> = passport.findings.iter().map(|f| (f.fault, f.instead)).collect();
        let sign = Fault::Of(Hypothesis::TorqueSign(0), 0.0);
        assert_eq!(found, [(Fault::Mount(1.0), 0), (Fault::Saturated(0.1), 0), (sign, 1)]);
    }

    #[test]
    fn a_remedy_that_mends_nothing_is_not_named() {
        let faults = [Hypothesis::TorqueSign(0)];
        let found = tried(log(&faults), |_| log(&faults));
        let [finding] = found.findings.as_slice() else { panic!("{:?}", found.findings) };
        assert_eq!((finding.fault, finding.tried), (Fault::Unidentified, None));
        assert_eq!(finding.joints, ["j1"]);
        assert!(finding.evidence.contains("the torque of j1 has the wrong sign"), "{}", finding.evidence);
    }
}
