//! `mutations PROGRAM SECONDS FOUND`: for SECONDS seconds, changes files that the program can read at random, and runs the
//! program on them. Files that crash the program are stored in the folder FOUND. `cargo xtask fuzz` calls it.
//!
//! The rule that every run must keep is in the module `tests::mutation`.

use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use tests::mutation::{by_time, hunt, seeds};
use tests::random::Random;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [program, seconds, found] = &arguments[..] else {
        eprintln!("expected are the program, seconds, and a folder for what breaks it");
        return ExitCode::FAILURE;
    };
    match run(Path::new(program), seconds, Path::new(found)) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

/// Runs the program on randomly changed files. Returns whether every run ended normally, as the module `mutation` requires.
fn run(program: &Path, seconds: &str, found: &Path) -> Result<bool, String> {
    let told = |path: &Path| format!("{}: it cannot be written", path.display());
    let time = Duration::from_secs(seconds.parse().map_err(|_| format!("{seconds} is no number of seconds"))?);
    let folder = std::env::temp_dir().join(format!("rist-mutations-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(|_| told(&folder))?;
    let mut seeds = seeds(program, &folder);
    by_time(program, &folder, &mut seeds);
    // The seed of the random numbers differs in every run, so that several runs test different files.
    let start = Instant::now();
    let since = std::time::UNIX_EPOCH.elapsed().map_or(0, |since| since.as_secs());
    let (count, broken) = hunt(program, &folder, &seeds, &mut Random(since), |_| start.elapsed() > time);
    println!("{count} mutants of {} files, seed {since}: {} findings", seeds.len(), broken.len());
    for (k, finding) in broken.iter().enumerate() {
        let path = found.join(format!("mutations-{since}-{k}-{}", finding.name));
        std::fs::write(&path, &finding.bytes).map_err(|_| told(&path))?;
        println!("{}: {:?}: {}", path.display(), finding.command, finding.outcome);
    }
    std::fs::remove_dir_all(&folder).map_err(|_| told(&folder))?;
    Ok(broken.is_empty())
}
