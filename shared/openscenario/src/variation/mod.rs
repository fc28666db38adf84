//! Parameter value distributions: the combinations of a variation file.

mod draw;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::error::{Place, ReadError};
use crate::library::Source;
use crate::node::Node;
use crate::parameter::{Assignment, Scope};
use crate::read;
use draw::Distribution;

/// Most runs of a variation.
pub const MAX_RUNS: usize = 1_000_000;
/// Values of a range are rounded to this many steps per unit, so that 0.1 + 0.2 is 0.3.
const ROUNDING: f64 = 1e9;

/// A variation file: which scenario, with which values.
#[derive(Clone, Debug, PartialEq)]
pub struct Variation {
    /// The scenario file.
    pub scenario: PathBuf,
    /// The description of the header.
    pub description: String,
    /// Where each parameter is first varied.
    places: BTreeMap<String, Place>,
    combinations: Combinations,
}

#[derive(Clone, Debug, PartialEq)]
enum Combinations {
    /// For each distribution its choices; the last one varies fastest.
    All(Vec<Vec<Vec<Assignment>>>),
    /// Run by run.
    Drawn(Vec<Vec<Assignment>>),
}

impl Variation {
    /// Reads a variation file.
    ///
    /// # Errors
    /// As [`read::scenario`]; also when a distribution is empty or there are too many combinations.
    pub fn open(path: &Path, source: &dyn Source) -> Result<Self, ReadError> {
        let document = read::open(path, source)?;
        let scope = Scope::default().with(&document.file, &document.root, &[])?;
        let root = Node { file: &document.file, element: &document.root, scope: &scope };
        let Some(node) = root.child_if("ParameterValueDistribution") else {
            return Err(
                root.refuse("this file varies no parameters", "`ParameterValueDistribution`")
            );
        };
        let relative = node.child("ScenarioFile")?.text("filepath")?;
        let directory = path.parent().unwrap_or(Path::new(""));
        let scenario = directory.join(relative.trim_start_matches("./"));
        let kind = node.chosen(&["Deterministic", "Stochastic"])?;
        let combinations = match kind.name() {
            "Deterministic" => all(kind)?,
            _ => drawn(kind)?,
        };
        let description = root.child("FileHeader")?.text_if("description")?.unwrap_or_default();
        let mut places = BTreeMap::new();
        locate(kind, &mut places)?;
        Ok(Self { scenario, description, places, combinations })
    }

    /// An error about a value that this file gives to a parameter of its scenario, with the place in this file.
    #[must_use]
    pub fn locate(&self, error: ReadError) -> ReadError {
        match &error {
            ReadError::Override { name, .. } => match self.places.get(name) {
                Some(place) => error.given_at(place),
                None => error,
            },
            _ => error,
        }
    }

    /// How many combinations there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match &self.combinations {
            Combinations::All(choices) => choices.iter().map(Vec::len).product(),
            Combinations::Drawn(runs) => runs.len(),
        }
    }

    /// Whether there are none, which a file that was read never says.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The values of one combination.
    #[must_use]
    pub fn get(&self, index: usize) -> Vec<Assignment> {
        match &self.combinations {
            Combinations::Drawn(runs) => runs[index].clone(),
            Combinations::All(choices) => {
                let mut rest = index;
                let mut values = Vec::new();
                for choice in choices.iter().rev() {
                    values.push(&choice[rest % choice.len()]);
                    rest /= choice.len();
                }
                values.into_iter().rev().flatten().cloned().collect()
            }
        }
    }
}

fn locate(node: Node<'_>, places: &mut BTreeMap<String, Place>) -> Result<(), ReadError> {
    for name in ["parameterName", "parameterRef"] {
        if let Some(name) = node.text_if(name)? {
            places.entry(name).or_insert_with(|| node.place());
        }
    }
    node.children().try_for_each(|child| locate(child, places))
}

fn all(node: Node<'_>) -> Result<Combinations, ReadError> {
    let mut choices: Vec<Vec<Vec<Assignment>>> = Vec::new();
    let mut known = BTreeSet::new();
    for distribution in node.children() {
        let choice: Vec<Vec<Assignment>> = match distribution.name() {
            "DeterministicSingleParameterDistribution" => single(distribution)?,
            _ => distribution
                .child("ValueSetDistribution")?
                .children()
                .map(|set| set.children().map(assignment).collect())
                .collect::<Result<_, _>>()?,
        };
        for set in &choice {
            let mut before = known.clone();
            for assignment in set {
                refuse_twice(&distribution, !before.insert(assignment.name.clone()), assignment)?;
            }
        }
        known.extend(choice.iter().flatten().map(|assignment| assignment.name.clone()));
        choices.push(choice);
    }
    let count = choices.iter().try_fold(1usize, |count, c| count.checked_mul(c.len()));
    match count {
        Some(count) if !choices.is_empty() && count <= MAX_RUNS => Ok(Combinations::All(choices)),
        _ => Err(too_many(node)),
    }
}

/// A parameter that is varied in two places has no value: one would be taken, and each drive counted several times.
fn refuse_twice(node: &Node<'_>, twice: bool, of: &Assignment) -> Result<(), ReadError> {
    if twice {
        return Err(node.refuse(format!("parameter `{}` is varied twice", of.name), "each once"));
    }
    Ok(())
}

fn too_many(node: Node<'_>) -> ReadError {
    let expected = format!("1 to {MAX_RUNS} of them");
    node.refuse("no combinations, or too many", expected)
}

fn assignment(node: Node<'_>) -> Result<Assignment, ReadError> {
    Ok(Assignment { name: node.text("parameterRef")?, value: node.text("value")? })
}

/// The values of one parameter.
fn single(node: Node<'_>) -> Result<Vec<Vec<Assignment>>, ReadError> {
    let name = node.text("parameterName")?;
    let of = |value: String| vec![Assignment { name: name.clone(), value }];
    let kind = node.chosen(&["DistributionSet", "DistributionRange"])?;
    if kind.name() == "DistributionSet" {
        return kind.children().map(|element| element.text("value").map(of)).collect();
    }
    let step = kind.number("stepWidth")?;
    let (lower, upper) = range(kind.child("Range")?)?;
    if !(step > 0.0) || (upper - lower) / step > MAX_RUNS as f64 {
        let expected = format!("more than 0, and at most {MAX_RUNS} steps");
        return Err(kind.fault("stepWidth").error(format!("{step}"), expected));
    }
    let steps = libm::floor((upper - lower) / step + 1.0 / ROUNDING) as usize;
    let value = |i: usize| libm::round((lower + i as f64 * step) * ROUNDING) / ROUNDING;
    Ok((0..=steps).map(|i| of(value(i).to_string())).collect())
}

fn range(node: Node<'_>) -> Result<(f64, f64), ReadError> {
    let (lower, upper) = (node.number("lowerLimit")?, node.number("upperLimit")?);
    match lower <= upper {
        true => Ok((lower, upper)),
        false => {
            let expected = format!("{lower} or more");
            Err(node
                .fault("upperLimit")
                .error(format!("{upper} is below the lower limit"), expected))
        }
    }
}

/// Draws every run's values; each parameter has a stream of its own, so that adding one does not change
/// the others.
fn drawn(node: Node<'_>) -> Result<Combinations, ReadError> {
    let runs = node.magnitude("numberOfTestRuns")?;
    if libm::trunc(runs) != runs || runs < 1.0 || runs > MAX_RUNS as f64 {
        return Err(too_many(node));
    }
    let seed = node.number_or("randomSeed", 0.0)?;
    if libm::trunc(seed) != seed {
        return Err(node.fault("randomSeed").error(format!("{seed}"), "a whole number"));
    }
    let mut values = vec![Vec::new(); runs as usize];
    for (stream, distribution) in node.children().enumerate() {
        let name = distribution.text("parameterName")?;
        let kind = distribution.children().next().expect("the subset demands one");
        let mut source = Distribution::read(kind)?.seeded(seed as i64 as u64, stream as u64);
        for run in &mut values {
            let Some(value) = source.draw() else {
                return Err(kind.refuse(
                    "its range holds next to none of its values",
                    "a range that most values are in",
                ));
            };
            let drawn = Assignment { name: name.clone(), value };
            let twice = run.iter().any(|known: &Assignment| known.name == drawn.name);
            refuse_twice(&distribution, twice, &drawn)?;
            run.push(drawn);
        }
    }
    Ok(Combinations::Drawn(values))
}

#[cfg(test)]
mod tests;
