//! The inertial parameters as inputs of a function: all standard parameters X, or the base parameters X_base.
//!
//! A function of base parameters is the function of standard parameters with zeros for the dropped parameters. The expression
//! graph omits the terms of these parameters.

use expr::{Expr, Input, SymbolKind};
use robot::{Inertial, LinkId, StandardParameter};

use crate::base::base_parameters::BaseParameters;
use crate::derivation::Derivation;

/// The inertial parameters that are inputs of a function, with their expressions `x`: all standard parameters X, or the base
/// parameters X_base.
pub(crate) struct ParameterInputs {
    pub x: Vec<Expr>,
    parameters: Vec<StandardParameter>,
}

impl ParameterInputs {
    pub(crate) fn standard(derivation: &mut Derivation) -> ParameterInputs {
        let parameters = StandardParameter::all(derivation.robot);
        let name = |p: &StandardParameter| p.display(derivation.robot).to_string();
        let names: Vec<String> = parameters.iter().map(name).collect();
        ParameterInputs::of(derivation, parameters, &names)
    }

    /// The base parameters as inputs. Each takes the place of the standard parameter after which it is named.
    pub(crate) fn base(derivation: &mut Derivation, base: &BaseParameters) -> ParameterInputs {
        let names: Vec<String> = base.base.iter().map(|b| b.name.clone()).collect();
        ParameterInputs::of(derivation, base.base.iter().map(|b| base.standard[b.column]).collect(), &names)
    }

    fn of(derivation: &mut Derivation, parameters: Vec<StandardParameter>, names: &[String]) -> ParameterInputs {
        let g = &mut derivation.graph;
        let x = names.iter().map(|name| g.symbol(name, SymbolKind::Input)).collect();
        ParameterInputs { x, parameters }
    }

    /// The input expression of a parameter of a link; zero if the parameter is not an input.
    pub(crate) fn get(&self, link: LinkId, inertial: Inertial) -> Expr {
        let parameter = StandardParameter { link, inertial };
        self.parameters.iter().position(|p| *p == parameter).map_or(Expr::ZERO, |c| self.x[c])
    }

    pub(crate) fn body(&self, link: LinkId) -> [Expr; 10] {
        Inertial::BODY.map(|i| self.get(link, i))
    }

    pub(crate) fn input(&self) -> Input {
        Input { name: "x".into(), entries: self.x.clone() }
    }
}
