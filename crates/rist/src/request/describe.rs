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
    Symoro = "symoro" "in the link frames of rist; all other conventions use the joint frames of the file",
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
        Regressor = "regressor" "The matrix Y in tau = Y X, for the standard parameters X",
        /// Y, the regressor of the base parameters.
        BaseRegressor = "base-regressor" "The matrix Y in tau = Y X, for the base parameters X",
        /// tau, the torque.
        Torque = "torque" "The torque tau",
    }
}

request! {
    /// Options for showing the model of a robot.
    pub struct InspectRequest {
        /// Format of the output. text is wrapped at the width of the terminal, or at 80 columns in a pipe. In html, you can
        /// select a base parameter or a link.
        format: SheetFormat = SheetFormat::Text;
        /// Write the rules in the standard parameters only, however long they are [default: only if all rules together have at
        /// most 200000 characters; otherwise the rules use the regrouped parameters of the next link].
        expand_rules: bool = false;
    }
}

request! {
    /// Options for a conversion; exactly one must be given.
    pub struct ConvertRequest {
        /// Format of the new description.
        to: Option<DescriptionFormat> = None;
        /// Instead of a description, list the inertial parameters of every link by the names of a convention.
        parameters: Option<Convention> = None, value_name("CONVENTION");
    }
}

request! {
    /// Selects what is computed at given states.
    pub struct EvaluateRequest {
        /// The quantity to compute; required.
        quantity: Option<StateQuantity> = None;
    }
}
