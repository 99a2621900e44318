//! Tests that the examples of the library run, and that the generated file in one of them equals the output of the generator.

use std::process::Command;

use rist::describe::source::Language;
use rist::generate;
use tests::{model, workspace};

/// Output of an example; panics if it fails. `cargo test --workspace` has usually built the examples already.
fn run(example: &str) -> String {
    let build = ["build", "--quiet", "--workspace", "--examples"];
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    assert!(cargo.args(build).current_dir(workspace()).status().unwrap().success());
    let deps = std::env::current_exe().unwrap();
    let program = deps.ancestors().nth(2).unwrap().join("examples").join(example);
    let out = Command::new(program).current_dir(workspace()).output().unwrap();
    assert!(out.status.success(), "{example}: {}", String::from_utf8_lossy(&out.stderr));
    String::from_utf8(out.stdout).unwrap()
}

#[test]
fn every_example_runs() {
    let expected = [
        ("inspect", "ZZR1 = ZZ1 + IA1 + L1^2*M2"),
        // The description has ZZ1 = 0.25 and MX1 = 0.5; the filter causes small errors at the ends of the log.
        ("identify_log", "ZZR1           0.2500"),
        ("identify_log", "MX1           0.49999"),
        ("computed_torque", "after 2 s the joints are at"),
        ("plan_and_validate", "race: 3 of 275 experiments"),
        ("convert_and_write_back", "name: ur5"),
        ("description_and_estimate", "<svg"),
    ];
    let folder = workspace().join("crates/rist/examples");
    let files = std::fs::read_dir(folder).unwrap().filter_map(|entry| entry.unwrap().file_name().into_string().ok());
    let names: Vec<String> = files.filter_map(|file| Some(file.strip_suffix(".rs")?.to_string())).collect();
    assert!(names.iter().all(|name| expected.iter().any(|(e, _)| e == name)), "{names:?}");
    for (example, text) in expected {
        let out = run(example);
        assert!(out.contains(text), "{example}: no `{text}` in {out}");
    }
}

#[test]
fn the_picture_of_the_readme_is_what_its_example_draws() {
    let picture = std::fs::read_to_string(workspace().join("docs/ur5/torque.svg")).unwrap();
    assert!(run("description_and_estimate") == picture, "docs/ur5/torque.svg is stale: draw it again");
}

#[test]
fn the_generated_file_of_an_example_is_up_to_date() {
    let functions = ["inverse-dynamics".to_string(), "forward-dynamics".to_string()];
    let made_by =
        "rist generate models/planar2r_vertical.yaml --functions inverse-dynamics,forward-dynamics".to_string();
    let source =
        generate(&model("planar2r_vertical.yaml"), &functions, &Language::Rust, &made_by, None, &[], false).unwrap();
    let file = workspace().join("crates/rist/examples/computed_torque/arm.rs");
    let found = std::fs::read_to_string(&file).unwrap();
    assert!(found == source.text, "{} is stale: run `{made_by} --out {}`", file.display(), file.display());
}
