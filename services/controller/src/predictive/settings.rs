//! What a scenario may set of the law.

use super::{DynamicProgramming, PaperN2, Planner, Resolution};
use truck_model::Truck;

/// Which planner drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlannerKind {
    /// Receding-horizon dynamic programming.
    #[default]
    DynamicProgramming,
    /// The published scheme.
    PaperN2,
}

impl PlannerKind {
    /// Both planners.
    pub const ALL: [Self; 2] = [Self::DynamicProgramming, Self::PaperN2];

    /// Name in scenarios and tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::DynamicProgramming => "dynamic-programming",
            Self::PaperN2 => "paper-n2",
        }
    }

    /// A planner for `truck`.
    #[must_use]
    pub fn create(self, truck: &Truck) -> Box<dyn Planner> {
        match self {
            Self::DynamicProgramming => {
                Box::new(DynamicProgramming::new(truck, Resolution::default()))
            }
            Self::PaperN2 => Box::new(PaperN2::new(truck)),
        }
    }
}

/// Settings of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The truck as the law knows it.
    pub truck: Truck,
    /// Mean speed to keep on a free road, relative to the set speed.
    pub mean_speed: f64,
}

impl Settings {
    /// Settings for a truck whose mean speed shall be its set speed.
    #[must_use]
    pub fn new(truck: &Truck) -> Self {
        Self { truck: *truck, mean_speed: 1.0 }
    }
}
