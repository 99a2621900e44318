//! Applies the remedy of a finding automatically, exactly as it is printed.
//!
//! A remedy consists of clauses, separated by `;`. Used are the first clause that contains one of the phrases below, and the
//! following clauses that begin with `and`. All phrases in these clauses are applied:
//!
//! | phrase | action |
//! |---|---|
//! | `in the file of --options: YAML` | the YAML is merged into a file of options |
//! | `--base x`, `--gain x`, and so on | the flag is passed |
//! | `name the columns as currents`, `name the columns tau1_mNm` | the headers of the torques are changed |
//! | `say the unit in the header` | `_deg` and `_deg_s` are appended to the headers of angles |
//!
//! Other phrases, and lists that the program leaves incomplete (`..`), can be applied only by a person.

use std::fmt;

use serde_json::{Map, Value};

/// The flags that are recognised in a remedy. The flags of the description and of `rist doctor` come first.
const FLAGS: [&str; 9] = ["base", "gain", "lock", "rotor-inertia", "delay", "unknowns", "friction", "cutoff", "spring"];
/// The first flags in this list are flags of `rist doctor`. This is their number.
const OF_DOCTOR: usize = 4;

/// The text that precedes options in YAML in a remedy.
const OPTIONS: &str = "in the file of --options:";

/// One action that a remedy requires.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Options for the options file, as printed.
    Options(String),
    /// A flag and its value.
    Flag(String, String),
    /// The torque columns are renamed as currents.
    Currents,
    /// A unit is appended to the names of the torque columns.
    TorqueUnit(String),
    /// Units are appended to the names of the angle columns.
    Degrees,
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Step::Options(yaml) => write!(f, "--options with {yaml}"),
            Step::Flag(name, value) => write!(f, "--{name} {value}"),
            Step::Currents => write!(f, "tau_ named i_"),
            Step::TorqueUnit(unit) => write!(f, "tau_ named tau_.._{unit}"),
            Step::Degrees => write!(f, "q_ named q_.._deg"),
        }
    }
}

/// The actions that the remedy of a finding requires. Empty if only a person can apply it.
pub fn steps(finding: &str) -> Vec<Step> {
    let of_clause = |clause: &&str| {
        if let Some((_, yaml)) = clause.split_once(OPTIONS) {
            let is_open = yaml.contains("..");
            return if is_open { Vec::new() } else { vec![Step::Options(yaml.trim().to_string())] };
        }
        // The text after ", or" is an alternative, so it is ignored.
        let clause = clause.split(", or ").next().unwrap_or(clause);
        let mut found = Vec::new();
        if clause.contains("name the columns as currents") {
            found.push(Step::Currents);
        } else if let Some((_, unit)) = clause.split_once("name the columns tau1_") {
            found.push(Step::TorqueUnit(unit.chars().take_while(|c| c.is_alphanumeric()).collect()));
        }
        if clause.contains("say the unit in the header") {
            found.push(Step::Degrees);
        }
        found.extend(flags(clause));
        found
    };
    let clauses = clauses(finding);
    let Some(first) = clauses.iter().position(|clause| !of_clause(clause).is_empty()) else { return Vec::new() };
    let beside = clauses[first + 1..].iter().take_while(|clause| clause.starts_with(" and "));
    std::iter::once(&clauses[first]).chain(beside).flat_map(of_clause).collect()
}

/// Whether `rist doctor` accepts this action: it is no flag, or it is a flag of doctor.
pub fn is_of_doctor(step: &Step) -> bool {
    !matches!(step, Step::Flag(name, _) if !FLAGS[..OF_DOCTOR].contains(&name.as_str()))
}

/// The known flags in a clause, each with its value.
fn flags(clause: &str) -> Vec<Step> {
    let mut words = clause.split_whitespace();
    let mut found = Vec::new();
    while let Some(word) = words.next() {
        let Some(name) = word.strip_prefix("--").filter(|name| FLAGS.contains(name)) else { continue };
        let value = words.next().unwrap_or_default().trim_end_matches([',', ';', '.', ')', ':']);
        found.push(Step::Flag(name.to_string(), value.to_string()));
    }
    found
}

/// Splits a text at each `;` that is not inside brackets.
fn clauses(text: &str) -> Vec<&str> {
    let (mut depth, mut begin, mut found) = (0, 0, Vec::new());
    for (place, c) in text.char_indices() {
        match c {
            '[' | '{' => depth += 1,
            ']' | '}' => depth -= 1,
            ';' if depth <= 0 => {
                found.push(&text[begin..place]);
                begin = place + 1;
            }
            _ => {}
        }
    }
    found.push(&text[begin..]);
    found
}

/// The content of one options file with the options of all these actions; `None` if no action is an option.
///
/// Fails with the printed text if it is not valid YAML.
pub fn options(steps: &[Step]) -> Result<Option<String>, String> {
    let mut all = Value::Null;
    for step in steps {
        let Step::Options(yaml) = step else { continue };
        let value = serde_yaml::from_str::<Value>(yaml).ok().filter(Value::is_object);
        merge(&mut all, value.ok_or_else(|| format!("`{yaml}` is no file of options"))?);
    }
    // Every JSON text is also YAML.
    Ok((!all.is_null()).then(|| all.to_string()))
}

/// Merges maps key by key. All other values are replaced.
pub fn merge(all: &mut Value, more: Value) {
    match more {
        Value::Object(more) => {
            if !all.is_object() {
                *all = Value::Object(Map::new());
            }
            let Value::Object(all) = all else { return };
            for (key, value) in more {
                merge(all.entry(key).or_insert(Value::Null), value);
            }
        }
        other => *all = other,
    }
}

/// The header of a log in which the columns are renamed as the actions require. `slides`: names of the prismatic joints.
pub fn renamed(header: &str, steps: &[Step], slides: &[String]) -> String {
    let one = |column: &str| {
        let mut column = column.to_string();
        for step in steps {
            let Some((signal, joint)) = column.split_once('_').map(|(s, j)| (s.to_string(), j.to_string())) else {
                break;
            };
            match (step, signal.as_str()) {
                (Step::Currents, "tau") => column = format!("i_{joint}"),
                (Step::TorqueUnit(unit), "tau") => column = format!("tau_{joint}_{unit}"),
                (Step::Degrees, "q") if !slides.contains(&joint) => column = format!("q_{joint}_deg"),
                (Step::Degrees, "dq") if !slides.contains(&joint) => column = format!("dq_{joint}_deg_s"),
                _ => {}
            }
        }
        column
    };
    header.split(',').map(one).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_clause_with_a_step_is_obeyed() {
        let zero =
            "the zero of j2 is off: 4 %; slopes 1 -; in the file of --options: transmission: {offsets: [0, -0.5]}";
        assert_eq!(steps(zero), [Step::Options("transmission: {offsets: [0, -0.5]}".into())]);
        let mount =
            "turned: 1 %; --base 1.5,-0.4,-0.4, or in a URDF <joint name=\"mount\"/>; near: --unknowns mount finds it";
        assert_eq!(steps(mount), [Step::Flag("base".into(), "1.5,-0.4,-0.4".into())]);
        let both = "off: 1; --base 1,2,3, or in a URDF; and in the file of --options: a: {b: 1}; and see";
        assert_eq!(steps(both), [Step::Flag("base".into(), "1,2,3".into()), Step::Options("a: {b: 1}".into())]);
        let current =
            "no torques: 1; name the columns as currents (i1, ..) and give about --gain j1=2,j2=3; or the ratios";
        assert_eq!(steps(current), [Step::Currents, Step::Flag("gain".into(), "j1=2,j2=3".into())]);
        let open = "swapped: 1; in the file of --options: columns: {torque: [..]} in the order of the joints";
        assert_eq!(steps(open), []);
        assert_eq!(steps("signs: 1; change the sign of the torque columns"), []);
    }

    #[test]
    fn options_are_merged_key_by_key() {
        let of = |yaml: &str| Step::Options(yaml.into());
        let both = [of("transmission: {offsets: [0, 1]}"), of("transmission: {ratios: [1, -1]}")];
        let tree: Value = serde_json::from_str(&options(&both).unwrap().unwrap()).unwrap();
        assert!(tree["transmission"]["offsets"].is_array() && tree["transmission"]["ratios"].is_array());
        assert!(options(&[of("in the order")]).is_err());
    }

    #[test]
    fn headers_are_changed_as_they_are_told() {
        let steps = [Step::TorqueUnit("mNm".into()), Step::Degrees];
        assert_eq!(renamed("t,q_a,q_b,dq_a,tau_a", &steps, &["b".into()]), "t,q_a_deg,q_b,dq_a_deg_s,tau_a_mNm");
    }
}
