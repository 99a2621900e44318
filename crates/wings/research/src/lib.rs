//! Wing (optional package) for research: methods that papers use as references for comparison.
//!
//! These are IDIM-IV and DIDIM, which simulate the experiments in closed loop (`simulated_loop`), and the search for the best
//! plan of experiments by branch and bound (`branch_and_bound`, `proof_again`). The plan file contains a proof that can be
//! verified.
//!
//! Parts of the core that this wing uses: `rist::wings` calls the identification methods with simulation, and the search for
//! plans. `experiments::plan` bounds plans by relaxed designs and stores a proof in the file. `experiments::simulate` simulates a
//! control loop.

#![warn(missing_docs)]

mod branch_and_bound;
mod correlated_deviation;
mod experiments_in_loop;
mod loop_estimate;
mod plan_node;
mod proof_again;
mod proof_tree;
mod simulated_loop;
#[cfg(test)]
mod test_arm;

use rist::wings::Wing;

pub use experiments_in_loop::identify_in_loop;
pub use loop_estimate::identify_closed_loop;
pub use simulated_loop::{ClosedLoop, Simulated, Simulator, simulated};

/// The methods that this wing registers.
pub fn wing() -> Wing {
    Wing {
        in_loop: Some(Ok(identify_in_loop)),
        prove_plan: Some(Ok(branch_and_bound::branch_and_bound)),
        find_proof: Some(Ok(proof_again::efficiency_again)),
        ..Wing::default()
    }
}
