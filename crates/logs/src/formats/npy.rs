//! A single array of NumPy (.npy) as a table: it has no names, so its columns are c1, c2, ..

use gate::budget::Budget;

use crate::Error;
use crate::formats::arrays::Array;
use crate::formats::delimited::NO_HEADER;
use crate::formats::npz::{ArrayContent, array};
use crate::table::Table;

/// First bytes of such a file.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";

/// The table of a .npy of shape (samples, columns), or of shape (columns, samples) if the second length is greater.
///
/// Fails if the array has another shape, or if the file is damaged.
pub(crate) fn read(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
    let at = |message: String| Error::at(file, 0, message);
    let refused = "one array without names: shape (samples, columns) is expected; or save a .npz with the names of the \
                   signals, `numpy.savez('OUT.npz', t=t, q=q, tau=tau)`";
    let ArrayContent::Numbers(array) = array(Box::new(bytes), budget).map_err(at)? else {
        return Err(at(refused.into()));
    };
    let &[rows, columns] = array.shape.as_slice() else { return Err(at(refused.into())) };
    let Array { values, .. } = array;
    let (samples, signals) = (rows.max(columns), rows.min(columns));
    let at_place = |sample: usize, signal: usize| {
        if columns > rows { values[signal * columns + sample] } else { values[sample * columns + signal] }
    };
    let names = (1..=signals).map(|k| (format!("c{k}"), k - 1));
    let arrays = names.map(|(name, k)| {
        (name, Array { shape: vec![samples], values: (0..samples).map(|row| at_place(row, k)).collect() })
    });
    let mut table = Table::from_arrays(file, arrays.collect())?;
    table.notes.push(NO_HEADER.into());
    Ok(table)
}

#[cfg(test)]
mod tests {
    use crate::Table;
    use crate::formats::npz::tests::{doubles, npy};

    #[test]
    fn a_single_array_has_columns_by_place() {
        let rows = npy("<f8", "(3, 2)", "False", &doubles(&[0.0, 1.0, 0.1, 2.0, 0.2, 3.0]));
        let columns = npy("<f8", "(2, 3)", "False", &doubles(&[0.0, 0.1, 0.2, 1.0, 2.0, 3.0]));
        for file in [rows, columns] {
            let table = Table::from_bytes("log.npy", &file).unwrap();
            assert_eq!((table.header.join(" "), &table.columns[1]), ("c1 c2".into(), &vec![1.0, 2.0, 3.0]));
            assert!(table.notes[0].contains("no header"), "{:?}", table.notes);
        }
        let message = |bytes: &[u8]| Table::from_bytes("log.npy", bytes).unwrap_err().to_string();
        let one = message(&npy("<f8", "(3,)", "False", &doubles(&[0.0; 3])));
        assert!(one.contains("shape (samples, columns) is expected"), "{one}");
    }
}
