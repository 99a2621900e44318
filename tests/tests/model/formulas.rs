//! Tests that the formulas printed by `rist derive` give the same values as direct evaluation (by a tape, a list of operations).
//! A small calculator evaluates text, MATLAB and LaTeX; Python evaluates SymPy if it is installed.

use std::collections::HashMap;
use std::fmt::Write as _;

use expr::Function;
use formulas::{FormulaLanguage, Formulas, formula_file, printed_symbols};
use modeling::{LinkFrame, RobotFunction};
use robot::Robot;
use tests::formula_text::{assignments, evaluated};
use tests::model;
use tests::program::{done, folder, has_python};
use tests::random::Random;

/// Tolerance for the difference between two orders of summation, for some thousand terms that mostly cancel.
const ROUNDING: f64 = 1e-11;

/// The functions with these names. A function of a link is derived for the last link. All constants stay symbols.
fn functions(robot: &Robot, words: &[&str]) -> Vec<Function> {
    let last = LinkFrame::from(robot.link_ids().next_back().unwrap());
    let function = |word: &&str| match RobotFunction::of_robot(word) {
        Some(function) => function,
        None => RobotFunction::of_link(word).unwrap_or_else(|| panic!("{word}"))(last.clone()),
    };
    let wanted: Vec<RobotFunction> = words.iter().map(function).collect();
    modeling::formulas(robot, &wanted).unwrap().functions.into_iter().map(|(_, function)| function).collect()
}

fn all_words() -> Vec<&'static str> {
    tests::register_wings();
    RobotFunction::words().map(|(word, _)| word).collect()
}

/// Random values for the inputs of a function, then the values of its constants.
fn values(function: &Function, random: &mut Random) -> Vec<f64> {
    let inputs = function.inputs.iter().flat_map(|i| &i.entries).map(|_| random.unit() + 0.1).collect::<Vec<_>>();
    inputs.into_iter().chain(function.constants().into_iter().map(|(_, _, x)| x)).collect()
}

fn by_tape(function: &Function, values: &[f64]) -> Vec<f64> {
    let n = function.inputs.iter().map(|i| i.entries.len()).sum();
    tests::evaluated(function, &[&values[..n]])
}

/// The entries of all outputs, computed by the formulas in the printed file. An entry that the file does not assign is zero.
fn by_file(function: &Function, file: &str, language: FormulaLanguage, values: &[f64]) -> Vec<f64> {
    let symbols: HashMap<String, f64> =
        printed_symbols(function, language).into_iter().zip(values.iter().copied()).collect();
    let lines = assignments(file);
    let is_frame = |line: &&String| {
        let unpacked = line.split_once(" = ").is_some_and(|(name, _)| symbols.contains_key(name));
        line.starts_with("function") || *line == "end" || line.contains(" = [") || unpacked
    };
    let lines: Vec<&String> = lines.iter().filter(|line| !is_frame(line)).collect();
    let found = evaluated(lines.iter().map(|line| line.as_str()), symbols.clone());
    let entry = |(o, k): (&expr::Output, usize)| {
        let name = formulas::output_name(&o.name);
        let (row, column) = (k / o.columns + 1, k % o.columns + 1);
        let place = if o.columns == 1 { row.to_string() } else { format!("{row},{column}") };
        let name = match language {
            FormulaLanguage::Latex => {
                let letters = match name.as_str() {
                    "tau" => "\\tau".into(),
                    "ddq" => "\\ddot{q}".into(),
                    name if name.len() == 1 => name.to_string(),
                    name => format!("\\mathit{{{}}}", name.replace('_', "\\_")),
                };
                format!("{letters}_{{{place}}}")
            }
            FormulaLanguage::Matlab => format!("{name}_{row}_{column}"),
            _ => format!("{name}[{place}]"),
        };
        found.get(&name).copied().unwrap_or(0.0)
    };
    function.outputs.iter().flat_map(|o| (0..o.entries.len()).map(move |k| (o, k))).map(entry).collect()
}

fn printed(function: &Function, language: FormulaLanguage, is_expanded: bool) -> String {
    let formulas = Formulas { doc: vec!["Of a test.".into()], function: function.clone(), place: None, is_expanded };
    formula_file(&["A test.".into()], &[formulas], language, "this test").unwrap()
}

#[track_caller]
fn agree(what: &str, found: &[f64], expected: &[f64]) {
    let scale = expected.iter().fold(1.0, |s: f64, x| s.max(x.abs()));
    assert_eq!(found.len(), expected.len(), "{what}");
    for (k, (a, b)) in found.iter().zip(expected).enumerate() {
        // Both are NaN for a pose that no configuration reaches.
        assert!(
            (a - b).abs() <= ROUNDING * scale || (a.is_nan() && b.is_nan()),
            "{what}, entry {k}: {a} printed, {b} by the tape"
        );
    }
}

#[test]
fn text_latex_and_matlab_compute_what_the_tape_does() {
    let (mut random, mut compared) = (Random(40), 0);
    for file in ["planar2r_vertical.yaml", "rx90.yaml", "stanford.yaml", "sr400.par", "tree.yaml", "race.yaml"] {
        let robot = model(file);
        for function in functions(&robot, &all_words()) {
            // Each function is tested twice: with all constants as symbols, and with some of them as numbers.
            for function in [function.bound_except(&|name| name.len() % 2 == 0), function] {
                let values = values(&function, &mut random);
                let expected = by_tape(&function, &values);
                for language in [FormulaLanguage::Text, FormulaLanguage::Latex, FormulaLanguage::Matlab] {
                    let text = printed(&function, language, false);
                    let found = by_file(&function, &text, language, &values);
                    agree(&format!("{file}, {}, {language:?}", function.name), &found, &expected);
                    compared += expected.iter().filter(|x| **x != 0.0).count();
                }
            }
        }
    }
    assert!(compared > 10_000, "{compared} numbers that are not zero");
}

#[test]
fn expanded_entries_compute_what_the_tape_does() {
    let mut random = Random(41);
    for file in ["planar2r_vertical.yaml", "scara.yaml", "cartpole.yaml"] {
        for function in functions(&model(file), &["inertia-matrix", "bias", "inverse-dynamics", "pose", "jacobian"]) {
            let values = values(&function, &mut random);
            let expected = by_tape(&function, &values);
            for language in [FormulaLanguage::Text, FormulaLanguage::Latex] {
                let found = by_file(&function, &printed(&function, language, true), language, &values);
                agree(&format!("{file}, {} expanded", function.name), &found, &expected);
            }
        }
    }
}

#[test]
fn one_entry_is_that_of_the_matrix() {
    let mut random = Random(42);
    for function in functions(&model("rx90.yaml"), &["inertia-matrix", "pose"]) {
        let values = values(&function, &mut random);
        let expected = by_tape(&function, &values);
        let (o, (row, column)) = (&function.outputs[0], (1, 2));
        let formulas =
            Formulas { doc: vec![], function: function.clone(), place: Some((0, row, column)), is_expanded: false };
        let text = formula_file(&[], &[formulas], FormulaLanguage::Text, "this test").unwrap();
        let lines = assignments(&text);
        let symbols = printed_symbols(&function, FormulaLanguage::Text).into_iter().zip(values).collect();
        let found = evaluated(lines.iter().map(String::as_str), symbols);
        let name = format!("{}[2,3]", formulas::output_name(&o.name));
        agree(&function.name, &[found[&name]], &[expected[row * o.columns + column]]);
        assert_eq!(text.lines().filter(|line| line.contains("] = ")).count(), 1, "{text}");
    }
}

#[test]
fn sympy_computes_what_the_tape_does() {
    if !has_python("sympy") {
        return;
    }
    let folder = folder("sympy");
    let (mut random, mut script, mut expected) = (Random(43), String::new(), Vec::new());
    for (m, file) in ["planar2r_vertical.yaml", "rx90.yaml", "sr400.par"].into_iter().enumerate() {
        let words = ["inertia-matrix", "inverse-dynamics", "forward-dynamics", "energy", "pose", "friction"];
        let functions = functions(&model(file), &words);
        let formulas = functions.iter().map(|function| {
            let doc = vec!["A \"test\" \\ of".into(), "two lines.".into()];
            Formulas { doc, function: function.clone(), place: None, is_expanded: false }
        });
        let formulas: Vec<Formulas> = formulas.collect();
        let text = formula_file(&[], &formulas, FormulaLanguage::Sympy, "this test").unwrap();
        std::fs::write(folder.join(format!("robot{m}.py")), text).unwrap();
        writeln!(script, "import robot{m}").unwrap();
        for function in functions {
            let values = values(&function, &mut random);
            let mut rest = &values[..];
            let mut arguments: Vec<String> = Vec::new();
            for input in &function.inputs {
                let (own, others) = rest.split_at(input.entries.len());
                arguments.push(format!("{own:?}"));
                rest = others;
            }
            arguments.extend(rest.iter().map(|x| format!("{x:?}")));
            let call = format!("robot{m}.{}({})", function.name, arguments.join(", "));
            writeln!(script, "made = {call}\nfor m in made if isinstance(made, tuple) else [made]:").unwrap();
            writeln!(script, "    for x in m: print(float(x))\nrobot{m}.{}()", function.name).unwrap();
            expected.push((format!("{file}, {}", function.name), by_tape(&function, &values)));
        }
    }
    std::fs::write(folder.join("run.py"), script).unwrap();
    let printed = done(&folder, "python3", "run.py").out;
    let mut numbers = printed.lines().map(|x| x.parse::<f64>().unwrap());
    for (what, expected) in expected {
        let found: Vec<f64> = numbers.by_ref().take(expected.len()).collect();
        agree(&what, &found, &expected);
    }
}
