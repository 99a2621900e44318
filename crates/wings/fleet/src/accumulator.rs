//! Sums of sufficient statistics over many logs: each log is read once, and its rows are replaced by triangular matrices.
//!
//! For any number of logs, one triangular matrix R per joint (the R of a QR decomposition) replaces the rows [W y], because these
//! matrices can be added: R'R = sum_k R_k'R_k, k: log [Golub, Van Loan 2013, 12.5]. W: regressor, y: torques. Standard deviations
//! need several separate terms of this sum, called replicates (`block_deviation`). So a small number of logs is stored log by
//! log, and an even smaller number block by block. The rows are also stored sorted by the state of their joint (`state_cells`).
//!
//! | number of logs | each log is stored in | cells of states | replicates |
//! |---|---|---|---|
//! | 1 to 4 | 16 blocks | octaves of speed, 32nds of a turn | 16 to 64 blocks |
//! | 5 to 15 | 4 blocks | octaves, eighths of a turn | 20 to 60 blocks |
//! | 16 to 64 | one block | two octaves each | one per log: the standard deviations contain the differences between logs |
//! | more | 64 groups of logs, selected by the digest of the log | two octaves each | at most 64 |
//!
//! Up to 64 logs form a set, sorted by name; the sum is computed when it is needed. So the file is the same, byte for byte, for
//! every order and grouping of merges. With more than 64 logs, the rounding of a group's sum depends on the order of the merges.
//! A file has at most 64 replicates and a line for each log.
//!
//! A smaller statistic would be the second moment of the scores (gradients of single rows) at a fixed solution. It is not used,
//! because every added log changes the solution, and scores at another solution need third moments of the rows.

use std::collections::BTreeMap;

use logs::Error;
use numerics::triangle::Triangle;
use serde::{Deserialize, Serialize};

use crate::replicate::{LogAccount, MAX_BLOCKS_PER_LOG, Replicate};
use crate::settings::Settings;
use crate::state_cells::StateCells;
use identification::rows::observation::Observation;

/// Largest number of logs, or groups of logs, that are stored separately.
pub(crate) const MAX_REPLICATES: usize = 64;

/// A log that could not be used, with the reason.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FailedLog {
    /// Name of the file, as given by the user.
    pub name: String,
    /// The reason why the log could not be used.
    pub reason: String,
}

/// Sums over the logs of one robot, from which parameters can be identified.
#[derive(Clone, Debug)]
pub struct Accumulator {
    settings: Settings,
    replicates: Vec<Replicate>,
    failed: Vec<FailedLog>,
}

impl Accumulator {
    /// Empty sums with these settings.
    pub fn new(settings: Settings) -> Accumulator {
        Accumulator { settings, replicates: Vec::new(), failed: Vec::new() }
    }

    /// Makes the sums from the content of a file, and sorts the logs.
    pub(super) fn of(settings: Settings, replicates: Vec<Replicate>, failed: Vec<FailedLog>) -> Accumulator {
        let mut all = Accumulator { settings, replicates, failed };
        all.settle();
        all
    }

    /// The settings that all logs of the sums share.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The replicates, in the order of their first logs.
    pub fn replicates(&self) -> &[Replicate] {
        &self.replicates
    }

    /// The logs whose rows are in the sums, in the order of their names.
    pub fn logs(&self) -> Vec<&LogAccount> {
        let mut logs: Vec<&LogAccount> = self.replicates.iter().flat_map(|r| &r.logs).collect();
        logs.sort_by(|a, b| (&a.name, &a.digest).cmp(&(&b.name, &b.digest)));
        logs
    }

    /// The logs that could not be used, in the order of their names.
    pub fn failed(&self) -> &[FailedLog] {
        &self.failed
    }

    /// Records a log that could not be used.
    pub fn fail(&mut self, name: String, reason: String) {
        self.failed.push(FailedLog { name, reason });
        self.settle();
    }

    /// Adds a log. If the options of the sums have no cut-off frequency yet, the cut-off of this log is used for all.
    ///
    /// Fails if the log is already included, or has other filter settings.
    pub fn add(&mut self, replicate: Replicate) -> Result<(), Error> {
        let mut settings = self.settings.clone();
        settle_cutoff(&mut settings, &replicate.observation);
        self.merge(&Accumulator { settings, replicates: vec![replicate], failed: Vec::new() })
    }

    /// Adds the logs of other sums.
    ///
    /// Fails if the settings differ, or if a log is in both sums; then the sums are unchanged.
    pub fn merge(&mut self, other: &Accumulator) -> Result<(), Error> {
        let mut settings = self.settings.clone();
        if self.replicates.is_empty() && settings.options.signal.cutoff.is_none() {
            settings.options.signal.cutoff = other.settings.options.signal.cutoff;
        }
        let mut theirs = other.settings.clone();
        if other.replicates.is_empty() && theirs.options.signal.cutoff.is_none() {
            theirs.options.signal.cutoff = settings.options.signal.cutoff;
        }
        let differences = settings.differences(&theirs);
        if !differences.is_empty() {
            return Err(Error::new(format!(
                "these sums cannot be added: {}; make all parts with the same settings ([:accumulate] [like=FIRST.tri])",
                differences.join("; ")
            )));
        }
        let ours: BTreeMap<&str, &str> =
            self.logs().into_iter().map(|log| (log.digest.as_str(), log.name.as_str())).collect();
        for log in other.logs() {
            if let Some(name) = ours.get(log.digest.as_str()) {
                let also = if *name == log.name { String::new() } else { format!(" (as {name})") };
                return Err(Error::new(format!(
                    "{}: in both{also}; a log counts once: leave out a part that has it",
                    log.name
                )));
            }
        }
        // Logs may have different names for their columns. The choice of the names does not depend on the order of merging.
        let names = [&settings.options.columns, &theirs.options.columns].map(|names| format!("{names:?}"));
        if names[1] < names[0] {
            settings.options.columns = theirs.options.columns;
        }
        self.settings = settings;
        self.replicates.extend(other.replicates.iter().cloned());
        self.failed.extend(other.failed.iter().cloned());
        self.settle();
        Ok(())
    }

    /// The triangles (R of QR decompositions) of all logs, one per block and joint, and statistics of the joints' motion. All
    /// blocks of a replicate get the number of the replicate, as if it were a log. `None` if there are no logs.
    pub fn observation(&self) -> Option<Observation> {
        let numbered = |(number, replicate): (usize, &Replicate)| {
            let mut observation = replicate.observation.clone();
            observation.log_of.fill(number);
            observation
        };
        let mut replicates = self.replicates.iter().enumerate().map(numbered);
        let mut all = replicates.next()?;
        replicates.for_each(|one| all.append(one));
        Some(all)
    }

    /// The rows of all logs, sorted by the state of their joint. `None` if there are no logs.
    pub(super) fn cells(&self) -> Option<StateCells> {
        let mut replicates = self.replicates.iter().map(|r| r.cells.clone());
        let mut all = replicates.next()?;
        replicates.for_each(|one| all.absorb(one));
        Some(all)
    }

    /// The triangles (R of QR decompositions) for tests of faults, for example a wrong sign of a torque. Consecutive triangles
    /// are merged so that at most `groups` remain.
    pub(super) fn faults(&self, groups: usize) -> Vec<Triangle> {
        let all: Vec<&Triangle> = self.replicates.iter().flat_map(|r| &r.faults).collect();
        let sum = |some: &[&Triangle]| Triangle::sum(some[0].columns(), some.iter().copied());
        all.chunks(all.len().div_ceil(groups).max(1)).map(sum).collect()
    }

    /// Sorts the logs, and merges their blocks as the table at the top of this file says.
    fn settle(&mut self) {
        let logs: usize = self.replicates.iter().map(|r| r.logs.len()).sum();
        let blocks = match logs {
            0..=4 => MAX_BLOCKS_PER_LOG,
            5..=15 => MAX_BLOCKS_PER_LOG / 4,
            _ => 1,
        };
        self.replicates.iter_mut().for_each(|r| r.fold_to(blocks));
        self.replicates.sort_by(|a, b| a.key().cmp(&b.key()));
        if logs > MAX_REPLICATES {
            let mut groups: BTreeMap<u64, Replicate> = BTreeMap::new();
            for replicate in std::mem::take(&mut self.replicates) {
                let digest = replicate.key().map_or("", |key| key.1);
                let group = u64::from_str_radix(digest, 16).unwrap_or(0) % MAX_REPLICATES as u64;
                match groups.get_mut(&group) {
                    Some(sum) => sum.absorb(replicate),
                    None => {
                        groups.insert(group, replicate);
                    }
                }
            }
            self.replicates = groups.into_values().collect();
            self.replicates.sort_by(|a, b| a.key().cmp(&b.key()));
        }
        let found: Vec<String> = self.logs().into_iter().map(|log| log.name.clone()).collect();
        // If a log failed at first but was read successfully later, its failure is removed from the list.
        self.failed.retain(|failed| found.binary_search(&failed.name).is_err());
        self.failed.sort();
        self.failed.dedup();
    }
}

/// If the options have no cut-off frequency, sets it to the cut-off frequency that was chosen for this observation.
fn settle_cutoff(settings: &mut Settings, observation: &Observation) {
    let signal = &mut settings.options.signal;
    if signal.order > 0 && signal.cutoff.is_none() {
        signal.cutoff = Some(observation.cutoff);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::replicate::MAX_FAULT_PARTS_PER_LOG;
    use crate::replicate::of_hypotheses;
    use crate::test_arm::{self, Pendulum};
    use identification::estimate::claims::hypotheses::{FitPoint, UndeterminedMechanics};
    use identification::estimate::options::Options;
    use identification::estimators::weighted::{Weights, fit};
    use linear_model::linear_model::Model;
    use linear_model::states::States;
    use random::Random;

    fn empty() -> Accumulator {
        let mut options = Options { friction: Vec::new(), ..Options::default() };
        options.signal.cutoff = Some(10.0);
        test_arm::empty(&options)
    }

    /// The replicate of log k of a pendulum.
    fn log(k: u64) -> Replicate {
        changed_log(k, |_| ())
    }

    /// The replicate of log k, with torques changed by `change`.
    fn changed_log(k: u64, change: impl FnOnce(&mut States)) -> Replicate {
        let arm = Pendulum::new();
        let model = Model::new(&arm, &[], &[]);
        let (mut states, mut random) = (arm.states(100), Random::stream(5, k));
        change(&mut states);
        states.tau.iter_mut().for_each(|tau| *tau += 0.1 * random.normal());
        let account = test_arm::account(format!("{k:03}.csv"), random.bits(), 100);
        let observation = Observation::of(&model, &states, MAX_BLOCKS_PER_LOG);
        let mut cells = StateCells::new(&model);
        cells.add(&model, &states);
        let (solution, weights) = fit(&observation.joints(|_| true), Weights::Joint);
        let point = FitPoint { x: &solution.x, weights: &weights, robust: None };
        let faults =
            of_hypotheses(&model, &[states][..], point, UndeterminedMechanics::default(), MAX_FAULT_PARTS_PER_LOG)
                .unwrap();
        Replicate { logs: vec![account], observation, cells, faults }
    }

    fn sums(logs: impl IntoIterator<Item = Replicate>) -> Accumulator {
        let mut sums = empty();
        logs.into_iter().for_each(|log| sums.add(log).unwrap());
        sums
    }

    /// Four logs have torques that differ by some per cent. The standard deviation of a parameter must equal the standard
    /// deviation of the mean of four values; the number of blocks has no effect.
    #[test]
    fn what_changes_from_log_to_log_is_in_the_deviation() {
        let scaled = |k: u64| {
            changed_log(k, |states| states.tau.iter_mut().for_each(|tau| *tau *= 1.0 + 0.06 * (k as f64 - 1.5)))
        };
        let (fit, _) = sums((0..4).map(scaled)).fit().unwrap();
        for p in &fit.estimate.parameters[..2] {
            // The four factors have a standard deviation of 0.077, so their mean has a standard deviation of half of this.
            let share = p.sigma.unwrap() / p.value.unwrap().abs();
            assert!((0.025..0.08).contains(&share), "{p:?}");
        }
    }

    #[test]
    fn faults_are_in_the_deviation() {
        let sprung =
            |k: u64| changed_log(k, |states| states.tau.iter_mut().zip(&states.q).for_each(|(tau, q)| *tau += 0.4 * q));
        let with = sums((0..2).map(sprung));
        let without = sums((0..2).map(sprung).map(|log| Replicate { faults: Vec::new(), ..log }));
        let [with, without] = [with, without].map(|sums| sums.solve().unwrap());
        let exact = Pendulum::new().truth;
        let wider = (0..3).filter(|&c| with.parameters[c].sigma > without.parameters[c].sigma).count();
        assert!(wider > 0, "{with:?}");
        for (p, exact) in with.parameters.iter().zip(exact) {
            // Only the largest fault inflates the standard deviation. The true value must still be within three standard
            // deviations.
            assert!((p.value.unwrap() - exact).abs() < 3.0 * p.sigma.unwrap(), "{p:?} {exact}");
        }
    }

    /// Distributes logs over several sums at random, each log once, and merges these sums in random order.
    fn merged(logs: &[Replicate], random: &mut Random) -> Accumulator {
        let mut left: Vec<&Replicate> = logs.iter().collect();
        let mut parts: Vec<Accumulator> = (0..1 + random.index(5)).map(|_| empty()).collect();
        while !left.is_empty() {
            let one = left.swap_remove(random.index(left.len())).clone();
            let part = random.index(parts.len());
            parts[part].add(one).unwrap();
        }
        while parts.len() > 1 {
            let part = parts.swap_remove(random.index(parts.len()));
            let into = random.index(parts.len());
            parts[into].merge(&part).unwrap();
        }
        parts.remove(0)
    }

    #[test]
    fn any_partition_is_the_same_file() {
        let logs: Vec<Replicate> = (0..20).map(log).collect();
        let mut random = Random::new(1);
        for count in [3, 9, 20] {
            let expected = merged(&logs[..count], &mut random).to_bytes().unwrap();
            for _ in 0..334 {
                assert!(merged(&logs[..count], &mut random).to_bytes().unwrap() == expected, "{count} logs");
            }
        }
    }

    #[test]
    fn many_logs_stay_few_replicates() {
        let logs: Vec<Replicate> = (0..150).map(log).collect();
        let mut random = Random::new(2);
        let (one, other) = (merged(&logs, &mut random), merged(&logs, &mut random));
        assert!(one.replicates().len() <= MAX_REPLICATES && one.logs().len() == 150);
        let sum = |all: &Accumulator| all.observation().unwrap().joints(|_| true).remove(0);
        let (a, b) = (sum(&one), sum(&other));
        assert_eq!((a.rows, b.rows), (15_000, 15_000));
        for j in 0..=3 {
            for i in 0..=j {
                // Tolerance for some hundred merges; each has a rounding error relative to the norm of the column.
                assert!((a.at(i, j).abs() - b.at(i, j).abs()).abs() < 1e-12 * a.column_norm(j.min(2)).max(a.at(3, 3)));
            }
        }
    }

    #[test]
    fn a_log_counts_once_and_what_is_refused_changes_nothing() {
        let mut all = empty();
        all.fail("001.csv".into(), "cut short".into());
        all.fail("nine.csv".into(), "cut short".into());
        (0..3).for_each(|k| all.add(log(k)).unwrap());
        let before = all.to_bytes().unwrap();
        let twice = all.add(log(1)).unwrap_err().to_string();
        assert!(twice.contains("001.csv: in both"), "{twice}");
        let mut copy = log(2);
        copy.logs[0].name = "copy.csv".into();
        assert!(all.add(copy).unwrap_err().to_string().contains("copy.csv: in both (as 002.csv)"));
        let mut slower = log(7);
        slower.observation.cutoff = 5.0;
        let mut other = empty();
        other.settings.options.signal.cutoff = None;
        other.add(slower).unwrap();
        let unlike = all.merge(&other).unwrap_err().to_string();
        assert!(unlike.contains("cut-off: 10 Hz and 5 Hz"), "{unlike}");
        assert_eq!(all.to_bytes().unwrap(), before);
        let names: Vec<&str> = all.failed().iter().map(|f| f.name.as_str()).collect();
        assert_eq!(names, ["nine.csv"], "001.csv could be read after all");
    }
}
