//! Which formulas of a robot are written.

use rist::request::{Request, function_names};
use rist::wings::Wing;

use crate::file::FormulaLanguage;

/// What this wing adds.
pub fn wing() -> Wing {
    Wing { requests: vec![("derive", DeriveRequest::fields())], ..Wing::default() }
}

rist::words! { FormulaLanguage:
    Text = "text" "One assignment a line",
    Latex = "latex" "align* environments for a document with amsmath",
    Sympy = "sympy" "A Python function each, of SymPy's symbols or numbers",
    Matlab = "matlab" "A function of MATLAB or Octave",
}

rist::request! {
    /// Which formulas of a robot are written.
    pub struct DeriveRequest {
        /// Functions to write:
        function: Vec<String> = Vec::new(), value_name("NAMES"), and(&format!("base-regressor, {}", function_names()));
        /// Language to write.
        language: FormulaLanguage = FormulaLanguage::Text;
        /// Lengths, angles and components of gravity that stay symbols: `all`, `none`, or these; a number without a name is
        /// called by its place, as d3, r4, alpha5, gz [default: those that the file gives a name].
        symbols: Vec<String> = Vec::new(), value_name("NAMES");
        /// Expand each entry to a sum of products, for small robots.
        expand: bool = false;
        /// The one entry to write, as A[1,2] or tau[3] [default: all].
        entry: Option<String> = None, value_name("ENTRY");
    }
}
