//! What all services of timegap agree on: messages, time, the runtime, scenarios and statistics.
//!
//! The arrow of dependence points one way: launcher → services → shared. Nothing here knows a
//! control law or a vehicle model.
//!
//! * [`e2e`]: end-to-end protection of the messages
//! * [`messages`]: the fixed-layout messages and the topics that carry them
//! * [`runtime`]: a service's life: its ports, its releases on either clock, its scheduling
//! * [`rung`]: the degradation ladder
//! * [`report`]: what a service tells the launcher when it ends
//! * [`statistics`]: histograms and percentiles, [`histogram_log`]: histograms as files
//! * [`scenario`]: scenario files
//! * [`road`]: grade profiles

pub mod e2e;
pub mod histogram_log;
pub mod messages;
pub mod report;
pub mod road;
pub mod rung;
pub mod runtime;
pub mod scenario;
mod service;
pub mod statistics;

pub use service::Service;
