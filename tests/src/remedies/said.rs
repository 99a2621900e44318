//! Parses the output of the program for a log.
//!
//! A finding names a probable mistake. Other lines state properties that agree, or properties that cannot be determined.

use crate::program::Run;

/// The parsed output of `rist doctor`.
#[derive(Clone, Debug, Default)]
pub struct Said {
    /// The exit code: 1 if there are findings, 2 if the log or an option is refused.
    pub code: Option<i32>,
    /// The findings, one line each.
    pub findings: Vec<String>,
    /// The lines on properties of the log that agree with the description. `untold`: the lines on properties that cannot be
    /// determined.
    pub agrees: Vec<String>,
    pub untold: Vec<String>,
    /// All other lines: assumptions and corrections that the program makes itself.
    pub notes: Vec<String>,
    pub whole: String,
    pub error: String,
}

impl Said {
    /// Parses the output of `rist doctor`. The findings come after the table of the joints, and before the lines on properties
    /// that agree. The error message states the number of findings.
    pub fn of(run: &Run) -> Said {
        let is_table = |line: &&str| !(line.starts_with("joint ") && line.contains("slope"));
        let behind = run.out.lines().skip_while(is_table).skip_while(|line| !line.trim().is_empty());
        let lines: Vec<&str> = behind.filter(|line| !line.trim().is_empty()).collect();
        let starting = |word: &str| -> Vec<String> {
            lines.iter().filter(|line| line.starts_with(word)).map(|line| line.to_string()).collect()
        };
        let counted = run.err.lines().find_map(|line| line.strip_prefix("rist: ")?.split_once(" finding"));
        let count = counted.and_then(|(number, _)| number.parse::<usize>().ok()).unwrap_or(0);
        let (agrees, untold) = (starting("agrees: "), starting("cannot tell: "));
        let behind = lines.iter().skip(count).map(|line| line.to_string());
        let notes = behind.filter(|line| !agrees.contains(line) && !untold.contains(line)).collect();
        Said {
            code: run.code,
            findings: lines.iter().take(count).map(|line| line.to_string()).collect(),
            agrees,
            untold,
            notes,
            whole: format!("{}{}", run.out, run.err),
            error: run.err.clone(),
        }
    }

    /// Whether the program accepted the log.
    pub fn is_accepted(&self) -> bool {
        matches!(self.code, Some(0 | 1))
    }

    /// The detection limit for a topic at a joint, from lines such as `agrees: zero of j2; 20 deg would have shown`. If `joint`
    /// is `None`: the smallest limit for the topic.
    pub fn least_size(&self, topic: &str, joint: Option<&str>) -> Option<f64> {
        let of_line = |line: &String| {
            let (subject, shown) = line.strip_prefix("agrees: ")?.split_once("; ")?;
            let is_of = subject.starts_with(topic) && joint.is_none_or(|joint| names(subject, joint));
            let number = shown.split_whitespace().next()?.parse::<f64>().ok()?;
            is_of.then_some(number.abs())
        };
        self.agrees.iter().filter_map(of_line).min_by(f64::total_cmp)
    }

    /// Whether a line states that a topic cannot be determined, for one of these joints if any are given.
    pub fn is_untold(&self, topic: &str, joints: &[&str]) -> bool {
        let is_of = |line: &String| {
            let subject = line.strip_prefix("cannot tell: ").unwrap_or_default();
            subject.starts_with(topic) && (joints.is_empty() || joints.iter().any(|joint| names(subject, joint)))
        };
        self.untold.iter().any(is_of)
    }
}

/// Whether a text contains the name of a joint as a separate word.
pub fn names(text: &str, joint: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(joint).any(|(place, _)| {
        let before = text[..place].chars().next_back().is_some_and(is_part);
        let behind = text[place + joint.len()..].chars().next().is_some_and(is_part);
        !before && !behind
    })
}

/// A finding without its numbers. Two findings on the same fault of the same joint give the same text.
pub fn claim(finding: &str) -> String {
    let statement = finding.split_once(": ").map_or(finding, |(statement, _)| statement);
    let words = statement.split_whitespace().filter(|word| word.parse::<f64>().is_err());
    words.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_taken_apart() {
        let out = "log\njoint  slope\nj1  1.0\nj12  1.0\n\nthe zero of j1 is off by 30 degrees: 3 %; in a file\n\
                   cannot tell: zero of j12: little gravity\nagrees: sign of j1, j12; -1 times the torque would have shown\n";
        let said = Said::of(&Run { code: Some(1), out: out.into(), err: "rist: 1 finding\n".into(), ..Run::default() });
        assert_eq!(said.findings.len(), 1);
        assert_eq!(claim(&said.findings[0]), "the zero of j1 is off by degrees");
        assert_eq!(said.least_size("sign", Some("j1")), Some(1.0));
        assert_eq!(said.least_size("sign", Some("j2")), None);
        assert!(said.is_untold("zero", &["j12"]) && !said.is_untold("zero", &["j1"]));
    }
}
