//! The fixture of the unit tests: the pendulum of `experiments`.

pub(crate) use pendulum::Pendulum;

#[path = "../../experiments/src/pendulum.rs"]
mod pendulum;
#[path = "test_states.rs"]
mod test_states;
