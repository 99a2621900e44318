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
    All = "all" "All parameters that both sums determine",
    Inertial = "inertial" "Parameters of bodies and rotors only, because friction may change from day to day",
}

rist::request! {
    /// Options for comparing the sums of robots with the sums of a reference.
    pub struct CompareRequest {
        /// The parameters to compare.
        of: Compared = Compared::All;
        /// False discovery rate: the expected share of unchanged robots among the robots reported as changed, and of unchanged
        /// parameters among the reported parameters.
        fdr: f64 = 0.05, value_name("RATE");
    }
}

rist::request! {
    /// Options for sums over logs.
    pub struct SumsRequest {
        /// Gain of every drive (torque per current), N m/A [default: as in the description].
        gain: Vec<(String, f64)> = Vec::new(), range(Range::Positive), value_name("COORDINATE=GAIN"), heading(METHOD);
        ..
        /// Options for the rows. No option may need the rows twice.
        rows: RowsRequest;
    }
}

rist::request! {
    /// Options for reading logs and adding them up. By default, the first log that fails ends the command with an error.
    pub struct AccumulateRequest {
        /// Leave out logs that cannot be used or are not of this robot. The file of the sums lists these logs with the reason.
        skip_broken: bool = false;
        /// Also add logs that, by the checks of rist doctor, do not belong to the description.
        anyway: bool = false;
        /// Number of logs that are read at the same time [default: the number of processors]. The sums do not depend on it.
        threads: Option<usize> = None, range(1..), value_name("N");
        ..
        /// Options for the sums.
        sums: SumsRequest;
    }
}

impl SumsRequest {
    /// The request with these options.
    pub fn of_options(options: Options) -> SumsRequest {
        SumsRequest { rows: RowsRequest::of_options(options), ..SumsRequest::default() }
    }
}
