//! `cargo xtask datasets DIR`: identifies measured robots by all recipes, and prints the residuals next to the residuals of an
//! independent program. DIR contains one folder per data set, with its name.
//!
//! A recipe describes the logs of a data set and what is fitted and predicted (`tests::benchmark::dataset`).

use std::path::Path;
use std::process::ExitCode;

use logs::Error;
use tests::benchmark::dataset::Dataset;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder] = arguments.as_slice() else {
        eprintln!("the folder that holds the sets is expected, and nothing else: cargo xtask datasets DIR");
        return ExitCode::FAILURE;
    };
    match run(Path::new(folder)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run(sets: &Path) -> Result<(), Error> {
    let known = Dataset::known()?;
    let mut found = 0;
    for dataset in &known {
        let folder = sets.join(&dataset.name);
        if !folder.is_dir() {
            continue;
        }
        found += 1;
        let robot = dataset.robot(&folder)?;
        for run in &dataset.runs {
            println!("{}", dataset.run(run, &folder, &robot)?);
        }
    }
    if found > 0 {
        return Ok(());
    }
    let names: Vec<&str> = known.iter().map(|d| d.name.as_str()).collect();
    Err(Error::new(format!("{}: none of the known sets is there: {}", sets.display(), names.join(", "))))
}
