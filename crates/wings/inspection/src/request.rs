//! The options (request) of `rist visibility`, which predicts an identification, and the registration of this wing (optional
//! package).

use rist::request::{FrictionChoice, Range, Request};
use rist::wings::{PointReader, Wing, terms_without_torque};
use rist::{Error, FrictionTerm, LimitsFile};

use crate::points::{points_of_ros, read_table};

/// The requests and readers that this wing registers.
pub fn wing() -> Wing {
    Wing {
        requests: vec![("visibility", VisibilityRequest::fields)],
        points: Some(Ok(PointReader { of_table: read_table, of_ros: points_of_ros })),
        ..Wing::default()
    }
}

rist::request! {
    /// Options for predicting an identification from a motion or a log.
    pub struct VisibilityRequest {
        /// YAML with tighter limits, as for [limits] of `rist excite`. A joint that this file locks gives no rows.
        limits: Option<LimitsFile> = None, value_name("FILE");
        /// Friction terms of every joint in the later identification. The words and the default are those of [friction] of
        /// `rist identify`; auto is not possible.
        friction: Option<FrictionChoice> = None, value_name("TERMS");
        /// Standard deviation of the noise of a torque sample, as a share of the effort limit.
        noise: f64 = 0.01, range(Range::Positive), value_name("SHARE");
        /// Sample rate of a JointTrajectory in the analysis, Hz.
        rate: f64 = 200.0, range(1.0..=2e4), value_name("HZ");
    }
}

impl VisibilityRequest {
    /// The friction terms of the request.
    ///
    /// Fails if the request leaves the choice of the terms to a log, or if a term needs a measured torque.
    pub fn friction_terms(&self) -> Result<Vec<FrictionTerm>, Error> {
        terms_without_torque(self.friction.as_ref())
    }
}
