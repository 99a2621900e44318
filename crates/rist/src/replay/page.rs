//! The HTML page of a replay (the observer of external torques, run over a log).
//!
//! A span is a short time interval; a line has its smallest and its largest value in every span.

use identification::plot_data::envelope::Envelope;
use report::identification::Origin;
use report::replay::{JointTorque, ReplayPage};

use crate::replay::artefact::Replay;
use crate::request::spelling::{Audience, spelled};

/// Largest number of time spans of a line on the page.
const MOST_SPANS: usize = 4000;

impl Replay {
    /// The page as HTML. `reader`: the kind of reader, for whom names of options are spelled.
    pub fn page(&self, origin: Origin, reader: Audience) -> String {
        let contacts = self.contacts.iter().map(|contact| {
            let name = |joint: usize| self.coordinates[joint].clone();
            let torque = format!("{:+.3} {}", contact.torque, self.units[contact.joint]);
            let time = format!("{:.3} to {:.3}", contact.start, contact.end);
            [time, torque, name(contact.joint), name(contact.last_joint)]
        });
        let loads = self.loads.iter().map(|load| {
            let (mass, centre) = load.texts();
            [format!("{:.3}", load.start), mass, centre.unwrap_or_else(|| "not determined".into())]
        });
        let joints = self.joints.iter().zip(&self.coordinates).zip(&self.units).map(|((joint, name), unit)| {
            [name.clone(), format!("{:.4} {unit}", joint.noise), format!("{:.2}", joint.misfit), joint.drift_text()]
        });
        let line = |value: &dyn Fn(usize) -> f64| {
            let mut line = Envelope::of_spans(MOST_SPANS);
            self.series.iter().enumerate().for_each(|(i, cycle)| line.push(cycle.t, value(i)));
            line
        };
        let torques = self.coordinates.iter().zip(&self.units).enumerate().map(|(j, (name, unit))| JointTorque {
            name: name.clone(),
            unit: (*unit).into(),
            torque: line(&|i| self.series[i].beyond[j]),
            // The band is symmetric: without contact, `beyond` lies between -band and band.
            limits: [-1.0, 1.0].map(|sign| line(&|i| sign * self.series[i].band[j])),
        });
        let page = ReplayPage {
            log: &self.log,
            settings: self.settings(),
            contacts: contacts.collect(),
            loads: loads.collect(),
            load_on: &self.load_on,
            joints: joints.collect(),
            torques: torques.collect(),
            mass: line(&|i| self.series[i].mass),
            borders: self.contacts.iter().flat_map(|contact| [contact.start, contact.end]).collect(),
            facts: origin.facts(),
        };
        spelled(&page.html(), reader)
    }
}
