//! Estimators: each file computes a solution from the triangles (R of QR) of the joints.

pub mod barrier;
pub mod clusters;
pub mod consistent;
pub mod drive_gains;
pub mod essential;
pub mod huber;
pub mod loss;
pub mod payload;
pub mod replicate_deviation;
pub mod row_products;
pub mod state_bands;
pub mod weighted;
