//! Maps the columns of a table to quantities, joints and units.
//!
//! Columns are found by the meaning of their headers (`words`), or the user names them. If two columns match one quantity of
//! one joint, the table is refused. The mapping can be printed.

use std::fmt;

use Quantity::*;

use crate::Error;
use crate::cleaning::account::ReadColumns;
use crate::cleaning::undriven::NoTorqueReason;
use crate::columns::finder::Finder;
use crate::columns::names::{ColumnNames, NamePattern};
use crate::columns::source::{ColumnSource, NO_COLUMN};
use crate::columns::words::{Quantity, of_sliding, written};
use crate::table::Table;

/// Which signals a table must have in addition to positions.
#[derive(Clone, Copy)]
struct Needed {
    time: bool,
    efforts: bool,
}

/// The mapping from columns of a table to signals of a robot. If the mapping is printed, every choice is listed.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// Names of the coordinates, in the order of the series.
    pub coordinates: Vec<String>,
    /// The column of the clock.
    pub time: ColumnSource,
    /// Rows per second (Hz) if the user gives them instead of a clock column.
    pub rate: Option<f64>,
    /// The column that is added to `time`: the fractions of a second of a clock in two columns.
    pub time_fraction: Option<ColumnSource>,
    /// The column with the episode number; `None` if the file has none.
    pub episode: Option<ColumnSource>,
    /// Positions, one column per coordinate.
    pub position: Vec<ColumnSource>,
    /// Velocities, one column per coordinate; `None` if the file has none.
    pub velocity: Option<Vec<ColumnSource>>,
    /// Accelerations, one column per coordinate; `None` if the file has none.
    pub acceleration: Option<Vec<ColumnSource>>,
    /// Torques; or currents if there are no torques; or goals of position servos. One column per coordinate. A coordinate without
    /// a torque has its position column with the factor zero.
    pub effort: Vec<ColumnSource>,
    /// For each coordinate, the reason why it has no torque; `None` if it has a torque.
    pub undriven: Vec<Option<NoTorqueReason>>,
    /// The quantity in the effort columns: torque, current or goal.
    pub effort_is: Quantity,
    /// Headers of the file that are not used.
    pub unused: Vec<String>,
    /// Notes from reading the file (`Table::notes`).
    pub notes: Vec<String>,
}

impl Columns {
    /// Changes the units for sliding (prismatic) coordinates: lengths in m and forces in N if the headers have no unit. `slides`:
    /// for each coordinate, whether it slides.
    ///
    /// Fails if a header has deg, rpm, or N m with a factor, because these are no units of a length or a force.
    pub fn with_sliding(mut self, slides: &[bool]) -> Result<Columns, Error> {
        let groups =
            [Some(&mut self.position), self.velocity.as_mut(), self.acceleration.as_mut(), Some(&mut self.effort)];
        for sources in groups.into_iter().flatten() {
            let sliding = sources.iter_mut().zip(slides).zip(&self.coordinates).filter(|((_, slides), _)| **slides);
            for ((source, _), name) in sliding {
                source.unit = of_sliding(&source.unit).map(str::to_string).ok_or_else(|| {
                    let unit = written(&source.unit);
                    Error::new(format!(
                        "column `{}` is in {unit}, and joint {name} slides: m, m/s, m/s^2 or N are expected; check the \
                         order of the columns, or name them in [options.columns]",
                        source.header
                    ))
                })?;
            }
        }
        Ok(self)
    }

    /// Finds the columns for the coordinates of a robot in a table.
    ///
    /// Fails when time, a position or an effort is missing, or when two columns are found for one quantity.
    pub fn find(table: &Table, coordinates: &[String], names: &ColumnNames) -> Result<Columns, Error> {
        Columns::found(table, coordinates, names, Needed { time: true, efforts: true })
    }

    /// Finds the columns of a log of postures, which needs no clock.
    ///
    /// Fails when a position or an effort is missing, or when two columns are found for one quantity.
    pub(crate) fn of_postures(table: &Table, coordinates: &[String], names: &ColumnNames) -> Result<Columns, Error> {
        Columns::found(table, coordinates, names, Needed { time: false, efforts: true })
    }

    /// Finds the columns of positions; a clock and efforts are optional.
    ///
    /// Fails when a position is missing, or when two columns are found for one quantity.
    pub fn of_positions(table: &Table, coordinates: &[String], names: &ColumnNames) -> Result<Columns, Error> {
        Columns::found(table, coordinates, names, Needed { time: false, efforts: false })
    }

    /// The clock column; `None` if there is none.
    pub(crate) fn clock(&self) -> Option<&ColumnSource> {
        (self.time.header != NO_COLUMN).then_some(&self.time)
    }

    /// Finds the columns of a planned motion, in which efforts are optional.
    ///
    /// Fails when time or a position is missing, or when two columns are found for one quantity.
    pub fn of_motion(table: &Table, coordinates: &[String], names: &ColumnNames) -> Result<Columns, Error> {
        Columns::found(table, coordinates, names, Needed { time: true, efforts: false })
    }

    fn found(table: &Table, coordinates: &[String], names: &ColumnNames, needed: Needed) -> Result<Columns, Error> {
        let finder = Finder::new(table, coordinates, names)?;
        let undriven = names.undriven(coordinates).map_err(Error::new)?;
        let mut time = clock(table, &finder, names, needed)?;
        let time_fraction = finder.fraction_of(&time);
        let episode = finder.episode(names.episode.as_deref())?;
        let quantity = |quantity: Quantity, given: &Option<NamePattern>| match given {
            Some(given) => finder.given(quantity, given).map(Some),
            None => finder.group(quantity, coordinates.len()),
        };
        let position = quantity(Position, &names.position)?.ok_or_else(|| finder.missing(Position))?;
        if time.header == NO_COLUMN {
            // The substitute for the clock refers to a column that is read anyway.
            time.column = position.first().map_or(0, |source| source.column);
        }
        // If the user names a column as a position (`A1`), it is not used as a velocity or an acceleration too.
        let is_apart = |found: &Vec<ColumnSource>| found.iter().all(|s| position.iter().all(|p| p.column != s.column));
        let velocity = quantity(Velocity, &names.velocity)?.filter(is_apart);
        let acceleration = quantity(Acceleration, &names.acceleration)?.filter(is_apart);
        let (efforts, effort_is) = efforts(&finder, names, &undriven, needed)?;
        let none = |position: &ColumnSource| ColumnSource {
            header: NO_COLUMN.into(),
            unit: "nm".into(),
            factor: 0.0,
            ..position.clone()
        };
        let effort =
            efforts.into_iter().zip(&position).map(|(source, position)| source.unwrap_or_else(|| none(position)));
        let effort = effort.collect();
        let mut columns = Columns {
            coordinates: coordinates.to_vec(),
            time,
            rate: names.rate,
            time_fraction,
            episode,
            position,
            velocity,
            acceleration,
            effort,
            undriven,
            effort_is,
            unused: Vec::new(),
            notes: table.notes.iter().cloned().chain(finder.notes).collect(),
        };
        let used = columns.places();
        let unused = (0..table.header.len()).filter(|c| !used.contains(c) && !table.header[*c].is_empty());
        columns.unused = unused.map(|c| table.header[c].clone()).collect();
        Ok(columns)
    }

    /// The names of the columns in use, as a user can write them in options.
    pub(crate) fn read(&self) -> ReadColumns {
        let each = |all: &[ColumnSource]| -> Vec<String> {
            all.iter().filter(|source| source.header != NO_COLUMN).map(ColumnSource::name).collect()
        };
        ReadColumns {
            position: each(&self.position),
            velocity: self.velocity.as_deref().map(each),
            acceleration: self.acceleration.as_deref().map(each),
            effort: each(&self.effort),
        }
    }

    /// Indices in the table of all columns in use.
    pub(crate) fn places(&self) -> Vec<usize> {
        let optional = self.time_fraction.iter().chain(&self.episode);
        self.sources().chain(optional).filter(|s| s.header != NO_COLUMN).map(|source| source.column).collect()
    }

    /// The columns of all series, time first.
    pub fn sources(&self) -> impl Iterator<Item = &ColumnSource> {
        let optional = self.velocity.iter().chain(&self.acceleration).flatten();
        std::iter::once(&self.time).chain(&self.position).chain(optional).chain(&self.effort)
    }
}

impl fmt::Display for Columns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Writes one line per choice, so that the user can see a wrong column.
        match (&self.time_fraction, self.rate) {
            (_, Some(rate)) => writeln!(f, "time: {rate} rows per second, as given")?,
            _ if self.clock().is_none() => writeln!(f, "time: not in the file, each row is a posture")?,
            (Some(fraction), _) => writeln!(f, "time: {} and {fraction}", self.time)?,
            (None, _) => writeln!(f, "time: {}", self.time)?,
        }
        if let Some(episode) = &self.episode {
            writeln!(f, "episodes: {}", episode.header)?;
        }
        let effort = match self.effort_is {
            Torque => "torque",
            Goal => "goal",
            _ => "current",
        };
        let rows = [
            ("position", Some(&self.position)),
            ("velocity", self.velocity.as_ref()),
            ("acceleration", self.acceleration.as_ref()),
            (effort, Some(&self.effort)),
        ];
        // A coordinate without an effort column is listed below.
        for (name, sources) in rows {
            let Some(sources) = sources else {
                writeln!(f, "{name}: not in the file")?;
                continue;
            };
            let pairs = self.coordinates.iter().zip(sources);
            let pairs = pairs.filter(|(_, s)| s.header != NO_COLUMN);
            let pairs: Vec<String> = pairs.map(|(k, s)| format!("{k} <- {s}")).collect();
            writeln!(f, "{name}: {}", pairs.join(", "))?;
        }
        // Lists the coordinates without a torque, grouped by the reason.
        for (why, what) in [
            (NoTorqueReason::Prescribed, "prescribed: their positions count, and give no rows of torque"),
            (NoTorqueReason::Free, "free: their torque is zero"),
        ] {
            let of = self.coordinates.iter().zip(&self.undriven).filter(|(_, undriven)| **undriven == Some(why));
            let of: Vec<&str> = of.map(|(name, _)| name.as_str()).collect();
            if !of.is_empty() {
                writeln!(f, "{}: {what}", of.join(", "))?;
            }
        }
        if !self.unused.is_empty() {
            writeln!(f, "not used: {}", self.unused.join(", "))?;
        }
        for note in &self.notes {
            writeln!(f, "note: {note}")?;
        }
        Ok(())
    }
}

/// The clock column that the user names, or that is found by its header. A substitute if the user gives the rows per second.
fn clock(table: &Table, finder: &Finder, names: &ColumnNames, needed: Needed) -> Result<ColumnSource, Error> {
    check_rate(names)?;
    let mut time = match &names.time {
        _ if names.rate.is_some() => finder.without_clock(),
        Some(name) => finder.named(Time, name)?,
        None if needed.time => finder.clock()?,
        None => finder.clock_if_any()?,
    };
    if time.unit == "s"
        && time.header != NO_COLUMN
        && names.units.time.is_none()
        && let Some((unit, factor)) = epoch_unit(&table.columns[time.column])
    {
        (time.unit, time.factor) = (unit.to_string(), factor);
    }
    Ok(time)
}

/// The torques, currents or goals of the coordinates, and which of these quantities they are. `None` for a coordinate without
/// a torque.
fn efforts(
    finder: &Finder,
    names: &ColumnNames,
    undriven: &[Option<NoTorqueReason>],
    needed: Needed,
) -> Result<(Vec<Option<ColumnSource>>, Quantity), Error> {
    refuse_two_efforts(names)?;
    let effort = |quantity: Quantity, given: &Option<NamePattern>| finder.efforts(quantity, given.as_ref(), undriven);
    // If the user names currents or goals, they are used even if the table also has torques.
    let torque = match names.current.is_some() || names.goal.is_some() {
        true => None,
        false => effort(Torque, &names.torque)?,
    };
    Ok(match torque {
        Some(torque) => (torque, Torque),
        None if names.goal.is_some() => (effort(Goal, &names.goal)?.unwrap_or_default(), Goal),
        None if !needed.efforts => (vec![], Torque),
        None if undriven.iter().all(Option::is_some) => (vec![None; undriven.len()], Torque),
        None => (effort(Current, &names.current)?.ok_or_else(|| finder.missing(Torque))?, Current),
    })
}

/// Fails if the rate is not a positive number, or if the user also names a clock column.
fn check_rate(names: &ColumnNames) -> Result<(), Error> {
    match names.rate {
        Some(rate) if !(rate.is_finite() && rate > 0.0) => Err(Error::new(format!(
            "[options.columns.rate]: rows per second, a positive number of Hz, are expected, found {rate}"
        ))),
        Some(_) if names.time.is_some() => {
            Err(Error::new("[options.columns.rate] and [options.columns.time] are both given: keep one of them"))
        }
        _ => Ok(()),
    }
}

/// Fails if the user names goals and also torques or currents, because a joint has only one kind of effort.
fn refuse_two_efforts(names: &ColumnNames) -> Result<(), Error> {
    let other = [("torque", &names.torque), ("current", &names.current)].into_iter().find(|(_, given)| given.is_some());
    match other.filter(|_| names.goal.is_some()) {
        Some((other, _)) => Err(Error::new(format!(
            "[options.columns.goal] stands together with [options.columns.{other}]: the error of a goal is what a servo has instead \
             of a torque; take the goal away where the {other} is measured, or the {other} where it is not believed"
        ))),
        None => Ok(()),
    }
}

/// The unit of a clock that counts from 1970: ms, us or ns; `None` for s. Assumption: the log is from 1990 to 2100.
fn epoch_unit(clock: &[f64]) -> Option<(&'static str, f64)> {
    const SECONDS_SINCE_1970: std::ops::Range<f64> = 631e6..4102e6;
    let first = clock.iter().find(|t| t.is_finite())?;
    let units = [("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];
    units.into_iter().find(|unit| SECONDS_SINCE_1970.contains(&(first * unit.1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::units::UnitNames;

    fn find(header: &str, coordinates: &[&str], names: &ColumnNames) -> Result<Columns, Error> {
        let header: Vec<String> = header.split(',').map(Into::into).collect();
        let table = Table { file: "log.csv".into(), columns: vec![vec![]; header.len()], header, ..Table::default() };
        Columns::find(&table, &coordinates.iter().map(|c| c.to_string()).collect::<Vec<_>>(), names)
    }

    #[test]
    fn the_ways_of_writing_a_column() {
        for header in [
            "t,q1,q2,dq1,dq2,tau1,tau2",
            "time,q_1,q_2,qd_1,qd_2,effort_1,effort_2",
            "timestamp,actual_q_0,actual_q_1,actual_qd_0,actual_qd_1,actual_current_0,actual_current_1",
            "time_s,position_shoulder,position_elbow,velocity_shoulder,velocity_elbow,torque_shoulder,torque_elbow",
            "t,elbow/position,shoulder/position,elbow/velocity,shoulder/velocity,elbow/effort,shoulder/effort",
            "t,q[1],q[2],v1,v2,i1_mA,i2_mA",
            "t,q_deg1,q_deg2,qd_degps1,qd_degps2,tau1_Nm,tau2_Nm",
            "__time,/joint_states/elbow/position,/joint_states/shoulder/position,/joint_states/elbow/velocity,/joint_states/shoulder/velocity,/joint_states/elbow/effort,/joint_states/shoulder/effort",
            "%time,field.position0,field.position1,field.velocity0,field.velocity1,field.effort0,field.effort1",
            "timestamp,actual_joint_pos_1,actual_joint_pos_2,actual_joint_vel_1,actual_joint_vel_2,actual_joint_torque_1,actual_joint_torque_2",
            "Time (s),q_meas_1,q_meas_2,dq_meas_1,dq_meas_2,tau_meas_1,tau_meas_2",
        ] {
            let columns = find(header, &["shoulder", "elbow"], &ColumnNames::default()).unwrap();
            assert!(columns.unused.is_empty(), "{header}: {columns}");
            assert!(columns.velocity.is_some(), "{header}");
            let first = if header.contains("elbow/") { 2 } else { 1 };
            assert_eq!(columns.position[0].column, first, "{header}");
        }
        let columns = find("t,q1_deg,i1_mA", &["q1"], &ColumnNames::default()).unwrap();
        assert_eq!((columns.position[0].unit.as_str(), columns.effort[0].factor), ("deg", 1e-3));
    }

    /// `rostopic echo -p` writes the joints in the order of the message. Separate columns contain the joint names.
    #[test]
    fn joint_names_in_columns_of_their_own() {
        let mut table = Table {
            file: "log.csv".into(),
            header: ["%time", "field.name0", "field.name1", "field.position0", "field.position1", "tau0", "tau1"]
                .map(Into::into)
                .to_vec(),
            columns: vec![vec![1.6e18]; 7],
            texts: vec![None; 7],
            ..Table::default()
        };
        let coordinates = ["shoulder".to_string(), "elbow".to_string()];
        let find = |table: &Table| Columns::find(table, &coordinates, &ColumnNames::default()).unwrap();
        assert_eq!(find(&table).position[0].column, 3);
        (table.texts[1], table.texts[2]) = (Some((2, "elbow".into())), Some((2, "shoulder".into())));
        let columns = find(&table);
        assert_eq!((columns.position[0].column, columns.effort[1].column), (4, 5));
        // 1.6e18 in s, ms or us after 1970 is a time after 2100, so the unit is ns.
        assert_eq!((columns.time.unit.as_str(), columns.time.factor), ("ns", 1e-9));
    }

    #[test]
    fn set_points_are_not_measurements() {
        let columns = find("t,q1,q_ref1,tau_des1,i_des1,i1", &["j"], &ColumnNames::default()).unwrap();
        assert_eq!((columns.effort[0].header.as_str(), columns.effort_is), ("i1", Current));
        assert_eq!(columns.unused, ["q_ref1", "tau_des1", "i_des1"]);
    }

    #[test]
    fn names_given_by_the_user() {
        let position = Some(NamePattern::Pattern("q_motor_deg{}".into()));
        let names = ColumnNames { position, ..ColumnNames::default() };
        let columns = find("t,q_link1,q_motor_deg1,tau1", &["a"], &names).unwrap();
        assert_eq!((columns.position[0].column, columns.position[0].unit.as_str()), (2, "deg"));
    }

    #[test]
    fn a_minus_before_a_name_changes_the_sign() {
        let given = |names: [&str; 2]| Some(NamePattern::Each(names.map(str::to_string).to_vec()));
        let names = ColumnNames { torque: given(["t1", "-t2_mNm"]), ..ColumnNames::default() };
        let columns = find("t,q1,q2,t1,t2_mNm", &["a", "b"], &names).unwrap();
        assert_eq!((columns.effort[0].si(3.0), columns.effort[1].si(3.0)), (3.0, -3e-3));
        assert!(columns.to_string().contains("b <- -t2_mNm [mN m]"), "{columns}");
        let read = ColumnNames { torque: Some(NamePattern::Each(columns.read().effort)), ..ColumnNames::default() };
        let again = find("t,q1,q2,t1,t2_mNm", &["a", "b"], &read).unwrap();
        assert_eq!(again.effort, columns.effort);
        let names = ColumnNames { torque: given(["t1", "-t2"]), ..ColumnNames::default() };
        assert_eq!(find("t,q1,q2,t1,-t2", &["a", "b"], &names).unwrap().effort[1].si(3.0), 3.0);
        let message = find("t,q1,q2,t1,t2", &["a", "b"], &ColumnNames { torque: given(["t1", "-t3"]), ..names });
        assert!(message.unwrap_err().to_string().contains("no column `t3`"));
    }

    #[test]
    fn units_as_they_are_written() {
        let columns = find("time [s],q1,dq1,tau1", &["a"], &ColumnNames::default()).unwrap();
        let lines = ["time: time [s]", "position: a <- q1 [rad]", "velocity: a <- dq1 [rad/s]"];
        let shown = columns.to_string();
        assert!(shown.starts_with(&lines.join("\n")), "{shown}");
        assert!(shown.contains("torque: a <- tau1 [N m]\n"), "{shown}");
        let milli = find("t_ms,q1_deg,i1_mA", &["a"], &ColumnNames::default()).unwrap().to_string();
        assert!(milli.contains("time: t_ms [ms]") && milli.contains("current: a <- i1_mA [mA]"), "{milli}");
    }

    #[test]
    fn sliding_joints_are_in_lengths_and_forces() {
        let of =
            |header: &str| find(header, &["x", "turn"], &ColumnNames::default()).unwrap().with_sliding(&[true, false]);
        let shown = of("t,q1,q2,dq1,dq2,tau1,tau2").unwrap().to_string();
        assert!(shown.contains("x <- q1 [m], turn <- q2 [rad]") && shown.contains("x <- tau1 [N], turn <- tau2 [N m]"));
        assert!(of("t,q1_mm,q2_deg,tau1_N,tau2_Nm").is_ok());
        for header in ["t,q1_deg,q2,tau1,tau2", "t,q1,q2,tau1_Ncm,tau2"] {
            let message = of(header).unwrap_err().to_string();
            assert!(message.contains("joint x slides"), "{message}");
        }
    }

    #[test]
    fn patterns_find_numbers_and_names() {
        let given = |position: &str, header: &str| {
            let names = ColumnNames { position: Some(NamePattern::Pattern(position.into())), ..ColumnNames::default() };
            find(header, &["shoulder", "elbow"], &names)
        };
        for (pattern, header) in [
            ("A{} Ist", "t,A1 Ist_[°],A2 Ist_[°],tau1,tau2"),
            ("present_{}", "t,present_0,present_1,tau1,tau2"),
            ("my_{}", "t,my_shoulder,my_elbow,tau1,tau2"),
            ("my_{joint}_x", "t,my_shoulder_x,my_elbow_x,tau1,tau2"),
        ] {
            let columns = given(pattern, header).unwrap();
            assert_eq!((columns.position[0].column, columns.position[1].column), (1, 2), "{header}");
            assert_eq!(columns.position[0].unit == "°", header.contains('°'), "{header}");
        }
        let message = given("positon_{}", "t,position_1,position_2,tau1,tau2").unwrap_err().to_string();
        assert!(message.contains("no column `positon_1` (did you mean `position_1`?)"), "{message}");
    }

    #[test]
    fn coordinates_without_a_torque() {
        let names = |prescribed: &[&str], free: &[&str]| {
            let of = |names: &[&str]| names.iter().map(|name| name.to_string()).collect();
            ColumnNames { prescribed: of(prescribed), free: of(free), ..ColumnNames::default() }
        };
        for header in ["t,q1,q2,tau2", "t,q1,q2,tau1,tau2"] {
            for (given, said) in [(names(&["a"], &[]), "a: prescribed"), (names(&[], &["a"]), "a: free")] {
                let columns = find(header, &["a", "b"], &given).unwrap();
                assert_eq!((columns.effort[0].si(3.0), columns.effort[1].si(3.0)), (0.0, 3.0), "{header}");
                assert!(columns.to_string().contains(said) && columns.to_string().contains("torque: b <- tau2"));
            }
        }
        let torque = Some(NamePattern::Each(vec!["x".into()]));
        let given = ColumnNames { torque, ..names(&["a"], &[]) };
        assert_eq!(find("t,q1,q2,x", &["a", "b"], &given).unwrap().effort[1].column, 3);
        for (given, wanted) in [
            (names(&["c"], &[]), "`c` is no coordinate"),
            (names(&["a"], &["a"]), "free and prescribed"),
            (names(&["a", "b"], &[]), "nothing is identifiable"),
        ] {
            let message = find("t,q1,q2,tau1,tau2", &["a", "b"], &given).unwrap_err().to_string();
            assert!(message.contains(wanted), "{message}");
        }
        let message = find("t,q1,q2,tau2", &["a", "b"], &ColumnNames::default()).unwrap_err().to_string();
        assert!(message.contains("`columns: {prescribed: [a]}`"), "{message}");
    }

    #[test]
    fn a_unit_by_option_stands_for_that_of_the_header() {
        let units = |position: &str, torque: &str| UnitNames {
            position: Some(position.into()),
            torque: Some(torque.into()),
            ..UnitNames::default()
        };
        let with = |units| find("t,q1,tau1", &["a"], &ColumnNames { units, ..ColumnNames::default() });
        let columns = with(units("ticks(4096)", "int16 counts(0.01)")).unwrap();
        assert_eq!(columns.position[0].si(2048.0), std::f64::consts::PI);
        assert_eq!(columns.effort[0].si(65436.0), -1.0);
        let shown = columns.to_string();
        assert!(shown.contains("a <- q1 [ticks(4096)]") && shown.contains("tau1 [int16 counts(0.01)]"), "{shown}");
        let refused = with(units("degg", "N m")).unwrap_err().to_string();
        assert!(refused.contains("[options.units]: `degg` is no unit of a position"), "{refused}");
        // The scale that the user gives is also used for a sliding joint.
        let slides = |unit: &str| with(units(unit, "counts(2)")).unwrap().with_sliding(&[true]);
        assert!(slides("counts(0.001)").is_ok() && slides("mm").is_ok() && slides("deg").is_err());
    }

    #[test]
    fn a_prefix_that_all_names_share_is_no_obstacle() {
        let joints = ["j1", "j2"];
        for header in [
            "t,position_left_j1,position_left_j2,effort_left_j1,effort_left_j2",
            "t,left/j1/position,left/j2/position,left/j1/effort,left/j2/effort",
            "t,/arm/left_j1/position,/arm/left_j2/position,/arm/left_j1/effort,/arm/left_j2/effort",
        ] {
            let columns = find(header, &joints, &ColumnNames::default()).unwrap();
            assert_eq!((columns.position[1].column, columns.effort[0].column), (2, 3), "{header}");
            assert!(columns.notes[0].contains("in front of the names"), "{:?}", columns.notes);
        }
        let columns = find("t,q_pan,q_lift,tau_pan,tau_lift", &["my_pan", "my_lift"], &ColumnNames::default()).unwrap();
        assert_eq!(columns.notes, ["the joints are named without the `my_` of the description"]);
        let two = "t,q_left_j1,q_left_j2,q_right_j1,q_right_j2,tau_left_j1,tau_left_j2,tau_right_j1,tau_right_j2";
        let message = find(two, &joints, &ColumnNames::default()).unwrap_err().to_string();
        assert!(message.contains("several times") && message.contains("`right_`"), "{message}");
        // A prefix counts only if it matches for every joint. Here only one joint matches.
        let message = find("t,q_left_j1,tau_left_j1", &joints, &ColumnNames::default()).unwrap_err().to_string();
        assert!(message.contains("no columns hold the joint positions"), "{message}");
    }
}
