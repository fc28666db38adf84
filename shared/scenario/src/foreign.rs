//! Keys of a scenario that come from a file of another format.

use super::error::ScenarioError;
use super::placed::Placed;
use super::storyboard::Storyboard;

/// Keys of a scenario, each with its value and the place in the file that it comes from. All other keys
/// have their defaults.
///
/// [`Scenario::from_foreign`](crate::Scenario::from_foreign) checks them like the keys of a scenario
/// file. An error names the place:
///
/// ```
/// use scenario::{ForeignKeys, Overrides, Reads, Scenario};
///
/// let mut keys = ForeignKeys::new("drive.xml");
/// keys.set("schema_version", 1);
/// keys.set("name", "drive");
/// keys.set_at("drive.xml:12", "the element `Car`", "plant.initial_speed_mps", 200.0);
/// let error = Scenario::from_foreign(&keys, &Overrides::new(), &|_| Ok(Reads::everything()))
///     .expect_err("too fast");
/// assert!(error.to_string().starts_with(
///     "error: drive.xml:12: the element `Car` makes a scenario with initial_speed_mps = 200.0: \
///      200 is out of range"
/// ));
/// ```
#[derive(Clone, Debug)]
pub struct ForeignKeys {
    file: String,
    keys: Vec<ForeignKey>,
    storyboard: Option<Storyboard>,
}

#[derive(Clone, Debug)]
struct ForeignKey {
    path: String,
    value: toml::Value,
    /// Place of the value and the text there; absent: the whole file.
    origin: Option<(String, String)>,
}

impl ForeignKeys {
    /// An empty list for `file`, which errors name.
    #[must_use]
    pub fn new(file: &str) -> Self {
        Self { file: file.to_owned(), keys: Vec::new(), storyboard: None }
    }

    /// Adds a key that the file as a whole determines. `path` is dotted, and elements of a list have
    /// their index: `actors.0.gap_m`. The elements must be added in their order.
    pub fn set(&mut self, path: &str, value: impl Into<toml::Value>) {
        self.keys.push(ForeignKey { path: path.to_owned(), value: value.into(), origin: None });
    }

    /// Adds a key that comes from `place`, such as `drive.xml:12`, where `what` stands.
    pub fn set_at(&mut self, place: &str, what: &str, path: &str, value: impl Into<toml::Value>) {
        let origin = Some((place.to_owned(), what.to_owned()));
        self.keys.push(ForeignKey { path: path.to_owned(), value: value.into(), origin });
    }

    /// Adds the storyboard that moves the actors.
    pub fn set_storyboard(&mut self, storyboard: Storyboard) {
        self.storyboard = Some(storyboard);
    }

    pub(super) fn storyboard(&self) -> Option<&Storyboard> {
        self.storyboard.as_ref()
    }

    pub(super) fn len(&self) -> usize {
        self.keys.len()
    }

    /// The keys as a document. The position of a value is its index, that of the root their number.
    pub(super) fn root(&self) -> Placed {
        let mut root = Placed::empty(self.len()..self.len());
        for (index, ForeignKey { path, value, .. }) in self.keys.iter().enumerate() {
            let place = index..index + 1;
            let target = path.split('.').fold(&mut root, |table, name| table.make(name, &place));
            *target = Placed::at(value.clone(), &place);
        }
        root
    }

    /// The error about the value at a position.
    pub(super) fn error(&self, position: usize, message: &str) -> ScenarioError {
        let Some(key) = self.keys.get(position) else {
            let message = format!("the file makes a scenario: {message}");
            return ScenarioError::whole(&self.file, message);
        };
        let (place, what) = match &key.origin {
            Some((place, what)) => (place.as_str(), what.as_str()),
            None => (self.file.as_str(), "the file"),
        };
        let name = key.path.rsplit('.').next().unwrap_or_default();
        let message = format!("{what} makes a scenario with {name} = {}: {message}", key.value);
        ScenarioError::whole(place, message)
    }
}
