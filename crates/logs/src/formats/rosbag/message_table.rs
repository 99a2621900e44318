//! Converts the messages of one topic of any type to a table. Each message is a row, and each of its numbers is in a column with
//! the path of its field.
//!
//! The time is from the header of the message, or from the recorder, and is counted from the first message.

use std::collections::BTreeMap;

use crate::Error;
use crate::formats::rosbag::cdr::Encoding;
use crate::formats::rosbag::fields;
use crate::formats::rosbag::joint_table::{CELL_BYTES, NumbersByRow, SPARSE_JOINT_RATIO, seconds};
use crate::formats::rosbag::schema::Schema;
use crate::table::{MAX_CELLS, MAX_COLUMNS, Table, check_header};
use gate::budget::Budget;

/// Largest number of different combinations of array lengths and names in a topic. Signals of a robot have fewer.
const MAX_FORMS: usize = 1000;

/// The messages of one topic.
pub(crate) struct MessageTable {
    schema: Schema,
    stamps: Vec<i64>,
    log_times: Vec<i64>,
    paths: Vec<String>,
    places: BTreeMap<String, usize>,
    series: Vec<NumbersByRow>,
    /// For each form of a message (array lengths and names), the indices of the columns of its values.
    forms: BTreeMap<Vec<u8>, Vec<usize>>,
    cells: usize,
}

impl MessageTable {
    pub(crate) fn new(schema: Schema) -> MessageTable {
        let (places, forms) = (BTreeMap::new(), BTreeMap::new());
        let (stamps, log_times, paths, series) = (vec![], vec![], vec![], vec![]);
        MessageTable { schema, stamps, log_times, paths, places, series, forms, cells: 0 }
    }

    /// Adds a message. `log_time`: time at which the recorder received it, ns. The memory of its numbers is taken from `memory`.
    ///
    /// Fails if the message does not fit its definition, or if there are too many numbers.
    pub(crate) fn push(
        &mut self,
        log_time: i64,
        data: &[u8],
        encoding: Encoding,
        memory: &mut Budget,
    ) -> Result<(), String> {
        let found = fields::decode(data, encoding, &self.schema, false)?;
        if found.values.len() > MAX_COLUMNS {
            return Err(format!("it holds {} numbers; at most {MAX_COLUMNS} are expected", found.values.len()));
        }
        self.cells += found.values.len() + 2;
        if self.cells > MAX_CELLS {
            return Err(format!("with it there are more than {MAX_CELLS} numbers; cut the recording into parts"));
        }
        memory.draw(CELL_BYTES * (found.values.len() + 2))?;
        if !self.forms.contains_key(&found.form) {
            let places = self.new_form(data, encoding)?;
            self.forms.insert(found.form.clone(), places);
        }
        let row = self.stamps.len() as u32;
        self.stamps.push(found.stamp);
        self.log_times.push(log_time);
        for (place, value) in self.forms[&found.form].iter().zip(found.values) {
            self.series[*place].push(row, value);
        }
        Ok(())
    }

    /// The indices of the columns for a message with a new form. Fails if there are too many forms or columns.
    fn new_form(&mut self, data: &[u8], encoding: Encoding) -> Result<Vec<usize>, String> {
        if self.forms.len() == MAX_FORMS {
            return Err(format!("its arrays have their {MAX_FORMS}th set of lengths and names: these are no signals"));
        }
        let paths = fields::decode(data, encoding, &self.schema, true)?.paths.unwrap_or_default();
        let mut places = Vec::with_capacity(paths.len());
        for path in paths {
            let next = self.paths.len();
            let place = *self.places.entry(path.clone()).or_insert(next);
            if place == next {
                if next == MAX_COLUMNS {
                    return Err(format!("with it there are more than {MAX_COLUMNS} columns"));
                }
                self.paths.push(path);
                self.series.push(NumbersByRow::default());
            }
            places.push(place);
        }
        Ok(places)
    }

    /// The table of all messages. `name`: topic. `kind`: message type. `file`: file name for messages.
    ///
    /// Fails if there are no messages, or more than [`MAX_CELLS`] numbers.
    pub(crate) fn table(self, name: &str, kind: &str, file: &str, mut notes: Vec<String>) -> Result<Table, Error> {
        let rows = self.stamps.len();
        let refused = |message: String| Error::at(file, 0, message);
        if rows == 0 {
            return Err(refused(format!("no message is in the recording on the topic {name}")));
        }
        let (time, clock) = seconds(&self.stamps, &self.log_times);
        notes.insert(0, format!("topic {name}, messages {kind}; time from {clock}"));
        let mut table = Table { file: file.into(), notes, ..Table::default() };
        let is_taken = |name: &str| self.places.contains_key(name);
        let clock = if is_taken("time") { "stamp" } else { "time" };
        if !is_taken(clock) {
            table.header.push(clock.into());
            table.columns.push(time);
        }
        for (path, series) in self.paths.into_iter().zip(self.series) {
            if series.len() < rows / SPARSE_JOINT_RATIO {
                continue;
            }
            if (table.columns.len() + 1).saturating_mul(rows) > MAX_CELLS {
                return Err(refused(format!("more than {MAX_CELLS} numbers; cut the recording into parts")));
            }
            table.header.push(path);
            table.columns.push(series.column(rows));
        }
        table.texts = vec![None; table.header.len()];
        check_header(file, 0, &mut table.header)?;
        Ok(table)
    }
}
