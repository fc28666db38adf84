//! Scenario files: the course of a run and its parameters.
//!
//! A scenario is a TOML document. A key that is not written has a default. An unknown key is refused. Units are part
//! of the names. [`Scenario::open`] reads a built-in scenario or a file, lays the command line's overrides over it and
//! checks it. A mistake comes back as a [`ScenarioError`] that shows the line. [`Scenario::to_toml`] writes the scenario
//! as it took effect, files included; a run keeps this text. [`schema`] has all keys as data.
//!
//! ```
//! let text = r#"
//!     schema_version = 1
//!     name = "short"
//!     [plant]
//!     initial_speed_mps = 15
//!     [[actors]]
//!     name = "lead"
//!     gap_m = 40
//!     initial_speed_mps = 15
//!     profile.sine = { amplitude_mps2 = 2, period_s = 10 }
//! "#;
//! let scenario = scenario::Scenario::parse("short.toml", text)?;
//! assert_eq!(scenario.actors[0].gap_m.value(), 40.0);
//! # Ok::<(), scenario::ScenarioError>(())
//! ```
//!
//! Positions along the road count from the ego's front bumper at the start of the run. Lateral positions count from the
//! centre of its lane, left positive. Times count from the start of the run.

#![allow(
    clippy::result_large_err,
    reason = "an error ends the reading of a file; its size costs nothing"
)]

// `#[derive(Schema)]` names this crate as its users do.
extern crate self as scenario;

use serde::{Deserialize, Serialize};

pub mod actor;
pub mod aebs;
pub mod builtin;
pub mod carrier;
pub mod controller;
pub mod course;
pub mod curve_speed;
pub mod cycle;
pub mod event;
pub mod faults;
pub mod lateral;
pub mod name;
pub mod own_law;
pub mod per_service;
pub mod perception;
pub mod plan;
pub mod plant;
pub mod preview;
pub mod quantity;
pub mod radio;
pub mod recorded;
pub mod referee;
pub mod require;
pub mod road;
pub mod runtime;
pub mod schema;
pub mod speeds;
pub mod storyboard;
pub mod supervision;
pub mod translation;
pub mod v2x;

mod accepted;
mod binary;
mod check;
mod document;
mod error;
mod event_script;
mod files;
mod foreign;
pub mod grade;
mod law_tables;
mod open;
mod overrides;
mod placed;
mod problem;
mod reads;
mod refusal;
mod start_notices;
mod table;

pub use accepted::accepted;
pub use binary::DecodeError;
pub use document::MAX_TEXT_BYTES;
pub use error::ScenarioError;
pub use foreign::ForeignKeys;
pub use law_tables::LawTables;
pub use open::Source;
pub use overrides::Overrides;
pub use problem::Problem;
pub use reads::Reads;

use actor::Actor;
use aebs::Aebs;
use controller::Controller;
use document::Document;
use faults::Fault;
use messages::{Presence, Service};
use name::{Line, Name};
use own_law::OwnLaws;
use perception::Perception;
use plant::Plant;
use quantity::{Duration, Seed, Speed};
use referee::Referee;
use require::Require;
use road::Road;
use runtime::Runtime;
use schema::Schema;
use storyboard::Storyboard;
use supervision::Supervision;
use v2x::V2x;

/// The version of the schema that this program reads.
pub const SCHEMA_VERSION: u32 = 1;

/// A whole scenario, checked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Version of the schema: 1.
    pub schema_version: u32,
    /// Name.
    pub name: Name,
    /// Its subject, in one line.
    #[serde(default)]
    pub description: Line,
    /// Duration of the run, s.
    #[serde(default = "ten_seconds")]
    pub duration_s: Duration,
    /// Seed of all random numbers.
    #[serde(default = "first_seed")]
    pub seed: Seed,
    /// The driver's set speed, m/s.
    #[serde(default = "motorway_speed")]
    pub set_speed_mps: Speed,
    /// The legal limit on this road, m/s; absent: not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_limit_mps: Option<Speed>,
    /// The ego vehicle.
    #[serde(default)]
    pub plant: Plant,
    /// The road's heights and its plan; absent: level and straight.
    #[serde(default, skip_serializing_if = "Road::is_absent")]
    pub road: Road,
    /// Radar, tracker and target selection.
    #[serde(default)]
    pub perception: Perception,
    /// The emergency brake.
    #[serde(default)]
    pub aebs: Aebs,
    /// Measures of the referee.
    #[serde(default, skip_serializing_if = "Referee::is_default")]
    pub referee: Referee,
    /// The roadside unit and its signals.
    #[serde(default)]
    pub v2x: V2x,
    /// The control law and its loop.
    #[serde(default)]
    pub controller: Controller,
    /// Laws of the user's own by name: `command`, `directory`, `env`, `arguments`.
    #[serde(default, skip_serializing_if = "OwnLaws::is_empty")]
    pub laws: OwnLaws,
    /// Scheduling and placement.
    #[serde(default)]
    pub runtime: Runtime,
    /// Restarts and standbys of services that die or hang.
    #[serde(default)]
    pub supervision: Supervision,
    /// Requirements on a completed run.
    #[serde(default)]
    pub require: Require,
    /// The other vehicles.
    #[serde(default)]
    pub actors: Vec<Actor>,
    /// Faults.
    #[serde(default, deserialize_with = "faults::taken", skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<Fault>,
    /// The storyboard that moves the actors with the profile `storyboard`; comes from an OpenSCENARIO
    /// file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub storyboard: Option<Storyboard>,
    /// Remarks on keys without effect, for the person who starts a run.
    #[serde(skip)]
    pub notes: Vec<String>,
}

impl Scenario {
    /// Remarks for the person who starts a run: on keys without effect and on the storyboard.
    pub fn notices(&self) -> impl Iterator<Item = &str> {
        let storyboard = self.storyboard.iter().flat_map(|storyboard| &storyboard.notices);
        self.notes.iter().chain(storyboard).map(String::as_str)
    }

    /// True if the emergency brake is on.
    #[must_use]
    pub fn has_aebs(&self) -> bool {
        self.aebs.enabled.unwrap_or_else(|| self.perception.gives_detections())
    }

    /// True if signals come as frames, which an on-board unit decodes.
    #[must_use]
    pub fn has_obu(&self) -> bool {
        !self.v2x.radio.is_direct()
    }

    /// The services that the scenario's group consists of.
    #[must_use]
    pub fn services(&self) -> Vec<Service> {
        let takes_part = |service: &Service| match service.descriptor().presence {
            Presence::Always => true,
            Presence::EmergencyBrake => self.has_aebs(),
            Presence::Frames => self.has_obu(),
        };
        Service::ALL.into_iter().filter(takes_part).collect()
    }

    /// The scenario as it took effect: parsing this text gives an equal scenario.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let keys = toml::to_string(self).expect("every value of a scenario has a form in TOML");
        document::KEPT.to_owned() + &keys
    }
}

/// Reads another file of the same form, such as a campaign, into its type, and has it checked. `source` stands
/// for it in errors.
///
/// # Errors
/// If the text is not TOML, does not fit the type, or does not pass the check. The error shows the line and what was
/// expected.
pub fn read_as<T: serde::de::DeserializeOwned>(
    source: &str,
    text: &str,
    check: impl FnOnce(&T) -> Result<(), Problem>,
) -> Result<T, ScenarioError> {
    let none = Overrides::new();
    let document = Document::parse(source, text, &none)?;
    let (value, ()) = document.read(|_| (), |_| None)?;
    check(&value).map_err(|problem| document.problem(&problem))?;
    Ok(value)
}

/// Reads a table of a road's height or grade over distance. `source` stands for it in errors.
///
/// # Errors
/// When the text is not such a table; shows the line.
pub fn read_road(source: &str, text: &str) -> Result<crate::grade::GradeProfile, ScenarioError> {
    road::parse_csv(source, text)
}

fn ten_seconds() -> Duration {
    Duration::of(10.0)
}

fn first_seed() -> Seed {
    Seed::of(1)
}

fn motorway_speed() -> Speed {
    Speed::of(33.3)
}

#[cfg(test)]
mod tests;
