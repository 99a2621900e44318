//! Estimators: each file computes a solution from the triangles of the joints. A triangle is the R of the QR decomposition of
//! all rows (equations) of a joint; it contains all that least squares needs.

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
