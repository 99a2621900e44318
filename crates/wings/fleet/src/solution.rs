//! Estimates parameters from sums (triangles added over logs, see `accumulator`). The rows of the logs are not needed, but the
//! result equals the result of `identify` for the same logs.
//!
//! Values, residuals and the error on held-out blocks equal the results of `estimate::identify`. A standard deviation combines
//! two, as in `estimators::replicate_deviation`. The first is from the blocks (`block_deviation`), scaled by Student's t such
//! that 1.96 standard deviations cover 95 %. The second is from the bands of speed and position (`state_cells`). The result is at
//! least the standard deviation for white noise and the standard deviation between logs. Faults inflate it as in `identify`, with
//! triangles that were weighted by a fit to each log alone. Not available, because they need the rows: residuals that depend on
//! another joint, and rows that do not fit.
//!
//! A difference of two sums (`comparison`) is tested with the blocks only, because the model has the same errors in both sums.

use logs::Error;
use numerics::least_squares::Solution;
use numerics::student::two_sided_quantile;
use numerics::triangle::Triangle;

use crate::accumulator::Accumulator;
use crate::block_deviation::{BlockDeviation, block_deviation};
use crate::settings::ColumnsOnly;
use crate::state_cells::StateCells;
use identification::estimate::artefact::Estimate;
use identification::estimate::claims::hypotheses::{HypothesisTest, tested};
use identification::estimate::claims::{inflate_by_faults, inflate_by_undetected_faults};
use identification::estimate::held_out::cross_validate;
use identification::estimate::identified::INTERVAL;
use identification::estimate::identify::{Fit, NO_JOINT_MOVES, of_signals, report, with_deviations};
use identification::estimate::logs_left_out::{logs_left_out, sentence as of_left_out};
use identification::estimators::clusters::FullNormalMatrix;
use identification::estimators::replicate_deviation::{ReplicateDeviation, by_band, moved_by_logs, white_deviation};
use identification::estimators::weighted::fit;
use identification::rows::observation::{Observation, weighted};

/// With fewer than this number of blocks, a standard deviation has a relative uncertainty above one half.
const SUFFICIENT_BLOCKS: usize = 8;

/// The numerical solution of the sums of a robot.
pub(super) struct Solved {
    pub observation: Observation,
    pub joints: Vec<Triangle>,
    pub solution: Solution,
    pub deviation: BlockDeviation,
    weights: Vec<f64>,
}

impl Solved {
    /// Solves the sums. Fails if there are no logs, or if no joint moves in any of them.
    pub(super) fn of(sums: &Accumulator) -> Result<Solved, Error> {
        let observation = sums.observation().ok_or_else(|| match sums.failed().first() {
            Some(failed) => Error::new(format!("no log could be used: {}", failed.reason)),
            None => Error::new("no log is in these sums; at least one is needed"),
        })?;
        let joints = observation.joints(|_| true);
        if joints.iter().all(|t| t.rows == 0) {
            return Err(Error::new(NO_JOINT_MOVES));
        }
        let (solution, weights) = fit(&joints, sums.settings().options.weights);
        let deviation = block_deviation(&observation.parts, &weights, &solution);
        Ok(Solved { observation, joints, solution, deviation, weights })
    }

    /// Standard deviations from the blocks, one per parameter.
    ///
    /// Each is the larger of two: the standard deviation for white noise; and the one from the blocks, multiplied by `interval`
    /// (a function of its degrees of freedom).
    pub(super) fn sigma(&self, interval: impl Fn(f64) -> f64) -> Vec<f64> {
        let BlockDeviation { sigma, freedom, .. } = &self.deviation;
        let both = white_deviation(&self.solution).into_iter().zip(sigma.iter().zip(freedom));
        both.map(|(white, (blocks, freedom))| white.max(interval(*freedom) * blocks)).collect()
    }

    /// The standard deviations from the blocks, from the bands of speed and position in `cells`, and between logs.
    fn believed(&self, cells: &StateCells) -> ReplicateDeviation {
        let interval = |freedom: f64| two_sided_quantile(0.05, freedom) / INTERVAL;
        // The quantile is taken for at least one degree of freedom, because it grows without limit below one.
        let by_part = self.sigma(|freedom| interval(freedom.max(1.0)));
        let whole = FullNormalMatrix::of(&weighted(&self.joints, &self.weights));
        let wider = interval((self.deviation.blocks as f64 - 1.0).max(1.0));
        let bands = cells.clusters(&self.solution.x, &self.weights);
        let [by_speed, by_position] = bands.map(|bands| by_band(&whole, &bands, wider));
        let white = white_deviation(&self.solution);
        let moved_by_logs = moved_by_logs(&whole, &self.observation, &self.solution, &self.weights, 1.0);
        ReplicateDeviation { white, by_part, by_speed, by_position, moved_by_logs, correlated: 1.0 }
    }

    /// Degrees of freedom of the standard deviation from the blocks, for parameter c.
    pub(super) fn freedom(&self, c: usize) -> f64 {
        self.deviation.freedom[c]
    }
}

/// When faults are tested, the triangles are divided into this number of groups, and one group after the other is held out.
const LEFT_OUT_GROUPS: usize = 10;

impl Accumulator {
    /// The estimate from all logs. Faults that the data show, or that the data cannot exclude, inflate its standard deviations.
    ///
    /// Fails if there are no logs, or if no joint moves. Parameters that the data do not determine have a status that says so.
    pub fn solve(&self) -> Result<Estimate, Error> {
        let (Fit { mut estimate, .. }, faults) = self.fit()?;
        inflate_by_faults(&mut estimate, &faults);
        inflate_by_undetected_faults(&mut estimate, &faults);
        Ok(estimate)
    }

    /// The estimate from all logs with intermediate results, and the tests of hypotheses (possible faults).
    ///
    /// Fails like [`Accumulator::solve`].
    pub fn fit(&self) -> Result<(Fit, Vec<HypothesisTest>), Error> {
        let columns: ColumnsOnly = self.settings().columns_alone()?;
        let options = &self.settings().options;
        let model = options.linear_model(&columns);
        let solved = Solved::of(self)?;
        let cells = self.cells().ok_or_else(|| Error::new("no log is in these sums; at least one is needed"))?;
        // Standard deviations from blocks, from bands and between logs are combined in one estimate.
        let deviation = solved.believed(&cells);
        let mut estimate = report(&model, &solved.joints, &solved.observation, &solved.solution, &deviation.sigma());
        let held_out = cross_validate(&model, &solved.observation, options.weights);
        estimate.cross_validation = Some(held_out.total);
        for (joint, out) in estimate.joints.iter_mut().zip(held_out.joints) {
            joint.held_out = Some(out.relative);
        }
        of_signals(&mut estimate, &solved.observation, options);
        // Adds remarks about the replicates and about the logs that failed.
        estimate.remarks.push(self.replicates_in_words(solved.deviation.blocks));
        estimate
            .remarks
            .extend(self.failed().iter().map(|failed| format!("not in it: {}: {}", failed.name, failed.reason)));
        let settings = self.settings();
        estimate.model = settings.model.name.clone();
        estimate.fingerprint = Some(settings.model.fingerprint.clone());
        estimate.description = settings.description.clone();
        estimate.method = format!("{}, from sums", options.weights.method());
        estimate.logs = self.logs().into_iter().map(|log| log.name.clone()).collect();
        if options.covariance {
            estimate.covariance = with_deviations(&solved.solution.inverse, &deviation.sigma());
        }
        let Solved { observation, solution, weights, .. } = solved;
        let mut fit = Fit { estimate, observation, solution, weights, robust: None, deviation };
        // If each log is one replicate, each log can be predicted by a fit to the other logs. A sentence tells the result.
        if self.replicates().len() == fit.estimate.logs.len() {
            let sentence = of_left_out(&logs_left_out(&model, &fit, None), &fit.estimate.logs);
            fit.estimate.remarks.extend(sentence);
        }
        let parts = self.faults(LEFT_OUT_GROUPS);
        let faults = match parts.is_empty() {
            true => Vec::new(),
            false => tested(&parts, &fit.solution.x, &settings.hypotheses),
        };
        Ok((fit, faults))
    }

    /// A sentence that names the replicates from which the standard deviations are computed.
    fn replicates_in_words(&self, blocks: usize) -> String {
        let logs = self.logs().len();
        let of = match (logs, self.replicates().len()) {
            (1, _) => format!("{blocks} blocks of one log"),
            (logs, replicates) if blocks <= replicates && logs > replicates => {
                format!("{blocks} groups of {logs} logs")
            }
            (logs, replicates) if blocks <= replicates => format!("{logs} logs"),
            (logs, _) => format!("{blocks} blocks of {logs} logs"),
        };
        let warning = if blocks < SUFFICIENT_BLOCKS { ", which are few: more logs make it surer" } else { "" };
        format!(
            "sigma follows from the differences between {of}{warning}, and between the speeds and positions of each joint"
        )
    }
}
