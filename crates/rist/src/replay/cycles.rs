//! The samples of a log as the observer takes them: momentum, known torque, and the rows of the regressor.
//!
//! Nothing is filtered forward and backward, because a robot cannot do this while it runs. The acceleration, which only friction
//! that depends on the load and the uncertainty of the parameters need, is the derivative of the velocity through the filter of the
//! observer.

use identification::estimate::artefact::Estimate;
use identification::signals::preparation::Preparation;
use identification::signals::records::{Records, SourceRecords};
use linear_model::linear_model::Model as LinearModel;
use linear_model::parameter::{FrictionParameter, ParameterId};
use linear_model::regressor::predict_load;
use linear_model::states::States;
use logs::LogSource;
use online::Band;

use crate::describe::evaluation::{Evaluation, ManyStates};
use crate::describe::model::{Model, predicts};
use crate::error::Error;

/// The model of an estimate, with which the samples of logs become cycles.
pub(crate) struct CycleModel<'a> {
    pub(crate) model: &'a Model,
    pub(crate) linear: LinearModel<'a>,
    preparation: Preparation,
    /// Values of all parameters of the linear model.
    x: Vec<f64>,
    /// Number of base parameters.
    base: usize,
    load: &'a [f64],
    momentum: Evaluation,
    load_momentum: Evaluation,
    /// Gain of the observer, 1/s.
    gain: f64,
    /// For each joint, the speed below which friction changes its direction smoothly, because there the sign of a measured velocity
    /// is noise, rad/s (m/s).
    pub(crate) slow: Vec<f64>,
    /// The bands of the joints, once they are known; their speeds give the slowness of a cycle.
    pub(crate) bands: Vec<Band<f64>>,
}

/// One joint in one cycle.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointCycle {
    /// Velocity, rad/s (m/s).
    pub(crate) speed: f64,
    /// Direction of the velocity, -1 to 1; smooth at low speed.
    pub(crate) direction: f64,
    /// Slowness of the joint, 0 to 1 ([`Band::slowness`]); zero before the bands are known.
    pub(crate) slowness: f64,
    /// Generalised momentum, kg m^2/s (kg m/s).
    pub(crate) momentum: f64,
    /// Torque of the motor minus friction plus b, N m (N).
    pub(crate) known: f64,
    /// Row of the regressor with friction, p entries.
    pub(crate) row: Vec<f64>,
    /// Momentum, then b, per unit of the ten parameters of the load.
    pub(crate) load: [[f64; 10]; 2],
}

/// One cycle.
pub(crate) struct Cycle<'a> {
    /// Time, s.
    pub(crate) t: f64,
    /// Time since the cycle before, s; zero at the first cycle of a record.
    pub(crate) period: f64,
    pub(crate) joints: &'a [JointCycle],
}

impl<'a> CycleModel<'a> {
    /// Fails for an estimate of experiments, if the estimate lacks a parameter, and if there is no link `link`. `gain`: gain of the
    /// observer, 1/s.
    pub(crate) fn new(
        model: &'a Model,
        estimate: &'a Estimate,
        link: &str,
        gain: f64,
    ) -> Result<CycleModel<'a>, Error> {
        let Some(options) = &estimate.options else {
            return Err(Error::new(
                "an estimate of experiments has no friction of samples: identify logs, without [plan]",
            ));
        };
        let linear = options.linear_model(model.regressor());
        let x = linear.parameters.iter().map(|p| predicts(estimate, &p.id)).collect::<Result<Vec<f64>, _>>()?;
        let mut preparation = options.preparation();
        // No filter, every sample, and columns of friction that are computed at the sample.
        preparation.signal.order = 0;
        preparation.signal.decimate = Some(1);
        preparation.signal.border = Some(0.0);
        preparation.signal.standstill = Some(0.0);
        preparation.friction = Vec::new();
        preparation.load = Vec::new();
        let load_momentum = Evaluation::of_function(model, &format!("load-momentum={link}"))?;
        let momentum = Evaluation::of_function(model, "momentum-and-rate")?;
        let (base, load) = (model.regressor().parameters().len(), options.friction_load.as_slice());
        let (slow, bands) = (vec![0.0; linear.n()], Vec::new());
        Ok(CycleModel { model, linear, preparation, x, base, load, momentum, load_momentum, gain, slow, bands })
    }

    /// Leaves out all friction but viscous friction, Coulomb friction and offset, as a generated file does.
    pub(crate) fn keep_standard_friction(&mut self) {
        use FrictionParameter::{Coulomb, Offset, Viscous};
        for (x, parameter) in self.x.iter_mut().zip(&self.linear.parameters).skip(self.base) {
            if !matches!(parameter.id, ParameterId::Friction(Viscous | Coulomb | Offset, _)) {
                *x = 0.0;
            }
        }
    }

    /// Takes also the samples that the fit left out, such as those of contact.
    pub(crate) fn take_all_samples(&mut self) {
        self.preparation.signal.leave_out.clear();
    }

    /// Values of all parameters of the linear model.
    pub(crate) fn x(&self) -> &[f64] {
        &self.x
    }

    /// Number of joints.
    pub(crate) fn n(&self) -> usize {
        self.linear.n()
    }

    /// Calls `take` with each cycle of a log. Fails if the log cannot be read or does not fit the robot.
    pub(crate) fn each(&self, log: &LogSource, take: &mut dyn FnMut(&Cycle)) -> Result<(), Error> {
        let regressor = self.model.regressor();
        let records = SourceRecords::new(regressor, std::slice::from_ref(log), &self.preparation)?;
        let mut failed = None;
        records.each(&mut |states| {
            if failed.is_none() {
                failed = self.each_of_record(states.clone(), take).err();
            }
        })?;
        failed.map_or(Ok(()), Err)
    }

    fn each_of_record(&self, mut states: States, take: &mut dyn FnMut(&Cycle)) -> Result<(), Error> {
        let n = self.n();
        self.filter_accelerations(&mut states);
        for (k, direction) in states.direction.iter_mut().enumerate() {
            let (speed, slow) = (states.dq[k], self.slow[k % n]);
            *direction = if slow > 0.0 { (speed / slow).clamp(-1.0, 1.0) } else { *direction };
        }
        if !self.load.is_empty() {
            predict_load(self.model.regressor(), &mut states, self.load);
        }
        let mut joints = vec![JointCycle::default(); n];
        let (mut momenta, mut loads) = (Vec::new(), Vec::new());
        let mut before = None;
        let usual = states.period;
        for first in (0..states.len()).step_by(CYCLES_PER_PASS) {
            let range = first..states.len().min(first + CYCLES_PER_PASS);
            let part = range.start * n..range.end * n;
            let at = |parameters| ManyStates {
                q: &states.q[part.clone()],
                dq: &states.dq[part.clone()],
                parameters,
                ..ManyStates::default()
            };
            momenta.resize(range.len() * 2 * n, 0.0);
            loads.resize(range.len() * 20 * n, 0.0);
            self.momentum.fill(self.model, &at(&self.x[..self.base]), &mut momenta)?;
            self.load_momentum.fill(self.model, &at(&[]), &mut loads)?;
            self.linear.rows(&states, range.clone(), |r, rows| {
                let momenta = &momenta[(r - first) * 2 * n..][..2 * n];
                let loads = &loads[(r - first) * 20 * n..][..20 * n];
                for (j, (joint, row)) in joints.iter_mut().zip(rows.chunks_exact(self.x.len())).enumerate() {
                    let friction: f64 = row.iter().zip(&self.x).skip(self.base).map(|(y, x)| y * x).sum();
                    joint.speed = states.dq[r * n + j];
                    joint.direction = states.direction[r * n + j];
                    joint.slowness = self.bands.get(j).map_or(0.0, |band| band.slowness(joint.speed));
                    joint.momentum = momenta[j];
                    joint.known = states.tau[r * n + j] - friction + momenta[n + j];
                    joint.row.clear();
                    joint.row.extend_from_slice(row);
                    joint.load = [0, 1].map(|part| std::array::from_fn(|c| loads[(part * n + j) * 10 + c]));
                }
                let t = states.t[r];
                let period = before.map_or(0.0, |before| t - before);
                // After samples that are left out, the observers begin again.
                let is_gap = period > LARGEST_PERIOD_RATIO * usual;
                take(&Cycle { t, period: if is_gap { 0.0 } else { period }, joints: &joints });
                before = Some(t);
            });
        }
        Ok(())
    }

    /// Replaces the accelerations by the derivative of the velocities through a low-pass of first order with the observer's gain.
    fn filter_accelerations(&self, states: &mut States) {
        let n = states.n;
        for j in 0..n {
            let mut slow = states.dq.get(j).copied().unwrap_or(0.0);
            for r in 0..states.len() {
                let step = self.gain * if r > 0 { states.t[r] - states.t[r - 1] } else { 0.0 };
                slow += step / (1.0 + step) * (states.dq[r * n + j] - slow);
                states.ddq[r * n + j] = self.gain * (states.dq[r * n + j] - slow);
            }
        }
    }

    /// Mean time between the cycles of a log, s. Fails if the log cannot be read.
    pub(crate) fn mean_period(&self, log: &LogSource) -> Result<f64, Error> {
        let (mut sum, mut count) = (0.0, 0);
        self.each(log, &mut |cycle| {
            sum += cycle.period;
            count += usize::from(cycle.period > 0.0);
        })?;
        Ok(sum / count.max(1) as f64)
    }

    /// Standard deviations of FV, FS and OFF of each joint in the estimate; zero for a parameter that it does not hold.
    pub(crate) fn friction_sigma(&self, estimate: &Estimate) -> Vec<[f64; 3]> {
        let of = |coordinate: &String| {
            [FrictionParameter::Viscous, FrictionParameter::Coulomb, FrictionParameter::Offset].map(|parameter| {
                let id = ParameterId::friction(parameter, coordinate);
                estimate.parameters.iter().find(|p| p.id == id).and_then(|p| p.sigma).unwrap_or(0.0)
            })
        };
        self.model.regressor().coordinates().iter().map(of).collect()
    }
}

/// A cycle that comes later than this many periods is the first after a gap.
const LARGEST_PERIOD_RATIO: f64 = 5.0;

/// Number of cycles whose functions are evaluated together.
const CYCLES_PER_PASS: usize = 1024;
