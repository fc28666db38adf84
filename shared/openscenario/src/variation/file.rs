//! The elements of a variation file.

use std::collections::{BTreeMap, BTreeSet};

use super::draw::Distribution;
use super::{Combinations, MAX_RUNS, Variation};
use crate::declare::{AtLeastOne, AtLeastZero, Node, Number, OneOf, Placed, Text, elements};
use crate::error::{Place, ReadError};
use crate::parameter::{Assignment, ParameterAssignment, ParameterDeclarations};
use crate::subset::FileHeader;

/// Values of a range are rounded to this many steps per unit, so that 0.1 + 0.2 is 0.3.
const ROUNDING: f64 = 1e9;
/// Largest mean of a Poisson distribution: beyond it Knuth's product of uniform draws underflows.
const MAX_POISSON_MEAN: f64 = 500.0;

/// The combinations, and where each parameter is first varied.
pub(crate) type Varied = (Combinations, BTreeMap<String, Place>);

/// Sets of values, one of which is chosen; each set with the places of its parameters.
type Sets = (Vec<(String, Place)>, Vec<Vec<Assignment>>);

/// A parameter, and its distribution with the place of it.
type Drawn = (String, (Place, Distribution));

elements! { "Parameter variation";
    /// a parameter variation
    VariationFile = "OpenSCENARIO" -> Variation [] {
        description: FileHeader,
        _: Option<ParameterDeclarations>,
        distribution: ParameterValueDistribution,
    } {
        let (scenario, (combinations, places)) = distribution;
        Ok(Variation { scenario: scenario.into(), description, places, combinations })
    }

    /// a campaign of one run for each combination
    ParameterValueDistribution -> (String, Varied) []
    {scenario: ScenarioPath, varied: OneOf<(Deterministic, Stochastic)>}
    { Ok((scenario, varied)) }

    /// relative to the variation file
    ScenarioPath = "ScenarioFile" -> String ["filepath" path: Text] {}

    /// all combinations; the last one listed varies fastest; combinations that break a constraint are left out and counted
    Deterministic -> Varied [] {
        choices: Vec<Placed<OneOf<(
            DeterministicSingleParameterDistribution,
            DeterministicMultiParameterDistribution,
        )>>>,
    } |node| { all(node, choices) }

    /// values of one parameter
    DeterministicSingleParameterDistribution -> Sets ["parameterName" name: Text]
    {values: OneOf<(DistributionSet, DistributionRange)>}
    |node| {
        let set = |value| vec![Assignment { name: name.clone(), value }];
        let sets = values.into_iter().map(set).collect();
        Ok((vec![(name, node.place())], sets))
    }

    /// values of several parameters together
    DeterministicMultiParameterDistribution -> Sets [] {sets: ValueSetDistribution}

    /// one set after the other
    ValueSetDistribution -> Sets [] {sets: AtLeastOne<ParameterValueSet>}
    {
        let place = |(place, set): &(Place, Assignment)| (set.name.clone(), place.clone());
        let places = sets.iter().flatten().map(place).collect();
        let values = |set: Vec<(Place, Assignment)>| set.into_iter().map(|(_, it)| it).collect();
        Ok((places, sets.into_iter().map(values).collect()))
    }

    /// values that go together
    ParameterValueSet -> Vec<(Place, Assignment)> []
    {values: AtLeastOne<Placed<ParameterAssignment>>}

    /// the values listed
    DistributionSet -> Vec<String> [] {values: AtLeastOne<SetElement>}

    /// a value
    SetElement = "Element" -> String ["value" value: Text] {} unused ["weight?"]

    /// from the lower limit in steps up to the upper limit, which belongs to it
    DistributionRange -> Vec<String> ["stepWidth" step: Number] {range: Range}
    |node| {
        let (lower, upper) = range;
        if !(step > 0.0) || (upper - lower) / step > MAX_RUNS as f64 {
            let expected = format!("more than 0, and at most {MAX_RUNS} steps");
            return Err(node.wrong("stepWidth", format!("{step}"), expected));
        }
        let steps = libm::floor((upper - lower) / step + 1.0 / ROUNDING) as usize;
        let value = |i: usize| libm::round((lower + i as f64 * step) * ROUNDING) / ROUNDING;
        Ok((0..=steps).map(|i| value(i).to_string()).collect())
    }

    /// both limits belong to it
    Range -> (f64, f64) ["lowerLimit" lower: Number, "upperLimit" upper: Number] {}
    |node| {
        if lower > upper {
            let reason = format!("{upper} is below the lower limit");
            return Err(node.wrong("upperLimit", reason, format!("{lower} or more")));
        }
        Ok((lower, upper))
    }

    /// draws of rand_pcg's Pcg64 from the seed (0 without one), each parameter from a stream of its own
    Stochastic -> Varied
    ["numberOfTestRuns" runs: AtLeastZero, "randomSeed" seed: Option<Number>]
    {distributions: AtLeastOne<Placed<StochasticDistribution>>}
    |node| {
        if libm::trunc(runs) != runs || runs < 1.0 || runs > MAX_RUNS as f64 {
            return Err(too_many(node));
        }
        let seed = seed.unwrap_or(0.0);
        if libm::trunc(seed) != seed {
            return Err(node.wrong("randomSeed", format!("{seed}"), "a whole number"));
        }
        drawn(runs as usize, seed as i64 as u64, distributions)
    }

    /// one parameter
    StochasticDistribution -> Drawn ["parameterName" name: Text] {
        distribution: Placed<OneOf<(
            ProbabilityDistributionSet,
            NormalDistribution,
            LogNormalDistribution,
            UniformDistribution,
            PoissonDistribution,
            Histogram,
        )>>,
    } { Ok((name, distribution)) }

    /// values by weight
    ProbabilityDistributionSet -> Distribution [] {values: AtLeastOne<WeightedElement>}
    |node| {
        require_weight(node, values.iter().map(|value| value.1))?;
        Ok(Distribution::Set(values))
    }

    /// a value with its weight
    WeightedElement = "Element" -> (String, f64)
    ["value" value: Text, "weight" weight: AtLeastZero] {}
    { Ok((value, weight)) }

    /// expected value and variance, of `LogNormalDistribution` the logarithm's; redrawn outside its range
    NormalDistribution | LogNormalDistribution -> Distribution
    ["expectedValue" mean: Number, "variance" variance: AtLeastZero] {range: Option<Range>}
    |node| {
        let log = node.name() == LogNormalDistribution::NAME;
        Ok(Distribution::Normal { mean, deviation: libm::sqrt(variance), log, range })
    }

    /// even between the limits
    UniformDistribution -> Distribution [] {range: Range}
    { Ok(Distribution::Uniform(range.0, range.1)) }

    /// whole numbers; redrawn outside its range
    PoissonDistribution -> Distribution ["expectedValue" mean: AtLeastZero] {range: Option<Range>}
    |node| {
        if mean > MAX_POISSON_MEAN {
            let expected = format!("at most {MAX_POISSON_MEAN}");
            return Err(node.wrong("expectedValue", format!("{mean}"), expected));
        }
        Ok(Distribution::Poisson { mean, range })
    }

    /// a bin by weight, then even inside it
    Histogram -> Distribution [] {bins: AtLeastOne<Bin>}
    |node| {
        require_weight(node, bins.iter().map(|bin| bin.1))?;
        Ok(Distribution::Histogram(bins))
    }

    /// a bin
    Bin -> ((f64, f64), f64) ["weight" weight: AtLeastZero] {range: Range} { Ok((range, weight)) }
}

fn require_weight(node: Node<'_>, mut weights: impl Iterator<Item = f64>) -> Result<(), ReadError> {
    match weights.any(|weight| weight > 0.0) {
        true => Ok(()),
        false => Err(node.refuse("all weights are 0", "a weight above 0")),
    }
}

fn too_many(node: Node<'_>) -> ReadError {
    node.refuse("no combinations, or too many", format!("1 to {MAX_RUNS} of them"))
}

/// The error that a parameter is varied in two places: one value would be lost, and drives would repeat.
fn twice(place: &Place, name: &str) -> ReadError {
    ReadError::meaning(place.clone(), format!("parameter `{name}` is varied twice"), "each once")
}

/// All combinations of some choices.
fn all(node: Node<'_>, choices: Vec<(Place, Sets)>) -> Result<Varied, ReadError> {
    let mut known = BTreeSet::new();
    let mut places = BTreeMap::new();
    for (place, (named, sets)) in &choices {
        for set in sets {
            let mut before = known.clone();
            if let Some(again) = set.iter().find(|value| !before.insert(value.name.clone())) {
                return Err(twice(place, &again.name));
            }
        }
        known.extend(sets.iter().flatten().map(|value| value.name.clone()));
        for (name, place) in named {
            places.entry(name.clone()).or_insert_with(|| place.clone());
        }
    }
    let count =
        choices.iter().try_fold(1usize, |count, (_, (_, sets))| count.checked_mul(sets.len()));
    match count {
        Some(count) if !choices.is_empty() && count <= MAX_RUNS => {
            let sets = choices.into_iter().map(|(_, (_, sets))| sets).collect();
            Ok((sets, places))
        }
        _ => Err(too_many(node)),
    }
}

/// Draws every run's values. Each parameter has a stream of its own, so that adding one does not change
/// the others.
fn drawn(runs: usize, seed: u64, distributions: Vec<(Place, Drawn)>) -> Result<Varied, ReadError> {
    let mut values = vec![Vec::new(); runs];
    let mut places = BTreeMap::new();
    for (stream, (place, (name, (inner, distribution)))) in distributions.into_iter().enumerate() {
        if places.insert(name.clone(), place.clone()).is_some() {
            return Err(twice(&place, &name));
        }
        let mut source = distribution.seeded(seed, stream as u64);
        for run in &mut values {
            let Some(value) = source.draw() else {
                let reason = "its range holds next to none of its values";
                return Err(ReadError::meaning(inner, reason, "a range that most values are in"));
            };
            run.push(Assignment { name: name.clone(), value });
        }
    }
    Ok((vec![values], places))
}
