//! Steps of opening a scenario: read, override, complete and check, in this order.

use std::path::{Path, PathBuf};

use super::document::Document;
use super::foreign::ForeignKeys;
use super::overrides::Overrides;
use super::own_law;
use super::placed::Placed;
use super::problem::Problem;
use super::quantity::PeriodMs;
use super::reads::{self, Reads};
use super::storyboard::Storyboard;
use super::{
    LawTables, MAX_TEXT_BYTES, SCHEMA_VERSION, Scenario, ScenarioError, builtin, check, controller,
    faults, files, road, schema, translation,
};

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

    /// Opens the built-in scenario of that name or the file at that path, with `overrides` laid over it. `check` is
    /// asked last, for conditions that only the control laws have.
    ///
    /// # Errors
    /// When there is no such scenario, it cannot be read, or something in it is wrong.
    pub fn open(
        argument: &str,
        overrides: &Overrides,
        check: &dyn Fn(&Self) -> Result<Reads, Problem>,
    ) -> Result<Self, ScenarioError> {
        Source::read(argument)?.open(overrides, check)
    }

    /// Opens an OpenSCENARIO file with its catalogs and its road, as a scenario with `overrides` laid
    /// over it. The `choices` have values that replace the declared ones.
    ///
    /// # Errors
    /// If a file cannot be read, or is outside the supported subset of the standard, or if an override does not fit.
    pub fn open_openscenario(
        path: &Path,
        choices: &openscenario::Choices,
        overrides: &Overrides,
        check: &dyn Fn(&Self) -> Result<Reads, Problem>,
    ) -> Result<Self, translation::OpenError> {
        Ok(Self::from_foreign(&translation::keys_of(path, choices)?, overrides, check)?)
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

    pub(super) fn build(
        source: &str,
        text: &str,
        overrides: &Overrides,
        place: Place<'_>,
        check: &dyn Fn(&Self) -> Result<Reads, Problem>,
    ) -> Result<Self, ScenarioError> {
        Self::of_document(&Document::parse(source, text, overrides)?, place, check)
    }

    pub(super) fn of_document(
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
        if let (Some(_), Some(truck_kg)) = (scenario.road.plan(), scenario.plant.vehicle.truck_kg())
        {
            let mass_kg = truck_kg * scenario.plant.mass_factor.value();
            scenario.plant.lateral.follow_truck(mass_kg, |path| document.has(path));
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

    /// Periods that were not written follow a control period that is shorter than they are. The plant's becomes equal,
    /// and a timer releases the controller instead of the slower radar.
    fn follow_a_fast_controller(&mut self, is_written: impl Fn(&str) -> bool) {
        let period_ms = self.controller.period_ms;
        if period_ms < self.plant.period_ms && !is_written("plant.period_ms") {
            self.plant.period_ms = period_ms;
        }
        if period_ms < self.perception.period_ms && !is_written("controller.release") {
            self.controller.release = controller::Release::Timer;
        }
    }

    /// A plant's period that was not written divides the delay of commands. Else the delay would end between two of its
    /// steps.
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
}

/// A scenario's file that was read and parsed. It can be opened many times, each time with other keys laid over it.
///
/// ```
/// use scenario::{Overrides, Reads, Scenario, Source};
///
/// let source = Source::read("following")?;
/// let check = |_: &Scenario| Ok(Reads::everything());
/// for seed in [1, 2] {
///     let mut overrides = Overrides::new();
///     overrides.option("--seed", "seed", &seed.to_string());
///     assert_eq!(source.open(&overrides, &check)?.seed.value(), seed);
/// }
/// # Ok::<(), scenario::ScenarioError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Source {
    /// Its name in errors.
    name: String,
    text: String,
    root: Placed,
    /// The directory at which paths in it begin; none: it is built in.
    directory: Option<PathBuf>,
}

impl Source {
    /// Reads the built-in scenario of that name or the file at that path.
    ///
    /// # Errors
    /// If there is no such scenario, or it cannot be read or is not TOML.
    pub fn read(argument: &str) -> Result<Self, ScenarioError> {
        if let Some(builtin) = builtin::find(argument) {
            return Self::parse(format!("built-in {argument}"), builtin.text.to_owned(), None);
        }
        let path = Path::new(argument);
        let looks_like_a_path = argument.ends_with(".toml") || argument.contains('/');
        if !looks_like_a_path && !path.exists() {
            return Err(builtin::unknown(argument));
        }
        let text = files::read(path, MAX_TEXT_BYTES)
            .map_err(|reason| ScenarioError::whole(argument, reason.to_string()))?;
        let directory = path.parent().unwrap_or(path).to_owned();
        Self::parse(argument.to_owned(), text, Some(directory))
    }

    fn parse(
        name: String,
        text: String,
        directory: Option<PathBuf>,
    ) -> Result<Self, ScenarioError> {
        let root = Document::root_of(&name, &text)?;
        Ok(Self { name, text, root, directory })
    }

    /// The scenario with `overrides` laid over the file. `check` is asked last, for conditions that only the control
    /// laws have.
    ///
    /// # Errors
    /// When something in the file or in an override is wrong.
    pub fn open(
        &self,
        overrides: &Overrides,
        check: &dyn Fn(&Scenario) -> Result<Reads, Problem>,
    ) -> Result<Scenario, ScenarioError> {
        let Self { name, text, root, directory } = self;
        let document = Document::of_parsed(name, text, root.clone(), overrides)?;
        let place = directory.as_deref().map_or(Place::BuiltIn(None), Place::In);
        Scenario::of_document(&document, place, check)
    }
}

/// The source of a scenario's text.
#[derive(Clone, Copy)]
pub(crate) enum Place<'a> {
    /// The program, or a file of another format with its storyboard.
    BuiltIn(Option<&'a Storyboard>),
    /// A file in this directory.
    In(&'a Path),
    /// A run: all keys as they took effect.
    TakenEffect,
}

impl<'a> Place<'a> {
    /// The directory at which paths in it begin.
    fn directory(self) -> Option<&'a Path> {
        match self {
            Self::In(directory) => Some(directory),
            Self::BuiltIn(_) | Self::TakenEffect => None,
        }
    }
}
