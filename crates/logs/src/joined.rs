//! Reads a log that is divided into several files: `position.csv+effort.csv`.
//!
//! Files with equal numbers of rows are joined row by row, if at most one has a clock or all have the same clock. Otherwise
//! each file needs a clock: the columns of the later files are interpolated linearly at the times of the first file, in the
//! time interval that all files cover.
//!
//! The short name of a file is its stem without the common start of all stems: `q` and `tau` for `log_q.txt` and `log_tau.txt`.
//! If several files have a column of the same name, the short name is put before it, `effort.joint_1`. Columns without a header
//! are `q_1`, `q_2`. A file may have a single number per line, and k times as many lines as the shortest file has rows. Then
//! each k lines are one sample.

use std::path::Path;

use crate::Error;
use crate::columns::words::{Quantity, readings};
use crate::formats::delimited::NO_HEADER;
use crate::table::{Lines, Table, check_header};

/// The character between the file names.
const SEPARATOR: char = '+';
/// Largest number of files: one per joint and quantity.
const MAX_FILES: usize = 128;
/// Largest number of joints in a file with a single number per line.
const MAX_JOINTS_A_FILE: usize = 64;
/// Two clocks are the same if their times differ by less than this value, as a fraction of the step of the first clock.
const SAME_CLOCK_STEPS: f64 = 1e-3;

/// The files that a path names. `None` if it names a single file, even if the name of this file contains the separator.
pub(crate) fn files(path: &Path) -> Option<Vec<&Path>> {
    let text = path.to_str().filter(|text| text.contains(SEPARATOR))?;
    (!path.exists()).then(|| text.split(SEPARATOR).map(Path::new).collect())
}

/// The joined table of all files.
///
/// Fails if a file cannot be read, or if the rows of the files do not correspond.
pub(crate) fn read(path: &Path, files: &[&Path]) -> Result<Table, Error> {
    let file = path.display().to_string();
    if files.len() > MAX_FILES {
        return Err(Error::at(&file, 0, format!("{} files; at most {MAX_FILES} are expected", files.len())));
    }
    let mut tables = files.iter().map(|file| Table::read(file)).collect::<Result<Vec<Table>, Error>>()?;
    let names = own_names(files);
    name_by_files(&mut tables, &names);
    joined(&file, tables, &names)
}

/// The short name of each file: its stem without the common start of all stems, which ends at a separator. If a short name were
/// empty, all stems are returned unchanged.
fn own_names(files: &[&Path]) -> Vec<String> {
    let stems: Vec<String> =
        files.iter().map(|file| file.file_stem().unwrap_or_default().to_string_lossy().into()).collect();
    let shared = stems.iter().fold(stems[0].as_str(), |shared, stem| {
        let same = shared.char_indices().zip(stem.chars()).find(|((_, a), b)| a != b);
        &shared[..same.map_or(shared.len().min(stem.len()), |((at, _), _)| at)]
    });
    let begin = shared.rfind(['_', '-', '.', ' ']).map_or(0, |at| at + 1);
    if stems.iter().any(|stem| stem.len() <= begin) {
        return stems;
    }
    stems.iter().map(|stem| stem[begin..].to_string()).collect()
}

/// Names the columns of files without a header by the short names of the files. Divides a file with a single number per line
/// into columns.
fn name_by_files(tables: &mut [Table], names: &[String]) {
    let rows = tables.iter().map(Table::rows).min().unwrap_or_default();
    for (table, name) in tables.iter_mut().zip(names) {
        let Some(note) = table.notes.iter().position(|note| note == NO_HEADER) else { continue };
        table.notes.remove(note);
        let count = table.rows().checked_div(rows).filter(|count| {
            table.columns.len() == 1 && *count > 1 && table.rows() == count * rows && *count <= MAX_JOINTS_A_FILE
        });
        if let Some(count) = count {
            let values = std::mem::take(&mut table.columns[0]);
            table.columns = (0..count).map(|k| values.iter().skip(k).step_by(count).copied().collect()).collect();
            table.texts = vec![None; count];
            table.lines = Lines::default();
            table.notes.push(format!("{name}: one number a line, {count} lines a row"));
        }
        table.header = match table.columns.len() {
            1 => vec![name.clone()],
            count => (1..=count).map(|k| format!("{name}_{k}")).collect(),
        };
    }
}

fn joined(file: &str, mut tables: Vec<Table>, names: &[String]) -> Result<Table, Error> {
    let found: Vec<Option<(usize, f64)>> = tables.iter().map(clock).collect();
    let mut units = found.iter().zip(names).filter_map(|(clock, name)| Some((clock.as_ref()?.1, name)));
    if let Some((unit, first)) = units.next()
        && let Some((_, other)) = units.find(|(other, _)| *other != unit)
    {
        let message = format!("the clocks of {first} and {other} are in different units: write both in s");
        return Err(Error::at(file, 0, message));
    }
    let clocks: Vec<Option<usize>> = found.into_iter().map(|clock| clock.map(|(column, _)| column)).collect();
    let are_as_long = tables.iter().all(|table| table.rows() == tables[0].rows());
    let mut notes: Vec<String> = tables.iter().flat_map(|table| table.notes.clone()).collect();
    let mut range = 0..tables[0].rows();
    if are_as_long && (clocks.iter().flatten().count() <= 1 || are_one_clock(&tables, &clocks)) {
        notes.push(format!("{} files of {} rows are joined row by row", tables.len(), tables[0].rows()));
    } else if let Some(places) = clocks.iter().copied().collect::<Option<Vec<usize>>>() {
        range = by_time(file, &mut tables, &places, names, &mut notes)?;
    } else {
        let rows: Vec<String> =
            tables.iter().zip(names).map(|(table, name)| format!("{name} has {}", table.rows())).collect();
        let message = format!(
            "files without a clock are joined row by row, and need as many rows: {}; add a column of the time to each file, or \
             cut the rows that only one file has",
            rows.join(", ")
        );
        return Err(Error::at(file, 0, message));
    }
    let mut all = Table { file: file.into(), notes, ..Table::default() };
    let stands_twice: Vec<String> = {
        let headers: Vec<&String> = tables.iter().flat_map(|table| &table.header).collect();
        headers
            .iter()
            .filter(|name| headers.iter().filter(|other| other == name).count() > 1)
            .map(ToString::to_string)
            .collect()
    };
    let first_clock = clocks.iter().position(Option::is_some);
    let lines = std::mem::take(&mut tables[0].lines);
    for (k, table) in tables.into_iter().enumerate() {
        all.ragged += table.ragged;
        let columns = table.header.into_iter().zip(table.columns).zip(table.texts).enumerate();
        for (place, ((header, column), text)) in
            columns.filter(|(place, _)| Some(k) == first_clock || clocks[k] != Some(*place))
        {
            let is_shared = stands_twice.contains(&header) && clocks[k] != Some(place);
            all.header.push(if is_shared { format!("{}.{header}", names[k]) } else { header });
            all.columns.push(column[range.clone()].to_vec());
            all.texts.push(text);
        }
    }
    // Files in different folders may have the same name, so equal column names get numbers.
    check_header(file, 0, &mut all.header)?;
    all.lines = if range.len() == lines.len() { lines } else { Lines::default() };
    Ok(all)
}

/// The index of the clock column, and the factor that converts its numbers to s. `None` if no header names a clock.
fn clock(table: &Table) -> Option<(usize, f64)> {
    let all = readings(table, &[]).unwrap_or_default();
    all.iter().find(|reading| reading.quantity == Quantity::Time).map(|reading| (reading.column, reading.unit.1))
}

fn step(t: &[f64]) -> f64 {
    match t {
        [first, .., last] => (last - first).abs() / (t.len() - 1) as f64,
        _ => 0.0,
    }
}

/// Whether all clocks have the same times, up to rounding.
fn are_one_clock(tables: &[Table], clocks: &[Option<usize>]) -> bool {
    let all: Vec<&Vec<f64>> = tables.iter().zip(clocks).filter_map(|(table, c)| c.map(|c| &table.columns[c])).collect();
    let tolerance = SAME_CLOCK_STEPS * step(all[0]);
    all.iter().all(|t| t.iter().zip(all[0]).all(|(a, b)| (a - b).abs() <= tolerance))
}

/// Interpolates the columns of the later tables at the times of the first table. Returns the rows of the first table that all
/// tables cover.
fn by_time(
    file: &str,
    tables: &mut [Table],
    clocks: &[usize],
    names: &[String],
    notes: &mut Vec<String>,
) -> Result<std::ops::Range<usize>, Error> {
    let t = tables[0].columns[clocks[0]].clone();
    let mut range = 0..t.len();
    for (k, table) in tables.iter_mut().enumerate() {
        let own = table.columns[clocks[k]].clone();
        if let Some(row) = own.windows(2).position(|w| w[1].partial_cmp(&w[0]) != Some(std::cmp::Ordering::Greater)) {
            let message =
                format!("{}: its clock does not increase at row {}; files are joined by time", names[k], row + 2);
            return Err(Error::at(file, 0, message));
        }
        if k == 0 {
            continue;
        }
        let (Some(begin), Some(end)) = (own.first(), own.last()) else {
            return Err(Error::at(file, 0, format!("{}: it has no rows", names[k])));
        };
        range.start = range.start.max(t.partition_point(|t| t < begin));
        range.end = range.end.min(t.partition_point(|t| t <= end));
        notes.push(format!(
            "{} is joined by time to {}: it begins {:.4} s later, with a mean step of {:.4} s instead of {:.4} s",
            names[k],
            names[0],
            begin - t[0],
            step(&own),
            step(&t)
        ));
        let place = |t: f64| {
            let next = own.partition_point(|own| *own < t).clamp(1, own.len().max(2) - 1);
            let before = next - 1;
            (before, next, (t - own[before]) / (own[next] - own[before]))
        };
        if own.len() < 2 {
            return Err(Error::at(file, 0, format!("{}: one row; two and more are interpolated", names[k])));
        }
        let places: Vec<(usize, usize, f64)> = t.iter().map(|t| place(*t)).collect();
        for column in table.columns.iter_mut().filter(|column| column.len() == own.len()) {
            // If a number is missing, the interpolated values next to it are missing too.
            *column = places.iter().map(|(a, b, share)| column[*a] + share * (column[*b] - column[*a])).collect();
        }
    }
    if range.len() < 2 {
        return Err(Error::at(file, 0, "the files have no time in common: their clocks do not overlap"));
    }
    Ok(range)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Table {
        Table::from_bytes("x.csv", text.as_bytes()).unwrap()
    }

    fn join(texts: &[&str]) -> Result<Table, String> {
        let names: Vec<String> = (0..texts.len()).map(|k| format!("f{k}")).collect();
        joined("all", texts.iter().map(|text| table(text)).collect(), &names).map_err(|e| e.to_string())
    }

    #[test]
    fn files_without_a_clock_are_joined_row_by_row() {
        let all = join(&["j1,j2\n1,2\n3,4\n", "j1,j2\n5,6\n7,8\n"]).unwrap();
        assert_eq!(all.header, ["f0.j1", "f0.j2", "f1.j1", "f1.j2"]);
        assert_eq!(all.columns, [[1.0, 3.0], [2.0, 4.0], [5.0, 7.0], [6.0, 8.0]]);
        let message = join(&["j1\n1\n3\n", "tau1\n5\n"]).unwrap_err();
        assert!(message.contains("f0 has 2, f1 has 1"), "{message}");
    }

    #[test]
    fn one_clock_is_kept_once() {
        let all = join(&["t,q1\n0,1\n1,3\n", "t,tau1\n0,5\n1,7\n"]).unwrap();
        assert_eq!((all.header.join(" "), all.rows()), ("t q1 tau1".into(), 2));
        let all = join(&["q1\n1\n3\n", "t,tau1\n0,5\n1,7\n"]).unwrap();
        assert_eq!(all.header, ["q1", "t", "tau1"]);
    }

    /// Torques with another clock are interpolated in the common time interval. A straight line is reproduced exactly.
    #[test]
    fn clocks_of_their_own_are_joined_by_time() {
        let line = |from: f64, step: f64, rows: usize| -> String {
            (0..rows).map(|r| from + step * r as f64).map(|t| format!("{t},{}\n", 2.0 * t + 1.0)).collect()
        };
        let all =
            join(&[&format!("t,q1\n{}", line(0.0, 0.5, 9)), &format!("t,tau1\n{}", line(0.75, 0.3, 10))]).unwrap();
        assert_eq!(all.columns[0], [1.0, 1.5, 2.0, 2.5, 3.0]);
        for (t, tau) in all.columns[0].iter().zip(&all.columns[2]) {
            // Allowance for the rounding of the time steps of 0.3.
            assert!((tau - (2.0 * t + 1.0)).abs() < 1e-12, "{t} {tau}");
        }
        assert!(all.notes[0].contains("begins 0.7500 s later"), "{:?}", all.notes);
        let apart = join(&["t,q1\n0,1\n1,2\n", "t,tau1\n5,1\n6,2\n7,3\n"]).unwrap_err();
        assert!(apart.contains("do not overlap"), "{apart}");
        let back = join(&["t,q1\n0,1\n1,2\n", "t,tau1\n0,1\n0,2\n1,3\n"]).unwrap_err();
        assert!(back.contains("f1: its clock does not increase at row 2"), "{back}");
        let back = join(&["t,q1\n0,1\n0,2\n1,3\n", "t,tau1\n0,1\n1,2\n"]).unwrap_err();
        assert!(back.contains("f0: its clock does not increase at row 2"), "{back}");
        for texts in [["t,q1\n0,1\n1,2\n", "t_ms,tau1\n0,1\n1000,2\n"], ["t,q1\n0,1\n1,2\n", "t_ms,tau1\n0,1\n1,2\n"]] {
            let units = join(&texts).unwrap_err();
            assert!(units.contains("the clocks of f0 and f1 are in different units"), "{units}");
        }
    }

    #[test]
    fn files_name_their_columns() {
        let of = |files: &[&str]| own_names(&files.iter().map(Path::new).collect::<Vec<_>>());
        assert_eq!(of(&["a/sep_t.txt", "b/sep_tau.txt"]), ["t", "tau"]);
        assert_eq!(of(&["joint_j1.csv", "joint_j2.csv"]), ["j1", "j2"]);
        assert_eq!(of(&["q.csv", "tau.csv"]), ["q", "tau"]);
        assert_eq!(of(&["log_.csv", "log_tau.csv"]), ["log_", "log_tau"]);
        let mut tables = ["0\n0.1\n", "1\n2\n3\n4\n5\n6\n", "7,8\n9,10\n"].map(table);
        let names = ["t", "q", "tau"].map(String::from);
        name_by_files(&mut tables, &names);
        let all = joined("all", tables.into(), &names).unwrap();
        assert_eq!(all.header, ["t", "q_1", "q_2", "q_3", "tau_1", "tau_2"]);
        assert_eq!((&all.columns[2], &all.columns[5]), (&vec![2.0, 5.0], &vec![8.0, 10.0]));
        assert!(all.notes.iter().any(|note| note == "q: one number a line, 3 lines a row"), "{:?}", all.notes);
    }

    /// Files of the same name in two folders have equal column names. The columns get numbers, so that the user must select
    /// one.
    #[test]
    fn files_of_one_name_are_numbered() {
        let tables = ["q1\n1\n3\n", "q1\n5\n7\n"].map(table).into();
        let all = joined("all", tables, &["log".into(), "log".into()]).unwrap();
        assert_eq!(all.header, ["log.q1 #1", "log.q1 #2"]);
    }
}
