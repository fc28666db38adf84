//! Figures that a campaign can require something of.

use super::counts::{self, Counts};
use super::measured::{self, MeasuredFigure};
use super::record::Record;
use super::tally::{Sum, Tally};

/// A figure over all runs.
#[derive(Clone, Copy)]
pub struct Figure {
    /// Name behind `max_` or `min_`.
    pub name: &'static str,
    of: Kind,
}

#[derive(Clone, Copy)]
enum Kind {
    /// A number of runs or events. Each run that has one is to blame.
    Count(fn(&Counts) -> u64),
    /// A measured value.
    Measure(MeasuredFigure),
}

pub fn figures() -> impl Iterator<Item = Figure> {
    let counts = counts::limited().map(|(name, of)| Figure { name, of: Kind::Count(of) });
    let measured =
        measured::limited().map(|figure| Figure { name: figure.name, of: Kind::Measure(figure) });
    counts.chain(measured)
}

impl Figure {
    /// The figure of that name.
    pub fn named(name: &str) -> Option<Self> {
        figures().find(|figure| figure.name == name)
    }

    /// True if it counts runs or events.
    pub fn is_count(&self) -> bool {
        matches!(self.of, Kind::Count(_))
    }

    /// Its value over all runs; none if no run measured it.
    pub fn value(&self, tally: &Tally) -> Option<f64> {
        match self.of {
            Kind::Count(of) => Some(of(&tally.counts) as f64),
            Kind::Measure(figure) => (figure.of)(&tally.measures),
        }
    }
}

/// A limit of a figure: a `max_` or `min_` key and its value.
#[derive(Clone, Copy)]
pub struct Limit {
    pub figure: Figure,
    /// True for `min_`: the figure must be at least the value.
    is_least: bool,
    pub value: f64,
}

impl Limit {
    /// The limit of a key in a campaign that was checked.
    pub fn of(key: &str, value: f64) -> Self {
        let (bound, name) = key.split_at(4);
        let figure = Figure::named(name).expect("a campaign's keys are checked when it is read");
        Self { figure, is_least: bound == "min_", value }
    }

    /// True if it asks for a least number of things in all runs together.
    pub fn is_least_number(&self) -> bool {
        self.is_least && self.figure.is_count()
    }

    /// The limit for a share of the runs: least numbers shrink in proportion.
    pub fn for_share(self, share: f64) -> Self {
        let value = if self.is_least_number() { (self.value * share).floor() } else { self.value };
        Self { value, ..self }
    }

    /// True if a value keeps it.
    pub fn holds(&self, found: f64) -> bool {
        if self.is_least { found >= self.value } else { found <= self.value }
    }

    /// The figure of a single run, if that run is to blame for a broken limit.
    pub fn blames(&self, record: &Record) -> Option<f64> {
        let mut alone = Sum::default();
        alone.add(record);
        let alone = alone.tally();
        match self.figure.of {
            Kind::Count(of) => {
                Some(of(&alone.counts) as f64).filter(|count| *count > 0.0 && !self.is_least)
            }
            Kind::Measure(figure) if figure.is_median => None,
            Kind::Measure(figure) => {
                (figure.of)(&alone.measures).filter(|value| !self.holds(*value))
            }
        }
    }
}
