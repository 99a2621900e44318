//! Functions of a robot whose formulas are printed for readers. Every length, angle and component of gravity is a named
//! constant; every intermediate result has its name from Khalil's books.

use expr::Function;
use robot::Robot;

use crate::base::base_parameters::BaseParameters;
use crate::base::unclear_rank::UnclearRank;
use crate::derivation::Derivation;
use crate::robot_function::{Derived, RobotFunction, parameters_of};
use crate::robot_module::wrapped;

/// Functions of a robot whose formulas are printed for readers, with lines that explain the formulas.
pub struct RobotFormulas {
    /// Lines that explain the names that all functions share.
    pub doc: Vec<String>,
    /// The functions in the requested order, each with the lines that explain this function.
    pub functions: Vec<(Vec<String>, Function)>,
    /// The constants that occur in the functions. Each has the name used in the formulas, and the names of all entries in the
    /// robot's file that have this value (such as `d3`: `d3`, `d7`).
    pub constants: Vec<(String, Vec<String>)>,
}

/// Derives functions of a robot whose formulas are printed for readers. If the rank is not clear-cut, there are no base
/// parameters, and the functions depend on the standard parameters; a request for the base regressor then fails.
pub fn formulas(robot: &Robot, functions: &[RobotFunction]) -> Result<RobotFormulas, UnclearRank> {
    let mut derivation = Derivation::with_names(robot)?;
    let standard = derivation.regressor();
    let base = parameters_of(functions, &mut derivation, &standard)?;
    let derived = Derived { standard: &standard, base: &base };
    let derive = |which: &RobotFunction| {
        let (doc, function) = which.derive(&mut derivation, &derived);
        (doc.lines().map(String::from).collect(), function)
    };
    let functions: Vec<(Vec<String>, Function)> = functions.iter().map(derive).collect();
    let places = derivation.constants.places(&derivation.graph);
    let mut constants: Vec<(String, Vec<String>)> = Vec::new();
    for (_, name, _) in functions.iter().flat_map(|(_, function)| function.constants()) {
        if constants.iter().all(|(known, _)| *known != name) {
            let names = places.get(&name).cloned().unwrap_or_else(|| vec![name.clone()]);
            constants.push((name, names));
        }
    }
    Ok(RobotFormulas { doc: doc(robot, &base, &functions), functions, constants })
}

/// The lines that explain the inputs q and x and the intermediate results of the functions.
fn doc(robot: &Robot, base: &BaseParameters, functions: &[(Vec<String>, Function)]) -> Vec<String> {
    let mut doc =
        vec![format!("{}: q in rad or m, dq and ddq per s and s^2, torques in N m (forces in N).", robot.name)];
    doc.extend(robot.source.iter().flat_map(|source| wrapped(&format!("Source: {source}"), 100)));
    let coordinates: Vec<&str> = robot.coordinates.iter().map(|c| c.name.as_str()).collect();
    doc.extend(wrapped(&format!("Coordinates, in the order of q: {}", coordinates.join(" ")), 100));
    let passive: Vec<&str> = robot.passive.iter().map(|p| p.name.as_str()).collect();
    if !passive.is_empty() {
        let text =
            format!("Passive coordinates, which the loops determine, in the order of `passive`: {}", passive.join(" "));
        doc.extend(wrapped(&text, 100));
    }
    // The intermediate results have the same names for every robot, so the next lines are fixed texts.
    doc.push(
        "Of link j in its frame: wj angular velocity, dwj angular acceleration, aj acceleration of its origin less"
            .into(),
    );
    doc.push(
        "gravity, Uj = [dwj]x + [wj]x^2, wwj = wj wj^T; zj_k and dj_k angular velocity and velocity per dqk;".into(),
    );
    doc.push("fj, nj force and moment on it and all it carries; XXPj .. MPj it and all it carries as one body.".into());
    // Parameters are listed only if a function uses them: as the input x, or as the columns of Y.
    let reads =
        |p: usize| functions.iter().any(|(_, f)| f.inputs.iter().any(|i| i.name == "x" && i.entries.len() == p));
    let has_columns = |n: usize| functions.iter().any(|(_, f)| f.outputs.iter().any(|o| o.columns == n));
    if base.refused.is_none() && (reads(base.len()) || has_columns(base.len())) {
        doc.push(
            "The base parameters, in the order of x and of the columns of Y, each with what regroups into it:".into(),
        );
        doc.extend(base.rule_lines());
    }
    if reads(base.standard.len()) || has_columns(base.standard.len()) {
        let names: Vec<String> = base.standard.iter().map(|p| p.display(robot).to_string()).collect();
        doc.extend(wrapped(
            &format!("The standard parameters, in the order of x and of the columns of Y: {}", names.join(" ")),
            100,
        ));
    }
    doc
}
