//! Signal temporal logic: formulas over sampled signals, and by how much they hold.
//!
//! A [`Formula`] is read from text and checked against the signals that exist, their units included. Evaluated on a
//! [`Trace`], it gives a [`Margin`]. This is the distance to violation in the formula's unit, and the sample that
//! decides it. A positive margin holds, a negative one is violated.
//!
//! ```text
//! formula     = implied
//! implied     = either [ "implies" implied ]
//! either      = both { "or" both }
//! both        = until { "and" until }
//! until       = prefixed [ "until" [window] prefixed ]
//! prefixed    = ( "not" | "always" [window] | "eventually" [window] | "once" [window] ) prefixed | comparison
//! comparison  = sum [ ( "<" | "<=" | ">" | ">=" ) sum ]
//! sum         = product { ( "+" | "-" ) product }
//! product     = factor { "*" factor }
//! factor      = "-" factor | "abs" "(" sum ")" | "(" formula ")" | number | signal
//! window      = "[" seconds "," seconds "]"
//! ```
//!
//! Semantics: Donzé and Maler, Robust Satisfaction of Temporal Logic over Real-Valued Signals (FORMATS 2010), on
//! samples. A window that reaches beyond the last sample ends there. `until` needs its left side before the sample in
//! which its right side holds, not in it. Windows are evaluated in linear time. Extremes are by Lemire, Streaming
//! Maximum-Minimum Filter (2006); `until` is by the decomposition in Donzé, Ferrère and Maler, Efficient Robust
//! Monitoring for STL (CAV 2013).
//!
//! ```
//! use temporal_logic::{Formula, Signal, Trace, Unit};
//!
//! let signals = [Signal { name: "gap_m", unit: Unit::METRE }, Signal { name: "speed_mps", unit: Unit::METRE_PER_SECOND }];
//! let formula = Formula::parse("always (speed_mps > 10 implies gap_m >= 1.5 * speed_mps)", &signals)?;
//!
//! let gap_m = [40.0, 35.0, 31.0];
//! let speed_mps = [20.0, 20.0, 20.0];
//! let margin = formula.margin(&Trace { period_s: 0.01, samples: vec![&gap_m, &speed_mps] });
//! // The last sample decides. The formula has conditions in m/s and in m, so its margin counts tolerances: 1 m is two.
//! assert_eq!((margin.value, margin.sample), (2.0, 2));
//! # Ok::<(), temporal_logic::FormulaError>(())
//! ```

mod error;
mod evaluate;
mod parse;
mod syntax;
mod token;
mod unit;

pub use error::{FormulaError, Problem};
pub use evaluate::{Margin, Trace};
pub use unit::Unit;

use syntax::{Kind, Node, NodeId};

/// A signal that formulas may name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signal {
    pub name: &'static str,
    pub unit: Unit,
}

/// A formula whose signals, units and windows were checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    text: String,
    nodes: Vec<Node>,
    root: NodeId,
    units: Vec<Unit>,
}

impl Formula {
    /// Reads a formula over `signals`.
    ///
    /// # Errors
    /// [`FormulaError`] with the place: an unexpected word, an unknown signal, units that do not fit together, or a
    /// window that ends before it begins.
    pub fn parse(text: &str, signals: &[Signal]) -> Result<Self, FormulaError> {
        let (nodes, root) = parse::formula(text, signals)?;
        let units = syntax::check(text, &nodes, root, signals)?;
        Ok(Self { text: text.to_owned(), nodes, root, units })
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    /// Unit of the margin. A formula that compares quantities of different units has [`Unit::Mixed`]: its margin
    /// counts tolerances ([`Unit::tolerance`]).
    pub fn unit(&self) -> Unit {
        self.units[self.root]
    }

    /// Indices of the signals that the formula reads, ascending.
    pub fn signals(&self) -> Vec<usize> {
        let of = |node: &Node| match node.kind {
            Kind::Signal(index) => Some(index),
            _ => None,
        };
        let mut read: Vec<usize> = self.nodes.iter().filter_map(of).collect();
        read.sort_unstable();
        read.dedup();
        read
    }

    /// Checks that every window ends within a run of `duration_s`.
    ///
    /// # Errors
    /// [`Problem::LongWindow`] at the first window that does not.
    pub fn check_duration(&self, duration_s: f64) -> Result<(), FormulaError> {
        let long = |node: &&Node| {
            node.kind.window().is_some_and(|w| w.last_s.is_some_and(|b| b > duration_s))
        };
        match self.nodes.iter().find(long) {
            Some(node) => Err(FormulaError::at(
                &self.text,
                node.place.clone(),
                Problem::LongWindow { duration_s },
            )),
            None => Ok(()),
        }
    }

    /// The margin at the first sample of `trace`.
    ///
    /// # Panics
    /// If the trace has no sample, or less signals than the formula was read with.
    pub fn margin(&self, trace: &Trace<'_>) -> Margin {
        evaluate::margin(self, trace)
    }
}
