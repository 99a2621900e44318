//! Evaluates the regressor or the torque at the states of a CSV file and writes CSV, so that other tools can check the results.
//!
//! ```text
//! q_q1,q_q2,dq_q1,dq_q2,ddq_q1,ddq_q2   ->   Y_q1_ZZR1,..   or   tau_q1,tau_q2
//! ```
//! SI units. Each row is a state; missing columns dq and ddq count as zero. For the torque, a column x_MX2 replaces the
//! description's value of the parameter MX2.

use std::path::Path;

use expr::{Function, Tape};
use gate::{shown, source};
use modeling::Closure;
use robot::{Inertial, Robot, RotorInertia, StandardParameter};

use crate::describe::model::Model;
use crate::error::Error;
use crate::request::StateQuantity;

/// Computes `quantity` at each state of the file; returns CSV with a header.
///
/// Fails with the line and column of a cell that is not a finite number, and fails if a column is missing.
pub fn evaluate(model: &mut Model, states: &Path, quantity: StateQuantity) -> Result<String, Error> {
    let closure = model.take_closure();
    let (robot, parameters) = (&model.robot, &model.parameters);
    let states = StateTable::read(states, robot, quantity, closure)?;
    let standard = || (0..parameters.standard.len()).map(|c| parameters.standard[c].display(robot).to_string());
    let (function, columns): (&Function, Vec<String>) = match quantity {
        StateQuantity::Regressor => (&model.standard_regressor, regressor_columns(robot, standard().collect())),
        StateQuantity::BaseRegressor => {
            (&model.base_regressor, regressor_columns(robot, parameters.base.iter().map(|b| b.name.clone()).collect()))
        }
        StateQuantity::Torque => (&model.torque, robot.coordinates.iter().map(|c| format!("tau_{}", c.name)).collect()),
    };
    let tape = Tape::new(function);
    let mut outputs = vec![0.0; states.n_rows * tape.n_outputs()];
    if tape.n_inputs() > 0 {
        tape.evaluate_many(&states.inputs, &mut tape.workspace(), &mut outputs);
    }
    let mut text = columns.iter().map(|column| shown::csv_cell(column)).collect::<Vec<_>>().join(",");
    text.push('\n');
    for row in outputs.chunks(columns.len().max(1)) {
        let cells: Vec<String> = row.iter().map(|x| format!("{x:?}")).collect();
        text += &cells.join(",");
        text.push('\n');
    }
    Ok(text)
}

fn regressor_columns(robot: &Robot, parameters: Vec<String>) -> Vec<String> {
    let of = |coordinate: &str| parameters.iter().map(|p| format!("Y_{coordinate}_{p}")).collect::<Vec<_>>();
    robot.coordinates.iter().flat_map(|c| of(&c.name)).collect()
}

/// Largest size of a file of states, bytes. The size is limited because all states and their outputs are held in memory.
const MAX_STATES_BYTES: u64 = 1 << 28;

/// The inputs of the function at all states, one state after the other.
struct StateTable {
    inputs: Vec<f64>,
    n_rows: usize,
}

/// The source of an input of the function: a column of the file, or one number for all rows.
enum InputOrigin {
    Column(usize),
    Number(f64),
}

impl StateTable {
    fn read(
        path: &Path,
        robot: &Robot,
        quantity: StateQuantity,
        mut closure: Option<Closure>,
    ) -> Result<StateTable, Error> {
        let file = path.display();
        let failed = |e: csv::Error| Error::new(format_args!("{file}: {e}"));
        let text = source::read(path, MAX_STATES_BYTES).map_err(|e| Error::new(format_args!("{file}: {e}")))?;
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(&text[..]);
        let header = reader.headers().map_err(failed)?;
        let header: Vec<String> = header.iter().map(|name| shown::line(name).into_owned()).collect();
        let mut origins = state_origins(robot, &header, path)?;
        if quantity == StateQuantity::Torque {
            for parameter in StandardParameter::all(robot) {
                origins.push(parameter_origin(robot, parameter, &header, path)?);
            }
        }
        let mut states = StateTable { inputs: Vec::new(), n_rows: 0 };
        for record in reader.records() {
            let record = record.map_err(failed)?;
            let line = record.position().map_or(0, csv::Position::line);
            let mut row: Vec<f64> = Vec::with_capacity(origins.len());
            for origin in &origins {
                row.push(match origin {
                    InputOrigin::Number(x) => *x,
                    InputOrigin::Column(c) => match record[*c].parse::<f64>() {
                        Ok(x) if x.is_finite() => x,
                        _ => {
                            return Err(Error::new(format_args!(
                                "{file}:{line}: column `{}`: a finite number was expected, `{}` was found",
                                header[*c], &record[*c]
                            )));
                        }
                    },
                });
            }
            // The function takes the positions of the passive joints directly after q.
            if let Some(closure) = &mut closure {
                let n = robot.n_coordinates();
                let passive =
                    closure.passive(&row[..n]).map_err(|open| Error::new(format_args!("{file}:{line}: {open}")))?;
                row.splice(n..n, passive);
            }
            states.inputs.extend(row);
            states.n_rows += 1;
        }
        if states.n_rows == 0 {
            return Err(Error::new(format_args!("{file}: no states below the header")));
        }
        Ok(states)
    }
}

/// The sources of q, dq and ddq; velocities and accelerations without a column are zero.
fn state_origins(robot: &Robot, header: &[String], path: &Path) -> Result<Vec<InputOrigin>, Error> {
    let mut origins = Vec::new();
    for quantity in ["q", "dq", "ddq"] {
        for coordinate in &robot.coordinates {
            let name = format!("{quantity}_{}", coordinate.name);
            // The column of coordinate q1 is `q_q1` or, shorter, `q1`.
            let short = coordinate.name.strip_prefix('q').map(|rest| format!("{quantity}{rest}"));
            let matches = |h: &String| *h == name || Some(h) == short.as_ref();
            match header.iter().position(matches) {
                Some(column) => origins.push(InputOrigin::Column(column)),
                None if quantity == "q" => {
                    let (file, found) = (path.display(), header.join(", "));
                    return Err(Error::new(format_args!("{file}:1: no column `{name}`; found: {found}")));
                }
                None => origins.push(InputOrigin::Number(0.0)),
            }
        }
    }
    Ok(origins)
}

/// The source of a parameter's value: the file's column `x_<parameter>` if it exists, otherwise the description.
fn parameter_origin(
    robot: &Robot,
    parameter: StandardParameter,
    header: &[String],
    path: &Path,
) -> Result<InputOrigin, Error> {
    let name = parameter.display(robot).to_string();
    if let Some(column) = header.iter().position(|h| *h == format!("x_{name}")) {
        return Ok(InputOrigin::Column(column));
    }
    let link = robot.link(parameter.link);
    let value = match parameter.inertial {
        Inertial::Ia => match link.joint.rotor_inertia {
            RotorInertia::Known(x) => Some(x),
            RotorInertia::Absent | RotorInertia::Unknown => Some(0.0),
        },
        inertial => link.inertial.map(|x| x[inertial as usize]),
    };
    value.map(InputOrigin::Number).ok_or_else(|| {
        Error::new(format_args!(
            "the description does not give the parameters of link `{}`: add a column `x_{name}` to {}, or standard \
             parameters to the description",
            link.name,
            path.display()
        ))
    })
}
