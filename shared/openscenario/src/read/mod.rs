//! From files to a [`Script`].

mod action;
mod condition;
mod entity;
mod position;
mod storyboard;

use std::cell::{OnceCell, RefCell};
use std::io::ErrorKind;
use std::path::Path;

use crate::error::{Place, ReadError};
use crate::library::{Library, Source};
use crate::model::element::ElementKind;
use crate::model::{Entity, Named, Script};
use crate::node::Node;
use crate::parameter::{Assignment, Scope};
use crate::road::{self, Road};
use crate::subset;
use crate::xml::{self, Document};

/// A scenario as it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// What it says.
    pub script: Script,
    /// The description of its header.
    pub description: String,
    /// Its parameters with the values that took effect, by name.
    pub parameters: Vec<(String, String)>,
    /// What a person should know of how it is simulated, a sentence each.
    pub notices: Vec<String>,
    /// Where in the scenario file its parts are.
    pub lines: Lines,
}

/// Lines of the scenario file, from 1.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lines {
    /// Where each entity is declared.
    pub entities: Vec<usize>,
    /// Where Init says of each entity how it begins; where it is declared when Init does not.
    pub starts: Vec<usize>,
    /// Where the storyboard's stop trigger is.
    pub stop: Option<usize>,
}

/// Reads a scenario file with its catalogs and its road. `assigned` values take the place of the
/// declared ones.
///
/// # Errors
/// At the first thing that is not well-formed, outside the subset, or without meaning.
pub fn scenario(
    path: &Path,
    source: &dyn Source,
    assigned: &[Assignment],
) -> Result<Scenario, ReadError> {
    let document = open(path, source)?;
    let root = &document.root;
    if root.child("Storyboard").is_none() || root.child("Entities").is_none() {
        let found = match root.child("ParameterValueDistribution").or(root.child("Catalog")) {
            Some(other) if other.name == "Catalog" => "this file holds a `Catalog`",
            Some(_) => {
                "this file holds a `ParameterValueDistribution`, which `timegap campaign` runs"
            }
            None => "this file holds no scenario",
        };
        return Err(ReadError::Meaning {
            place: Place { file: document.file.clone(), line: root.line },
            reason: found.to_owned(),
            expected: "`Entities` and `Storyboard`".to_owned(),
        });
    }
    let scope = Scope::default().with(&document.file, root, assigned)?;
    let node = Node { file: &document.file, element: root, scope: &scope };
    let reader = Reader::new(Library::new(source, path), node)?;
    reader.read(node)
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
        Ok(Self { document: open(path, source)? })
    }

    /// Whether values break none of the constraints that the file declares.
    ///
    /// # Errors
    /// When they do not fit its parameters for another reason.
    pub fn admits(&self, assigned: &[Assignment]) -> Result<bool, ReadError> {
        match Scope::default().with(&self.document.file, &self.document.root, assigned) {
            Ok(_) => Ok(true),
            Err(ReadError::Constraint { .. }) => Ok(false),
            Err(error) => Err(error),
        }
    }
}

/// Reads and checks one file.
pub(crate) fn open(path: &Path, source: &dyn Source) -> Result<Document, ReadError> {
    let file = path.display().to_string();
    let text = source
        .read(path)
        .map_err(|error| ReadError::File { file: file.clone(), reason: error.to_string() })?;
    let document = xml::parse(&file, &text)?;
    subset::check(&document)?;
    Ok(document)
}

/// A reference to a part of the storyboard, to be looked up once all of it has been read.
struct Reference {
    place: Place,
    kind: ElementKind,
    name: String,
}

/// What the parts of a scenario are read against.
pub(super) struct Reader<'a> {
    library: Library<'a>,
    root: Node<'a>,
    entities: Vec<Entity>,
    /// Names for several entities.
    selections: Vec<(String, Vec<usize>)>,
    ego: usize,
    roads: Roads,
    values: RefCell<Vec<Named>>,
    references: RefCell<Vec<Reference>>,
    notices: RefCell<Vec<String>>,
}

/// The road file, and the road of it that the scenario is on.
enum Roads {
    /// There is none: a road is assumed.
    Assumed(Road),
    /// A file, whose road is known once a position names it.
    File(Document, OnceCell<Road>),
}

impl<'a> Reader<'a> {
    fn new(library: Library<'a>, root: Node<'a>) -> Result<Self, ReadError> {
        let mut reader = Self {
            library,
            root,
            entities: Vec::new(),
            selections: Vec::new(),
            ego: 0,
            roads: Roads::Assumed(Road::assumed()),
            values: RefCell::default(),
            references: RefCell::default(),
            notices: RefCell::default(),
        };
        reader.open_road()?;
        reader.read_entities()?;
        reader.read_variables()?;
        Ok(reader)
    }

    fn read(self, root: Node<'_>) -> Result<Scenario, ReadError> {
        let storyboard = root.child("Storyboard")?;
        let init = self.init(storyboard.child("Init")?)?;
        let stories = self.stories(storyboard)?;
        let lines = self.lines(storyboard)?;
        let stop = match storyboard.child_if("StopTrigger") {
            Some(trigger) => Some(self.trigger(trigger)?),
            None => None,
        };
        let road = self.any_road()?.clone();
        if road.straight.is_none() {
            self.notice(format!(
                "road `{}` is curved: it is unrolled along its reference line, its curvature has no effect",
                road.id
            ));
        }
        if road.steepest_slope > 0.0 {
            self.notice(format!(
                "road `{}` has grades of up to {:.1} %: they have no effect",
                road.id,
                100.0 * road.steepest_slope
            ));
        }
        let script = Script {
            road,
            ego: self.ego,
            entities: self.entities,
            values: self.values.into_inner(),
            init,
            stories,
            stop,
        };
        for reference in self.references.into_inner() {
            script.find(reference.kind, &reference.name).map_err(|fault| ReadError::Meaning {
                place: reference.place,
                reason: fault.reason,
                expected: fault.expected,
            })?;
        }
        let header = root.child("FileHeader")?;
        Ok(Scenario {
            script,
            description: header.text_if("description")?.unwrap_or_default(),
            parameters: root.scope.iter().map(|(name, v)| (name.to_owned(), v.text())).collect(),
            notices: self.notices.into_inner(),
            lines,
        })
    }

    fn lines(&self, storyboard: Node<'_>) -> Result<Lines, ReadError> {
        let objects = self.root.child("Entities")?.named("ScenarioObject");
        let entities: Vec<usize> = objects.map(|object| object.element.line).collect();
        let mut starts = entities.clone();
        for private in storyboard.child("Init")?.child("Actions")?.named("Private") {
            starts[self.entity_ref(private)?] = private.element.line;
        }
        let stop = storyboard.child_if("StopTrigger").map(|trigger| trigger.element.line);
        Ok(Lines { entities, starts, stop })
    }

    fn notice(&self, text: String) {
        let mut notices = self.notices.borrow_mut();
        if !notices.contains(&text) {
            notices.push(text);
        }
    }

    fn open_road(&mut self) -> Result<(), ReadError> {
        let file = self.root.child_if("RoadNetwork").and_then(|node| node.child_if("LogicFile"));
        let Some(file) = file else {
            self.notice("no road file: a straight road with lanes of 3.5 m is assumed".to_owned());
            return Ok(());
        };
        let (path, text) = self.library.text(&file.text("filepath")?);
        let name = path.display().to_string();
        match text {
            Ok(text) => {
                self.roads = Roads::File(xml::parse(&name, &text)?, OnceCell::new());
            }
            Err(error) if error.kind() == ErrorKind::NotFound => self.notice(format!(
                "{}: {name} is not there: a straight road with lanes of 3.5 m is assumed",
                file.place()
            )),
            Err(error) => return Err(ReadError::File { file: name, reason: error.to_string() }),
        }
        Ok(())
    }

    /// The road that a position names by `node`'s attribute `roadId`: the same for all of them.
    fn road_of(&self, node: Node<'_>) -> Result<&Road, ReadError> {
        let id = node.text("roadId")?;
        let (document, cell) = match &self.roads {
            Roads::Assumed(road) => return Ok(road),
            Roads::File(document, cell) => (document, cell),
        };
        let road = match cell.get() {
            Some(road) => road,
            None => {
                let road = road::read(document, Some(&id))?;
                cell.get_or_init(|| road)
            }
        };
        if road.id != id {
            return Err(node.fault("roadId").error(
                format!("`{id}` is a second road"),
                format!("`{}`, since all that happens is on one road", road.id),
            ));
        }
        Ok(road)
    }

    /// The road, whichever it is.
    fn any_road(&self) -> Result<&Road, ReadError> {
        match &self.roads {
            Roads::Assumed(road) => Ok(road),
            Roads::File(document, cell) => match cell.get() {
                Some(road) => Ok(road),
                None => {
                    let road = road::read(document, None)?;
                    Ok(cell.get_or_init(|| road))
                }
            },
        }
    }
}
