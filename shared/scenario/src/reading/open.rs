//! Steps of opening a scenario: read, override, complete and check, in this order.

use std::path::{Path, PathBuf};

use toml::{Table, Value};

use super::document::{Document, MAX_TEXT_BYTES, Origin};
use super::error::{Refusal, ScenarioError};
use super::law_tables::LawTables;
use super::load::load;
use super::overrides::Overrides;
use super::problem::Problem;
use super::reads::{self, Reads};
use super::setting::Setting;
use super::{form, text_file};
use crate::controller::Release;
use crate::quantity::PeriodMs;
use crate::storyboard::Storyboard;
use crate::{SCHEMA_VERSION, Scenario, builtin, check, faults, road, table, translation};

/// A check that only the control laws have: the keys that the scenario's law reads.
type Check<'a> = &'a dyn Fn(&Scenario) -> Result<Reads, Problem>;

impl Scenario {
    /// Reads a scenario from its text. `source_name` stands for it in errors.
    ///
    /// # Errors
    /// When the text is not a scenario, or names files, which only [`Scenario::open`] reads.
    pub fn parse(source_name: &str, text: &str) -> Result<Self, ScenarioError> {
        Self::parse_with(source_name, text, &Overrides::new(), &|_| Ok(Reads::everything()))
    }

    /// Reads a scenario from its text with `overrides` laid over it. `check` is asked last.
    ///
    /// # Errors
    /// As [`Scenario::parse`], or when an override does not fit.
    pub fn parse_with(
        source_name: &str,
        text: &str,
        overrides: &Overrides,
        check: Check<'_>,
    ) -> Result<Self, ScenarioError> {
        let document = Document::parse(source_name, text, overrides)?;
        Self::of_document(&document, Place::TakenEffect, check)
    }

    /// Reads what [`Scenario::to_toml`] wrote, in another process of the run. The content of its files makes a text longer
    /// than any that a person writes.
    ///
    /// # Errors
    /// When the text comes from another version of the program.
    pub fn of_run(text: &str) -> Result<Self, ScenarioError> {
        let (source, none) = ("scenario", Overrides::new());
        let root = Document::root_of(source, text)?;
        let document = Document::new(Origin::Text { source, text }, root, &none)?;
        Self::of_document(&document, Place::TakenEffect, &|_| Ok(Reads::everything()))
    }

    /// The scenario that has these settings, with `overrides` laid over them. Other keys have their defaults.
    ///
    /// # Errors
    /// As [`Scenario::parse_with`].
    pub fn of_settings(
        settings: &[Setting],
        overrides: &Overrides,
        check: Check<'_>,
    ) -> Result<Self, ScenarioError> {
        let mut own = Overrides::new();
        own.option("schema_version", "schema_version", SCHEMA_VERSION);
        settings.iter().cloned().for_each(|setting| own.set(setting));
        let root = own.laid_over(Table::new())?;
        let document = Document::new(Origin::Values, root, overrides)?;
        Self::of_document(&document, Place::TakenEffect, check)
    }

    /// Opens the built-in scenario of that name or the file at that path, with `overrides` laid over it. `check` is
    /// asked last, for conditions that only the control laws have.
    ///
    /// # Errors
    /// When there is no such scenario, it cannot be read, or something in it is wrong.
    pub fn open(
        argument: &str,
        overrides: &Overrides,
        check: Check<'_>,
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
        check: Check<'_>,
    ) -> Result<Self, ScenarioError> {
        let (keys, storyboard) = translation::translated(path, choices)?;
        let document = Document::new(Origin::Foreign(&keys), keys.table.clone(), overrides)?;
        Self::of_document(&document, Place::BuiltIn(Some(&storyboard)), check)
    }

    pub(crate) fn of_document(
        document: &Document<'_>,
        place: Place<'_>,
        check: Check<'_>,
    ) -> Result<Self, ScenarioError> {
        Self::completed(document, place, check).map_err(|refusal| match refusal {
            Refusal::Key(problem) => document.error(&problem),
            Refusal::File(error) => error,
        })
    }

    fn completed(
        document: &Document<'_>,
        place: Place<'_>,
        check: Check<'_>,
    ) -> Result<Self, Refusal> {
        let mut scenario = Self::of_keys(document.root.clone())?;
        if let Place::BuiltIn(Some(storyboard)) = place {
            scenario.storyboard = Some(storyboard.clone());
        }
        let is_written = |path: &str| document.has(path);
        road::one_source(is_written)?;
        let is_taken_effect = matches!(place, Place::TakenEffect);
        scenario.perception.unite(|path| document.has(path) && !is_taken_effect)?;
        scenario.follow_other_keys(is_written);
        // Paths in a built-in scenario and in a run's begin nowhere.
        let directory = if let Place::In(directory) = place { Some(directory) } else { None };
        scenario.controller.place_command(directory);
        scenario.laws.values_mut().for_each(|law| law.place_command(directory));
        scenario.plant.place_unit(directory);
        scenario.v2x.radio.place(directory);
        let of_records = load(&mut scenario, document, directory)?;
        check::all(&scenario)?;
        let reads = check(&scenario)?;
        scenario.notes = of_records;
        if !is_taken_effect {
            let mut notes = reads.judge(document)?;
            notes.extend(reads::judge_radar(document, &scenario.perception)?);
            // A file that a run has kept has every key, read or not.
            if !document.is_kept() {
                scenario.notes.extend(notes);
            }
        }
        Ok(scenario)
    }

    fn of_keys(mut keys: Table) -> Result<Self, Problem> {
        if let Some(version) = keys.get("schema_version").and_then(Value::as_integer)
            && version != i64::from(SCHEMA_VERSION)
        {
            let message = format!("version {version} of the schema is not known");
            return Err(Problem::new("schema_version", message, format!("{SCHEMA_VERSION}")));
        }
        let tables = LawTables::take_from(&mut keys);
        let mut keys = Value::Table(keys);
        form::check_form::<Self>(&keys, "").map_err(Self::or_elsewhere)?;
        let faults = faults::take_from(&mut keys)?;
        let mut scenario: Self = form::plain(keys, "")?;
        scenario.controller.tables = tables;
        scenario.faults = faults;
        Ok(scenario)
    }

    /// Names the table in which an unknown key belongs, if no key of its own table is like it.
    fn or_elsewhere(problem: Problem) -> Problem {
        let name = problem.path.rsplit('.').next().unwrap_or_default();
        let is_open = problem.is_of_key && !problem.expected.contains("(did you mean");
        let Some(path) = crate::path_of(name).filter(|_| is_open) else { return problem };
        let expected = format!("{} (did you mean `{path}`?)", problem.expected);
        Problem { expected, ..problem }
    }

    /// Gives keys that were not written the values that follow from others.
    fn follow_other_keys(&mut self, is_written: impl Fn(&str) -> bool) {
        // A control period that is shorter than the plant's makes that equal, and a timer releases the controller
        // instead of the slower radar.
        let period_ms = self.controller.period_ms;
        if period_ms < self.plant.period_ms && !is_written("plant.period_ms") {
            self.plant.period_ms = period_ms;
        }
        if period_ms < self.perception.period_ms && !is_written("controller.release") {
            self.controller.release = Release::Timer;
        }
        // The plant's period divides the delay of commands. Else the delay would end between two of its steps.
        if !is_written("plant.period_ms") {
            let (mut period, mut rest) =
                (self.plant.period_ms.value(), self.runtime.extra_delay_ms.value());
            // Euclid's greatest common divisor.
            while rest > 0 {
                (period, rest) = (rest, period % rest);
            }
            self.plant.period_ms = PeriodMs::of(period);
        }
        let Some(truck_kg) = self.plant.vehicle.truck_kg() else { return };
        self.aebs.follow_truck(&is_written);
        if self.road.plan().is_some() {
            let mass_kg = truck_kg * self.plant.mass_factor.value();
            self.plant.lateral.follow_truck(mass_kg, &is_written);
        }
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
///     overrides.option("--seed", "seed", seed);
///     assert_eq!(source.open(&overrides, &check)?.seed.value(), seed as u64);
/// }
/// # Ok::<(), scenario::ScenarioError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Source {
    name: String,
    text: String,
    root: Table,
    /// The directory at which paths in it begin; none: it is built in.
    directory: Option<PathBuf>,
}

impl Source {
    /// Reads the built-in scenario of that name or the file at that path.
    ///
    /// # Errors
    /// If there is no such scenario, or it cannot be read or is not TOML.
    pub fn read(argument: &str) -> Result<Self, ScenarioError> {
        let path = Path::new(argument);
        let looks_like_a_path = argument.ends_with(".toml") || argument.contains('/');
        let (name, text, directory) = match builtin::find(argument) {
            Some(builtin) => (format!("built-in {argument}"), builtin.text.to_owned(), None),
            None if !looks_like_a_path && !path.exists() => return Err(builtin::unknown(argument)),
            None => {
                let text = text_file::read(path, MAX_TEXT_BYTES)
                    .map_err(|reason| ScenarioError::whole(argument, reason.to_string()))?;
                (argument.to_owned(), text, Some(path.parent().unwrap_or(path).to_owned()))
            }
        };
        let root = Document::root_of(&name, &text)?;
        Ok(Self { name, text, root, directory })
    }

    /// A drive of the ego through a configuration of SUMO.
    pub fn of_sumo(path: &Path, ego: &str) -> Self {
        let name = translation::word(path.file_stem().and_then(|stem| stem.to_str()), "sumo");
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let root = table! {
            schema_version: SCHEMA_VERSION,
            name: name,
            traffic: table! { sumo: file, ego: ego },
        };
        let directory = Some(path.parent().unwrap_or(path).to_owned());
        Self { name: path.display().to_string(), text: root.to_string(), root, directory }
    }

    /// The scenario with `overrides` laid over the file. `check` is asked last, for conditions that only the control
    /// laws have.
    ///
    /// # Errors
    /// When something in the file or in an override is wrong.
    pub fn open(&self, overrides: &Overrides, check: Check<'_>) -> Result<Scenario, ScenarioError> {
        let Self { name: source, text, root, directory } = self;
        let document = Document::new(Origin::Text { source, text }, root.clone(), overrides)?;
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
