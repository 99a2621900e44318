//! The options (request) of `rist generate`, which writes source code with functions of a robot.
//!
//! A request is a struct with all options of a command; each field is one option. The monitor is generated C code that computes
//! external torques, contact and the load.

use std::path::PathBuf;

use modeling::RobotFunction;

use super::Range;

/// Names by which a user requests the monitor: external torque and contact, and the load.
pub(crate) const MONITOR: [&str; 2] = ["observer", "payload"];

impl GenerateRequest {
    /// Whether the functions contain the observer of external torques, or the load.
    pub fn has_monitor(&self) -> bool {
        self.functions.iter().any(|name| MONITOR.contains(&name.as_str()))
    }
}

words! {
    /// The languages in which source can be generated.
    pub enum SourceLanguage {
        /// A single source file.
        Rust = "rust" "One file, no_std, generic over f64, f32 and numbers of your own",
        /// A source file and a header.
        C = "c" "C99: a header and a source file that need math.h",
    }
}

request! {
    /// Options for generated source code.
    pub struct GenerateRequest {
        /// Functions beside base-regressor: controller (gravity compensation, feedforward and computed torque, with limits), observer and payload (external torque, contact and load; C),
        functions: Vec<String> = Vec::new(), value_name("NAMES"), and(&function_names());
        /// An estimate of this model: its numbers stand in the file as the constants X and F.
        estimate: Option<PathBuf> = None, value_name("ESTIMATE");
        /// Take the numbers even of an estimate whose verdict is no.
        anyway: bool = false;
        /// Lengths, angles and components of gravity that stay open, as an argument `symbols` of all functions: `all`, or
        /// these; a number without a name is called by its place, as d3, r4, alpha5, gz [default: none].
        symbols: Vec<String> = Vec::new(), value_name("NAMES");
        /// Rate of the control loop of an observer, Hz.
        rate: f64 = 1000.0, range(1.0..=1e5), value_name("HZ");
        /// For an observer, logs without contact, in which its noise is measured [default: the logs of the estimate].
        reference: Vec<PathBuf> = Vec::new(), value_name("LOGS");
        /// False alarms an hour of an observer that are accepted.
        alarms: f64 = 1.0, range(Range::Positive), value_name("PER_HOUR");
        /// Gain of an observer, 1/s.
        observer_gain: f64 = 50.0, range(0.1..=1e4), value_name("GAIN");
        /// Link or frame that carries the load of an observer [default: the last link].
        load_on: Option<String> = None, value_name("LINK");
        /// Largest mass of this load, kg.
        largest_load: f64 = 10.0, range(Range::Positive), value_name("KG");
        /// Language to write.
        language: SourceLanguage = SourceLanguage::Rust;
    }
}

/// A list of all function names except the base regressor, for messages: `regressor, ..., pose=LINK`.
pub fn function_names() -> String {
    let name = |(word, of_link)| if of_link { format!("{word}=LINK") } else { String::from(word) };
    let mut names: Vec<String> = RobotFunction::words().skip(1).map(name).collect();
    let last = names.pop().unwrap_or_default();
    format!("{} and {last}", names.join(", "))
}
