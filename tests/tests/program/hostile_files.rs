//! Snapshot test of hostile files from security tests: each is read, or refused with a message. No run of the program ends in a
//! panic, by a signal or by a timeout. The memory of each run stays within a bound that depends on the file size.
use tests::files_below;
use tests::hostile::{command, hardening};
use tests::mutation::{bounded, broken};
use tests::program::{folder, program};
use tests::snapshot::assert_snapshot;

#[test]
fn each_file_is_read_refused_or_said() {
    let Some(all) = hardening() else { return };
    let here = folder("hostile-files");
    let (robot, motion) = (all.join("tamper/p2.yaml"), all.join("tamper/m.yaml"));
    let (robot, motion) = (robot.display().to_string(), motion.display().to_string());
    let (mut told, mut beyond) = (String::new(), Vec::new());
    for path in files_below(&all) {
        let name = path.strip_prefix(&all).unwrap().display().to_string();
        let bytes = std::fs::read(&path).unwrap();
        let shown = path.display().to_string();
        let Some(words) = command(&path, &String::from_utf8_lossy(&bytes), &robot, &motion) else {
            told += &format!("{name}: no input of its own\n");
            continue;
        };
        let words: Vec<&str> = words.iter().map(|word| if word == "{}" { &shown } else { word.as_str() }).collect();
        let run = bounded(program(), &here, bytes.len(), &words);
        if let Some(outcome) = broken(&run) {
            beyond.push(format!("{name}: {outcome}"));
        }
        let outcome = match run.code {
            Some(0) => "read",
            Some(1) => "read, and the answer is no",
            _ => "refused",
        };
        let why = run.err.lines().rfind(|line| line.starts_with("rist:")).unwrap_or_default();
        let why: String = why.replace(&all.display().to_string(), "").chars().take(160).collect();
        told += format!("{name}: {outcome}: {why}").trim_end_matches([':', ' ']);
        told.push('\n');
    }
    assert!(beyond.is_empty(), "{beyond:#?}");
    assert_snapshot("hostile/outcomes.txt", &told);
}
