//! Writes functions of a robot as formulas. The symbols of the robot's file, or the symbols that the request names, stay
//! symbols in the formulas.

use expr::Function;
use modeling::{RobotFormulas, RobotFunction};
use rist::Error;
use rist::describe::description::check_size;
use rist::describe::source::{function_named, function_names};
use robot::Robot;

use crate::file::{FormulaLanguage, Formulas, formula_file};
use crate::listing::{OutputEntry, output_name};
use crate::request::DeriveRequest;
use crate::symbols::KeptSymbols;

/// Writes the requested formulas as the text of one file. `made_by`: the command that the head of the file shows.
///
/// Fails if a function, a symbol or an entry does not exist, if the description lacks a number, if the rank of the base regressor
/// is ambiguous, or if the derivation would be long and `any_size` is false.
pub fn derive(robot: &Robot, request: &DeriveRequest, made_by: &str, any_size: bool) -> Result<String, Error> {
    check_size(robot, any_size)?;
    let RobotFormulas { doc, functions, constants } =
        modeling::formulas(robot, &wanted(robot, request)?).map_err(Error::new)?;
    let kept = KeptSymbols::of(robot, &request.symbols, &constants)?;
    let formulas = |(mut doc, function): (Vec<String>, Function)| -> Result<Formulas, Error> {
        let function = function.bound_except(&|name| kept.holds(name));
        let place = request.entry.as_ref().map(|entry| place(&function, entry)).transpose()?;
        doc.extend(kept.line(&function));
        let count = function.count();
        doc.push(format!("{} products, {} sums, {} angles.", count.mul, count.add, count.sin_cos));
        Ok(Formulas { doc, function, place, is_expanded: request.expand })
    };
    let mut formulas = functions.into_iter().map(formulas).collect::<Result<Vec<_>, _>>()?;
    for k in 1..formulas.len() {
        // Two different names may give the same identifier. Then an underscore is appended to the second one.
        while formulas[..k].iter().any(|f| f.function.name == formulas[k].function.name) {
            formulas[k].function.name.push('_');
        }
    }
    formula_file(&doc, &formulas, request.language, made_by).map_err(Error::new)
}

/// The requested functions of the robot.
fn wanted(robot: &Robot, request: &DeriveRequest) -> Result<Vec<RobotFunction>, Error> {
    let functions: Vec<RobotFunction> =
        request.function.iter().map(|name| function_named(robot, name)).collect::<Result<_, _>>()?;
    let count = functions.len();
    match (&request.entry, request.language) {
        _ if count == 0 => {
            let names = function_names();
            Err(Error::new(format_args!("[function] is missing; there are base-regressor, {names}")))
        }
        (Some(entry), _) if count > 1 => {
            Err(Error::new(format_args!("[entry={entry}] is of one function, and [function] names {count}: name one")))
        }
        (_, FormulaLanguage::Matlab) if count > 1 => Err(Error::new(format_args!(
            "[language=matlab] finds one function in a file, and [function] names {count}: write a file each"
        ))),
        _ => Ok(functions),
    }
}

/// The output entry with this name, such as `A[1,2]` or `tau[3]`.
fn place(function: &Function, text: &str) -> Result<OutputEntry, Error> {
    let there = || {
        let shape = |o: &expr::Output| match o.columns {
            1 => format!("{}[1] to {0}[{}]", output_name(&o.name), o.rows),
            _ => format!("{}[1,1] to {0}[{},{}]", output_name(&o.name), o.rows, o.columns),
        };
        function.outputs.iter().map(shape).collect::<Vec<_>>().join(", ")
    };
    let found = || {
        let (name, places) = text.trim().strip_suffix([']', ')'])?.split_once(['[', '('])?;
        let places: Vec<usize> = places.split(',').map(|x| x.trim().parse().ok()).collect::<Option<_>>()?;
        let output = function.outputs.iter().position(|o| o.name.eq_ignore_ascii_case(name))?;
        let o = &function.outputs[output];
        let (row, column) = match places[..] {
            [row] if o.columns == 1 => (row, 1),
            [row, column] => (row, column),
            _ => return None,
        };
        let is_there = (1..=o.rows).contains(&row) && (1..=o.columns).contains(&column);
        is_there.then(|| (output, row - 1, column - 1))
    };
    found()
        .ok_or_else(|| Error::new(format_args!("[entry={text}] is no entry of {}; it has {}", function.name, there())))
}
