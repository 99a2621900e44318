//! Whether an exciting motion keeps what it promises: the covariance of the parameters by the information of the motion
//! itself, and the errors of what is identified from simulated logs of it.

use identification::algebra::information_matrix::Rows;
use identification::estimate::identified::INTERVAL;
use identification::experiments::excitation::artefact::ExcitingMotion;
use identification::model::friction::terms::{FrictionTerm, sign};
use identification::model::parameter::ParameterId;
use identification::simulate::dynamics::RegressorDynamics;
use identification::simulate::setup::SimulationSetup;
use logs::LogSource;
use nalgebra::{Cholesky, DMatrix};
use rist::simulation::SimulateRequest;
use rist::{Error, IdentifyRequest, Model};

/// The columns of [`information`]: base parameters, then the friction of each joint.
pub fn columns(model: &Model, friction: &[FrictionTerm]) -> Vec<ParameterId> {
    let base = model.regressor().parameters().iter().map(|p| ParameterId::Base(p.name.clone()));
    let own = |c| friction.iter().flat_map(|t| t.parameters()).map(move |f| ParameterId::friction(*f, c));
    base.chain(model.regressor().coordinates().iter().flat_map(|c| own(c.as_str()))).collect()
}

/// The information of a motion about base parameters and friction, over the noise of each joint: rows over N m, of all
/// samples of its repetitions.
pub fn information(model: &Model, motion: &ExcitingMotion, noise: &[f64], friction: &[FrictionTerm]) -> Rows {
    let regressor = model.regressor();
    let (n, base) = (regressor.coordinates().len(), regressor.parameters().len());
    let played = motion.motion("motion").unwrap();
    let own: usize = friction.iter().map(|t| t.parameters().len()).sum();
    let mut rows = Rows::new(base + n * own);
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

/// The friction that simulated joints have: equation (5).
pub const FRICTION: [FrictionTerm; 1] = [FrictionTerm::Asymmetric];

/// What became of a promise.
pub struct Kept {
    /// The base parameter.
    pub name: String,
    /// Root mean square error over the promised deviation.
    pub ratio: f64,
    /// Share of the draws whose 95 % interval holds the truth.
    pub held: f64,
}

/// Simulates the motion as the robot would play it, with its friction and noise, and identifies it with
/// this friction and defaults else,
/// `draws` times: what each base parameter keeps of the promise that the motion makes for that noise of the torques. Those that
/// the motion or the logs leave open are left out.
pub fn kept(model: &Model, motion: &ExcitingMotion, draws: u64) -> Result<Vec<Kept>, Error> {
    let truth = model.described_parameters().expect("inertial parameters in the description");
    let dynamics = RegressorDynamics::new(model.regressor(), truth.clone());
    let noise = SimulationSetup::for_robot(&model.robot, &dynamics).sensing.torque_noise;
    let (names, rows) = (columns(model, &FRICTION), information(model, motion, &noise, &FRICTION));
    let is_shown = |name: &ParameterId| motion.parameters.iter().any(|p| p.id == *name && p.deviation.is_some());
    let shown: Vec<usize> = (0..names.len()).filter(|&i| is_shown(&names[i])).collect();
    let mut square = DMatrix::zeros(shown.len(), shown.len());
    for row in rows.iter() {
        let row = DMatrix::from_fn(1, shown.len(), |_, i| row[shown[i]]);
        square += row.transpose() * row;
    }
    let covariance = Cholesky::new(square).expect("the motion shows these columns").inverse();
    let variance = |i: usize| shown.iter().position(|s| *s == i).map(|place| covariance[(place, place)]);
    let mut errors: Vec<Option<(f64, usize)>> = (0..truth.len()).map(|i| variance(i).map(|_| (0.0, 0))).collect();
    for seed in 1..=draws {
        let mut logs = Vec::new();
        let request = SimulateRequest { validation_motions: 0, seed, ..Default::default() };
        let gains = vec![1.0; model.regressor().coordinates().len()];
        rist::simulate(model, motion, &request, &mut |name, record| {
            logs.push(LogSource::Held(record.to_log(name, model.regressor().coordinates(), &gains)));
            Ok(())
        })?;
        let mut request = IdentifyRequest::default();
        request.options.friction = FRICTION.to_vec();
        let found = rist::identify(model, &logs, &request)?.estimate;
        for (i, truth) in truth.iter().enumerate() {
            let found = found.parameters.iter().find(|p| p.id == names[i]).and_then(|p| Some((p.value?, p.sigma?)));
            errors[i] = errors[i].zip(found).zip(variance(i)).map(|(((sum, held), (value, sigma)), variance)| {
                let error = value - truth;
                (sum + error.powi(2) / variance, held + usize::from(error.abs() <= INTERVAL * sigma))
            });
        }
    }
    let of = |(name, sums): (&ParameterId, &Option<(f64, usize)>)| {
        let (sum, held) = (*sums)?;
        let draws = draws as f64;
        Some(Kept { name: name.to_string(), ratio: (sum / draws).sqrt(), held: held as f64 / draws })
    };
    Ok(names.iter().zip(&errors).filter_map(of).collect())
}
