//! What a scenario may set of the law.

use crate::settings::{self, SettingError, within};
use serde::{Deserialize, Serialize};
use truck_model::Truck;

/// Least and largest request of the law, m/s².
pub(super) const REQUESTS_MPS2: (f64, f64) = (-6.5, 1.5);

/// Which planner drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
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

    /// The price of time, relative to the flat's, at which a truck keeps its mean speed over hills; the
    /// servo corrects its error.
    #[must_use]
    pub(crate) fn usual_time_price(self) -> f64 {
        match self {
            Self::DynamicProgramming | Self::ConstantSpeed => 1.3,
            Self::PaperN2 => 1.6,
        }
    }
}

/// The law's table, `[controller.predictive]`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Keys {
    /// Which planner drives.
    pub planner: PlannerKind,
    /// Mean speed to keep on a free road, relative to the set speed.
    pub mean_speed: f64,
    /// Hardest deceleration of the vehicle ahead that is reckoned with on a car, m/s².
    pub lead_deceleration_mps2: f64,
}

impl Default for Keys {
    fn default() -> Self {
        let planner = PlannerKind::default();
        Self { planner, mean_speed: 1.0, lead_deceleration_mps2: 9.0 }
    }
}

impl settings::Settings for Keys {
    const SOURCE: &'static str = include_str!("settings.rs");

    fn check(&self) -> Result<(), SettingError> {
        within("mean_speed", self.mean_speed, 0.8, 1.2)?;
        within("lead_deceleration_mps2", self.lead_deceleration_mps2, 0.5, 12.0)
    }
}

/// Settings of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The truck as the law knows it.
    pub truck: Truck,
    /// Which planner drives.
    pub planner: PlannerKind,
    /// Mean speed to keep on a free road, relative to the set speed.
    pub mean_speed: f64,
    /// Drives a car, by accelerations: kept at a safe gap and stopped softly.
    pub car: Option<CarGap>,
}

/// How a car's gap is kept safe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarGap {
    /// Lag of the car's acceleration behind the request, s.
    pub lag_s: f64,
    /// Hardest deceleration of the vehicle ahead that is reckoned with, m/s².
    pub lead_deceleration_mps2: f64,
}

impl Settings {
    /// Settings for a truck whose mean speed is to be its set speed.
    #[must_use]
    pub fn new(truck: &Truck, planner: PlannerKind) -> Self {
        Self { truck: *truck, planner, mean_speed: 1.0, car: None }
    }
}
