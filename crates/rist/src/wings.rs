//! What wings add to core: tables that are filled once, before the first request is read.
//!
//! A wing is a package that core does not know. Who builds it in hands its [`Wing`] to [`register`].

use std::path::Path;
use std::sync::OnceLock;

use experiments::motion::point_trajectory::PointTrajectory;
use modeling::FunctionOfLink;
use robot::{Note, Robot};

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::experiments::ExperimentLogs;
use crate::request::{ClosedLoopRequest, DescriptionFormat, Field, Method};

pub use crate::describe::adapters::tape_dynamics::dynamics;
pub use crate::fit::experiments::Reader;
pub use crate::motion::described::{described_values, torque_noise};
pub use crate::request::terms_without_torque;
pub use experiments::plan::proof_search::ProofSearch;
pub use identification::estimate::artefact::Estimate;

pub use identification::estimate::identify::Fit;
pub use identification::estimate::ledger::hypotheses::Open;
pub use identification::estimate::verdict::Evidence;
pub use identification::estimators::drive_gains::likelihood::DriveGains;
pub use identification::signals::records::Records;
pub use logs::reading::{LogFormat, LogReader};
pub use robot::mesh::MeshFormat;

/// What a wing adds, or what is said of a wing that was not built in.
#[derive(Default)]
pub struct Wing {
    /// Its requests by name.
    pub requests: Vec<(&'static str, fn() -> Vec<Field>)>,
    /// Formats of log files.
    pub log_formats: Vec<LogFormat>,
    /// Formats of meshes.
    pub mesh_formats: Vec<MeshFormat>,
    /// Writers of descriptions.
    pub writers: Vec<DescriptionWriter>,
    /// What reads motions of others, or what is said where it was not built in.
    pub points: Option<Result<PointReader, &'static str>>,
    /// Functions of a link.
    pub functions: Vec<FunctionOfLink>,
    /// Identification that simulates the experiments of a plan, or what is said where it was not built in.
    pub in_loop: Option<Result<IdentifyInLoop, &'static str>>,
    /// The search for a plan that is proven the best, or what is said where it was not built in.
    pub proof_search: Option<Result<ProofSearch, &'static str>>,
}

/// Identifies from the logs of a plan by a method that simulates its experiments.
pub type IdentifyInLoop = fn(&Model, ExperimentLogs, &ClosedLoopRequest, Method) -> Result<Estimate, Error>;

/// The text of a robot, and what of it the format cannot carry.
pub type WriteDescription = fn(&Robot) -> (String, Vec<Note>);

/// A writer of descriptions.
#[derive(Clone, Copy)]
pub struct DescriptionWriter {
    /// What it writes.
    pub format: DescriptionFormat,
    /// How, or what is said where it was not built in.
    pub write: Result<WriteDescription, &'static str>,
}

/// Readers of points that others made.
#[derive(Clone, Copy)]
pub struct PointReader {
    /// Of a file that holds a table, with the coordinates of a model.
    pub of_table: fn(&Model, &Path) -> Result<PointTrajectory, Error>,
    /// Of the text of a JointTrajectory; the name of its file comes first.
    pub of_ros: fn(&str, &str) -> Result<PointTrajectory, logs::Error>,
}

static WINGS: OnceLock<Vec<Wing>> = OnceLock::new();

/// Adds wings, before the first text is spelled and the first file is read; only the first call counts.
pub fn register(wings: Vec<Wing>) {
    WINGS.get_or_init(|| {
        logs::reading::register(wings.iter().flat_map(|wing| wing.log_formats.clone()).collect());
        robot::mesh::register(wings.iter().flat_map(|wing| wing.mesh_formats.clone()).collect());
        modeling::register_functions(wings.iter().flat_map(|wing| wing.functions.clone()).collect());
        if let Some(search) = wings.iter().find_map(|wing| wing.proof_search) {
            experiments::plan::proof_search::register(search);
        }
        wings
    });
}

/// The wings that were registered.
pub(crate) fn registered() -> &'static [Wing] {
    WINGS.get().map_or(&[], Vec::as_slice)
}
