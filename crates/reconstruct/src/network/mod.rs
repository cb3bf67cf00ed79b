//! What small networks are made of, for whichever method learns: nodes and their slopes, a way to train, and files of
//! weights.

mod adam;
mod dense;
mod numbers;
mod weights_file;

pub use adam::Adam;
pub use dense::{add_products, lanes_of, sum_of_lanes, tanh, weighted_sum};
pub use numbers::Numbers;
pub use weights_file::{WeightsError, WeightsReader, write_line};
