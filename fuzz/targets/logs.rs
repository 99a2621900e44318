//! The bytes of a log in any format: delimited text, gzip, zstd, .npz, Parquet, MCAP, SQLite.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(table) = logs::Table::from_bytes("log", data) {
        // What was read can be walked: every row knows the line it came from.
        for row in 0..table.rows().min(1000) {
            let _ = table.line(row);
        }
    }
});
