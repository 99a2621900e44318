//! Gives coordinates and the motion of links their names in formulas, as in Khalil's programs.

use expr::{Expr, Graph, Node};
use robot::Robot;

use crate::kinematics::vector::{Vector, name_vector};

/// The label of each coordinate, which follows a letter in formulas: `2` in `q2`. If all coordinates of the file have names
/// such as `q2`, the labels are the digits in these names. Otherwise the labels are the indices, from 1.
pub(crate) fn coordinate_labels(robot: &Robot) -> Vec<String> {
    let digits = |name: &str| {
        let digits = name.strip_prefix('q').filter(|d| !d.is_empty() && d.bytes().all(|b| b.is_ascii_digit()))?;
        Some(digits.to_string())
    };
    let of_file: Option<Vec<String>> = robot.coordinates.iter().map(|c| digits(&c.name)).collect();
    of_file.unwrap_or_else(|| (1..=robot.n_coordinates()).map(|k| k.to_string()).collect())
}

/// Gives the motion of a link its names in formulas: w3_x, dw3_x, a3_x (acceleration minus g), ww3_xy and U3_xy for link 3.
pub(crate) fn name_motion(g: &mut Graph, label: &str, [w, dw, a]: [Vector; 3], [ww, U]: [&[Vector; 3]; 2]) {
    name_vector(g, w, || format!("w{label}"));
    name_vector(g, dw, || format!("dw{label}"));
    name_vector(g, a, || format!("a{label}"));
    for (letters, matrix) in [("ww", ww), ("U", U)] {
        for (row, axis) in matrix.iter().zip(["x", "y", "z"]) {
            for (&entry, other) in row.iter().zip(["x", "y", "z"]) {
                g.name(entry, || format!("{letters}{label}_{axis}{other}"));
            }
        }
    }
}

/// Gives the twists of a link their names in formulas: for link 3, z3_1 and d3_1 are angular velocity and velocity per unit rate
/// of coordinate 1.
pub(crate) fn name_twists(g: &mut Graph, label: &str, twists: impl Iterator<Item = Option<[Vector; 2]>>, q: &[Expr]) {
    for (k, twist) in twists.enumerate() {
        let Some([z, d]) = twist else { continue };
        let of = match g.node(q[k]) {
            Node::Symbol(s) => g.symbols()[s.0 as usize].0.trim_start_matches('q').to_string(),
            _ => k.to_string(),
        };
        name_vector(g, z, || format!("z{label}_{of}"));
        name_vector(g, d, || format!("d{label}_{of}"));
    }
}
