//! Postures of a robot at rest, with the holding torques: from the rows of a table, or from the plateaus of a log.
//!
//! If a table has no clock, or a step of half a second or more, each row is a posture. In another log, a posture is a plateau: an
//! interval of at least [`MIN_PLATEAU_S`] in which no joint leaves a small range. Its values are means over the middle of the
//! plateau.

use std::path::Path;

use crate::Error;
use crate::cleaning::clock::SLOWEST_CLOCK_STEP_S;
use crate::cleaning::goals::GoalSpan;
use crate::columns::mapping::Columns;
use crate::columns::names::ColumnNames;
use crate::columns::source::NO_COLUMN;
use crate::effort::Effort;
use crate::table::Table;

/// Shortest duration of a plateau, s.
const MIN_PLATEAU_S: f64 = 0.5;
/// Largest distance of a joint from its first position within a plateau, rad (m).
const PLATEAU_BAND: f64 = 1e-3;
/// The interval of a plateau that is averaged, as fractions of its duration. Before this interval the robot may still settle, and
/// after it a slow motion may start.
const SETTLED_SHARES: std::ops::Range<f64> = 0.4..0.8;
/// Largest number of rows in a table of postures.
const MAX_POSTURES: usize = 20_000;

/// Several postures with their holding torques.
#[derive(Clone, Debug, PartialEq)]
pub struct Postures {
    /// Name of the file, as given by the user.
    pub name: String,
    /// Names of the coordinates, in the order of the numbers of a posture.
    pub coordinates: Vec<String>,
    /// For each posture, the positions of all joints, rad (m).
    pub q: Vec<Vec<f64>>,
    /// For each posture, the efforts of all joints: N m (N), A, or rad (m), depending on `effort_is`.
    pub effort: Vec<Vec<f64>>,
    /// The quantity in `effort`: torques, currents or position errors.
    pub effort_is: Effort,
    /// Number of rows of the file.
    pub rows: usize,
    /// The names of the columns that were read.
    pub names: ColumnNames,
    /// Whether each posture is the mean of several rows of a log.
    pub are_plateaus: bool,
}

impl Postures {
    /// Reads the postures of these coordinates from a file.
    ///
    /// Fails if the file cannot be read, if a column is missing, if the joints never rest, or if a table has more rows than
    /// `MAX_POSTURES`.
    pub fn read(path: &Path, coordinates: &[String], names: &ColumnNames) -> Result<(Postures, Columns), Error> {
        Postures::of_table(&Table::read(path)?, coordinates, names)
    }

    /// Extracts the postures of these coordinates from a table.
    pub fn of_table(table: &Table, coordinates: &[String], names: &ColumnNames) -> Result<(Postures, Columns), Error> {
        let columns = Columns::of_postures(table, coordinates, names)?;
        let series = |sources: &[crate::ColumnSource]| -> Vec<Vec<f64>> {
            sources.iter().map(|s| table.columns[s.column].iter().map(|x| s.si(*x)).collect()).collect()
        };
        // A row with a missing number is not a posture.
        let (q, mut effort) = (series(&columns.position), series(&columns.effort));
        let finite = |r: &usize| q.iter().chain(&effort).all(|x| x[*r].is_finite());
        let rows: Vec<usize> = (0..table.rows()).filter(finite).collect();
        let effort_is = Effort::of(columns.effort_is);
        if effort_is == Effort::PositionError {
            let driven = columns.effort.iter().zip(&q).zip(&mut effort).filter(|((s, _), _)| s.header != NO_COLUMN);
            for ((s, q), goal) in driven {
                let mut span = GoalSpan::default();
                span.take(&s.header, q, goal);
                span.check(&table.file)?;
            }
        }
        // Stores the names that select the same columns again.
        let mut found = Postures {
            name: table.file.clone(),
            coordinates: coordinates.to_vec(),
            q: Vec::new(),
            effort: Vec::new(),
            effort_is,
            rows: table.rows(),
            names: effort_is.names(columns.read()),
            are_plateaus: false,
        };
        let t: Option<Vec<f64>> = columns.clock().map(|s| table.columns[s.column].iter().map(|x| s.si(*x)).collect());
        // If the clock has short steps, the table is a log with plateaus. Otherwise every row is a posture.
        match t.filter(|t| step(t) < SLOWEST_CLOCK_STEP_S) {
            None if rows.len() > MAX_POSTURES => {
                let message = format!(
                    "{} rows without a clock: a table of postures has at most {MAX_POSTURES}; of a log name the column of the \
                     time, [options.columns.time]",
                    rows.len()
                );
                return Err(Error::at(&table.file, 0, message));
            }
            None => rows.iter().for_each(|&r| found.push(&q, &effort, &[r])),
            Some(t) => {
                found.are_plateaus = true;
                plateaus(&t, &q, &rows).iter().for_each(|rows| found.push(&q, &effort, rows));
            }
        }
        if found.q.is_empty() {
            let message = match found.are_plateaus {
                true => format!(
                    "no posture: nowhere do all joints stay within {PLATEAU_BAND} rad (m) for {MIN_PLATEAU_S} s; a log of a motion \
                     is one for rist identify"
                ),
                false => "no row has a number for each position and torque".into(),
            };
            return Err(Error::at(&table.file, 0, message));
        }
        Ok((found, columns))
    }

    /// Adds a posture: the means of these rows.
    fn push(&mut self, q: &[Vec<f64>], effort: &[Vec<f64>], rows: &[usize]) {
        let mean = |x: &Vec<f64>| rows.iter().map(|&r| x[r]).sum::<f64>() / rows.len() as f64;
        self.q.push(q.iter().map(mean).collect());
        self.effort.push(effort.iter().map(mean).collect());
    }
}

/// The median step of a clock, s; infinite if the clock never advances.
fn step(t: &[f64]) -> f64 {
    let mut steps: Vec<f64> = t.windows(2).map(|w| w[1] - w[0]).filter(|step| *step > 0.0).collect();
    let middle = steps.len() / 2;
    if steps.is_empty() { f64::INFINITY } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// The rows of each plateau, without the rows in which the robot still settles.
fn plateaus(t: &[f64], q: &[Vec<f64>], rows: &[usize]) -> Vec<Vec<usize>> {
    let mut found = Vec::new();
    let mut first = 0;
    while first < rows.len() {
        let stays = |r: usize| q.iter().all(|q| (q[r] - q[rows[first]]).abs() <= PLATEAU_BAND);
        let end = (first..rows.len()).find(|&k| !stays(rows[k])).unwrap_or(rows.len());
        let (start, last) = (t[rows[first]], t[rows[end - 1]]);
        if last - start < MIN_PLATEAU_S {
            first += 1;
            continue;
        }
        let settled = |r: &usize| SETTLED_SHARES.contains(&((t[*r] - start) / (last - start)));
        let of_plateau: Vec<usize> = rows[first..end].iter().copied().filter(settled).collect();
        if !of_plateau.is_empty() {
            found.push(of_plateau);
        }
        first = end;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write as _;

    fn read(text: &str) -> Result<Postures, Error> {
        let table = Table::from_bytes("log.csv", text.as_bytes())?;
        Ok(Postures::of_table(&table, &["a".into()], &ColumnNames::default())?.0)
    }

    #[test]
    fn rows_are_postures_where_no_clock_is() {
        for text in ["q_a,tau_a\n0.1,5\n0.2,6\n", "t,q_a,tau_a\n0,0.1,5\n1,0.2,6\n", "q_a,tau_a\n0.1,5\nnan,1\n0.2,6\n"]
        {
            let found = read(text).unwrap();
            assert_eq!((found.q.concat(), found.effort.concat()), (vec![0.1, 0.2], vec![5.0, 6.0]));
            assert!(found.q.len() == 2 && !found.are_plateaus);
        }
        let many: String =
            std::iter::once("q_a,tau_a\n".into()).chain((0..20_001).map(|k| format!("{k}e-5,1\n"))).collect();
        assert!(read(&many).unwrap_err().to_string().contains("20001 rows without a clock"));
    }

    #[test]
    fn plateaus_of_a_log_are_postures() {
        let mut text = "t,q_a,tau_a\n".to_string();
        for k in 0..600 {
            // The joint is 2 s at 0, moves for 1 s, and is 3 s at 1. The torque settles after each stop.
            let t = 0.01 * f64::from(k);
            let q = (t - 2.0).clamp(0.0, 1.0);
            let since = if t < 2.0 { t } else { t - 3.0 };
            let _ = writeln!(text, "{t},{q},{}", 3.0 + q + if since < 0.2 { 5.0 } else { 0.0 });
        }
        let found = read(&text).unwrap();
        let near = |a: f64, b: f64| (a - b).abs() < 1e-3;
        assert_eq!((found.q.len(), found.are_plateaus), (2, true));
        assert!(near(found.q[0][0], 0.0) && near(found.effort[0][0], 3.0));
        assert!(near(found.q[1][0], 1.0) && near(found.effort[1][0], 4.0));
        let moving: String = (0..200).map(|k| format!("{},{},1\n", 0.01 * f64::from(k), 0.02 * f64::from(k))).collect();
        let message = read(&format!("t,q_a,tau_a\n{moving}")).unwrap_err().to_string();
        assert!(message.contains("no posture: nowhere do all joints stay"), "{message}");
    }
}
