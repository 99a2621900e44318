//! Tries the findings (faults with their evidence) of a log check: the faults are undone in the log, and the log is checked
//! again.
//!
//! If the second check reveals another fault, this fault is undone too. If no contradiction remains in the end, all undone
//! faults are reported. Otherwise the report says that the cause is not identified.

use crate::estimate::digits::percent;
use crate::estimate::log_check::change::Change;
use crate::estimate::log_check::finding::{Fault, Finding};
use crate::estimate::log_check::report::{JointCheck, LogCheck};
use crate::estimate::log_check::search::MAX_MISTAKES;

/// Number of repeated checks: one with the found faults undone, and two for faults that these checks reveal.
const REPEATED_CHECKS: usize = 3;

/// A joint is wrong if its squared relative residual with the description exceeds this value. The slope (measured / nominal
/// torque) is limited to `PLAUSIBLE_SLOPES`.
const WRONG_JOINT_MISFIT: f64 = 0.5;

/// A log belongs to another robot if the squared relative residual of the description, as a mean over the joints, exceeds this
/// value.
pub(super) const FOREIGN_ROBOT_MISFIT: f64 = 0.6;
/// Remedy if the log belongs to another robot.
pub(super) const OTHER_ROBOT: &str = "no single sign, zero, unit or exchange of columns mends it: look for another model, another \
                                      tool or mounting (gravity), or several mistakes at once";

/// Plausible range of the slope (measured / nominal torque) of a joint: nominal bodies may be wrong by a factor of two.
const PLAUSIBLE_SLOPES: (f64, f64) = (0.5, 2.0);

/// Two explanations of a log are equivalent if the ratio of their squared residuals is at most this value.
pub const AS_WELL_RATIO: f64 = 1.5;

/// Tries the findings of the log check `first`, and returns the check with the confirmed findings. `again`: checks the log with
/// changes applied.
///
/// An explanation (a list of findings) is confirmed if no contradiction remains after its faults are undone. Only explanations
/// with the fewest faults are kept. The explanation with the smallest residual comes first, and equivalent explanations are
/// reported as alternatives.
pub(super) fn tried(mut first: LogCheck, again: impl Fn(&[Change]) -> LogCheck) -> LogCheck {
    if !first.is_gross() {
        return first;
    }
    let explanations = std::iter::once(first.findings.clone()).chain(std::mem::take(&mut first.others));
    // Confirmed explanations with the fewest faults.
    let mut mended: Vec<Vec<Finding>> = Vec::new();
    for findings in explanations {
        let fewest = mended.first().map_or(MAX_MISTAKES, |found| found.iter().map(mistakes).sum());
        if let Some(found) = mends(&first, findings, fewest, &again) {
            mended.retain(|other| other.len() <= found.len());
            mended.push(found);
        }
    }
    // Of the confirmed explanations, two kinds are kept: the explanation with the smallest residual, and the explanations that
    // are equivalent to that explanation.
    let left = |found: &Vec<Finding>| found.iter().find_map(|f| f.tried).map_or(f64::INFINITY, |shares| shares[1]);
    mended.sort_by(|a, b| left(a).total_cmp(&left(b)));
    let least = mended.first().map_or(f64::INFINITY, &left);
    mended.retain(|found| left(found) <= AS_WELL_RATIO * least);
    if mended.is_empty() {
        first.leave_unidentified();
        return first;
    }
    // Equivalent explanations with the same faults at the same joints are reported once.
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

/// Number of faults for which a finding counts. `NoTorque` gives each joint a free gain, so it counts as the largest allowed
/// number of faults.
fn mistakes(finding: &Finding) -> usize {
    if finding.fault == Fault::NoTorque { MAX_MISTAKES } else { 1 }
}

/// Tries one explanation: undoes the gross findings of the explanation, and then the findings of the next check. `None` if a
/// contradiction remains, or if more than `most` faults are needed. `again`: checks the log with changes applied.
fn mends(
    first: &LogCheck,
    findings: Vec<Finding>,
    most: usize,
    again: &impl Fn(&[Change]) -> LogCheck,
) -> Option<Vec<Finding>> {
    let (mut found, mut new) = (Vec::<Finding>::new(), findings);
    for _ in 0..REPEATED_CHECKS {
        new.retain(|f| f.fault.is_gross());
        // A finding that no change of the log can undo cannot be tried. So the explanation is not confirmed.
        let count = found.iter().chain(&new).map(mistakes).sum::<usize>();
        if new.iter().any(|f| f.undo.is_empty()) || count > most {
            return None;
        }
        found.append(&mut new);
        let undo: Vec<Change> = found.iter().flat_map(|f| f.undo.iter().copied()).collect();
        let log_check = again(&undo);
        if !log_check.is_gross() {
            let shares = [first.unexplained(), log_check.unexplained()];
            found.iter_mut().for_each(|f| f.tried = Some(shares));
            return Some(found);
        }
        new = log_check.findings;
    }
    None
}

impl LogCheck {
    /// Squared relative residual of the description, mean over the joints with slopes. Slopes (measured / nominal torque) are
    /// limited to a plausible range.
    pub fn unexplained(&self) -> f64 {
        let all: Vec<f64> = self.joints.iter().filter_map(JointCheck::misfit).collect();
        all.iter().sum::<f64>() / all.len().max(1) as f64
    }

    /// Inserts an explanation before the others. The previous gross findings (which make estimates unusable) become
    /// alternatives; all other previous findings are dropped.
    pub fn put_before(&mut self, explanation: Vec<Finding>) {
        let others = self.findings.drain(..).filter(|f| f.fault.is_gross());
        let others = others.map(|f| Finding { instead: f.instead + 1, ..f }).collect::<Vec<_>>();
        self.findings = explanation.into_iter().chain(others).collect();
    }

    /// Replaces all findings whose trial failed by one finding: cause not identified, or another robot.
    fn leave_unidentified(&mut self) {
        let (vain, others): (Vec<Finding>, Vec<Finding>) =
            self.findings.drain(..).partition(|f| f.fault.is_gross() && !f.undo.is_empty());
        self.findings = others;
        if vain.is_empty() {
            return;
        }
        let is_wrong = |j: &&JointCheck| j.misfit().is_some_and(|misfit| misfit > WRONG_JOINT_MISFIT);
        let mut joints: Vec<String> = self.joints.iter().filter(is_wrong).map(|j| j.coordinate.clone()).collect();
        if joints.is_empty() {
            joints = vain.iter().flat_map(|f| f.joints.iter().cloned()).collect();
        }
        let candidates: Vec<String> = vain.iter().map(Finding::statement).collect();
        let evidence = format!(
            "the nominal residual is {} of the torques (joints alike); tried, and not enough: {}",
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
            "log these joints one at a time, slowly and through their range: that shows zeros, signs and columns";
        self.findings.insert(0, Finding::of(Fault::Unidentified, joints, evidence, remedy));
    }
}

impl JointCheck {
    /// Squared relative residual of the torque of the joint, with the description and a plausible slope; `None` without a
    /// slope.
    fn misfit(&self) -> Option<f64> {
        let (slope, share) = (self.slope?, self.share?);
        let allowed = slope.clamp(PLAUSIBLE_SLOPES.0, PLAUSIBLE_SLOPES.1);
        // xx, yy: squared nominal and squared measured torque. With the fitted slope, the description explains slope^2 xx =
        // share yy. With the slope `allowed` instead, the squared residual grows by (slope - allowed)^2 xx.
        let missed = if slope == 0.0 { 0.0 } else { share * ((slope - allowed) / slope).powi(2) };
        Some((1.0 - share + missed).min(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::hypothesis::Hypothesis;

    /// The check of a log of two joints in which these faults exist.
    fn log(faults: &[Hypothesis]) -> LogCheck {
        let slope = |k: usize| if faults.iter().any(|f| f.joint() == Some(k)) { -1.0 } else { 1.0 };
        let joint = |k: usize| JointCheck {
            coordinate: format!("j{}", k + 1),
            slope: Some(slope(k)),
            share: Some(0.9),
            ..JointCheck::default()
        };
        // The check detects only the first fault. The second fault appears after the first is undone.
        let seen = faults.first().map(|&of| {
            let joints = of.joints().iter().map(|k| format!("j{}", k + 1)).collect();
            Finding::of(Fault::Of(of, 0.0), joints, String::new(), "").undone_by(vec![Change::of(of)])
        });
        LogCheck { joints: vec![joint(0), joint(1)], findings: seen.into_iter().collect(), ..LogCheck::default() }
    }

    fn without(faults: &[Hypothesis], changes: &[Change]) -> LogCheck {
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
        let mut log_check = log(&[Hypothesis::TorqueSign(0)]);
        log_check.findings.push(saturated());
        log_check.put_before(vec![Finding::of(Fault::Mount(1.0), Vec::new(), String::new(), ""), saturated()]);
        let found: Vec<(Fault, usize)> = log_check.findings.iter().map(|f| (f.fault, f.instead)).collect();
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
