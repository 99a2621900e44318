//! The loop of a replay over the cycles of a log. It makes the same calls as the loop of a controller.
//!
//! In each cycle (one sample): observers, noise scale, contact, load, drift of friction. A contact that a load explains becomes
//! a change of the load. The misfit is the mean square of the normalised residual.

use online::{Contact, ContactDetector, Drift, Load, LoadDecision, LoadMonitor, NoiseScale, Order, Payload};

use crate::replay::artefact::{CarriedLoad, ContactInterval, EARLY_S, JointReplay, Replay, ReplayedCycle};
use crate::replay::cycles::{Cycle, CycleModel};
use crate::replay::directions::DIRECTIONS;
use crate::replay::load_noise::{self, load_start};
use crate::replay::noise::{Noise, SETTLING_TIME_CONSTANTS, square};
use crate::replay::observers::Observers;
use crate::replay::wrench::ContactWrench;

/// Settings of a run.
pub(crate) struct Settings {
    pub(crate) order: Order<f64>,
    /// Gain of the observer, 1/s.
    pub(crate) gain: f64,
    /// Mean period of the log, s.
    pub(crate) period: f64,
    /// Threshold of contact, standard deviations.
    pub(crate) threshold: f64,
    /// The external torque of a joint is significant beyond this number of standard deviations.
    pub(crate) significant: f64,
    /// Time below half the threshold after which contact ends, s.
    pub(crate) hold: f64,
    /// Largest mass of a load, kg.
    pub(crate) largest_load: f64,
}

/// A contact must last this time, s, before it can count as a load. Pushes and collisions are shorter.
pub(crate) const LOAD_DECISION_S: f64 = 1.5;
/// Time constant of the misfit of a new load, s.
pub(crate) const MISFIT_MEMORY_S: f64 = 0.3;
/// A load explains a contact only if its misfit is at most this value; 1 is expected. Friction that the model lacks raises it: of 12
/// loads of a Kuka LWR in MuJoCo, a limit of 4 misses three, and this limit none (docs/how-to/watch_in_mujoco.py with LOADS = 12).
pub(crate) const LARGEST_MISFIT: f64 = 12.0;
/// Memory of the drift of friction, s. It is two minutes, because temperature changes friction within minutes.
const DRIFT_MEMORY_S: f64 = 120.0;
/// Prior standard deviation of a drift, relative to the noise of the observer. It is so large that the prior has hardly any
/// effect.
const DRIFT_RELATIVE_TO_NOISE: f64 = 100.0;

/// The state of a run.
pub(crate) struct Run {
    noise: Noise,
    settings: Settings,
    observers: Observers,
    detector: ContactDetector<f64>,
    loads: LoadMonitor<f64, DIRECTIONS>,
    /// Whether the last interval of contact is the present contact. A contact that turned out to be a load has no interval.
    is_open: bool,
    /// The candidate of the present contact, [`EARLY_S`] after it began.
    early: Option<Load<f64>>,
    drifts: Vec<Drift<f64>>,
    scales: Vec<NoiseScale<f64>>,
    pub(crate) replay: Replay,
    /// Sum of squared ratios without contact, per joint, and their number.
    squares: Vec<f64>,
    count: usize,
    /// The factor of each joint for the standard deviation of a row of a load ([`Noise::load_factors`]).
    load_factors: Vec<f64>,
    /// The mean residuals of each joint, N m (N) ([`LoadMonitor::push`]).
    means: Vec<[f64; 2]>,
    /// Time in which the torque of a joint was at its limit, s.
    saturated: Vec<f64>,
}

impl Run {
    /// Starts without contact and without a load. `log`: its name.
    pub(crate) fn new(cycles: &CycleModel, noise: Noise, log: String, settings: Settings) -> Run {
        let n = cycles.n();
        let start = load_start(settings.largest_load);
        let correlation = noise.correlation(settings.period);
        let decision = LoadDecision {
            time: LOAD_DECISION_S,
            settling: SETTLING_TIME_CONSTANTS / settings.gain,
            memory: MISFIT_MEMORY_S,
            largest_misfit: LARGEST_MISFIT,
        };
        // In each cycle, the weight of all earlier cycles is multiplied by this factor. So the weights decay with the time
        // constant `DRIFT_MEMORY_S`.
        let weight = 1.0 - settings.period / DRIFT_MEMORY_S;
        let drift = |band: &online::Band<f64>| {
            // Prior standard deviations of FV, FS and OFF. FV times the speed of the band is a torque as large as that of FS
            // and OFF.
            let possible = DRIFT_RELATIVE_TO_NOISE * band.noise;
            Drift::new([possible / band.speed.max(f64::MIN_POSITIVE), possible, possible], weight, correlation)
        };
        let regressor = cycles.model.regressor();
        let units = (0..n).map(|j| if regressor.is_prismatic(j) { "N" } else { "N m" });
        Run {
            observers: Observers::new(n, settings.order),
            detector: ContactDetector::new(settings.threshold, settings.significant, settings.hold),
            loads: LoadMonitor::new(Payload::new(start), decision, n),
            is_open: false,
            early: None,
            scales: noise.scales(),
            drifts: noise.bands.iter().map(drift).collect(),
            replay: Replay::new(log, regressor.coordinates().to_vec(), units.collect(), settings.threshold),
            squares: vec![0.0; n],
            means: vec![[0.0; 2]; n],
            saturated: vec![0.0; n],
            count: 0,
            load_factors: noise.load_factors(settings.period),
            noise,
            settings,
        }
    }

    /// Processes one cycle: compares the external torques with their noise, updates contact, load and drift, and stores the
    /// results.
    pub(crate) fn step(&mut self, cycle: &Cycle) {
        // After a gap of the log, it is not known whether an earlier contact still lasts.
        if cycle.period <= 0.0 {
            let Settings { threshold, significant, hold, .. } = self.settings;
            self.detector = ContactDetector::new(threshold, significant, hold);
        }
        self.observers.step(cycle);
        let shared: Vec<[f64; DIRECTIONS]> = cycle.joints.iter().map(|joint| self.noise.shared(&joint.row)).collect();
        let seen = &self.observers.seen;
        let beyond: Vec<f64> = seen.iter().map(|s| s.torque - self.loads.explained(&s.load)).collect();
        let scales = self.scales.iter_mut().zip(&beyond);
        let scales: Vec<f64> = scales.map(|(scale, torque)| scale.step(*torque, cycle.period)).collect();
        let mut bands = self.noise.bands.clone();
        bands.iter_mut().zip(scales).for_each(|(band, scale)| band.noise *= scale);
        // The uncertainty of the robot's parameters and of the load.
        let of_parameters: Vec<f64> =
            seen.iter().zip(&shared).map(|(seen, shared)| square(shared) + self.loads.variance(&seen.load)).collect();
        let joints = bands.iter().zip(seen).zip(&of_parameters);
        let limits: Vec<f64> = joints
            .clone()
            .map(|((band, seen), of_parameters)| {
                self.settings.threshold * band.deviation(seen.slowness, *of_parameters) + band.dry_at(seen.slowness)
            })
            .collect();
        let ratios = joints
            .zip(&beyond)
            .map(|(((band, seen), of_parameters), torque)| band.ratio(*torque, seen.slowness, *of_parameters));
        let ratios: Vec<f64> = ratios.collect();
        let contact = self.detector.step(ratios.iter().copied(), cycle.period);
        let deviations = limits.iter().map(|limit| limit / self.settings.threshold);
        self.note_contact(cycle, contact, (&beyond, &deviations.collect::<Vec<f64>>()), &ratios);
        if !contact.is_contact {
            self.count += 1;
            self.squares.iter_mut().zip(&ratios).for_each(|(sum, ratio)| *sum += ratio * ratio);
        }
        self.update(cycle, contact, (&beyond, &bands), &shared);
        self.replay.series.push(ReplayedCycle {
            t: cycle.t,
            torque: self.observers.seen.iter().map(|s| s.torque).collect(),
            beyond,
            band: limits,
            is_contact: contact.is_contact,
            mass: self.loads.carried().parameters[9],
        });
    }

    /// Updates load and drift.
    fn update(
        &mut self,
        cycle: &Cycle,
        contact: Contact,
        (beyond, bands): (&[f64], &[online::Band<f64>]),
        shared: &[[f64; DIRECTIONS]],
    ) {
        self.loads.begin(contact, cycle.period);
        if self.loads.is_settling() {
            self.means.fill([0.0; 2]);
        }
        for (j, joint) in cycle.joints.iter().enumerate() {
            let (band, seen) = (&bands[j], &self.observers.seen[j]);
            // If the drive cuts a torque off, the true torque is neither the measured nor the commanded one.
            if joint.is_saturated {
                self.saturated[j] += cycle.period;
                continue;
            }
            if let Some(deviation) = load_noise::deviation(band, seen.slowness) {
                let deviation = self.load_factors[j] * deviation;
                self.loads.push(&mut self.means[j], &seen.load, seen.torque, deviation, &shared[j]);
            }
            if !contact.is_contact && joint.speed.abs() > band.speed {
                let deviation = band.deviation(seen.slowness, square(&shared[j]));
                self.drifts[j].push(seen.friction[0], seen.friction[1], beyond[j], deviation);
            }
        }
        let is_changed = self.loads.end();
        let began = self.contact().map(|contact| contact.start);
        if let (Some((load, _)), Some(began)) = (self.loads.candidate(), began)
            && cycle.t - began >= EARLY_S
        {
            self.early.get_or_insert(*load);
        }
        if is_changed {
            // The load first looked like a contact. So its interval of contact is removed, and only that.
            if began.is_some() {
                self.replay.contacts.pop();
            }
            self.is_open = false;
            let began = began.unwrap_or(cycle.t);
            let load = *self.loads.carried();
            self.replay.loads.push(CarriedLoad { start: began, found: cycle.t, load, early: self.early.take() });
        }
        if let Some(last) = self.replay.loads.last_mut() {
            last.load = *self.loads.carried();
        }
    }

    /// Begins, extends or ends an interval of contact.
    fn note_contact(
        &mut self,
        cycle: &Cycle,
        contact: Contact,
        (beyond, deviations): (&[f64], &[f64]),
        ratios: &[f64],
    ) {
        // If contact outlasts the change of a load, the test of another load is a contact of its own.
        let is_new = contact.begins || (contact.is_contact && !self.is_open && self.loads.candidate().is_some());
        if is_new {
            self.replay.contacts.push(ContactInterval::new(cycle.t, cycle.joints.len()));
            self.early = None;
        }
        self.is_open = contact.is_contact && (self.is_open || is_new);
        let is_open = self.is_open;
        if let Some(interval) = self.replay.contacts.last_mut().filter(|_| is_open) {
            let is_largest = interval.extend(cycle.t, beyond, ratios, contact.last_joint);
            if is_largest && !cycle.jacobian.is_empty() {
                interval.wrench = Some(ContactWrench::new(cycle.jacobian, beyond, deviations));
            }
        }
    }

    /// The present contact; `None` without contact, and after it turned out to be a load.
    pub(crate) fn contact(&self) -> Option<&ContactInterval> {
        self.replay.contacts.last().filter(|_| self.is_open)
    }

    /// The load that would explain the present contact; see [`LoadMonitor::candidate`].
    pub(crate) fn candidate(&self) -> Option<&Load<f64>> {
        self.loads.candidate().map(|(load, _)| load)
    }

    /// The result so far, with the results of each joint.
    pub(crate) fn finish(mut self) -> Replay {
        let count = self.count.max(1) as f64;
        let bands = self.noise.bands.iter().zip(&self.drifts).zip(&self.squares).zip(&self.saturated);
        self.replay.joints = bands
            .map(|(((band, drift), square), saturated)| {
                let (change, sigma) = drift.changes();
                JointReplay {
                    noise: band.noise,
                    misfit: (square / count).sqrt(),
                    drift: change,
                    drift_sigma: sigma,
                    saturated: *saturated,
                }
            })
            .collect();
        self.replay
    }
}
