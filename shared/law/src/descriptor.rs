//! Description of a law for the rest of the system, which need not build it.

use scenario::controller::Controller;
use scenario::referee::DesiredGap;
use scenario::{Problem, Scenario};
use serde::Serialize;

use super::Law;
use super::reader::Reader;
use crate::settings::Table;

/// A law as data: the registry (`laws::ALL`) is a list of these.
///
/// The command line, the scenario check, the referee's desired gap, the report and the conformance suite read the
/// descriptor. Only the control loop calls [`Descriptor::build`].
#[derive(Debug)]
pub struct Descriptor {
    /// Name in scenarios and on the command line.
    pub name: &'static str,
    /// Summary in one line.
    pub description: &'static str,
    pub source: &'static str,
    /// Its table below `[controller]`, if it has one.
    pub table: Option<Table>,
    /// Every way in which it is formulated; the first is the one for the road.
    pub formulations: &'static [&'static Formulation],
    /// The formulation that a scenario's keys choose.
    pub formulation: fn(&Controller) -> &'static Formulation,
    pub gap: GapPolicy,
    /// It filters the target itself: it is given gap and relative speed as measured, not the tracker's estimate.
    pub measured_target: bool,
    /// It refuses cars.
    pub trucks_alone: bool,
    /// Builds the law from the keys that it reads, or names the key that it refuses.
    pub build: fn(&Reader<'_>) -> Result<Box<dyn Law>, Problem>,
}

/// One formulation of a law: the meaning of the numbers in its output.
#[derive(Debug)]
pub struct Formulation {
    /// Name, for people.
    pub name: &'static str,
    /// A word of caution that every summary of a run shows; none where none is needed.
    pub caution: Option<&'static str>,
    /// Modes, in the order of [`Output::mode`](super::Output::mode).
    pub modes: &'static [&'static str],
    /// Reasons for a mode change, in the order of [`Output::mode_reason`](super::Output::mode_reason).
    pub reasons: &'static [&'static str],
    /// Figures, in the order of [`Output::figures`](super::Output::figures).
    pub figures: &'static [Figure],
}

impl Formulation {
    pub fn figure_names(&self) -> Vec<&'static str> {
        self.figures.iter().map(|figure| figure.name).collect()
    }

    /// The place of a figure among the output's.
    pub fn figure(&self, name: &str) -> Option<usize> {
        self.figures.iter().position(|figure| figure.name == name)
    }
}

/// A number that a law shows in `control/diagnostics`; no figure steers anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Figure {
    /// Name, with the unit as its ending.
    pub name: &'static str,
    pub unit: &'static str,
    /// Meaning and sign where the name does not give them; otherwise empty.
    pub meaning: &'static str,
}

impl Figure {
    pub const fn new(name: &'static str, unit: &'static str) -> Self {
        Self { name, unit, meaning: "" }
    }

    /// The same with what it is.
    pub const fn meaning(self, meaning: &'static str) -> Self {
        Self { meaning, ..self }
    }
}

/// Way by which others get the gap at which a law aims.
#[derive(Clone, Copy, Debug)]
pub enum GapPolicy {
    Scenario(fn(&Scenario) -> DesiredGap),
    /// The law shows gap minus desired gap as the figure of this name.
    Figure(&'static str),
    /// Only the law has it.
    Internal,
}
