//! Counts, for each kind of mistake, how the program answered.
//!
//! A finding names a probable mistake with a remedy. A remedy is obeyed if it can be applied automatically.

use std::collections::BTreeMap;
use std::fmt;

use super::judge::{Cause, Outcome};

#[derive(Clone, Debug, Default)]
pub struct Counts {
    /// Number of situations. `above`: number of mistakes above the detection limit.
    pub n: usize,
    pub above: usize,
    /// Numbers of situations by [`Cause`], in the order of its variants.
    pub causes: [usize; 5],
    /// Number of mistakes above the detection limit whose true cause is among the findings.
    pub above_right: usize,
    /// Number of situations with a remedy that can be applied automatically. `accepted`: number of these in which the program
    /// accepts the changed input. `gone`: number of accepted ones in which the finding is gone.
    pub obeyed: usize,
    pub accepted: usize,
    pub gone: usize,
    /// Number of accepted changes after which there is a new finding.
    pub new: usize,
    /// Number of accepted changes after which the finding is gone and there is no new one.
    pub mended: usize,
    /// Number of findings whose remedy only a person can apply.
    pub person: usize,
    /// Number of estimates that are trusted although they are wrong.
    pub silent_yes: usize,
    /// Numbers of situations by level of trust: yes, with care, no.
    pub trust: [usize; 3],
}

impl Counts {
    fn add(&mut self, outcome: &Outcome) {
        let is_right = matches!(outcome.cause, Cause::Right | Cause::Among);
        self.n += 1;
        self.above += usize::from(outcome.is_above);
        self.causes[outcome.cause as usize] += 1;
        self.above_right += usize::from(outcome.is_above && is_right);
        self.person += outcome.needs_person;
        self.silent_yes += usize::from(outcome.is_silent_yes());
        let words = ["yes", "with care", "no"];
        let said = words.iter().position(|word| outcome.trust.as_deref() == Some(word));
        said.into_iter().for_each(|place| self.trust[place] += 1);
        let Some(obeyed) = outcome.obeyed else { return };
        self.obeyed += 1;
        self.accepted += usize::from(obeyed.accepted);
        self.gone += usize::from(obeyed.accepted && obeyed.gone);
        self.new += usize::from(obeyed.accepted && !obeyed.nothing_new);
        self.mended += usize::from(outcome.is_mended() == Some(true));
    }
}

/// Counts of all situations and of each kind, and lines on the wrong outcomes.
#[derive(Default)]
pub struct Tally {
    all: Counts,
    kinds: BTreeMap<&'static str, Counts>,
    wrong: Vec<String>,
    unmended: Vec<String>,
    accused: Vec<String>,
}

impl Tally {
    pub fn add(&mut self, kind: &'static str, situation: &dyn fmt::Display, outcome: &Outcome) {
        self.all.add(outcome);
        self.kinds.entry(kind).or_default().add(outcome);
        let said = line(situation, outcome);
        if outcome.cause == Cause::Wrong || outcome.is_silent_yes() {
            self.wrong.push(said.clone());
        } else if outcome.is_above && matches!(outcome.cause, Cause::Untold | Cause::Silent) {
            self.wrong.push(format!("above its power: {said}"));
        }
        if outcome.obeyed.is_some() && outcome.is_mended() != Some(true) {
            self.unmended.push(said);
        }
        if let Some(clean) = outcome.clean.as_ref().filter(|clean| clean.code != Some(0)) {
            let what =
                if clean.findings.is_empty() { clean.error.trim().to_string() } else { clean.findings.join(" | ") };
            self.accused.push(format!("{situation}: {what}"));
        }
    }
}

pub fn line(situation: &dyn fmt::Display, outcome: &Outcome) -> String {
    let what = match outcome.cause {
        Cause::Untold => "it cannot be told".to_string(),
        _ if !outcome.said.is_accepted() => outcome.said.error.trim().replace('\n', " "),
        Cause::Right if outcome.said.findings.is_empty() => outcome.said.notes.join(" | "),
        _ if outcome.said.findings.is_empty() => "nothing".to_string(),
        _ => outcome.said.findings.join(" | "),
    };
    let above = if outcome.is_above { "above" } else { "below" };
    let obeyed = outcome.obeyed.map_or(String::new(), |o| {
        let told = outcome.again.lines().next().unwrap_or_default();
        let word = |is: bool, yes: &str, no: &str| if is { yes.to_string() } else { no.to_string() };
        let [accepted, gone, new] = [
            word(o.accepted, "accepted", "REFUSED"),
            word(o.gone, "gone", "STILL THERE"),
            word(o.nothing_new, "nothing new", "NEW CLAIM"),
        ];
        format!(" [obeyed: {accepted}, {gone}, {new}: {told}]")
    });
    let left = outcome.left.map_or(String::new(), |left| format!(", {:.1} % wrong", 100.0 * left));
    let trust = outcome.trust.as_ref().map_or(String::new(), |trust| format!(" [trust: {trust}{left}]"));
    format!("{situation} ({above}): {:?}: {what}{obeyed}{trust}", outcome.cause)
}

pub fn share(k: usize, of: usize) -> String {
    if of == 0 { "-".into() } else { format!("{k} of {of} ({:.1} %)", 100.0 * k as f64 / of as f64) }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "| kind | n | above | right | among several | wrong | cannot tell | silent | obeyed | accepted | claim gone | \
             new claim | by a person | yes, and wrong |"
        )?;
        writeln!(f, "|---{}|", "|---".repeat(13))?;
        let kinds = self.kinds.iter().map(|(name, counts)| (*name, counts));
        for (name, c) in kinds.chain([("all", &self.all)]) {
            let [right, among, wrong, untold, silent] = c.causes;
            writeln!(
                f,
                "| {name} | {} | {} | {right} | {among} | {wrong} | {untold} | {silent} | {} | {} | {} | {} | {} | {} |",
                c.n, c.above, c.obeyed, c.accepted, c.gone, c.new, c.person, c.silent_yes
            )?;
        }
        let c = &self.all;
        writeln!(f, "\nabove the power that is printed: right cause {}", share(c.above_right, c.above))?;
        writeln!(f, "obeyed: accepted {}", share(c.accepted, c.obeyed))?;
        writeln!(f, "accepted: claim gone and nothing new {}", share(c.mended, c.accepted))?;
        let [yes, with_care, no] = c.trust;
        writeln!(f, "trust: {yes} yes, {with_care} with care, {no} no")?;
        writeln!(f, "trusted, and wrong: {}", share(c.silent_yes, c.n))?;
        let lists = [("wrong, or silent above the power", &self.wrong), ("obeyed in vain", &self.unmended)];
        for (title, lines) in lists.into_iter().chain([("without the mistake, and accused", &self.accused)]) {
            writeln!(f, "\n{title} ({}):", lines.len())?;
            lines.iter().try_for_each(|line| writeln!(f, "{line}"))?;
        }
        Ok(())
    }
}
