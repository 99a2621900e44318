//! Identifies parameters from the logs of a plan by simulating its experiments, with the methods IDIM-IV (instrumental
//! variables) and DIDIM (direct and inverse dynamic identification), see `simulated_loop`.
//!
//! The simulated controller is the controller of [`simulate`](rist::simulate): a PD controller with a bandwidth of 10 Hz, tuned
//! to the least squares estimate. IDIM-IV only needs a simulation that follows the plan approximately as the robot does. DIDIM
//! needs a simulated loop that equals the real loop.

use crate::loop_estimate::identify_closed_loop;
use crate::simulated_loop::{ClosedLoop, Simulator};
use experiments::motion::record::Record;
use experiments::motion::reference_motion::Reference;
use experiments::simulate::closed_loop::Stop;
use experiments::simulate::setup::{SimulatedMotion, SimulationSetup};
use identification::estimate::identify::Fit;
use identification::signals::preparation::{Preparation, states};
use linear_model::friction::law::FrictionLaw;
use linear_model::friction::terms::FrictionTerm;
use linear_model::states::States;

use identification::estimate::artefact::Estimate;
use rist::Error;
use rist::ExperimentLogs;
use rist::Model;
use rist::request::{ClosedLoopRequest, Method, Request};
use rist::wings::ExperimentReader;
use rist::wings::dynamics as dynamics_of;

/// Identifies base parameters and friction from the experiments of a plan. The experiments are simulated in each iteration.
///
/// Fails if a log is missing or does not belong to its experiment, if a drive gain is unknown, if another friction model is
/// requested, if a simulation diverges, or if the motion does not determine all parameters.
pub fn identify_in_loop(
    model: &Model,
    logs: ExperimentLogs,
    request: &ClosedLoopRequest,
    method: Method,
) -> Result<Estimate, Error> {
    let method = match method {
        Method::Iv => ClosedLoop::InstrumentalVariables,
        _ => ClosedLoop::DirectAndInverse,
    };
    request.check()?;
    let mut options = request.options()?;
    let trajectories = logs.plan.trajectories(&logs.directory.display().to_string())?;
    let mut read = ExperimentReader { model, columns: &options.columns, currents: false, files: Vec::new() };
    let mut records: Vec<Record> = Vec::new();
    for (e, trajectory) in logs.plan.experiments.iter().zip(&trajectories) {
        records.push(read.record(&logs.directory.join(format!("{}.csv", e.name)), trajectory)?);
    }
    let gains = gains(model, read.currents, &request.gain)?;

    // The record of each experiment and the reference that is simulated are cut to the same number of samples.
    let mut references: Vec<Reference> = trajectories.iter().map(|t| t.reference()).collect();
    let coordinates = model.regressor().coordinates();
    let mut measured = Vec::new();
    for ((record, reference), file) in records.iter_mut().zip(&mut references).zip(&read.files) {
        let count = record.q[0].len().min(reference.q[0].len());
        *record = record.cut(std::slice::from_ref(&(0..count)));
        [&mut reference.q, &mut reference.dq, &mut reference.ddq].into_iter().flatten().for_each(|x| x.truncate(count));
        measured.push(record.to_log(file, coordinates, &gains));
    }
    options.model = model.robot.name.clone();
    let preparation = options.preparation().for_logs(&measured)?;
    let mut rows = Vec::new();
    for log in &measured {
        rows.extend(states(model.regressor(), log, &preparation)?);
    }
    let start = Fit::of_records(model.regressor(), rows.as_slice(), read.files.clone(), &options)?.solution.x;
    let base = model.regressor().parameters().len();
    let mut setup = SimulationSetup::for_robot(&model.robot, dynamics_of(model, start[..base].to_vec()).as_ref());
    setup.drives.gain.fill(1.0);
    // The simulated signals serve as instruments (of the instrumental variables) and must have no noise. So the positions in the
    // simulated loop are not quantised.
    setup.sensing.quantum.fill(0.0);
    let simulator = PlanInLoop { model, references: &references, setup, preparation };
    let mut estimate = identify_closed_loop(model.regressor(), &rows, read.files, &simulator, &options, method)?;
    estimate.fingerprint = Some(model.reference.fingerprint.clone());
    estimate.description = model.description.clone();
    if let Some(options) = estimate.options.as_mut().filter(|_| read.currents) {
        options.transmission.drive_gains = Some(gains);
    }
    Ok(estimate)
}

/// Simulates the experiments of a plan.
struct PlanInLoop<'a> {
    model: &'a Model,
    references: &'a [Reference],
    setup: SimulationSetup,
    preparation: Preparation,
}

impl Simulator for PlanInLoop<'_> {
    fn simulate(&self, x: &[f64]) -> Result<States, logs::Error> {
        let regressor = self.model.regressor();
        let (base, friction) = x.split_at(regressor.parameters().len());
        let dynamics = dynamics_of(self.model, base.to_vec());
        let mut setup = self.setup.clone();
        // Each joint has the friction parameters FV (viscous), FS (Coulomb) and OFF (offset), which become one friction law.
        let law = |f: &[f64]| FrictionLaw::asymmetric(f[0], f[1] + f[2], f[0], f[2] - f[1]);
        setup.friction = friction.chunks_exact(FrictionTerm::STANDARD.len()).map(law).collect();
        let mut found = Vec::new();
        let asked = |reference| SimulatedMotion { reference, feedforward: None, noise: None };
        let asked: Vec<SimulatedMotion> = self.references.iter().map(asked).collect();
        for (record, stop) in setup.records(dynamics.as_ref(), &asked) {
            if let Stop::NotPhysical { time } = stop {
                return Err(logs::Error::new(format!(
                    "the simulation of an experiment breaks down at {time:.3} s: no robot has the parameters it starts \
                     from, or it cannot follow the motion; identify by [method=ls] or rist-mh and look at the estimate"
                )));
            }
            let log = record.to_log("simulation", regressor.coordinates(), &setup.drives.gain);
            found.extend(states(regressor, &log, &self.preparation)?);
        }
        Ok(States::joined(&found))
    }
}

/// For each coordinate, the torque per unit of the logged signal: the drive gain, N m/A, if currents are logged, and 1 if torques
/// are logged. Fails if a gain is unknown.
fn gains(model: &Model, currents: bool, given: &[(String, f64)]) -> Result<Vec<f64>, Error> {
    let coordinates = model.regressor().coordinates();
    if !currents {
        return match given.first() {
            Some((name, _)) => Err(Error::new(format_args!("[gain={name}]: the logs hold torques, not currents"))),
            None => Ok(vec![1.0; coordinates.len()]),
        };
    }
    let mut known = model.drive_gains();
    model.give_gains(&mut known, given)?;
    let open = |(name, gain): (&String, &Option<f64>)| gain.is_none().then(|| name.clone());
    let open: Vec<String> = coordinates.iter().zip(&known).filter_map(open).collect();
    if !open.is_empty() {
        return Err(Error::new(format_args!(
            "the logs hold currents, and the gains of {} are not known: give them with [gain={}=1.0], or have them estimated \
             by [method=rist-mh]",
            open.join(", "),
            open[0]
        )));
    }
    Ok(known.into_iter().flatten().collect())
}
