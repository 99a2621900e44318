//! Detection of contact from the external torques of all joints.
//!
//! Contact begins when the external torque of one joint exceeds z standard deviations. It ends when all joints have stayed
//! below half of this threshold for a hold time. z follows from the rate of false alarms that is accepted (`rist replay`
//! computes it from the residual of the fitted log).
//!
//! A force on a link moves only the joints before this link. So the last joint with a significant torque is before the touched
//! link. The touched link is the link of this joint or a later one.

use crate::real::Real;

/// The contact of one cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contact {
    /// Whether there is contact.
    pub is_contact: bool,
    /// Whether contact begins in this cycle.
    pub begins: bool,
    /// Index of the last joint with a significant external torque, from 0: the touched link is moved by this joint. `None` if no
    /// joint has such a torque.
    pub last_joint: Option<usize>,
}

/// Detector of contact.
#[derive(Clone, Copy, Debug)]
pub struct ContactDetector<R> {
    threshold: R,
    significant: R,
    hold: R,
    quiet: R,
    is_contact: bool,
}

/// Contact ends below this share of the threshold, so that noise near the threshold is not counted several times.
const RELEASE_SHARE: f64 = 0.5;

impl<R: Real> ContactDetector<R> {
    /// Makes a detector. `threshold`: z, standard deviations; `significant`: the external torque of a joint is significant beyond
    /// this number of standard deviations; `hold`: time below half the threshold after which contact ends, s.
    pub fn new(threshold: R, significant: R, hold: R) -> ContactDetector<R> {
        ContactDetector { threshold, significant, hold, quiet: R::ZERO, is_contact: false }
    }

    /// Takes one cycle. `ratios`: external torque of each joint divided by its standard deviation, in the order of the joints
    /// from the base; `period`: time since the previous cycle, s. A ratio that is NaN counts as no contact.
    pub fn step(&mut self, ratios: impl IntoIterator<Item = R>, period: R) -> Contact {
        let (mut largest, mut last_joint) = (R::ZERO, None);
        for (k, ratio) in ratios.into_iter().enumerate() {
            largest = ratio.abs().max(largest);
            if ratio.abs() > self.significant {
                last_joint = Some(k);
            }
        }
        let begins = !self.is_contact && largest > self.threshold;
        if largest > self.threshold * R::of(RELEASE_SHARE) {
            self.quiet = R::ZERO;
        } else {
            self.quiet = self.quiet + period;
        }
        self.is_contact = begins || (self.is_contact && self.quiet < self.hold);
        Contact { is_contact: self.is_contact, begins, last_joint }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_push_is_one_contact_and_noise_near_the_threshold_is_none() {
        let mut detector = ContactDetector::new(5.0, 3.0, 0.1);
        let mut begun = 0;
        let mut of = |ratios: [f64; 3]| {
            let contact = detector.step(ratios, 0.01);
            begun += u32::from(contact.begins);
            contact
        };
        for _ in 0..100 {
            assert!(!of([4.9, -4.9, 1.0]).is_contact);
        }
        // The last joint is not moved by the push, so the second joint moves the touched link.
        assert_eq!(of([7.0, -6.0, 1.0]), Contact { is_contact: true, begins: true, last_joint: Some(1) });
        for k in 0..20 {
            // The ratio falls below the threshold now and then, but it never stays below half of the threshold for 0.1 s.
            let now = if k % 5 == 0 { 5.1 } else { 2.0 };
            assert!(of([now, 0.0, 0.0]).is_contact, "{k}");
        }
        let held = (0..20).filter(|_| of([f64::NAN, 1.0, 0.0]).is_contact).count();
        // The last large ratio was four cycles ago, so six of ten cycles remain until 0.1 s have passed; rounding may add one.
        assert!((5..=6).contains(&held), "{held}");
        assert_eq!(begun, 1);
    }
}
