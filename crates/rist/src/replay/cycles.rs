//! Converts the samples of a log into cycles, the inputs of the observer: momentum, known torque, and the rows of the
//! regressor.
//!
//! No signal is filtered forward and backward, because a robot cannot do this while it runs. The acceleration is needed only
//! for load-dependent friction and for the uncertainty of the parameters. It is the derivative of the velocity, after the
//! filter of the observer.
//!
//! p: generalised momentum; b = C' dq - g, where C is the Coriolis matrix and g the gravity torque. Known torque: torque of the
//! motor minus friction plus b. Slowness: 1 at standstill, 0 at speed. A record is a part of a log without gaps.

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

/// The model with the parameters of an estimate. It converts samples of logs to cycles.
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
    /// The Jacobian of the link that is assumed to be touched.
    jacobian: Option<Evaluation>,
    /// Gain of the observer, 1/s.
    gain: f64,
    /// For each joint, the speed below which friction changes its direction smoothly, rad/s (m/s). Below this speed, the sign
    /// of a measured velocity is only noise.
    pub(crate) slow: Vec<f64>,
    /// Limits of the torques by the description, N m (N); infinite where it has none.
    efforts: Vec<f64>,
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
    /// Whether the torque of the motor is at the effort limit of the description. The true torque is then not known.
    pub(crate) is_saturated: bool,
    /// Row of the regressor with friction, p entries.
    pub(crate) row: Vec<f64>,
    /// Momentum, then b, per unit of the ten parameters of the load.
    pub(crate) load: [[f64; 10]; 2],
}

/// One cycle.
pub(crate) struct Cycle<'a> {
    /// Time, s.
    pub(crate) t: f64,
    /// Time since the previous cycle, s; zero at the first cycle of a record.
    pub(crate) period: f64,
    pub(crate) joints: &'a [JointCycle],
    /// Jacobian of the link that is assumed to be touched, 6 x n row by row; empty without one.
    pub(crate) jacobian: &'a [f64],
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
        // The signals are not filtered, every sample is used, and friction is computed at the sample itself.
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
        let effort = |name: &String| {
            let coordinate = model.robot.coordinates.iter().find(|coordinate| coordinate.name == *name);
            coordinate.and_then(|coordinate| coordinate.limits.effort).filter(|effort| *effort > 0.0)
        };
        let efforts =
            model.regressor().coordinates().iter().map(|name| effort(name).unwrap_or(f64::INFINITY)).collect();
        Ok(CycleModel {
            model,
            linear,
            preparation,
            x,
            base,
            load,
            momentum,
            load_momentum,
            jacobian: None,
            gain,
            slow,
            efforts,
            bands,
        })
    }

    /// Evaluates the Jacobian of a link or frame in each cycle. Fails if there is none of this name.
    pub(crate) fn evaluate_jacobian(&mut self, link: &str) -> Result<(), Error> {
        self.jacobian = Some(Evaluation::of_function(self.model, &format!("jacobian={link}"))?);
        Ok(())
    }

    /// Leaves out couplings, as a generated file does.
    pub(crate) fn leave_out_couplings(&mut self) {
        for (x, parameter) in self.x.iter_mut().zip(&self.linear.parameters) {
            if matches!(parameter.id, ParameterId::Coupling(..)) {
                *x = 0.0;
            }
        }
    }

    /// From now on, also converts the samples that the fit left out, for example during contact.
    pub(crate) fn take_all_samples(&mut self) {
        self.preparation.signal.leave_out.clear();
    }

    /// Values of all parameters of the linear model.
    pub(crate) fn x(&self) -> &[f64] {
        &self.x
    }

    /// Base parameters of the earlier fit that friction terms of single joints take the load from; empty without such terms.
    pub(crate) fn load_base(&self) -> &[f64] {
        self.load
    }

    /// Limits of the torques by the description, N m (N); infinite where it has none.
    pub(crate) fn efforts(&self) -> &[f64] {
        &self.efforts
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

    /// Calls `take` with the cycle of one sample. The cycle continues the record whose values are in `memory`. `q`, `dq` and
    /// `tau`: position, velocity and torque of the motor of each coordinate, SI units; `t`: time and usual period, s.
    pub(crate) fn sample(
        &self,
        (t, usual): (f64, f64),
        [q, dq, tau]: [&[f64]; 3],
        memory: &mut RecordMemory,
        take: &mut dyn FnMut(&Cycle),
    ) -> Result<(), Error> {
        let sign = |v: f64| if v == 0.0 { 0.0 } else { v.signum() };
        let states = States {
            n: self.n(),
            period: usual,
            t: vec![t],
            q: q.to_vec(),
            dq: dq.to_vec(),
            ddq: vec![0.0; self.n()],
            direction: dq.iter().copied().map(sign).collect(),
            motor_direction: self.linear.couplings.iter().map(|c| sign(c.speed(|k| dq[k]))).collect(),
            tau: tau.to_vec(),
            used: vec![true; self.n()],
            ..States::default()
        };
        self.each_with_memory(states, memory, take)
    }

    fn each_of_record(&self, states: States, take: &mut dyn FnMut(&Cycle)) -> Result<(), Error> {
        self.each_with_memory(states, &mut RecordMemory::default(), take)
    }

    fn each_with_memory(
        &self,
        mut states: States,
        memory: &mut RecordMemory,
        take: &mut dyn FnMut(&Cycle),
    ) -> Result<(), Error> {
        let n = self.n();
        self.filter_accelerations(&mut states, memory);
        // direction = clamp(dq / slow, -1, 1), because below the speed `slow` the sign of dq is only noise.
        for (k, direction) in states.direction.iter_mut().enumerate() {
            let (speed, slow) = (states.dq[k], self.slow[k % n]);
            *direction = if slow > 0.0 { (speed / slow).clamp(-1.0, 1.0) } else { *direction };
        }
        if !self.load.is_empty() {
            predict_load(self.model.regressor(), &mut states, self.load);
        }
        let mut joints = vec![JointCycle::default(); n];
        let (mut momenta, mut loads, mut jacobians) = (Vec::new(), Vec::new(), Vec::new());
        for first in (0..states.len()).step_by(CYCLES_PER_PASS) {
            let range = first..states.len().min(first + CYCLES_PER_PASS);
            let part = range.start * n..range.end * n;
            let at = |parameters| ManyStates {
                q: &states.q[part.clone()],
                dq: &states.dq[part.clone()],
                parameters,
                ..ManyStates::default()
            };
            // Per cycle: p, then b, of the robot (2 n numbers); and the same per unit of each of the ten parameters of the load
            // (20 n numbers).
            momenta.resize(range.len() * 2 * n, 0.0);
            loads.resize(range.len() * 20 * n, 0.0);
            self.momentum.fill(self.model, &at(&self.x[..self.base]), &mut momenta)?;
            self.load_momentum.fill(self.model, &at(&[]), &mut loads)?;
            if let Some(jacobian) = &self.jacobian {
                jacobians.resize(range.len() * 6 * n, 0.0);
                jacobian.fill(self.model, &at(&[]), &mut jacobians)?;
            }
            self.linear.rows(&states, range.clone(), |r, rows| {
                let momenta = &momenta[(r - first) * 2 * n..][..2 * n];
                let loads = &loads[(r - first) * 20 * n..][..20 * n];
                for (j, (joint, row)) in joints.iter_mut().zip(rows.chunks_exact(self.x.len())).enumerate() {
                    let friction: f64 = row.iter().zip(&self.x).skip(self.base).map(|(y, x)| y * x).sum();
                    joint.speed = states.dq[r * n + j];
                    joint.direction = states.direction[r * n + j];
                    joint.slowness = self.bands.get(j).map_or(0.0, |band| band.slowness(joint.speed));
                    joint.momentum = momenta[j];
                    // known = torque of the motor - friction + b.
                    joint.known = states.tau[r * n + j] - friction + momenta[n + j];
                    joint.is_saturated = is_at(states.tau[r * n + j], self.efforts[j]);
                    joint.row.clear();
                    joint.row.extend_from_slice(row);
                    joint.load = [0, 1].map(|part| std::array::from_fn(|c| loads[(part * n + j) * 10 + c]));
                }
                let (t, period) = (states.t[r], memory.period(states.t[r], states.period));
                let jacobian = jacobians.get((r - first) * 6 * n..(r - first + 1) * 6 * n).unwrap_or(&[]);
                take(&Cycle { t, period, joints: &joints, jacobian });
            });
        }
        Ok(())
    }

    /// Replaces the accelerations by the derivative of the velocities through a low-pass of first order with the observer's gain.
    fn filter_accelerations(&self, states: &mut States, memory: &mut RecordMemory) {
        let n = states.n;
        for r in 0..states.len() {
            let before = if r > 0 { Some(states.t[r - 1]) } else { memory.before };
            let step = before.map_or(0.0, |before| self.gain * (states.t[r] - before));
            memory.slow.resize(n, 0.0);
            for (slow, k) in memory.slow.iter_mut().zip(r * n..) {
                *slow =
                    if before.is_none() { states.dq[k] } else { *slow + step / (1.0 + step) * (states.dq[k] - *slow) };
                states.ddq[k] = self.gain * (states.dq[k] - *slow);
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

/// If a torque differs from the effort limit by less than this share of the limit, the drive probably cuts the torque off. A
/// torque that is farther above the limit shows that the drive has another limit than the description.
pub(crate) const SATURATED_WITHIN: f64 = 1e-3;

/// Whether a torque is at the limit of the effort.
fn is_at(torque: f64, effort: f64) -> bool {
    (torque.abs() / effort - 1.0).abs() < SATURATED_WITHIN
}

/// Values that a cycle of a record passes on to the next cycle.
#[derive(Clone, Debug, Default)]
pub(crate) struct RecordMemory {
    /// Velocities through the low-pass, rad/s (m/s).
    slow: Vec<f64>,
    /// Time of the previous cycle, s.
    before: Option<f64>,
}

impl RecordMemory {
    /// Whether the time `t`, s, is later than the time of the previous cycle. True if there is no previous cycle.
    pub(crate) fn is_before(&self, t: f64) -> bool {
        self.before.is_none_or(|before| before < t)
    }

    /// The time since the previous cycle, s. It is zero at the first cycle and after a gap; there the observers start again.
    /// `usual`: the usual period, s.
    fn period(&mut self, t: f64, usual: f64) -> f64 {
        let period = self.before.replace(t).map_or(0.0, |before| t - before);
        if period > LARGEST_PERIOD_RATIO * usual { 0.0 } else { period }
    }
}

/// If a cycle comes later than this number of periods after the previous cycle, there is a gap between them.
const LARGEST_PERIOD_RATIO: f64 = 5.0;

/// Number of cycles whose functions are evaluated together.
const CYCLES_PER_PASS: usize = 1024;
