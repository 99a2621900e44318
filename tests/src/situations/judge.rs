//! What rist says of a situation, and whether it is true.

use linear_model::parameter::ParameterId;
use logs::{LogSource, Table};
use rist::Model;
use rist::request::IdentifyRequest;
use rist::verdict::{Trust, Verdict};

use crate::joint_log::JointLog;
use crate::random::Random;
use crate::situations::Situation;
use crate::situations::motion::Motion;

/// What came out.
pub struct Judgement {
    pub trust: Trust,
    /// Error of the torque without friction on another motion, relative.
    pub torque_error: f64,
    /// Largest error of an inertial base parameter, in its printed deviations.
    pub sigmas: f64,
    pub verdict: Option<Verdict>,
    /// Why there is no estimate, where there is none.
    pub refused: Option<String>,
}

impl Judgement {
    /// Whether the estimate is right.
    pub fn is_good(&self) -> bool {
        self.torque_error < 0.02 && self.sigmas < 4.0
    }
}

/// Identifies as `rist identify` does, and compares with the truth.
pub fn judge(situation: &Situation, model: &Model) -> Judgement {
    let Situation { machine, motions, sensors, .. } = situation;
    let mut random = Random(0xbeef + situation.seed);
    let names = model.regressor().coordinates();
    let mut source = |motion: &Motion, faulty: bool| -> Result<LogSource, rist::Error> {
        let log = sensors.log(machine, motion, faulty, &mut random);
        model.log_of_table(table(&log, names), &Default::default()).map(|(log, _)| log)
    };
    let refused = |e: rist::Error| Judgement {
        trust: Trust::No,
        torque_error: f64::INFINITY,
        sigmas: f64::INFINITY,
        verdict: None,
        refused: Some(e.to_string()),
    };
    let fitted = match source(&motions[0], true) {
        Ok(log) => [log],
        Err(e) => return refused(e),
    };
    let second = situation.has_second.then(|| source(&motions[1], situation.second_is_faulty)).transpose();
    let others: Vec<LogSource> = match second {
        Ok(log) => log.into_iter().collect(),
        Err(e) => return refused(e),
    };
    let mut found = match rist::identify(model, &fitted, &IdentifyRequest::default()) {
        Ok(found) => found,
        Err(e) => return refused(e),
    };
    let verdict = match found.judged(model, &others, false) {
        Ok(judged) => judged.verdict,
        Err(e) => return refused(e),
    };
    let used = found.used(model);
    let value = |name: &ParameterId| found.estimate.prediction(name).unwrap_or(0.0);
    let regressor = used.regressor();
    let x: Vec<f64> = regressor.parameters().iter().map(|p| value(&ParameterId::Base(p.name.clone()))).collect();
    let (n, p) = (names.len(), x.len());

    // Another motion of the same robot, at the speeds of a robot that works.
    let mut draw = Random(0xfeed + situation.seed);
    let other = Motion::random(&machine.robot, 1, &mut draw);
    let (mut left, mut whole) = (0.0, 0.0);
    let mut y = vec![0.0; n * p];
    let (mut rows, mut torques): (Vec<Vec<f64>>, Vec<f64>) = (Vec::new(), Vec::new());
    for i in 0..300 {
        let state = other.at(0.09 * f64::from(i));
        let truth = machine.rigid(&state);
        regressor.fill(&state.q, &state.dq, &state.ddq, &mut y);
        for (row, truth) in y.chunks(p).zip(truth) {
            left += (row.iter().zip(&x).map(|(y, x)| y * x).sum::<f64>() - truth).powi(2);
            whole += truth * truth;
            rows.push(row.to_vec());
            torques.push(truth);
        }
    }
    let sigmas = sigmas(&found.estimate, used, &truth(situation, used, &rows, &torques));
    Judgement {
        trust: verdict.trust,
        torque_error: (left / whole).sqrt(),
        sigmas,
        verdict: Some(verdict),
        refused: None,
    }
}

/// The true base parameters of the model that was used: of its own columns, fitted to true torques, which they explain
/// wholly unless the model has no rotors.
fn truth(situation: &Situation, model: &Model, rows: &[Vec<f64>], torques: &[f64]) -> Option<Vec<f64>> {
    let standard = &model.parameters.standard;
    let machine = &situation.machine;
    let mine = robot::StandardParameter::all(&machine.robot);
    let has_rotors = standard.iter().any(|p| p.inertial == robot::Inertial::Ia);
    if !has_rotors && machine.rotors.iter().any(|r| *r > 0.0) {
        return None;
    }
    let value = |p: &robot::StandardParameter| {
        let same = |q: &robot::StandardParameter| q.link == p.link && q.inertial == p.inertial;
        match (mine.iter().position(same), p.inertial) {
            (Some(c), _) => machine.bodies[c],
            (None, robot::Inertial::Ia) => {
                let link = &model.robot.link(p.link).joint.variable;
                link.terms.first().map_or(0.0, |(k, _)| machine.rotors[k.0])
            }
            _ => 0.0,
        }
    };
    let x: Vec<f64> = standard.iter().map(value).collect();
    let base = model.parameters.values(&x);
    // The law that makes this a truth: its columns give the machine's torque.
    let of = |row: &Vec<f64>| row.iter().zip(&base).map(|(y, x)| y * x).sum::<f64>();
    let size = torques.iter().map(|t| t * t).sum::<f64>().sqrt();
    let left = rows.iter().zip(torques).map(|(row, t)| (of(row) - t).powi(2)).sum::<f64>().sqrt();
    assert!(left < 1e-8 * size, "situation {}: the truth leaves {}", situation.seed, left / size);
    Some(base)
}

fn sigmas(estimate: &rist::Estimate, model: &Model, truth: &Option<Vec<f64>>) -> f64 {
    // Without rotors in the model there is no truth to compare with.
    let Some(truth) = truth else { return 0.0 };
    let names = model.regressor().parameters().iter().map(|p| ParameterId::Base(p.name.clone()));
    let off = |(name, truth): (ParameterId, &f64)| {
        let found = estimate.parameters.iter().find(|p| p.id == name)?;
        Some((found.value? - truth).abs() / found.sigma?)
    };
    names.zip(truth).filter_map(off).fold(0.0, f64::max)
}

fn table(log: &JointLog, names: &[String]) -> Table {
    let named = |quantity: &str, series: &[Vec<f64>]| -> Vec<(String, Vec<f64>)> {
        names.iter().zip(series).map(|(name, x)| (format!("{quantity}_{name}"), x.clone())).collect()
    };
    let mut columns = vec![("t".to_string(), log.t.clone())];
    for (quantity, series) in [("q", &log.q), ("dq", &log.dq), ("tau", &log.tau)] {
        columns.extend(named(quantity, series));
    }
    let (header, columns): (Vec<String>, Vec<Vec<f64>>) = columns.into_iter().unzip();
    let texts = vec![None; header.len()];
    Table { file: "situation.csv".into(), header, columns, texts, ..Table::default() }
}
