//! Tests that generated files are reproducible byte by byte, compile alone without std, and contain no operation that can fail.
//! Code can be generated for any tree of joints, small or large.

use std::path::Path;

use robot::Robot;
use tests::program::{done, folder};
use tests::random::Random;
use tests::urdf_text::random_tree;
use tests::{derived, dot, evaluated, models, recursion};

fn generated(robot: &Robot) -> String {
    let module = modeling::module(robot, &[]).unwrap_or_else(|unclear| panic!("{}: {unclear}", robot.name));
    codegen::rust_file(&module, "this test")
}

/// Compiles the file with warnings as errors, as a library of its own or as a module of a crate without std (`root`).
fn compiles(folder: &Path, root: &str, text: &str) {
    std::fs::write(folder.join("x.rs"), text).unwrap();
    std::fs::write(folder.join("without_std.rs"), "#![no_std]\npub mod x;\n").unwrap();
    done(folder, "rustc", &format!("--crate-type lib --edition 2024 --emit=metadata -D warnings {root}"));
}

#[test]
fn the_same_robot_gives_the_same_bytes() {
    for (file, robot) in models() {
        assert!(generated(&robot) == generated(&tests::model(&file)), "{file}: two renderings differ");
    }
}

#[test]
fn a_generated_file_compiles_alone_without_std_and_without_a_warning() {
    let folder = folder("generation");
    for (_, robot) in models() {
        let text = generated(&robot);
        compiles(&folder, "x.rs", &text);
        compiles(&folder, "without_std.rs", &text);
    }
}

#[test]
fn nothing_in_a_generated_file_can_fail_or_allocate() {
    for (file, robot) in models() {
        // This line imports std to use fused multiply-add, if the target has an instruction for it.
        let of_std = |line: &str| line.trim() == "extern crate std;";
        // A `const` block can only fail at compile time.
        let of_compiler = |line: &str| line.trim_start().starts_with("const {");
        let code = |line: &&str| !line.trim_start().starts_with("//") && !of_std(line) && !of_compiler(line);
        for line in generated(&robot).lines().filter(code) {
            for word in
                ["unwrap", "expect", "panic", "assert", "alloc", "Vec", "Box", "vec!", "std::", "unsafe", "extern"]
            {
                assert!(!line.contains(word), "{file}: {line}");
            }
            // Each index must be a literal, which the compiler checks; calls of `set` have literals as indices.
            let handed_out = line.trim_start().strip_prefix("set(").map(|text| text.split(", ").take(3));
            if let Some(mut indices) = handed_out {
                assert!(indices.all(|word| word.chars().all(|c| c.is_ascii_digit())), "{file}: {line}");
            }
            for index in line.split('[').skip(1) {
                // If no `]` follows before the next `[`, it is a list and not an index.
                let Some((inside, _)) = index.split_once(']') else { continue };
                if ["entry", "row", "column"].contains(&inside) {
                    continue;
                }
                let literal = inside.chars().all(|c| c.is_ascii_digit());
                let type_or_list = inside.is_empty() || inside.contains([';', ',', '"', '(', ' ']) || inside == "R";
                assert!(literal || type_or_list || inside.contains("f64") || inside == "inline", "{file}: {line}");
            }
        }
    }
}

/// Reads a random tree of n joints, checks torques that are computed from its base regressor, and compiles the generated code.
fn goes_all_the_way(n: usize, reach: usize, seed: u64) {
    let text = random_tree(n, reach, seed);
    let robot = robot::format::read_urdf(&text, "tree.urdf").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(robot.n_coordinates(), n);
    let (_, regressor, base) = derived(&robot);
    let mut random = Random(seed);
    let (state, x) = (random.state(&robot), random.parameters(&robot));
    let y = evaluated(&base.regressor(&regressor), &[&state.inputs()]);
    let x_base = base.values(&x);
    for (row, tau) in y.chunks(base.len()).zip(recursion::torque(&robot, &state, &x)) {
        let (found, size) = dot(row, &x_base);
        // In a long arm the regrouping adds lengths over many links, which increases rounding.
        assert!((found - tau).abs() <= 1e-10 * (1.0 + size), "{n} joints: {found} {tau}");
    }
    compiles(&folder(&format!("tree_of_{n}")), "without_std.rs", &generated(&robot));
}

#[test]
fn any_tree_of_joints_is_generated() {
    for (n, reach, seed) in [(1, 1, 41), (30, 1, 42), (44, 6, 43)] {
        goes_all_the_way(n, reach, seed);
    }
}
