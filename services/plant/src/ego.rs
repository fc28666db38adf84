//! The ego: a car or a truck.

use crate::gateway::Actuation;
use crate::longitudinal::{self, State};
use crate::truck::{self, Truck};
use scenario::{Problem, Scenario};
use serde::{Deserialize, Serialize};

/// The ego vehicle.
#[derive(Clone, Debug)]
pub enum Ego {
    /// Follows accelerations.
    Car(longitudinal::Vehicle),
    /// Has engine, gears and a road.
    Truck(Box<Truck>),
}

/// State of the ego that outlives the plant's process.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Snapshot {
    /// All of a car.
    Car(longitudinal::Vehicle),
    /// The motion of a truck.
    Truck(truck::Snapshot),
}

impl Ego {
    /// The ego of a scenario at its start.
    ///
    /// # Errors
    /// If the scenario's road is not valid.
    pub fn new(scenario: &Scenario) -> Result<Self, Problem> {
        Ok(match Truck::new(scenario)? {
            Some(truck) => Self::Truck(Box::new(truck)),
            None => Self::Car(longitudinal::Vehicle::new(&scenario.plant)),
        })
    }

    /// Goes on from what another process kept; what was kept of another kind of ego is passed over.
    pub fn restore(&mut self, kept: Snapshot) {
        match (self, kept) {
            (Self::Car(car), Snapshot::Car(kept)) => *car = kept,
            (Self::Truck(truck), Snapshot::Truck(kept)) => truck.restore(&kept),
            _ => {}
        }
    }

    /// State that outlives this process.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        match self {
            Self::Car(car) => Snapshot::Car(car.clone()),
            Self::Truck(truck) => Snapshot::Truck(truck.snapshot()),
        }
    }

    /// Moves on by one period of the plant, with the emergency brake's ceiling on the acceleration,
    /// m/s².
    pub fn step(&mut self, actuation: &Actuation, ceiling_mps2: Option<f64>) {
        match self {
            Self::Car(car) => car.step_below(actuation.request_mps2, ceiling_mps2),
            Self::Truck(truck) => truck.step(actuation, ceiling_mps2),
        }
    }

    /// Present state of motion.
    #[must_use]
    pub fn state(&self) -> State {
        match self {
            Self::Car(car) => car.state(),
            Self::Truck(truck) => truck.state(),
        }
    }

    /// The truck, if it is one.
    #[must_use]
    pub fn truck(&self) -> Option<&Truck> {
        match self {
            Self::Car(_) => None,
            Self::Truck(truck) => Some(truck),
        }
    }
}
