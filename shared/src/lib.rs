//! What all services agree on: messages, time, runtime, scenarios and statistics.

pub mod scenario;
