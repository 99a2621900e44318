//! Evaluates the output of the program for a situation: whether it names the true cause of the mistake, and whether its remedy
//! corrects the log.
//!
//! A finding is a line of the output that names a probable mistake with a remedy. The detection limit is the smallest size of a
//! mistake that the program states it would have found. A gross mistake must be found in any case.

use std::path::Path;

use super::Situation;
use super::kinds::{Kind, Mistake};
use super::obedience::{Step, is_of_doctor, options, renamed, steps};
use super::said::{Said, claim};
use crate::program::{Run, folder, rist};

/// An estimate is wrong if its relative torque error on another motion exceeds this.
const WRONG_TORQUE: f64 = 0.05;

/// Whether the findings of the program name the true cause of the mistake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// All findings name the true cause; or the program states that it has corrected the mistake itself.
    Right,
    /// Some findings name the true cause, others do not.
    Among,
    /// There are findings, but no finding names the true cause.
    Wrong,
    /// There are no findings, but a line states that this kind of mistake cannot be determined.
    Untold,
    /// There are no findings, and no line states that the kind cannot be determined.
    Silent,
}

/// The result after the remedies were applied.
#[derive(Clone, Copy, Debug)]
pub struct Obeyed {
    /// Whether the program accepts the changed input.
    pub accepted: bool,
    /// Whether the findings whose remedies were applied are gone.
    pub gone: bool,
    /// Whether there is no finding that was not there before.
    pub nothing_new: bool,
}

/// The output for a situation, and the result after the remedies were applied.
pub struct Outcome {
    /// Output for the log with the mistake.
    pub said: Said,
    /// Output for the log of the same machine and motion without the mistake.
    pub clean: Option<Said>,
    /// Whether the findings name the true cause.
    pub cause: Cause,
    /// Whether the mistake is gross, or larger than the detection limit that the program states.
    pub is_above: bool,
    /// The result after the remedies were applied; `None` if only a person can apply them.
    pub obeyed: Option<Obeyed>,
    /// Number of findings whose remedy only a person can apply.
    pub needs_person: usize,
    /// The remedies that were applied, and the output after that.
    pub again: String,
    /// The level of trust that `rist identify` states; `None` if it was not run or failed.
    pub trust: Option<String>,
    /// If the trust is yes: relative torque error of the estimate on another motion.
    pub left: Option<f64>,
}

impl Outcome {
    /// Whether the program trusts an estimate although the mistake makes its torques wrong.
    pub fn is_silent_yes(&self) -> bool {
        self.left.is_some_and(|left| left > WRONG_TORQUE)
    }

    /// Whether the remedies corrected the input; `None` if the program did not accept it.
    pub fn is_mended(&self) -> Option<bool> {
        self.obeyed.filter(|o| o.accepted).map(|o| o.gone && o.nothing_new)
    }
}

impl Situation<'_> {
    /// Runs `rist doctor` on the log with and without the mistake, applies the remedies and, if `identifies`, runs `rist
    /// identify`.
    pub fn outcome(&self, identifies: bool) -> Outcome {
        let log = self.write(self.mistake.is_some());
        let said = self.doctor(&log, &[]);
        // For the log of another robot there is no correct log of the same motion.
        let is_own = self.mistake.is_some_and(|m| m.kind != Kind::OtherRobot);
        let clean = is_own.then(|| self.doctor(&self.write(false), &[]));
        let cause = self.cause(&said);
        let is_gross = self.entry.is_some_and(|entry| entry.is_gross);
        let is_above = clean.as_ref().map_or(is_gross, |clean| self.is_above(clean));
        let (obeyed, needs_person, again) = self.obey(&log, &said);
        let (trust, left) = if identifies { self.trust(&log) } else { (None, None) };
        Outcome { said, clean, cause, is_above, obeyed, needs_person, again, trust, left }
    }

    fn doctor(&self, log: &Path, more: &[String]) -> Said {
        Said::of(&self.run("doctor", log, more))
    }

    fn run(&self, command: &str, log: &Path, more: &[String]) -> Run {
        let (robot, log) = (self.description().display().to_string(), log.display().to_string());
        let all = [vec![command.to_string(), robot, log], self.arm.flags(), more.to_vec()].concat();
        let words: Vec<&str> = all.iter().map(String::as_str).collect();
        rist(&folder("remedies"), &words)
    }

    /// Whether a finding names the mistake.
    pub fn is_right(&self, finding: &str) -> bool {
        let Some(entry) = self.entry else { return false };
        let joints = self.joints();
        let orders: Vec<[&str; 2]> = match joints[..] {
            [a, b] => vec![[a, b], [b, a]],
            [a] => vec![[a, ""]],
            _ => vec![["", ""]],
        };
        let says =
            |words: &str| orders.iter().any(|[a, b]| finding.contains(&words.replace("{a}", a).replace("{b}", b)));
        entry.right.iter().any(|words| says(words))
    }

    fn cause(&self, said: &Said) -> Cause {
        let right = said.findings.iter().filter(|finding| self.is_right(finding)).count();
        let topic = self.entry.map_or("", |entry| entry.topic);
        match right {
            _ if !said.is_accepted() && self.is_right(&said.error) => Cause::Right,
            _ if !said.is_accepted() => Cause::Wrong,
            0 if !said.findings.is_empty() => Cause::Wrong,
            0 if said.notes.iter().any(|line| self.is_right(line)) => Cause::Right,
            0 if said.is_untold(topic, &self.joints()) => Cause::Untold,
            0 if said.untold.iter().any(|line| self.is_right(line)) => Cause::Untold,
            0 => Cause::Silent,
            all if all == said.findings.len() => Cause::Right,
            _ => Cause::Among,
        }
    }

    /// Whether the mistake is larger than the detection limit that the program states for the correct log. If it states none for
    /// this kind, a gross mistake counts as larger. If it states that the kind cannot be determined, the mistake counts as
    /// smaller.
    fn is_above(&self, clean: &Said) -> bool {
        let Some(entry) = self.entry else { return false };
        let joints = self.joints();
        let least: Vec<Option<f64>> = match joints.is_empty() {
            true => vec![clean.least_size(entry.topic, None)],
            false => joints.iter().map(|joint| clean.least_size(entry.topic, Some(joint))).collect(),
        };
        match (self.size(), least.iter().flatten().copied().reduce(f64::min)) {
            (Some(size), Some(least)) => size >= least,
            _ => entry.is_gross,
        }
    }

    /// Applies the remedies of all findings together, and runs the program again.
    fn obey(&self, log: &Path, said: &Said) -> (Option<Obeyed>, usize, String) {
        // A remedy after "or else" is an alternative to the first one, so it is not applied.
        let first = said.findings.iter().filter(|finding| !finding.starts_with("or else "));
        let each: Vec<(&String, Vec<Step>)> = first.map(|finding| (finding, steps(finding))).collect();
        let needs_person = each.iter().filter(|(_, steps)| steps.is_empty()).count();
        let all: Vec<Step> = each.iter().flat_map(|(_, steps)| steps.clone()).collect();
        if all.is_empty() {
            return (None, needs_person, String::new());
        }
        let done = each.iter().filter(|(_, steps)| !steps.is_empty());
        let claims: Vec<String> = done.map(|(finding, _)| claim(finding)).collect();
        let known: Vec<String> = said.findings.iter().map(|finding| claim(finding)).collect();
        let refused = Obeyed { accepted: false, gone: false, nothing_new: false };
        let flags = match self.flags(&all) {
            Ok(flags) => flags,
            Err(why) => return (Some(refused), needs_person, why),
        };
        let log = self.renamed(log, &all);
        let told = all.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        if all.iter().all(is_of_doctor) {
            let again = self.doctor(&log, &flags);
            let now: Vec<String> = again.findings.iter().map(|finding| claim(finding)).collect();
            let gone = !claims.iter().any(|claim| now.contains(claim));
            let nothing_new = now.iter().all(|claim| known.contains(claim));
            let obeyed = Obeyed { accepted: again.is_accepted(), gone, nothing_new };
            return (Some(obeyed), needs_person, format!("{told}\n{}", again.whole));
        }
        let run = self.run("identify", &log, &flags);
        let reasons: Vec<String> = run.out.lines().filter_map(|line| line.strip_prefix("  - ")).map(claim).collect();
        let gone = !claims.iter().any(|claim| reasons.contains(claim));
        let obeyed = Obeyed { accepted: matches!(run.code, Some(0 | 1)), gone, nothing_new: true };
        (Some(obeyed), needs_person, format!("{told}, by identify\n{}{}", run.out, run.err))
    }

    /// The flags of the program for these actions. Options are written to a file.
    fn flags(&self, steps: &[Step]) -> Result<Vec<String>, String> {
        let mut flags = Vec::new();
        if let Some(yaml) = options(steps)? {
            let path = folder("remedies").join("options.yaml");
            std::fs::write(&path, yaml).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            flags.extend(["--options".to_string(), path.display().to_string()]);
        }
        for step in steps {
            if let Step::Flag(name, value) = step {
                flags.extend([format!("--{name}"), value.clone()]);
            }
        }
        Ok(flags)
    }

    /// Writes the log with the columns renamed as the actions require, and returns its path.
    fn renamed(&self, log: &Path, steps: &[Step]) -> std::path::PathBuf {
        let text = std::fs::read_to_string(log).unwrap_or_else(|e| panic!("{}: {e}", log.display()));
        let (header, rows) = text.split_once('\n').unwrap_or((&text, ""));
        let names = self.arm.names();
        let slides: Vec<String> = (0..self.arm.n()).filter(|&k| self.arm.slides(k)).map(|k| names[k].clone()).collect();
        let path = folder("remedies").join("again.csv");
        let text = format!("{}\n{rows}", renamed(header, steps, &slides));
        std::fs::write(&path, text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        path
    }

    /// The level of trust that `rist identify` states for the log and a second log with the same mistake. (For a single log it is
    /// never yes.) If it is yes, also the relative torque error of the estimate on a third motion.
    fn trust(&self, log: &Path) -> (Option<String>, Option<f64>) {
        let [second, judge] = [self.write_second(), self.write_judge()].map(|path| path.display().to_string());
        let estimate = folder("remedies").join("estimate.yaml").display().to_string();
        let run = self.run("identify", log, &[second, "--out".into(), estimate.clone()]);
        let trust = run.out.lines().find_map(|line| line.strip_prefix("trust: ")).map(|word| word.trim().to_string());
        // The program may say "yes" except for the units of some joints. For a wrong scale of one of these joints, such a yes is
        // not wrong.
        let said = run.out.split_whitespace().collect::<Vec<_>>().join(" ");
        let of_units = said.split_once("no factor would have").and_then(|(before, _)| before.rsplit_once("; at "));
        let is_named = |mistake: &Mistake| {
            let joint = &self.arm.names()[mistake.a];
            of_units.is_some_and(|(_, names)| names.trim().split(", ").any(|name| name == joint))
        };
        let is_said = self.mistake.as_ref().is_some_and(|m| matches!(m.kind, Kind::Scaled(_)) && is_named(m));
        if trust.as_deref() != Some("yes") || is_said {
            return (trust, None);
        }
        let judged = self.run("validate", Path::new(&estimate), &[judge]);
        let total = judged.out.lines().find_map(|line| line.strip_prefix("total "));
        // If the torque error cannot be determined, the estimate counts as completely wrong.
        let left = total.and_then(|numbers| numbers.split_whitespace().next()?.parse().ok()).unwrap_or(f64::INFINITY);
        (trust, Some(left))
    }
}
