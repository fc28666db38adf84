//! What a scenario may set of the law.

use super::{DynamicProgramming, PaperN2, Plan, PlanRequest, Planner, Resolution};
use truck_model::Truck;

/// Which planner drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlannerKind {
    /// Receding-horizon dynamic programming.
    #[default]
    DynamicProgramming,
    /// The published scheme.
    PaperN2,
    /// None: a PI control of the set speed, the baseline of all savings.
    ConstantSpeed,
}

impl PlannerKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::DynamicProgramming, Self::PaperN2, Self::ConstantSpeed];

    /// Name in scenarios and tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::DynamicProgramming => "dynamic-programming",
            Self::PaperN2 => "paper-n2",
            Self::ConstantSpeed => "constant-speed",
        }
    }

    /// The price of time, relative to the flat's, at which a truck keeps its mean speed over hills; what is
    /// wrong with it the servo mends.
    #[must_use]
    pub(crate) fn usual_time_price(self) -> f64 {
        match self {
            Self::DynamicProgramming | Self::ConstantSpeed => 1.3,
            Self::PaperN2 => 1.6,
        }
    }

    /// The kind of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// A planner for `truck`; one that never has a plan for constant speed.
    #[must_use]
    pub fn create(self, truck: &Truck) -> Box<dyn Planner> {
        match self {
            Self::DynamicProgramming => {
                Box::new(DynamicProgramming::new(truck, Resolution::default()))
            }
            Self::PaperN2 => Box::new(PaperN2::new(truck)),
            Self::ConstantSpeed => Box::new(NoPlan),
        }
    }
}

struct NoPlan;

impl Planner for NoPlan {
    fn plan(&mut self, request: &PlanRequest, plan: &mut Plan) -> bool {
        plan.begin(request);
        false
    }
}

/// Settings of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The truck as the law knows it.
    pub truck: Truck,
    /// Who plans.
    pub planner: PlannerKind,
    /// Mean speed to keep on a free road, relative to the set speed.
    pub mean_speed: f64,
}

impl Settings {
    /// Settings for a truck whose mean speed shall be its set speed.
    #[must_use]
    pub fn new(truck: &Truck, planner: PlannerKind) -> Self {
        Self { truck: *truck, planner, mean_speed: 1.0 }
    }
}
