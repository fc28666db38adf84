//! The table `[controller.external]`.

use crate::settings::{self, Ranges};
use scenario::schema::Schema;
use serde::{Deserialize, Serialize};

/// Settings of the law `external`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Time that the program has for its first answer, and in simulated time for each, s.
    pub patience_s: f64,
    /// Time without an answer after which a program is replaced in real time, s.
    pub silence_s: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { patience_s: 8.0, silence_s: 0.5 }
    }
}

impl settings::Settings for Settings {
    fn ranges(&self, see: &mut Ranges<'_>) {
        see.within("patience_s", self.patience_s, 0.1, 600.0);
        see.within("silence_s", self.silence_s, 0.01, 600.0);
    }
}
