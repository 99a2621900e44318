//! The identification methods. Each method has a request type with its options, and refuses the options of other methods.
//!
//! A request is a struct with all options of a method. Methods differ in the equations that they solve, and in the logs that
//! they need (any logs, or the logs of a plan).

use super::files::{BodiesFiles, PlanFiles, SamplesFiles};
use super::identify::{ClosedLoopRequest, HarmonicRequest, IdentifyRequest, PaperRequest, SamplesRequest};
use super::words::WordChoice;
use super::{Field, Request};
use crate::error::Error;

words! {
    /// The method by which parameters are identified.
    pub enum Method {
        /// Least squares on samples.
        Ls = "ls" "Least squares on filtered samples",
        /// Least squares on samples with the essential parameters only (the smallest set with nearly the same residual).
        Essential = "essential" "Least squares with only the parameters that the data need; all others are zero",
        /// RIST: the paper's equations.
        Rist = "rist" "The equations of [Vandanjon, Gautier, Desbats 1995], rows of the operator Sp",
        /// RIST with the drive gains by total least squares.
        Tls = "tls" "The equations of rist with unknown drive gains, by total least squares",
        /// RIST-MH: all harmonics of the experiments, with friction.
        RistMh = "rist-mh" "The spectrum method with all harmonics of the motion, and with friction",
        /// IDIM-IV: least squares with instrumental variables from simulated experiments.
        Iv = "iv" "Instrumental variables: the experiments are simulated in closed loop, and give the instruments of the samples",
        /// DIDIM: direct and inverse dynamics; only torques are fitted, to simulated experiments.
        Didim = "didim" "Direct and inverse dynamics: the experiments are simulated in closed loop, and only torques are fitted",
    }
}

impl Method {
    /// All methods, in the order of the help.
    pub fn all() -> impl Iterator<Item = Method> {
        Method::WORDS.iter().map(|(method, ..)| *method)
    }

    /// The fields of the method's request.
    pub fn fields(self) -> Vec<Field> {
        match self {
            Method::Ls => IdentifyRequest::fields(),
            Method::Essential => SamplesRequest::fields(),
            Method::Rist | Method::Tls => PaperRequest::fields(),
            Method::RistMh => HarmonicRequest::fields(),
            Method::Iv | Method::Didim => ClosedLoopRequest::fields(),
        }
    }

    /// The options that name files which the program reads and writes for the method.
    pub fn files(self) -> Vec<Field> {
        match self {
            Method::Ls => BodiesFiles::fields(),
            Method::Essential => SamplesFiles::fields(),
            Method::Rist | Method::Tls | Method::RistMh | Method::Iv | Method::Didim => PlanFiles::fields(),
        }
    }

    /// The error text if this method does not have the option `name`, but another method has it; otherwise `None`.
    pub fn refusal(self, name: &str) -> Option<Error> {
        let takes = |method: Method| method.fields().iter().chain(&method.files()).any(|field| field.name == name);
        let users: Vec<&str> = Method::all().filter(|method| takes(*method)).map(Method::word).collect();
        if takes(self) {
            return None;
        }
        let (first, others) = users.split_first()?;
        let others: String = others.iter().map(|other| format!(" or {other}")).collect();
        let own = self.word();
        Some(Error::new(format_args!("[{name}]: [method={own}] does not use that; [method={first}]{others} does")))
    }
}

request! {
    /// Selects the method.
    pub struct MethodRequest {
        /// Method of identification. All methods except ls and essential need [plan], the plan whose experiments are in the
        /// logs.
        method: Method = Method::Ls, heading("Method");
    }
}
