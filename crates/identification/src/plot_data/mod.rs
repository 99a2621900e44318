//! Plot data of logs and of their prediction by an estimate, for each joint; of limited size for logs of any length.
//!
//! Torques over time are stored as the smallest and the largest value of each of several hundred spans ([`envelope`]).
//! Friction is stored as one point per cell of a grid ([`friction_cloud`]). The residual also has its spectrum
//! ([`spectrum`]) and its autocorrelation (`estimate::autocorrelation`). [`mod@split`] computes the components of a joint's
//! torque, and [`series`] writes measured and predicted torques sample by sample. [`motion_plot_data`] contains plot data of
//! a planned exciting motion, and [`information`] the leverage of rows on parameters.

pub mod envelope;
pub mod friction_cloud;
pub mod information;
pub mod motion_plot_data;
pub mod series;
pub mod spectrum;
pub mod split;

use linear_model::linear_model::Model;
use linear_model::unit::Unit;
use logs::{Error, LogSource};
use numerics::triangle::Triangle;

use crate::estimate::autocorrelation::Autocorrelation;
use crate::estimate::nominal_prediction::nominal_values;
use crate::estimate::options::Options;
use crate::plot_data::envelope::{DRAWN_SPANS, Envelope};
use crate::plot_data::friction_cloud::FrictionCloud;
use crate::plot_data::information::{Information, InformationSums};
use crate::plot_data::spectrum::{Spectrum, noise_density};
use crate::plot_data::split::{JointTorque, split};
use crate::rows::observation::Observation;
use crate::signals::records::{Records, SourceRecords};

/// Gap between two logs on their common axis, as a share of the duration of all logs.
const GAP_BETWEEN_LOGS_SHARE: f64 = 0.01;

/// Number of spans of one kind of line (such as the measured torque), summed over all joints. A span has the smallest and largest
/// value of several samples. The number is large enough to zoom into a short log.
const SPANS_OF_ALL_JOINTS: usize = 12_000;
/// Largest number of spans of a line over time.
const MOST_SPANS_PER_LINE: usize = 4000;

/// Plot data of logs and of their prediction by an estimate.
#[derive(Clone, Debug, Default)]
pub struct PlotData {
    /// The logs on a common time axis, one after the other.
    pub logs: Vec<LogSpan>,
    /// Plot data of each joint, one per coordinate.
    pub joints: Vec<JointPlotData>,
    /// Number of samples of each joint over all logs, after decimation.
    pub samples: usize,
    /// Partial leverage of rows on parameters, and correlation of parameters.
    pub information: Information,
}

/// The interval that a log takes on the common time axis.
#[derive(Clone, Debug, PartialEq)]
pub struct LogSpan {
    /// Name of the log, as the user gave it.
    pub name: String,
    /// Start on the common axis, s.
    pub from: f64,
    /// End on the common axis, s.
    pub to: f64,
}

/// Plot data of one joint. Torques are in N m (N) and filtered as for the fit.
#[derive(Clone, Debug, Default)]
pub struct JointPlotData {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Unit of the joint's torque.
    pub unit: String,
    /// Whether the joint is prismatic.
    pub is_prismatic: bool,
    /// The measured torque over the common time axis.
    pub measured: Envelope,
    /// The predicted torque over time: Y X, friction and couplings.
    pub predicted: Envelope,
    /// The nominal torque with fitted friction over time; `None` if the description has no inertials. The lines `measured`,
    /// `predicted`, `nominal`, `residual` and `course` of all joints have equal spans.
    pub nominal: Option<Envelope>,
    /// The residual over time: measured minus predicted torque; NaN in unused rows.
    pub residual: Envelope,
    /// The position over time, rad (m).
    pub course: Envelope,
    /// Components of the torque over time: inertia, Coriolis and centrifugal, gravity, friction.
    pub parts: [Envelope; 4],
    /// Root mean squares of the components, in the order of `parts`.
    pub part_rms: [f64; 4],
    /// Root mean square of the measured torque.
    pub torque_rms: f64,
    /// Root mean square of the residual.
    pub residual_rms: f64,
    /// Smallest and largest position, rad (m).
    pub position: (f64, f64),
    /// Largest speed, rad/s (m/s).
    pub speed: f64,
    /// Largest acceleration, rad/s^2 (m/s^2).
    pub acceleration: f64,
    /// Largest magnitude of the measured torque.
    pub effort: f64,
    /// Spectrum of the residual: pairs (Hz, N m/sqrt(Hz)).
    pub residual_spectrum: Vec<(f64, f64)>,
    /// Spectrum of the measured torque: pairs (Hz, N m/sqrt(Hz)).
    pub torque_spectrum: Vec<(f64, f64)>,
    /// Noise of the measured torque: level of its spectrum far above the cut-off, where there is no motion, N m/sqrt(Hz).
    /// `None` if the log has no content at these frequencies.
    pub noise: Option<f64>,
    /// Autocorrelation of the residual: pairs (lag in s, rho).
    pub autocorrelation: Vec<(f64, f64)>,
    /// Half width of the 95 % interval in which rho lies if the residual is white noise.
    pub autocorrelation_band: f64,
    /// Measured friction: pairs (speed in rad/s, torque in N m). The torque is the measured torque minus inertia, Coriolis,
    /// centrifugal and gravity torques.
    pub friction: Vec<(f64, f64)>,
    /// The friction law of the estimate: pairs (speed in rad/s, torque in N m).
    pub friction_law: Vec<(f64, f64)>,
}

/// Collects the plot data of one joint while logs are read, with the sums that complete the plot data at the end.
struct Gathered {
    plot_data: JointPlotData,
    squares: [f64; 6],
    rows: usize,
    used: usize,
    cloud: FrictionCloud,
    residual_spectrum: Spectrum,
    torque_spectrum: Spectrum,
}

/// Makes plot data of logs and of the torques that the model predicts with parameters `x`. `options`: options of the estimate,
/// with its cut-off; `described`: nominal base parameters, if known.
///
/// Fails if a log cannot be read.
pub fn plot_data(
    model: &Model,
    x: &[f64],
    described: Option<&[f64]>,
    options: &Options,
    logs: &[LogSource],
) -> Result<PlotData, Error> {
    let mut plot_data = PlotData::default();
    let mut autocorrelation = Autocorrelation::new(model.n(), None);
    let duration: f64 = logs.iter().map(|log| log.report().clock.duration).sum();
    let gap = GAP_BETWEEN_LOGS_SHARE * duration;
    let rows = rows(model, options, logs)?;
    let described = described.map(|known| nominal_values(model, &rows, &vec![1.0; rows.len()], known));
    let axis = duration + gap * logs.len().saturating_sub(1) as f64;
    let mut information = InformationSums::new(model, &rows, options, axis);
    let mut joints: Vec<Gathered> = (0..model.n()).map(|j| Gathered::new(model, j, described.is_some())).collect();
    for log in logs {
        // Logs follow each other on a common time axis, with a gap between them.
        let from = plot_data.logs.last().map_or(0.0, |span: &LogSpan| span.to + gap);
        let records = SourceRecords::new(model.regressor, std::slice::from_ref(log), &options.preparation())?;
        let (mut begin, mut to) = (None, from);
        records.each(&mut |states| {
            let Some(first) = states.t.first() else { return };
            // A log is read block by block. The first sample of the first block is the start of the log's interval.
            let shift = from - *begin.get_or_insert(*first);
            joints.iter_mut().for_each(|joint| joint.begin(states.period));
            let mut residuals = vec![vec![f64::NAN; states.len()]; model.n()];
            split(model, x, described.as_deref(), states, |r, torques| {
                to = states.t[r] + shift;
                for (j, (joint, torque)) in joints.iter_mut().zip(torques).enumerate() {
                    joint.add(to, torque);
                    if torque.counts {
                        residuals[j][r] = torque.residual();
                    }
                }
                plot_data.samples += 1;
            });
            information.add(model, states, shift);
            autocorrelation.add_record(&residuals, states.period);
        })?;
        plot_data.logs.push(LogSpan { name: log.name(), from, to });
    }
    plot_data.information = information.finish();
    // These results need all samples: noise, autocorrelation, friction law.
    let base = model.regressor.parameters().len();
    let noise = noise_density(options, logs)?;
    for (j, (joint, noise)) in joints.into_iter().zip(noise).enumerate() {
        let mut found = joint.finish();
        found.noise = noise;
        found.autocorrelation = autocorrelation.of_joint(j);
        found.autocorrelation_band = autocorrelation.band(j);
        found.friction_law = friction_cloud::law(model, &x[base..], j, found.speed);
        plot_data.joints.push(found);
    }
    Ok(plot_data)
}

/// The rows of all logs, as one triangle (R of QR) per joint.
fn rows(model: &Model, options: &Options, logs: &[LogSource]) -> Result<Vec<Triangle>, Error> {
    let records = SourceRecords::new(model.regressor, logs, &options.preparation())?;
    Ok(Observation::of_records(model, &records, None)?.joints(|_| true))
}

impl Gathered {
    fn new(model: &Model, j: usize, is_described: bool) -> Gathered {
        let is_prismatic = model.regressor.is_prismatic(j);
        let spans = (SPANS_OF_ALL_JOINTS / model.n().max(1)).clamp(DRAWN_SPANS, MOST_SPANS_PER_LINE);
        let line = || Envelope::of_spans(spans);
        let plot_data = JointPlotData {
            measured: line(),
            predicted: line(),
            nominal: is_described.then(line),
            residual: line(),
            course: line(),
            coordinate: model.regressor.coordinates()[j].clone(),
            unit: Unit::TORQUE.along(is_prismatic).to_string(),
            is_prismatic,
            position: (f64::INFINITY, f64::NEG_INFINITY),
            ..JointPlotData::default()
        };
        Gathered {
            plot_data,
            squares: [0.0; 6],
            rows: 0,
            used: 0,
            cloud: FrictionCloud::default(),
            residual_spectrum: Spectrum::default(),
            torque_spectrum: Spectrum::default(),
        }
    }

    /// Starts a record: interrupts all lines. `period`: time between samples, s.
    fn begin(&mut self, period: f64) {
        let joint = &mut self.plot_data;
        let together = [&mut joint.measured, &mut joint.predicted, &mut joint.residual, &mut joint.course];
        together.into_iter().chain(&mut joint.nominal).chain(&mut joint.parts).for_each(Envelope::interrupt);
        self.residual_spectrum.begin(period);
        self.torque_spectrum.begin(period);
    }

    fn add(&mut self, t: f64, torque: &JointTorque) {
        let joint = &mut self.plot_data;
        joint.measured.push(t, torque.measured);
        joint.predicted.push(t, torque.predicted());
        joint.residual.push(t, if torque.counts { torque.residual() } else { f64::NAN });
        joint.course.push(t, torque.q);
        joint.nominal.iter_mut().for_each(|line| line.push(t, torque.described));
        for (k, part) in torque.parts.into_iter().enumerate() {
            joint.parts[k].push(t, part);
            self.squares[k] += part * part;
        }
        self.squares[4] += torque.measured * torque.measured;
        self.rows += 1;
        joint.position = (joint.position.0.min(torque.q), joint.position.1.max(torque.q));
        joint.speed = joint.speed.max(torque.dq.abs());
        joint.acceleration = joint.acceleration.max(torque.ddq.abs());
        joint.effort = joint.effort.max(torque.measured.abs());
        self.torque_spectrum.push(torque.measured);
        if torque.counts {
            let residual = torque.residual();
            self.squares[5] += residual * residual;
            self.used += 1;
            self.cloud.push(torque.dq, torque.measured - torque.rigid());
            self.residual_spectrum.push(residual);
        } else {
            // A gap would cause a jump that distorts the spectrum, so the residual of an unused row is set to zero.
            self.residual_spectrum.push(0.0);
        }
    }

    fn finish(self) -> JointPlotData {
        let rms = |square: f64, rows: usize| (square / rows.max(1) as f64).sqrt();
        JointPlotData {
            part_rms: std::array::from_fn(|k| rms(self.squares[k], self.rows)),
            torque_rms: rms(self.squares[4], self.rows),
            residual_rms: rms(self.squares[5], self.used),
            friction: self.cloud.points(),
            residual_spectrum: self.residual_spectrum.density(),
            torque_spectrum: self.torque_spectrum.density(),
            ..self.plot_data
        }
    }
}
