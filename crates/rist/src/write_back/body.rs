//! Values that are written into a simulator's file: inertial parameters, friction and rotor inertia.
//!
//! The ten inertial parameters of a link refer to the origin of the link frame, and include the links that are fixed to it
//! (`lumped`).

use linear_model::pseudo_inertia::{Ten, smallest_eigenvalue};
use robot::{Link, Part};

/// Friction and rotor inertia of a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct JointDynamics {
    /// The joint's name in the file.
    pub joint: String,
    /// Viscous friction, N m s/rad (N s/m).
    pub damping: f64,
    /// Coulomb friction, N m (N).
    pub friction: f64,
    /// Rotor inertia, referred to the joint side of the gear, kg m^2 (kg).
    pub armature: f64,
}

/// Fails if the ten inertial parameters of a link are physically impossible, because simulators refuse such a body.
pub(super) fn check(link: &Link, ten: &Ten) -> Result<(), String> {
    match smallest_eigenvalue(ten) > 0.0 {
        true => Ok(()),
        false => Err(format!(
            "link {}: the identified parameters are no body (pseudo-inertia not positive definite); estimate with \
             consistency first",
            link.name
        )),
    }
}

/// The ten inertial parameters of a link without the links that are fixed to it. `ten`: the sum over the link and these fixed
/// links, about the origin of the link frame. The file's parameters of the fixed links are subtracted from `ten`.
///
/// If the difference is physically impossible, the link gets the whole sum `ten`. Then the names of the fixed links are returned,
/// because their inertials must be removed from the file.
pub(super) fn own<'a>(link: &'a Link, ten: &Ten) -> (Ten, Vec<&'a str>) {
    let lumped: Vec<&Part> = link.parts.iter().filter(|part| part.name != link.name).collect();
    let mut rest = *ten;
    for part in &lumped {
        rest.iter_mut().zip(part.parameters()).for_each(|(r, theirs)| *r -= theirs);
    }
    match lumped.is_empty() || smallest_eigenvalue(&rest) > 0.0 {
        true => (rest, Vec::new()),
        false => (*ten, lumped.iter().map(|part| part.name.as_str()).collect()),
    }
}

/// A sentence for the user: this link got the inertia of the links `lumped`, which are fixed to it. `None` if `lumped` is
/// empty.
pub(super) fn carries(link: &Link, lumped: &[&str]) -> Option<String> {
    let names = lumped.join(", ");
    (!lumped.is_empty()).then(|| format!("{} carries the inertia of the links fixed to it: {names}", link.name))
}
