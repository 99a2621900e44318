//! Reads the rows of a file on a separate thread while earlier rows are added to blocks.

use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

use crate::Error;
use crate::table::{RowReader, Table};

/// Rows that are read at once: few enough that their numbers stay in the cache until they are in a block.
pub(crate) const ROWS_PER_READ: usize = 1 << 14;

/// Greatest number of tables that wait in the queue.
const MAX_WAITING_TABLES: usize = 2;

/// The next rows of a file, read ahead.
pub(crate) struct RowsAhead {
    tables: Receiver<Result<Table, Error>>,
    reader: Option<JoinHandle<()>>,
}

impl RowsAhead {
    /// Reads tables of at most [`ROWS_PER_READ`] rows. A new table begins after every `block` rows, so that no table crosses the
    /// end of a block.
    pub(crate) fn new(mut file: Box<dyn RowReader>, block: usize) -> RowsAhead {
        let (sender, tables) = sync_channel(MAX_WAITING_TABLES);
        let read = move || {
            let mut left = block;
            loop {
                let table = file.rows(ROWS_PER_READ.min(left));
                let rows = table.as_ref().map_or(0, Table::rows);
                left = if rows < left { left - rows } else { block };
                // After a failure the receiver is dropped and sending fails.
                if sender.send(table).is_err() || rows == 0 {
                    break;
                }
            }
        };
        RowsAhead { tables, reader: Some(std::thread::spawn(read)) }
    }

    /// The next rows. An empty table marks the end; do not call again after it.
    ///
    /// Fails like [`RowReader::rows`].
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
