//! The task `pictures [--check]`: writes docs/pictures/*.svg. With --check, it only compares the files with the new pictures.

use crate::cargo::root;
use crate::pictures;

pub(crate) const FOLDER: &str = "docs/pictures";

pub(crate) fn run(arguments: &[String]) -> Result<(), String> {
    let is_check = match arguments {
        [] => false,
        [flag] if flag == "--check" => true,
        [other, ..] => return Err(format!("pictures takes --check or nothing; found `{other}`")),
    };
    let folder = root().join(FOLDER);
    std::fs::create_dir_all(&folder).map_err(|e| format!("{FOLDER}: {e}"))?;
    let mut differ = Vec::new();
    for (name, draw) in pictures::ALL {
        let (drawn, file) = (draw().map_err(|e| format!("{name}: {e}"))?, folder.join(format!("{name}.svg")));
        if is_check && std::fs::read_to_string(&file).is_ok_and(|held| held == drawn) {
            continue;
        }
        if is_check {
            differ.push(format!("{FOLDER}/{name}.svg"));
            continue;
        }
        std::fs::write(&file, drawn).map_err(|e| format!("{}: {e}", file.display()))?;
    }
    match differ.is_empty() {
        true => Ok(()),
        false => Err(format!("not as drawn: {}; `cargo xtask pictures` writes them", differ.join(", "))),
    }
}
