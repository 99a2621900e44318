//! Tests that generated Rust and C files compile alone without a warning, and compute the same values as the tape (a list of
//! operations that is evaluated directly).
//!
//! Tape and generated code have the same operations, except for fused multiply-adds. So the values agree within twice the bound
//! of the rounding error. If both use fused multiply-adds, or both do not, the values agree bit by bit, apart from functions with
//! square roots.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use expr::{Expr, Function, Graph, Input, Module, Output, SymbolKind, Tape};
use random::SplitMix;
use tests::model;
use tests::program::{done, folder, is_there, run};
use tests::running_error::bounded;

const STATES: usize = 50;

/// Whether the processor has fused multiply-add that a compiler uses only with an option (x86-64 with AVX2 and FMA).
fn fuses() -> bool {
    #[cfg(target_arch = "x86_64")]
    return is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    return false;
}

/// Functions that are tested in addition to the base regressor; forward dynamics contains divisions.
const FUNCTIONS: [&str; 3] = ["energy", "inertia-matrix", "forward-dynamics"];

/// A module with sqrt(x^2 + y^2) / (x - 7), -(x / y), sqrt(-u) y: divisions and roots of variables, several functions in a file,
/// inputs named like variables, and an unused input.
fn quotients() -> Module {
    let mut g = Graph::new();
    let [x, y, u, v] = ["x", "y", "u", "v"].map(|name| g.symbol(name, SymbolKind::Input));
    let (seven, xx, yy) = (g.constant(7.0), g.mul(x, x), g.mul(y, y));
    let (sum, apart) = (g.add(xx, yy), g.sub(x, seven));
    let (length, root) = (g.sqrt(sum), g.sqrt(-u));
    let entries = vec![g.div(length, apart), -g.div(x, y), g.mul(root, y)];
    let inputs = vec![
        Input { name: "t".into(), entries: vec![x, y] },
        Input { name: "s".into(), entries: vec![u] },
        Input { name: "unread".into(), entries: vec![v] },
    ];
    let output = Output { name: "w".into(), rows: 3, columns: 1, entries };
    let mut module = Module::new("quotients");
    module.function("Quotients.", Function::new("quotient", &g, inputs.clone(), vec![output]));
    let (sine, cosine) = (g.sin(u), g.cos(x));
    let entries = vec![sine, cosine, Expr::ONE, -y];
    let output = Output { name: "w".into(), rows: 2, columns: 2, entries };
    module.function("Sines.\nOf two inputs.", Function::new("sines", &g, inputs.clone(), vec![output]));
    // The outputs are y, x for the inputs x, y. If a caller uses the same array for input and output, this is wrong if an output
    // is stored before all inputs are read.
    let output = Output { name: "w".into(), rows: 2, columns: 1, entries: vec![y, x] };
    module.function("Swapped.", Function::new("swapped", &g, inputs, vec![output]));
    module
}

fn modules() -> Vec<Module> {
    let functions = FUNCTIONS.map(|word| modeling::RobotFunction::of_robot(word).unwrap());
    let read = |name: &str| modeling::module(&model(name), &functions).unwrap_or_else(|e| panic!("{e}"));
    // The lengths of this robot stay symbols. They are an argument of the functions.
    let open = modeling::module_with_symbols(&model("rx90.yaml"), &functions, &|_| true);
    let open = open.unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(open.symbols, ["gz", "D3", "RL4"]);
    vec![quotients(), read("race.yaml"), read("scara.yaml"), read("ur5.yaml"), open.module]
}

/// Random inputs of a function for all states. In every fifth state, angles and rates are a thousand times larger than usual.
/// Input `s` of `quotients` is negative.
fn states(function: &Function) -> Vec<f64> {
    let mut random = SplitMix(1);
    let mut states = Vec::new();
    for k in 0..STATES {
        let reach = if k % 5 == 4 { 3e3 } else { 3.0 };
        for input in &function.inputs {
            states.extend(input.entries.iter().map(|_| {
                let x = reach * random.unit();
                if input.name == "s" { -x.abs() } else { x }
            }));
        }
    }
    states
}

/// The inputs of all functions at all states, one number per line. The generated test programs read them.
fn all_states(modules: &[Module]) -> String {
    let mut text = String::new();
    for f in modules.iter().flat_map(|m| &m.functions) {
        for x in states(&f.function) {
            writeln!(text, "{x:e}").unwrap();
        }
    }
    text
}

/// Compares the printed outputs of a program with the Tapes; bit by bit if `to_the_bit` and the function has no square root.
fn held_against_tapes(modules: &[Module], printed: &str, to_the_bit: bool) {
    let mut printed = printed.split_whitespace().map(|x| x.parse::<f64>().unwrap());
    for f in modules.iter().flat_map(|m| &m.functions) {
        let function = f.function.bound();
        let tape = Tape::new(&function);
        let mut work = tape.workspace();
        let mut values = vec![0.0; tape.n_outputs()];
        let roots = function.graph().nodes().iter().any(|node| matches!(node, expr::Node::Sqrt(_)));
        for inputs in states(&function).chunks(tape.n_inputs()) {
            tape.evaluate(inputs, &mut work, &mut values);
            let bounds = bounded(&function, inputs);
            for (k, (value, bound)) in values.iter().zip(bounds).enumerate() {
                let x = printed.next().expect("the program prints every entry");
                if to_the_bit && !roots {
                    assert_eq!(x.to_bits(), value.to_bits(), "{} entry {k}: {x} {value}", function.name);
                }
                assert!(
                    (x - value).abs() <= 2.0 * bound.error,
                    "{} entry {k}: {x} by the program, {value} by the tape, {:e} allowed",
                    function.name,
                    2.0 * bound.error
                );
            }
        }
    }
    assert!(printed.next().is_none(), "the program prints nothing else");
}

/// Compiles a program in `folder`, runs it with the states on standard input, and compares its outputs with the Tapes.
fn compiled_and_run(folder: &Path, compile: &mut Command, modules: &[Module], to_the_bit: bool) {
    let made = run(compile.current_dir(folder)).ended(0);
    assert!(made.err.is_empty(), "{compile:?}\n{}", made.err);
    std::fs::write(folder.join("states"), all_states(modules)).unwrap();
    let states = std::fs::File::open(folder.join("states")).unwrap();
    let ran = run(Command::new(folder.join("program")).stdin(states)).ended(0);
    held_against_tapes(modules, &ran.out, to_the_bit);
}

/// C code that calls a function with one array as input and output. The result must equal the result with separate arrays.
fn calls_in_place(m: &Module, f: &Function) -> String {
    let (mut main, name) = (String::new(), &f.name);
    let [output] = &f.outputs[..] else { return main };
    let n = output.entries.len();
    let may_be = |input: &&Input| output.columns == 1 && input.entries.len() == n;
    for place in f.inputs.iter().filter(may_be).map(|input| format!("in_{}", input.name)) {
        let inputs: Vec<String> = f.inputs.iter().map(|i| format!("in_{}, ", i.name)).collect();
        let (module, inputs, whole) = (&m.name, inputs.concat(), &output.name);
        writeln!(
            main,
            "        {{
            double kept[{n}];
            memcpy(kept, {place}, sizeof kept);
            {module}_{name}({inputs}{place});
            if (memcmp({place}, out_{whole}, sizeof kept) != 0)
                return 1;
            memcpy({place}, kept, sizeof kept);
        }}"
        )
        .unwrap();
    }
    main
}

/// C statements for the function `main` that call each function of a module at all states.
fn calls_of_c(m: &Module) -> String {
    let mut main = String::new();
    for f in &m.functions {
        let Function { name, inputs, outputs, .. } = &f.function;
        writeln!(main, "    for (k = 0; k < {STATES}; k++) {{").unwrap();
        for i in inputs {
            writeln!(main, "        double in_{}[{}];", i.name, i.entries.len()).unwrap();
        }
        for o in outputs {
            let columns = if o.columns == 1 { String::new() } else { format!("[{}]", o.columns) };
            writeln!(main, "        double out_{}[{}]{columns};", o.name, o.rows).unwrap();
        }
        for i in inputs {
            writeln!(main, "        take(in_{}, {});", i.name, i.entries.len()).unwrap();
        }
        let inputs = inputs.iter().map(|i| format!("in_{}", i.name));
        let names: Vec<String> = inputs.chain(outputs.iter().map(|o| format!("out_{}", o.name))).collect();
        writeln!(main, "        {}_{name}({});", m.name, names.join(", ")).unwrap();
        for o in outputs {
            let first = if o.columns == 1 { "" } else { "[0]" };
            writeln!(main, "        give(out_{}{first}, {});", o.name, o.entries.len()).unwrap();
        }
        main += &calls_in_place(m, &f.function);
        if let Some(entries) = &f.entries {
            // The generated function for the nonzero entries must return the entries of the full output, each at its position.
            let (list, n) = (entries.list.to_ascii_lowercase(), entries.of.places.len());
            let inputs: Vec<String> = f.function.inputs.iter().map(|i| format!("in_{}, ", i.name)).collect();
            let (module, inputs, whole) = (&m.name, inputs.concat(), &outputs[0].name);
            writeln!(
                main,
                "        double some[{n}];
        {module}_{name}_non_zeros({inputs}some);
        for (int e = 0; e < {n}; e++)
            if (some[e] != out_{whole}[{module}_{list}[e][0]][{module}_{list}[e][1]] && some[e] == some[e])
                return 1;"
            )
            .unwrap();
        }
        main += "    }\n";
    }
    main
}

fn write_c(folder: &Path, m: &Module) {
    let files = codegen::c_files(m, "this test", &format!("{}.h", m.name), None);
    std::fs::write(folder.join(format!("{}.h", m.name)), files.header).unwrap();
    std::fs::write(folder.join(format!("{}.c", m.name)), files.source).unwrap();
}

#[test]
fn c_agrees_with_the_tape() {
    // gcc and clang use different rules for fused multiply-add, so both are tested.
    let found: Vec<&str> = ["cc", "clang"].into_iter().filter(|cc| is_there(cc)).collect();
    if found.is_empty() {
        println!("skipped: no C compiler");
    }
    found.into_iter().for_each(c_by_a_compiler_agrees_with_the_tape);
}

fn c_by_a_compiler_agrees_with_the_tape(cc: &str) {
    let (folder, modules) = (folder(&format!("c_{cc}")), modules());
    let mut includes = String::from("#include <stdio.h>\n#include <string.h>\n");
    let mut main = String::new();
    let mut sources = vec!["main.c".to_string()];
    for m in &modules {
        write_c(&folder, m);
        writeln!(includes, "#include \"{}.h\"", m.name).unwrap();
        sources.push(format!("{}.c", m.name));
        main += &calls_of_c(m);
    }
    let program = format!(
        "{includes}
static void take(double *x, int n)
{{
    int i;
    for (i = 0; i < n; i++)
        if (scanf(\"%lf\", &x[i]) != 1)
            return;
}}

static void give(const double *x, int n)
{{
    int i;
    for (i = 0; i < n; i++)
        printf(\"%.17g\\n\", x[i]);
}}

int main(void)
{{
    int k;
{main}    return 0;
}}
"
    );
    std::fs::write(folder.join("main.c"), program).unwrap();
    let run = |flags: &str, to_the_bit: bool| {
        let mut compile = Command::new(cc);
        compile.args("-std=c99 -Wall -Wextra -Wconversion -pedantic -Werror -o program".split(' '));
        compile.args(flags.split(' ')).args(&sources).arg("-lm");
        compiled_and_run(&folder, &mut compile, &modules, to_the_bit);
    };
    run("-O1", !fuses());
    if fuses() {
        run("-O1 -mfma", true);
        // At -O3 the compiler vectorises the code with four lanes.
        run("-O3 -mavx2 -mfma", true);
    }
    // With these options, the compiler may reorder sums. This must not change the rounding of an angle to its quadrant.
    run("-O2 -ffast-math", false);
    run("-O2 -fassociative-math -fno-signed-zeros -fno-trapping-math", false);
}

/// Rust statements for the function `main` that call each function of a module at all states.
fn calls_of_rust(m: &Module) -> String {
    let mut main = String::new();
    for f in &m.functions {
        let Function { name, inputs, outputs, .. } = &f.function;
        writeln!(main, "    for _ in 0..{STATES} {{").unwrap();
        let mut arguments = Vec::new();
        for i in inputs {
            writeln!(main, "        let in_{} = [0.0_f64; {}].map(|_| take());", i.name, i.entries.len()).unwrap();
            arguments.push(format!("&in_{}", i.name));
        }
        for o in outputs {
            let row = if o.columns == 1 { "0.0_f64".into() } else { format!("[0.0_f64; {}]", o.columns) };
            writeln!(main, "        let mut out_{} = [{row}; {}];", o.name, o.rows).unwrap();
            arguments.push(format!("&mut out_{}", o.name));
        }
        writeln!(main, "        {}::{name}({});", m.name, arguments.join(", ")).unwrap();
        for o in outputs {
            let flat = if o.columns == 1 { "" } else { ".as_flattened()" };
            writeln!(main, "        out_{}{flat}.iter().for_each(|x| println!(\"{{x:e}}\"));", o.name).unwrap();
        }
        if let Some(entries) = &f.entries {
            let inputs: Vec<String> = inputs.iter().map(|i| format!("&in_{}, ", i.name)).collect();
            let (module, list, n) = (&m.name, &entries.list, entries.of.places.len());
            let (inputs, whole) = (inputs.concat(), &outputs[0].name);
            writeln!(
                main,
                "        let mut some = [0.0_f64; {n}];
        {module}::{name}_non_zeros({inputs}&mut some);
        for (x, (row, column)) in some.iter().zip({module}::{list}) {{
            assert_eq!(x.to_bits(), out_{whole}[row][column].to_bits());
        }}"
            )
            .unwrap();
        }
        main += "    }\n";
    }
    main
}

#[test]
fn rust_agrees_with_the_tape() {
    let (folder, modules) = (folder("rust"), modules());
    let mut text = String::new();
    let mut main = String::new();
    for m in &modules {
        std::fs::write(folder.join(format!("{}.rs", m.name)), codegen::rust_file(m, "this test")).unwrap();
        writeln!(text, "#[allow(dead_code)]\nmod {};", m.name).unwrap();
        main += &calls_of_rust(m);
    }
    writeln!(
        text,
        "fn main() {{
    let text = std::io::read_to_string(std::io::stdin()).unwrap();
    let mut numbers = text.lines().map(|x| x.parse::<f64>().unwrap());
    let mut take = || numbers.next().unwrap();
    let roots = [0.0, 4.0, f64::INFINITY, -1.0, f64::NEG_INFINITY, f64::NAN].map(quotients::Real::sqrt);
    assert!(roots[..3] == [0.0, 2.0, f64::INFINITY] && roots[3..].iter().all(|x| x.is_nan()));
{main}}}"
    )
    .unwrap();
    std::fs::write(folder.join("main.rs"), text).unwrap();
    let rustc = std::env::var("RUSTC").unwrap_or("rustc".into());
    let mut compile = Command::new(rustc);
    compile.args("--edition 2024 -C opt-level=1 -o program main.rs".split(' '));
    compiled_and_run(&folder, &mut compile, &modules, !fuses());
    if fuses() {
        compile.args(["-C", "target-feature=+avx2,+fma"]);
        compiled_and_run(&folder, &mut compile, &modules, true);
    }
}

/// Code for f32 contains no instructions for doubles, which are slow on processors with single precision only.
#[test]
fn floats_are_computed_as_floats() {
    if !cfg!(target_arch = "x86_64") {
        println!("skipped: the instructions looked for are those of x86-64");
        return;
    }
    let (folder, modules) = (folder("floats"), modules());
    let has_doubles = |assembly: &str| {
        let words = ["sd2ss", "ss2sd", "mulsd", "addsd", "subsd", "divsd", "mulpd", "addpd"];
        let calls = ["sin", "cos", "sqrt", "fma"].map(|name| format!("call\t{name}"));
        let is = |line: &&str| {
            let line = line.trim().trim_end_matches("@PLT");
            words.iter().any(|word| line.contains(word)) || calls.iter().any(|call| line == call)
        };
        assembly.lines().find(is).map(str::to_string)
    };
    for m in &modules {
        std::fs::write(folder.join(format!("{}.rs", m.name)), codegen::rust_file(m, "this test")).unwrap();
        let mut text = format!("#![no_std]\n#[allow(dead_code)]\nmod {};\n", m.name);
        for f in m.functions.iter().map(|f| &f.function) {
            let inputs = f.inputs.iter().map(|i| format!("{}_: &[f32; {}]", i.name, i.entries.len()));
            let outputs = f.outputs.iter().map(|o| match o.columns {
                1 => format!("{}_: &mut [f32; {}]", o.name, o.rows),
                _ => format!("{}_: &mut [[f32; {}]; {}]", o.name, o.columns, o.rows),
            });
            let arguments: Vec<String> = inputs.chain(outputs).collect();
            let all = f.inputs.iter().map(|i| &i.name).chain(f.outputs.iter().map(|o| &o.name));
            let names: Vec<String> = all.map(|name| format!("{name}_")).collect();
            let (name, arguments, names) = (&f.name, arguments.join(", "), names.join(", "));
            writeln!(text, "pub fn {name}({arguments}) {{ {}::{name}::<f32>({names}); }}", m.name).unwrap();
        }
        std::fs::write(folder.join("lib.rs"), text).unwrap();
        let options = "--edition 2024 --crate-type lib --emit asm=out.s,llvm-ir=out.ll -C opt-level=1 lib.rs";
        done(&folder, "rustc", options);
        let assembly = std::fs::read_to_string(folder.join("out.s")).unwrap();
        assert!(assembly.contains("mulss") || assembly.contains("mulps"), "{}: no floats", m.name);
        assert_eq!(has_doubles(&assembly), None, "Rust of {}", m.name);
        // The intermediate code of LLVM is the same for every target, so it is checked too.
        let ir = std::fs::read_to_string(folder.join("out.ll")).unwrap();
        let double = ir.lines().find(|line| line.contains("double"));
        assert!(ir.contains("float"), "{}: no floats", m.name);
        assert_eq!(double, None, "Rust of {}", m.name);

        write_c(&folder, m);
        let options = format!(
            "-std=c99 -Wall -Wextra -Wconversion -Wdouble-promotion -Werror -O1 -S -D{}_REAL=float -o c.s {}.c",
            m.name.to_ascii_uppercase(),
            m.name
        );
        if !is_there("cc") {
            println!("skipped C: no compiler");
            continue;
        }
        done(&folder, "cc", &options);
        assert_eq!(has_doubles(&std::fs::read_to_string(folder.join("c.s")).unwrap()), None, "C of {}", m.name);
    }
}

/// The C code is compiled for a Cortex-M4F, whose hardware has only single precision. It must call no routine for doubles: no
/// `__aeabi_d..`, no conversion, no sine, and no `fmaf`, which newlib computes with doubles. For Rust,
/// [`floats_are_computed_as_floats`] checks this, because the standard library for this target is not installed here.
#[test]
fn floats_of_a_cortex_m4f_call_no_doubles() {
    let (Some(nm), true) = (["llvm-nm", "nm"].into_iter().find(|nm| is_there(nm)), is_there("clang")) else {
        println!("skipped: no clang with nm");
        return;
    };
    let (folder, modules) = (folder("cortex"), modules());
    // A header with the declarations of a C library that the code may use.
    let of = |names: &[&str], number: &str| {
        let declared = |name: &&str| format!("{number} {name}({number});\n");
        names.iter().map(declared).collect::<String>()
    };
    let header = of(&["sinf", "cosf", "sqrtf", "tanhf"], "float") + &of(&["sin", "cos", "sqrt", "tanh"], "double");
    let fused = "float fmaf(float, float, float);\ndouble fma(double, double, double);\n";
    std::fs::write(folder.join("math.h"), header + fused).unwrap();
    let undefined = |name: &str, number: &str| {
        let options = "--target=thumbv7em-none-eabihf -mcpu=cortex-m4 -mfloat-abi=hard -std=c99 -ffreestanding -I. -Werror -O2 -c";
        let upper = name.to_ascii_uppercase();
        done(&folder, "clang", &format!("{options} -D{upper}_REAL={number} -o object.o {name}.c"));
        let listed = done(&folder, nm, "-u object.o").out;
        listed.split_whitespace().filter(|word| *word != "U").map(str::to_string).collect::<Vec<_>>()
    };
    for m in &modules {
        write_c(&folder, m);
        let of_floats = ["sqrtf"];
        let of_memory = |name: &str| name.starts_with("__aeabi_mem");
        let called = undefined(&m.name, "float");
        let others: Vec<_> = called.iter().filter(|n| !of_floats.contains(&n.as_str()) && !of_memory(n)).collect();
        assert!(others.is_empty(), "{}: {others:?}", m.name);
        // A check of the test itself: the code for doubles calls such a routine, so the test can detect it.
        assert!(undefined(&m.name, "double").iter().any(|name| name == "__aeabi_dmul"), "{}", m.name);
    }
}

#[test]
fn sines_and_roots_of_floats_are_near_those_of_doubles() {
    let folder = folder("f32_sines");
    std::fs::write(folder.join("quotients.rs"), codegen::rust_file(&quotients(), "this test")).unwrap();
    let main = "#[allow(dead_code)]
mod quotients;
use quotients::Real;
fn main() {
    let (mut sines, mut roots) = (0.0_f64, 0.0_f64);
    for k in -2_000_000_i32..2_000_000 {
        let x = k as f32 * 0.00409;
        let (s, c) = Real::sin_cos(x);
        let (s64, c64) = (f64::from(x).sin(), f64::from(x).cos());
        sines = sines.max((f64::from(s) - s64).abs()).max((f64::from(c) - c64).abs());
        let y = (k as f32 * 1e-3).abs() + 1e-3;
        let root = f64::from(y).sqrt();
        roots = roots.max((f64::from(Real::sqrt(y)) - root).abs() / root);
    }
    assert!(Real::sin_cos(9000.0_f32).0.is_nan() && Real::sqrt(-1.0_f32).is_nan() && Real::sqrt(0.0_f32) == 0.0);
    println!(\"{sines:e} {roots:e}\");
}
";
    std::fs::write(folder.join("main.rs"), main).unwrap();
    done(&folder, "rustc", "--edition 2024 -C opt-level=1 -o program main.rs");
    let printed = run(&mut Command::new(folder.join("program"))).out;
    let numbers: Vec<f64> = printed.split_whitespace().map(|x| x.parse().unwrap()).collect();
    // The spacing of f32 numbers at 1 is 1.2e-7.
    assert!(numbers.len() == 2 && numbers[0] < 1e-7 && numbers[1] < 6.2e-8, "{printed}");
}
