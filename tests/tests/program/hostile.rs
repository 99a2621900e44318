//! Tests that files without end, and files that would need a very long time, are refused with a message, in bounded memory.
use std::path::Path;
use std::process::Command;

use tests::model_path;
use tests::program::{LIMITED_ARM, Run, folder, program, rist, run};

/// Limit of the address space of a run, KiB. The program and its threads map about 300 MiB for any input.
const SPACE: usize = 1 << 20;

/// Runs the program with limited memory, so that an endless input does not use all memory of the machine.
fn bounded(folder: &Path, arguments: &[&str]) -> Run {
    let mut shell = Command::new("sh");
    shell.arg("-c").arg(format!("ulimit -v {SPACE}; exec \"$@\"")).arg("sh").arg(program()).args(arguments);
    run(shell.current_dir(folder))
}

#[test]
fn files_without_end_are_refused() {
    let here = folder("hostile-endless");
    let planar = model_path("planar2r_vertical.yaml");
    let planar = planar.to_str().unwrap();
    std::fs::write(here.join("log.csv"), "t,q1,q2,tau1,tau2\n0,0,0,0,0\n").unwrap();
    std::os::unix::fs::symlink("/dev/zero", here.join("endless.yaml")).unwrap();
    let commands: [&[&str]; 8] = [
        &["merge", "/dev/zero", "--out", "x.tri"],
        &["inspect", "endless.yaml"],
        &["identify", planar, "/dev/zero"],
        &["identify", planar, "log.csv", "--options", "endless.yaml"],
        &["validate", planar, "endless.yaml", "log.csv"],
        &["simulate", planar, "endless.yaml", "--out", "logs"],
        &["report", "--estimate", "endless.yaml", "--out", "report.html"],
        &["check", planar, "endless.yaml"],
    ];
    for command in commands {
        let run = bounded(&here, command).ended(2);
        let says_why =
            ["larger than 16 MiB", "binary file", "no sums of rist accumulate"].iter().any(|why| run.err.contains(why));
        assert!(says_why, "{command:?}: {}", run.err);
    }
}

/// Small files that claim to contain strings of 4 GiB must be refused. The process must not end because memory cannot be
/// allocated.
#[test]
fn strings_of_a_recording_are_not_believed() {
    let here = folder("hostile-claims");
    let planar = model_path("planar2r_vertical.yaml");
    let claims: [&[u8]; 3] = [
        b"\x03\x06\0\0\0\0\0\0\0\x01\0\xff\xff\xff\xff",
        b"\x04\x08\0\0\0\0\0\0\0\x01\0\x01\0\xff\xff\xff\xff",
        b"\x06\x20\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\xff\xff\xff\xff",
    ];
    for record in claims {
        std::fs::write(here.join("claim.mcap"), [b"\x89MCAP0\r\n", record].concat()).unwrap();
        bounded(&here, &["doctor", planar.to_str().unwrap(), "claim.mcap"])
            .failed(2, &["4294967295 bytes are claimed"]);
    }
}

/// If the input is a pipe, the message has no excerpt of the faulty line. For an excerpt the file would be opened again, and a
/// pipe without a writer would block forever.
#[test]
fn a_fault_in_a_pipe_is_told() {
    let here = folder("hostile-pipe");
    let text = "(printf 'convention: khalil-kleinfinger\nnam: x\n' > f.yaml &); exec timeout 20 \"$0\" inspect f.yaml";
    let made = Command::new("mkfifo").arg(here.join("f.yaml")).status().unwrap();
    assert!(made.success());
    let mut shell = Command::new("sh");
    shell.arg("-c").arg(text).arg(program());
    run(shell.current_dir(&here)).failed(2, &["f.yaml:2"]);
}

/// Control characters in file names are escaped in messages, so that a terminal does not interpret them.
#[test]
fn names_are_shown_as_what_they_are() {
    let here = folder("hostile-names");
    bounded(&here, &["inspect", "a\u{1b}]0;x\u{202e}.yaml", "--color", "always"])
        .failed(2, &["a\\u{1b}]0;x\\u{202e}.yaml"]);
}

#[test]
fn an_element_of_countless_attributes_is_refused_where_it_stands() {
    let here = folder("hostile-attributes");
    let attributes: String = (0..100_000).map(|k| format!(" a{k}=\"1\"")).collect();
    std::fs::write(here.join("crowded.urdf"), format!("<robot name=\"r\">\n<link{attributes}/></robot>")).unwrap();
    let run = bounded(&here, &["inspect", "crowded.urdf"]).ended(2);
    let lines: Vec<&str> = run.err.lines().collect();
    let [message, excerpt] = lines[..] else { panic!("{}", run.err) };
    assert_eq!(message, "rist: crowded.urdf:2: <link> has more than 256 attributes: no element of a URDF has");
    assert!(excerpt.starts_with(" 2 | <link a0=\"1\"") && excerpt.len() < 120, "{excerpt}");
}

/// A robot whose names contain control sequences, HTML, Markdown and line breaks.
fn odd_names() -> String {
    let head = "name: \"r\\e[31m\"\nsource: \"<script>alert(1)</script> \\u202E\"";
    let arm = LIMITED_ARM.replace("name: arm\n", &format!("{head}\n"));
    arm.replace("upper arm", "\"<img src=x>|[a](javascript:b)\\u202E\"").replace("name: forearm", "name: \"b\\nc\"")
}

#[test]
fn no_name_is_a_command_or_markup() {
    let here = folder("hostile-markup");
    std::fs::write(here.join("odd.yaml"), odd_names()).unwrap();
    let hidden = |text: &str| text.chars().any(|c| c != '\n' && rist::gate::shown::is_hidden(c));
    for format in ["text", "markdown", "latex", "html", "json"] {
        let run = bounded(&here, &["inspect", "odd.yaml", "--format", format]).ended(0);
        assert!(!hidden(&run.out) && !hidden(&run.err), "{format}: {:?}", run.out);
    }
    let run = bounded(&here, &["inspect", "odd.yaml", "--format", "markdown"]);
    assert!(!run.out.contains("<script") && !run.out.contains("<img") && !run.out.contains("[a]("), "{}", run.out);
    // Each row of the table of links must have seven cells, also if a name contains a vertical bar.
    let cells = |line: &str| line.replace("\\|", "").matches('|').count();
    let table: Vec<&str> = run.out.lines().skip_while(|line| !line.starts_with("| link |")).take(4).collect();
    assert!(table.iter().all(|line| cells(line) == 8), "{table:?}");
    for (language, file) in [("rust", "odd.rs"), ("c", "odd.c")] {
        bounded(&here, &["generate", "odd.yaml", "--language", language, "--out", file]).ended(0);
        assert!(!hidden(&std::fs::read_to_string(here.join(file)).unwrap()), "{file}");
    }
}

/// The name of a joint contains a comma or quotes. The program must be able to read the files that it writes.
#[test]
fn a_comma_in_a_name_stays_in_its_cell() {
    let here = folder("hostile-comma");
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/><origin xyz=\"0.3 0 0\"/>\
             <axis xyz=\"0 1 0\"/><limit lower=\"-2\" upper=\"2\" effort=\"100\" velocity=\"5\"/></joint>"
        )
    };
    let link = |name: &str| {
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0.1 0 0\"/><mass value=\"2\"/>\
             <inertia ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\"/></inertial></link>"
        )
    };
    let text = format!(
        "<robot name=\"r\"><link name=\"base\"/>{}{}{}{}</robot>",
        link("l1"),
        link("l2"),
        joint("j,1", "base", "l1"),
        joint("a/b &quot;2&quot;", "l1", "l2")
    );
    std::fs::write(here.join("comma.urdf"), text).unwrap();
    let states = "\"q_j,1\",\"q_a/b \"\"2\"\"\"\n0.1,0.2\n";
    std::fs::write(here.join("states.csv"), states).unwrap();
    let run = bounded(&here, &["evaluate", "comma.urdf", "states.csv", "--quantity", "torque"]);
    assert!(
        run.code == Some(0) && run.out.starts_with("\"tau_j,1\",\"tau_a/b \"\"2\"\"\"\n"),
        "{}{}",
        run.out,
        run.err
    );
    for command in [
        &["excite", "comma.urdf", "--out", "motion.yaml", "--play", "play.csv"][..],
        &["simulate", "comma.urdf", "motion.yaml", "--out", "logs"],
        &["identify", "comma.urdf", "logs/motion.csv", "--anyway", "--out", "estimate.yaml", "--series", "series.csv"],
        &["report", "--model", "comma.urdf", "--motion", "motion.yaml", "--out", "page.html", "--svg", "pictures"],
    ] {
        let run = rist(&here, command);
        assert!(matches!(run.code, Some(0 | 1)) && !run.err.contains("no columns"), "{command:?}: {}", run.err);
    }
    for file in ["play.csv", "series.csv"] {
        let head = std::fs::read_to_string(here.join(file)).unwrap().lines().next().unwrap().to_string();
        assert!(head.contains("_j,1\""), "{file}: {head}");
    }
    let names = std::fs::read_dir(here.join("pictures")).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(names.count() > 2);
}

/// If another program overwrites a log while it is read, the log is refused, because the data would be a mixture of two logs.
#[test]
fn a_log_that_is_written_over_is_refused() {
    let here = folder("hostile-overwritten");
    let planar = model_path("planar2r_vertical.yaml");
    let rows = |shift: f64| {
        let row = |k: u32| {
            let t = 0.001 * f64::from(k);
            format!("{t:.3},{:.6},{:.6},{:.6},1\n", (t + shift).sin(), (2.0 * t).sin(), shift + t.cos())
        };
        "t,q1,q2,tau1,tau2\n".to_string() + &(0..40_000).map(row).collect::<String>()
    };
    let (old, new) = (rows(0.0), rows(1.0));
    let place = here.join("log.csv");
    std::fs::write(&place, &old).unwrap();
    let long_ago = std::time::SystemTime::now() - std::time::Duration::from_secs(100);
    std::fs::File::options().write(true).open(&place).unwrap().set_modified(long_ago).unwrap();
    // Reads the first half, overwrites the file, then reads the rest.
    let mut source = rist::gate::source::Source::open(&place).unwrap();
    let mut half = vec![0; old.len() / 2];
    std::io::Read::read_exact(&mut source, &mut half).unwrap();
    std::fs::write(&place, &new).unwrap();
    let message = std::io::Read::read_to_end(&mut source, &mut half).unwrap_err().to_string();
    assert!(message.contains("written over while it was read"), "{message}");
    let run = bounded(&here, &["doctor", planar.to_str().unwrap(), "log.csv"]);
    assert!(!run.err.contains("written over"), "{}", run.err);
}

/// docs/files.md promises: an estimate that was changed is refused, or the output says that it was changed.
#[test]
fn an_estimate_that_was_changed_is_refused_or_says_so() {
    let here = folder("hostile-estimate");
    std::fs::write(here.join("arm.yaml"), LIMITED_ARM).unwrap();
    for step in [
        &["excite", "arm.yaml", "--starts", "1", "--rate", "100", "--out", "motion.yaml"][..],
        &["simulate", "arm.yaml", "motion.yaml", "--out", "logs"],
        &["identify", "arm.yaml", "logs/motion.csv", "--out", "estimate.yaml"],
    ] {
        let run = rist(&here, step);
        assert!(matches!(run.code, Some(0 | 1)), "{step:?}: {}", run.err);
    }
    let text = std::fs::read_to_string(here.join("estimate.yaml")).unwrap();
    let said = |text: &str| match rist::Estimate::from_yaml("estimate.yaml", text) {
        Ok(estimate) => estimate.to_string(),
        Err(e) => e.to_string(),
    };
    assert!(!said(&text).contains("changed after rist wrote it"));
    let changed = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}: {text}");
        said(&text.replacen(from, to, 1))
    };
    assert!(changed("sigma: ", "sigma: -").contains("is negative"));
    assert!(changed("value: ", "value: 1").contains("changed after rist wrote it"));
    let start = text.find("\n- name: ").unwrap() + 1;
    let end = start + text[start..].find("\n- name: ").unwrap() + 1;
    let twice = text.replacen(&text[start..end], &text[start..end].repeat(2), 1);
    let count = |line: &str| line.strip_prefix("parameter_count: ").and_then(|n| n.parse::<usize>().ok());
    let n = twice.lines().find_map(count).unwrap();
    let twice = twice.replace(&format!("parameter_count: {n}"), &format!("parameter_count: {}", n + 1));
    assert!(said(&twice).contains("stands twice among the parameters"), "{}", said(&twice));
    let without = text.lines().filter(|line| !line.starts_with("doubts:")).collect::<Vec<_>>().join("\n") + "\n";
    assert!(without == text || said(&without).contains("changed after rist wrote it"));
}

/// The proof of a motion divides a period into parts. If the period is shorter than a sample, this could take endless time, so
/// the motion is refused.
#[test]
fn a_period_without_a_sample_is_refused() {
    let here = folder("hostile-period");
    std::fs::write(here.join("arm.yaml"), LIMITED_ARM).unwrap();
    let made = ["excite", "arm.yaml", "--starts", "1", "--rate", "100", "--out", "motion.yaml"];
    assert_eq!(rist(&here, &made).code, Some(0));
    let text = std::fs::read_to_string(here.join("motion.yaml")).unwrap();
    let short = |line: &str| if line.starts_with("period_s:") { "period_s: 1e-300".into() } else { line.to_string() };
    std::fs::write(here.join("short.yaml"), text.lines().map(short).collect::<Vec<_>>().join("\n")).unwrap();

    bounded(&here, &["check", "arm.yaml", "short.yaml"]).failed(2, &["less than a sample at 100 Hz"]);
}
