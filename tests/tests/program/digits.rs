//! Tests that printed numbers have no useless digits or exponents, and that printed sentences are at most a hundred
//! columns wide.

use std::path::Path;

use tests::program::{folder, rist_in_pipe};
use tests::workspace;

/// Largest allowed number of significant digits of a printed number. It is enough to distinguish a value from its bound in a
/// proof.
const MOST_DIGITS: usize = 7;
/// Exponents of ten of numbers that must be printed without an exponent. Numbers below 1 may have one, because they are compared
/// with numbers such as 1e-13.
const PLAIN_POWERS: std::ops::RangeInclusive<i32> = 0..=5;
const COLUMNS: usize = 100;

/// Describes how a number is badly printed; `None` for a well printed number, and for a word that is no number.
fn fault_of(word: &str) -> Option<String> {
    let word = word.trim_start_matches(['(', '[', '+', '-']).trim_end_matches([')', ']', ',', ';', ':', '.']);
    word.parse::<f64>().ok().filter(|x| x.is_finite())?;
    let (mantissa, exponent) = word.split_once(['e', 'E']).unwrap_or((word, "0"));
    let digits = mantissa.replace('.', "");
    // Leading zeros, and trailing zeros without a decimal point, are not significant.
    let digits = if mantissa.contains('.') { digits.as_str() } else { digits.trim_end_matches('0') };
    let digits = digits.trim_start_matches('0');
    if digits.len() > MOST_DIGITS {
        return Some(format!("{word} has {} digits", digits.len()));
    }
    let exponent: i32 = exponent.parse().ok()?;
    let has_exponent = word.contains(['e', 'E']);
    (has_exponent && PLAIN_POWERS.contains(&exponent)).then(|| format!("{word} needs no exponent"))
}

/// The badly printed numbers of a text, each with its line.
fn numbers(text: &str) -> Vec<String> {
    let of_line = |line: &str| -> Vec<String> {
        line.split_whitespace().filter_map(fault_of).map(|fault| format!("{fault}: {line}")).collect()
    };
    text.lines().flat_map(of_line).collect()
}

/// The badly printed numbers and the lines that are too wide. Lines of tables (several blanks between cells) may be wider.
fn faults(text: &str) -> Vec<String> {
    let mut found = numbers(text);
    for line in text.lines() {
        if line.chars().count() > COLUMNS && !line.trim_start().contains("  ") {
            found.push(format!("{} columns: {line}", line.chars().count()));
        }
    }
    found
}

#[test]
fn a_fault_is_seen() {
    for word in ["38.800000000000004", "0.0000e0", "-5.3004e1", "(-209.439510", "12345678,"] {
        assert!(fault_of(word).is_some(), "{word}");
    }
    for word in ["38.8", "0.0000054", "-5.3e-13", "1500000", "q_1", "e01", "12:30", "0.5000", "inf"] {
        assert_eq!(fault_of(word), None, "{word}");
    }
    assert_eq!(faults(&"word ".repeat(30)).len(), 1);
    assert!(faults(&"1.0  ".repeat(30)).is_empty());
}

/// Runs every command that prints a result: on a UR5, and on the arm RACE, which is identified by spectrum analysis.
#[test]
fn what_commands_print_can_be_read() {
    let here = folder("digits");
    let file = |name: &str| workspace().join(name).display().to_string();
    let (ur5, race) = (file("models/ur5.urdf"), file("models/race.yaml"));
    for name in ["log.csv", "other.csv", "motion.yaml"] {
        std::fs::copy(workspace().join("docs/ur5").join(name), here.join(name)).unwrap();
    }
    let commands: [&[&str]; 16] = [
        &["inspect", &ur5],
        &["lint", &ur5],
        &["excite", &ur5, "--starts", "1", "--iterations", "10", "--out", "found.yaml"],
        &["check", &ur5, "motion.yaml"],
        &["doctor", &ur5, "log.csv"],
        &["identify", &ur5, "log.csv", "--validate", "other.csv", "--friction", "auto", "--out", "e.yaml"],
        &["identify", &ur5, "log.csv", "--weights", "huber", "--rotor-inertia", "actuated"],
        &["validate", &ur5, "e.yaml", "other.csv"],
        &["accumulate", &ur5, "log.csv", "--cutoff", "10", "--out", "a.tri"],
        &["accumulate", &ur5, "other.csv", "--cutoff", "10", "--out", "b.tri"],
        &["merge", "a.tri", "b.tri", "--out", "c.tri"],
        &["solve", "c.tri"],
        &["compare", "a.tri", "b.tri"],
        &["plan", &race, "--starts", "1", "--out", "p.yaml"],
        &["simulate", &race, "p.yaml", "--validation", "1", "--out", "logs"],
        &["identify", &race, "logs", "--plan", "p.yaml", "--method", "rist-mh"],
    ];
    let mut all = Vec::new();
    for command in commands {
        let run = rist_in_pipe(&here, command);
        // Exit code 1 is allowed: a log or a robot model may have findings.
        assert!(matches!(run.code, Some(0 | 1)) && !run.out.is_empty(), "{command:?}: {}", run.err);
        all.extend(faults(&run.out).into_iter().map(|fault| format!("rist {}: {fault}", command[0])));
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

/// Checks the transcripts in the documentation, including commands that are not run above.
#[test]
fn what_the_pages_show_can_be_read() {
    let mut pages = vec![workspace().join("README.md")];
    for folder in ["docs", "docs/how-to", "docs/ur5"] {
        let entries = std::fs::read_dir(workspace().join(folder)).unwrap().map(|entry| entry.unwrap().path());
        pages.extend(entries.filter(|path| path.extension().is_some_and(|end| end == "md")));
    }
    pages.sort();
    let (mut count, mut all) = (0, Vec::new());
    for page in &pages {
        let text = std::fs::read_to_string(page).unwrap();
        for block in text.split("```console\n").skip(1).filter_map(|rest| rest.split("```").next()) {
            count += 1;
            let printed: Vec<&str> = block.lines().filter(|line| !line.starts_with("$ ")).collect();
            let name = page.strip_prefix(workspace()).unwrap_or(Path::new(""));
            all.extend(numbers(&printed.join("\n")).into_iter().map(|fault| format!("{}: {fault}", name.display())));
        }
    }
    assert!(count > 15, "{count} blocks");
    assert!(all.is_empty(), "{}", all.join("\n"));
}
