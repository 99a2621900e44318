//! Counts the outcomes of situations.
//!
//! A situation is good if the estimate is accurate, so the program should trust it. "As logged" means: in the unit of the
//! logged torques, which may have a common wrong scale.

use std::collections::BTreeMap;
use std::fmt;

use rist::fit::verdict::Trust;

use super::Situation;
use super::judge::Outcome;

#[derive(Clone, Debug, Default)]
pub struct Counts {
    pub situations: usize,
    pub yes: usize,
    pub with_care: usize,
    pub no: usize,
    /// Number of situations in which the program ended with an error.
    pub errors: usize,
    /// Number of "yes" answers with a torque error of more than 5 % on another motion.
    pub yes_torque: usize,
    /// Number of "yes" answers with a torque error of more than 5 % also in the unit of the logged torques.
    pub yes_as_logged: usize,
    /// Number of "yes" answers with an error of more than 5 % in the torque of the bodies.
    pub yes_bodies: usize,
    /// Number of "yes" answers with an error of more than five standard deviations in a parameter.
    pub yes_sigma: usize,
    /// Number of "yes" answers with an error of more than five standard deviations also in the unit of the logged torques.
    pub yes_sigma_as_logged: usize,
    /// Number of good situations: torque within 2 %, all parameters within four standard deviations, and both logs of the same
    /// machine.
    pub good: usize,
    pub good_no: usize,
    pub good_with_care: usize,
}

impl Counts {
    fn add(&mut self, situation: &Situation, outcome: &Outcome) {
        self.situations += 1;
        match outcome.trust {
            Some(Trust::Yes) => self.yes += 1,
            Some(Trust::WithCare) => self.with_care += 1,
            Some(Trust::No) => self.no += 1,
            None => self.errors += 1,
        }
        if outcome.is_yes() {
            self.yes_torque += usize::from(outcome.predicts_wrong());
            self.yes_as_logged += usize::from(outcome.predicts_wrong_as_logged());
            self.yes_bodies += usize::from(outcome.bodies_wrong());
            self.yes_sigma += usize::from(outcome.is_oversure());
            self.yes_sigma_as_logged += usize::from(outcome.is_oversure_as_logged());
        }
        if outcome.is_good() && !situation.changes() {
            self.good += 1;
            self.good_no += usize::from(outcome.trust == Some(Trust::No));
            self.good_with_care += usize::from(outcome.is_with_care());
        }
    }
}

/// Counts of all situations, by number of logs, and by defect.
#[derive(Default)]
pub struct Tally {
    groups: BTreeMap<(usize, String), Counts>,
    false_yes: Vec<String>,
    /// Good situations that the program does not trust, each with the first reason of the program.
    doubted: Vec<String>,
}

impl Tally {
    pub fn add(&mut self, situation: &Situation, outcome: &Outcome) {
        let logs = situation.motions.len();
        let mut groups = vec![(0, "all".to_string()), (1, if logs == 1 { "one log" } else { "two logs" }.to_string())];
        groups.push((2, format!("description {}", situation.machine.description)));
        // Some answers "yes" hold only in the unit of the logged torques, because a common factor of all torques cannot be
        // detected.
        let names_units = |reason: &String| reason.starts_with("in the units of the torques as logged");
        if let Some(verdict) = outcome.verdict.as_ref().filter(|_| outcome.is_yes()) {
            let told = if verdict.reasons.iter().any(names_units) { "up to units" } else { "of units too" };
            groups.push((1, format!("yes, {told}")));
        }
        groups.push((3, if situation.defects.is_empty() { "clean" } else { "with a defect" }.to_string()));
        groups.extend(situation.defects.iter().map(|d| (4, format!("{:?}", d.kind))));
        let name = &situation.machine.name;
        let machine = ["gantry", "scara", "two_arms"].into_iter().find(|kind| name.starts_with(kind));
        let alone = situation.motions.iter().all(|m| m.said.ends_with("alone")).then_some("one joint moves");
        groups.extend(machine.into_iter().chain(alone).map(|group| (5, group.to_string())));
        for group in groups {
            self.groups.entry(group).or_default().add(situation, outcome);
        }
        if outcome.is_yes() && (outcome.predicts_wrong() || outcome.bodies_wrong() || outcome.is_oversure()) {
            self.false_yes.push(line(situation, outcome));
        }
        if outcome.is_good() && !outcome.is_yes() && !situation.changes() {
            let reason = outcome.verdict.as_ref().and_then(|v| v.reasons.first()).map_or("", String::as_str);
            self.doubted.push(format!("{}\n    {reason}", line(situation, outcome)));
        }
    }

    /// The counts of a group: `all`, `one log`, `two logs`, or the name of a defect.
    pub fn counts(&self, name: &str) -> Counts {
        let found = self.groups.iter().find(|((_, group), _)| group == name);
        found.map_or_else(Counts::default, |(_, counts)| counts.clone())
    }
}

pub fn line(situation: &Situation, outcome: &Outcome) -> String {
    let defects: Vec<String> = situation.defects.iter().map(ToString::to_string).collect();
    let trust = outcome.trust.map_or("error", Trust::word);
    let figures = outcome.judgement.as_ref().map_or(String::new(), |j| {
        let (joint, of_joint) = &j.worst_joint;
        let (parameter, sigma) = &j.worst_sigma;
        format!(
            "torque {:.2} % ({:.2} % as logged; {joint} {:.1} %), bodies {:.2} %, {parameter} {sigma:.1} sigma ({:.1} as logged){}",
            100.0 * j.torque,
            100.0 * j.as_logged,
            100.0 * of_joint,
            100.0 * j.rigid,
            j.worst_sigma_as_logged.1,
            if j.unsaid > 0 { " (rotors left out)" } else { "" }
        )
    });
    let (logs, name) = (situation.motions.len(), &situation.machine.name);
    let description = situation.machine.description;
    format!("seed {} {name}, {description}, {logs} log: {trust}: {figures}; {}", situation.seed, defects.join(", "))
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "| situations | n | yes, care, no, error | yes: torque > 5 % | as logged > 5 % | bodies > 5 % | > 5 sigma | as logged > 5 sigma | good | no | with care |"
        )?;
        writeln!(f, "|---|---|---|---|---|---|---|---|---|---|---|")?;
        let share = |k: usize, of: usize| {
            if of == 0 { "-".into() } else { format!("{k} ({:.0} %)", 100.0 * k as f64 / of as f64) }
        };
        for ((_, name), c) in &self.groups {
            writeln!(
                f,
                "| {name} | {} | {} {} {} {} | {} | {} | {} | {} | {} | {} | {} | {} |",
                c.situations,
                c.yes,
                c.with_care,
                c.no,
                c.errors,
                share(c.yes_torque, c.yes),
                share(c.yes_as_logged, c.yes),
                share(c.yes_bodies, c.yes),
                share(c.yes_sigma, c.yes),
                share(c.yes_sigma_as_logged, c.yes),
                c.good,
                share(c.good_no, c.good),
                share(c.good_with_care, c.good),
            )?;
        }
        writeln!(f, "\nfalse yes ({}):", self.false_yes.len())?;
        self.false_yes.iter().try_for_each(|line| writeln!(f, "{line}"))?;
        writeln!(f, "\ngood, and not trusted ({}):", self.doubted.len())?;
        self.doubted.iter().try_for_each(|line| writeln!(f, "{line}"))
    }
}
