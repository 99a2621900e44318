//! Types of other packages in signatures that wings alone call. They may change with any version.

pub use identification::estimate::identify::Fit;
pub use identification::estimate::ledger::hypotheses::Open;
pub use identification::estimate::verdict::Evidence;
pub use identification::estimators::drive_gains::likelihood::DriveGains;
pub use identification::signals::records::Records;
