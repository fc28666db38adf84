//! Parameter value distributions: the combinations of a variation file.

mod draw;
mod file;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::declare::{Element, Node};
use crate::error::{Place, ReadError};
use crate::library::Source;
use crate::parameter::{Assignment, opened};
use crate::read;
use crate::scene::Scene;
use crate::scope::Scope;
use file::ParameterValueDistribution;
pub(crate) use file::VariationFile;

pub const MAX_RUNS: usize = 1_000_000;
/// A variation file: a scenario, and the values of its parameters for each run.
///
/// ```no_run
/// use openscenario::{Choices, Disk, read, variation::Variation};
/// use std::path::Path;
///
/// let variation = Variation::open(Path::new("cut_in_variation.xosc"), &Disk)?;
/// for run in 0..variation.len() {
///     let choices = Choices { assigned: variation.get(run), ..Choices::default() };
///     let scenario = read::scenario(&variation.scenario, &Disk, &choices)?;
///     println!("{:?}", scenario.parameters);
/// }
/// # Ok::<(), openscenario::ReadError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Variation {
    pub scenario: PathBuf,
    pub description: String,
    /// The first place at which each parameter is varied.
    places: BTreeMap<String, Place>,
    combinations: Combinations,
}

/// The choices of each distribution, of which the last one varies fastest. Drawn runs are one choice.
pub(crate) type Combinations = Vec<Vec<Vec<Assignment>>>;

impl Variation {
    /// Reads a variation file.
    ///
    /// # Errors
    /// As [`read::scenario`]; also when a distribution is empty or there are too many combinations.
    pub fn open(path: &Path, source: &dyn Source) -> Result<Self, ReadError> {
        let others = [("Storyboard", " and varies no parameters"), ("Catalog", "")];
        let expected = format!("`{}`", ParameterValueDistribution::NAME);
        let document = read::open(path, source, VariationFile::FORM, (&others, &expected))?;
        let (scene, outside) = (Scene::new(source, path), Scope::default());
        let (file, element) = (&document.file, &document.root);
        let node = Node { file, element, scope: &outside, scene: &scene };
        let scope = opened(node, &[])?;
        let read = VariationFile::read(Node { scope: &scope, ..node })?;
        let directory = path.parent().unwrap_or(Path::new(""));
        let below = read.scenario.strip_prefix(".").unwrap_or(&read.scenario);
        Ok(Self { scenario: directory.join(below), ..read })
    }

    /// Adds the place in this file to an error about a value that it gives to a parameter of its scenario.
    pub fn locate(&self, error: ReadError) -> ReadError {
        let ReadError::Override { name, .. } = &error else { return error };
        match self.places.get(name) {
            Some(place) => error.given_at(place),
            None => error,
        }
    }

    pub fn len(&self) -> usize {
        self.combinations.iter().map(Vec::len).product()
    }

    /// True if there are none. A file that was read has at least one.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub fn get(&self, index: usize) -> Vec<Assignment> {
        let mut rest = index;
        let mut values = Vec::new();
        for choice in self.combinations.iter().rev() {
            values.push(&choice[rest % choice.len()]);
            rest /= choice.len();
        }
        values.into_iter().rev().flatten().cloned().collect()
    }
}

#[cfg(test)]
mod tests;
