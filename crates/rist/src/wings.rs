//! Registers wings (optional packages that add functions), and exports the types that wings need.
//!
//! A wing is a package on which the other packages, called core, do not depend. A program with wings passes all wings to
//! [`register`] once, before the program reads a file or prints a text.

use std::sync::Once;

use experiments::plan::{proof_check, proof_search};

use crate::describe::conversion;
use crate::fit::experiments as fit;
use crate::motion::played_file;
use crate::request;

pub use crate::describe::adapters::tape_dynamics::dynamics;
pub use crate::describe::conversion::{DescriptionWriter, WriteDescription};
pub use crate::fit::experiments::{ExperimentReader, IdentifyInLoop};
pub use crate::motion::nominal::{nominal_values, torque_noise};
pub use crate::motion::played_file::PointReader;
pub use crate::request::{WingRequest, terms_without_torque};
pub use experiments::plan::proof_check::FindProof;
pub use experiments::plan::proof_search::{ProvePlan, ProvenPlan, SearchBudget};
pub use identification::estimate::claims::hypotheses::UndeterminedMechanics;
pub use identification::estimate::identify::Fit;
pub use identification::estimate::verdict::Evidence;
pub use identification::estimators::drive_gains::likelihood::DriveGains;
pub use identification::signals::records::Records;
pub use logs::reading::{LogFormat, LogReader};
pub use modeling::FunctionOfLink;
pub use robot::format::DescriptionReader;
pub use robot::mesh::MeshFormat;

/// Functions that a wing (an optional package) adds. If a function is an `Err`, this build does not contain the function, and the
/// `Err` is the error text for the user.
#[derive(Default)]
pub struct Wing {
    /// The requests of the wing.
    pub requests: Vec<WingRequest>,
    /// Formats of log files that the wing reads.
    pub log_formats: Vec<LogFormat>,
    /// Formats of meshes that the wing reads.
    pub mesh_formats: Vec<MeshFormat>,
    /// Readers of descriptions.
    pub description_readers: Vec<DescriptionReader>,
    /// Writers of descriptions.
    pub writers: Vec<DescriptionWriter>,
    /// The functions that read motions from other sources, or the error text if this build does not contain them.
    pub points: Option<Result<PointReader, &'static str>>,
    /// Functions of a link for generated code.
    pub functions: Vec<FunctionOfLink>,
    /// The identification methods that simulate the experiments of a plan, or the error text if this build does not contain
    /// them.
    pub in_loop: Option<Result<IdentifyInLoop, &'static str>>,
    /// The search for a plan with a proof of its efficiency, or the error text if this build does not contain the search.
    pub prove_plan: Option<Result<ProvePlan, &'static str>>,
    /// The function that repeats the proof of a plan's efficiency, or the error text if this build does not contain the
    /// function.
    pub find_proof: Option<Result<FindProof, &'static str>>,
}

/// Registers wings; only the first call has an effect.
pub fn register(wings: Vec<Wing>) {
    static REGISTERED: Once = Once::new();
    REGISTERED.call_once(|| {
        let (mut requests, mut logs, mut meshes, mut readers) = (vec![], vec![], vec![], vec![]);
        let (mut writers, mut functions) = (vec![], vec![]);
        for wing in wings {
            requests.extend(wing.requests);
            logs.extend(wing.log_formats);
            meshes.extend(wing.mesh_formats);
            readers.extend(wing.description_readers);
            writers.extend(wing.writers);
            functions.extend(wing.functions);
            wing.points.into_iter().for_each(played_file::register);
            wing.in_loop.into_iter().for_each(fit::register);
            wing.prove_plan.into_iter().for_each(proof_search::register);
            wing.find_proof.into_iter().for_each(proof_check::register);
        }
        request::register(requests);
        ::logs::reading::register(logs);
        robot::mesh::register(meshes);
        robot::format::register_readers(readers);
        conversion::register(writers);
        modeling::register_functions(functions);
    });
}
