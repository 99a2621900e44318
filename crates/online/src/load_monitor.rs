//! Finds by itself when a load is picked up or put down, and distinguishes it from contact.
//!
//! At first, a load looks like a contact: both cause an external torque. When contact begins, a new estimate of the load
//! starts. The load has changed if three conditions hold: contact lasts for a decision time, the new load explains the torques,
//! and the motion determines its mass. Then the former estimate is dropped. If contact ends earlier, the former load is kept.
//! If the robot is at rest, a person who leans on it cannot be distinguished from a load; if it moves, this is possible.
//!
//! The estimate under test is available from the settling time on ([`LoadMonitor::candidate`]). It is the load if the contact is
//! one. A program that knows that a gripper has just closed need not wait for the decision.

use crate::contact::Contact;
use crate::payload::{Load, Payload};
use crate::real::Real;

/// The conditions for taking a contact for a change of the load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadDecision<R> {
    /// Time for which the contact must last, s.
    pub time: R,
    /// Time after the beginning of contact in which torques are not used, s. The filter of the observer answers to a load that
    /// appears suddenly with a transient, which the columns H of the load do not have. Usual: five time constants of the
    /// observer, after which the transient is over.
    pub settling: R,
    /// Time constant of the mean square of the normalised residual after the new load, s.
    pub memory: R,
    /// The new load explains the torques if the mean square of the normalised residual is at most this; 1 is expected.
    pub largest_misfit: R,
}

/// The mass of a load may be negative by this number of standard deviations: by noise, after a load is put down.
const LARGEST_NEGATIVE_MASS: f64 = 3.0;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// No contact. The estimate of the carried load is refined.
    Free,
    /// Contact, which may be a new load.
    Testing,
    /// The load has just changed, and contact has not ended since. The estimate of the new load is refined until it does.
    Settling,
}

/// The load that the robot carries, and a new load under test. D: as for [`Payload`].
#[derive(Clone, Copy, Debug)]
pub struct LoadMonitor<R, const D: usize> {
    decision: LoadDecision<R>,
    former: Payload<R, D>,
    current: Payload<R, D>,
    carried: Load<R>,
    /// inv(R) of the carried load.
    inverse: [[R; 10]; 10],
    /// The load of `current` at the end of the last update.
    tested: Load<R>,
    /// Parameters of `current` at the beginning of the update.
    predicted: [R; 10],
    phase: Phase,
    /// Whether a load has been found so far. Before that, noise is not taken for a small load.
    has_load: bool,
    age: R,
    misfit: R,
    period: R,
}

impl<R: Real, const D: usize> LoadMonitor<R, D> {
    /// Starts without a load. `empty`: an estimate without rows.
    pub fn new(empty: Payload<R, D>, decision: LoadDecision<R>) -> LoadMonitor<R, D> {
        let none = Load { parameters: [R::ZERO; 10], ..empty.load() };
        LoadMonitor {
            decision,
            former: empty,
            current: empty,
            carried: none,
            inverse: [[R::ZERO; 10]; 10],
            tested: none,
            predicted: [R::ZERO; 10],
            phase: Phase::Free,
            has_load: false,
            age: R::ZERO,
            misfit: R::ZERO,
            period: R::ZERO,
        }
    }

    /// The load that the robot carries.
    pub fn carried(&self) -> &Load<R> {
        &self.carried
    }

    /// The load that would explain the present contact, and the mean square of its normalised residual. For a load, this mean
    /// square falls to 1 as the estimate settles. `None` without contact, in the settling time, and after a decision for a load.
    pub fn candidate(&self) -> Option<(&Load<R>, R)> {
        let is_tested = self.phase == Phase::Testing && self.age >= self.decision.settling;
        is_tested.then_some((&self.tested, self.misfit))
    }

    /// The torque -H x of the carried load, for one row of H.
    pub fn explained(&self, row: &[R; 10]) -> R {
        self.carried.parameters.iter().zip(row).fold(R::ZERO, |sum, (x, h)| sum - *x * *h)
    }

    /// The variance of the torque of [`LoadMonitor::explained`], from the noise of the estimate, N^2 m^2 (N^2); zero before a
    /// load was found.
    pub fn variance(&self, row: &[R; 10]) -> R {
        let mut sum = R::ZERO;
        for c in 0..row.len() {
            // `inverse` is an upper triangle, so only the first entries of a column count.
            let product =
                self.inverse.iter().zip(row).take(c + 1).fold(R::ZERO, |sum, (inverse, h)| sum + inverse[c] * *h);
            sum = sum + product * product;
        }
        self.current.correlation() * sum
    }

    /// Begins an update. `contact`: the contact of the torques beyond the carried load; `period`: time since the previous
    /// update, s.
    pub fn begin(&mut self, contact: Contact, period: R) {
        let is_late = self.age > self.decision.time;
        match (contact.is_contact, self.phase) {
            (true, Phase::Free) => self.start_test(),
            (true, Phase::Settling) if is_late => self.start_test(),
            (false, Phase::Testing) => (self.current, self.phase) = (self.former, Phase::Free),
            (false, Phase::Settling) => self.phase = Phase::Free,
            _ => {}
        }
        self.age = self.age + period;
        self.period = period;
        self.predicted = self.current.parameters();
    }

    /// Takes the torque of one joint; arguments as of [`Payload::push`]. `joints`: number of joints.
    pub fn push(&mut self, row: &[R; 10], torque: R, deviation: R, shared: &[R; D], joints: usize) {
        if self.phase == Phase::Testing && self.age < self.decision.settling {
            return;
        }
        if self.phase == Phase::Testing {
            let explained = self.predicted.iter().zip(row).fold(R::ZERO, |sum, (x, h)| sum - *x * *h);
            let normalised = (torque - explained) / deviation;
            let share = self.period / (self.decision.memory + self.period) / R::of(joints as f64);
            let square = normalised * normalised;
            if square.is_finite() {
                self.misfit = self.misfit + share * (square - self.misfit);
            }
        }
        self.current.push(row, torque, deviation, shared);
    }

    /// Ends an update. Returns whether the load has changed in this update; then [`LoadMonitor::carried`] is the new load.
    pub fn end(&mut self) -> bool {
        let load = self.current.load();
        self.tested = load;
        let is_explained = self.age > self.decision.time && self.misfit < self.decision.largest_misfit;
        // A load whose mass the motion does not determine yet would be wrong in another posture. No body has a negative mass.
        let is_explained = is_explained && load.is_determined[9];
        let is_explained = is_explained && load.parameters[9] > -R::of(LARGEST_NEGATIVE_MASS) * load.sigma[9];
        match self.phase {
            Phase::Free if !self.has_load => false,
            Phase::Testing if !is_explained => false,
            Phase::Free | Phase::Settling => {
                self.carry(load);
                false
            }
            Phase::Testing => {
                self.carry(load);
                (self.phase, self.age, self.has_load) = (Phase::Settling, R::ZERO, true);
                true
            }
        }
    }

    fn carry(&mut self, load: Load<R>) {
        (self.carried, self.inverse) = (load, self.current.inverse_triangle());
    }

    fn start_test(&mut self) {
        self.former = self.current;
        self.current.reset();
        (self.phase, self.age, self.misfit) = (Phase::Testing, R::ZERO, R::ZERO);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    extern crate std;

    /// A cycle, with mass, sigma and misfit of a load.
    type Seen = (i32, f64, f64, f64);

    /// The cycles at which the load changed, and those with a candidate. A load of this mass is there from cycle 300 to 900, and a
    /// push of one joint from 1200 to 1230.
    fn monitored(load: f64) -> [std::vec::Vec<Seen>; 2] {
        let empty = Payload::<f64, 0>::new([5.0; 10], 1.0);
        let decision = LoadDecision { time: 1.0, settling: 0.05, memory: 0.2, largest_misfit: 4.0 };
        let mut monitor = LoadMonitor::new(empty, decision);
        let mut detector = crate::ContactDetector::new(6.0, 3.0, 0.1);
        let mut random = Random::new(2);
        let mut changes = std::vec::Vec::new();
        let mut early = std::vec::Vec::new();
        for k in 0..1500 {
            let t = 0.01 * f64::from(k);
            let rows: [[f64; 10]; 3] = std::array::from_fn(|j| {
                std::array::from_fn(|c| ((3.0 + 1.7 * c as f64) * t + 2.0 * j as f64 + 0.7 * c as f64).sin())
            });
            let mass = if (300..900).contains(&k) { load } else { 0.0 };
            let push = if (1200..1230).contains(&k) { 3.0 } else { 0.0 };
            let torques: [f64; 3] =
                std::array::from_fn(|j| -rows[j][9] * mass + [0.0, push, 0.0][j] + 0.05 * random.normal());
            let ratios: [f64; 3] = std::array::from_fn(|j| (torques[j] - monitor.explained(&rows[j])) / 0.05);
            let contact = detector.step(ratios, 0.01);
            monitor.begin(contact, 0.01);
            for (row, torque) in rows.iter().zip(torques) {
                monitor.push(row, torque, 0.05, &[], 3);
            }
            let is_changed = monitor.end();
            if let Some((load, misfit)) = monitor.candidate() {
                early.push((k, load.parameters[9], load.sigma[9], misfit));
            }
            if is_changed {
                changes.push((k, monitor.carried().parameters[9], monitor.carried().sigma[9], monitor.misfit));
            }
        }
        [changes, early]
    }

    /// Forces upward, as of a negative mass, are a contact and no load.
    #[test]
    fn a_negative_mass_is_no_load() {
        assert_eq!(monitored(-2.0)[0], []);
    }

    #[test]
    fn a_load_is_told_from_a_push() {
        let [changes, early] = monitored(2.0);
        let [(up, mass, sigma, _), (down, left, of_left, _)] = changes[..] else { panic!("{changes:?}") };
        assert!((398..430).contains(&up) && (998..1030).contains(&down), "{changes:?}");
        // Only one random sequence is tested, so the limit is four standard deviations. The ten columns are waves of similar
        // frequency. After the decision time of one second they leave a standard deviation of 0.15 kg.
        // Half a second after the load appeared, the estimate covers its mass. Just before the decision, the mean square is
        // below the limit for a load.
        let at = |k: i32| *early.iter().find(|(of, ..)| *of == k).expect("a candidate");
        let ((_, half, half_sigma, _), (.., misfit)) = (at(350), at(up - 1));
        assert!((half - 2.0).abs() < 4.0 * half_sigma && misfit < 4.0, "{half} {half_sigma} {misfit}");
        // Outside of contact and after the decision there is no candidate.
        assert!(
            early.iter().all(|(k, ..)| (300..up).contains(k) || (900..down).contains(k) || *k >= 1200),
            "{early:?}"
        );
        assert!((mass - 2.0).abs() < 4.0 * sigma && left.abs() < 4.0 * of_left && sigma < 0.2, "{changes:?}");
    }
}
