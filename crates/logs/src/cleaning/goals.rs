//! Checks the goals of position servos, and converts them to position errors.
//!
//! The torque of a servo with the goal q_g is k (q_g - q), if it is at no limit and has no integral term. q: position; k: gain,
//! N m/rad. A signal is not a goal if it is constant while the joint moves, or if it always equals the position.
//!
//! The goal is the commanded position of a servo, and the position error is goal minus position.

use std::f64::consts::{PI, TAU};

use crate::Error;

/// If all position errors are below this fraction of the joint's range, they are only rounding, because no encoder has a finer
/// resolution.
const ROUNDING_SHARE: f64 = 1e-4;
/// Largest deviation of a position from a constant goal, rad (m).
const LARGEST_SAG: f64 = 0.2;

/// Ranges of goals and positions of a joint, over a log or a block of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GoalSpan {
    header: String,
    /// Lowest and highest goal, rad (m); `None` if there is no goal yet.
    goal: Option<[f64; 2]>,
    /// Lowest and highest position, rad (m); `None` if there is no position yet.
    position: Option<[f64; 2]>,
    /// Largest absolute position error (goal minus position), rad (m).
    error: f64,
}

impl GoalSpan {
    /// Replaces the goals by position errors (goal minus position). Also removes whole turns from the errors, because a
    /// position may jump by a turn while its goal does not.
    pub(crate) fn take(&mut self, header: &str, position: &[f64], goal: &mut [f64]) {
        let span = |x: &[f64]| {
            x.iter().filter(|x| x.is_finite()).fold(None, |span: Option<[f64; 2]>, &x| {
                Some(span.map_or([x; 2], |[low, high]| [low.min(x), high.max(x)]))
            })
        };
        let (goals, positions) = (span(goal), span(position));
        let mut error: f64 = 0.0;
        for (goal, q) in goal.iter_mut().zip(position) {
            *goal -= q;
            if goal.abs() > PI {
                *goal -= TAU * (*goal / TAU).round();
            }
            error = error.max(goal.abs());
        }
        self.append(&GoalSpan { header: header.into(), goal: goals, position: positions, error });
    }

    /// Adds the ranges of another block of the log.
    pub(crate) fn append(&mut self, other: &GoalSpan) {
        let whole = |a: Option<[f64; 2]>, b: Option<[f64; 2]>| match (a, b) {
            (Some(a), Some(b)) => Some([a[0].min(b[0]), a[1].max(b[1])]),
            (a, b) => a.or(b),
        };
        self.header.clone_from(&other.header);
        self.goal = whole(self.goal, other.goal);
        self.position = whole(self.position, other.position);
        self.error = self.error.max(other.error);
    }

    /// Fails if the signal cannot be a goal. A coordinate without a drive has no goals and passes.
    pub(crate) fn check(&self, file: &str) -> Result<(), Error> {
        let (Some([low, high]), Some([from, to])) = (self.goal, self.position) else { return Ok(()) };
        let header = &self.header;
        let refuse = |what: String| Err(Error::at(file, 0, what));
        if high == low && to - from > LARGEST_SAG {
            return refuse(format!(
                "column `{header}` is {low} throughout, while its joint goes from {from:.4} to {to:.4}: no goal of a servo \
                 that follows; name the column of the commanded positions, [options.columns.goal]"
            ));
        }
        if self.error <= ROUNDING_SHARE * (to - from) && to > from {
            return refuse(format!(
                "column `{header}` is the position of its joint in every row, to {:.1e} rad (m): the measured position, named \
                 again? The goal is the commanded position, [options.columns.goal]",
                self.error
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(position: &[f64], goal: &[f64]) -> (GoalSpan, Vec<f64>) {
        let (mut span, mut error) = (GoalSpan::default(), goal.to_vec());
        span.take("goal_a", position, &mut error);
        (span, error)
    }

    #[test]
    fn an_error_is_the_nearest_by_whole_turns() {
        let (span, error) = span(&[3.1, -3.1, 0.5], &[3.15, 3.2, 0.4]);
        let expected = [0.05, 6.3 - TAU, -0.1];
        assert!(error.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{error:?}");
        assert!(span.check("log.csv").is_ok());
    }

    #[test]
    fn what_is_no_goal_is_refused() {
        for (position, goal, said) in [
            ([0.0, 0.5, 1.0], [0.3, 0.3, 0.3], "is 0.3 throughout, while its joint goes from 0.0000 to 1.0000"),
            ([0.0, 0.5, 1.0], [0.00005, 0.5, 1.0], "is the position of its joint in every row, to 5.0e-5"),
            ([0.0, 0.5, 1.0], [0.0, 0.5, 1.0], "is the position of its joint in every row"),
        ] {
            let message = span(&position, &goal).0.check("log.csv").unwrap_err().to_string();
            assert!(message.contains(said) && message.contains("goal_a"), "{message}");
        }
        // These errors are accepted: a servo that holds its position has a small error. The ranges of two blocks are combined.
        assert!(span(&[0.25, 0.28, 0.29], &[0.3; 3]).0.check("log.csv").is_ok());
        let (mut first, _) = span(&[0.0, 1.0], &[0.3, 0.3]);
        first.append(&span(&[1.0, 0.0], &[0.9, 0.1]).0);
        assert!(first.check("log.csv").is_ok());
    }
}
