//! Converts named arrays to a table of columns: the arrays of a .npz, or arrays in the memory of a program.
//!
//! An array of shape (N,) is one column with its name; an array of shape (N, k) or (k, N) is the columns name_1 .. name_k. N is
//! the length of the longest array. An array with more axes is noted and not used. Without a time, a scalar `frequency` or `fs`
//! (Hz) or `dt` (s) gives the time. Names follow common tools: `times positions velocities accelerations torques`,
//! `t q dq ddq tau`.

use crate::Error;
use crate::table::{MAX_COLUMNS, Table, check_header};

/// An array of numbers with its shape.
pub struct Array {
    /// Shape of the array: empty for a scalar, (samples,) or (samples, joints).
    pub shape: Vec<usize>,
    /// The numbers, row by row.
    pub values: Vec<f64>,
}

impl Table {
    /// Makes a table of named arrays. `file`: name in messages.
    ///
    /// Fails if no array has samples, if there are too many columns, if two have the same name, or if a rate is not usable.
    pub fn from_arrays(file: &str, arrays: Vec<(String, Array)>) -> Result<Table, Error> {
        // N is the length of the longest array with one or two axes. Arrays of another length or with more axes get a note and
        // are not used.
        let length = |array: &Array| match array.shape[..] {
            [n] | [n, _] => n,
            _ => 0,
        };
        let rows = arrays.iter().map(|(_, array)| length(array)).max().unwrap_or(0);
        let longest = arrays.iter().find(|(_, array)| length(array) == rows).map_or("", |(key, _)| key).to_string();
        let mut table = Table { file: file.into(), ..Table::default() };
        let push = |table: &mut Table, name: String, values: Vec<f64>| {
            table.header.push(name);
            table.columns.push(values);
            table.texts.push(None);
        };
        let rate = ["dt", "frequency", "fs"].into_iter().find_map(|key| {
            let found = arrays.iter().find(|a| a.0 == key && a.1.values.len() == 1)?;
            Some((key, found.1.values[0]))
        });
        for (key, array) in arrays {
            match array.shape[..] {
                [n] if n == rows && n > 1 => push(&mut table, key, array.values),
                // (k, N) is the order of MATLAB and HDF5: a row per signal.
                [n, k] | [k, n] if n == rows && n > 1 && k > 0 => {
                    check_width(file, table.header.len() + k, &key, &array.shape)?;
                    let is_transposed = array.shape[0] != rows;
                    for c in 0..k {
                        let values = array.values.iter().skip(if is_transposed { c * n } else { c });
                        let column = values.step_by(if is_transposed { 1 } else { k }).take(n).copied().collect();
                        push(&mut table, format!("{key}_{}", c + 1), column);
                    }
                }
                [n] | [n, _] if n > 1 => table.notes.push(format!(
                    "array `{key}` has {n} rows where `{longest}` has {rows}: it is not used; signals of one run have one length"
                )),
                [_, _, _, ..] => table.notes.push(format!(
                    "array `{key}` has {} axes, {:?}: it is not used; signals are arrays of shape (samples,) or (samples, \
                     joints)",
                    array.shape.len(),
                    array.shape
                )),
                _ => {}
            }
        }
        // Computes the time from the rate if no array contains the time.
        let timed =
            table.header.iter().any(|h| matches!(h.as_str(), "t" | "time" | "times" | "timestamp" | "timestamps"));
        if let (false, false, Some((key, value))) = (timed, table.columns.is_empty(), rate) {
            let period = if key == "dt" { value } else { 1.0 / value };
            if !(period.is_finite() && period > 0.0) {
                let unit = if key == "dt" { "s" } else { "Hz" };
                let message =
                    format!("`{key}` is {value}; a positive number of {unit} is expected, or an array `t` of times");
                return Err(Error::at(file, 0, message));
            }
            push(&mut table, "t".into(), (0..rows).map(|r| period * r as f64).collect());
        }
        if table.columns.is_empty() {
            let message = "no array holds samples; arrays of shape (samples,) or (samples, joints) are expected";
            return Err(Error::at(file, 0, message));
        }
        check_header(file, 0, &mut table.header)?;
        Ok(table)
    }

    /// Adds a column that contains text instead of numbers. `what`: description of the text. Using the column is an error.
    pub fn add_text(&mut self, name: String, what: String) {
        self.columns.push(vec![f64::NAN; self.rows()]);
        self.header.push(name);
        self.texts.push(Some((0, what)));
    }
}

/// Fails if a table with an array has too many columns.
fn check_width(file: &str, columns: usize, key: &str, shape: &[usize]) -> Result<(), Error> {
    match columns > MAX_COLUMNS {
        true => {
            Err(Error::at(file, 0, format!("more than {MAX_COLUMNS} columns with array `{key}` of shape {shape:?}")))
        }
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_the_text_of_their_numbers() {
        let of = |shape: &[usize], values: &[f64]| Array { shape: shape.into(), values: values.into() };
        let arrays = vec![
            ("t".to_string(), of(&[3], &[0.0, 0.1, 0.2])),
            ("q".to_string(), of(&[3, 2], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])),
        ];
        let mut found = Table::from_arrays("arrays", arrays).unwrap();
        let text = Table::from_bytes("text", b"t,q_1,q_2\n0,1,2\n0.1,3,4\n0.2,5,6\n").unwrap();
        assert_eq!((&found.header, &found.columns), (&text.header, &text.columns));
        let transposed = [("t", of(&[3], &[0.0, 0.1, 0.2])), ("q", of(&[2, 3], &[1.0, 3.0, 5.0, 2.0, 4.0, 6.0]))];
        let transposed = transposed.map(|(name, array)| (name.to_string(), array)).into();
        assert_eq!(Table::from_arrays("arrays", transposed).unwrap().columns, text.columns);
        found.add_text("note".into(), "a value of type utf8".into());
        assert_eq!((found.header.len(), found.columns.len(), found.texts.len()), (4, 4, 4));
        let named =
            crate::ColumnNames { torque: Some(crate::NamePattern::Each(vec!["note".into()])), ..Default::default() };
        let refused = crate::LogSource::from_table(found, &["1".into()], &named).err().unwrap().to_string();
        assert!(refused.contains("column `note`"), "{refused}");
    }

    #[test]
    fn more_axes_are_noted() {
        let of = |shape: &[usize]| Array { shape: shape.into(), values: vec![0.5; shape.iter().product()] };
        let arrays = [("q", of(&[3, 2])), ("images", of(&[4, 2, 2])), ("t", of(&[3]))];
        let table = Table::from_arrays("arrays", arrays.map(|(key, array)| (key.to_string(), array)).into()).unwrap();
        assert_eq!(table.header, ["q_1", "q_2", "t"]);
        let [note] = table.notes.as_slice() else { panic!("{:?}", table.notes) };
        assert!(note.starts_with("array `images` has 3 axes, [4, 2, 2]: it is not used"), "{note}");
    }

    #[test]
    fn a_rate_that_makes_no_time_is_refused() {
        let of = |key: &str, value: f64, other: &str| {
            let scalar = Array { shape: vec![], values: vec![value] };
            let signal = || Array { shape: vec![3], values: vec![0.1, 0.2, 0.3] };
            let arrays = [("q", signal()), (other, signal()), (key, scalar)];
            Table::from_arrays("arrays", arrays.map(|(key, array)| (key.to_string(), array)).into())
        };
        for (key, value, unit) in [
            ("frequency", 0.0, "Hz"),
            ("fs", -1.0, "Hz"),
            ("fs", f64::NAN, "Hz"),
            ("dt", 0.0, "s"),
            ("dt", f64::INFINITY, "s"),
        ] {
            let refused = of(key, value, "dq").err().unwrap().to_string();
            let said = format!("`{key}` is {value}; a positive number of {unit} is expected");
            assert!(refused.contains(&said), "{refused}");
            assert!(of(key, value, "t").is_ok());
        }
        assert_eq!(of("frequency", 4.0, "dq").unwrap().columns[2], [0.0, 0.25, 0.5]);
    }
}
