//! Checks the symbols that a user wants to keep in generated code: lengths, angles and components of gravity.
//!
//! A kept symbol becomes an argument of the generated functions; every other symbol becomes a number, and needs a value.

use robot::Robot;

use crate::error::Error;

/// Fails if a requested symbol does not exist, or if a constant that becomes a number has no value in the file. `asked`: the
/// requested symbols; `kept`: constants that stay symbols; `constants`: all constants, each with all its names in the file.
pub fn check_symbols(
    robot: &Robot,
    asked: &[String],
    kept: &[String],
    constants: &[(String, Vec<String>)],
) -> Result<(), Error> {
    let known = |name: &String| {
        matches!(name.as_str(), "all" | "none")
            || robot.symbols.iter().any(|s| s.name == *name)
            || constants.iter().any(|(_, names)| names.contains(name))
    };
    if let Some(unknown) = asked.iter().find(|name| !known(name)) {
        let all: Vec<&str> = constants.iter().flat_map(|(_, names)| names).map(String::as_str).collect();
        let there = if all.is_empty() { "none there".to_string() } else { all.join(", ") };
        return Err(Error::new(format_args!(
            "[symbols={unknown}]: the functions have no such length, angle or gravity; theirs are {there}"
        )));
    }
    let lacks_value = |name: &String| robot.symbols.iter().any(|s| s.generic && s.name == *name);
    match constants.iter().find(|(name, _)| lacks_value(name) && !kept.contains(name)) {
        Some((name, _)) => Err(Error::new(format_args!(
            "{name} has no value in the file: keep it as a symbol ([symbols={name}]), or give it one ([value={name}=0.45])"
        ))),
        None => Ok(()),
    }
}
