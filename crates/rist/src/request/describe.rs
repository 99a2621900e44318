//! The options (requests) of the commands that need only a robot description: `rist inspect` and `rist convert`, and the
//! evaluation of regressors and torques at given states.
//!
//! A request is a struct with all options of a command; each field is one option.

use robot::convention::Convention;

words! {
    /// The format in which `rist inspect` shows a model.
    pub enum SheetFormat {
        /// Text for a terminal.
        Text = "text" "",
        /// A page of Markdown.
        Markdown = "markdown" "",
        /// Tables of LaTeX.
        Latex = "latex" "",
        /// A page of HTML.
        Html = "html" "",
        /// All values as JSON.
        Json = "json" "",
    }
}

words! {
    /// The formats in which a description can be written.
    pub enum DescriptionFormat {
        /// The format of SYMORO.
        Par = "par" "",
        /// Modified Denavit-Hartenberg, the format of the files in models/.
        Yaml = "yaml" "",
        /// The format of ROS.
        Urdf = "urdf" "",
    }
}

words! { Convention:
    Symoro = "symoro" "in our link frames; the others in the joint frames of the file",
    Pinocchio = "pinocchio" "",
    Urdf = "urdf" "",
    Figaroh = "figaroh" "",
    SymPyBotics = "sympybotics" "",
    Matlab = "matlab" "",
    Mujoco = "mujoco" "",
    Drake = "drake" "",
}

words! {
    /// The quantities that `rist evaluate` computes at given states.
    pub enum StateQuantity {
        /// Y_s, the regressor of the standard parameters.
        Regressor = "regressor" "tau = Y X of the standard parameters",
        /// Y, the regressor of the base parameters.
        BaseRegressor = "base-regressor" "tau = Y X of the base parameters",
        /// tau, the torque.
        Torque = "torque" "The torque tau itself",
    }
}

request! {
    /// Options for showing the model of a robot.
    pub struct InspectRequest {
        /// text is wrapped at the terminal's width, at 80 columns in a pipe; html lets one choose a base parameter or a link.
        format: SheetFormat = SheetFormat::Text;
        /// Write the rules in the standard parameters alone, however long they are [default: while all of them stay below
        /// 200000 characters; beyond, they name the regrouped parameters of the next link].
        expand_rules: bool = false;
    }
}

request! {
    /// Options for a conversion; exactly one must be given.
    pub struct ConvertRequest {
        /// Format to write.
        to: Option<DescriptionFormat> = None;
        /// Instead, list the inertial parameters of every link by the names of a convention.
        parameters: Option<Convention> = None, value_name("CONVENTION");
    }
}

request! {
    /// Selects what is computed at given states.
    pub struct EvaluateRequest {
        /// What to compute; it has to be said.
        quantity: Option<StateQuantity> = None;
    }
}
