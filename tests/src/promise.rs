//! Tests whether predicted standard deviations of parameters are correct. For an exciting motion, the covariance that is computed
//! from the motion is compared with the errors of parameters that are identified from simulated logs of this motion.
//!
//! rist excite prints the predicted standard deviations with its motion (the "promise"). Coverage: share of the 95 % intervals
//! that contain the true value. A draw is one simulated log with its own noise.

use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::visibility::JointNoise;
use experiments::simulate::closed_loop::Sensors;
use experiments::simulate::dynamics::RegressorDynamics;
use experiments::simulate::setup::SimulationSetup;
use identification::estimate::identified::INTERVAL;
use identification::estimate::options::Options;
use identification::signals::encoder_torque::encoder_torque;
use linear_model::friction::terms::{FrictionTerm, sign};
use linear_model::parameter::ParameterId;
use logs::LogSource;
use nalgebra::{Cholesky, DMatrix};
use numerics::information_matrix::WeightedRows;
use random::Random;
use rist::motion::simulation::SimulateRequest;
use rist::{Error, IdentifyRequest, Model};

/// The columns of [`information`]: base parameters, then friction parameters of each joint.
pub fn columns(model: &Model, friction: &[FrictionTerm]) -> Vec<ParameterId> {
    let base = model.regressor().parameters().iter().map(|p| ParameterId::Base(p.name.clone()));
    let own = |c| friction.iter().flat_map(|t| t.parameters()).map(move |f| ParameterId::friction(*f, c));
    base.chain(model.regressor().coordinates().iter().flat_map(|c| own(c.as_str()))).collect()
}

/// The rows of a motion for base parameters and friction, for all samples of all repetitions. The rows of a joint are divided by
/// its torque noise, N m.
pub fn information(model: &Model, motion: &ExcitingMotion, noise: &[f64], friction: &[FrictionTerm]) -> WeightedRows {
    let regressor = model.regressor();
    let (n, base) = (regressor.coordinates().len(), regressor.parameters().len());
    let played = motion.motion("motion").unwrap();
    let own: usize = friction.iter().map(|t| t.parameters().len()).sum();
    let mut rows = WeightedRows::new(base + n * own);
    let mut y = vec![0.0; n * base];
    for k in 0..(played.repetitions as f64 * played.shape.period() * played.rate).round() as usize {
        let state = played.at(played.shape.blend() + k as f64 / played.rate);
        let of = |d: usize| -> Vec<f64> { state.iter().map(|x| x[d]).collect() };
        let (dq, ddq) = (of(1), of(2));
        regressor.fill(&of(0), &dq, &ddq, &mut y);
        for i in 0..n {
            let mut row = vec![0.0; rows.width()];
            row[..base].copy_from_slice(&y[i * base..][..base]);
            let mut place = base + i * own;
            for term in friction {
                let count = term.parameters().len();
                term.fill(dq[i], ddq[i], 0.0, sign(dq[i]), &mut row[place..][..count]);
                place += count;
            }
            row.iter_mut().for_each(|x| *x /= noise[i]);
            rows.push(&row);
        }
    }
    rows
}

/// The friction of the simulated joints: viscous and Coulomb friction, with different coefficients for each direction.
pub const FRICTION: [FrictionTerm; 1] = [FrictionTerm::Asymmetric];

pub struct Kept {
    pub name: String,
    /// Rms error of the parameter over all draws, divided by the predicted standard deviation.
    pub ratio: f64,
    /// The error of each draw, divided by the predicted standard deviation.
    pub errors: Vec<f64>,
    /// Share of the draws whose 95 % interval contains the true value.
    pub held: f64,
}

/// For each base parameter, compares the errors of identified values with the standard deviation that is predicted for the noise
/// of torques and encoders. The motion is simulated in closed loop with friction. From each of `draws` noisy records, the
/// parameters are identified with this friction and default options. `encoders`: quantum and noise of the encoders as a fraction
/// of the assumed values. Parameters that the motion or the logs do not determine are omitted.
pub fn kept(model: &Model, motion: &ExcitingMotion, draws: u64, encoders: f64) -> Result<Vec<Kept>, Error> {
    let truth = model.nominal_parameters().expect("inertial parameters in the description");
    let dynamics = RegressorDynamics::new(model.regressor(), truth.clone());
    let setup = SimulationSetup::for_robot(&model.robot, &dynamics);
    let noise = &setup.sensing.torque_noise;
    let share = |x: &[f64]| x.iter().map(|x| encoders * x).collect();
    let sensing = Sensors {
        quantum: share(&setup.sensing.quantum),
        position_noise: share(&setup.sensing.position_noise),
        torque_noise: noise.clone(),
    };
    let mut exact = None;
    let request = SimulateRequest { validation: 0, noise_free: true, ..Default::default() };
    rist::simulate(model, motion, &request, &mut |_, record| {
        exact = Some(record.clone());
        Ok(())
    })?;
    let exact = exact.expect("a motion has a record");
    let names = columns(model, &FRICTION);
    let is_shown = |name: &ParameterId| motion.parameters.iter().any(|p| p.id == *name && p.deviation.is_some());
    let shown: Vec<usize> = (0..names.len()).filter(|&i| is_shown(&names[i])).collect();
    let played = motion.motion("motion").expect("a motion");
    let encoders = encoder_torque(&dynamics, &played.reference(), &sensing.position_deviation());
    let known = promised(model, motion, &JointNoise { torque: noise.clone(), encoders }, &FRICTION, &shown);
    let variance = |i: usize| shown.iter().position(|s| *s == i).map(|place| known[place]);
    let mut errors: Vec<Option<(Vec<f64>, usize)>> =
        (0..truth.len()).map(|i| variance(i).map(|_| Default::default())).collect();
    for seed in 1..=draws {
        let record = sensing.measure(&exact, &setup.drives.gain, &mut Random::new(seed));
        let gains = vec![1.0; model.regressor().coordinates().len()];
        let logs = [LogSource::Held(record.to_log("motion", model.regressor().coordinates(), &gains))];
        let options = Options { friction: FRICTION.to_vec(), ..Options::default() };
        let request = IdentifyRequest::of_options(options);
        let found = rist::identify(model, &logs, &request)?.estimate;
        for (i, truth) in truth.iter().enumerate() {
            let found = found.parameters.iter().find(|p| p.id == names[i]).and_then(|p| Some((p.value?, p.sigma?)));
            let known = errors[i].take().zip(found).zip(variance(i));
            errors[i] = known.map(|(((mut over, held), (value, sigma)), variance)| {
                let error = value - truth;
                over.push(error / variance.sqrt());
                (over, held + usize::from(error.abs() <= INTERVAL * sigma))
            });
        }
    }
    let of = |(i, sums): (usize, Option<(Vec<f64>, usize)>)| {
        let (errors, held) = sums?;
        let ratio = (errors.iter().map(|e| e * e).sum::<f64>() / draws as f64).sqrt();
        Some(Kept { name: names[i].to_string(), ratio, errors, held: held as f64 / draws as f64 })
    };
    Ok(errors.into_iter().enumerate().filter_map(of).collect())
}

/// The variances of the parameters `shown`, by weighted least squares on the rows of a motion, as in an identification. `rist
/// excite` predicts the same variances. Here they are computed independently, by normal equations and a Cholesky factorisation.
pub fn promised(
    model: &Model,
    motion: &ExcitingMotion,
    noise: &JointNoise,
    friction: &[FrictionTerm],
    shown: &[usize],
) -> Vec<f64> {
    let weights = noise.weights();
    let rows = information(model, motion, &weights, friction);
    let mut square = DMatrix::zeros(shown.len(), shown.len());
    let mut covariance = square.clone();
    for (k, row) in rows.iter().enumerate() {
        let row = DMatrix::from_fn(1, shown.len(), |_, i| row[shown[i]]);
        let (one, i) = (row.transpose() * row, k % weights.len());
        covariance += &one * (noise.torque[i] / weights[i]).powi(2);
        square += one;
    }
    let inverse = Cholesky::new(square).expect("the motion shows these columns").inverse();
    (&inverse * covariance * &inverse).diagonal().iter().copied().collect()
}
