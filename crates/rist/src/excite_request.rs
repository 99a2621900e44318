//! Which exciting motion is looked for.

use identification::estimate::artefact::Estimate;
use identification::experiments::excitation::barrier::Timing;
use identification::experiments::excitation::criterion::Aim;
use identification::experiments::excitation::fourier_motion::{FourierJoint, FourierMotion};
use identification::experiments::excitation::limits::LimitsFile;
use identification::experiments::excitation::search::SearchOptions;
use identification::model::friction::terms::FrictionTerm;

use crate::error::Error;

/// Which motion is looked for.
#[derive(Clone, Debug)]
pub struct ExciteRequest {
    /// s; none: by the limits, see [`crate::exciting::default_period`].
    pub period: Option<f64>,
    /// s from rest to the series; none: by the limits.
    pub blend: Option<f64>,
    /// Number of harmonics.
    pub harmonics: usize,
    /// Whole periods.
    pub repetitions: usize,
    /// Of the file that is played and of the log, Hz.
    pub rate: f64,
    /// Limits tighter than those of the description.
    pub limits: LimitsFile,
    /// Share of the effort limits that the described torque may use.
    pub effort_share: f64,
    /// Friction columns that the identification will have.
    pub friction: Vec<FrictionTerm>,
    /// The aim of the search.
    pub aim: Aim,
    /// Noise of a torque sample as a share of the effort limit.
    pub noise: f64,
    /// Starting points of the search.
    pub starts: usize,
    /// Of each descent, at each height of the walls.
    pub iterations: usize,
    /// Of the starting points.
    pub seed: u64,
    /// What an earlier motion has told: it is added to what the motion tells, and limits the torque.
    pub after: Option<Estimate>,
}

impl ExciteRequest {
    /// How much is searched.
    pub(crate) fn search(&self) -> SearchOptions {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        SearchOptions { starts: self.starts, iterations: self.iterations, seed: self.seed, threads }
    }

    /// The motion of these series.
    pub(crate) fn motion(&self, timing: Timing, joints: Vec<FourierJoint>) -> FourierMotion {
        let Timing { period, blend, .. } = timing;
        FourierMotion { rate: self.rate, period, blend, repetitions: self.repetitions, joints }
    }
}

impl Default for ExciteRequest {
    fn default() -> ExciteRequest {
        ExciteRequest {
            period: None,
            blend: None,
            harmonics: 5,
            repetitions: 3,
            rate: 200.0,
            limits: LimitsFile::default(),
            effort_share: 0.9,
            friction: FrictionTerm::STANDARD.to_vec(),
            aim: Aim::Determinant,
            noise: 0.01,
            starts: 8,
            iterations: 40,
            seed: 1,
            after: None,
        }
    }
}

/// Fails where a number makes no motion.
pub(crate) fn check_request(request: &ExciteRequest) -> Result<(), Error> {
    let positive = [
        (Some(request.rate), "--rate"),
        (request.period, "--period"),
        (request.blend, "--blend"),
        (Some(request.noise), "--noise"),
    ];
    for (x, what) in positive.iter().filter_map(|(x, what)| x.map(|x| (x, what))) {
        if !(x.is_finite() && x > 0.0) {
            return Err(Error::new(format_args!("{what} must be a positive number, not {x}")));
        }
    }
    if !(request.effort_share > 0.0 && request.effort_share <= 1.0) {
        let share = request.effort_share;
        return Err(Error::new(format_args!("--effort-share is above 0 and at most 1, not {share}")));
    }
    if request.harmonics == 0 || request.harmonics > 40 {
        return Err(Error::new(format_args!("--harmonics must be between 1 and 40, not {}", request.harmonics)));
    }
    if request.repetitions == 0 || request.starts == 0 {
        return Err(Error::new("--repetitions and --starts must be at least 1"));
    }
    if request.friction.contains(&FrictionTerm::Load) {
        return Err(Error::new("--friction load needs a measured torque; a motion that is still to be run has none"));
    }
    Ok(())
}
