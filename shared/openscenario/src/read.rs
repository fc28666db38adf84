//! From files to a [`Script`].

use std::path::Path;

use crate::declare::{Element, Form, Node, SCENARIO_VERSIONS, check, check_head};
use crate::error::{Place, ReadError};
use crate::library::Source;
use crate::model::action::Action;
use crate::model::{InitAction, Script};
use crate::parameter::{Assignment, opened};
pub use crate::scene::Spots;
use crate::scene::{LaneHeadings, Scene};
use crate::scope::Scope;
use crate::subset::ScenarioFile;
use crate::world::NotFound;
use crate::xml::{self, Document};

#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    pub script: Script,
    pub description: String,
    /// Its parameters with the values that took effect, by name.
    pub parameters: Vec<(String, String)>,
    /// The direction from which its headings count.
    pub headings: LaneHeadings,
    /// The ego's set speed, m/s, where Init lets it change its speed over time; otherwise its speed at the start.
    pub set_speed_mps: Option<f64>,
    /// The friction of the road, as a factor of the usual one.
    pub friction: f64,
    /// Reason why its story cannot happen: the road file is not there.
    pub hindrance: Option<String>,
    /// Notes for a person on how it is simulated, a sentence each.
    pub notices: Vec<String>,
    /// The places of its parts in the scenario file.
    pub spots: Spots,
}

/// A reader's choices for a file.
#[derive(Clone, Debug, Default)]
pub struct Choices {
    /// Values that replace the declared ones.
    pub assigned: Vec<Assignment>,
    /// The direction from which headings count. Without it, the file's author says so: esmini's files count from the
    /// lane's traffic.
    pub headings: Option<LaneHeadings>,
    /// The entity that is the ego. Without it, its name or its controller says so.
    pub ego: Option<String>,
}

/// Reads a scenario file with its catalogs and its road, by the user's choices.
///
/// ```no_run
/// use openscenario::{Assignment, Choices, Disk, read};
/// use std::path::Path;
///
/// let speed = Assignment { name: "Ego_Speed".to_owned(), value: "20".to_owned() };
/// let choices = Choices { assigned: vec![speed], ..Choices::default() };
/// let scenario = read::scenario(Path::new("cut_in.xosc"), &Disk, &choices)?;
/// for notice in &scenario.notices {
///     println!("{notice}");
/// }
/// # Ok::<(), openscenario::ReadError>(())
/// ```
///
/// # Errors
/// At the first part that is not well-formed, is outside the subset, or cannot be simulated.
pub fn scenario(
    path: &Path,
    source: &dyn Source,
    choices: &Choices,
) -> Result<Scenario, ReadError> {
    let document = open_scenario(path, source)?;
    let (scene, outside) = (Scene::new(source, path), Scope::default());
    scene.headings.set(choices.headings.unwrap_or_else(|| headings_of(&document)));
    scene.are_headings_guessed.set(choices.headings.is_none());
    scene.ego_name.replace(choices.ego.clone());
    let root = &document.root;
    let node = Node { file: &document.file, element: root, scope: &outside, scene: &scene };
    let scope = opened(node, &choices.assigned)?;
    let node = Node { scope: &scope, ..node };
    let (description, Some((stories, stop))) = ScenarioFile::read(node)? else {
        return Err(node.refuse("this file holds no scenario", "`Entities` and `Storyboard`"));
    };
    let cycles = scene.controllers.take().into_iter();
    let cycles = cycles.map(|(_, cycle)| InitAction { actor: None, action: Action::Cycle(cycle) });
    let script = Script {
        roads: scene.road(None).map(|_| scene.roads())?,
        ego: scene.ego.get(),
        entities: scene.entities.take(),
        values: scene.values.take(),
        init: cycles.chain(scene.init.take()).collect(),
        stories,
        stop,
    };
    // Only now all parts of the storyboard are there that conditions refer to.
    if let Err(NotFound { name, reason, expected }) = script.check_names() {
        let references = scene.references.take();
        let place = references.into_iter().find(|reference| reference.1 == name);
        let place = place.map_or_else(|| node.place(), |(place, _)| place);
        return Err(ReadError::meaning(place, reason, expected));
    }
    let parameters = scope.iter().map(|(name, value)| (name.to_owned(), value.text())).collect();
    Ok(Scenario {
        script,
        description,
        parameters,
        headings: scene.headings.get(),
        set_speed_mps: scene.ego_goal_mps.get(),
        friction: scene.friction.get().unwrap_or(1.0),
        hindrance: scene.hindrance.take(),
        notices: scene.notices.take(),
        spots: scene.spots.take(),
    })
}

/// The direction from which the headings of a file count, by the program of its author.
fn headings_of(document: &Document) -> LaneHeadings {
    let header = document.root.child("FileHeader");
    let author = header.and_then(|header| header.attribute("author")).unwrap_or_default();
    match author.to_ascii_lowercase().contains("esmini") {
        true => LaneHeadings::Traffic,
        false => LaneHeadings::Road,
    }
}

/// A scenario file's parameters, to be asked about many values.
#[derive(Clone, Debug)]
pub struct Template {
    document: Document,
}

impl Template {
    /// Reads the file alone, without its catalogs and its road.
    ///
    /// # Errors
    /// As [`scenario`].
    pub fn open(path: &Path, source: &dyn Source) -> Result<Self, ReadError> {
        Ok(Self { document: open_scenario(path, source)? })
    }

    /// True if values break none of the constraints that the file declares.
    ///
    /// # Errors
    /// When they do not fit its parameters for another reason.
    pub fn admits(&self, assigned: &[Assignment]) -> Result<bool, ReadError> {
        let (scene, scope) = (Scene::default(), Scope::default());
        let Document { file, root } = &self.document;
        match opened(Node { file, element: root, scope: &scope, scene: &scene }, assigned) {
            Ok(_) => Ok(true),
            Err(ReadError::Constraint { .. }) => Ok(false),
            Err(error) => Err(error),
        }
    }
}

/// Reads and checks a scenario file.
fn open_scenario(path: &Path, source: &dyn Source) -> Result<Document, ReadError> {
    let others =
        [("Catalog", ""), ("ParameterValueDistribution", ", which `timegap campaign` runs")];
    open(path, source, ScenarioFile::FORM, (&others, "`Entities` and `Storyboard`"))
}

/// Reads a file and holds it against a form. `others` are elements of other kinds of files, with a hint each, and what
/// is expected in their place.
pub(crate) fn open(
    path: &Path,
    source: &dyn Source,
    form: &'static Form,
    (others, expected): (&[(&str, &str)], &str),
) -> Result<Document, ReadError> {
    let file = path.display().to_string();
    let text = source
        .read(path)
        .map_err(|error| ReadError::File { file: file.clone(), reason: error.to_string() })?;
    let document = xml::parse(&file, &text)?;
    check_head(&document, SCENARIO_VERSIONS)?;
    if let Some((name, hint)) = others.iter().find(|(name, _)| document.root.child(name).is_some())
    {
        let place = Place { file, spot: document.root.spot };
        return Err(ReadError::meaning(
            place,
            format!("this file holds a `{name}`{hint}"),
            expected,
        ));
    }
    check(&document.file, &document.root, form)?;
    Ok(document)
}
