//! The settings of the law outside its design.

use crate::settings::{self, Ranges};
use scenario::schema::Schema;
use serde::{Deserialize, Serialize};

/// Source of the gains.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, Schema)]
#[serde(rename_all = "kebab-case")]
pub enum GainSource {
    /// The design, which is proven at every start.
    #[default]
    Certified,
    /// The paper's output equation, of which nothing is proven: for study.
    Printed,
}

/// Settings of the law outside its design, as `[controller.quadratic_bounded]` holds them.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, Schema)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Source of the gains: the certified design, or the paper as it is printed.
    pub gains: GainSource,
    /// Path of a design file; absent: the design that comes with the law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub design: Option<String>,
    /// Targets beyond this range are not followed, m.
    pub sensor_range_m: f64,
    /// Gap errors above this are taken for this, m.
    pub gap_error_limit_m: f64,
    /// Gap errors that would make V larger than this are taken for smaller ones.
    pub envelope_limit: f64,
    /// Full braking of the fall-back, m/s² (positive).
    pub fall_back_braking_mps2: f64,
    /// Hardest deceleration of the lead that the fall-back assumes, m/s² (positive).
    pub lead_deceleration_mps2: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            gains: GainSource::Certified,
            design: None,
            sensor_range_m: 150.0,
            gap_error_limit_m: 20.0,
            envelope_limit: 0.98,
            fall_back_braking_mps2: 6.0,
            lead_deceleration_mps2: 9.0,
        }
    }
}

impl Settings {
    /// The key that the chosen gains do not use: without a V there is nothing to keep within it.
    pub(super) fn unused(&self) -> &'static [&'static str] {
        match self.gains {
            GainSource::Certified => &[],
            GainSource::Printed => &["envelope_limit"],
        }
    }
}

impl settings::Settings for Settings {
    fn ranges(&self, see: &mut Ranges<'_>) {
        see.within("sensor_range_m", self.sensor_range_m, 1.0, 1000.0);
        see.within("gap_error_limit_m", self.gap_error_limit_m, 0.0, 1000.0);
        see.within("envelope_limit", self.envelope_limit, 0.01, 1.0);
        see.within("fall_back_braking_mps2", self.fall_back_braking_mps2, 1.0, 12.0);
        see.within("lead_deceleration_mps2", self.lead_deceleration_mps2, 0.5, 12.0);
    }
}
