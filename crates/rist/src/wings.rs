//! What wings add to core: tables that are filled once, before the first request is read.
//!
//! A wing is a package that core does not know. Who builds it in hands its [`Wing`] to [`register`].

use std::sync::OnceLock;

use robot::{Note, Robot};

use crate::request::{DescriptionFormat, Field};

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
    pub requests: Vec<(&'static str, Vec<Field>)>,
    /// Formats of log files.
    pub log_formats: Vec<LogFormat>,
    /// Formats of meshes.
    pub mesh_formats: Vec<MeshFormat>,
    /// Writers of descriptions.
    pub writers: Vec<DescriptionWriter>,
}

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

static WINGS: OnceLock<Vec<Wing>> = OnceLock::new();

/// Adds wings, before the first text is spelled and the first file is read; only the first call counts.
pub fn register(wings: Vec<Wing>) {
    WINGS.get_or_init(|| {
        logs::reading::register(wings.iter().flat_map(|wing| wing.log_formats.clone()).collect());
        robot::mesh::register(wings.iter().flat_map(|wing| wing.mesh_formats.clone()).collect());
        wings
    });
}

/// The wings that were registered.
pub(crate) fn registered() -> &'static [Wing] {
    WINGS.get().map_or(&[], Vec::as_slice)
}
