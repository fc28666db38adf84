//! The parts of a scenario that other parts refer to: files, road, entities, values.

use std::cell::{Cell, OnceCell, RefCell};
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::error::{Place, ReadError, Spot, one_of};
use crate::library::Source;
use crate::model::position::{From, Heading, Position};
use crate::model::timed::SignalCycle;
use crate::model::{Entity, InitAction, Named};
use crate::road::{self, Found, Ground, INSIDE_M, Road, Start};
use crate::xml::{self, Document};

/// Most roads that an error lists.
pub(crate) const MOST_LISTED: usize = 8;

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
    rows: RefCell<Vec<Rc<Scenery>>>,
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

/// A row of roads.
pub(crate) struct Scenery {
    /// Its place among the rows.
    pub row: usize,
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

    /// The first row of roads with a road; `None` asks for the first one, or for the only one of the file.
    pub(crate) fn road(&self, id: Option<&str>) -> Result<Rc<Scenery>, ReadError> {
        let document = self.road_file.get();
        let holds = |row: &&Rc<Scenery>| {
            document.is_none() || id.is_none_or(|id| row.road.part(id).is_some())
        };
        if let Some(known) = self.rows.borrow().iter().find(holds) {
            return Ok(Rc::clone(known));
        }
        let assumed = || Ok(Found { road: Road::assumed(), notices: Vec::new() });
        Ok(self.add(document.map_or_else(assumed, |document| road::read(document, id))?))
    }

    pub(crate) fn row(&self, row: usize) -> Rc<Scenery> {
        Rc::clone(&self.rows.borrow()[row])
    }

    pub(crate) fn roads(&self) -> Vec<Road> {
        self.rows.borrow().iter().map(|row| row.road.clone()).collect()
    }

    /// The row that leads over the same roads as one that was found. If there is none, this one is added.
    fn row_of(&self, found: Found) -> Rc<Scenery> {
        let is_it = |row: &&Rc<Scenery>| row.road.parts == found.road.parts;
        let known = self.rows.borrow().iter().find(is_it).cloned();
        known.unwrap_or_else(|| self.add(found))
    }

    fn add(&self, Found { road, notices }: Found) -> Rc<Scenery> {
        notices.into_iter().for_each(|notice| self.notice(notice));
        let mut rows = self.rows.borrow_mut();
        let plane = rows.first().map_or_else(|| road.start(), |first| first.ground.plane);
        let ground = Ground::of(&road, &plane).expect("the lines of a row that was read");
        let row = Rc::new(Scenery { row: rows.len(), road, ground });
        rows.push(Rc::clone(&row));
        row
    }

    /// The place of a point of the file on the nearest road outside of junctions, m, with its row.
    pub(crate) fn nearest(&self, x_m: f64, y_m: f64) -> Result<(Rc<Scenery>, f64, f64), ReadError> {
        let document = self.road_file.get();
        let found = document.and_then(|document| road::nearest(document, x_m, y_m));
        let row = self.road(found.map(|(id, ..)| id))?;
        let part = found.and_then(|(id, s_m, t_m)| Some(row.road.part(id)?.place(s_m, t_m)));
        let (s_m, t_m) = part.unwrap_or((x_m, y_m));
        Ok((row, s_m, t_m))
    }

    /// A position on the row of the way that leads on from it: over the roads of these waypoints, then straight on in its
    /// lane.
    pub(crate) fn on_its_way(
        &self,
        place: &Place,
        position: Position,
        over: &[Position],
    ) -> Result<Position, ReadError> {
        let (From::Road { row, s_m, t_m }, Some(document)) = (position.from, self.road_file.get())
        else {
            return Ok(position);
        };
        let rows: Vec<Rc<Scenery>> = self.rows.borrow().clone();
        let Scenery { road, ground, .. } = &*rows[row];
        let part = road.part_at(s_m);
        let heading_rad = match position.heading {
            Heading::Plane(heading_rad) => heading_rad - ground.direction_rad(s_m),
            Heading::Road(heading_rad) | Heading::Entity(heading_rad) => heading_rad,
        };
        let (at, reversed) = (part.own(s_m, t_m), (libm::cos(heading_rad) < 0.0) != part.reversed);
        let start = Start { road: &part.id, at, reversed };
        let over = over.iter().filter_map(|waypoint| match waypoint.from {
            From::Road { row, s_m, .. } => Some(rows[row].road.part_at(s_m).id.as_str()),
            From::Entity { .. } => None,
        });
        let found = document.along(&start, &over.collect::<Vec<_>>(), place)?;
        if found.road.cuts.is_empty() || !(0.0..=part.length_m).contains(&at.0) {
            return Ok(position);
        }
        let over: Vec<&str> = found.road.parts.iter().map(|part| part.id.as_str()).collect();
        self.notice(format!("{place}: the way leads over the roads `{}`", over.join("`, `")));
        let scenery = self.row_of(found);
        let (s_m, t_m, turned) =
            scenery.road.place_of(road, s_m, t_m).expect("the row leads over this road");
        let heading = match position.heading {
            Heading::Road(h_rad) if turned => Heading::Road(h_rad + std::f64::consts::PI),
            heading => heading,
        };
        Ok(Position { from: From::Road { row: scenery.row, s_m, t_m }, heading })
    }

    /// Adds the rows of the lanes that leave the rows at their junctions: a change of lane may lead to them.
    pub(crate) fn add_exits(&self, place: &Place) -> Result<(), ReadError> {
        let Some(document) = self.road_file.get() else { return Ok(()) };
        let rows: Vec<Rc<Scenery>> = self.rows.borrow().clone();
        for Scenery { road, .. } in rows.iter().map(Rc::as_ref) {
            for cut in road.cuts.iter().skip(1) {
                let (s_m, part) = (cut.from_m - INSIDE_M, road.part_at(cut.from_m - INSIDE_M));
                let ahead = road.lanes.strips(s_m).filter(|lane| road.direction(lane) > 0.0);
                let leaves = ahead.filter(|lane| !road.leads_on(s_m, lane.center_m, 1.0));
                for lane in leaves.filter(|lane| lane.drivable) {
                    let (at, reversed) = (part.own(s_m, lane.center_m), part.reversed);
                    let found =
                        document.along(&Start { road: &part.id, at, reversed }, &[], place)?;
                    if !found.road.cuts.is_empty() {
                        self.row_of(found);
                    }
                }
            }
        }
        Ok(())
    }

    /// The roads of the file, if it has no road with this id.
    pub(crate) fn lacks(&self, id: &str) -> Option<String> {
        let roads = self.road_file.get()?.root.children.iter().filter(|it| it.name == "road");
        let ids: Vec<&str> = roads.filter_map(|road| road.attribute("id")).collect();
        let is_missing = !ids.is_empty() && !ids.contains(&id);
        is_missing.then(|| one_of(ids.into_iter().take(MOST_LISTED)))
    }
}
