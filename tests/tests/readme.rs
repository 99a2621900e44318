//! README.md, docs/tutorial.md, the how-tos with commands and docs/ur5/README.md show what the program prints.
//!
//! In a block of the kind `console`, a line `$ rist ..` is run, and the lines below it, to the next such line or the
//! end of the block, are its output; `...` alone on a line stands for any lines. The README's commands run at the
//! root of the repository. The tutorial's run in an empty folder, with the files that its blocks of the kind `yaml`
//! hold under the name in their first line, `# NAME: ..`, and with models/race.yaml; those of a how-to there too, or in a
//! folder with the files of the tutorial or its own. `[exit code 1]` below an output is the exit code where it is not 0.

use std::path::Path;

use tests::program::{folder, rist};
use tests::{model_path, workspace};

/// Command and output, of each command of the text.
fn transcripts(text: &str) -> Vec<(String, Vec<String>)> {
    let mut found: Vec<(String, Vec<String>)> = Vec::new();
    let mut inside = false;
    for line in text.lines() {
        match (inside, line.strip_prefix("$ rist ")) {
            (false, _) => inside = line == "```console",
            (true, _) if line == "```" => inside = false,
            (true, Some(arguments)) => found.push((arguments.to_string(), Vec::new())),
            (true, None) => match found.last_mut() {
                Some((_, output)) => output.push(line.trim_end().to_string()),
                None => panic!("a console block begins with `$ rist`, not with `{line}`"),
            },
        }
    }
    found
}

/// Whether the lines are the shown ones, `...` any number of them.
fn matches(shown: &[String], lines: &[&str]) -> bool {
    match shown.split_first() {
        None => lines.is_empty(),
        Some((first, rest)) if first == "..." => (0..=lines.len()).any(|skip| matches(rest, &lines[skip..])),
        Some((first, rest)) => lines.first() == Some(&first.as_str()) && matches(rest, &lines[1..]),
    }
}

/// The files that blocks of the kind `yaml` hold: name and text.
fn files(text: &str) -> Vec<(String, String)> {
    let blocks = text.split("```yaml\n").skip(1).filter_map(|rest| Some(rest.split_once("```")?.0));
    let named = |block: &str| {
        let name = block.strip_prefix("# ").and_then(|line| Some(line.split_once(':')?.0));
        (name.unwrap_or_else(|| panic!("a yaml block begins with `# NAME: `, not with\n{block}")).into(), block.into())
    };
    blocks.map(named).collect()
}

/// Runs the commands that a page shows, in this folder.
fn holds(page: &str, folder: &Path) {
    let text = std::fs::read_to_string(workspace().join(page)).unwrap_or_else(|e| panic!("{page}: {e}"));
    let transcripts = transcripts(&text);
    assert!(!transcripts.is_empty(), "{page} shows no `$ rist` in a console block");
    for (arguments, shown) in transcripts {
        let run = rist(folder, &arguments.split_whitespace().collect::<Vec<_>>());
        let lines: Vec<&str> = run.out.lines().map(str::trim_end).collect();
        let (shown, code) = match shown.split_last() {
            Some((last, rest)) if last == "[exit code 1]" => (rest, 1),
            _ => (shown.as_slice(), 0),
        };
        assert_eq!(run.code, Some(code), "rist {arguments}: {}", run.err);
        let found = lines.join("\n");
        assert!(matches(shown, &lines), "$ rist {arguments}\n{page}:\n{}\nfound:\n{found}", shown.join("\n"));
    }
}

#[test]
fn the_transcript_of_the_readme_is_what_rist_prints() {
    holds("README.md", &workspace());
}

#[test]
fn the_logs_that_ship_are_what_the_simulator_writes() {
    holds("docs/ur5/README.md", &workspace());
    for (made, ships) in [("target/ur5_log", "log.csv"), ("target/ur5_other", "other.csv")] {
        let [made, ships] =
            [workspace().join(made).join("motion_loaded.csv"), workspace().join("docs/ur5").join(ships)];
        let [made, text] = [&made, &ships].map(|file| std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{e}")));
        assert!(made == text, "{} is not what `rist simulate` writes", ships.display());
    }
}

/// Writes the files of a page into a folder.
fn write_files(page: &str, here: &Path) {
    let files = files(&std::fs::read_to_string(workspace().join(page)).unwrap_or_else(|e| panic!("{page}: {e}")));
    assert!(!files.is_empty(), "{page} holds no file");
    for (name, text) in files {
        std::fs::write(here.join(&name), text).unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

#[test]
fn the_pages_that_run_at_the_root_hold() {
    holds("docs/how-to/start-from-a-urdf.md", &workspace());
    holds("docs/how-to/identify-a-payload.md", &workspace());
}

#[test]
fn the_pages_that_run_in_a_folder_hold() {
    for (page, files_of) in [
        ("docs/how-to/units-and-gains.md", "docs/tutorial.md"),
        ("docs/how-to/describe-a-robot-with-loops.md", "docs/how-to/describe-a-robot-with-loops.md"),
    ] {
        let here = folder(&page.replace('/', "_"));
        write_files(files_of, &here);
        holds(page, &here);
    }
}

#[test]
fn the_transcript_of_the_fleet_is_what_rist_prints() {
    let here = folder("fleet_page");
    write_files("docs/tutorial.md", &here);
    write_files("docs/how-to/fleet.md", &here);
    holds("docs/how-to/fleet.md", &here);
}

/// The commands run, and a C compiler takes what they write; the numbers of the estimate stand in both files.
#[test]
fn the_page_on_code_for_a_loop_runs() {
    let here = folder("code_page");
    write_files("docs/tutorial.md", &here);
    holds("docs/how-to/code-for-a-control-loop.md", &here);
    let text = |file: &str| std::fs::read_to_string(here.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
    let estimate = rist::Estimate::from_yaml("samples.yaml", &text("samples.yaml")).unwrap();
    let (rust, c) = (text("arm.rs"), text("arm.c"));
    assert!(rust.contains("pub const X: [f64; 7] = [") && c.contains("const arm_real arm_x[7] = {"));
    assert!(rust.contains("pub const F: [f64; 6] = [") && c.contains("const arm_real arm_f[6] = {"));
    assert!(estimate.parameters.len() >= 13);
    for parameter in &estimate.parameters {
        let written = format!("{:?}", parameter.value.expect("everything is seen"));
        assert!(rust.contains(&written) && c.contains(&written), "{}: {written}", parameter.id);
    }
    let compiled = std::process::Command::new("cc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-c", "arm.c", "-o", "arm.o"])
        .current_dir(&here)
        .output()
        .expect("a C compiler is there");
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
}

#[test]
fn the_transcript_of_the_tutorial_is_what_rist_prints() {
    let here = folder("tutorial");
    let page = "docs/tutorial.md";
    write_files(page, &here);
    std::fs::copy(model_path("race.yaml"), here.join("race.yaml")).expect("models/race.yaml is there");
    holds(page, &here);
}

#[test]
fn a_transcript_is_compared_line_by_line() {
    let text = "x\n```console\n$ rist a b\none\n...\nfour\n$ rist c\n```\n$ rist no\n";
    let found = transcripts(text);
    assert_eq!(found.len(), 2);
    assert_eq!((found[0].0.as_str(), found[1].0.as_str()), ("a b", "c"));
    let shown = &found[0].1;
    assert!(matches(shown, &["one", "two", "three", "four"]) && matches(shown, &["one", "four"]));
    assert!(!matches(shown, &["one", "two"]) && !matches(shown, &["two", "four"]) && matches(&found[1].1, &[]));
}
