//! What is said of a situation, whether it is so, and what comes of obeying it.

use std::path::Path;

use super::Situation;
use super::kinds::{Kind, Mistake};
use super::obedience::{Step, is_of_doctor, options, renamed, steps};
use super::said::{Said, claim};
use crate::program::{Run, folder, rist};

/// An estimate is wrong that leaves more than this share of the torque on another motion.
const WRONG_TORQUE: f64 = 0.05;

/// What the findings say of the cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// All findings name it, or none is needed: the program says that it has undone it.
    Right,
    /// Some do.
    Among,
    /// None does.
    Wrong,
    /// There is none, and a line says that this cannot be told.
    Untold,
    /// Nothing is said of it.
    Silent,
}

/// What comes of obeying.
#[derive(Clone, Copy, Debug)]
pub struct Obeyed {
    /// Whether the program takes what it told to do.
    pub accepted: bool,
    /// Whether the claims that were obeyed are gone.
    pub gone: bool,
    /// Whether nothing is said that was not said before.
    pub nothing_new: bool,
}

/// What was said, and what came of it.
pub struct Outcome {
    /// Of the log with the mistake.
    pub said: Said,
    /// Of the log of the same machine and motion without it.
    pub clean: Option<Said>,
    /// What the findings say of the cause.
    pub cause: Cause,
    /// Whether the mistake is larger than what the program says it would find, or gross.
    pub is_above: bool,
    /// `None`: there is nothing that a machine can obey.
    pub obeyed: Option<Obeyed>,
    /// Findings that only a person can obey.
    pub needs_person: usize,
    /// All that was printed where it was obeyed, with what was done.
    pub again: String,
    /// What `rist identify` says of trust, where it was asked and had an answer.
    pub trust: Option<String>,
    /// Where it is yes: the share of the torque on another motion that the estimate leaves.
    pub left: Option<f64>,
}

impl Outcome {
    /// Whether an estimate is trusted that the mistake makes wrong.
    pub fn is_silent_yes(&self) -> bool {
        self.left.is_some_and(|left| left > WRONG_TORQUE)
    }

    /// Whether obeying did what it should.
    pub fn is_mended(&self) -> Option<bool> {
        self.obeyed.filter(|o| o.accepted).map(|o| o.gone && o.nothing_new)
    }
}

impl Situation<'_> {
    /// Runs `rist doctor` on the wrong and on the right log, obeys, and asks `rist identify` where `identifies`.
    pub fn outcome(&self, identifies: bool) -> Outcome {
        let log = self.write(self.mistake.is_some());
        let said = self.doctor(&log, &[]);
        // The right log of another robot is another motion.
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

    /// Whether the mistake is larger than what the program says of a right log that it would have shown. Of kinds of which it
    /// says nothing there, those that are gross are; what it says that it cannot tell is below.
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

    /// Does what the findings say, all at once, and looks again.
    fn obey(&self, log: &Path, said: &Said) -> (Option<Obeyed>, usize, String) {
        // What mends the log in place of the first is not done with it.
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

    /// The flags of steps; options stand in a file.
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

    /// The log with its columns named as the steps say.
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

    /// What `rist identify` says of trust, given the log and a second one with the same mistake (of one alone it never says yes);
    /// and where it says yes, how much of the torque on a third motion its estimate leaves.
    fn trust(&self, log: &Path) -> (Option<String>, Option<f64>) {
        let [second, judge] = [self.write_second(), self.write_judge()].map(|path| path.display().to_string());
        let estimate = folder("remedies").join("estimate.yaml").display().to_string();
        let run = self.run("identify", log, &[second, "--out".into(), estimate.clone()]);
        let trust = run.out.lines().find_map(|line| line.strip_prefix("trust: ")).map(|word| word.trim().to_string());
        // A yes in units that may be wrong at the joints that it names is no silent one at these.
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
        // An estimate that cannot be judged is as wrong as can be.
        let left = total.and_then(|numbers| numbers.split_whitespace().next()?.parse().ok()).unwrap_or(f64::INFINITY);
        (trust, Some(left))
    }
}
