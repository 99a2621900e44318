//! Options for reading a robot description.
//!
//! An artefact (a plan, a motion or an estimate, saved as a file) stores the options with which its description was read.

use std::collections::{BTreeMap, BTreeSet};

use linear_model::description_options::{DescriptionOptions, RotorInertias};
use robot::format::{AngleSnapping, Mimic};
use serde_json::Value;

use super::{Request, number, of_values};
use crate::error::Error;

request! {
    /// Options for reading a description. With the defaults, the description is read unchanged.
    pub struct ModelOptions {
        /// Value of a symbol of the description, m or rad: D3=0.45. A .par file may have symbols without a value.
        value: Vec<(String, f64)> = Vec::new(), value_name("NAME=VALUE");
        /// Value of an argument of a xacro, which the file uses as `$(arg NAME)` [default: as in the file].
        arg: Vec<(String, String)> = Vec::new(), value_name("NAME=VALUE");
        /// Folder of a package, for includes of a xacro (`$(find NAME)`) or meshes and parts of an MJCF. Without this option, a
        /// xacro finds packages with a package.xml in the folders above the file.
        package: Vec<(String, String)> = Vec::new(), value_name("NAME=FOLDER");
        /// The robot to read, if a file has several: a body of the world of an MJCF, or a model of an SDF [default: all that is
        /// in the file].
        root: Option<String> = None, value_name("NAME");
        /// How mimic joints of a URDF are read. constraint: they follow the joint that they mimic; independent: they are
        /// coordinates of their own.
        mimic: Mimic = Mimic::Constraint;
        /// How rounded angles are read. meant: as the exact angles (1.5707 and 1.5708 as pi/2); as-given: as the numbers in the
        /// file.
        angles: AngleSnapping = AngleSnapping::Meant;
        /// Joints that have a rotor inertia (IA) among their parameters [default: as in the file; if the file says nothing:
        /// actuated for YAML, none for URDF].
        rotor_inertia: Option<RotorInertias> = None, value_name("JOINTS");
        /// Joints locked at a position, rad or m, such as a gripper that is not in the log: finger=0.02. Without this option,
        /// no joint is locked.
        lock: Vec<(String, f64)> = Vec::new(), value_name("JOINT=POSITION");
        /// Mount of the base, rad: roll, pitch and yaw of the base frame, in a frame in which gravity is as in the file.
        /// 3.1416,0,0 is a robot on a ceiling [default: as in the file].
        base: Option<[f64; 3]> = None, value_name("ROLL,PITCH,YAW");
        /// Let the base float: six coordinates come first (base_x, base_y, base_z, base_yaw, base_pitch, base_roll), and
        /// the base becomes a link with its own parameters.
        floating_base: bool = false;
        /// Derive the model even if this takes more than about 10 s or 1 GiB. Otherwise such a model is refused, with an
        /// estimate of time and memory.
        any_size: bool = false;
    }
}

impl ModelOptions {
    /// The options with which the description of an artefact (a plan, a motion or an estimate) was read, as stored in the
    /// artefact.
    pub fn of_description(description: &DescriptionOptions) -> ModelOptions {
        ModelOptions {
            value: description.values.iter().map(|(name, value)| (name.clone(), *value)).collect(),
            arg: description.arguments.iter().map(|(name, text)| (name.clone(), text.clone())).collect(),
            package: description.packages.iter().map(|(name, folder)| (name.clone(), folder.clone())).collect(),
            root: description.root.clone(),
            mimic: if description.independent_mimic { Mimic::Independent } else { Mimic::Constraint },
            angles: if description.angles_as_given { AngleSnapping::AsGiven } else { AngleSnapping::Meant },
            rotor_inertia: description.rotor_inertia,
            lock: description.locked.iter().map(|(name, position)| (name.clone(), *position)).collect(),
            base: description.base,
            floating_base: description.floating_base,
            any_size: false,
        }
    }

    /// The options stored in an artefact (a plan, a motion or an estimate), except where `self` differs from the default: there
    /// `self` counts. Some options have one value per name, for example `lock`, with one position per joint. Of these options,
    /// only the values of the names in `self` are replaced.
    pub fn over(&self, description: &DescriptionOptions) -> Result<ModelOptions, Error> {
        let mut all: BTreeMap<&str, Value> = ModelOptions::of_description(description).given().into_iter().collect();
        for (key, value) in self.given() {
            match (all.get_mut(key), value) {
                (Some(Value::Object(theirs)), Value::Object(ours)) => theirs.extend(ours),
                (_, value) => drop(all.insert(key, value)),
            }
        }
        of_values(all.iter().map(|(key, value)| (*key, value)))
    }

    /// Phrases on options that differ between two descriptions, for example `[base] is 1.57,0,0 there and not given here`.
    /// `here`, `there`: options of the two descriptions; `None` means that all options have their defaults.
    pub fn differences(here: Option<&DescriptionOptions>, there: Option<&DescriptionOptions>) -> Vec<String> {
        let [here, there] = [here, there].map(|of| -> BTreeMap<&str, Value> {
            of.map(|of| ModelOptions::of_description(of).given().into_iter().collect()).unwrap_or_default()
        });
        let shown = |value: Option<&Value>| match value {
            None => "not given".into(),
            Some(Value::Array(list)) => list.iter().filter_map(Value::as_f64).map(number).collect::<Vec<_>>().join(","),
            Some(Value::String(word)) => word.clone(),
            Some(value) => value.to_string(),
        };
        let keys: BTreeSet<&str> = here.keys().chain(there.keys()).copied().collect();
        let odd = keys.into_iter().filter(|key| here.get(key) != there.get(key));
        odd.map(|key| format!("[{key}] is {} there and {} here", shown(there.get(key)), shown(here.get(key)))).collect()
    }

    /// The options in the form that an artefact (a plan, a motion or an estimate) stores; `None` if all have their defaults.
    pub fn description(&self) -> Option<DescriptionOptions> {
        let description = DescriptionOptions {
            values: self.value.iter().cloned().collect(),
            arguments: self.arg.iter().cloned().collect(),
            packages: self.package.iter().cloned().collect(),
            root: self.root.clone(),
            independent_mimic: self.mimic == Mimic::Independent,
            angles_as_given: self.angles == AngleSnapping::AsGiven,
            rotor_inertia: self.rotor_inertia,
            locked: self.lock.iter().cloned().collect(),
            base: self.base,
            floating_base: self.floating_base,
        };
        (description != DescriptionOptions::default()).then_some(description)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_go_over_those_of_an_artefact_key_by_key() {
        let artefact = ModelOptions {
            value: vec![("D3".into(), 0.4), ("D4".into(), 0.5)],
            rotor_inertia: Some(RotorInertias::Actuated),
            base: Some([1.5, 0.0, 0.0]),
            ..ModelOptions::default()
        };
        let made_with = artefact.description().unwrap();
        let over = |given: ModelOptions| given.over(&made_with).unwrap();
        assert_eq!(over(ModelOptions::default()).description(), artefact.description());
        let same = over(ModelOptions { base: artefact.base, any_size: true, ..Default::default() });
        assert_eq!(same.description(), Some(made_with.clone()));
        let other = over(ModelOptions { value: vec![("D3".into(), 0.3)], ..Default::default() });
        assert_eq!(other.value, [("D3".to_string(), 0.3), ("D4".to_string(), 0.5)]);
        let none = over(ModelOptions { rotor_inertia: Some(RotorInertias::None), ..Default::default() });
        assert_eq!((none.rotor_inertia, none.base), (Some(RotorInertias::None), artefact.base));
        // Only options that differ are reported.
        let said = ModelOptions::differences(none.description().as_ref(), Some(&made_with));
        assert_eq!(said, ["[rotor_inertia] is actuated there and none here"]);
        let said = ModelOptions::differences(None, artefact.description().as_ref());
        assert_eq!(said[0], "[base] is 1.5,0,0 there and not given here");
        assert_eq!(ModelOptions::differences(Some(&made_with), Some(&made_with)), [""; 0]);
    }
}
