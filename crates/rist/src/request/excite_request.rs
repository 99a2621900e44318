//! Which exciting motion is looked for.

use experiments::excitation::criterion::Aim;
use experiments::excitation::limits::LimitsFile;
use experiments::excitation::motion::{Motion, Shape};
use experiments::excitation::search::SearchOptions;
use experiments::excitation::space_limits::SpaceLimits;
use identification::estimate::artefact::Estimate;
use linear_model::friction::terms::FrictionTerm;

use crate::error::Error;

/// The functions that the motion is a sum of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Family {
    /// A finite Fourier series between blends: its periods can be averaged, and their spectrum is known.
    Fourier {
        /// s from rest to the series; none: by the limits.
        blend: Option<f64>,
        /// Number of harmonics.
        harmonics: usize,
    },
    /// A quintic spline from rest to rest. It loses no time in blends, and its speed may vary along the motion.
    Spline {
        /// Polynomials that a period is divided into; none: by the limits.
        spans: Option<usize>,
    },
}

/// The words for the families on a command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FamilyWord {
    /// See [`Family::Fourier`].
    Fourier,
    /// See [`Family::Spline`].
    Spline,
}

/// Harmonics of a series if no number is asked for.
pub(crate) const HARMONICS: usize = 5;

impl Family {
    /// The family of this word, with what else is asked of it: s, harmonics, spans.
    ///
    /// Fails where an option is of the other family.
    pub fn new(
        word: FamilyWord,
        blend: Option<f64>,
        harmonics: Option<usize>,
        spans: Option<usize>,
    ) -> Result<Family, Error> {
        let stray = match word {
            FamilyWord::Fourier => [spans.map(|_| "--spans"), None],
            FamilyWord::Spline => [harmonics.map(|_| "--harmonics"), blend.map(|_| "--blend")],
        };
        match (stray.into_iter().flatten().next(), word) {
            (Some(option), FamilyWord::Fourier) => {
                Err(Error::new(format_args!("{option} is of splines: add --motion spline, or ask for --harmonics")))
            }
            (Some(option), FamilyWord::Spline) => Err(Error::new(format_args!(
                "{option} is of Fourier series: a spline starts and ends at rest, and --spans says how free it is"
            ))),
            (None, FamilyWord::Fourier) => Ok(Family::Fourier { blend, harmonics: harmonics.unwrap_or(HARMONICS) }),
            (None, FamilyWord::Spline) => Ok(Family::Spline { spans }),
        }
    }
}

/// Which motion is looked for.
#[derive(Clone, Debug)]
pub struct ExciteRequest {
    /// What it is a sum of.
    pub family: Family,
    /// s; none: by the limits, see [`crate::exciting::default_period`].
    pub period: Option<f64>,
    /// Whole periods.
    pub repetitions: usize,
    /// Sampling rate of the file that is played and of the log, Hz.
    pub rate: f64,
    /// Limits tighter than those of the description.
    pub limits: LimitsFile,
    /// Share of the limits of effort and power that the described torque may use.
    pub effort_share: f64,
    /// Friction columns that the identification will have.
    pub friction: Vec<FrictionTerm>,
    /// The aim of the search.
    pub aim: Aim,
    /// Noise of a torque sample as a share of the effort limit.
    pub noise: f64,
    /// Starting points of the search.
    pub starts: usize,
    /// Iterations of each descent, at each height of the walls.
    pub iterations: usize,
    /// Seed of the starting points.
    pub seed: u64,
    /// An earlier estimate. Its information is added to that of the motion, and its parameters limit the torque.
    pub after: Option<Estimate>,
}

impl ExciteRequest {
    /// The options of the search.
    pub(crate) fn search(&self) -> SearchOptions {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        SearchOptions { starts: self.starts, iterations: self.iterations, seed: self.seed, threads }
    }

    /// Where the bodies may be.
    pub(crate) fn space(&self) -> SpaceLimits {
        self.limits.space.clone().unwrap_or_default()
    }

    /// The motion of these coefficients.
    pub(crate) fn motion(&self, shape: Shape, joints: Vec<Vec<f64>>) -> Motion {
        Motion { rate: self.rate, repetitions: self.repetitions, shape, joints }
    }
}

impl Default for ExciteRequest {
    fn default() -> ExciteRequest {
        ExciteRequest {
            family: Family::Fourier { blend: None, harmonics: HARMONICS },
            period: None,
            repetitions: 3,
            rate: 200.0,
            limits: LimitsFile::default(),
            effort_share: 0.9,
            friction: FrictionTerm::STANDARD.to_vec(),
            aim: Aim::Determinant,
            noise: 0.01,
            starts: 12,
            iterations: 100,
            seed: 1,
            after: None,
        }
    }
}

/// Fails where a number makes no motion.
pub(crate) fn check_request(request: &ExciteRequest) -> Result<(), Error> {
    let blend = if let Family::Fourier { blend, .. } = request.family { blend } else { None };
    let positive = [
        (Some(request.rate), "--rate"),
        (request.period, "--period"),
        (blend, "--blend"),
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
    // Both families may have about equally many coefficients a joint.
    match request.family {
        Family::Fourier { harmonics, .. } if harmonics == 0 || harmonics > 40 => {
            return Err(Error::new(format_args!("--harmonics must be between 1 and 40, not {harmonics}")));
        }
        Family::Spline { spans: Some(spans) } if !(4..=80).contains(&spans) => {
            return Err(Error::new(format_args!("--spans must be between 4 and 80, not {spans}")));
        }
        _ => {}
    }
    if request.repetitions == 0 || request.starts == 0 {
        return Err(Error::new("--repetitions and --starts must be at least 1"));
    }
    if request.friction.contains(&FrictionTerm::Load) {
        return Err(Error::new("--friction load needs a measured torque; a motion that is still to be run has none"));
    }
    Ok(())
}
