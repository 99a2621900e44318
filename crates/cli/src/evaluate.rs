//! `rist evaluate`: computes the regressor or the torque at given states.
//!
//! Input: a description, and a CSV file with one state per row. Output: CSV with one row per state, on standard output.

use std::path::PathBuf;

use clap::Args;
use rist::Model;
use rist::request::{EvaluateRequest, StateQuantity};

use crate::failure::Failure;
use crate::flags::Flags;
use crate::model::ModelArguments;
use crate::terminal::print;

/// Evaluate the regressor or the torque at the states of a CSV file
///
/// The header of STATES names one column per coordinate and quantity: q_<coordinate>, dq_<coordinate>, ddq_<coordinate> (SI
/// units). If dq or ddq columns are missing, they count as zero. For the torque, columns x_<parameter> (for example x_MX2)
/// replace the standard parameters of the description. The output has columns Y_<coordinate>_<parameter> or
/// tau_<coordinate>.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// CSV file of states, one per row
    states: PathBuf,

    #[command(flatten)]
    request: Flags<EvaluateRequest>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let quantity = arguments.request.read()?.quantity;
    let unsaid = || Failure::new("say what to compute: [quantity=torque], regressor or base-regressor");
    let quantity = quantity.ok_or_else(unsaid)?;
    let given = &arguments.model;
    let mut model = match quantity {
        StateQuantity::BaseRegressor => given.derive()?,
        // Only the regressor needs base parameters. For other quantities, a model is accepted even if its rank (the number of
        // base parameters) is unclear.
        _ => Model::at_any_rank(given.read_with_values()?, &given.model, given.options()?.any_size)?,
    };
    print(&rist::evaluate(&mut model, &arguments.states, quantity)?)
}
