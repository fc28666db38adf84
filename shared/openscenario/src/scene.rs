//! The parts of a scenario that other parts refer to: files, road, entities, values.

use std::cell::{Cell, OnceCell, RefCell};
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::error::{Place, ReadError, Spot};
use crate::library::Source;
use crate::model::timed::SignalCycle;
use crate::model::{Entity, InitAction, Named};
use crate::road::{self, Ground, Road};
use crate::xml::{self, Document};

/// The direction from which the headings of lane positions count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LaneHeadings {
    /// The road's reference line, in every lane, as in the standard.
    #[default]
    Road,
    /// The traffic of the lane, as in esmini and CARLA.
    Traffic,
}

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Spots {
    pub entities: Vec<Spot>,
    /// The place in Init that says how each entity begins; its declaration when Init does not.
    pub starts: Vec<Spot>,
    pub stop: Option<Spot>,
}

/// A scenario while it is read. The elements of a file come in an order in which each refers to earlier ones.
#[derive(Default)]
pub(crate) struct Scene<'a> {
    /// The files; none where a file is read alone.
    source: Option<&'a dyn Source>,
    directory: PathBuf,
    catalogs: RefCell<BTreeMap<PathBuf, Rc<Vec<Document>>>>,
    /// The directories of catalogs, each with the name of its location.
    pub locations: RefCell<Vec<Location>>,
    road_file: OnceCell<Document>,
    road: OnceCell<Rc<Scenery>>,
    pub entities: RefCell<Vec<Entity>>,
    /// Names that stand for several entities.
    pub selections: RefCell<Vec<(String, Vec<usize>)>>,
    pub ego: Cell<usize>,
    /// The name of the ego, where the user gives it.
    pub ego_name: RefCell<Option<String>>,
    /// The speed to which the ego drives in its own time, m/s.
    pub ego_goal_mps: Cell<Option<f64>>,
    /// The friction of the road as a factor, where Init gives it.
    pub friction: Cell<Option<f64>>,
    pub headings: Cell<LaneHeadings>,
    /// The file's author says from which direction headings count.
    pub are_headings_guessed: Cell<bool>,
    pub actors: RefCell<Vec<usize>>,
    pub master: Cell<usize>,
    pub init: RefCell<Vec<InitAction>>,
    pub spots: RefCell<Spots>,
    pub values: RefCell<Vec<Named>>,
    /// Controllers of traffic signals by name.
    pub controllers: RefCell<Vec<(String, SignalCycle)>>,
    /// The condition that is read is a criterion of CARLA's tests.
    pub is_criterion: Cell<bool>,
    /// Names of parts of the storyboard in conditions.
    pub references: RefCell<Vec<(Place, String)>>,
    pub notices: RefCell<Vec<String>>,
    pub hindrance: RefCell<Option<String>>,
}

pub(crate) struct Scenery {
    pub road: Road,
    pub ground: Ground,
}

#[derive(Clone)]
pub(crate) struct Location {
    /// The name of the element in `CatalogLocations`.
    pub name: String,
    pub path: String,
    pub place: Place,
}

impl<'a> Scene<'a> {
    pub(crate) fn new(source: &'a dyn Source, scenario: &Path) -> Self {
        let directory = scenario.parent().unwrap_or(Path::new("")).to_owned();
        Self { source: Some(source), directory, ..Self::default() }
    }

    fn source(&self) -> std::io::Result<&'a dyn Source> {
        self.source.ok_or_else(|| ErrorKind::NotFound.into())
    }

    fn path(&self, relative: &str) -> PathBuf {
        self.directory.join(relative.trim_start_matches("./"))
    }

    /// Tells the user how something is simulated, once.
    pub(crate) fn notice(&self, text: String) {
        let mut notices = self.notices.borrow_mut();
        if !notices.contains(&text) {
            notices.push(text);
        }
    }

    pub(crate) fn catalogs(&self, location: &Location) -> Result<Rc<Vec<Document>>, ReadError> {
        let path = self.path(&location.path);
        if let Some(known) = self.catalogs.borrow().get(&path) {
            return Ok(Rc::clone(known));
        }
        let unreadable = |path: &Path, error: std::io::Error| {
            let reason = format!("the catalogs of {} cannot be read: {error}", path.display());
            let expected = "a directory of catalogs, relative to the scenario file";
            ReadError::meaning(location.place.clone(), reason, expected)
        };
        let mut documents = Vec::new();
        let listed = self.source().and_then(|source| source.list(&path));
        for file in listed.map_err(|error| unreadable(&path, error))? {
            let text = self.source().and_then(|source| source.read(&file));
            let text = text.map_err(|error| unreadable(&file, error))?;
            documents.push(xml::parse(&file.display().to_string(), &text)?);
        }
        let documents = Rc::new(documents);
        self.catalogs.borrow_mut().insert(path, Rc::clone(&documents));
        Ok(documents)
    }

    /// Opens the road file. A straight road is assumed when it is not there.
    pub(crate) fn open_road(&self, file: &str, place: &Place) -> Result<(), ReadError> {
        let path = self.path(file);
        let name = path.display().to_string();
        match self.source().and_then(|source| source.read(&path)) {
            Ok(text) => {
                let document = xml::parse(&name, &text)?;
                self.road_file.get_or_init(|| document);
                Ok(())
            }
            Err(error) if error.kind() == ErrorKind::NotFound => {
                self.hindrance.replace(Some(format!("{place}: {name} is not there")));
                self.notice(format!(
                    "{place}: {name} is not there: a straight road with lanes of 3.5 m is assumed"
                ));
                Ok(())
            }
            Err(error) => Err(ReadError::File { file: name, reason: error.to_string() }),
        }
    }

    /// The road. The first position that names one chooses it; `None` asks for the only one.
    pub(crate) fn road(&self, id: Option<&str>) -> Result<Rc<Scenery>, ReadError> {
        if let Some(road) = self.road.get() {
            return Ok(Rc::clone(road));
        }
        let (road, place) = match self.road_file.get() {
            Some(document) => {
                let found = road::read(document, id)?;
                found.notices.into_iter().for_each(|notice| self.notice(notice));
                (found.road, Place { file: document.file.clone(), spot: document.root.spot })
            }
            None => (Road::assumed(), Place::default()),
        };
        let ground = Ground::of(&road)
            .map_err(|error| ReadError::meaning(place, error.to_string(), error.expected()))?;
        Ok(Rc::clone(self.road.get_or_init(|| Rc::new(Scenery { road, ground }))))
    }

    /// The road; if no position has chosen one, the one nearest to a point in the coordinates of the file.
    pub(crate) fn road_at(&self, x_m: f64, y_m: f64) -> Result<Rc<Scenery>, ReadError> {
        let document = self.road_file.get().filter(|_| self.road.get().is_none());
        self.road(document.and_then(|document| road::nearest(document, x_m, y_m)))
    }

    /// True if positions may name any road, since none is there.
    pub(crate) fn assumes_a_road(&self) -> bool {
        self.road_file.get().is_none()
    }
}
