//! Reads the rows of a file on a thread of its own, while the rows before them go into blocks.

use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

use crate::Error;
use crate::table::{RowReader, Table};

/// Rows that are read at once, so few that their numbers stay in the cache on the way into a block.
pub(crate) const ROWS_PER_READ: usize = 1 << 14;

/// Tables that may wait to be taken.
const MAX_WAITING_TABLES: usize = 2;

/// The rows of a file that come next.
pub(crate) struct RowsAhead {
    tables: Receiver<Result<Table, Error>>,
    reader: Option<JoinHandle<()>>,
}

impl RowsAhead {
    /// Reads tables of at most [`ROWS_PER_READ`] rows. Every `block` rows a new table begins, so that no table crosses
    /// the end of a block.
    pub(crate) fn new(mut file: Box<dyn RowReader>, block: usize) -> RowsAhead {
        let (sender, tables) = sync_channel(MAX_WAITING_TABLES);
        let read = move || {
            let mut left = block;
            loop {
                let table = file.rows(ROWS_PER_READ.min(left));
                let rows = table.as_ref().map_or(0, Table::rows);
                left = if rows < left { left - rows } else { block };
                // Nobody receives the next table after a failure on an earlier one.
                if sender.send(table).is_err() || rows == 0 {
                    break;
                }
            }
        };
        RowsAhead { tables, reader: Some(std::thread::spawn(read)) }
    }

    /// The next rows. An empty table is the end; do not ask again after it.
    ///
    /// Fails as [`RowReader::rows`] does.
    pub(crate) fn next(&mut self) -> Result<Table, Error> {
        match (self.tables.recv(), &mut self.reader) {
            (Ok(table), _) => table,
            (Err(_), reader) => {
                let cause = reader.take().and_then(|reader| reader.join().err());
                cause.map_or_else(|| Ok(Table::default()), |cause| std::panic::resume_unwind(cause))
            }
        }
    }
}
