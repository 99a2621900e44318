//! A log of a force-torque sensor: forces, torques and the pose of the sensor over time.
//!
//! Columns are found by the last words of their names: `force.x`, `wrench.force.x`, `fx`; `torque.x`, `tx`, `mx`; `position.x`,
//! `px`, `x`; `orientation.x` .. `orientation.w` or `qx` .. `qw`, or `roll` `pitch` `yaw`. Lengths may be in `[mm]` and angles in
//! `[deg]`. RTDE's `actual_TCP_force_0` .. `_5` and `actual_TCP_pose_0` .. `_5` are also known. The options can give other names.
//! In a table without a time column, each row is a posture at rest.

use std::path::Path;

use crate::wrench_options::{Corrections, WrenchOptions, matrix, roll_pitch_yaw};
use logs::Error;
use logs::Table;

/// A log of a force-torque sensor; each list has one entry per row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wrenches {
    /// Name of the file, as given by the user.
    pub name: String,
    /// Time, s, strictly increasing. Empty if each row is a posture at rest.
    pub t: Vec<f64>,
    /// Force in the axes of the sensor, N.
    pub force: Vec<[f64; 3]>,
    /// Torque about the origin of the sensor frame, in the axes of the sensor, N m.
    pub torque: Vec<[f64; 3]>,
    /// Origin of the sensor in a frame at rest whose z axis points up, m. Zeros if each row is a posture.
    pub position: Vec<[f64; 3]>,
    /// Rotation matrix of the sensor's axes in the frame at rest, row by row.
    pub rotation: Vec<[[f64; 3]; 3]>,
    /// Rotation matrices for the case that angles without a unit are in degrees. Empty if the log contains quaternions.
    pub in_degrees: Vec<[[f64; 3]; 3]>,
    /// Number of rows that are not used, because a number is missing or time does not increase.
    pub left_out: usize,
}

/// Largest deviation of the norm of a quaternion from 1.
const QUATERNION_NORM_SLACK: f64 = 0.01;
/// Largest number of columns that an error message lists.
const MAX_SHOWN_COLUMNS: usize = 30;

impl Wrenches {
    /// Reads a log and applies the corrections of the options. Fails if the file cannot be read, if a column is missing, or if a
    /// quaternion does not have the norm 1.
    pub fn read(path: &Path, options: &WrenchOptions) -> Result<Wrenches, Error> {
        Wrenches::of_table(&Table::read(path)?, options)
    }

    /// Reads a log from a table, and applies the corrections of the options. Fails like [`Wrenches::read`].
    pub fn of_table(table: &Table, options: &WrenchOptions) -> Result<Wrenches, Error> {
        // A column has the header that the options give; otherwise the column is found by its name. A log of postures needs no
        // positions.
        let (names, given) = (HeaderNames::of(table), &options.columns);
        let clock = match &given.time {
            Some(name) => names.given(std::slice::from_ref(name))?.pop(),
            None => names.any(&["t", "time", "timestamp", "stamp"]),
        };
        let force = names.three("force", &["force_?", "f?", "f_?", "actual_tcp_force_#0"], given.force.as_ref())?;
        let of_torque = ["torque_?", "t?", "t_?", "m?", "m_?", "moment_?", "actual_tcp_force_#3"];
        let torque = names.three("torque", &of_torque, given.torque.as_ref())?;
        let of_position = ["position_?", "translation_?", "p?", "p_?", "?", "actual_tcp_pose_#0"];
        let position = match names.three("position", &of_position, given.position.as_ref()) {
            Err(_) if clock.is_none() && given.position.is_none() => None,
            found => Some(found?),
        };
        let (turned, is_vector) = names.orientation(options)?;
        let mut log = Wrenches { name: table.file.clone(), ..Wrenches::default() };
        for r in 0..table.rows() {
            let three = |columns: &[WrenchTableColumn]| [0, 1, 2].map(|i| columns[i].at(table, r));
            let (f, n) = (three(&force), three(&torque));
            let p = position.as_ref().map_or([0.0; 3], |columns| three(columns));
            let angles: Vec<f64> = turned.iter().map(|c| c.at(table, r)).collect();
            let t = clock.as_ref().map_or(r as f64, |c| c.at(table, r));
            let numbers = f.iter().chain(&n).chain(&p).chain(&angles).chain([&t]);
            // A row with a missing number, or whose time does not increase, is counted and not used.
            if !numbers.into_iter().all(|x| x.is_finite())
                || (clock.is_some() && log.t.last().is_some_and(|last| t <= *last))
            {
                log.left_out += 1;
                continue;
            }
            let rotation = rotation(&angles, is_vector).map_err(|what| Error::at(&table.file, table.line(r), what))?;
            log.force.push(f);
            log.torque.push(n);
            log.position.push(p);
            log.rotation.push(rotation);
            // Three angles without a unit may be in rad or in degrees, so both rotations are stored.
            if angles.len() == 3 {
                let angles: Vec<f64> = angles.iter().map(|angle| angle.to_radians()).collect();
                log.in_degrees
                    .push(self::rotation(&angles, is_vector).map_err(|what| Error::at(&table.file, 0, what))?);
            }
            if clock.is_some() {
                log.t.push(t);
            }
        }
        if log.force.len() < 3 {
            let message = format!("{} rows have a number for each signal: three are the least", log.force.len());
            return Err(Error::at(&table.file, 0, message));
        }
        if options.corrections.degrees && log.in_degrees.is_empty() {
            let message = "[options.corrections.degrees]: its orientations are quaternions, and have no unit";
            return Err(Error::at(&table.file, 0, message));
        }
        Ok(log.corrected(&options.corrections))
    }
}

impl Wrenches {
    /// The log with these corrections applied to its numbers.
    pub fn corrected(mut self, by: &Corrections) -> Wrenches {
        if by.degrees {
            self.rotation.clone_from(&self.in_degrees);
        }
        let poses = self.rotation.iter_mut().zip(&mut self.position);
        for ((turn, place), (force, torque)) in poses.zip(self.force.iter_mut().zip(&mut self.torque)) {
            by.correct(turn, place, [force, torque]);
        }
        self
    }
}

/// A column of the table, and the factor that converts its unit to the SI unit.
#[derive(Clone, Copy)]
struct WrenchTableColumn {
    index: usize,
    factor: f64,
}

impl WrenchTableColumn {
    fn at(self, table: &Table, row: usize) -> f64 {
        table.columns[self.index].get(row).map_or(f64::NAN, |x| self.factor * x)
    }
}

/// For each column of a table: its name in lower case with `_` between words, and the factor of its unit.
struct HeaderNames<'a> {
    table: &'a Table,
    names: Vec<(String, f64)>,
}

impl<'a> HeaderNames<'a> {
    fn of(table: &'a Table) -> HeaderNames<'a> {
        let name = |header: &String| {
            let (name, unit) = header.split_once(['[', '(']).unwrap_or((header, ""));
            let factor = match unit.trim_end_matches([']', ')']).trim() {
                "mm" | "ms" | "N mm" | "Nmm" => 1e-3,
                "deg" | "°" => std::f64::consts::PI / 180.0,
                _ => 1.0,
            };
            let words = name.trim().to_lowercase().replace(|c: char| !c.is_ascii_alphanumeric(), "_");
            (words.trim_matches('_').to_string(), factor)
        };
        HeaderNames { table, names: table.header.iter().map(name).collect() }
    }

    /// The column with this name, otherwise the only column whose name ends with these words. `None` if there is none or several.
    fn ending(&self, words: &str) -> Option<WrenchTableColumn> {
        let whole = self.names.iter().position(|n| n.0 == words);
        let mut ends = self.names.iter().enumerate().filter(|(_, n)| n.0.ends_with(&format!("_{words}")));
        let index = whole.or_else(|| ends.next().map(|(k, _)| k).filter(|_| ends.next().is_none()))?;
        Some(WrenchTableColumn { index, factor: self.names[index].1 })
    }

    fn any(&self, words: &[&str]) -> Option<WrenchTableColumn> {
        words.iter().find_map(|w| self.ending(w))
    }

    /// The columns with these headers. Fails if a header is missing.
    fn given(&self, headers: &[String]) -> Result<Vec<WrenchTableColumn>, Error> {
        let column = |name: &String| {
            let index = self.table.header.iter().position(|header| header == name);
            let column = index.map(|index| WrenchTableColumn { index, factor: self.names[index].1 });
            column.ok_or_else(|| self.missing(&format!("`{}`", gate::shown::line(name))))
        };
        headers.iter().map(column).collect()
    }

    /// The columns x, y and z, with the given headers or by one of the patterns. `?`: the axis; `#3`: numbers starting at 3.
    fn three(
        &self,
        what: &str,
        patterns: &[&str],
        given: Option<&[String; 3]>,
    ) -> Result<[WrenchTableColumn; 3], Error> {
        if let Some(headers) = given {
            let found = self.given(headers)?;
            return Ok([found[0], found[1], found[2]]);
        }
        let by = |pattern: &&str| {
            let name = |k: usize| match pattern.split_once('#') {
                Some((before, first)) => format!("{before}{}", first.parse::<usize>().unwrap_or(0) + k),
                None => pattern.replace('?', ["x", "y", "z"][k]),
            };
            let [x, y, z] = [0, 1, 2].map(|k| self.ending(&name(k)));
            Some([x?, y?, z?])
        };
        patterns.iter().find_map(by).ok_or_else(|| {
            let wanted = ["x", "y", "z"].map(|axis| patterns[0].replace('?', axis).replace('_', "."));
            self.missing(&format!("of the {what} ({})", wanted.join(", ")))
        })
    }

    /// The columns of the orientation (qx qy qz qw, or roll pitch yaw, or a rotation vector); and whether they contain a rotation
    /// vector.
    fn orientation(&self, options: &WrenchOptions) -> Result<(Vec<WrenchTableColumn>, bool), Error> {
        let (given, vector) = (&options.columns.orientation, options.columns.rotation_vector.as_ref());
        if let Some(headers) = given {
            let found = self.given(headers)?;
            let is_either = [3, 4].contains(&found.len());
            return is_either.then_some((found, false)).ok_or_else(|| {
                self.missing("that are 4 of a quaternion or roll, pitch, yaw in [options.columns.orientation]")
            });
        }
        if let Ok(found) = self.three("orientation", &["actual_tcp_pose_#3", "rotvec_?"], vector) {
            return Ok((found.to_vec(), true));
        }
        let four = |prefix: &str| ["x", "y", "z", "w"].iter().map(|a| self.ending(&format!("{prefix}{a}"))).collect();
        let quaternion: Option<Vec<WrenchTableColumn>> =
            ["orientation_", "rotation_", "q", "q_"].iter().find_map(|p| four(p));
        let rpy =
            || ["roll", "pitch", "yaw"].iter().map(|a| self.ending(a)).collect::<Option<Vec<WrenchTableColumn>>>();
        let found = quaternion.or_else(rpy);
        let found = found.ok_or_else(|| self.missing("of the orientation (qx, qy, qz, qw, or roll, pitch, yaw)"));
        Ok((found?, false))
    }

    fn missing(&self, what: &str) -> Error {
        let there: Vec<&str> = self.table.header.iter().take(MAX_SHOWN_COLUMNS).map(String::as_str).collect();
        let message = format!(
            "no columns {what}; the columns are {}: rename those that are meant, or give their names by [options]",
            there.join(", ")
        );
        Error::at(&self.table.file, 1, message)
    }
}

/// The rotation matrix of a quaternion x, y, z, w; of roll, pitch and yaw, rad; or of a rotation vector, rad.
fn rotation(angles: &[f64], is_vector: bool) -> Result<[[f64; 3]; 3], String> {
    let &[x, y, z, w] = angles else {
        let angles = [0, 1, 2].map(|i| angles.get(i).copied().unwrap_or(0.0));
        if !is_vector {
            return Ok(roll_pitch_yaw(angles));
        }
        let half = angles.iter().map(|x| x * x).sum::<f64>().sqrt() / 2.0;
        let share = if half > 0.0 { half.sin() / (2.0 * half) } else { 0.5 };
        let [x, y, z] = angles.map(|x| share * x);
        return Ok(matrix([x, y, z, half.cos()]));
    };
    let norm = (x * x + y * y + z * z + w * w).sqrt();
    if (norm - 1.0).abs() > QUATERNION_NORM_SLACK {
        return Err(format!("the orientation ({x}, {y}, {z}, {w}) has the norm {norm:.3}: a quaternion x y z w has 1"));
    }
    Ok(matrix([x, y, z, w].map(|c| c / norm)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(head: &str, rows: &str) -> Result<Wrenches, Error> {
        let table = Table::from_bytes("w.csv", format!("{head}\n{rows}").as_bytes())?;
        Wrenches::of_table(&table, &WrenchOptions::default())
    }

    /// A quarter turn about z, once given as a quaternion and once as yaw in degrees.
    #[test]
    fn columns_are_found_by_their_last_words() {
        let half = 0.5f64.sqrt();
        let row = |t: f64| format!("{t},1,2,3,4,5,6,0.1,0.2,0.3,0,0,{half},{half}\n");
        let rows = row(0.0) + &row(0.1) + &row(0.2);
        let ros = "t,wrench.force.x,wrench.force.y,wrench.force.z,wrench.torque.x,wrench.torque.y,wrench.torque.z,\
                   pose.position.x,pose.position.y,pose.position.z,pose.orientation.x,pose.orientation.y,\
                   pose.orientation.z,pose.orientation.w";
        let short = "time,Fx,Fy,Fz,Mx,My,Mz,x,y,z,qx,qy,qz,qw";
        let log = read(ros, &rows).unwrap();
        assert_eq!(log, read(short, &rows).unwrap());
        assert_eq!((log.force[0], log.torque[0], log.position[0]), ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [0.1, 0.2, 0.3]));
        let turned = "t,Fx,Fy,Fz,Mx,My,Mz,x [mm],y [mm],z [mm],roll [deg],pitch [deg],yaw [deg]";
        let row = |t: f64| format!("{t},1,2,3,4,5,6,100,200,300,0,0,90\n");
        let same = read(turned, &(row(0.0) + &row(0.1) + &row(0.2))).unwrap();
        for (a, b) in log.rotation[2].iter().flatten().zip(same.rotation[2].iter().flatten()) {
            assert!((a - b).abs() < 1e-15, "{log:?} {same:?}");
        }
        assert!((same.position[1][2] - 0.3).abs() < 1e-15);
    }

    #[test]
    fn what_is_missing_is_named() {
        let rows = "0,1,2,3,4,5,6,0,0,0,2\n".repeat(4);
        for (head, wanted) in [
            ("t,fx,fy,fz,tx,ty,tz,a,b,c,d", "w.csv:1: no columns of the position (position.x, position.y, position.z)"),
            (
                "n,fx,fy,fz,tx,ty,tz,a,b,c,d",
                "w.csv:1: no columns of the orientation (qx, qy, qz, qw, or roll, pitch, yaw)",
            ),
            (
                "n,fx,fy,fz,a,b,c,qx,qy,qz,qw",
                "no columns of the torque (torque.x, torque.y, torque.z); the columns are n, fx",
            ),
            ("n,fx,fy,fz,tx,ty,tz,qx,qy,qz,qw", "w.csv:2: the orientation (0, 0, 0, 2) has the norm 2.000"),
        ] {
            let message = read(head, &rows).unwrap_err().to_string();
            assert!(message.contains(wanted), "{message}");
        }
    }
}
