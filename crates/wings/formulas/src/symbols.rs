//! Which lengths, angles and components of gravity stay symbols.

use expr::Function;
use rist::Error;
use rist::describe::symbols::check_symbols;
use robot::Robot;

/// Which named constants stay symbols.
pub(crate) struct KeptSymbols<'a> {
    robot: &'a Robot,
    names: Vec<String>,
}

impl<'a> KeptSymbols<'a> {
    /// Of the constants of the functions, each with all its names in the file, those that are asked for.
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

    /// Whether the file gives the symbol no value.
    fn is_open(&self, name: &str) -> bool {
        self.robot.symbols.iter().any(|s| s.generic && s.name == name)
    }

    /// A line with the values in the file of the function's symbols.
    pub(crate) fn line(&self, function: &Function) -> Option<String> {
        let value = |(_, name, x): (expr::Expr, String, f64)| match self.is_open(&name) {
            true => format!("{name} has no value"),
            false => format!("{name} = {x}"),
        };
        let values: Vec<String> = function.constants().into_iter().map(value).collect();
        (!values.is_empty()).then(|| format!("In the file {}.", values.join(", ")))
    }
}
