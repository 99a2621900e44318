//! Finds by itself when a load is picked up or put down, and distinguishes it from contact.
//!
//! At first, a load looks like a contact: both cause an external torque. When contact begins, a new estimate of the load
//! starts. The load has changed if four conditions hold: contact lasts for a decision time, the new load explains the torques, a
//! torque of one joint alone does not explain them, and the motion determines the mass of the load. Then the former estimate is
//! dropped. If contact ends earlier, the former load is kept. If the robot is at rest, a person who leans on it cannot be
//! distinguished from a load; if it moves, this is possible.
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
    /// Time constant of the means of the misfit, s.
    pub memory: R,
    /// The new load explains the torques if the misfit is at most this ([`LoadMonitor::push`]); 1 is expected.
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
    joints: usize,
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
    /// The misfit if a torque of one joint alone is beyond the carried load, instead of a new load.
    misfit_of_one: R,
    /// The squares of the present update.
    squares: Squares<R>,
    period: R,
}

/// Sums over joints of the squared normalised mean residuals.
#[derive(Clone, Copy, Debug)]
struct Squares<R> {
    joints: R,
    /// After the new load.
    new: R,
    /// After the carried load, and the largest of its terms.
    carried: R,
    largest: R,
}

impl<R: Real> Squares<R> {
    const NONE: Squares<R> = Squares { joints: R::ZERO, new: R::ZERO, carried: R::ZERO, largest: R::ZERO };

    /// Adds the squares of a joint, after the new load and after the carried load.
    fn add(&mut self, [new, carried]: [R; 2]) {
        if new.is_finite() && carried.is_finite() {
            self.joints = self.joints + R::ONE;
            (self.new, self.carried) = (self.new + new, self.carried + carried);
            self.largest = self.largest.max(carried);
        }
    }

    /// The mean over the joints after the new load, and the mean over all joints but one after the carried load.
    fn means(&self) -> [R; 2] {
        let others = (self.joints - R::ONE).max(R::ONE);
        [self.new / self.joints.max(R::ONE), (self.carried - self.largest) / others]
    }
}

impl<R: Real, const D: usize> LoadMonitor<R, D> {
    /// Starts without a load. `empty`: an estimate without rows; `joints`: number of joints of the robot.
    pub fn new(empty: Payload<R, D>, decision: LoadDecision<R>, joints: usize) -> LoadMonitor<R, D> {
        let none = Load { parameters: [R::ZERO; 10], ..empty.load() };
        LoadMonitor {
            decision,
            joints,
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
            misfit_of_one: R::ZERO,
            squares: Squares::NONE,
            period: R::ZERO,
        }
    }

    /// The load that the robot carries.
    pub fn carried(&self) -> &Load<R> {
        &self.carried
    }

    /// The load that would explain the present contact, and its misfit ([`LoadMonitor::push`]). For a load, the misfit falls to 1 as
    /// the estimate settles. `None` without contact, in the settling time, and after a decision for a load.
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
        sum
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
        self.squares = Squares::NONE;
    }

    /// Whether a contact has just begun. The means of [`LoadMonitor::push`] start from zero then.
    pub fn is_settling(&self) -> bool {
        self.phase == Phase::Testing && self.age < self.decision.settling
    }

    /// Takes the torque of one joint; arguments as of [`Payload::push`]. `means`: the mean residual of this joint after the new load,
    /// and after the carried load, N m (N). The caller keeps them from update to update.
    ///
    /// The misfit is the mean over time and joints of m^2 / var(m). m: mean of the residual over the memory, as a low-pass of first
    /// order with the share k. var(m) = s^2 k / (2 - k) + |Z|^2: noise averages out, an error of the robot's parameters does not. So
    /// a torque that the load leaves unexplained counts also if it is smaller than the noise of a single update.
    pub fn push(&mut self, means: &mut [R; 2], row: &[R; 10], torque: R, deviation: R, shared: &[R; D]) {
        let is_testing = self.phase == Phase::Testing;
        if self.is_settling() {
            return;
        }
        if is_testing {
            let share = self.share();
            let of_noise = deviation * deviation * share / (R::of(2.0) - share);
            let variance = shared.iter().fold(of_noise, |sum, z| sum + *z * *z);
            let after = |load: &[R; 10]| load.iter().zip(row).fold(torque, |sum, (x, h)| sum + *x * *h);
            let residuals = [after(&self.predicted), after(&self.carried.parameters)];
            for (mean, residual) in means.iter_mut().zip(residuals) {
                *mean = *mean + share * (residual - *mean);
            }
            self.squares.add(means.map(|mean| mean * mean / variance));
        }
        self.current.push(row, torque, deviation, shared);
    }

    /// Weight of an update in a mean over the memory.
    fn share(&self) -> R {
        self.period / (self.decision.memory + self.period)
    }

    /// Ends an update. Returns whether the load has changed in this update; then [`LoadMonitor::carried`] is the new load.
    pub fn end(&mut self) -> bool {
        let load = self.current.load();
        self.tested = load;
        if self.phase == Phase::Testing {
            let share = self.share();
            let [misfit, misfit_of_one] = self.squares.means();
            self.misfit = self.misfit + share * (misfit - self.misfit);
            self.misfit_of_one = self.misfit_of_one + share * (misfit_of_one - self.misfit_of_one);
        }
        let is_explained = self.age > self.decision.time && self.misfit < self.decision.largest_misfit;
        // If the torque of a single joint explains the contact nearly as well, friction of this joint may have changed.
        let limit_of_one = self.decision.largest_misfit * self.misfit.max(R::ONE);
        let is_explained = is_explained && (self.joints == 1 || self.misfit_of_one > limit_of_one);
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
        (self.phase, self.age) = (Phase::Testing, R::ZERO);
        (self.misfit, self.misfit_of_one) = (R::ZERO, R::ZERO);
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
    /// push of one joint from 1200 to 1230. `of_joints`: factor of the rows of each joint.
    fn monitored(load: f64, of_joints: [f64; 3]) -> [std::vec::Vec<Seen>; 2] {
        let empty = Payload::<f64, 0>::new([5.0; 10]);
        let decision = LoadDecision { time: 1.0, settling: 0.05, memory: 0.2, largest_misfit: 4.0 };
        let mut monitor = LoadMonitor::new(empty, decision, 3);
        let mut detector = crate::ContactDetector::new(6.0, 3.0, 0.1);
        let mut random = Random::new(2);
        let mut changes = std::vec::Vec::new();
        let mut early = std::vec::Vec::new();
        let mut means = [[0.0; 2]; 3];
        for k in 0..1500 {
            let t = 0.01 * f64::from(k);
            let rows: [[f64; 10]; 3] = std::array::from_fn(|j| {
                std::array::from_fn(|c| {
                    of_joints[j] * ((3.0 + 1.7 * c as f64) * t + 2.0 * j as f64 + 0.7 * c as f64).sin()
                })
            });
            let mass = if (300..900).contains(&k) { load } else { 0.0 };
            let push = if (1200..1230).contains(&k) { 3.0 } else { 0.0 };
            let torques: [f64; 3] =
                std::array::from_fn(|j| -rows[j][9] * mass + [0.0, push, 0.0][j] + 0.05 * random.normal());
            let ratios: [f64; 3] = std::array::from_fn(|j| (torques[j] - monitor.explained(&rows[j])) / 0.05);
            let contact = detector.step(ratios, 0.01);
            monitor.begin(contact, 0.01);
            if monitor.is_settling() {
                means = [[0.0; 2]; 3];
            }
            for ((row, torque), mean) in rows.iter().zip(torques).zip(&mut means) {
                monitor.push(mean, row, torque, 0.05, &[]);
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
        assert_eq!(monitored(-2.0, [1.0; 3])[0], []);
    }

    /// If the torque of one joint is the only one, friction of this joint explains it as well as a load.
    #[test]
    fn a_torque_of_one_joint_is_no_load() {
        assert_eq!(monitored(2.0, [0.0, 1.0, 0.0])[0], []);
        assert_eq!(monitored(2.0, [0.3, 1.0, 0.0])[0].len(), 2);
    }

    #[test]
    fn a_load_is_told_from_a_push() {
        let [changes, early] = monitored(2.0, [1.0; 3]);
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
