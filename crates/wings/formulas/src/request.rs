//! The options (request) of `rist derive`, which writes functions of a robot as formulas.

use rist::request::{Request, function_names};
use rist::wings::Wing;

use modeling::FunctionOfLink;

use crate::determinant::jacobian_determinant;
use crate::file::FormulaLanguage;
use crate::inverse_geometry::inverse_geometry;

/// The request and the functions that this wing registers.
pub fn wing() -> Wing {
    Wing {
        requests: vec![("derive", DeriveRequest::fields)],
        functions: vec![
            FunctionOfLink {
                word: "jacobian-determinant",
                sentence: [
                    "Determinant of the Jacobian of ",
                    ", with other than six coordinates that of J^T J or J J^T",
                ],
                derive: |of, frame, _| Ok(jacobian_determinant(of, frame)),
                has_reference: false,
            },
            FunctionOfLink {
                word: "inverse-geometry",
                sentence: [
                    "All eight configurations, one a row, that bring ",
                    " to the pose t in the base frame: q = atan2(sin_q, cos_q), or slide of a joint that slides; an angle that is free, where axes lie along each other, is 0, and what is out of reach is no number",
                ],
                derive: |of, frame, _| inverse_geometry(of, frame).map_err(|e| e.to_string()),
                has_reference: false,
            },
        ],
        ..Wing::default()
    }
}

rist::words! { FormulaLanguage:
    Text = "text" "One assignment a line",
    Latex = "latex" "align* environments for a document with amsmath",
    Sympy = "sympy" "One Python function each, for symbols of SymPy or numbers",
    Matlab = "matlab" "A function of MATLAB or Octave",
}

rist::request! {
    /// Options that select the functions to write, their language and their form.
    pub struct DeriveRequest {
        /// Functions to write:
        function: Vec<String> = Vec::new(), value_name("NAMES"), and(&format!("base-regressor, {}", function_names()));
        /// Language of the formulas.
        language: FormulaLanguage = FormulaLanguage::Text;
        /// Lengths, angles and components of gravity that stay symbols: `all`, `none`, or a list of names. A number without a
        /// name is called by its place, such as d3, r4, alpha5, gz [default: those that have a name in the file].
        symbols: Vec<String> = Vec::new(), value_name("NAMES");
        /// Expand each entry to a sum of products; only for small robots.
        expand: bool = false;
        /// The only entry to write, such as A[1,2] or tau[3] [default: all entries].
        entry: Option<String> = None, value_name("ENTRY");
    }
}
