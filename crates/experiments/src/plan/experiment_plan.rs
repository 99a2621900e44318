//! The file plan.yaml: the experiments to run, the contribution of each, and the quality of the whole plan.
//!
//! The experiments are in greedy order: each adds the most to the experiments before it. All figures are predictions for motions
//! that follow their reference exactly, with the torque noise in the file.

use std::fmt;

use claims::significant;
use linear_model::artefact::{self, ArtefactKind, Checksum};
use linear_model::parameter::{BaseParameter, Parameter, ParameterId};
use linear_model::reference::ModelReference;
use linear_model::regressor::Regressor;
use logs::Error;
use numerics::information_matrix::{InformationMatrix, WeightedRows};
use numerics::least_squares::{Solution, solve};
use numerics::triangle::TriangleBuilder;
use serde::{Deserialize, Serialize};

use crate::motion::profile::Profile;
use crate::plan::candidates::Candidate;
use crate::plan::certificate::{certified_efficiency, condition_bound, determinant_bound};
use crate::plan::exchange::{Criterion, ExchangeSettings, exchange, scales, value_of};
use crate::plan::exciting_trajectory::{ExcitingTrajectory, JointMotion};
use crate::plan::motion_kind::MotionKind;
use crate::plan::plan_proof::PlanProof;
use crate::plan::planned_experiment::{
    CandidateMotion, PlannedExperiment, PlannedSweep, PlannedSwing, PredictedParameter, check_names,
};
use crate::plan::proof_search::{SearchBudget, registered};
use crate::plan::ranges::check_motion;

/// A plan of experiments with its predicted quality, as plan.yaml contains it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ExperimentPlan {
    /// Name and fingerprint of the robot model for which the plan was made.
    pub model: ModelReference,
    /// Names of the coordinates, in the order of q.
    pub coordinates: Vec<String>,
    /// Whether the checksum in the file matches its contents.
    #[serde(skip)]
    pub checksum: Checksum,
    /// Sample time of the robot's controller, s.
    pub sample_time_s: f64,
    /// Assumed standard deviation of the noise of one torque sample, N m, one per coordinate.
    pub torque_noise: Vec<f64>,
    /// Number of candidate experiments from which the plan was chosen.
    pub candidates: usize,
    /// The criterion by which the plan was chosen: `determinant` or `frobenius_condition`.
    pub criterion: String,
    /// Lower bound of the D-efficiency: (det F)^(1/p), divided by its value for the best plan of the same number of experiments.
    /// F: information matrix of the plan; p: number of parameters.
    pub d_efficiency_at_least: f64,
    /// The proof of an upper bound of log det F for all plans; F: information matrix of a plan. `None`: no branch and bound was
    /// run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub proof: Option<PlanProof>,
    /// Frobenius condition number sqrt(tr F tr F^-1) of this plan, with F of the unweighted rows: equation (15) of [Vandanjon,
    /// Gautier, Desbats 1995].
    pub cond_fro: f64,
    /// Proved lower bound of the Frobenius condition number of any plan with the same candidates.
    pub cond_fro_at_least: f64,
    /// Number of parameters that the plan makes identifiable.
    pub rank: usize,
    /// The experiments in greedy order: each adds the most to the experiments before it.
    pub experiments: Vec<PlannedExperiment>,
    /// Predicted standard deviations of the base parameters, in the order of the regressor's columns.
    pub parameters: Vec<PredictedParameter>,
}

/// Relative tolerance at which the iteration for the bounds of determinant and condition number ends.
const DESIGN_TOLERANCE: f64 = 1e-2;
/// Greatest number of iterations for each of the bounds of determinant and condition number.
const DESIGN_ITERATIONS: usize = 2000;
/// Ridge added to the information matrix when experiments are ordered; the first few do not have full rank.
const ORDER_RIDGE: f64 = 1e-6;
/// Least number of samples in a period of a swing (periodic motion).
const MIN_PERIOD_SAMPLES: usize = 8;
impl ExperimentPlan {
    /// Chooses a plan of experiments from the candidates and bounds its quality. `torque_noise`: standard deviation of a torque
    /// sample, N m, one per coordinate; `progress` receives (number of ended starts of the search, number of starts, best value
    /// of the criterion).
    pub fn choose(
        model: ModelReference,
        regressor: &dyn Regressor,
        candidates: &[Candidate],
        torque_noise: &[f64],
        choice: &ExchangeSettings,
        progress: &(dyn Fn(usize, usize, f64) + Sync),
    ) -> ExperimentPlan {
        let ExchangeSettings { count, criterion, search } = choice;
        // For each candidate: regressor rows divided by their noise, for the determinant; unweighted rows, for the condition
        // number.
        let information: Vec<WeightedRows> = candidates.iter().map(|c| c.information.clone()).collect();
        let raw: Vec<WeightedRows> = candidates.iter().map(|c| c.raw.clone()).collect();
        let p = regressor.parameters().len();
        let blocks = match criterion {
            Criterion::Determinant => &information,
            Criterion::FrobeniusCondition => &raw,
        };
        // First a good plan is found by exchange. If requested, branch and bound then finds a plan with a proof.
        let mut chosen = exchange(blocks, *count, *criterion, search, progress).chosen;
        let bound = determinant_bound(&information, DESIGN_TOLERANCE, DESIGN_ITERATIONS);
        let work = SearchBudget { nodes: search.nodes, tolerance: search.tolerance };
        let is_asked = *criterion == Criterion::Determinant && search.nodes > 0;
        let proven = registered().ok().filter(|_| is_asked).and_then(|prove| prove(&information, &chosen, &work));
        if let Some(proven) = &proven {
            chosen.clone_from(&proven.chosen);
        }
        let motions = candidates.iter().map(|c| written(&c.trajectory, regressor.coordinates()));
        // The quality of the plan: condition number, determinant, and predicted standard deviations.
        let condition = condition_bound(&raw, DESIGN_TOLERANCE, DESIGN_ITERATIONS);
        let value = value_of(&information, &chosen, Criterion::Determinant);
        let solution = fit(p, chosen.iter().map(|&i| &information[i]));
        ExperimentPlan {
            model,
            coordinates: regressor.coordinates().to_vec(),
            checksum: Checksum::Whole,
            sample_time_s: candidates.first().map_or(0.0, |c| c.trajectory.sample_time),
            torque_noise: torque_noise.to_vec(),
            candidates: candidates.len(),
            criterion: match criterion {
                Criterion::Determinant => "determinant".into(),
                Criterion::FrobeniusCondition => "frobenius_condition".into(),
            },
            d_efficiency_at_least: {
                // The better of two lower bounds of the D-efficiency: from a design with fractional numbers of runs, or from the
                // branch and bound.
                let relaxed = certified_efficiency(value, chosen.len(), p, &bound);
                let whole = proven.as_ref().map(|x| ((value - x.proof.log_det_at_most) / p as f64).exp());
                whole.map_or(relaxed, |whole| whole.max(relaxed))
            },
            cond_fro: (-value_of(&raw, &chosen, Criterion::FrobeniusCondition)).exp(),
            cond_fro_at_least: condition.bound,
            rank: solution.rank,
            experiments: in_order(regressor, candidates, &information, chosen, proven.is_some()),
            proof: proven.map(|x| x.proof.with_candidates(motions)),
            parameters: predicted(regressor.parameters(), &solution),
        }
    }

    /// The motions of all experiments, in the order of the plan.
    ///
    /// Fails if the file names an unknown coordinate or kind, if a number of a motion is out of range, or if the name of an
    /// experiment cannot be the name of its own log file. `file`: name of the plan's file, for error messages.
    pub fn trajectories(&self, file: &str) -> Result<Vec<ExcitingTrajectory>, Error> {
        check_names(&self.experiments).map_err(|m| Error::at(file, 0, m))?;
        self.experiments.iter().map(|e| self.trajectory(e).map_err(|m| Error::at(file, 0, m))).collect()
    }

    /// The motion of one experiment. Fails like [`ExperimentPlan::trajectories`], with a message for the user.
    pub fn trajectory(&self, e: &PlannedExperiment) -> Result<ExcitingTrajectory, String> {
        let n = self.coordinates.len();
        let fail = |what: String| Err(format!("experiment {}: {what}", e.name));
        let place = |name: &String| match self.coordinates.iter().position(|c| c == name) {
            Some(k) => Ok(k),
            None => {
                Err(format!("experiment {}: there is no coordinate `{name}`; there are {:?}", e.name, self.coordinates))
            }
        };
        let Some(kind) = MotionKind::from_word(&e.kind) else {
            let words: Vec<&str> = MotionKind::ALL.iter().map(|k| k.word()).collect();
            return fail(format!("there is no kind `{}`; there are {}", e.kind, words.join(", ")));
        };
        // The motion is a swing or a sweep. The ranges of its numbers are checked below.
        let motion = match (&e.swing, &e.sweep) {
            (Some(s), None) => {
                let profile = match s.profile.as_str() {
                    "bang_bang" => Profile::BangBang,
                    "smooth" => Profile::Smooth,
                    other => return fail(format!("there is no profile `{other}`; there are bang_bang and smooth")),
                };
                if s.period_samples < MIN_PERIOD_SAMPLES || s.periods == 0 || s.half_range.len() != n {
                    return fail(format!("a swing has at least 8 samples a period, one period, {n} half ranges"));
                }
                JointMotion::Swing {
                    profile,
                    period: s.period_samples,
                    half_range: s.half_range.clone(),
                    transient_periods: s.transient_periods,
                    periods: s.periods,
                }
            }
            (None, Some(s)) => JointMotion::Sweep {
                range: s.range_rad,
                velocity: s.velocity_rad_per_s,
                acceleration: s.acceleration_rad_per_s2,
                settling: s.settling_s,
            },
            _ => return fail("it has either a swing or a sweep".into()),
        };
        if e.centre.len() != n {
            return fail(format!("the centre has {n} angles"));
        }
        let trajectory = ExcitingTrajectory {
            kind,
            fast: place(&e.fast)?,
            slow: e.slow.iter().map(place).collect::<Result<_, _>>()?,
            centre: e.centre.clone(),
            sample_time: self.sample_time_s,
            motion,
        };
        // A number out of range usually has a wrong unit or a wrong digit.
        match check_motion(&trajectory) {
            Ok(()) => Ok(trajectory),
            Err(what) => fail(what),
        }
    }

    /// The base parameters that are not identifiable with this plan.
    pub fn unidentifiable(&self) -> Vec<ParameterId> {
        self.parameters.iter().filter(|p| p.sigma.is_none()).map(|p| p.id.clone()).collect()
    }

    /// Writes the plan as the text of plan.yaml.
    pub fn to_yaml(&self) -> Result<String, Error> {
        artefact::write(ArtefactKind::Plan, self.checksum, self).map_err(Error::new)
    }

    /// Reads plan.yaml from its text. `file`: name of the file, for error messages.
    pub fn from_yaml(file: &str, text: &str) -> Result<ExperimentPlan, Error> {
        let plan: ExperimentPlan = artefact::read(ArtefactKind::Plan, text).map_err(|e| Error::at(file, 0, e))?;
        Ok(ExperimentPlan { checksum: Checksum::of(text), ..plan })
    }
}

/// Predicts the standard deviation of each base parameter from a least-squares fit of all experiments of the plan.
fn predicted(parameters: &[BaseParameter], solution: &Solution) -> Vec<PredictedParameter> {
    let parameter = |(i, base): (usize, &BaseParameter)| PredictedParameter {
        id: ParameterId::Base(base.name.clone()),
        unit: Parameter::from(base).unit(),
        sigma: solution.determined[i].then(|| solution.inverse[(i, i)].max(0.0).sqrt()),
    };
    parameters.iter().enumerate().map(parameter).collect()
}

/// Converts the motion of a candidate to the form of a plan file.
fn written(t: &ExcitingTrajectory, coordinates: &[String]) -> CandidateMotion {
    let name = |&k: &usize| coordinates[k].clone();
    // Exactly one of `swing` and `sweep` has a value.
    let (swing, sweep) = match &t.motion {
        JointMotion::Swing { profile, period, half_range, transient_periods, periods } => {
            let profile = match profile {
                Profile::BangBang => "bang_bang",
                Profile::Smooth => "smooth",
            };
            let swing = PlannedSwing {
                profile: profile.into(),
                period_samples: *period,
                transient_periods: *transient_periods,
                periods: *periods,
                half_range: half_range.clone(),
            };
            (Some(swing), None)
        }
        JointMotion::Sweep { range, velocity, acceleration, settling } => {
            let sweep = PlannedSweep {
                range_rad: *range,
                velocity_rad_per_s: *velocity,
                acceleration_rad_per_s2: *acceleration,
                settling_s: *settling,
            };
            (None, Some(sweep))
        }
    };
    CandidateMotion {
        kind: t.kind.word().into(),
        fast: name(&t.fast),
        slow: t.slow.iter().map(name).collect(),
        centre: t.centre.clone(),
        swing,
        sweep,
    }
}

fn planned(index: usize, t: &ExcitingTrajectory, coordinates: &[String]) -> PlannedExperiment {
    let CandidateMotion { kind, fast, slow, centre, swing, sweep } = written(t, coordinates);
    let name = format!("e{:02}", index + 1);
    PlannedExperiment { name, kind, fast, slow, centre, swing, sweep, ..PlannedExperiment::default() }
}

/// Orders the experiments greedily: the one that increases log det F the most comes next. `left`: indices of the chosen
/// candidates; `names_candidates`: whether each experiment of the file states the index of its candidate.
fn in_order(
    regressor: &dyn Regressor,
    candidates: &[Candidate],
    information: &[WeightedRows],
    mut left: Vec<usize>,
    names_candidates: bool,
) -> Vec<PlannedExperiment> {
    let p = regressor.parameters().len();
    let scale = scales(p, left.iter().map(|&i| &information[i]));
    let value = |chosen: &[usize]| {
        let rows: Vec<WeightedRows> = chosen.iter().map(|&i| information[i].scaled(&scale)).collect();
        // The ridge replaces the information of the experiments that are not yet ordered. It affects only the order.
        let f = InformationMatrix::sum(p, ORDER_RIDGE, rows.iter().map(|r| (r, 1.0)));
        f.factor().map_or(f64::NEG_INFINITY, |f| f.log_det)
    };
    let (mut chosen, mut found): (Vec<usize>, Vec<PlannedExperiment>) = (vec![], vec![]);
    let mut known = vec![false; p];
    let mut rank = 0;
    while !left.is_empty() {
        let with = |i: usize| value(&[chosen.as_slice(), &[i]].concat());
        let best = (0..left.len()).map(|at| (at, with(left[at]))).reduce(|a, b| if b.1 > a.1 { b } else { a });
        let at = best.map_or(0, |b| b.0);
        let before =
            value_of(&pick(information, &chosen), &(0..chosen.len()).collect::<Vec<_>>(), Criterion::Determinant);
        chosen.push(left.remove(at));
        let after =
            value_of(&pick(information, &chosen), &(0..chosen.len()).collect::<Vec<_>>(), Criterion::Determinant);
        let solution = fit(p, chosen.iter().map(|&i| &information[i]));
        let last = chosen[chosen.len() - 1];
        let mut e = planned(found.len(), &candidates[last].trajectory, regressor.coordinates());
        e.candidate = names_candidates.then_some(last);
        e.rank = solution.rank;
        e.adds_log_det = (rank == p).then_some(after - before);
        rank = solution.rank;
        let new = |c: &usize| solution.determined[*c] && !known[*c];
        e.adds = (0..p).filter(new).map(|c| ParameterId::Base(regressor.parameters()[c].name.clone())).collect();
        known = solution.determined;
        found.push(e);
    }
    found
}

fn pick(blocks: &[WeightedRows], chosen: &[usize]) -> Vec<WeightedRows> {
    chosen.iter().map(|&i| blocks[i].clone()).collect()
}

fn fit<'a>(p: usize, blocks: impl Iterator<Item = &'a WeightedRows>) -> Solution {
    let mut block = TriangleBuilder::new(p);
    for row in blocks.flat_map(|b| b.iter().collect::<Vec<_>>()) {
        block.push(row, 0.0);
    }
    solve(&block.finish())
}

impl fmt::Display for ExperimentPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (count, p) = (self.experiments.len(), self.parameters.len());
        writeln!(f, "{}: {count} of {} experiments, rank {} of {p}", self.model.name, self.candidates, self.rank)?;
        writeln!(
            f,
            "D-efficiency at least {}; cond_fro {}, of no plan below {}\n",
            significant(self.d_efficiency_at_least, 4),
            significant(self.cond_fro, 4),
            significant(self.cond_fro_at_least, 3)
        )?;
        for e in &self.experiments {
            let slow = if e.slow.is_empty() { String::new() } else { format!(" with {}", e.slow.join(", ")) };
            let centre: Vec<String> = e.centre.iter().map(|q| format!("{q:.2}")).collect();
            write!(f, "{} {:<11} {}{slow} about ({}), rank {}", e.name, e.kind, e.fast, centre.join(", "), e.rank)?;
            match e.adds_log_det {
                Some(gain) => writeln!(f, ", log det +{gain:.2}")?,
                None if e.adds.is_empty() => writeln!(f)?,
                None => writeln!(f, "\n    adds {}", names(&e.adds))?,
            }
        }
        match self.unidentifiable().as_slice() {
            [] => Ok(()),
            open => writeln!(f, "\nnot identifiable with this plan: {}", names(open)),
        }
    }
}

/// The names of parameters, separated by blanks.
fn names(parameters: &[ParameterId]) -> String {
    parameters.iter().map(ParameterId::to_string).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pendulum::Pendulum;
    use crate::plan::candidates::candidates;
    use crate::plan::exchange::SearchEffort;
    use crate::plan::test_plans::{grid, limits};

    fn plan(count: usize) -> ExperimentPlan {
        let (arm, noise) = (Pendulum::new(), [0.1]);
        let model = ModelReference { name: "pendulum".into(), fingerprint: "0123".into() };
        let choice = ExchangeSettings {
            count,
            criterion: Criterion::Determinant,
            search: SearchEffort { starts: 4, ..SearchEffort::default() },
        };
        let found = candidates(&grid(), &limits()[..1], &arm, &noise);
        ExperimentPlan::choose(model, &arm, &found, &noise, &choice, &|_, _, _| ())
    }

    #[test]
    fn a_plan_survives_its_file() {
        let plan = plan(4);
        assert_eq!((plan.rank, plan.unidentifiable().len()), (3, 0));
        assert!(plan.d_efficiency_at_least > 0.7 && plan.cond_fro >= plan.cond_fro_at_least);
        let text = plan.to_yaml().unwrap();
        let read = ExperimentPlan::from_yaml("plan.yaml", &text).unwrap();
        assert_eq!(plan, read, "{text}");
        assert_eq!(read.trajectories("plan.yaml").unwrap().len(), 4);
        let ranks: Vec<usize> = plan.experiments.iter().map(|e| e.rank).collect();
        assert!(ranks.is_sorted() && ranks[3] == 3, "{ranks:?}");
    }

    #[test]
    fn a_poor_plan_names_what_it_cannot_tell() {
        let plan = plan(1);
        assert!(plan.rank < 3 && !plan.unidentifiable().is_empty());
        assert!(plan.to_string().contains("not identifiable with this plan: "), "{plan}");
    }

    #[test]
    fn a_broken_file_is_told_where() {
        let mut plan = plan(3);
        plan.experiments[1].fast = "q9".into();
        let error = plan.trajectories("plan.yaml").unwrap_err();
        assert!(error.to_string().contains("experiment e02: there is no coordinate `q9`"), "{error}");
        plan.experiments[1].fast = "q1".into();
        plan.sample_time_s = 1e-9;
        let error = plan.trajectories("plan.yaml").unwrap_err();
        assert!(error.to_string().contains("experiment e01: the sample time is 1e-9 s"), "{error}");
        assert!(ExperimentPlan::from_yaml("plan.yaml", "experiments: 3").is_err());
    }
}
