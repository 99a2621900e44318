//! README.md shows what the program prints.
//!
//! In a block of the kind `console`, a line `$ rist ..` is run at the root of the repository, and the lines below
//! it, to the next such line or the end of the block, are its output; `...` alone on a line stands for any lines.

use tests::program::rist;
use tests::workspace;

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

#[test]
fn the_transcript_of_the_readme_is_what_rist_prints() {
    let text = std::fs::read_to_string(workspace().join("README.md")).expect("README.md is there");
    let transcripts = transcripts(&text);
    assert!(!transcripts.is_empty(), "README.md shows no `$ rist` in a console block");
    for (arguments, shown) in transcripts {
        let run = rist(&workspace(), &arguments.split_whitespace().collect::<Vec<_>>());
        let lines: Vec<&str> = run.out.lines().map(str::trim_end).collect();
        assert_eq!(run.code, Some(0), "rist {arguments}: {}", run.err);
        let (shown, found) = (&shown, lines.join("\n"));
        assert!(matches(shown, &lines), "$ rist {arguments}\nREADME.md:\n{}\nfound:\n{found}", shown.join("\n"));
    }
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
