//! Writes the page of a replayed log: contact, loads, drift of friction, and the external torque of each joint with its band.
//!
//! A replay runs the observer of external torques over a log. The band of a joint contains the external torques that occur
//! without contact.

use identification::plot_data::envelope::Envelope;
use serde::Serialize;

use crate::chart::Chart;
use crate::compact::compact;
use crate::plot::Plot;
use crate::template::rendered;
use crate::timeline::Timeline;

/// The external torque of one joint over time.
#[derive(Clone, Debug)]
pub struct JointTorque {
    /// Name of the coordinate.
    pub name: String,
    /// Unit of the torque.
    pub unit: String,
    /// External torque minus the torque of the load.
    pub torque: Envelope,
    /// Lower and upper limit of the torque without contact.
    pub limits: [Envelope; 2],
}

/// The content of the page.
#[derive(Clone, Debug)]
pub struct ReplayPage<'a> {
    /// Name of the log.
    pub log: &'a str,
    /// Sentences on the settings of the replay.
    pub settings: Vec<String>,
    /// Rows of the contact table: start, end, torque, joint, touched link.
    pub contacts: Vec<[String; 4]>,
    /// Rows of the load table: start, mass, standard deviation, centre of mass.
    pub loads: Vec<[String; 3]>,
    /// The link that carries the load.
    pub load_on: &'a str,
    /// Rows of the joint table: name, noise, misfit, drift.
    pub joints: Vec<[String; 4]>,
    /// The external torque of each joint.
    pub torques: Vec<JointTorque>,
    /// Mass of the load over time, kg.
    pub mass: Envelope,
    /// Starts and ends of the intervals of contact, s.
    pub borders: Vec<f64>,
    /// Facts on the origin of the page, each with a heading and a text.
    pub facts: Vec<(&'static str, String)>,
}

const STYLE: &str = concat!(include_str!("../templates/page.css"), include_str!("../templates/chart.css"));

/// Name of the time axis, as used by the script of the page.
const TIME: &str = "replay";

#[derive(Serialize)]
struct ReplayContext<'a> {
    style: &'static str,
    script: String,
    time: &'static str,
    /// The lines as JSON, escaped so that they cannot end the script element of the page.
    lines: String,
    log: &'a str,
    settings: &'a [String],
    contacts: &'a [[String; 4]],
    loads: &'a [[String; 3]],
    load_on: &'a str,
    joints: &'a [[String; 4]],
    plots: Vec<String>,
    facts: &'a [(&'static str, String)],
}

impl ReplayPage<'_> {
    /// The page as HTML.
    pub fn html(&self) -> String {
        let scripts = [
            include_str!("../templates/dom.js"),
            include_str!("../templates/plot.js"),
            include_str!("../templates/alive.js"),
        ];
        let of_joints = self.torques.iter().enumerate().flat_map(|(k, joint)| {
            let [low, high] = &joint.limits;
            [("r", &joint.torque), ("l", low), ("u", high)].map(|(key, line)| (format!("{key}{k}"), line))
        });
        let lines = Timeline::new(of_joints.chain([("m".to_string(), &self.mass)]));
        let torques = self.torques.iter().enumerate().map(|(k, joint)| self.torque(k, joint));
        let content = ReplayContext {
            style: STYLE,
            script: scripts.into_iter().map(compact).collect(),
            time: TIME,
            lines: lines.map_or_else(|| "null".into(), |lines| lines.to_json()),
            log: self.log,
            settings: &self.settings,
            contacts: &self.contacts,
            loads: &self.loads,
            load_on: self.load_on,
            joints: &self.joints,
            plots: torques.chain((!self.loads.is_empty()).then(|| self.mass())).collect(),
            facts: &self.facts,
        };
        rendered(include_str!("../templates/replay.html"), content)
    }

    fn chart(&self, title: &str, unit: &str) -> Chart<'_> {
        let spans = self.mass.spans();
        let ends = spans.first().zip(spans.last()).map_or((0.0, 1.0), |(first, last)| (first.t, last.end));
        Chart::new(title, ("time, s", unit)).with_zero().borders(self.borders.clone()).low().wide(ends)
    }

    fn torque(&self, k: usize, joint: &JointTorque) -> String {
        let caption = format!("External torque of {}, and its limits without contact", joint.name);
        let names = [("u", "c", "upper limit"), ("l", "c", "lower limit"), ("r", "a", "external torque")];
        let [low, high] = &joint.limits;
        let chart = self.chart(&caption, &joint.unit);
        let chart = [high, low, &joint.torque]
            .into_iter()
            .zip(names)
            .fold(chart, |chart, (line, (_, class, name))| chart.envelope(name, class, line));
        let legend: Vec<_> = names.map(|(key, class, name)| (format!("{key}{k}"), class, name.to_string())).into();
        let keys = legend.iter().map(|(key, _, _)| key.clone()).collect();
        Plot { time: TIME, caption, legend, svgs: vec![chart.live(keys).svg()] }.html()
    }

    fn mass(&self) -> String {
        let caption = format!("Mass on {}", self.load_on);
        let chart = self.chart(&caption, "kg").envelope("mass", "b", &self.mass).live(vec!["m".into()]);
        let legend = vec![("m".to_string(), "b", "mass".to_string())];
        Plot { time: TIME, caption, legend, svgs: vec![chart.svg()] }.html()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_holds_tables_and_lines() {
        let line = |scale: f64| {
            let mut line = Envelope::default();
            (0..100).for_each(|i| line.push(0.01 * f64::from(i), scale * f64::from(i % 10)));
            line
        };
        let limits = [line(-1.0), line(1.0)];
        let joint = JointTorque { name: "<j1>".into(), unit: "N m".into(), torque: line(0.5), limits };
        let page = ReplayPage {
            log: "a<b.csv",
            settings: vec!["noise from c.csv".into()],
            contacts: vec![["1.000 to 2.000".into(), "+3.0 N m".into(), "<j1>".into(), "<j1>".into()]],
            loads: Vec::new(),
            load_on: "tool",
            joints: vec![["<j1>".into(), "0.1 N m".into(), "1.00".into(), "not significant".into()]],
            torques: vec![joint],
            mass: line(0.1),
            borders: vec![0.2, 0.4],
            facts: vec![("command", "rist replay".into())],
        };
        let html = page.html();
        assert!(html.starts_with("<!doctype html>") && !html.contains("could not be made"), "{html}");
        assert!(html.contains("a&lt;b.csv") && !html.contains("<j1>"), "{html}");
        assert_eq!(html.matches("class=\"border\"").count(), 2, "two borders in one chart; there is no load");
        assert!(html.contains("data-curve=\"r0\"") && html.contains("id=\"time-replay\""));
        assert!(html.contains("No load was found.") && !html.contains("No contact was found."));
    }
}
