//! The pendulum of `experiments`, for unit tests.

pub(crate) use pendulum::Pendulum;

#[path = "../../../experiments/src/pendulum.rs"]
mod pendulum;
#[path = "../../../identification/src/test_states.rs"]
mod test_states;
