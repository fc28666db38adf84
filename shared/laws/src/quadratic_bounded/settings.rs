//! The settings of the law outside its design.

use law::settings;
use parameters::parameters;
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

parameters! {
    /// Settings of the law outside its design, as `[controller.quadratic_bounded]` holds them.
    #[derive(Deserialize, Serialize, Schema)]
    #[serde(default, deny_unknown_fields)]
    pub struct Settings {
        /// Targets beyond this range are not followed, m.
        sensor_range_m: f64 = 150.0, "m", 1.0..=1000.0, "Chosen.";
        /// Gap errors above this are taken for this, m.
        gap_error_limit_m: f64 = 20.0, "m", 0.0..=1000.0, "Chosen.";
        /// Gap errors that would make V larger than this are taken for smaller ones.
        envelope_limit: f64 = 0.98, "1", 0.01..=1.0, "Chosen.";
        /// Full braking of the fall-back, m/s² (positive).
        fall_back_braking_mps2: f64 = 6.0, "m/s²", 1.0..=12.0, "Chosen.";
        /// Hardest deceleration of the lead that the fall-back assumes, m/s² (positive).
        lead_deceleration_mps2: f64 = 9.0, "m/s²", 0.5..=12.0, "Chosen.";
        others {
            /// Source of the gains: the certified design, or the paper as it is printed.
            gains: GainSource = GainSource::Certified;
            /// Path of a design file; absent: the design that comes with the law.
            #[serde(skip_serializing_if = "Option::is_none")]
            design: Option<String> = None;
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

impl settings::Settings for Settings {}
