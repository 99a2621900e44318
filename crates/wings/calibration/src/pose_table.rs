//! Reads a table of postures with measurements: one row per posture, no clock needed.
//!
//! The columns of the joints have the same names as in a log. A measured point has the columns `x`, `y`, `z`, also written
//! `position.x` or `px`. Several points have `x1`, `y1`, `z1`, `x2` .., also written `marker1_x`. An orientation has the
//! columns `qx` .. `qw`, `roll pitch yaw`, `phix phiy phiz` (also roll, pitch and yaw), or `rx ry rz` (a rotation vector).
//! `distance` is a distance from a fixed point. A unit is in brackets after the name: `[mm]`, `[deg]`.
//!
//! If the tool touched something at each posture, the table needs no measurement columns: the touched object is the
//! measurement.

use std::path::Path;

use gate::shown;
use logs::{Columns, Error, NamePattern, Table};
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use robot::Robot;

use crate::corrections::{CalibrationOptions, MeasurementColumns, TableCorrections};
use crate::measurement::{MeasurementKind, Posture};

/// Largest number of postures of a table.
const MAX_POSTURES: usize = 20_000;
/// Largest allowed difference between the norm of a quaternion and 1.
const QUATERNION_NORM_SLACK: f64 = 0.01;
/// Largest number of columns that an error message lists.
const MAX_SHOWN_COLUMNS: usize = 30;

rist::words! {
    /// The object that the tool touched at every posture, for a table without other measurements.
    pub enum Touched {
        /// The same point at every posture.
        Point = "point" "the same point at every posture",
        /// The same plane at every posture.
        Plane = "plane" "the same plane",
        /// The surface of the same sphere at every posture.
        Sphere = "sphere" "the surface of the same sphere",
    }
}

/// The form in which the table gives orientations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Orientation {
    Quaternion,
    RollPitchYaw,
    RotationVector,
}

/// A row of the table, in SI units as the headers say.
#[derive(Clone, Debug)]
struct Row {
    line: usize,
    q: Vec<f64>,
    points: Vec<[f64; 3]>,
    angles: Vec<f64>,
    distance: Option<f64>,
    load: f64,
}

/// A table of postures with measurements, before corrections.
#[derive(Clone, Debug)]
pub struct PoseTable {
    /// Name of the file, as given by the user.
    pub name: String,
    /// Names of the coordinates of the chain.
    pub coordinates: Vec<String>,
    /// Whether each of these coordinates is a length.
    pub slides: Vec<bool>,
    /// The kind of the measurements.
    pub kind: MeasurementKind,
    /// Number of rows that are not used, because a number is missing.
    pub left_out: usize,
    /// Notes on how the table was read.
    pub notes: Vec<String>,
    /// Whether the table has a column with loads.
    pub has_loads: bool,
    orientation: Option<Orientation>,
    rows: Vec<Row>,
}

/// A column of the table, and the factor of its unit.
#[derive(Clone, Copy)]
struct Source(usize, f64);

impl Source {
    fn at(self, table: &Table, row: usize) -> f64 {
        table.columns[self.0].get(row).map_or(f64::NAN, |x| self.1 * x)
    }
}

impl PoseTable {
    /// Reads the postures. `of`: the indices of the coordinates of the robot that the table gives.
    ///
    /// Fails if the file cannot be read, or if a column is missing.
    pub fn read(
        path: &Path,
        robot: &Robot,
        of: &[usize],
        options: &CalibrationOptions,
        touched: Option<Touched>,
    ) -> Result<PoseTable, Error> {
        PoseTable::of_table(&Table::read(path)?, robot, of, options, touched)
    }

    /// Reads the postures from a table; fails like [`PoseTable::read`].
    pub fn of_table(
        table: &Table,
        robot: &Robot,
        of: &[usize],
        options: &CalibrationOptions,
        touched: Option<Touched>,
    ) -> Result<PoseTable, Error> {
        let coordinates: Vec<String> = of.iter().map(|&k| robot.coordinates[k].name.clone()).collect();
        let slides: Vec<bool> = of.iter().map(|&k| slides(robot, k)).collect();
        let mut names = options.joints.clone();
        // A table of postures often has the bare names of the joints as headers.
        if names.position.is_none() && coordinates.iter().all(|c| table.header.contains(c)) {
            names.position = Some(NamePattern::Each(coordinates.clone()));
        }
        let columns = Columns::of_positions(table, &coordinates, &names)?.with_sliding(&slides)?;
        let taken: Vec<usize> = columns.position.iter().map(|source| source.column).collect();
        let headers = Headers::of(table, &taken);
        let found = headers.measurements(&options.columns)?;
        let kind = headers.kind(&found, touched)?;
        let mut read = PoseTable {
            name: table.file.clone(),
            coordinates,
            slides,
            kind,
            left_out: 0,
            notes: columns.notes.clone(),
            has_loads: found.load.is_some(),
            orientation: found.orientation.as_ref().map(|o| o.0),
            rows: Vec::new(),
        };
        let points = read.distinct_points(table, found.points);
        for r in 0..table.rows() {
            let q: Vec<f64> = columns.position.iter().map(|s| s.si(table.columns[s.column][r])).collect();
            let component = |source: &Option<Source>| source.map_or(f64::NAN, |s| s.at(table, r));
            let mut row = Row {
                line: table.line(r),
                q,
                points: points.iter().map(|p| [0, 1, 2].map(|i| component(&p[i]))).collect(),
                angles: found.orientation.iter().flat_map(|o| &o.1).map(|s| s.at(table, r)).collect(),
                distance: found.distance.map(|s| s.at(table, r)),
                load: found.load.map_or(0.0, |s| s.at(table, r)),
            };
            let wanted = points.iter().zip(&row.points).flat_map(|(p, x)| p.iter().zip(x));
            let measured: Vec<f64> = wanted.filter(|(source, _)| source.is_some()).map(|(_, x)| *x).collect();
            let numbers = row.q.iter().chain(&row.angles).chain(&row.distance).chain([&row.load]);
            // A marker that was hidden is left out; a posture without a measurement too.
            let is_seen = measured.is_empty() || measured.iter().any(|x| x.is_finite());
            if !numbers.into_iter().all(|x| x.is_finite()) || !is_seen {
                read.left_out += 1;
                continue;
            }
            if let Some(touched) = touched {
                row.touch(touched);
            }
            read.rows.push(row);
        }
        read.check(table)?;
        Ok(read)
    }

    /// Removes a point if its columns have the same numbers as the columns of another point.
    fn distinct_points(&mut self, table: &Table, points: Vec<[Option<Source>; 3]>) -> Vec<[Option<Source>; 3]> {
        let is_same = |a: &[Option<Source>; 3], b: &[Option<Source>; 3]| {
            a.iter().zip(b).all(|(a, b)| match (a, b) {
                (Some(a), Some(b)) => table.columns[a.0] == table.columns[b.0],
                (a, b) => a.is_none() && b.is_none(),
            })
        };
        let mut kept: Vec<[Option<Source>; 3]> = Vec::new();
        for (k, point) in points.into_iter().enumerate() {
            match kept.iter().position(|other| is_same(other, &point)) {
                Some(of) => self.notes.push(format!(
                    "marker {} repeats the columns of marker {}, and is not used",
                    k + 1,
                    of + 1
                )),
                None => kept.push(point),
            }
        }
        if let MeasurementKind::Points(count) = &mut self.kind {
            *count = kept.len().max(1);
        }
        kept
    }

    fn check(&self, table: &Table) -> Result<(), Error> {
        if self.rows.len() < 4 || self.rows.len() > MAX_POSTURES {
            let message = format!(
                "{} rows have a number for each joint and a measurement: from 4 to {MAX_POSTURES} are expected",
                self.rows.len()
            );
            return Err(Error::at(&table.file, 0, message));
        }
        Ok(())
    }

    /// Number of postures.
    pub fn count(&self) -> usize {
        self.rows.len()
    }

    /// Mass of the load at each posture, kg.
    pub fn loads(&self) -> Vec<f64> {
        self.rows.iter().map(|row| row.load).collect()
    }

    /// Whether the orientations are quaternions; `None` without orientations.
    pub fn has_quaternions(&self) -> Option<bool> {
        self.orientation.map(|o| o == Orientation::Quaternion)
    }

    /// Whether a length is measured.
    pub(crate) fn has_lengths(&self) -> bool {
        let measured = |row: &Row| {
            row.distance.is_some_and(|d| d != 0.0) || row.points.iter().flatten().any(|x| *x != 0.0 && x.is_finite())
        };
        self.rows.iter().any(measured)
    }

    /// The postures with the corrections applied.
    ///
    /// Fails if a correction names an unknown joint, or if a quaternion does not have the norm 1.
    pub fn postures(&self, by: &TableCorrections) -> Result<Vec<Posture>, Error> {
        let place = |name: &String| {
            self.coordinates.iter().position(|c| c == name).ok_or_else(|| {
                let known = self.coordinates.join(", ");
                Error::new(format!(
                    "[options.corrections]: `{}` is no joint of the chain; they are {known}",
                    shown::line(name)
                ))
            })
        };
        let reversed: Vec<usize> = by.reversed.iter().map(place).collect::<Result<_, _>>()?;
        let swapped: Vec<(usize, usize)> =
            by.swapped.iter().map(|[a, b]| Ok((place(a)?, place(b)?))).collect::<Result<_, Error>>()?;
        let millis = if by.millimetres { 1e-3 } else { 1.0 };
        // The order is units, exchanged columns, signs. So a reversed sign belongs to a joint and not to a column.
        let posture = |row: &Row| {
            let mut q = row.q.clone();
            if by.joint_degrees {
                q.iter_mut().zip(&self.slides).filter(|(_, slides)| !**slides).for_each(|(q, _)| *q = q.to_radians());
            }
            swapped.iter().for_each(|(a, b)| q.swap(*a, *b));
            reversed.iter().for_each(|k| q[*k] = -q[*k]);
            let mut points: Vec<[f64; 3]> = row.points.iter().map(|p| p.map(|x| millis * x)).collect();
            let mut rotation = match self.orientation {
                Some(orientation) => Some(self.rotation(row, orientation, by)?),
                None => None,
            };
            // The inverse of a pose (R, p) is (R', -R' p).
            if let (true, Some(r), [point]) = (by.inverted_poses, &mut rotation, points.as_mut_slice()) {
                *r = r.transpose();
                *point = (-(*r * Vector3::from(*point))).into();
            }
            // Only a fit of stiffness needs the holding torques, and it sets them later.
            let torque = vec![0.0; q.len()];
            Ok(Posture { line: row.line, q, torque, points, rotation, distance: row.distance.map(|d| millis * d) })
        };
        self.rows.iter().map(posture).collect()
    }

    fn rotation(&self, row: &Row, given: Orientation, by: &TableCorrections) -> Result<Matrix3<f64>, Error> {
        let unit = if by.degrees { std::f64::consts::PI / 180.0 } else { 1.0 };
        let a = &row.angles;
        let is_vector = (given == Orientation::RotationVector) != by.other_angles;
        Ok(match given {
            Orientation::Quaternion => {
                let [x, y, z, w] = if by.scalar_first { [a[1], a[2], a[3], a[0]] } else { [a[0], a[1], a[2], a[3]] };
                let q = Quaternion::new(w, x, y, z);
                if (q.norm() - 1.0).abs() > QUATERNION_NORM_SLACK {
                    let message = format!("the orientation has the norm {:.3}: a quaternion has 1", q.norm());
                    return Err(Error::at(&self.name, row.line, message));
                }
                UnitQuaternion::from_quaternion(q).to_rotation_matrix().into_inner()
            }
            _ if is_vector => Rotation3::new(unit * Vector3::new(a[0], a[1], a[2])).into_inner(),
            _ => Rotation3::from_euler_angles(unit * a[0], unit * a[1], unit * a[2]).into_inner(),
        })
    }
}

impl Row {
    /// Sets the measurement of a touched point, plane or sphere.
    fn touch(&mut self, touched: Touched) {
        match touched {
            Touched::Point => self.points = vec![[0.0; 3]],
            Touched::Plane => self.points = vec![[f64::NAN, f64::NAN, 0.0]],
            Touched::Sphere => (self.points, self.distance) = (vec![[f64::NAN; 3]], Some(0.0)),
        }
    }
}

/// Whether a coordinate is a length.
pub(crate) fn slides(robot: &Robot, coordinate: usize) -> bool {
    let joint = robot.joint_of(robot::CoordinateId(coordinate));
    joint.is_some_and(|j| robot.link(j).joint.kind == robot::JointKind::Prismatic)
}

/// The measured columns of a table.
struct Found {
    points: Vec<[Option<Source>; 3]>,
    orientation: Option<(Orientation, Vec<Source>)>,
    distance: Option<Source>,
    load: Option<Source>,
}

/// For each column of a table: its name in lower case with `_` between words, and the factor of its unit. Columns of joints have
/// no name.
struct Headers<'a> {
    table: &'a Table,
    names: Vec<(String, f64)>,
}

impl<'a> Headers<'a> {
    fn of(table: &'a Table, taken: &[usize]) -> Headers<'a> {
        let name = |(k, header): (usize, &String)| {
            let (name, unit) = header.split_once(['[', '(']).unwrap_or((header, ""));
            let factor = match unit.trim_end_matches([']', ')']).trim() {
                "mm" => 1e-3,
                "cm" => 1e-2,
                "deg" | "°" => std::f64::consts::PI / 180.0,
                _ => 1.0,
            };
            let words = name.trim().to_lowercase().replace(|c: char| !c.is_ascii_alphanumeric(), "_");
            (if taken.contains(&k) { String::new() } else { words.trim_matches('_').to_string() }, factor)
        };
        Headers { table, names: table.header.iter().enumerate().map(name).collect() }
    }

    /// The column with this name, otherwise the only column whose name ends with these words.
    fn ending(&self, words: &str) -> Option<Source> {
        let whole = self.names.iter().position(|n| n.0 == words);
        let mut ends = self.names.iter().enumerate().filter(|(_, n)| n.0.ends_with(&format!("_{words}")));
        let index = whole.or_else(|| ends.next().map(|(k, _)| k).filter(|_| ends.next().is_none()))?;
        Some(Source(index, self.names[index].1))
    }

    fn any(&self, words: &[&str]) -> Option<Source> {
        words.iter().find_map(|w| self.ending(w))
    }

    fn given(&self, name: &String) -> Result<Source, Error> {
        let index = self.table.header.iter().position(|header| header == name);
        index.map(|k| Source(k, self.names[k].1)).ok_or_else(|| self.missing(&format!("named `{}`", shown::line(name))))
    }

    /// The columns x, y and z of a point by a pattern in which `?` is the axis; `None` if there is none of them.
    fn point(&self, patterns: &[String]) -> Option<[Option<Source>; 3]> {
        let by = |pattern: &String| {
            let axes = ["x", "y", "z"].map(|axis| self.ending(&pattern.replace('?', axis)));
            axes.iter().any(Option::is_some).then_some(axes)
        };
        patterns.iter().find_map(by)
    }

    fn points(&self, given: &MeasurementColumns) -> Result<Vec<[Option<Source>; 3]>, Error> {
        if let Some(points) = &given.points {
            let axis = |name: &String| (!name.is_empty()).then(|| self.given(name)).transpose();
            return points.iter().map(|[x, y, z]| Ok([axis(x)?, axis(y)?, axis(z)?])).collect();
        }
        let numbered = |k: usize| {
            let words = ["?#", "p?#", "p#_?", "marker#_?", "marker_#_?", "point#_?", "point_#_?"];
            self.point(&words.map(|w| w.replace('#', &k.to_string())))
        };
        let several: Vec<_> = (1..).map_while(numbered).collect();
        let one = ["position_?", "translation_?", "p?", "p_?", "?"].map(String::from);
        Ok(if several.is_empty() { self.point(&one).into_iter().collect() } else { several })
    }

    fn orientation(&self, given: &MeasurementColumns) -> Result<Option<(Orientation, Vec<Source>)>, Error> {
        // Columns that the user names have priority over columns with known names.
        if let Some(headers) = &given.orientation {
            let found: Vec<Source> = headers.iter().map(|name| self.given(name)).collect::<Result<_, _>>()?;
            return match found.len() {
                3 => Ok(Some((Orientation::RollPitchYaw, found))),
                4 => Ok(Some((Orientation::Quaternion, found))),
                _ => Err(self.missing("that are 4 of a quaternion or 3 angles in [options.columns.orientation]")),
            };
        }
        let all = |words: &[&str], number: &str| -> Option<Vec<Source>> {
            words.iter().map(|w| self.ending(&format!("{w}{number}"))).collect()
        };
        let four = |prefix: &str| ["x", "y", "z", "w"].map(|axis| format!("{prefix}{axis}"));
        // The first complete set of columns counts: quaternions, then roll, pitch and yaw, then rotation vectors. Sets with the
        // number 1 are searched last.
        for number in ["", "1"] {
            for prefix in ["orientation_", "rotation_", "quaternion_", "q", "q_"] {
                let words = four(prefix);
                if let Some(found) = all(&words.each_ref().map(String::as_str), number) {
                    return Ok(Some((Orientation::Quaternion, found)));
                }
            }
            let three = [
                (Orientation::RollPitchYaw, ["roll", "pitch", "yaw"]),
                (Orientation::RollPitchYaw, ["phix", "phiy", "phiz"]),
                (Orientation::RotationVector, ["rotvec_x", "rotvec_y", "rotvec_z"]),
                (Orientation::RotationVector, ["rx", "ry", "rz"]),
            ];
            if let Some(found) = three.iter().find_map(|(kind, words)| Some((*kind, all(words, number)?))) {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    fn measurements(&self, given: &MeasurementColumns) -> Result<Found, Error> {
        let distance = given.distance.as_ref().map(|name| self.given(name)).transpose()?;
        let load = given.load.as_ref().map(|name| self.given(name)).transpose()?;
        Ok(Found {
            points: self.points(given)?,
            orientation: self.orientation(given)?,
            distance: distance.or_else(|| self.any(&["distance", "length", "ball_bar"])),
            load: load.or_else(|| self.any(&["load", "payload", "load_mass"])),
        })
    }

    fn kind(&self, found: &Found, touched: Option<Touched>) -> Result<MeasurementKind, Error> {
        let is_measured = !found.points.is_empty() || found.orientation.is_some() || found.distance.is_some();
        match touched {
            Some(_) if is_measured => {
                Err(Error::at(&self.table.file, 1, "[touched] is for tables without measurements, and this one has some: leave one of them out"))
            }
            Some(Touched::Point | Touched::Plane) => Ok(MeasurementKind::Points(1)),
            Some(Touched::Sphere) => Ok(MeasurementKind::Sphere),
            None if found.orientation.is_some() && found.points.len() <= 1 => Ok(MeasurementKind::Pose),
            None if found.distance.is_some() && found.points.is_empty() => Ok(MeasurementKind::Distance),
            None if !found.points.is_empty() && found.orientation.is_none() => Ok(MeasurementKind::Points(found.points.len())),
            None if is_measured => Err(self.missing("of one kind: an orientation stands beside several points; name those that are meant in [options.columns]")),
            None => Err(self.missing(
                "of a measurement (x, y, z, x1, y1, z1, qx .. qw, roll, pitch, yaw, distance); if the tool touched the same \
                 point, plane or sphere at each posture, say so by [touched]",
            )),
        }
    }

    fn missing(&self, what: &str) -> Error {
        let there: Vec<&str> = self.table.header.iter().take(MAX_SHOWN_COLUMNS).map(String::as_str).collect();
        let message = format!("no columns {what}; the columns are {}", there.join(", "));
        Error::at(&self.table.file, 1, message)
    }
}
