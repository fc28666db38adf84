//! Reports of the services at their end: each service's crate defines its own figures.

pub use aebs::AebsReport;
pub use controller::law::ProgramReport;
pub use controller::report::{CheckReport, ControllerReport, ModeChange, PlanningReport};
pub use obu::report::ObuReport;
pub use perception_sim::report::PerceptionReport;
pub use plant::report::{
    BrakeFigures, ControlFigures, Hops, Outcome, Parts, PlantReport, SignalHops, WorstChain,
};
pub use runtime::report::{Payload, ReceivedTopic, SentTopic, ServiceReport};
pub use v2x_sim::report::{ClockComparison, LinkReport, StationReport};
