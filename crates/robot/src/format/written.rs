//! Functions that all writers of descriptions use: names that a format allows, and notes on data that no format can store.

use crate::format::expression::is_name;
use crate::inertial::Pose;
use crate::robot::{Link, Robot};
use crate::value::{Affine, CoordinateId, Symbol, Value};

/// The unique names of symbols and coordinates in a written file.
pub struct WrittenNames {
    /// Names of the symbols, in the order of the robot.
    pub symbols: Vec<String>,
    /// Names of the coordinates, in the order of the robot.
    pub coordinates: Vec<String>,
    renamed: Vec<Symbol>,
}

impl WrittenNames {
    /// Makes the names for a format. `allowed`: replaces the characters of a name that the format does not allow. `is_reserved`:
    /// whether a name already has a meaning in the format.
    pub fn new(robot: &Robot, allowed: impl Fn(&str) -> String, is_reserved: impl Fn(&str) -> bool) -> WrittenNames {
        let mut taken: Vec<String> = Vec::new();
        let mut unique = |name: &str| {
            let mut name = allowed(name);
            if !is_name(&name) {
                name.insert(0, 'q');
            }
            // An underscore at the end turns a reserved word into a word that is not reserved.
            while taken.contains(&name) || is_reserved(&name) {
                name.push('_');
            }
            taken.push(name.clone());
            name
        };
        let symbols: Vec<String> = robot.symbols.iter().map(|s| unique(&s.name)).collect();
        let coordinates = (0..robot.n_variables()).map(|k| unique(robot.coordinate_name(CoordinateId(k)))).collect();
        let rename = |(s, name): (&Symbol, &String)| Symbol { name: name.clone(), ..s.clone() };
        let renamed = robot.symbols.iter().zip(&symbols).map(rename).collect();
        WrittenNames { symbols, coordinates, renamed }
    }

    /// The text of a value, with the names of this file.
    pub fn value(&self, value: &Value) -> String {
        value.text(&self.renamed, &|k| self.coordinates[k.0].clone())
    }

    /// The text of a joint variable plus its constant part, with the names of this file.
    pub fn variable(&self, variable: &Affine, constant: &Value) -> String {
        variable.text(constant, &self.renamed, &|k| self.coordinates[k.0].clone())
    }
}

/// Adds notes on data of the link's original file that no writer stores: the separate bodies lumped into the link, and the
/// frame of the link.
pub fn tell_of_file(link: &Link, mut note: impl FnMut(&str, String)) {
    if link.parts.len() > 1 {
        note(&link.name, format!("its {} parts are written as one link", link.parts.len()));
    }
    if link.file_frame != Pose::IDENTITY {
        note(&link.name, "the frame its own file gave it is not carried: parameters are in Khalil's frame".into());
    }
}
