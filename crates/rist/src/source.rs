//! A robot's functions as source for a project of the user's own.

use modeling::{LinkFrame, RobotFunction};
use robot::Robot;

use crate::error::Error;

/// The language of generated source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Language {
    /// One file: no_std, generic over f64, f32 and numbers of your own.
    Rust,
    /// C99: a header of this name and a source file that need math.h.
    C {
        /// Name of the header, as the source includes it.
        header: String,
    },
}

/// Generated source.
pub struct Source {
    /// The file; of C the one with the functions.
    pub text: String,
    /// The header, of C.
    pub header: Option<String>,
    /// Name of each function, with its multiplications, additions, and sines with cosines a call.
    pub counts: Vec<(String, expr::Count)>,
}

/// All that can be asked for, as a list for messages: `base-regressor, ..., pose=LINK`.
pub fn function_names() -> String {
    let name = |(word, of_link)| if of_link { format!("{word}=LINK") } else { String::from(word) };
    let mut names: Vec<String> = RobotFunction::words().map(name).collect();
    let last = names.pop().unwrap_or_default();
    format!("{} and {last}", names.join(", "))
}

/// A function by its name: `inertia-matrix`, `pose=5`; a link is named by its name, its joint or its label, a
/// URDF's also where it is fixed to a moving one; functions of it are in the frame that the file gives it.
///
/// Fails with the names there are.
pub fn function_named(robot: &Robot, text: &str) -> Result<RobotFunction, Error> {
    let (name, link) = text.split_once('=').map_or((text, None), |(name, link)| (name, Some(link)));
    if let Some(function) = RobotFunction::of_robot(name).filter(|_| link.is_none()) {
        return Ok(function);
    }
    let Some(make) = RobotFunction::of_link(name) else {
        return Err(Error::new(format_args!("there is no function `{text}`; there are {}", function_names())));
    };
    let Some(wanted) = link else {
        return Err(Error::new(format_args!("`{name}` needs its link: `{name}=LINK`")));
    };
    LinkFrame::named(robot, wanted).map(make).ok_or_else(|| {
        let names = LinkFrame::names(robot).join(", ");
        Error::new(format_args!("{} has no moving link `{wanted}`; it has {names}", robot.name))
    })
}

/// The base regressor and `functions` of a robot as source; `made_by`: the command that the head of the file names.
///
/// Fails where a name is no function's, and where the rank is not clear-cut.
pub fn generate(robot: &Robot, functions: &[String], language: &Language, made_by: &str) -> Result<Source, Error> {
    let functions: Vec<RobotFunction> =
        functions.iter().map(|name| function_named(robot, name)).collect::<Result<_, _>>()?;
    let module = modeling::module(robot, &functions).map_err(Error::new)?;
    let count = |f: &expr::Documented| (f.function.name.clone(), f.function.bound().count());
    let counts = module.functions.iter().map(count).collect();
    Ok(match language {
        Language::Rust => Source { text: codegen::rust_file(&module, made_by), header: None, counts },
        Language::C { header } => {
            let files = codegen::c_files(&module, made_by, header);
            Source { text: files.source, header: Some(files.header), counts }
        }
    })
}
