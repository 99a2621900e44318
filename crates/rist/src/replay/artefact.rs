//! The result of a replay (the observer of external torques, run over a log), as a table, as CSV and as JSON.
//!
//! A cycle is one sample of the log, as a controller would process it. The external torque of a joint is computed by the
//! observer;
//! `beyond` is the external torque minus the torque of the carried load. The band of a joint is the largest value of `beyond`
//! without contact. The ratio is `beyond` divided by its standard deviation. The drift is the change of friction since the
//! identification: FV viscous, FS Coulomb, OFF offset.

use std::fmt;

use online::{Load, possible};
use serde_json::{Value, json};

use crate::replay::wrench::ContactWrench;

/// An interval of contact.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactInterval {
    /// Time at which contact was detected, s.
    pub start: f64,
    /// Time of the last cycle of contact, s.
    pub end: f64,
    /// Index of the joint with the largest external torque relative to its standard deviation.
    pub joint: usize,
    /// Largest external torque of this joint, N m (N).
    pub torque: f64,
    /// Index of the last joint with a significant torque at that time: this joint or a later one moves the touched link.
    pub last_joint: usize,
    /// Force and moment at the largest ratio, if a link was assumed to be touched.
    pub wrench: Option<ContactWrench>,
    /// The largest ratio of torque to standard deviation.
    ratio: f64,
    /// Largest external torque of each joint.
    torques: Vec<f64>,
}

impl ContactInterval {
    pub(crate) fn new(start: f64, joints: usize) -> ContactInterval {
        let torques = vec![0.0; joints];
        let (joint, last_joint, wrench) = (0, 0, None);
        ContactInterval { start, end: start, joint, torque: 0.0, last_joint, wrench, ratio: 0.0, torques }
    }

    /// Adds a cycle of contact. Returns whether it has the largest ratio so far.
    pub(crate) fn extend(&mut self, t: f64, torques: &[f64], ratios: &[f64], last_joint: Option<usize>) -> bool {
        self.end = t;
        let before = self.ratio;
        for (joint, (torque, ratio)) in torques.iter().zip(ratios).enumerate() {
            if torque.abs() > self.torques[joint].abs() {
                self.torques[joint] = *torque;
            }
            if ratio.abs() > self.ratio {
                (self.joint, self.ratio) = (joint, ratio.abs());
                self.last_joint = last_joint.unwrap_or(joint).max(joint);
            }
        }
        self.torque = self.torques[self.joint];
        self.ratio > before
    }
}

/// A load that the robot carries from a time on.
#[derive(Clone, Debug, PartialEq)]
pub struct CarriedLoad {
    /// Time at which the torque of the load began, s.
    pub start: f64,
    /// Time at which it was distinguished from contact, s.
    pub found: f64,
    /// The parameters of the load at the end of the interval. A mass of about zero means that the load was put down.
    pub load: Load<f64>,
    /// The estimate [`EARLY_S`] after `start`, when it was still under test; `None` if the log has a gap there.
    pub early: Option<Load<f64>>,
}

/// Time after the start of a load at which [`CarriedLoad::early`] is taken, s.
pub const EARLY_S: f64 = 0.5;

/// The note for a reference of one log. Errors of the model depend on the posture, and one log shows too few postures.
pub const ONE_LOG: &str = "the noise is from one log: in other postures, errors of the model may cause more false alarms; identify \
     with logs of several motions, or give such logs as [reference]";

impl CarriedLoad {
    /// Mass, kg, and its standard deviation.
    pub fn mass(&self) -> (f64, f64) {
        (self.load.parameters[9], self.load.sigma[9])
    }

    /// Whether the mass is significant, at 95 %.
    pub fn is_held(&self) -> bool {
        let (mass, sigma) = self.mass();
        mass > identification::estimate::identified::INTERVAL * sigma
    }

    /// Centre of mass in the load's frame, m; `None` for a component that the motion does not determine, or without a load.
    pub fn centre(&self) -> [Option<f64>; 3] {
        let load = &self.load;
        let is_known = |k: usize| self.is_held() && load.is_determined[6 + k] && load.is_determined[9];
        [0, 1, 2].map(|k| is_known(k).then(|| load.parameters[6 + k] / load.parameters[9]))
    }

    /// The mass, and the centre of mass if the motion determines a part of it, as text.
    pub(crate) fn texts(&self) -> (String, Option<String>) {
        let ((mass, sigma), word) = (self.mass(), if self.is_held() { "carried" } else { "put down" });
        let centre = self.centre();
        let shown = centre.map(|c| c.map_or("not determined".into(), |c| format!("{c:.4}"))).join(" ");
        (format!("{word}: {mass:.4} +- {sigma:.4} kg"), centre.iter().any(Option::is_some).then_some(shown))
    }
}

/// The result of a replay for one joint.
#[derive(Clone, Debug, PartialEq)]
pub struct JointReplay {
    /// Standard deviation of the observer's torque at speed, N m (N).
    pub noise: f64,
    /// RMS of the ratio (external torque divided by its standard deviation) in cycles without contact. It is 1 if the model
    /// fits this log as well as the logs in which the noise was measured.
    pub misfit: f64,
    /// Changes of FV, N m s/rad, FS and OFF, N m, since the identification.
    pub drift: [f64; 3],
    /// Standard deviations of the changes. They include the standard deviations of the parameters in the estimate.
    pub drift_sigma: [f64; 3],
    /// Time during which the torque of the motor was at the effort limit, s. During this time, the external torque is not
    /// known.
    pub saturated: f64,
}

/// The RMS ratio of a joint above which the model does not fit the robot any more.
const LARGEST_MISFIT: f64 = 2.0;

/// A drift is named if it exceeds this many standard deviations. The number is three and not two, because three parameters of
/// every joint are tested.
const SIGNIFICANT_DRIFT: f64 = 3.0;

impl JointReplay {
    /// Whether the estimate does not describe the robot of this log any more.
    pub fn is_outdated(&self) -> bool {
        self.misfit > LARGEST_MISFIT
    }

    /// Which of FV, FS and OFF have changed significantly.
    pub fn drifted(&self) -> impl Iterator<Item = usize> {
        (0..3).filter(|&k| self.drift[k].abs() > SIGNIFICANT_DRIFT * self.drift_sigma[k])
    }

    /// The significant drifts, whether to identify anew, and the time of saturation, as text.
    pub(crate) fn drift_text(&self) -> String {
        let drifted =
            self.drifted().map(|k| format!("{} {:+.4} +- {:.4}", FRICTION[k], self.drift[k], self.drift_sigma[k]));
        let drifted: Vec<String> = drifted.collect();
        let text = if drifted.is_empty() { "not significant".into() } else { drifted.join(", ") };
        let text = if self.is_outdated() { format!("{text}; the model no longer fits: identify anew") } else { text };
        match self.saturated > 0.0 {
            true => format!("{text}; external torque unknown for {:.3} s, at the limit of the effort", self.saturated),
            false => text,
        }
    }
}

/// One cycle of a replay.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplayedCycle {
    /// Time, s.
    pub t: f64,
    /// External torque of each joint, N m (N). It contains the torque of the load.
    pub torque: Vec<f64>,
    /// External torque of each joint minus the torque of the load, N m (N).
    pub beyond: Vec<f64>,
    /// For each joint, the limit for a contact: contact is reported if the external torque minus the torque of the load
    /// exceeds this value, N m (N).
    pub band: Vec<f64>,
    /// Whether there is contact.
    pub is_contact: bool,
    /// Mass of the carried load, kg.
    pub mass: f64,
}

/// The result of a replay.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// Name of the log.
    pub log: String,
    /// Names of the coordinates.
    pub coordinates: Vec<String>,
    /// Unit of the torque of each coordinate, N m or N.
    pub units: Vec<&'static str>,
    /// Names of the logs in which the noise was measured.
    pub reference: Vec<String>,
    /// Accepted false alarms an hour.
    pub alarms_per_hour: f64,
    /// Threshold of contact, standard deviations.
    pub threshold: f64,
    /// Whether the bands contain the uncertainty of the parameters. This needs an estimate with its covariance.
    pub has_covariance: bool,
    /// The link that carries the load.
    pub load_on: String,
    /// The link that is assumed to be touched.
    pub wrench_on: Option<String>,
    /// Intervals of contact, in the order of time.
    pub contacts: Vec<ContactInterval>,
    /// Changes of the load, in the order of time.
    pub loads: Vec<CarriedLoad>,
    /// One entry per coordinate.
    pub joints: Vec<JointReplay>,
    /// All cycles.
    pub series: Vec<ReplayedCycle>,
}

/// Names of the parameters of friction, in the order of a drift.
const FRICTION: [&str; 3] = ["FV", "FS", "OFF"];

impl Replay {
    pub(crate) fn new(log: String, coordinates: Vec<String>, units: Vec<&'static str>, threshold: f64) -> Replay {
        Replay {
            log,
            coordinates,
            units,
            reference: Vec::new(),
            alarms_per_hour: 0.0,
            threshold,
            has_covariance: false,
            load_on: String::new(),
            wrench_on: None,
            contacts: Vec::new(),
            loads: Vec::new(),
            joints: Vec::new(),
            series: Vec::new(),
        }
    }

    /// Sentences on the threshold, and on what the bands do not contain.
    pub(crate) fn settings(&self) -> Vec<String> {
        let threshold = format!(
            "contact from {:.2} standard deviations; accepted false alarms an hour: {}; noise from {}",
            self.threshold,
            self.alarms_per_hour,
            self.reference.join(", ")
        );
        let lack = "the bands lack the uncertainty of the parameters: identify with [covariance=true]";
        let notes = [(!self.has_covariance).then_some(lack), (self.reference.len() == 1).then_some(ONE_LOG)];
        std::iter::once(threshold).chain(notes.into_iter().flatten().map(String::from)).collect()
    }

    /// All cycles as CSV: `t`, the external torque and the band of each joint, `contact` (0 or 1), `mass`.
    pub fn to_csv(&self) -> String {
        let names = self.coordinates.iter().flat_map(|name| [format!("tau_ext_{name}"), format!("band_{name}")]);
        let head: Vec<String> =
            std::iter::once("t".into()).chain(names).chain(["contact".into(), "mass".into()]).collect();
        let mut text = head.join(",") + "\n";
        for cycle in &self.series {
            let pairs = cycle.torque.iter().zip(&cycle.band).map(|(torque, band)| format!(",{torque:.6},{band:.6}"));
            text += &format!("{:.6}{}", cycle.t, pairs.collect::<String>());
            text += &format!(",{},{:.6}\n", u8::from(cycle.is_contact), cycle.mass);
        }
        text
    }

    /// The result without the cycles, as JSON.
    pub fn to_json(&self) -> Value {
        let name = |joint: usize| self.coordinates[joint].as_str();
        let contacts = self.contacts.iter().map(|c| {
            json!({
                "start": c.start, "end": c.end, "joint": name(c.joint), "torque": c.torque, "last_joint": name(c.last_joint),
                "wrench": c.wrench.as_ref().map(|w| json!({"components": w.components, "sigma": w.sigma, "misfit": w.misfit})),
            })
        });
        // The estimated parameters may be impossible for a rigid body. `possible` is the possible body with the same mass and
        // first moment, or zeros if the mass is not positive.
        let loads = self.loads.iter().map(|l| {
            let (mass, sigma) = l.mass();
            json!({
                "start": l.start, "found": l.found, "mass": mass, "sigma": sigma, "centre_of_mass": l.centre(),
                "parameters": l.load.parameters, "parameter_sigma": l.load.sigma, "determined": l.load.is_determined,
                "possible": possible(&l.load.parameters), "is_held": l.is_held(),
            })
        });
        let joints = self.joints.iter().zip(&self.coordinates).map(|(joint, name)| {
            json!({
                "name": name, "noise": joint.noise, "misfit": joint.misfit, "is_outdated": joint.is_outdated(),
                "saturated": joint.saturated,
                "drift": FRICTION.iter().zip(joint.drift.iter().zip(&joint.drift_sigma)).map(|(name, (value, sigma))| {
                    (name.to_string(), json!({"value": value, "sigma": sigma}))
                }).collect::<serde_json::Map<String, Value>>(),
            })
        });
        json!({
            "log": self.log, "reference": self.reference, "alarms_per_hour": self.alarms_per_hour,
            "threshold": self.threshold, "has_covariance": self.has_covariance, "load_on": self.load_on,
            "wrench_on": self.wrench_on,
            "contacts": contacts.collect::<Vec<_>>(), "loads": loads.collect::<Vec<_>>(), "joints": joints.collect::<Vec<_>>(),
        })
    }
}

impl fmt::Display for Replay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (first, last) = (self.series.first().map_or(0.0, |c| c.t), self.series.last().map_or(0.0, |c| c.t));
        writeln!(f, "{}: {} cycles in {:.2} s", self.log, self.series.len(), last - first)?;
        self.settings().iter().try_for_each(|sentence| writeln!(f, "{sentence}"))?;
        writeln!(f, "\ncontact: {}", if self.contacts.is_empty() { "none" } else { "" })?;
        // A force on a link causes torques only at the joints before the link. So the touched link is at or beyond the last
        // joint with a significant torque.
        for contact in &self.contacts {
            writeln!(
                f,
                "  {:9.3} .. {:9.3} s  {:+.3} {} at {}; the touched link is moved by {}, or lies beyond it",
                contact.start,
                contact.end,
                contact.torque,
                self.units[contact.joint],
                self.coordinates[contact.joint],
                self.coordinates[contact.last_joint]
            )?;
            // Force and moment are valid only if the link that the user assumed is the touched link.
            if let (Some(wrench), Some(link)) = (&contact.wrench, &self.wrench_on) {
                writeln!(f, "      if it is {link}: {}", wrench.text())?;
            }
        }
        writeln!(f, "\nload on {}: {}", self.load_on, if self.loads.is_empty() { "none" } else { "" })?;
        for load in &self.loads {
            let (mass, centre) = load.texts();
            write!(f, "  from {:9.3} s  {mass}", load.start)?;
            writeln!(f, "{}", centre.map_or(String::new(), |centre| format!(", centre of mass {centre} m")))?;
        }
        writeln!(f, "\n{:<12} {:>10} {:>8}  drift of friction since the identification", "joint", "noise", "misfit")?;
        for ((joint, name), unit) in self.joints.iter().zip(&self.coordinates).zip(&self.units) {
            let noise = format!("{:.4} {unit}", joint.noise);
            writeln!(f, "{name:<12} {noise:>10} {:>8.2}  {}", joint.misfit, joint.drift_text())?;
        }
        Ok(())
    }
}
