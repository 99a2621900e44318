//! From sums to an estimate: what `identify` finds in the same logs, without their rows.
//!
//! Values, residuals and the error on left-out blocks are those of `estimate::identify`. The deviation comes from the
//! blocks (`estimators::block_deviation`) instead of from residuals sample by sample. It is scaled by Student's t of
//! its degrees of freedom, so that 1.96 of it hold 95 %, and it is at least that of white noise. Not here, because they
//! need the rows: residuals that move with another joint, rows that do not fit.

use logs::Error;
use numerics::least_squares::Solution;
use numerics::student::reach;
use numerics::triangle::Triangle;

use crate::estimate::artefact::Estimate;
use crate::estimate::fleet::accumulator::Accumulator;
use crate::estimate::fleet::settings::ColumnsAlone;
use crate::estimate::held_out::cross_validate;
use crate::estimate::identified::INTERVAL;
use crate::estimate::identify::{NO_JOINT_MOVES, of_signals, report, with_deviations};
use crate::estimators::block_deviation::{BlockDeviation, block_deviation};
use crate::estimators::replicate_deviation::white_deviation;
use crate::estimators::weighted::fit;
use crate::rows::observation::Observation;

/// With fewer blocks than this a deviation is uncertain by more than a half.
const SUFFICIENT_BLOCKS: usize = 8;

/// The numbers that the sums of a robot give, before they are put into words.
pub(super) struct Solved {
    pub observation: Observation,
    pub joints: Vec<Triangle>,
    pub solution: Solution,
    pub deviation: BlockDeviation,
}

impl Solved {
    /// Fails where there is no log, and where no joint ever moves.
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
        Ok(Solved { observation, joints, solution, deviation })
    }

    /// The deviation, one per parameter.
    ///
    /// It is the larger of that of white noise and that of the blocks times `reach` of its degrees of freedom.
    pub(super) fn sigma(&self, reach: impl Fn(f64) -> f64) -> Vec<f64> {
        let BlockDeviation { sigma, freedom, .. } = &self.deviation;
        let both = white_deviation(&self.solution).into_iter().zip(sigma.iter().zip(freedom));
        both.map(|(white, (blocks, freedom))| white.max(reach(*freedom) * blocks)).collect()
    }

    /// Degrees of freedom of that deviation.
    pub(super) fn freedom(&self, c: usize) -> f64 {
        self.deviation.freedom[c]
    }
}

impl Accumulator {
    /// The estimate of all its logs.
    ///
    /// Fails where there is no log, and where no joint ever moves. Parameters that the data do not determine are a
    /// status.
    pub fn solve(&self) -> Result<Estimate, Error> {
        let columns: ColumnsAlone = self.settings().columns_alone()?;
        let options = &self.settings().options;
        let model = options.linear_model(&columns);
        let solved = Solved::of(self)?;
        // Below one degree of freedom the reach would grow without end, and the deviation is no estimate.
        let sigma = solved.sigma(|freedom| reach(0.05, freedom.max(1.0)) / INTERVAL);
        let mut estimate = report(&model, &solved.joints, &solved.observation, &solved.solution, &sigma);
        let held_out = cross_validate(&model, &solved.observation, options.weights);
        estimate.cross_validation = Some(held_out.total);
        for (joint, out) in estimate.joints.iter_mut().zip(held_out.joints) {
            joint.held_out = Some(out.relative);
        }
        of_signals(&mut estimate, &solved.observation, options);
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
            estimate.covariance = with_deviations(&solved.solution.inverse, &sigma);
        }
        Ok(estimate)
    }

    /// A sentence on what the deviations are taken from.
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
        format!("the deviation is that between {of}{warning}")
    }
}
