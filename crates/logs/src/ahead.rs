//! Reads the rows of a file on a separate thread while earlier rows are added to blocks.
//!
//! A table holds some rows of named columns. A block is a larger range of rows that is stored or processed as a whole.

use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

use crate::Error;
use crate::table::{RowReader, Table};

/// Largest number of rows in a table. It is small, so that the numbers stay in the cache until they are added to a block.
pub(crate) const ROWS_PER_READ: usize = 1 << 14;

/// Largest number of tables that wait in the queue between the reading thread and the caller.
const MAX_WAITING_TABLES: usize = 2;

/// Reads the next rows of a file on a separate thread.
pub(crate) struct RowsAhead {
    tables: Receiver<Result<Table, Error>>,
    reader: Option<JoinHandle<()>>,
}

impl RowsAhead {
    /// Starts the thread. It reads tables of at most [`ROWS_PER_READ`] rows. After every `block` rows it starts a new table, so
    /// no table crosses the end of a block.
    pub(crate) fn new(mut file: Box<dyn RowReader>, block: usize) -> RowsAhead {
        let (sender, tables) = sync_channel(MAX_WAITING_TABLES);
        let read = move || {
            let mut left = block;
            loop {
                let table = file.rows(ROWS_PER_READ.min(left));
                let rows = table.as_ref().map_or(0, Table::rows);
                left = if rows < left { left - rows } else { block };
                // If the receiver was dropped after a failure, sending fails and the thread ends.
                if sender.send(table).is_err() || rows == 0 {
                    break;
                }
            }
        };
        RowsAhead { tables, reader: Some(std::thread::spawn(read)) }
    }

    /// The next rows of the file. An empty table means the end of the file; do not call the function again after it.
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
