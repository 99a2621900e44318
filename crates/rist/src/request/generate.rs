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
        Rust = "rust" "One file, no_std, generic over f64, f32 and your own types of numbers",
        /// A source file and a header.
        C = "c" "C99: a header and a source file that need math.h",
    }
}

request! {
    /// Options for generated source code.
    pub struct GenerateRequest {
        /// Functions in addition to base-regressor: controller (gravity compensation, feedforward and computed torque, with
        /// limits); in C also observer (external torque and contact) and payload (load);
        functions: Vec<String> = Vec::new(), value_name("NAMES"), and(&function_names());
        /// An estimate of this model. It gives the constants X (base parameters) and F (friction) of the source.
        estimate: Option<PathBuf> = None, value_name("ESTIMATE");
        /// Use the estimate even if its verdict is no. Otherwise the estimate is refused.
        anyway: bool = false;
        /// Lengths, angles and components of gravity that are not fixed, but given in an argument `symbols` of all functions:
        /// `all`, or a list of names. A number without a name is called by its place, such as d3, r4, alpha5, gz [default:
        /// none].
        symbols: Vec<String> = Vec::new(), value_name("NAMES");
        /// Rate of the control loop in which an observer runs, Hz.
        rate: f64 = 1000.0, range(1.0..=1e5), value_name("HZ");
        /// For an observer: logs without contact, from which its noise is measured [default: the logs of the estimate].
        reference: Vec<PathBuf> = Vec::new(), value_name("LOGS");
        /// For an observer: accepted number of false alarms per hour.
        alarms: f64 = 1.0, range(Range::Positive), value_name("PER_HOUR");
        /// Gain of an observer of external torques, 1/s.
        observer_gain: f64 = 50.0, range(0.1..=1e4), value_name("GAIN");
        /// For an observer: link or frame with a load [default: the last link].
        load_on: Option<String> = None, value_name("LINK");
        /// For an observer: largest possible mass of a load, kg.
        largest_load: f64 = 10.0, range(Range::Positive), value_name("KG");
        /// Language of the source.
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
