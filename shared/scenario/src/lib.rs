//! Scenario files: what happens in a run, and with which parameters.
//!
//! A scenario is a TOML document. Every key that is not written has a default, every key that is
//! not known is refused, units are part of the names. [`Scenario::open`] reads a built-in scenario
//! or a file, lays the command line's overrides over it and checks it; what is wrong comes back as
//! a [`ScenarioError`] that shows the line. [`Scenario::to_toml`] writes the scenario as it took
//! effect, files included, so that it can be kept with the run and handed to every service.
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
//! Positions along the road count from the ego's front bumper at the start of the run, lateral
//! positions from the centre of its lane, left positive; times from the start of the run.

#![allow(
    clippy::result_large_err,
    reason = "an error ends the reading of a file; its size costs nothing"
)]

use std::path::Path;

use serde::{Deserialize, Serialize};

pub mod actor;
pub mod aebs;
pub mod builtin;
pub mod carrier;
pub mod controller;
pub mod cycle;
pub mod event;
pub mod faults;
pub mod name;
pub mod own_law;
pub mod perception;
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
mod keys;
mod law_tables;
mod overrides;
mod placed;
mod problem;
mod reads;
mod refusal;
mod table;

pub use accepted::accepted;
pub use binary::DecodeError;
pub use document::MAX_TEXT_BYTES;
pub use error::ScenarioError;
pub use foreign::ForeignKeys;
pub use law_tables::LawTables;
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
use quantity::{Duration, PeriodMs, Seed, Speed};
use referee::Referee;
use require::Require;
use road::Road;
use runtime::Runtime;
use storyboard::Storyboard;
use supervision::Supervision;
use v2x::V2x;

/// The version of the schema that this program reads.
pub const SCHEMA_VERSION: u32 = 1;

/// A whole scenario, checked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Version of the schema: 1.
    pub schema_version: u32,
    /// Name.
    pub name: Name,
    /// What it is about, in one line.
    #[serde(default)]
    pub description: Line,
    /// How long the run lasts, s.
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
    /// The road's heights; absent: level.
    #[serde(default, skip_serializing_if = "Road::is_level")]
    pub road: Road,
    /// Radar, tracker and target selection.
    #[serde(default)]
    pub perception: Perception,
    /// The emergency brake.
    #[serde(default)]
    pub aebs: Aebs,
    /// What the referee measures against.
    #[serde(default, skip_serializing_if = "Referee::is_default")]
    pub referee: Referee,
    /// The roadside unit and its signals.
    #[serde(default)]
    pub v2x: V2x,
    /// The control law and its loop.
    #[serde(default)]
    pub controller: Controller,
    /// Laws of the user's own by name: `command`, `directory`, `env`, `arguments`, or `library`.
    #[serde(default, skip_serializing_if = "OwnLaws::is_empty")]
    pub laws: OwnLaws,
    /// Scheduling and placement.
    #[serde(default)]
    pub runtime: Runtime,
    /// What becomes of services that die or hang.
    #[serde(default)]
    pub supervision: Supervision,
    /// What the run must keep to count as completed.
    #[serde(default)]
    pub require: Require,
    /// The other vehicles.
    #[serde(default)]
    pub actors: Vec<Actor>,
    /// What goes wrong.
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
    /// Reads a scenario from its text. `source_name` stands for it in errors.
    ///
    /// # Errors
    /// When the text is not a scenario, or names files, which only [`Scenario::open`] reads.
    pub fn parse(source_name: &str, text: &str) -> Result<Self, ScenarioError> {
        Self::build(source_name, text, &Overrides::new(), Place::TakenEffect, &|_| {
            Ok(Reads::everything())
        })
    }

    /// Reads a scenario from its text with `overrides` laid over it. `check` is asked last.
    ///
    /// # Errors
    /// As [`Scenario::parse`], or when an override does not fit.
    pub fn parse_with(
        source_name: &str,
        text: &str,
        overrides: &Overrides,
        check: &dyn Fn(&Self) -> Result<Reads, Problem>,
    ) -> Result<Self, ScenarioError> {
        Self::build(source_name, text, overrides, Place::TakenEffect, check)
    }

    /// Opens the built-in scenario of that name or the file at that path, with `overrides` laid
    /// over it. `check` is asked last, for what only the control laws know.
    ///
    /// # Errors
    /// When there is no such scenario, it cannot be read, or something in it is wrong.
    pub fn open(
        argument: &str,
        overrides: &Overrides,
        check: &dyn Fn(&Self) -> Result<Reads, Problem>,
    ) -> Result<Self, ScenarioError> {
        if let Some(builtin) = builtin::find(argument) {
            let source = format!("built-in {argument}");
            return Self::build(&source, builtin.text, overrides, Place::BuiltIn(None), check);
        }
        let path = Path::new(argument);
        let looks_like_a_path = argument.ends_with(".toml") || argument.contains('/');
        if !looks_like_a_path && !path.exists() {
            return Err(builtin::unknown(argument));
        }
        let text = files::read(path, MAX_TEXT_BYTES)
            .map_err(|reason| ScenarioError::whole(argument, reason.to_string()))?;
        Self::build(argument, &text, overrides, Place::In(path.parent().unwrap_or(path)), check)
    }

    /// Opens an OpenSCENARIO file with its catalogs and its road, as a scenario with `overrides` laid
    /// over it. `parameters` take the place of the values that the file declares.
    ///
    /// # Errors
    /// When a file cannot be read or is outside the subset of the standard that is read here, or when
    /// an override does not fit.
    pub fn open_openscenario(
        path: &Path,
        parameters: &[openscenario::Assignment],
        overrides: &Overrides,
        check: &dyn Fn(&Self) -> Result<Reads, Problem>,
    ) -> Result<Self, translation::OpenError> {
        Ok(Self::from_foreign(&translation::keys_of(path, parameters)?, overrides, check)?)
    }

    /// Builds a scenario from the keys of a file of another format, with `overrides` laid over them.
    /// `check` is asked last.
    ///
    /// # Errors
    /// When a key or an override does not fit; the error names the place in the file, or the option.
    pub fn from_foreign(
        keys: &ForeignKeys,
        overrides: &Overrides,
        check: &dyn Fn(&Self) -> Result<Reads, Problem>,
    ) -> Result<Self, ScenarioError> {
        let document = Document::of_foreign(keys, overrides)?;
        Self::of_document(&document, Place::BuiltIn(keys.storyboard()), check)
    }

    fn build(
        source: &str,
        text: &str,
        overrides: &Overrides,
        place: Place<'_>,
        check: &dyn Fn(&Self) -> Result<Reads, Problem>,
    ) -> Result<Self, ScenarioError> {
        Self::of_document(&Document::parse(source, text, overrides)?, place, check)
    }

    fn of_document(
        document: &Document<'_>,
        place: Place<'_>,
        check: &dyn Fn(&Self) -> Result<Reads, Problem>,
    ) -> Result<Self, ScenarioError> {
        if let Some(version) = document.integer("schema_version")
            && version != i64::from(SCHEMA_VERSION)
        {
            return Err(document.problem(&Problem::new(
                "schema_version",
                format!("version {version} of the schema is not known"),
                format!("{SCHEMA_VERSION}"),
            )));
        }
        let (mut scenario, (tables, faults)): (Self, _) = document
            .read(|root| (LawTables::take_from(root), faults::take_from(root)), schema::path_of)?;
        scenario.controller.tables = tables;
        if let Place::BuiltIn(Some(storyboard)) = place {
            scenario.storyboard = Some(storyboard.clone());
        }
        scenario.faults =
            faults::written(faults.as_ref()).map_err(|problem| document.problem(&problem))?;
        road::one_source(|path| document.has(path))
            .map_err(|problem| document.problem(&problem))?;
        let is_written = |path: &str| document.has(path) && !matches!(place, Place::TakenEffect);
        (scenario.perception.unite(is_written)).map_err(|problem| document.problem(&problem))?;
        let directory = place.directory();
        scenario.follow_a_fast_controller(|path| document.has(path));
        scenario.follow_a_delay(|path| document.has(path));
        if scenario.plant.vehicle.is_truck() {
            scenario.aebs.follow_truck(|path| document.has(path));
        }
        scenario.controller.place_command(directory);
        own_law::place(&mut scenario.laws, directory);
        scenario.v2x.radio.place(directory);
        let of_records = files::load(&mut scenario, document, directory)?;
        check::all(&scenario).map_err(|problem| document.problem(&problem))?;
        let reads = check(&scenario).map_err(|problem| document.problem(&problem))?;
        scenario.notes = of_records;
        if !matches!(place, Place::TakenEffect) {
            let notes = reads.judge(document).and_then(|mut notes| {
                notes.extend(reads::judge_radar(document, &scenario.perception)?);
                Ok(notes)
            });
            let notes = notes.map_err(|problem| document.problem(&problem))?;
            // A file that a run has kept has every key, read or not.
            if !document.is_kept() {
                scenario.notes.extend(notes);
            }
        }
        Ok(scenario)
    }

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

    /// Periods that were not written follow a control period that is shorter than they are: the plant's
    /// becomes equal, and a timer releases the controller instead of the slower radar.
    fn follow_a_fast_controller(&mut self, is_written: impl Fn(&str) -> bool) {
        let period_ms = self.controller.period_ms;
        if period_ms < self.plant.period_ms && !is_written("plant.period_ms") {
            self.plant.period_ms = period_ms;
        }
        if period_ms < self.perception.period_ms && !is_written("controller.release") {
            self.controller.release = controller::Release::Timer;
        }
    }

    /// A plant's period that was not written divides the delay of commands: else the delay would end between
    /// two of its steps.
    fn follow_a_delay(&mut self, is_written: impl Fn(&str) -> bool) {
        if is_written("plant.period_ms") {
            return;
        }
        let (mut period, mut rest) =
            (self.plant.period_ms.value(), self.runtime.extra_delay_ms.value());
        // Euclid's greatest common divisor.
        while rest > 0 {
            (period, rest) = (rest, period % rest);
        }
        self.plant.period_ms = PeriodMs::of(period);
    }

    /// The scenario as it took effect: parsing this text gives an equal scenario.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let keys = toml::to_string(self).expect("every value of a scenario has a form in TOML");
        document::KEPT.to_owned() + &keys
    }
}

/// Where a scenario's text is from.
#[derive(Clone, Copy)]
enum Place<'a> {
    /// The program, or a file of another format with its storyboard.
    BuiltIn(Option<&'a Storyboard>),
    /// A file in this directory.
    In(&'a Path),
    /// A run: all keys as they took effect.
    TakenEffect,
}

impl<'a> Place<'a> {
    /// Where paths in it begin.
    fn directory(self) -> Option<&'a Path> {
        match self {
            Self::In(directory) => Some(directory),
            Self::BuiltIn(_) | Self::TakenEffect => None,
        }
    }
}

/// Reads another file of the same form, such as a campaign, into its type, and has it checked. `source` stands
/// for it in errors.
///
/// # Errors
/// When the text is no TOML, does not fit the type or does not pass the check; shows the line and what was
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
/// When the text is no such table; shows the line.
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
