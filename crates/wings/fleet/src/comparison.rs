//! Compares the parameters of robots, or of one robot on several days, with a reference.
//!
//! d_c: difference of parameter c from the reference. Its variance is sigma_c^2 + sigma_c^2(reference), because the two sums
//! (triangles added over logs, see `accumulator`) contain different logs. Each sigma is the larger of two standard deviations:
//! for white noise, and between replicates. Each has its degrees of freedom. `crate::behrens_fisher` gives the probability of a
//! difference as large as d_c if nothing changed. The tests of all parameters and robots are combined (`false_discovery`).
//! Parameters that are undetermined in one of the sums are listed but not compared.

use std::fmt;

use crate::behrens_fisher::two_sided_difference;
use linear_model::artefact::{self, ArtefactKind, Checksum};
use linear_model::parameter::ParameterId;
use linear_model::unit::Unit;
use logs::Error;
use serde::{Deserialize, Serialize};

use crate::accumulator::Accumulator;
use crate::false_discovery::families;
use crate::solution::Solved;

/// The choice of the tested parameters. More tests have less power, because the false discovery rate is for all tests together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Compared {
    /// All parameters that both the robot's sums and the reference's sums determine.
    #[default]
    All,
    /// Only parameters of bodies and rotors. Friction and offsets change with temperature and from day to day, so they are fitted
    /// but not tested.
    Inertial,
}

impl Compared {
    fn has(self, id: &ParameterId) -> bool {
        self == Compared::All || matches!(id, ParameterId::Base(_))
    }
}

/// The result of a comparison of robots with a reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Comparison {
    /// Name of the robot's model.
    pub model: String,
    /// Name of the reference, as given by the user.
    pub reference: String,
    /// Which parameters were tested.
    #[serde(default)]
    pub of: Compared,
    /// The false discovery rate, used twice: for the robots, and for the parameters of the robots that changed.
    pub rate: f64,
    /// The results of the robots, in the order given.
    pub robots: Vec<ComparedRobot>,
    /// Whether the checksum in the file matches its contents.
    #[serde(skip)]
    pub seal: Checksum,
}

/// The result of one robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComparedRobot {
    /// Name of the robot, as given by the user.
    pub name: String,
    /// Whether the robot changed significantly.
    pub changed: bool,
    /// The smallest false discovery rate at which the robot is reported as changed.
    pub adjusted: f64,
    /// Differences of the parameters that both the robot's sums and the reference's sums determine, in the order of the columns.
    pub parameters: Vec<Difference>,
    /// Parameters that are undetermined in the sums of the robot or in the sums of the reference.
    pub open: Vec<ParameterId>,
}

/// The difference of one parameter between a robot and the reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Difference {
    /// The parameter.
    pub name: ParameterId,
    /// SI unit of the three values below.
    pub unit: Unit,
    /// Value of the parameter in the reference.
    pub reference: f64,
    /// Value of the robot minus value of the reference.
    pub difference: f64,
    /// Standard deviation of the difference.
    pub sigma: f64,
    /// p-value: probability that a difference is at least as large as this one if the parameter did not change.
    pub p: f64,
    /// Whether the parameter is reported as changed significantly.
    pub moved: bool,
}

impl Difference {
    /// The difference divided by its standard deviation; 0 if the standard deviation is zero.
    pub fn deviations(&self) -> f64 {
        if self.sigma > 0.0 { self.difference / self.sigma } else { 0.0 }
    }
}

/// Compares robots with a reference; each is a name and its sums over logs. `of`: which parameters are tested. `rate`: the false
/// discovery rate.
///
/// Fails if the settings of two sums differ, if two sums contain the same log, or if a sum cannot be solved.
pub fn compare(
    reference: (&str, &Accumulator),
    robots: &[(&str, &Accumulator)],
    of: Compared,
    rate: f64,
) -> Result<Comparison, Error> {
    if !(rate > 0.0 && rate < 1.0) {
        return Err(Error::new(format!("a false discovery rate of {rate}: a number between 0 and 1 is expected")));
    }
    let solved = |(name, sums): (&str, &Accumulator)| Solved::of(sums).map_err(|e| Error::new(format!("{name}: {e}")));
    let base = solved(reference)?;
    let mut compared = Vec::new();
    for &(name, sums) in robots {
        let both = Pair { ours: (name, sums), theirs: reference };
        both.check()?;
        compared.push(both.differences(&solved((name, sums))?, &base, of));
    }
    let p: Vec<Vec<f64>> = compared.iter().map(|r| r.parameters.iter().map(|d| d.p).collect()).collect();
    for (robot, family) in compared.iter_mut().zip(families(&p, rate)) {
        (robot.changed, robot.adjusted) = (family.is_found, family.adjusted);
        robot.parameters.iter_mut().zip(family.found).for_each(|(d, found)| d.moved = found);
    }
    let model = reference.1.settings().model.name.clone();
    Ok(Comparison { model, reference: reference.0.into(), of, rate, robots: compared, seal: Checksum::Whole })
}

/// A robot and its reference, each with its name and its sums over logs.
struct Pair<'a> {
    ours: (&'a str, &'a Accumulator),
    theirs: (&'a str, &'a Accumulator),
}

impl Pair<'_> {
    /// Fails if the two sums have different settings, or contain the same log.
    fn check(&self) -> Result<(), Error> {
        let [(ours, a), (theirs, b)] = [self.ours, self.theirs];
        let differences = a.settings().differences(b.settings());
        if !differences.is_empty() {
            return Err(Error::new(format!(
                "{ours} and {theirs} cannot be compared: {}; make both with the same settings ([:accumulate] \
                 [like={theirs}])",
                differences.join("; ")
            )));
        }
        let logs = b.logs();
        let both = a.logs().into_iter().find(|log| logs.iter().any(|other| other.digest == log.digest));
        match both {
            Some(log) => Err(Error::new(format!(
                "{}: in {ours} and in {theirs}; a difference of sums of one log with itself says nothing: leave it out of one",
                log.name
            ))),
            None => Ok(()),
        }
    }

    fn differences(&self, a: &Solved, b: &Solved, of: Compared) -> ComparedRobot {
        let columns = &self.ours.1.settings().columns;
        let (mut parameters, mut open) = (Vec::new(), Vec::new());
        let sigma = [a, b].map(|solved| solved.sigma(|_| 1.0));
        for (c, column) in columns.iter().enumerate().filter(|(_, column)| of.has(&column.name)) {
            if !(a.solution.determined[c] && b.solution.determined[c]) {
                open.push(column.name.clone());
                continue;
            }
            let (one, other) = (sigma[0][c], sigma[1][c]);
            let difference = a.solution.x[c] - b.solution.x[c];
            // If there is no noise, a difference of the size of a rounding error is no change: p is 1.
            let p = two_sided_difference(difference, (one, a.freedom(c)), (other, b.freedom(c)));
            parameters.push(Difference {
                name: column.name.clone(),
                unit: column.unit,
                reference: b.solution.x[c],
                difference,
                sigma: one.hypot(other),
                p,
                moved: false,
            });
        }
        ComparedRobot { name: self.ours.0.into(), changed: false, adjusted: 1.0, parameters, open }
    }
}

impl Comparison {
    /// Number of robots that changed significantly.
    pub fn changed(&self) -> usize {
        self.robots.iter().filter(|robot| robot.changed).count()
    }

    /// Writes the comparison as the text of comparison.yaml.
    pub fn to_yaml(&self) -> Result<String, Error> {
        artefact::write(ArtefactKind::Comparison, self.seal, self).map_err(Error::new)
    }

    /// Reads comparison.yaml; fails with the first line that does not belong to a comparison.
    pub fn from_yaml(file: &str, text: &str) -> Result<Comparison, Error> {
        let comparison: Comparison =
            artefact::read(ArtefactKind::Comparison, text).map_err(|e| Error::at(file, 0, e))?;
        Ok(Comparison { seal: Checksum::of(text), ..comparison })
    }
}

/// Largest number of unchanged robots that are listed by name. If there are more, only their number is given.
const MAX_NAMED_ROBOTS: usize = 8;

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (changed, all) = (self.changed(), self.robots.len());
        if let Some(said) = self.seal.said() {
            writeln!(f, "{said}")?;
        }
        writeln!(
            f,
            "{}: {changed} of {all} changed against {}{}, with a false discovery rate of {} %",
            self.model,
            self.reference,
            if self.of == Compared::Inertial { ", friction not asked about" } else { "" },
            100.0 * self.rate
        )?;
        let are_many = all - changed > MAX_NAMED_ROBOTS;
        for robot in self.robots.iter().filter(|robot| robot.changed || !are_many) {
            robot.fmt(f)?;
        }
        if are_many {
            writeln!(f, "\nnothing moved in the other {} ([out] names them)", all - changed)?;
        }
        Ok(())
    }
}

impl fmt::Display for ComparedRobot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.changed {
            writeln!(f, "\n{}: changed (adjusted p {:.1e})", self.name, self.adjusted)?;
            self.write_moved(f)?;
        } else {
            let most = self.parameters.iter().max_by(|a, b| b.p.total_cmp(&a.p));
            let most = most.map_or(String::new(), |d| format!(", {} most: {:+.1} sigma", d.name, d.deviations()));
            writeln!(f, "\n{}: nothing moved (adjusted p {:.2}{most})", self.name, self.adjusted)?;
        }
        if !self.open.is_empty() {
            let names: Vec<String> = self.open.iter().map(ToString::to_string).collect();
            writeln!(f, "not compared, one of the two does not identify them: {}", names.join(", "))?;
        }
        Ok(())
    }
}

impl ComparedRobot {
    /// Writes a table of the changed parameters; the difference that is largest relative to its standard deviation is first.
    fn write_moved(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut moved: Vec<(&Difference, String)> =
            self.parameters.iter().filter(|d| d.moved).map(|d| (d, d.name.to_string())).collect();
        moved.sort_by(|a, b| b.0.deviations().abs().total_cmp(&a.0.deviations().abs()));
        let width = moved.iter().map(|(_, name)| name.chars().count()).max().unwrap_or(0).max(9);
        let head = ["reference", "change", "sigma", "deviations"];
        writeln!(
            f,
            "{:<width$}  {:>12}  {:>12}  {:>10}  {:>10}  unit",
            "parameter", head[0], head[1], head[2], head[3]
        )?;
        for (d, name) in moved {
            let (reference, change, sigma, deviations) = (d.reference, d.difference, d.sigma, d.deviations());
            writeln!(
                f,
                "{name:<width$}  {reference:>12.5}  {change:>+12.5}  {sigma:>10.5}  {deviations:>+10.1}  {}",
                d.unit
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::replicate::{MAX_BLOCKS_PER_LOG, Replicate};
    use crate::test_arm::{Pendulum, account, empty};
    use identification::estimate::options::Options;
    use identification::rows::observation::Observation;
    use linear_model::friction::terms::FrictionTerm;
    use linear_model::linear_model::Model;
    use random::Random;

    use crate::state_cells::StateCells;

    /// Sums over one log of a pendulum. `more`: amount by which its first moment MX is larger.
    fn sums(seed: u64, more: f64) -> Accumulator {
        with_friction(seed, more, 0.0)
    }

    /// Sums over one log of a pendulum whose MX is larger by `more`, with viscous friction `viscous`. Friction is fitted unless
    /// `viscous` is zero.
    fn with_friction(seed: u64, more: f64, viscous: f64) -> Accumulator {
        let arm = Pendulum::new();
        let friction = if viscous == 0.0 { Vec::new() } else { FrictionTerm::STANDARD.to_vec() };
        let options = Options { friction, ..Options::default() };
        let model = Model::new(&arm, &options.friction, &[]);
        let (mut states, mut random) = (arm.states(1000), Random::new(seed));
        for r in 0..states.len() {
            states.tau[r] += more * 9.81 * states.q[r].cos() + viscous * states.dq[r] + 0.1 * random.normal();
        }
        let (account, mut all) = (account(format!("{seed}.csv"), seed, 1000), empty(&options));
        let observation = Observation { cutoff: 10.0, ..Observation::of(&model, &states, MAX_BLOCKS_PER_LOG) };
        let mut cells = StateCells::new(&model);
        cells.add(&model, &states);
        all.add(Replicate { logs: vec![account], observation, cells, faults: Vec::new() }).unwrap();
        all
    }

    #[test]
    fn the_parameter_that_moved_is_named() {
        let (reference, same, heavier) = (sums(1, 0.0), sums(2, 0.0), sums(3, 0.02));
        let found = compare(("a", &reference), &[("b", &same), ("c", &heavier)], Compared::All, 0.05).unwrap();
        assert!(!found.robots[0].changed && found.robots[1].changed, "{found}");
        let moved: Vec<String> =
            found.robots[1].parameters.iter().filter(|d| d.moved).map(|d| d.name.to_string()).collect();
        assert_eq!(moved, ["MX1"], "{found}");
        let change = found.robots[1].parameters[1].difference;
        // The standard deviation of the change is 0.0005 kg m: a noise of 0.1 N m, divided by 9.81 m/s^2 and by the root of
        // five hundred rows. The limit is four standard deviations.
        assert!((change - 0.02).abs() < 0.002, "{change}");
        assert_eq!(Comparison::from_yaml("c", &found.to_yaml().unwrap()).unwrap(), found);
    }

    #[test]
    fn friction_is_not_asked_about_where_bodies_are() {
        let (reference, day, heavier) =
            (with_friction(1, 0.0, 0.5), with_friction(2, 0.0, 0.7), with_friction(3, 0.02, 0.7));
        let robots = [("day", &day), ("heavier", &heavier)];
        let all = compare(("a", &reference), &robots, Compared::All, 0.05).unwrap();
        assert!(all.robots.iter().all(|r| r.changed), "{all}");
        let found = compare(("a", &reference), &robots, Compared::Inertial, 0.05).unwrap();
        assert!(!found.robots[0].changed && found.robots[1].changed, "{found}");
        assert!(found.to_string().contains("friction not asked about") && !all.to_string().contains("not asked"));
        assert!(found.robots.iter().flat_map(|r| &r.parameters).all(|d| matches!(d.name, ParameterId::Base(_))));
        assert_eq!(Comparison::from_yaml("c", &found.to_yaml().unwrap()).unwrap(), found);
    }

    #[test]
    fn one_log_is_not_compared_with_itself() {
        let one = sums(1, 0.0);
        let refused = compare(("a.tri", &one), &[("b.tri", &one)], Compared::All, 0.05).unwrap_err().to_string();
        assert!(refused.contains("1.csv: in b.tri and in a.tri"), "{refused}");
        assert!(compare(("a.tri", &one), &[], Compared::All, 0.0).is_err());
    }
}
