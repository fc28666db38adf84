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

mod check;
mod ego;
mod group;
mod reading;
mod roads;
mod signals;
mod traffic;

pub mod builtin;
pub mod faults;
pub mod name;
pub mod quantity;
pub mod schema;

pub use ::road::grade;
pub use ego::{aebs, controller, lateral, own_law, perception, plant};
pub use group::{referee, runtime, supervision};
pub use reading::problem::accepted;
pub use reading::{
    LawTables, MAX_TEXT_BYTES, Overrides, Problem, Reads, Refusal, ScenarioError, Setting, Source,
    option_value,
};
pub use roads::{plan, road};
pub use signals::{carrier, radio, v2x};
pub use toml::{Table, Value};
pub use traffic::{actor, event, recorded, speeds, storyboard, sumo as sumo_traffic, translation};

use serde::de::DeserializeOwned;

use actor::Actor;
use aebs::Aebs;
use controller::Controller;
use faults::Fault;
use messages::{Presence, Service};
use name::{Line, Name};
use own_law::OwnLaws;
use perception::Perception;
use plant::Plant;
use quantity::{Duration, Seed, Speed};
use reading::Document;
use referee::{Referee, Require};
use road::Road;
use runtime::Runtime;
use scenario_derive::tables;
use schema::{Key, Shape};
use storyboard::Storyboard;
use sumo_traffic::Traffic;
use supervision::Supervision;
use v2x::V2x;

/// The version of the schema that this program reads.
pub const SCHEMA_VERSION: u32 = 1;

tables! {
    /// A whole scenario, checked.
    pub struct Scenario {
        /// Version of the schema: 1.
        pub schema_version: u32,
        /// Name.
        pub name: Name,
        /// Its subject, in one line.
        pub description: Line = "",
        /// Duration of the run, s.
        pub duration_s: Duration = 10.0,
        /// Seed of all random numbers.
        pub seed: Seed = 1,
        /// The driver's set speed, m/s.
        pub set_speed_mps: Speed = 33.3,
        /// The legal limit on this road, m/s; absent: not known.
        pub speed_limit_mps: Option<Speed>,
        /// The ego vehicle.
        pub plant: Plant = default,
        /// The road's heights and its plan; absent: level and straight.
        pub road: Road = sparse,
        /// Radar, tracker and target selection.
        pub perception: Perception = default,
        /// The emergency brake.
        pub aebs: Aebs = default,
        /// Measures of the referee.
        pub referee: Referee = sparse,
        /// The roadside unit and its signals.
        pub v2x: V2x = default,
        /// The control law and its loop.
        pub controller: Controller = default,
        /// Laws of the user's own by name: `command`, `directory`, `env`, `arguments`.
        pub laws: OwnLaws = sparse,
        /// Scheduling and placement.
        pub runtime: Runtime = default,
        /// Restarts and standbys of services that die or hang.
        pub supervision: Supervision = default,
        /// Requirements on a completed run.
        pub require: Require = default,
        /// SUMO as the traffic around the ego.
        pub traffic: Traffic = sparse,
        /// The other vehicles.
        pub actors: Vec<Actor> = default,
        /// Faults.
        pub faults: Vec<Fault> = sparse,
        /// The storyboard that moves the actors with the profile `storyboard`; comes from an OpenSCENARIO file.
        pub storyboard: Option<Storyboard>,
        /// Remarks on keys without effect, for the person who starts a run.
        #[serde(skip)]
        pub notes: Vec<String>,
    }
}

impl Scenario {
    /// Remarks for the person who starts a run: on keys without effect and on the storyboard.
    pub fn notices(&self) -> impl Iterator<Item = &str> {
        let storyboard = self.storyboard.iter().flat_map(|storyboard| &storyboard.notices);
        self.notes.iter().chain(storyboard).map(String::as_str)
    }

    /// Reason why the story of its OpenSCENARIO file cannot happen, as far as that is known before the drive.
    ///
    /// ```
    /// let text = scenario::builtin::find("cut-in").expect("built in").text;
    /// assert_eq!(scenario::Scenario::parse("cut-in", text)?.hindrance(), None);
    /// # Ok::<(), scenario::ScenarioError>(())
    /// ```
    pub fn hindrance(&self) -> Option<String> {
        let storyboard = self.storyboard.as_ref()?;
        let stands =
            self.set_speed_mps.value() == 0.0 && self.plant.initial_speed_mps.value() == 0.0;
        let waits = || "the ego stands, and its set speed is 0 m/s".to_owned();
        storyboard.hindrance.clone().or_else(|| stands.then(waits))
    }

    /// True if the emergency brake is on.
    pub fn has_aebs(&self) -> bool {
        self.aebs.enabled.unwrap_or_else(|| self.perception.gives_detections())
    }

    /// True if signals come as frames, which an on-board unit decodes.
    pub fn has_obu(&self) -> bool {
        self.v2x.radio != radio::Radio::Direct
    }

    /// The services that the scenario's group consists of.
    pub fn services(&self) -> Vec<Service> {
        let takes_part = |service: &Service| match service.descriptor().presence {
            Presence::Always => true,
            Presence::EmergencyBrake => self.has_aebs(),
            Presence::Frames => self.has_obu(),
        };
        Service::ALL.into_iter().filter(takes_part).collect()
    }

    /// The scenario as it took effect: parsing this text gives an equal scenario.
    pub fn to_toml(&self) -> String {
        let keys = toml::to_string(self).expect("every value of a scenario has a form in TOML");
        reading::KEPT.to_owned() + &keys
    }
}

/// Reads another file of the same form, such as a campaign, into its type, and has it checked. `source` stands
/// for it in errors.
///
/// # Errors
/// If the text is not TOML, does not fit the type, or does not pass the check. The error shows the line and what was
/// expected.
pub fn read_as<T: DeserializeOwned>(
    source: &str,
    text: &str,
    check: impl FnOnce(&T) -> Result<(), Problem>,
) -> Result<T, ScenarioError> {
    let none = Overrides::new();
    let document = Document::parse(source, text, &none)?;
    let value = document.read()?;
    check(&value).map_err(|problem| document.error(&problem))?;
    Ok(value)
}

/// A table of keys and values.
///
/// ```
/// let keys = scenario::table! { kind: "drop", for_s: 0.5, when: scenario::table! { standstill: true } };
/// assert_eq!(keys["for_s"].as_float(), Some(0.5));
/// ```
#[macro_export]
macro_rules! table {
    ($($key:ident: $value:expr),* $(,)?) => {
        $crate::Table::from_iter([$((stringify!($key).to_owned(), $crate::Value::from($value))),*])
    };
}

/// The keys of a scenario file.
pub fn keys() -> &'static [Key] {
    match schema::shape_of::<Scenario>() {
        Shape::Table(keys) => keys,
        _ => &[],
    }
}

/// The dotted path of the only key of a scenario file with this name.
pub(crate) fn path_of(name: &str) -> Option<String> {
    let mut found = paths(keys(), "", name);
    found.pop().filter(|_| found.is_empty())
}

/// The paths of all keys of a name among `keys`, whose own paths begin with `above`.
fn paths(keys: &[Key], above: &str, name: &str) -> Vec<String> {
    let of_key = |key: &Key| {
        let path = format!("{above}{}", key.name);
        let mut found = match &key.shape {
            Shape::Table(below) => paths(below, &format!("{path}."), name),
            _ => Vec::new(),
        };
        found.extend((key.name == name).then_some(path));
        found
    };
    keys.iter().flat_map(of_key).collect()
}

#[cfg(test)]
mod tests;
