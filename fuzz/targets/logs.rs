//! Fuzz target for the bytes of a log in any format (delimited text, gzip, zstd, .npz, Parquet, MCAP, SQLite) and its joint
//! columns.
//!
//! A panic of the crate `parquet` is a finding although the reader catches it, since the program would print it.
#![no_main]

use libfuzzer_sys::fuzz_target;
use logs::{ColumnNames, LogSource, Table};

/// Names of the coordinates in the logs of the corpus.
const COORDINATES: [[&str; 2]; 2] = [["q1", "q2"], ["a", "b"]];

fuzz_target!(|data: &[u8]| {
    rist::wings::register(vec![foreign::wing()]);
    let Ok(table) = Table::from_bytes("log", data) else { return };
    // Every row has the number of its line. A numeric column has a value for every row, a text column has none.
    for row in 0..table.rows() {
        let _ = table.line(row);
    }
    assert!(table.columns.iter().all(|column| column.is_empty() || column.len() == table.rows()));
    for coordinates in COORDINATES {
        let coordinates = coordinates.map(String::from);
        let Ok((log, _)) = LogSource::from_table(table.clone(), &coordinates, &ColumnNames::default()) else {
            continue;
        };
        let report = log.report();
        assert!(report.kept <= table.rows());
        if let LogSource::Held(log) = &log {
            assert!(log.t.windows(2).all(|t| t[0] < t[1]), "a log ascends in time");
        }
    }
});
