//! Selects the lengths, angles and components of gravity that remain symbols in the formulas.

use expr::Function;
use rist::Error;
use rist::describe::symbols::check_symbols;
use robot::Robot;

/// The named constants that remain symbols.
pub(crate) struct KeptSymbols<'a> {
    robot: &'a Robot,
    names: Vec<String>,
}

impl<'a> KeptSymbols<'a> {
    /// Selects the requested constants. `constants`: for each constant of the functions, its name in the formulas and all names
    /// that it has in the file.
    pub(crate) fn of(
        robot: &'a Robot,
        asked: &[String],
        constants: &[(String, Vec<String>)],
    ) -> Result<KeptSymbols<'a>, Error> {
        let is_asked = |(name, names): &&(String, Vec<String>)| match asked {
            [] => robot.symbols.iter().any(|s| s.name == *name),
            [word] if word == "all" => true,
            [word] if word == "none" => false,
            _ => names.iter().chain([name]).any(|name| asked.contains(name)),
        };
        let names = constants.iter().filter(is_asked).map(|(name, _)| name.clone()).collect();
        let kept = KeptSymbols { robot, names };
        check_symbols(robot, asked, &kept.names, constants)?;
        Ok(kept)
    }

    pub(crate) fn holds(&self, name: &str) -> bool {
        self.names.iter().any(|kept| kept == name)
    }

    /// Whether the symbol has no value in the file.
    fn is_open(&self, name: &str) -> bool {
        self.robot.symbols.iter().any(|s| s.generic && s.name == name)
    }

    /// A line with the values of the function's symbols in the file. `None` if it has no symbols.
    pub(crate) fn line(&self, function: &Function) -> Option<String> {
        let value = |(_, name, x): (expr::Expr, String, f64)| match self.is_open(&name) {
            true => format!("{name} has no value"),
            false => format!("{name} = {x}"),
        };
        let values: Vec<String> = function.constants().into_iter().map(value).collect();
        (!values.is_empty()).then(|| format!("In the file {}.", values.join(", ")))
    }
}
