//! The options (requests) of the commands of the fleet wing (optional package): adding logs to sums (triangles added over
//! logs), and comparing sums.
//!
//! A request is a struct with all options of a command; each field is one option.

use rist::Options;
use rist::request::{METHOD, Range, Request, RowsRequest};
use rist::wings::Wing;

use crate::comparison::Compared;

/// The requests that this wing registers.
pub fn wing() -> Wing {
    Wing {
        requests: vec![("compare", CompareRequest::fields), ("accumulate", AccumulateRequest::fields)],
        ..Wing::default()
    }
}

rist::words! { Compared:
    All = "all" "All that both determine",
    Inertial = "inertial" "Those of bodies and rotors: friction may move from day to day",
}

rist::request! {
    /// Options for comparing the sums of robots with the sums of a reference.
    pub struct CompareRequest {
        /// The parameters that are asked about.
        of: Compared = Compared::All;
        /// False discovery rate: the expected share of unchanged robots among those reported as changed, and of unchanged
        /// parameters among those reported.
        fdr: f64 = 0.05, value_name("RATE");
    }
}

rist::request! {
    /// Options for sums over logs.
    pub struct SumsRequest {
        /// Torque per unit of current of every drive, N m/A [default: as the description says].
        gain: Vec<(String, f64)> = Vec::new(), range(Range::Positive), value_name("COORDINATE=GAIN"), heading(METHOD);
        ..
        /// How logs become rows; nothing in it may need them twice.
        rows: RowsRequest;
    }
}

rist::request! {
    /// Options for reading logs and adding them up. By default, the first log that fails ends the command with an error.
    pub struct AccumulateRequest {
        /// Leave out logs that cannot be used or are not of this robot; the sums say which and why.
        skip_broken: bool = false;
        /// Take logs in that do not belong to the description (rist doctor).
        anyway: bool = false;
        /// Logs that are read at a time [default: as many as there are processors]; the sums are the same.
        threads: Option<usize> = None, range(1..), value_name("N");
        ..
        /// What is asked of the sums.
        sums: SumsRequest;
    }
}

impl SumsRequest {
    /// The request with these options.
    pub fn of_options(options: Options) -> SumsRequest {
        SumsRequest { rows: RowsRequest::of_options(options), ..SumsRequest::default() }
    }
}
