//! Runs `rist identify` on a situation, and compares its answers with the true values.
//!
//! A situation has a machine (the true robot), a description, and one or two logs. "As logged" means: in the unit of the logged
//! torques. If all torques of a log have a common wrong scale, no method can detect this without further information, so errors
//! are also computed relative to the scaled true values. `of_use` is a further motion on which predicted torques are compared.

use claims::{Claim, EvidenceLevel, Subject};
use identification::estimate::artefact::Estimate;
use identification::estimate::topics::ROTOR;
use linear_model::friction::terms::FrictionTerm;
use linear_model::linear_model::Model as LinearModel;
use linear_model::parameter::{FrictionParameter, ParameterId};
use linear_model::regressor::predict_load;
use linear_model::states::States;
use logs::ColumnNames;
use rist::fit::verdict::{Trust, Verdict};
use rist::request::IdentifyRequest;
use rist::{Error, LogSource, Model};

use super::Situation;
use super::chain::Chain;
use super::defects::{Defect, Kind};
use super::sensors::zero;
use super::torque::{FINE, series, standing};
use super::truth::{Truth, truth};

/// An error, and the name of the joint or parameter with this error.
pub type Worst = (String, f64);

pub struct Judgement {
    /// Relative error |predicted - true| / |true| of the whole motor torque, on a motion that was not logged (`of_use`).
    pub torque: f64,
    /// The relative torque error in the unit of the logged torques: the true torque is multiplied by the wrong scale of the log.
    pub as_logged: f64,
    /// Relative error of the torque of bodies and rotors, without friction.
    pub rigid: f64,
    /// The joint with the largest relative torque error.
    pub worst_joint: Worst,
    /// The parameter with the largest error in units of its standard deviation.
    pub worst_sigma: Worst,
    /// The parameter with the largest error in units of its standard deviation, if errors are computed in the unit of the logged
    /// torques: if all torques have the same wrong scale, the true parameters are multiplied by it.
    pub worst_sigma_as_logged: Worst,
    /// For each parameter: name, value, standard deviation, true value.
    pub parameters: Vec<(String, f64, f64, f64)>,
    /// Relative residual of the true torques after a fit with the columns of the model. It must be only a rounding error.
    pub left: f64,
    /// Number of rotors whose inertia no column of the model can represent.
    pub unsaid: usize,
}

pub struct Outcome {
    /// The level of trust; `None` if the program ended with an error.
    pub trust: Option<Trust>,
    pub verdict: Option<Verdict>,
    pub said: String,
    pub judgement: Option<Judgement>,
}

impl Outcome {
    pub fn is_yes(&self) -> bool {
        self.trust == Some(Trust::Yes)
    }

    pub fn is_with_care(&self) -> bool {
        self.trust == Some(Trust::WithCare)
    }

    /// Whether the torque on another motion has an error of more than 5 %.
    pub fn predicts_wrong(&self) -> bool {
        self.judgement.as_ref().is_some_and(|j| beyond(j.torque, 0.05))
    }

    /// Whether the torque error also exceeds 5 % in the unit of the logged torques.
    pub fn predicts_wrong_as_logged(&self) -> bool {
        self.judgement.as_ref().is_some_and(|j| beyond(j.as_logged, 0.05))
    }

    /// Whether the torque of the bodies has an error of more than 5 %.
    pub fn bodies_wrong(&self) -> bool {
        self.judgement.as_ref().is_some_and(|j| beyond(j.rigid, 0.05))
    }

    /// Whether a parameter has an error of more than five standard deviations.
    pub fn is_oversure(&self) -> bool {
        self.judgement.as_ref().is_some_and(|j| beyond(j.worst_sigma.1, 5.0))
    }

    /// Whether a parameter has an error of more than five standard deviations also in the unit of the logged torques.
    pub fn is_oversure_as_logged(&self) -> bool {
        self.judgement.as_ref().is_some_and(|j| beyond(j.worst_sigma_as_logged.1, 5.0))
    }

    /// Whether the torque is within 2 %, and all parameters are within four standard deviations.
    pub fn is_good(&self) -> bool {
        self.judgement.as_ref().is_some_and(|j| j.torque <= 0.02 && j.worst_sigma.1 <= 4.0)
    }
}

/// Whether an error exceeds a bound or is NaN.
fn beyond(error: f64, bound: f64) -> bool {
    error.is_nan() || error > bound
}

/// The joints whose rotor inertia, according to an open claim of the program, is included in other parameters.
fn said_within(verdict: &Verdict, n: usize) -> Vec<usize> {
    let is_said = |k: &usize| {
        let rotor = Subject::of(ROTOR, [format!("joint_{}", k + 1)]);
        let is_open = |claim: &&Claim| claim.subject().touches(&rotor) && claim.standing() == EvidenceLevel::Open;
        verdict.claims.iter().any(|claim| is_open(&claim))
    };
    (0..n).filter(is_said).collect()
}

impl Situation {
    /// Runs `rist identify` with default options, and compares its answers with the true values. `fits_all`: all logs are fitted;
    /// otherwise only the first log is fitted, and its estimate predicts the other log.
    pub fn outcome(&self, fits_all: bool) -> Outcome {
        let model = self.model();
        match self.identified(&model, fits_all) {
            Ok(outcome) => outcome,
            Err(error) => Outcome { trust: None, verdict: None, said: format!("{error}\n"), judgement: None },
        }
    }

    fn identified(&self, model: &Model, fits_all: bool) -> Result<Outcome, Error> {
        let mut sources = Vec::new();
        let mut said = String::new();
        for i in 0..self.motions.len() {
            let (log, columns) = model.log_of_table(self.log(i), &ColumnNames::default())?;
            said += &format!("{columns}\n{}\n", log.report());
            sources.push(log);
        }
        let fitted = if fits_all { sources.len() } else { 1 };
        let (fitted, others): (&[LogSource], &[LogSource]) = sources.split_at(fitted);
        let mut found = rist::identify(model, fitted, &IdentifyRequest::default())?;
        let judged = found.verdict_of_logs(model, others, false)?;
        said += &found.estimate.to_string();
        for finding in &found.log_check.findings {
            said += &format!("{finding}\n");
        }
        for (log, residuals) in &judged.predictions {
            said += &format!("\n{log}, not fitted:\n{residuals}");
        }
        said += &format!("\n{}", judged.verdict);
        let within = said_within(&judged.verdict, self.machine.chain.len());
        let judgement = self.judgement(found.used(model), &found.estimate, &within);
        let trust = Some(judged.verdict.trust);
        Ok(Outcome { trust, verdict: Some(judged.verdict), said, judgement: Some(judgement) })
    }

    /// Compares the estimate with the true values. `within`: joints whose rotor inertia is included in other parameters,
    /// according to the program.
    pub fn judgement(&self, model: &Model, estimate: &Estimate, within: &[usize]) -> Judgement {
        let options = estimate.options.clone().unwrap_or_default();
        let couplings = options.transmission.coupled();
        let linear = LinearModel::new(model.regressor(), &options.friction, &couplings);
        let x: Vec<f64> = linear.parameters.iter().map(|p| estimate.prediction(&p.id).unwrap_or(f64::NAN)).collect();
        let chain = standing(&self.machine, &self.defects, self.is_loaded(0));
        let joints = self.machine.chain.len();
        let errors = |units: &[f64]| self.torque_errors(&linear, &chain, &x, &options.friction_load, units);
        let (torque, rigid, worst_joint) = errors(&vec![1.0; joints]);
        let scales: Vec<f64> = (0..joints).map(|k| self.logged_scale(k)).collect();
        let (as_logged, ..) = errors(&scales);
        // The parameters belong to the model that was used for the estimate. The program may have tilted its base.
        let as_modelled = Chain { gravity: model.robot.gravity_number(), ..chain };
        let true_base = truth(&as_modelled, model.regressor(), within);
        let true_value = |id: &ParameterId| self.true_value(id, model, &true_base, &options.friction);
        let one = |p: &identification::estimate::identified::Identified| {
            Some((p.id.to_string(), p.value?, p.sigma?, true_value(&p.id)?))
        };
        let parameters: Vec<(String, f64, f64, f64)> = estimate.parameters.iter().filter_map(one).collect();
        let worst = |scale: f64| {
            let off = |(_, value, sigma, exact): &(String, f64, f64, f64)| (value - scale * exact).abs() / sigma;
            let worst = parameters.iter().max_by(|a, b| off(a).total_cmp(&off(b)));
            worst.map_or((String::new(), 0.0), |p| (p.0.clone(), off(p)))
        };
        // If all torques have the same wrong scale, all parameters have this scale too.
        let of_all = if scales.iter().all(|scale| *scale == scales[0]) { scales[0] } else { 1.0 };
        let (worst_sigma, worst_sigma_as_logged) = (worst(1.0), worst(of_all));
        Judgement {
            torque,
            as_logged,
            rigid,
            worst_joint,
            worst_sigma,
            worst_sigma_as_logged,
            parameters,
            left: true_base.left,
            unsaid: true_base.unsaid.len(),
        }
    }

    /// Errors of the torque on the motion `of_use`: of the whole torque, of the bodies, and of the worst joint. `load`: base
    /// parameters that predict the load torque, if friction depends on it. `units`: for each joint, the factor by which the true
    /// torque is multiplied.
    fn torque_errors(
        &self,
        linear: &LinearModel,
        chain: &Chain,
        x: &[f64],
        load: &[f64],
        units: &[f64],
    ) -> (f64, f64, Worst) {
        /// Number of steps of the fine time grid between two states.
        const EVERY: usize = 20;
        let n = chain.len();
        let series = series(&self.machine, chain, &self.of_use, &self.defects);
        let zeros: Vec<f64> = (0..n).map(|k| zero(&self.machine, &self.defects, k)).collect();
        let mut states = States { n, period: EVERY as f64 / FINE, ..States::default() };
        let mut rigid_tau = Vec::new();
        for i in (0..series.steps()).step_by(EVERY) {
            states.t.push(i as f64 / FINE);
            for k in 0..n {
                states.q.push(series.theta[k][i] - zeros[k]);
                states.dq.push(series.dtheta[k][i]);
                states.ddq.push(series.ddq[k][i]);
                states.tau.push(series.tau[k][i]);
                states.direction.push(if series.dtheta[k][i] == 0.0 { 0.0 } else { series.dtheta[k][i].signum() });
                states.used.push(true);
                rigid_tau.push(series.rigid[k][i]);
            }
        }
        states.motor_direction = vec![0.0; states.len() * linear.couplings.len()];
        if !load.is_empty() {
            predict_load(linear.regressor, &mut states, load);
        }
        let (p, base) = (linear.p(), linear.regressor.parameters().len());
        let (mut error, mut size, mut of_bodies, mut bodies) = (vec![0.0; n], vec![0.0; n], 0.0, 0.0);
        linear.rows(&states, 0..states.len(), |r, w| {
            for k in 0..n {
                let row = &w[k * p..][..p];
                let sum = |range: std::ops::Range<usize>| range.map(|c| row[c] * x[c]).sum::<f64>();
                let (tau, rigid) = (units[k] * states.tau[r * n + k], rigid_tau[r * n + k]);
                error[k] += (sum(0..p) - tau).powi(2);
                size[k] += tau * tau;
                of_bodies += (sum(0..base) - rigid).powi(2);
                bodies += rigid * rigid;
            }
        });
        let of_joint = |k: usize| (error[k] / size[k]).sqrt();
        let worst = (0..n).max_by(|&a, &b| of_joint(a).total_cmp(&of_joint(b))).unwrap_or(0);
        let total = (error.iter().sum::<f64>() / size.iter().sum::<f64>()).sqrt();
        (total, (of_bodies / bodies).sqrt(), (format!("joint_{}", worst + 1), of_joint(worst)))
    }

    /// The wrong scale of the log of joint k: logged torque divided by true torque.
    fn logged_scale(&self, k: usize) -> f64 {
        let is_scale = |d: &&Defect| d.kind == Kind::ScaleOfAll || d.kind == Kind::ScaleOfJoint && d.joint == k;
        self.defects.iter().filter(is_scale).map(Defect::factor).product()
    }

    /// The true value of a parameter. `None` if it has none, for example Coulomb friction FS if the friction of the machine
    /// follows another law.
    fn true_value(&self, id: &ParameterId, model: &Model, truth: &Truth, terms: &[FrictionTerm]) -> Option<f64> {
        let has = |kind: Kind| self.defects.iter().any(|d| d.kind == kind);
        match id {
            ParameterId::Base(name) => {
                let column = model.regressor().parameters().iter().position(|p| p.name == *name)?;
                Some(truth.base[column])
            }
            ParameterId::Friction(parameter, _) => {
                let is_other =
                    [Kind::Stribeck, Kind::Bristle, Kind::LoadFriction, Kind::Asymmetric].into_iter().any(has);
                let coordinates = model.regressor().coordinates();
                let k = coordinates.iter().position(|c| ParameterId::friction(*parameter, c) == *id)?;
                // If the model has a friction term of another law for this joint, none of the joint's friction parameters has a
                // true value.
                let is_alone = |term: &FrictionTerm| !matches!(term, FrictionTerm::At(number, _) if *number == k + 1);
                if is_other || !terms.starts_with(&FrictionTerm::STANDARD) || !terms.iter().all(is_alone) {
                    return None;
                }
                let friction = self.machine.friction.get(k)?;
                match parameter {
                    FrictionParameter::Viscous => Some(friction.viscous),
                    FrictionParameter::Coulomb => Some(friction.coulomb),
                    FrictionParameter::Offset if !has(Kind::Spring) => Some(friction.offset + truth.offsets[k]),
                    _ => None,
                }
            }
            _ => None,
        }
    }
}
