//! The ego: a car, a unit of the user's or a truck.

use crate::gateway::Actuation;
use crate::longitudinal::{self, State};
use crate::truck::{self, Truck};
use crate::unit_car::{Moment, UnitCar};
use runtime::RuntimeError;
use scenario::Scenario;
use scenario::grade::GradeProfile;
use serde::{Deserialize, Serialize};

pub(crate) enum Ego {
    /// Follows accelerations; on a road with heights it feels them.
    Car(longitudinal::Vehicle, Option<GradeProfile>),
    Unit(Box<UnitCar>),
    /// Has engine, gears and a road.
    Truck(Box<Truck>),
}

/// State of the ego that outlives the plant's process.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Snapshot {
    Car(longitudinal::Vehicle),
    Truck(truck::Kept),
}

impl Ego {
    pub(crate) fn new(scenario: &Scenario) -> Result<Self, RuntimeError> {
        if let Some(unit) = &scenario.plant.fmu {
            return Ok(Self::Unit(Box::new(UnitCar::open(scenario, unit)?)));
        }
        Ok(match Truck::new(scenario)? {
            Some(truck) => Self::Truck(Box::new(truck)),
            None => {
                let mut car = longitudinal::Vehicle::new(&scenario.plant);
                let heights = (!scenario.road.is_level()).then(|| scenario.road.profile());
                let heights = heights.transpose()?;
                if let Some(heights) = &heights {
                    car.take_slope(heights);
                }
                Self::Car(car, heights)
            }
        })
    }

    /// Goes on from what another process kept; what was kept of another kind of ego is passed over.
    pub(crate) fn restore(&mut self, kept: Snapshot) {
        match (self, kept) {
            (Self::Car(car, _), Snapshot::Car(kept)) => *car = kept,
            (Self::Unit(unit), Snapshot::Car(kept)) => unit.restore(kept),
            (Self::Truck(truck), Snapshot::Truck(kept)) => truck.kept = kept,
            _ => {}
        }
    }

    pub(crate) fn snapshot(&self) -> Snapshot {
        match self {
            Self::Car(car, _) => Snapshot::Car(car.clone()),
            Self::Unit(unit) => Snapshot::Car(unit.own.clone()),
            Self::Truck(truck) => Snapshot::Truck(truck.kept),
        }
    }

    /// Moves on by one period of the plant, with the emergency brake's ceiling on the acceleration, m/s². A unit that
    /// fails is an error in simulated time.
    pub(crate) fn step(
        &mut self,
        actuation: &Actuation,
        ceiling_mps2: Option<f64>,
        moment: Moment,
    ) -> Result<(), RuntimeError> {
        match self {
            Self::Unit(unit) => {
                let ceiling_mps2 = ceiling_mps2.unwrap_or(f64::INFINITY);
                unit.step(actuation.request_mps2.min(ceiling_mps2), moment)?;
            }
            Self::Car(car, heights) => {
                car.step_on(actuation.request_mps2, ceiling_mps2, heights.as_ref());
            }
            Self::Truck(truck) => truck.step(actuation, ceiling_mps2),
        }
        Ok(())
    }

    /// Corrects the place on the axis, m: on a road with a plan the way is not the place.
    pub(crate) fn place(&mut self, position_m: f64) {
        match self {
            Self::Car(car, _) => car.place(position_m),
            Self::Unit(unit) => unit.place(position_m),
            Self::Truck(truck) => truck.place(position_m),
        }
    }

    pub(crate) fn state(&self) -> State {
        match self {
            Self::Car(car, _) => car.state(),
            Self::Unit(unit) => unit.own.state(),
            Self::Truck(truck) => truck.state(),
        }
    }

    pub(crate) fn truck(&self) -> Option<&Truck> {
        if let Self::Truck(truck) = self { Some(truck) } else { None }
    }

    pub(crate) fn unit(&self) -> Option<&UnitCar> {
        if let Self::Unit(unit) = self { Some(unit) } else { None }
    }
}
