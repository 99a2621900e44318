//! Validation: compares measured and predicted torques on motions that were not used for identification.
//!
//! The measured torque tau = kt I (kt: drive gain, I: current) is compared with Y X (rigid model) and with Y X + friction. The
//! four friction coefficients of equation (5) are fitted to these motions, because the rows of the paper do not estimate them.
//! Position and torque are filtered by the same zero-phase low-pass. The residual is then thinned to N samples, half a period
//! of the cut-off apart. The residual counts as white if 95 % of its autocorrelations at lags 1 .. 50 are within 1.96/sqrt(N).
//!
//! [Vandanjon, Gautier, Desbats 1995], section 4.3 and figure 2(a-c).

use experiments::motion::record::Record;
use experiments::plan::measured_motion::MeasuredMotion;
use linear_model::friction::periodic::FrictionShape;
use linear_model::reference::ModelReference;
use linear_model::regressor::Regressor;
use linear_model::unit::Unit;
use logs::Error;
use numerics::fourier::circular_differences;
use numerics::least_squares::solve;
use numerics::triangle::TriangleBuilder;

use crate::estimate::validation::{JointValidation, MotionValidation, TorquePicture, Validation};
use crate::signals::butterworth::Butterworth;

/// Number of samples dropped at each end of a motion. The circular differences are wrong at the ends, because they treat the
/// start as the sample after the end.
const BORDER_SAMPLES: usize = 30;
/// Largest number of samples of a plotted torque.
const SAMPLES_PER_PLOT: usize = 400;
/// Order of the low-pass for positions and torques.
const LOW_PASS_ORDER: usize = 4;
/// Largest lag of the autocorrelation, in thinned samples. Successive thinned samples are half a period of the cut-off apart.
const LARGEST_LAG: usize = 50;
/// Half of the 95 % interval of a normal variable, in standard deviations.
const INTERVAL_SIGMAS: f64 = 1.96;
/// Numbers of a plot are rounded to multiples of 1 / `PLOT_ROUNDING`, which is finer than a pixel.
const PLOT_ROUNDING: f64 = 1e4;

/// Measured and predicted torques of one joint in one motion, N m (N), over time, s. `friction`: columns of asymmetric
/// viscous and Coulomb friction.
struct Compared {
    t: Vec<f64>,
    tau: Vec<f64>,
    rigid: Vec<f64>,
    friction: Vec<Vec<f64>>,
}

/// Sums of squares of one joint over all motions.
#[derive(Default)]
struct JointSums {
    squares: f64,
    rigid: f64,
    total: f64,
    count: usize,
    /// One number for each lag of each motion that is long enough: 1 if the autocorrelation of the residual is outside the 95 %
    /// band of white noise, else 0.
    outside: Vec<f64>,
}

impl JointSums {
    /// Adds a motion. `cutoff`: cut-off of the low-pass, cycles per sample. Returns |tau - predicted|^2 and |tau|^2 of the
    /// motion.
    fn add(&mut self, c: &Compared, predicted: &[f64], cutoff: f64) -> (f64, f64) {
        let residual: Vec<f64> = c.tau.iter().zip(predicted).map(|(a, b)| a - b).collect();
        let sum = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let (left, whole) = (sum(&residual), sum(&c.tau));
        self.squares += left;
        self.total += whole;
        self.rigid += c.tau.iter().zip(&c.rigid).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        self.count += residual.len();
        // Only one sample per half period of the cut-off is used, because the low-pass makes closer samples correlated.
        let step = (0.5 / cutoff).ceil() as usize;
        self.outside.extend(not_white(&residual.into_iter().step_by(step.max(1)).collect::<Vec<_>>()));
        (left, whole)
    }

    fn validation(self, coordinate: &str, unit: Unit, friction: Vec<f64>) -> JointValidation {
        JointValidation {
            coordinate: coordinate.into(),
            relative: (self.squares / self.total).sqrt(),
            relative_rigid: Some((self.rigid / self.total).sqrt()),
            rms: (self.squares / self.count.max(1) as f64).sqrt(),
            unit,
            // A motion with fewer than four thinned samples (one per half period of the cut-off) gives no autocorrelation and
            // does not count.
            not_white: (!self.outside.is_empty()).then(|| self.outside.iter().sum::<f64>() / self.outside.len() as f64),
            friction,
        }
    }
}

/// Compares the measured torques of `records`, each with its name, with the torques predicted from `parameters`. `gain`: N m per
/// unit of the record; `cutoff`: cut-off of the low-pass, Hz.
///
/// Fails if a record is too short or too slow for the low-pass, or if its series have different lengths.
pub fn validate_motions(
    model: &ModelReference,
    method: &str,
    regressor: &dyn Regressor,
    parameters: &[f64],
    gain: &[f64],
    records: &[(String, Record)],
    cutoff: f64,
) -> Result<Validation, Error> {
    // For each motion and joint: the filtered measured torques and the torques of the model.
    let compared: Vec<Vec<Compared>> = records
        .iter()
        .map(|(name, record)| compare(name, record, regressor, parameters, gain, cutoff))
        .collect::<Result<_, _>>()?;
    let mut report =
        Validation { model: model.clone(), method: method.into(), cutoff_hz: Some(cutoff), ..Validation::default() };
    let mut left = vec![0.0; records.len()];
    let mut whole = vec![0.0; records.len()];
    // Friction is fitted to all motions of a joint at once. Errors are summed for each joint and each motion.
    for (j, coordinate) in regressor.coordinates().iter().enumerate() {
        let of_joint: Vec<&Compared> = compared.iter().map(|m| &m[j]).collect();
        let friction = fit_friction(&of_joint);
        let mut sums = JointSums::default();
        for (m, c) in of_joint.iter().enumerate() {
            let predicted = predicted(c, &friction);
            let (r, t) = sums.add(c, &predicted, cutoff * records[m].1.sample_time);
            left[m] += r;
            whole[m] += t;
            if m == 0 {
                report.pictures.push(picture(coordinate, c, &predicted));
            }
        }
        let unit = Unit::TORQUE.along(regressor.is_prismatic(j));
        report.joints.push(sums.validation(coordinate, unit, friction));
    }
    // The relative error is sqrt(sum |tau - predicted|^2 / sum |tau|^2).
    let relative = |m: usize| (left[m] / whole[m]).sqrt();
    let motion = |(m, (name, _)): (usize, &(String, Record))| MotionValidation {
        name: name.clone(),
        relative: relative(m),
        joints: Vec::new(),
    };
    report.motions = records.iter().enumerate().map(motion).collect();
    report.total = (left.iter().sum::<f64>() / whole.iter().sum::<f64>()).sqrt();
    Ok(report)
}

fn compare(
    name: &str,
    record: &Record,
    regressor: &dyn Regressor,
    parameters: &[f64],
    gain: &[f64],
    cutoff: f64,
) -> Result<Vec<Compared>, Error> {
    let (n, h) = (gain.len(), record.sample_time);
    let count = record.q.first().map_or(0, Vec::len);
    let Some(filter) = Butterworth::low_pass(LOW_PASS_ORDER, cutoff, 1.0 / h) else {
        return Err(Error::at(name, 0, format!("a sample time of {h} s is too long for a cut-off of {cutoff} Hz")));
    };
    if count < 4 * BORDER_SAMPLES || record.q.len() != n || record.current.len() != n {
        let found =
            format!("{count} samples of {} joints; at least {} of {n} are needed", record.q.len(), 4 * BORDER_SAMPLES);
        return Err(Error::at(name, 0, found));
    }
    let series = || record.q.iter().chain(&record.current);
    if let Some(other) = series().map(Vec::len).find(|length| *length != count) {
        let found =
            format!("a series of {other} samples and one of {count}; all joints of a motion need the same number");
        return Err(Error::at(name, 0, found));
    }
    // The filter has zero phase, so position and torque are not shifted in time relative to each other. The ends of the
    // filtered signals are cut off.
    let smooth: Vec<Vec<f64>> = filter.zero_phase(record.q.clone());
    let (dq, ddq): (Vec<_>, Vec<_>) = smooth.iter().map(|q| circular_differences(q, h)).unzip();
    let cut = |x: &[f64]| x[BORDER_SAMPLES..count - BORDER_SAMPLES].to_vec();
    let cut_all = |x: &[Vec<f64>]| x.iter().map(|x| cut(x)).collect::<Vec<_>>();
    let motion = MeasuredMotion { q: cut_all(&smooth), dq: cut_all(&dq), ddq: cut_all(&ddq) };
    let columns = motion.regressor_columns(regressor);
    let joint = |j: usize| Compared {
        t: (BORDER_SAMPLES..count - BORDER_SAMPLES).map(|i| i as f64 * h).collect(),
        tau: cut(&filter.zero_phase(vec![record.current[j].iter().map(|c| c * gain[j]).collect()])[0]),
        rigid: (0..motion.len()).map(|i| columns[j].iter().zip(parameters).map(|(d, x)| d[i] * x).sum()).collect(),
        friction: FrictionShape::ASYMMETRIC.fill(&motion.dq[j], &motion.ddq[j], &[], h),
    };
    Ok((0..n).map(joint).collect())
}

fn fit_friction(motions: &[&Compared]) -> Vec<f64> {
    let mut block = TriangleBuilder::new(4);
    for c in motions {
        for i in 0..c.tau.len() {
            block.push(&c.friction.iter().map(|f| f[i]).collect::<Vec<_>>(), c.tau[i] - c.rigid[i]);
        }
    }
    solve(&block.finish()).x
}

fn predicted(c: &Compared, friction: &[f64]) -> Vec<f64> {
    let of = |i: usize| c.rigid[i] + c.friction.iter().zip(friction).map(|(f, x)| f[i] * x).sum::<f64>();
    (0..c.tau.len()).map(of).collect()
}

/// For each lag, 1 if the autocorrelation of x is outside the 95 % band of white noise, else 0.
fn not_white(x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let mean = x.iter().sum::<f64>() / n.max(1) as f64;
    let product = |lag: usize| x.iter().zip(&x[lag..]).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    let variance = product(0);
    let band = INTERVAL_SIGMAS / (n as f64).sqrt();
    (1..=LARGEST_LAG.min(n / 4)).map(|lag| f64::from(u8::from((product(lag) / variance).abs() > band))).collect()
}

fn picture(coordinate: &str, c: &Compared, predicted: &[f64]) -> TorquePicture {
    let step = c.t.len().div_ceil(SAMPLES_PER_PLOT).max(1);
    let thin = |x: &[f64]| x.iter().step_by(step).map(|x| (x * PLOT_ROUNDING).round() / PLOT_ROUNDING).collect();
    TorquePicture { coordinate: coordinate.into(), t: thin(&c.t), measured: thin(&c.tau), predicted: thin(predicted) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arm::Pendulum;
    use experiments::motion::point_to_point::{ValidationMotion, validation_trajectory};
    use experiments::simulate::dynamics::torque;
    use random::Random;

    /// Records of three point-to-point motions with friction and noise. `noise`: standard deviation of the torque, N m. The drive
    /// gain is 2 N m/A.
    fn records(arm: &Pendulum, noise: f64) -> Vec<(String, Record)> {
        let mut random = Random::new(4);
        let mut one = |i: usize| {
            let motion = ValidationMotion::default();
            let r = validation_trajectory(&motion, &[(-1.0, 1.0)], &[3.0], &[20.0], 1e-3, &mut random);
            let mut current = Vec::new();
            for t in 0..r.q[0].len() {
                let tau = torque(arm, &arm.truth, &[r.q[0][t]], &[r.dq[0][t]], &[r.ddq[0][t]])[0];
                let friction = 0.3 * r.dq[0][t] + 0.5 * f64::from(r.dq[0][t] > 0.0);
                current.push((tau + friction + noise * random.normal()) / 2.0);
            }
            (format!("v{i}"), Record { sample_time: 1e-3, q: r.q, current: vec![current] })
        };
        (0..3).map(&mut one).collect()
    }

    #[test]
    fn the_truth_predicts_and_a_wrong_model_does_not() {
        let arm = Pendulum::new();
        let model = ModelReference::default();
        let records = records(&arm, 0.05);
        let of = |x: &[f64]| validate_motions(&model, "test", &arm, x, &[2.0], &records, 40.0).unwrap();
        let right = of(&arm.truth);
        assert!(right.total < 0.01, "{right}");
        assert!(right.joints.iter().all(|j| j.relative_rigid.unwrap() > 3.0 * j.relative), "{right}");
        let wrong: Vec<f64> = arm.truth.iter().map(|x| 1.2 * x).collect();
        assert!(of(&wrong).total > 0.05);
        assert_eq!(right.pictures.len(), 1);
        let text = right.to_yaml().unwrap();
        assert_eq!(Validation::from_yaml("validation.yaml", &text).unwrap(), right);
    }

    #[test]
    fn white_noise_is_white_and_a_wave_is_not() {
        let mut random = Random::new(8);
        let noise: Vec<f64> = (0..4000).map(|_| random.normal()).collect();
        let wave: Vec<f64> = (0..4000).map(|i| (0.05 * i as f64).sin()).collect();
        let share = |x: &[f64]| not_white(x).iter().sum::<f64>() / 50.0;
        assert!(share(&noise) < 0.2 && share(&wave) > 0.8);
    }

    #[test]
    fn short_and_unlike_records_are_refused() {
        let arm = Pendulum::new();
        for (positions, currents, said) in
            [(9, 9, "9 samples of 1 joints"), (200, 199, "a series of 199 samples and one of 200")]
        {
            let (q, current) = (vec![vec![0.0; positions]], vec![vec![0.0; currents]]);
            let short = [("v0".into(), Record { sample_time: 1e-3, q, current })];
            let error = validate_motions(&ModelReference::default(), "", &arm, &arm.truth, &[1.0], &short, 40.0);
            let error = error.unwrap_err().to_string();
            assert!(error.starts_with("v0") && error.contains(said), "{error}");
        }
    }

    /// Half of each torque is predicted. So the relative error over both motions is 1/2, and the rms residual is half of
    /// sqrt((3^2 + 4^2 + 12^2) / 3).
    #[test]
    fn residuals_are_those_of_all_samples() {
        let mut sums = JointSums::default();
        for tau in [vec![3.0, 4.0], vec![12.0]] {
            let n = tau.len();
            let compared = Compared { t: vec![0.0; n], rigid: vec![0.0; n], friction: vec![], tau };
            let half: Vec<f64> = compared.tau.iter().map(|tau| 0.5 * tau).collect();
            sums.add(&compared, &half, 0.05);
        }
        let found = sums.validation("q1", Unit::TORQUE, vec![]);
        assert_eq!((found.rms, found.relative, found.relative_rigid), (0.5 * (169.0_f64 / 3.0).sqrt(), 0.5, Some(1.0)));
    }

    #[test]
    fn too_few_samples_are_neither_white_nor_not() {
        let mut random = Random::new(5);
        let of = |n: usize, random: &mut Random| {
            let tau: Vec<f64> = (0..n).map(|_| random.normal()).collect();
            let compared = Compared { t: vec![0.0; n], rigid: vec![0.0; n], friction: vec![], tau };
            let mut sums = JointSums::default();
            // At 0.05 cycles per sample, half a period is ten samples: every tenth sample is used.
            sums.add(&compared, &vec![0.0; n], 0.05);
            sums.validation("q1", Unit::TORQUE, vec![])
        };
        assert!(of(40, &mut random).not_white.is_some());
        let few = of(30, &mut random);
        assert_eq!(few.not_white, None);
        let whole =
            Validation { joints: vec![JointValidation { relative_rigid: None, ..few }], ..Validation::default() };
        let text = whole.to_string();
        let row = text.lines().find(|line| line.starts_with("q1")).unwrap();
        let cells: Vec<&str> = row.split_whitespace().collect();
        assert!(cells[2] == "-" && cells[4] == "-" && !text.contains("NaN%"), "{text}");
    }
}
