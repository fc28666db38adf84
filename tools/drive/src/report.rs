//! Reports of the services at their end: each service's crate defines its own figures.

pub use aebs::report::AebsReport;
pub use controller::law::ProgramReport;
pub use controller::report::{CheckReport, ControllerReport, ModeChange, PlanningReport};
pub use obu::report::ObuReport;
pub use perception_sim::report::PerceptionReport;
pub use plant::report::{
    BrakeFigures, ControlFigures, Hops, Outcome, Parts, PlantReport, SignalHops, WorstChain,
};
pub use runtime::report::{ReceivedTopic, SentTopic};
pub use v2x_sim::report::{LinkReport, StationReport};

use messages::Service;
use runtime::report::Payload;

/// Report of one service, with its own figures.
pub type ServiceReport = runtime::report::ServiceReport<Details>;

/// Figures that only one service has.
#[derive(Clone, Debug, PartialEq)]
pub enum Details {
    None,
    Controller(Box<ControllerReport>),
    Plant(Box<PlantReport>),
    /// Figures of the emergency brake.
    Aebs(Box<AebsReport>),
    /// Figures of perception-sim.
    Perception(Box<PerceptionReport>),
    /// Figures of the on-board unit.
    Obu(Box<ObuReport>),
    /// Figures of v2x-sim, if the roadside units are on other hosts or in a capture.
    Link(Box<LinkReport>),
}

type Reader = fn(&Payload) -> Option<Details>;

/// Readers of the services' own figures. A service that is not here has no report.
const READERS: [(Service, Reader); 6] = [
    (Service::Plant, |payload| payload.read().map(Box::new).map(Details::Plant)),
    (Service::PerceptionSim, |payload| payload.read().map(Box::new).map(Details::Perception)),
    (Service::V2xSim, |payload| {
        payload.read::<Option<_>>().flatten().map(Box::new).map(Details::Link)
    }),
    (Service::Controller, |payload| payload.read().map(Box::new).map(Details::Controller)),
    (Service::Aebs, |payload| payload.read().map(Box::new).map(Details::Aebs)),
    (Service::Obu, |payload| payload.read().map(Box::new).map(Details::Obu)),
];

impl Details {
    /// The figures that `service` sent; none from a program in its place that sends others.
    pub fn of(service: Service, payload: &Payload) -> Self {
        let reader = READERS.into_iter().find(|(of, _)| *of == service);
        reader.and_then(|(_, read)| read(payload)).unwrap_or(Self::None)
    }
}

/// The report that a service sent, with its figures read.
pub fn read(report: runtime::report::ServiceReport) -> ServiceReport {
    let service = report.service;
    report.map(|payload| Details::of(service, &payload))
}
