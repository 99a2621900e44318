//! Finds the columns of a quantity, by the meaning of their headers or by names that the user gives.
//!
//! The possible meanings of a header are its readings (`words`): a quantity, a joint and a unit. The finder chooses one column
//! per joint for each quantity, and refuses a table with two candidates.

use Quantity::{Position, Time};
use gate::suggestion::did_you_mean;

use crate::Error;
use crate::cleaning::undriven::NoTorqueReason;
use crate::columns::clocks;
use crate::columns::names::{ColumnNames, NamePattern};
use crate::columns::prefixes::prefixes;
use crate::columns::row_rate::rows_per_second;
use crate::columns::source::{ColumnSource, NO_COLUMN};
use crate::columns::units::{GivenUnit, given_unit};
use crate::columns::words::{Designator, Quantity, Reading, readings, units};
use crate::table::Table;

pub(crate) struct Finder<'a> {
    table: &'a Table,
    coordinates: &'a [String],
    readings: Vec<Reading>,
    names: &'a ColumnNames,
    /// Notes on assumptions about the columns.
    pub notes: Vec<String>,
}

impl<'a> Finder<'a> {
    /// Reads the headers of a table.
    ///
    /// Fails if a header can mean two quantities, or if the table contains the joints of several robots.
    pub(crate) fn new(
        table: &'a Table,
        coordinates: &'a [String],
        names: &'a ColumnNames,
    ) -> Result<Finder<'a>, Error> {
        let mut finder = Finder { table, coordinates, readings: readings(table, coordinates)?, names, notes: vec![] };
        finder.look_behind_prefixes()?;
        if names.rate.is_some()
            && let Ok(clock) = finder.clock_if_any()
            && clock.header != NO_COLUMN
        {
            let note = format!("`{}` is not used as the clock, since the rows per second are given", clock.header);
            finder.notes.push(note);
        }
        Ok(finder)
    }

    pub(crate) fn error(&self, message: impl Into<String>) -> Error {
        let header = self.table.header.join(", ");
        let line = usize::from(!self.table.lines.is_empty());
        let notes: String = self.table.notes.iter().map(|note| format!("; {note}")).collect();
        let repeated = match self.table.header.iter().any(|name| name.ends_with(" #1")) {
            true => " (repeated names are numbered)",
            false => "",
        };
        let message = format!("{}; the columns are{repeated}: {}{}", message.into(), clipped(&header), clipped(&notes));
        Error::at(&self.table.file, line, message)
    }

    pub(crate) fn missing(&self, quantity: Quantity) -> Error {
        let (what, examples) = match quantity {
            Position => ("joint positions", "q1.., q_<joint>, position_<joint>, actual_q_0.."),
            _ => ("joint torques or motor currents", "tau1.., effort_<joint>, i1.., actual_current_0.."),
        };
        let goals = match quantity {
            Position => "",
            _ => "; of position servos without either, the commanded positions: [options.columns.goal]",
        };
        self.error(format!(
            "no columns hold the {what} (looked for {examples}, also with units); other names go into [options.columns], as `[:columns]` proposes them{goals}"
        ))
    }

    /// The clock column. If the clock has two columns, the column of the whole seconds. Fails if there is none.
    pub(crate) fn clock(&self) -> Result<ColumnSource, Error> {
        let time = self.clock_if_any()?;
        match time.header == NO_COLUMN {
            true => {
                let rate = rows_per_second(self.table, &self.readings).map_or(String::new(), |rate| {
                    format!(" (the derivatives of the positions agree with the velocities at {rate})")
                });
                let message = format!(
                    "no column holds the time; a column `t` in seconds (or time, timestamp, t_ms) is expected; another name goes \
                     into [options.columns.time], as `[:columns]` proposes it; of a log without a clock say the rows per second, \
                     [rate=HZ]{rate}"
                );
                Err(self.error(message))
            }
            false => Ok(time),
        }
    }

    /// The clock column, or a substitute with the header [`NO_COLUMN`] if there is no clock.
    pub(crate) fn clock_if_any(&self) -> Result<ColumnSource, Error> {
        if let Some(time) = self.group(Time, 1)?.and_then(|mut group| group.pop()) {
            return Ok(time);
        }
        match clocks::pairs(self.table).first() {
            Some((seconds, _)) => self.source(Time, *seconds, ("s", 1.0)),
            None => Ok(self.without_clock()),
        }
    }

    /// The substitute for the clock column of a file without a clock.
    pub(crate) fn without_clock(&self) -> ColumnSource {
        ColumnSource { column: 0, header: NO_COLUMN.into(), unit: "s".into(), factor: 0.0, word: None }
    }

    /// The column with the fractions of a second for a column of whole seconds; `None` if there is none.
    pub(crate) fn fraction_of(&self, time: &ColumnSource) -> Option<ColumnSource> {
        let pairs = clocks::pairs(self.table);
        let (_, (column, unit, factor)) = pairs.into_iter().find(|(seconds, _)| *seconds == time.column)?;
        let header = self.table.header[column].clone();
        (time.unit == "s").then(|| ColumnSource { column, header, unit: unit.into(), factor, word: None })
    }

    /// The column with the episode number: the column that the user names, or a column with the usual name. `None` if there is
    /// none.
    pub(crate) fn episode(&self, given: Option<&str>) -> Result<Option<ColumnSource>, Error> {
        let header = &self.table.header;
        let column = match given {
            Some(name) => Some(header.iter().position(|h| h == name).ok_or_else(|| {
                let meant = did_you_mean(name, header.iter().map(String::as_str));
                self.error(format!("there is no column `{name}`{meant} that numbers the episodes"))
            })?),
            None => header.iter().position(|h| h == "episode_index").filter(|&c| self.table.texts[c].is_none()),
        };
        let unit = String::new();
        Ok(column.map(|column| ColumnSource { column, header: header[column].clone(), unit, factor: 1.0, word: None }))
    }

    /// The columns of a quantity, found by their headers, in the order of the coordinates. `None` if there are none.
    pub(crate) fn group(&self, quantity: Quantity, n: usize) -> Result<Option<Vec<ColumnSource>>, Error> {
        let all = self.group_of(quantity, &vec![true; n])?;
        Ok(all.map(|all| all.into_iter().flatten().collect()))
    }

    /// The columns of the torques or currents. The entry of a coordinate without a torque is `None`.
    pub(crate) fn efforts(
        &self,
        quantity: Quantity,
        given: Option<&NamePattern>,
        undriven: &[Option<NoTorqueReason>],
    ) -> Result<Option<Vec<Option<ColumnSource>>>, Error> {
        let needed: Vec<bool> = undriven.iter().map(Option::is_none).collect();
        let found = match given {
            Some(names) => Some(self.given_of(quantity, names, &needed)?),
            None => self.group_of(quantity, &needed)?,
        };
        let without = |(source, needed): (Option<ColumnSource>, &bool)| source.filter(|_| *needed);
        Ok(found.map(|all| all.into_iter().zip(&needed).map(without).collect()))
    }

    /// The columns of a quantity, found by their headers. A coordinate must have a column only if its entry in `needed` is true.
    fn group_of(&self, quantity: Quantity, needed: &[bool]) -> Result<Option<Vec<Option<ColumnSource>>>, Error> {
        let n = needed.len();
        let group: Vec<&Reading> = self.readings.iter().filter(|r| r.quantity == quantity).collect();
        if group.is_empty() {
            return Ok(None);
        }
        // If one joint has the number 0, the joints are numbered from 0; otherwise from 1.
        let from_zero = group.iter().any(|r| r.joint == Designator::Number(0));
        let mut places: Vec<Option<&Reading>> = vec![None; n];
        for reading in group {
            let place = match reading.joint {
                Designator::None => 0,
                Designator::Coordinate(k) => k,
                Designator::Number(i) => i.wrapping_sub(usize::from(!from_zero)),
            };
            // A number beyond the number of joints belongs to another device, such as a gripper, and is ignored.
            let Some(slot) = places.get_mut(place) else { continue };
            if let Some(other) = slot {
                let (a, b) = (&self.table.header[other.column], &self.table.header[reading.column]);
                let what = match quantity {
                    Time => "time".into(),
                    _ => format!("{quantity:?} of joint {}", place + 1).to_lowercase(),
                };
                return Err(self.error(format!(
                    "`{a}` and `{b}` both hold the {what}; say which one to use by naming the columns"
                )));
            }
            *slot = Some(reading);
        }
        // Fails if some of the needed joints have no column of this quantity.
        let missing: Vec<usize> = (0..n).filter(|&k| needed[k] && places[k].is_none()).collect();
        if !missing.is_empty() {
            return Err(self.error(self.of_some_joints(quantity, &missing)));
        }
        let source = |place: Option<&Reading>| place.map(|r| self.source(quantity, r.column, r.unit)).transpose();
        places.into_iter().map(source).collect::<Result<_, _>>().map(Some)
    }

    /// The error message if some joints have no column of a quantity. It has one line for all these joints.
    fn of_some_joints(&self, quantity: Quantity, joints: &[usize]) -> String {
        let name = |k: &usize| self.coordinates.get(*k).map_or("", String::as_str);
        let names: Vec<&str> = joints.iter().map(name).collect();
        let (all, locks) =
            (names.join(", "), names.iter().map(|name| format!("{name}=0")).collect::<Vec<_>>().join(","));
        let which: Vec<String> = joints.iter().map(|k| format!("{} ({})", k + 1, name(k))).collect();
        let (of, is, stood, others) = match which.as_slice() {
            [_] => ("joint", "is", "a joint that stood still is", "one"),
            _ => ("joints", "are", "joints that stood still are", "those"),
        };
        let otherwise = match quantity {
            Quantity::Torque | Quantity::Current => format!(
                "; {others} that something else moves {is} named in [options], `columns: {{prescribed: [{all}]}}`, {others} that \
                 nothing drives by `columns: {{free: [{all}]}}`"
            ),
            _ => String::new(),
        };
        let quantity = format!("{quantity:?}").to_lowercase();
        format!(
            "the {quantity} of {of} {} is missing, though other joints have it; {stood} left out of the model by [lock={locks}], \
             with {} position{otherwise}",
            which.join(", "),
            if joints.len() == 1 { "its" } else { "their" }
        )
    }

    /// A column with its unit: the unit that the user gives, otherwise the unit in the header.
    fn source(&self, quantity: Quantity, column: usize, of_header: (&str, f64)) -> Result<ColumnSource, Error> {
        let header = self.table.header[column].clone();
        let given = self.names.units.of(quantity).map(|text| given_unit(quantity, text));
        let given = given.transpose().map_err(|what| Error::new(format!("[options.units]: {what}")))?;
        let (name, factor) = of_header;
        let GivenUnit { name: unit, factor, word } =
            given.unwrap_or(GivenUnit { name: name.to_string(), factor, word: None });
        Ok(ColumnSource { column, header, unit, factor, word })
    }

    /// If no positions are found, tries other names of the joints: with a prefix of the table, or without their common prefix.
    fn look_behind_prefixes(&mut self) -> Result<(), Error> {
        let has_positions = |readings: &[Reading]| readings.iter().any(|r| r.quantity == Position);
        if self.names.position.is_some() || has_positions(&self.readings) || self.coordinates.is_empty() {
            return Ok(());
        }
        // A prefix counts only if it gives the position of every coordinate.
        let found: Vec<(String, Vec<Reading>)> = prefixes(self.table, self.coordinates)
            .into_iter()
            .filter_map(|(said, coordinates)| {
                let readings = readings(self.table, &coordinates).ok()?;
                let of =
                    |k: usize| readings.iter().any(|r| r.quantity == Position && r.joint == Designator::Coordinate(k));
                (0..coordinates.len()).all(of).then_some((said, readings))
            })
            .collect();
        let mut found = found;
        // Prefixes that differ only by separators at their start find the same columns: the shorter one is kept.
        let columns =
            |readings: &[Reading]| readings.iter().map(|r| (r.column, r.quantity, r.joint)).collect::<Vec<_>>();
        let mut kept: Vec<_> = Vec::new();
        found.reverse();
        found.retain(|(_, readings)| {
            let own = columns(readings);
            let is_new = !kept.contains(&own);
            kept.push(own);
            is_new
        });
        found.reverse();
        // Several matching prefixes are several robots: the user must choose.
        match found.len() {
            0 => Ok(()),
            1 => {
                let (said, readings) = found.remove(0);
                self.notes.push(said);
                self.readings = readings;
                Ok(())
            }
            _ => {
                let said: Vec<&str> = found.iter().map(|(said, _)| said.as_str()).collect();
                Err(self.error(format!(
                    "the joints stand there several times: {}; name the columns of one of them, with {{joint}} for the name, \
                     in [options.columns]",
                    said.join("; ")
                )))
            }
        }
    }

    pub(crate) fn given(&self, quantity: Quantity, names: &NamePattern) -> Result<Vec<ColumnSource>, Error> {
        let all = self.given_of(quantity, names, &vec![true; self.coordinates.len()])?;
        Ok(all.into_iter().flatten().collect())
    }

    /// The columns with the names that the user gives. A coordinate must have a column only if its entry in `needed` is true.
    fn given_of(
        &self,
        quantity: Quantity,
        names: &NamePattern,
        needed: &[bool],
    ) -> Result<Vec<Option<ColumnSource>>, Error> {
        let n = self.coordinates.len();
        let wanted = needed.iter().filter(|needed| **needed).count();
        let by_name = |pattern: &str, braces: &str| -> Vec<String> {
            self.coordinates.iter().map(|name| pattern.replace(braces, name)).collect()
        };
        let names: Vec<String> = match names {
            NamePattern::Pattern(p) if p.contains("{joint}") => by_name(p, "{joint}"),
            NamePattern::Pattern(p) if p.contains("{}") => {
                let counted = |first: usize| (first..n + first).map(|i| p.replace("{}", &i.to_string())).collect();
                let numberings: [Vec<String>; 3] = [counted(1), counted(0), by_name(p, "{}")];
                let is_there = |(name, needed): (&String, &bool)| !needed || self.column(name).is_some();
                let are_there = |way: &&Vec<String>| way.iter().zip(needed).all(is_there);
                // If a file has a column with the number 0, the numbers of its columns start at 0, even if there are more such
                // columns than joints.
                let order = if self.column(&p.replace("{}", "0")).is_some() { [1, 0, 2] } else { [0, 1, 2] };
                order.iter().map(|k| &numberings[*k]).find(are_there).unwrap_or(&numberings[0]).clone()
            }
            NamePattern::Pattern(p) if n == 1 => vec![p.clone()],
            NamePattern::Pattern(p) => {
                return Err(self.error(format!(
                    "`{p}` names one column for {n} joints; write `{{}}` for the number, or `{{joint}}` for the name"
                )));
            }
            NamePattern::Each(names) if names.len() == n => names.clone(),
            NamePattern::Each(names) if names.len() == wanted => {
                let mut names = names.iter();
                needed.iter().map(|needed| names.by_ref().take(usize::from(*needed)).cloned().collect()).collect()
            }
            NamePattern::Each(names) => {
                return Err(
                    self.error(format!("{} names of {quantity:?} columns are given for {wanted} joints", names.len()))
                );
            }
        };
        let source = |(name, needed): (&String, &bool)| needed.then(|| self.named(quantity, name)).transpose();
        names.iter().zip(needed).map(source).collect()
    }

    /// Index of the column with this header. A unit in brackets at the end of the header may be omitted.
    fn column(&self, name: &str) -> Option<usize> {
        let bracketed = |header: &str| {
            let rest = header.strip_prefix(name)?.trim_start_matches(['_', ' ']);
            (rest.starts_with(['[', '(']) && rest.ends_with([']', ')'])).then_some(())
        };
        let header = &self.table.header;
        header.iter().position(|h| h == name).or_else(|| header.iter().position(|h| bracketed(h).is_some()))
    }

    /// The column with this name. A `-` before the name means that the sign of its numbers is changed.
    pub(crate) fn named(&self, quantity: Quantity, name: &str) -> Result<ColumnSource, Error> {
        if let Some(name) = name.strip_prefix('-').filter(|_| self.column(name).is_none()) {
            let source = self.named(quantity, name)?;
            return Ok(ColumnSource { factor: -source.factor, ..source });
        }
        let column = self.column(name).ok_or_else(|| {
            let meant = did_you_mean(name, self.table.header.iter().map(String::as_str));
            self.error(format!("there is no column `{name}`{meant}"))
        })?;
        let lower = self.table.header[column].to_lowercase();
        let lower = lower.trim_end_matches([']', ')']);
        let units = units(quantity);
        let bare = lower.trim_end_matches(|c: char| c.is_ascii_digit() || c == '_');
        let separated =
            |text: &str, unit: &str| text.strip_suffix(unit).is_some_and(|r| r.ends_with(['_', '.', '-', '[', '(']));
        let unit = units.iter().find(|u| separated(lower, u.0) || separated(bare, u.0));
        let unit = unit.or(units.first()).copied().unwrap_or(("", 1.0));
        self.source(quantity, column, unit)
    }
}

/// Largest number of characters of a list in a message.
const MAX_LISTED_CHARACTERS: usize = 300;
fn clipped(text: &str) -> String {
    let has_room = text.chars().count() <= MAX_LISTED_CHARACTERS;
    if has_room { text.into() } else { text.chars().take(MAX_LISTED_CHARACTERS).chain(" ..".chars()).collect() }
}
