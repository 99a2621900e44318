//! Generates source code with functions of a robot, which a user adds to a project.
//!
//! Input: a robot, the names of functions, and possibly the values of an estimate. Output: the text of a file in Rust or C. The
//! values become two constants: X (base parameters) and F (friction of each coordinate). A monitor is C code that computes the
//! external torques, contact and the load.

use codegen::Monitor;
use expr::ConstantValue;
use modeling::RobotFunction;
use robot::Robot;

use crate::describe::description::check_size;
pub use crate::describe::named_function::function_named;
use crate::describe::symbols::check_symbols;
use crate::error::Error;
use crate::request::MONITOR;
pub use crate::request::function_names;

/// The language of generated source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Language {
    /// One Rust file without std. It is generic over the number type: f64, f32 or a type of the user.
    Rust,
    /// C99: a header and a source file. Both need math.h.
    C {
        /// Name of the header in the `#include` of the source.
        header: String,
    },
}

/// Generated source code.
pub struct GeneratedSource {
    /// The text of the file; for C, of the source file with the functions.
    pub text: String,
    /// The text of the header, only for C.
    pub header: Option<String>,
    /// For each function, the name of the function, and the numbers of multiplications, additions, and sines and cosines in one
    /// call.
    pub counts: Vec<(String, expr::Count)>,
}

/// The values of an estimate that are written into the source.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifiedValues {
    /// Base parameters X, in the order of the base regressor's columns. A parameter that is not identifiable has the value with
    /// which torques are predicted.
    pub base: Vec<f64>,
    /// Viscous, Coulomb and offset friction FV FS OFF of each coordinate: N m s/rad, N m, N m (N s/m, N, N); zero if the
    /// estimate has no such friction.
    pub friction: Vec<f64>,
    /// Names of the parameters that are neither in `base` nor in `friction`: other laws of friction, couplings, gains.
    pub left_out: Vec<String>,
    /// The logs that the estimate was made from.
    pub logs: Vec<String>,
    /// The numbers of the monitor (external torque, contact, load); `None` if no monitor is requested.
    pub monitor: Option<(String, Monitor)>,
}

impl IdentifiedValues {
    /// Writes the values into a module, as the constants X and F.
    fn write(&self, module: &mut expr::Module) {
        let from = if self.logs.is_empty() { "experiments".to_string() } else { self.logs.join(", ") };
        let x = format!("X: the base parameters as identified from {from}, SI units.");
        module.constant("X", &x, ConstantValue::Reals(self.base.clone()));
        let mut f = "FV FS OFF of each coordinate as identified: f of `friction`.".to_string();
        if !self.left_out.is_empty() {
            f += &format!(" Not held here: {}.", self.left_out.join(", "));
        }
        module.constant("F", &f, ConstantValue::Reals(self.friction.clone()));
    }
}

/// Name by which a user requests gravity compensation, feedforward and computed torque together.
pub(crate) const CONTROLLER: &str = "controller";
/// Functions that the generated controllers call.
const CALLED_BY_CONTROLLER: [&str; 2] = ["inverse-dynamics", "gravity"];

/// Generates `functions` of a robot as source; the base regressor if `functions` is empty. `made_by`: the command that the head
/// of the file names. `values`: numbers that become the constants X and F. `symbols`: lengths, angles and components of gravity
/// that become an argument, `all` for all of them.
///
/// Fails if a symbol that has to be a number has no value, if a function is unknown, or if the derivation would take long or
/// much memory, unless `any_size` is set. If the base regressor is requested, also fails if the rank is not clear-cut.
pub fn generate(
    robot: &Robot,
    functions: &[String],
    language: &Language,
    made_by: &str,
    values: Option<&IdentifiedValues>,
    symbols: &[String],
    any_size: bool,
) -> Result<GeneratedSource, Error> {
    check_size(robot, any_size)?;
    let (controllers, functions): (Vec<&String>, Vec<&String>) = functions.iter().partition(|name| *name == CONTROLLER);
    // Add the functions that the generated controllers call.
    let called = CALLED_BY_CONTROLLER.iter().filter(|_| !controllers.is_empty());
    let names = functions.into_iter().map(String::as_str).chain(called.copied());
    let (watching, names): (Vec<&str>, Vec<&str>) = names.partition(|name| MONITOR.contains(name));
    let monitor = monitor_for(robot, language, values, !watching.is_empty())?;
    let of_load = monitor.map(|(link, _)| format!("load-momentum={link}"));
    let of_monitor = of_load.iter().flat_map(|of_load| ["momentum-and-rate", of_load.as_str()]);
    let names = names.into_iter().chain(of_monitor);
    let functions: Vec<RobotFunction> = names.map(|name| function_named(robot, name)).collect::<Result<_, _>>()?;
    let is_symbol = |name: &str| symbols.iter().any(|asked| asked == name || asked == "all");
    let made = modeling::module_with_symbols(robot, &functions, &is_symbol).map_err(Error::new)?;
    check_symbols(robot, symbols, &made.symbols, &made.constants)?;
    let mut module = made.module;
    module.has_controller = !controllers.is_empty();
    if let Some(values) = values {
        values.write(&mut module);
    }
    let count = |f: &expr::Documented| (f.function.name.clone(), f.function.bound().count());
    let counts = module.functions.iter().map(count).collect();
    Ok(match language {
        Language::Rust => GeneratedSource { text: codegen::rust_file(&module, made_by), header: None, counts },
        Language::C { header } => {
            let load_function = |name: &String| name.starts_with("load_momentum");
            let load_function = module.functions.iter().map(|f| f.function.name.clone()).find(load_function);
            let monitor =
                monitor.map(|(_, m)| Monitor { load_function: load_function.unwrap_or_default(), ..m.clone() });
            let files = codegen::c_files(&module, made_by, header, monitor.as_ref());
            GeneratedSource { text: files.source, header: Some(files.header), counts }
        }
    })
}

/// The monitor of the values, with the link of its load, if a monitor is requested. Fails if the monitor cannot be generated.
fn monitor_for<'a>(
    robot: &Robot,
    language: &Language,
    values: Option<&'a IdentifiedValues>,
    is_asked: bool,
) -> Result<Option<&'a (String, Monitor)>, Error> {
    if !is_asked {
        return Ok(None);
    }
    if *language == Language::Rust {
        return Err(Error::new(
            "`observer` and `payload` are written in C: give [language=c]. In Rust, the crate `online` of rist holds them; generate \
             momentum-and-rate and load-momentum=LINK for it",
        ));
    }
    if !robot.passive.is_empty() {
        return Err(Error::new("`observer` and `payload` are for robots without loops that are solved numerically"));
    }
    let monitor = values.and_then(|values| values.monitor.as_ref());
    let missing = || Error::new("`observer` and `payload` need an estimate of logs: give [estimate]");
    monitor.map(Some).ok_or_else(missing)
}
