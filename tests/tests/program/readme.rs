//! Tests that README.md, docs/tutorial.md, the how-tos with commands and docs/ur5/README.md show the output of the program.
//!
//! In a code block of the kind `console`, each line `$ rist ..` is run. The lines below it, up to the next such line or the end
//! of the block, are its output; a line `...` stands for any lines. The commands of the README run at the root of the repository.
//! The commands of the tutorial run in an empty folder with models/race.yaml and the files in its `yaml` blocks; the first line
//! of such a block has the name of the file, `# NAME: ..`. The commands of a how-to run at the root, or in a folder with the
//! files of the tutorial or of the how-to. `[exit code 1]` below an output states an exit code other than 0. In a block of the
//! kind `sh`, each command `rist ..` is run too, with sample files in place of the files of the reader.

use std::path::Path;

use tests::joint_log::{swinging, unlike};
use tests::program::{done, folder, rist, rist_in_pipe, run};
use tests::{fenced, model_path, text_of, workspace};

/// Each command in the `console` blocks of a text, with the lines of its output.
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

/// Whether the lines of an output equal the shown lines. A line `...` stands for any number of lines.
fn matches(shown: &[String], lines: &[&str]) -> bool {
    match shown.split_first() {
        None => lines.is_empty(),
        Some((first, rest)) if first == "..." => (0..=lines.len()).any(|skip| matches(rest, &lines[skip..])),
        Some((first, rest)) => lines.first() == Some(&first.as_str()) && matches(rest, &lines[1..]),
    }
}

/// For each command `rist ..` in blocks of the kind `sh`: its arguments without the comment, and whether the comment mentions
/// exit code 1.
fn shell_commands(text: &str) -> Vec<(Vec<String>, bool)> {
    let lines = fenced(text, "```sh").into_iter().filter_map(|line| line.strip_prefix("rist "));
    let words = |line: &str| {
        let (command, comment) = line.split_once('#').unwrap_or((line, ""));
        (command.split_whitespace().map(str::to_string).collect(), comment.contains("exit code 1"))
    };
    lines.map(words).collect()
}

/// Runs the `sh` commands of a page in a folder with sample files. `stand_ins`: names and texts of these files.
fn shell_commands_run(page: &str, stand_ins: &[(&str, &str)]) {
    let here = folder(&format!("{}_shell", page.replace('/', "_")));
    stand_ins.iter().for_each(|(name, text)| std::fs::write(here.join(name), text).unwrap());
    let commands = shell_commands(&text_of(page));
    assert!(!commands.is_empty(), "{page} shows no `rist` in a block of the kind sh");
    for (arguments, may_be_no) in commands {
        // The log of the previous motion is kept as first.csv, because the next command overwrites it.
        let (log, first) = (here.join("logs/motion.csv"), here.join("first.csv"));
        if log.is_file() && !first.exists() {
            std::fs::copy(log, first).unwrap();
        }
        let run = rist(&here, &arguments.iter().map(String::as_str).collect::<Vec<_>>());
        let is_no = may_be_no && run.code == Some(1);
        assert!(is_no || run.code == Some(0), "{page}: rist {}: {:?} {}", arguments.join(" "), run.code, run.err);
    }
}

/// The names and texts of the files in blocks of the kind `yaml`.
fn files(text: &str) -> Vec<(String, String)> {
    let blocks = text.split("```yaml\n").skip(1).filter_map(|rest| Some(rest.split_once("```")?.0));
    let named = |block: &str| {
        let name = block.strip_prefix("# ").and_then(|line| Some(line.split_once(':')?.0));
        (name.unwrap_or_else(|| panic!("a yaml block begins with `# NAME: `, not with\n{block}")).into(), block.into())
    };
    blocks.map(named).collect()
}

/// Runs the `console` commands of a page in a folder, and compares their output with the page.
fn holds(page: &str, folder: &Path) {
    let text = text_of(page);
    let transcripts = transcripts(&text);
    assert!(!transcripts.is_empty(), "{page} shows no `$ rist` in a console block");
    // The commands of the pages write into the folder `target`. It does not exist if CARGO_TARGET_DIR is another folder.
    std::fs::create_dir_all(folder.join("target")).unwrap();
    for (arguments, shown) in transcripts {
        let run = rist_in_pipe(folder, &arguments.split_whitespace().collect::<Vec<_>>());
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

/// The sentences of a page outside of code, without Markdown marks. List items and table rows end a sentence.
fn sentences(text: &str) -> Vec<String> {
    let mut paragraphs = vec![String::new()];
    for (k, block) in text.split("```").enumerate() {
        for line in block.lines().filter(|_| k % 2 == 0) {
            let is_new = line.trim().is_empty() || line.starts_with(['-', '|', '#', '<']);
            if is_new {
                paragraphs.push(String::new());
            }
            if !line.starts_with('<') {
                let last = paragraphs.last_mut().expect("there is always one");
                last.push(' ');
                last.push_str(line.trim_start_matches(['-', '#', '|', ' ']));
            }
        }
    }
    let ends =
        |text: &str| text.replace("? ", "?\n").replace(". ", ".\n").replace(".** ", ".**\n").replace("! ", "!\n");
    let without_targets = |text: &str| -> String {
        text.split("](")
            .enumerate()
            .map(|(i, part)| if i == 0 { part } else { part.split_once(')').map_or("", |p| p.1) })
            .collect()
    };
    let all = paragraphs.iter().map(|text| ends(&without_targets(text))).collect::<Vec<_>>().join("\n");
    all.lines().map(str::trim).filter(|line| !line.is_empty()).map(String::from).collect()
}

#[test]
fn a_sentence_ends_where_it_ends() {
    let text = "One two. Three\n[four five](six.md)? Seven\n- eight\n```sh\nrun. it\n```\n";
    assert_eq!(sentences(text), ["One two.", "Three [four five?", "Seven", "eight"]);
}

/// The README must be short: sentences of at most 30 words, at most 150 lines, and the headings in this order.
#[test]
fn the_readme_is_short() {
    let text = text_of("README.md");
    let sentences = sentences(&text);
    assert!(sentences.len() > 30, "{sentences:#?}");
    for sentence in &sentences {
        let words = sentence.split_whitespace().filter(|word| word.contains(char::is_alphanumeric)).count();
        assert!(words <= 30, "{words} words: {sentence}");
    }
    assert!(text.lines().count() <= 150, "{} lines", text.lines().count());
    let place = |heading: &str| text.find(heading).unwrap_or_else(|| panic!("no `{heading}`"));
    let headings = ["## What you get", "## What you need", "## Install", "## A walk", "## Can you believe it?"];
    assert!(headings.map(place).is_sorted());
}

#[test]
fn the_figures_of_the_readme_are_those_of_the_pages() {
    let cells = |page: &str, start: &str| -> Vec<String> {
        let text = text_of(page);
        let row = text.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{page}: no row {start}"));
        row.trim_matches('|').split('|').map(|cell| cell.trim().to_string()).collect()
    };
    let readme = text_of("README.md").split_whitespace().collect::<Vec<_>>().join(" ");
    let holds = |sentence: String| assert!(readme.contains(&sentence), "README.md has no `{sentence}`");
    let all = cells("docs/what-trust-means.md", "| all |");
    let first = |cell: &str| cell.split([',', ' ']).next().unwrap_or_default().to_string();
    holds(format!("we simulated {} situations", all[1]));
    holds(format!("The verdict was \"yes\" {} times", first(&all[2])));
    holds(format!("In {} of these, predicted torques of another motion are wrong by more than 5 %", first(&all[3])));
    holds(format!("in {} of them also in the units of the log", first(&all[4])));
    holds(format!("In {}, a parameter is wrong by more than five sigma", first(&all[5])));
    let held = cells("docs/benchmarks.md", "| 95 % intervals cover");
    holds(format!("{} of the 95 % intervals contain the true value", held[1]));
    // For measured robots, the README states the smallest and the largest error of the rows that its picture shows.
    let sets = ["| Panda,", "| TX40,", "| UR10e, id_30s -> id_40s", "| cobot6,", "| KR300,"];
    let errors = sets.map(|set| {
        let cells = cells("docs/identification.md", set);
        let [baseline, ours] = [1, 3].map(|k| cells[k].parse::<f64>().unwrap_or_else(|e| panic!("{set}: {e}")));
        assert!(ours <= baseline, "{set}: README says that none is worse");
        100.0 * ours
    });
    let (least, greatest) = errors.iter().fold((f64::MAX, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
    holds(format!("another motion is predicted with {least:.1} to {greatest:.0} % error"));
}

/// Compiles the Rust lines of the README; the lines below must be identical to them.
fn lines_of_the_readme() -> Result<(), rist::Error> {
    let model = rist::Model::read("robot.urdf")?;
    println!("{}", model.parameters.rule_lines().join("\n"));
    Ok(())
}

#[test]
fn the_lines_of_rust_compile() {
    let text = text_of("README.md");
    let block = text.split("```rust\n").nth(1).and_then(|rest| rest.split("```").next()).expect("lines of Rust");
    let own = include_str!("readme.rs");
    assert_eq!(block.lines().count(), 2);
    assert!(block.lines().all(|line| own.contains(line)), "{block}");
    // The compiled lines read the file robot.urdf. It does not exist here, so they fail.
    assert!(lines_of_the_readme().is_err());
}

/// The README says that ten seconds of a log at 100 Hz are enough. Tested with every other row of a log at 200 Hz.
#[test]
fn a_log_at_a_hundred_hertz_is_enough() {
    let here = folder("hundred_hertz");
    for name in ["log.csv", "other.csv"] {
        let text = std::fs::read_to_string(workspace().join("docs/ur5").join(name)).unwrap();
        let rows: Vec<&str> =
            text.lines().enumerate().filter(|(k, _)| *k == 0 || k % 2 == 1).map(|(_, row)| row).collect();
        assert!(rows.len() < 1000, "less than ten seconds");
        std::fs::write(here.join(name), rows.join("\n") + "\n").unwrap();
    }
    let ur5 = model_path("ur5.urdf").display().to_string();
    rist(&here, &["identify", &ur5, "log.csv", "--validate", "other.csv"])
        .told(0, &["\ntrust: yes\n", "median step 0.01 s"]);
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

fn files_of(page: &str) -> Vec<(String, String)> {
    files(&text_of(page))
}

fn write_files(page: &str, here: &Path) {
    let files = files_of(page);
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
fn the_page_on_contact_and_load_holds() {
    holds("docs/how-to/watch-a-robot.md", &folder("watch_a_robot"));
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
fn the_commands_of_shell_blocks_run() {
    let urdf = text_of("models/ur5.urdf");
    // The log is from a robot without a load, because bodies that differ much from the description would not be written.
    let here = folder("shell_stand_in");
    let robot = rist::Model::read(model_path("ur5.urdf")).unwrap().robot;
    let names: Vec<String> = robot.coordinates.iter().map(|c| c.name.clone()).collect();
    swinging(&robot, &unlike(&robot, 1), 1.2, 0.0).write(&here.join("log.csv"), &names);
    let log = std::fs::read_to_string(here.join("log.csv")).unwrap();
    // The format of a log is recognised from its content, not from its name.
    let files =
        [("robot.urdf", urdf.as_str()), ("log.csv", &log), ("log.mcap", &log), ("options.yaml", "weights: huber\n")];
    shell_commands_run("README.md", &files);
    shell_commands_run("docs/how-to/find-what-is-wrong-with-a-log.md", &files);

    let ball = r#"<collision><geometry><sphere radius="0.05"/></geometry></collision>"#;
    let with_bodies = urdf.replace("</inertial>", &format!("</inertial>{ball}"));
    let with_tool = with_bodies.replace(r#"<link name="tool0"/>"#, &format!(r#"<link name="tool0">{ball}</link>"#));
    assert!(with_tool.len() > with_bodies.len() && with_bodies.len() > urdf.len());
    let page = "docs/how-to/find-a-motion.md";
    let (_, limits) = files_of(page).into_iter().find(|(name, _)| name == "limits.yaml").expect("it holds limits");
    shell_commands_run(
        page,
        &[("arm.urdf", &with_tool), ("limits.yaml", &limits), ("options.yaml", "covariance: true\n")],
    );
}

#[test]
fn the_transcript_of_the_fleet_is_what_rist_prints() {
    let here = folder("fleet_page");
    write_files("docs/tutorial.md", &here);
    write_files("docs/how-to/fleet.md", &here);
    holds("docs/how-to/fleet.md", &here);
}

/// The commands of the page on control loops run, and a C compiler accepts their output. Both generated files contain the numbers
/// of the estimate.
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
    done(&here, "cc", "-std=c99 -Wall -Wextra -Werror -pedantic -c arm.c -o arm.o");

    // Runs the Rust lines of the page at one state. The torques must agree within 5 % with `rist evaluate`, which uses the
    // nominal parameters. The estimate comes from a simulation with these parameters.
    let page = text_of("docs/how-to/code-for-a-control-loop.md");
    let lines = page.split("```rust\n").nth(1).and_then(|rest| rest.split("```").next()).expect("lines of Rust");
    let states = "let (q, dq, ddq_wanted) = ([0.4, -0.3], [0.5, 0.2], [1.0, 2.0]);";
    let program = format!("mod arm;\nfn main() {{\n{states}\n{lines}println!(\"{{}} {{}}\", tau[0], tau[1]);\n}}\n");
    std::fs::write(here.join("main.rs"), program).unwrap();
    done(&here, "rustc", "--edition 2024 main.rs");
    let ran = run(&mut std::process::Command::new(here.join("main")));
    std::fs::write(here.join("states.csv"), "q_q1,q_q2,dq_q1,dq_q2,ddq_q1,ddq_q2\n0.4,-0.3,0.5,0.2,1,2\n").unwrap();
    let expected = rist(&here, &["evaluate", "arm.yaml", "states.csv", "--quantity", "torque"]).out;
    let numbers = |text: &str| text.split([' ', ',', '\n']).filter_map(|x| x.parse().ok()).collect::<Vec<f64>>();
    let (found, expected) = (numbers(&ran.out), numbers(&expected));
    assert_eq!((found.len(), expected.len()), (2, 2));
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found - expected).abs() < 0.05 * expected.abs(), "{found} {expected}");
    }
}

/// The commands of the page on packages write folders, and a compiler accepts the C code of both.
#[test]
fn the_page_on_packages_runs() {
    let here = folder("packages_page");
    holds("docs/how-to/run-on-the-robot.md", &here);
    for folder in ["ur5_ros/src", "ur5_can/ur5_urdf"] {
        for source in ["ur5_urdf", "ur5_urdf_step"] {
            done(
                &here.join(folder),
                "cc",
                &format!("-std=c99 -Wall -Wextra -Werror -pedantic -c {source}.c -o {source}.o"),
            );
        }
    }
}

#[test]
fn the_transcript_of_the_tutorial_is_what_rist_prints() {
    let here = folder("tutorial");
    let page = "docs/tutorial.md";
    write_files(page, &here);
    std::fs::copy(model_path("race.yaml"), here.join("race.yaml")).expect("models/race.yaml is there");
    holds(page, &here);
}

/// The commands of the page on formulas run, and the Rust and C compilers accept their output.
#[test]
fn the_page_on_formulas_runs() {
    let here = folder("formula_page");
    write_files("docs/tutorial.md", &here);
    std::fs::copy(model_path("rx90.yaml"), here.join("rx90.yaml")).expect("models/rx90.yaml is there");
    holds("docs/how-to/from-a-robot-to-a-formula.md", &here);
    done(&here, "rustc", "--edition 2024 --crate-type lib arm_open.rs");
    done(&here, "cc", "-std=c99 -Wall -Wextra -Werror -pedantic -c arm_open.c -o arm_open.o");
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
