//! The parameters of the observation equation: names and units.

/// A parameter of the observation equation.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    pub name: String,
    pub unit: &'static str,
    /// The joint whose friction it is; `None` for dynamics.
    pub joint: Option<usize>,
}

/// The unit of a joint's own parameter where the joint is prismatic.
pub(crate) fn along(unit: &'static str) -> &'static str {
    match unit {
        "N m s/rad" => "N s/m",
        "N m" => "N",
        "kg m^2" => "kg",
        other => other,
    }
}

/// First moments in kg m (`MXR4`, `D2MXR4`), masses in kg, inertias in kg m^2; a label behind an
/// underscore is not looked at.
pub(crate) fn unit_of_inertial(name: &str) -> &'static str {
    let letters = name.split('_').next().unwrap_or(name).to_ascii_uppercase();
    if ["MX", "MY", "MZ"].iter().any(|moment| letters.contains(moment)) {
        "kg m"
    } else if letters.starts_with('M') {
        "kg"
    } else {
        "kg m^2"
    }
}

/// What stands behind the letters: the number of `q3`, or `_elbow`.
pub fn label(coordinate: &str) -> String {
    match coordinate.strip_prefix('q') {
        Some(digits) if !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()) => digits.into(),
        _ => format!("_{coordinate}"),
    }
}
