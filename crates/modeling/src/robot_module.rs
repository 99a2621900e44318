//! Makes the generated file of a robot (a module): the head of the file, names, the base regressor with the regrouping rules,
//! other functions.

use expr::{ConstantValue, Function, Fusion, Module, Node, SymbolKind};
use robot::Robot;

use crate::base::base_parameters::BaseParameters;
use crate::base::unclear_rank::UnclearRank;
use crate::derivation::Derivation;
use crate::robot_function::{Derived, RobotFunction, parameters_of};

/// Makes the generated file with the base regressor of a robot and other functions, each once. If the rank is not clear-cut, the
/// file has the regressor of the standard parameters instead; a request for the base regressor, or for no function, then fails.
pub fn module(robot: &Robot, functions: &[RobotFunction]) -> Result<Module, UnclearRank> {
    Ok(module_with_symbols(robot, functions, &|_| false)?.module)
}

/// Name of the function that is the regressor of the standard parameters.
const STANDARD: &str = "regressor";

/// A module whose functions have some lengths, angles and components of gravity as an argument.
pub struct ModuleWithSymbols {
    /// The module. If `symbols` is not empty, the last input of its functions is `symbols`.
    pub module: Module,
    /// The names of the lengths, angles and gravity components in the argument `symbols`, in the order of this argument.
    pub symbols: Vec<String>,
    /// For each constant in the graph: its name there, and all names that the constant has in the robot's file.
    pub constants: Vec<(String, Vec<String>)>,
}

/// Makes the file of [`module`], in which the named constants for which `is_symbol(name)` holds are entries of the input
/// `symbols`. Fails like [`module`].
pub fn module_with_symbols(
    robot: &Robot,
    functions: &[RobotFunction],
    is_symbol: &dyn Fn(&str) -> bool,
) -> Result<ModuleWithSymbols, UnclearRank> {
    let mut derivation = Derivation::new(robot)?;
    let standard = derivation.regressor();
    let base = parameters_of(functions, &mut derivation, &standard)?;
    let places = derivation.constants.places(&derivation.graph);
    let values = named_constants(&derivation);
    let all_names = |(name, _): &(String, f64)| {
        let names = places.get(name).cloned().unwrap_or_else(|| vec![name.clone()]);
        (name.clone(), names)
    };
    let constants: Vec<(String, Vec<String>)> = values.iter().map(all_names).collect();
    let is_open = |(_, names): &&(String, Vec<String>)| names.iter().any(|name| is_symbol(name));
    let symbols: Vec<String> = constants.iter().filter(is_open).map(|(name, _)| name.clone()).collect();
    let bind = |function: Function| match symbols.is_empty() {
        true => function.bound(),
        false => function.with_constants_as_input("symbols", &symbols).bound(),
    };
    let mut module = robot_module(robot, &base, &standard, &symbols, bind(base.regressor(&standard)));
    if !symbols.is_empty() {
        doc_of_symbols(&mut module, robot, &symbols, &values);
    }
    let d = &mut derivation;
    if let Some(closure) = d.closure_function() {
        module.function(
            "Zero where the loops are closed, and its Jacobian for the passive joints: solve e = 0.",
            bind(closure),
        );
    }
    let derived = Derived { standard: &standard, base: &base };
    for (k, which) in functions.iter().enumerate() {
        if which.is_base_regressor() || functions[..k].contains(which) {
            continue;
        }
        let (doc, function) = which.derive(d, &derived);
        // The file already has the regressor of the standard parameters, so this regressor is not written twice.
        if base.refused.is_some() && function.name == STANDARD {
            continue;
        }
        let mut function = bind(function);
        // Two frame names may give the same function name, so a suffix makes the function name unique.
        while module.functions.iter().any(|f| f.function.name == function.name) {
            function.name.push('_');
        }
        module.function(&format!("{doc}\n{}.", operations(&function)), function);
    }
    Ok(ModuleWithSymbols { module, symbols, constants })
}

/// Makes the module with the base regressor `regressor`, the names of the rows and columns of this regressor, and the
/// regrouping rules with the values of the constants.
fn robot_module(
    robot: &Robot,
    base: &BaseParameters,
    standard: &Function,
    symbols: &[String],
    mut regressor: Function,
) -> Module {
    let (of, name) = if base.refused.is_some() { ("standard", STANDARD) } else { ("base", "base_regressor") };
    regressor.name = name.into();
    let parameters: Vec<String> = base.base.iter().map(|b| b.name.clone()).collect();
    let coordinates: Vec<String> = robot.coordinates.iter().map(|c| c.name.clone()).collect();

    let mut module = Module::new(&robot.name);
    let doc = &mut module.doc;
    doc.push(format!("{}: the {of} regressor, tau = Y(q, dq, ddq) X.", robot.name));
    if let Some(why) = &base.refused {
        doc.extend(wrapped(&format!("There are no base parameters: {why}"), 100));
    }
    doc.push(String::new());
    // The head of the file: dimensions of Y, units, source, regrouping rules, parameters without effect.
    let (n, p, entries) = (coordinates.len(), parameters.len(), regressor.non_zeros(0).len());
    doc.push(format!("Y is {n} x {p}, {entries} of its entries not always zero: {}.", operations(&regressor)));
    doc.push("q: rad or m; dq, ddq: per s, per s^2; tau: N m or N. Gravity included, friction not.".into());
    if let Some(source) = &robot.source {
        doc.push(String::new());
        doc.extend(wrapped(&format!("Source: {source}"), 100));
    }
    if !robot.snapped.is_empty() {
        let taken: Vec<String> = robot.snapped.iter().map(|n| format!("{}: {}", n.subject, n.text)).collect();
        doc.push(String::new());
        doc.extend(wrapped(&format!("Not as given: {}.", taken.join("; ")), 100));
    }
    doc.push(String::new());
    doc.push(format!("The {of} parameters X, each with what regroups into it:"));
    doc.push("```text".into());
    doc.extend(base.rule_lines());
    let no_effect: Vec<String> = base.no_effect.iter().map(|&c| base.standard[c].display(robot).to_string()).collect();
    if !no_effect.is_empty() {
        doc.extend(wrapped(&format!("No effect: {}", no_effect.join(" ")), 100));
    }
    if !base.weak.is_empty() {
        doc.extend(wrapped(&base.evidence_of_rank(robot), 100));
    }
    let values = values(standard, symbols);
    if !values.is_empty() {
        doc.extend(wrapped(&format!("With {}", values.join(", ")), 100));
    }
    doc.push("```".into());
    let n_passive = robot.passive.len();
    if n_passive > 0 {
        let passive = robot.passive.iter().map(|p| format!("{} from {}", p.name, p.start)).collect::<Vec<_>>();
        let how = "solve `closure` for them, starting";
        doc.push(String::new());
        doc.extend(wrapped(&format!("The {n_passive} entries of `passive`: {how} {}.", passive.join(", ")), 100));
    }

    // Add constants for programs that call the functions.
    module.constant("NAME", "The robot.", ConstantValue::Text(robot.name.clone()));
    module.constant("COORDINATES", "The coordinates, in the order of q.", ConstantValue::Texts(coordinates));
    let in_order = format!("The {of} parameters, in the order of the columns of Y.");
    module.constant("PARAMETERS", &in_order, ConstantValue::Texts(parameters));
    let purpose = "Distinguishes this function from the functions of other robots and geometries.";
    module.constant("FINGERPRINT", purpose, ConstantValue::Number(regressor.fingerprint()));
    let shape = "Y(q, dq, ddq), row by row: `y[i][c]` is the torque of coordinate i per unit of parameter c.";
    module.regressor(shape, regressor);
    module
}

/// The lengths, angles and components of gravity that are named constants of the expression graph, with their values.
fn named_constants(derivation: &Derivation) -> Vec<(String, f64)> {
    let constant = |(name, kind): &(String, SymbolKind)| match kind {
        SymbolKind::Constant(x) => Some((name.clone(), *x)),
        SymbolKind::Input => None,
    };
    derivation.graph.symbols().iter().filter_map(constant).collect()
}

/// Adds the names of the entries of `symbols` to the module. Also adds the values of these entries if the robot's file has all
/// of them.
fn doc_of_symbols(module: &mut Module, robot: &Robot, symbols: &[String], values: &[(String, f64)]) {
    let how = "The entries of the argument `symbols`, m, rad or m/s^2, as SYMBOLS lists them.";
    module.doc.extend([String::new(), how.into()]);
    module.constant("SYMBOLS", "The entries of the argument `symbols`.", ConstantValue::Texts(symbols.to_vec()));
    let is_known = |name: &str| !robot.symbols.iter().any(|s| s.generic && s.name == name);
    if symbols.iter().all(|name| is_known(name)) {
        let value = |name: &String| values.iter().find(|(known, _)| known == name).map_or(0.0, |(_, x)| *x);
        let doc = "What the robot's file says they are.";
        module.constant("SYMBOL_VALUES", doc, ConstantValue::Reals(symbols.iter().map(value).collect()));
    }
}

/// The number of operations of the generated code, as text. Terms that are zero at the values of the constants do not count. A
/// product within a sum is one `mul_add`. It counts neither as a product nor as a sum.
fn operations(bound: &Function) -> String {
    let bound = bound.bound();
    let (count, fusion) = (bound.count(), Fusion::of(&bound));
    let (mul, mul_add) = (count.mul - fusion.fused_products(), fusion.fused_sums());
    format!("{mul_add} mul_add, {mul} mul, {} add, {} sin_cos", count.add - mul_add, count.sin_cos)
}

/// The named constants of the regressor that are not in `symbols`, with their values, as text: `D2 = 0.3`.
fn values(standard: &Function, symbols: &[String]) -> Vec<String> {
    let graph = standard.graph();
    let mut read: Vec<usize> = graph
        .nodes()
        .iter()
        .filter_map(|node| if let Node::Symbol(s) = node { Some(s.0 as usize) } else { None })
        .collect();
    read.sort_unstable();
    let value = |s: usize| match &graph.symbols()[s] {
        (name, SymbolKind::Constant(x)) if !symbols.contains(name) => Some(format!("{name} = {x}")),
        _ => None,
    };
    read.into_iter().filter_map(value).collect()
}

pub(crate) fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.len() - 1;
        if !lines[last].is_empty() && lines[last].len() + 1 + word.len() > width {
            lines.push(word.to_string());
        } else {
            if !lines[last].is_empty() {
                lines[last].push(' ');
            }
            lines[last] += word;
        }
    }
    lines
}
