//! The controllers of a generated file: gravity compensation, feedforward and computed torque. They call functions of the same
//! file.
//!
//! ```text
//! gravity compensation   tau = g(q)
//! feedforward            tau = A(q_r) ddq_r + h(q_r, dq_r) + F(dq_r)
//! computed torque        tau = A(q) (ddq_r + kd (dq_r - dq) + kp (q_r - q)) + h(q, dq) + F(dq_r)
//! F(v)                   = FV v + FS tanh(v / width) + OFF
//! ```
//! [Khalil, Dombre 2002, chapter 14]. Each torque is saturated at +-limit. Friction is computed from the reference velocity,
//! because the sign of a measured velocity chatters. This module holds the texts in Rust and C. They call two functions of the
//! generated file, `inverse_dynamics` and `gravity`.

use expr::{Function, Module};
use proc_macro2::TokenStream;

/// An argument of a controller function: its name and its number of entries.
struct ControllerArgument {
    name: &'static str,
    length: usize,
}

/// The functions of a module that its controllers call, and the number of coordinates n.
pub(crate) struct ControllerText<'a> {
    inverse_dynamics: &'a Function,
    gravity: &'a Function,
    n: usize,
}

impl<'a> ControllerText<'a> {
    /// Finds the functions that the controllers of `module` call. `None` if the module has no controllers or lacks such a
    /// function.
    pub(crate) fn of(module: &'a Module) -> Option<ControllerText<'a>> {
        let function = |name: &str| module.functions.iter().map(|f| &f.function).find(|f| f.name == name);
        let inverse_dynamics = function("inverse_dynamics").filter(|_| module.has_controller)?;
        let n = inverse_dynamics.outputs[0].rows;
        Some(ControllerText { inverse_dynamics, gravity: function("gravity")?, n })
    }

    /// Number of entries of an input of the function `inverse_dynamics`; zero if it has no input of this name.
    fn length(&self, input: &str) -> usize {
        self.inverse_dynamics.inputs.iter().find(|i| i.name == input).map_or(0, |i| i.entries.len())
    }

    /// The arguments of a controller with these names. Arguments without entries for this robot are left out.
    fn arguments(&self, names: &[&'static str]) -> Vec<ControllerArgument> {
        let length = |name: &str| match name {
            "passive" | "x" | "symbols" => self.length(name),
            // Friction coefficients FV, FS and OFF of each coordinate.
            "f" => 3 * self.n,
            _ => self.n,
        };
        let all = names.iter().map(|&name| ControllerArgument { name, length: length(name) });
        all.filter(|argument| argument.length > 0).collect()
    }

    /// The arguments of a call as text: the names of all inputs, then `tau` with the text `reference` before it. `given`: pairs
    /// of a name and the text that replaces it.
    fn call(function: &Function, given: &[(&str, &str)], reference: &str) -> String {
        let argument = |input: &expr::Input| match given.iter().find(|(name, _)| *name == input.name) {
            Some((_, argument)) => argument.to_string(),
            None => input.name.clone(),
        };
        let inputs = function.inputs.iter().map(argument);
        inputs.chain([format!("{reference}tau")]).collect::<Vec<_>>().join(", ")
    }

    /// The definitions of the controllers in Rust, as tokens.
    pub(crate) fn rust(&self) -> TokenStream {
        let head = |names: &[&'static str]| {
            let argument = |a: &ControllerArgument| format!("{}: &[R; {}]", a.name, a.length);
            let arguments: Vec<String> = self.arguments(names).iter().map(argument).collect();
            format!("{}, tau: &mut [R; {}]", arguments.join(", "), self.n)
        };
        let n = self.n;
        let implementations: String = ["f64", "f32"].map(|number| RUST_OF_NUMBER.replace("NUMBER", number)).concat();
        let text = RUST
            .replace("IMPLEMENTATIONS", &implementations)
            .replace("GRAVITY_ARGUMENTS", &head(&["q", "passive", "x", "symbols", "limit"]))
            .replace("FRICTION_ARGUMENTS", &head(&["dq", "f", "width"]))
            .replace("FEEDFORWARD_ARGUMENTS", &head(FEEDFORWARD))
            .replace("COMPUTED_ARGUMENTS", &head(COMPUTED))
            .replace("CALL_GRAVITY", &ControllerText::call(self.gravity, &[], ""))
            .replace("CALL_FEEDFORWARD", &ControllerText::call(self.inverse_dynamics, OF_REFERENCE, ""))
            .replace("CALL_COMPUTED", &ControllerText::call(self.inverse_dynamics, &[("ddq", "&ddq")], ""))
            .replace("LENGTH", &n.to_string());
        text.parse().expect("the texts below are Rust, whatever names are put in")
    }

    /// The declarations and the definitions of the controllers in C, for the module with the name `prefix`.
    pub(crate) fn c(&self, prefix: &str) -> (String, String) {
        let head = |names: &[&'static str]| {
            let argument = |a: &ControllerArgument| format!("const {prefix}_real {}[{}]", a.name, a.length);
            let arguments: Vec<String> = self.arguments(names).iter().map(argument).collect();
            format!("{}, {prefix}_real tau[{}]", arguments.join(", "), self.n)
        };
        let functions = [
            ("gravity_compensation", head(&["q", "passive", "x", "symbols", "limit"]), GRAVITY_DOC),
            ("feedforward", head(FEEDFORWARD), FEEDFORWARD_DOC),
            ("computed_torque", head(COMPUTED), COMPUTED_DOC),
        ];
        // Each controller calls the model and saturates the torques. Feedforward and computed torque also add friction.
        let (mut header, mut source) = (String::new(), C_HEAD.to_string());
        for (name, arguments, doc) in functions {
            header += &format!("\n/* {} */\nint {prefix}_{name}({arguments});\n", doc.join("\n   "));
            let body = match name {
                "gravity_compensation" => {
                    format!("    {prefix}_gravity({});\n", ControllerText::call(self.gravity, &[], ""))
                }
                "feedforward" => {
                    let call = ControllerText::call(self.inverse_dynamics, OF_REFERENCE, "");
                    format!("    {prefix}_inverse_dynamics({call});\n    add_friction(dq_r, f, width, tau);\n")
                }
                _ => {
                    let call = ControllerText::call(self.inverse_dynamics, &[], "");
                    format!(
                        "{C_FEEDBACK}    {prefix}_inverse_dynamics({call});\n    add_friction(dq_r, f, width, tau);\n"
                    )
                }
            };
            source += &format!("\nint {prefix}_{name}({arguments})\n{{\n{body}    return cut(limit, tau);\n}}\n");
        }
        (header, source.replace("LENGTH", &self.n.to_string()))
    }
}

const OF_REFERENCE: &[(&str, &str)] = &[("q", "q_r"), ("dq", "dq_r"), ("ddq", "ddq_r")];
const FEEDFORWARD: &[&str] = &["q_r", "passive", "dq_r", "ddq_r", "x", "f", "width", "symbols", "limit"];
const COMPUTED: &[&str] =
    &["q", "passive", "dq", "q_r", "dq_r", "ddq_r", "kp", "kd", "x", "f", "width", "symbols", "limit"];

const GRAVITY_DOC: &[&str] = &["Torques that hold the robot against gravity, within +-limit. Whether one was cut."];
const FEEDFORWARD_DOC: &[&str] = &[
    "Torques of the motion asked for, q_r, dq_r, ddq_r, with its friction, within +-limit: what to add to a controller.",
    "f: FV FS OFF of each coordinate; width > 0: the velocity within which Coulomb friction turns. Whether one was cut.",
];
const COMPUTED_DOC: &[&str] = &[
    "Computed torque: what gives the acceleration ddq_r + kd (dq_r - dq) + kp (q_r - q), with the friction of dq_r, within",
    "+-limit. kp: 1/s^2, kd: 1/s, w^2 and 2 z w of a loop of w rad/s with damping z. Whether one was cut.",
];

const C_HEAD: &str = "
/* tau += FV dq + FS tanh(dq / width) + OFF */
static void add_friction(const real dq[LENGTH], const real f[3 * LENGTH], const real width[LENGTH], real tau[LENGTH])
{
    int k;
    for (k = 0; k < LENGTH; k++)
        tau[k] = tau[k] + f[3 * k] * dq[k] + f[3 * k + 1] * TANH(dq[k] / width[k]) + f[3 * k + 2];
}

/* Cuts to +-limit; whether one was beyond. What is no number stays so. */
static int cut(const real limit[LENGTH], real tau[LENGTH])
{
    int k, is_cut = 0;
    for (k = 0; k < LENGTH; k++) {
        if (tau[k] > limit[k]) {
            tau[k] = limit[k];
            is_cut = 1;
        } else if (tau[k] < -limit[k]) {
            tau[k] = -limit[k];
            is_cut = 1;
        }
    }
    return is_cut;
}
";

const C_FEEDBACK: &str = "    real ddq[LENGTH];
    int k;
    for (k = 0; k < LENGTH; k++)
        ddq[k] = ddq_r[k] + kd[k] * (dq_r[k] - dq[k]) + kp[k] * (q_r[k] - q[k]);
";

const RUST_OF_NUMBER: &str = "
impl Control for NUMBER {
    /// The continued fraction of Lambert for a 32nd of the quotient, at most 5/8, then five times
    /// tanh(2 a) = 2 t / (1 + t^2).
    #[inline(always)]
    fn tanh_of_quotient(self, divisor: Self) -> Self {
        let (x, _) = (self / divisor).within(20.0);
        let z = x / 32.0;
        let zz = z * z;
        let tail = 9.0 + zz / (11.0 + zz / (13.0 + zz / 15.0));
        let t = z / (1.0 + zz / (3.0 + zz / (5.0 + zz / (7.0 + zz / tail))));
        let double = |t: Self| 2.0 * t / (1.0 + t * t);
        double(double(double(double(double(t)))))
    }

    #[inline(always)]
    fn within(self, limit: Self) -> (Self, bool) {
        if self > limit {
            (limit, true)
        } else if self < -limit {
            (-limit, true)
        } else {
            (self, false)
        }
    }
}
";

const RUST: &str = "
/// What a controller needs of numbers beside `Real`.
pub trait Control: Real {
    /// Hyperbolic tangent of the quotient; within 1e-15 of it for f64.
    fn tanh_of_quotient(self, divisor: Self) -> Self;
    /// The number, or the end of +-limit beyond which it is, and whether it was beyond. What is no number stays so.
    fn within(self, limit: Self) -> (Self, bool);
}

IMPLEMENTATIONS

/// tau += FV dq + FS tanh(dq / width) + OFF
#[inline(always)]
fn add_friction<R: Control>(FRICTION_ARGUMENTS) {
    for k in 0..LENGTH {
        let coulomb = f[3 * k + 1] * dq[k].tanh_of_quotient(width[k]);
        tau[k] = tau[k] + f[3 * k] * dq[k] + coulomb + f[3 * k + 2];
    }
}

#[inline(always)]
fn cut<R: Control>(limit: &[R; LENGTH], tau: &mut [R; LENGTH]) -> bool {
    let mut is_cut = false;
    for (tau, limit) in tau.iter_mut().zip(limit) {
        let (within, was_beyond) = tau.within(*limit);
        *tau = within;
        is_cut |= was_beyond;
    }
    is_cut
}

/// Torques that hold the robot against gravity, within +-limit. Whether one was cut.
pub fn gravity_compensation<R: Control>(GRAVITY_ARGUMENTS) -> bool {
    gravity(CALL_GRAVITY);
    cut(limit, tau)
}

/// Torques of the motion asked for, q_r, dq_r, ddq_r, with its friction, within +-limit: what to add to a controller.
/// `f`: FV FS OFF of each coordinate; `width` > 0: the velocity within which Coulomb friction turns. Whether one was cut.
#[allow(clippy::too_many_arguments, reason = \"the signals of a controller\")]
pub fn feedforward<R: Control>(FEEDFORWARD_ARGUMENTS) -> bool {
    inverse_dynamics(CALL_FEEDFORWARD);
    add_friction(dq_r, f, width, tau);
    cut(limit, tau)
}

/// Computed torque: what gives the acceleration ddq_r + kd (dq_r - dq) + kp (q_r - q), with the friction of dq_r, within
/// +-limit. `kp`: 1/s^2, `kd`: 1/s, w^2 and 2 z w of a loop of w rad/s with damping z. Whether one was cut.
#[allow(clippy::too_many_arguments, reason = \"the signals of a controller\")]
pub fn computed_torque<R: Control>(COMPUTED_ARGUMENTS) -> bool {
    let mut ddq = *ddq_r;
    for k in 0..LENGTH {
        ddq[k] = ddq[k] + kd[k] * (dq_r[k] - dq[k]) + kp[k] * (q_r[k] - q[k]);
    }
    inverse_dynamics(CALL_COMPUTED);
    add_friction(dq_r, f, width, tau);
    cut(limit, tau)
}
";
