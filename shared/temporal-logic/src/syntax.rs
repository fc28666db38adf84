//! The tree of a formula, as a list of nodes in which children stand before their parents.

use std::ops::Range;

/// Index of a node.
pub(crate) type NodeId = usize;

/// A node and its place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Node {
    pub kind: Kind,
    /// Bytes of the text that an error marks.
    pub place: Range<usize>,
}

/// A window of time after (or, of `once`, before) a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Window {
    /// Its beginning, s.
    pub first_s: f64,
    /// Its end, s; the end of the trace without one.
    pub last_s: Option<f64>,
}

impl Window {
    /// All samples to come.
    pub(crate) const ALL: Self = Self { first_s: 0.0, last_s: None };
}

/// The operation of a node.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Kind {
    Number(f64),
    Signal(usize),
    Negative(NodeId),
    Absolute(NodeId),
    Sum(NodeId, NodeId),
    Difference(NodeId, NodeId),
    Product(NodeId, NodeId),
    /// The left side is at least the right one. Margins do not distinguish this from "greater".
    AtLeast(NodeId, NodeId),
    Not(NodeId),
    And(NodeId, NodeId),
    Or(NodeId, NodeId),
    Implies(NodeId, NodeId),
    Always(Window, NodeId),
    Eventually(Window, NodeId),
    Once(Window, NodeId),
    Until(Window, NodeId, NodeId),
}

impl Kind {
    /// The signal that the node reads.
    pub(crate) fn signal(&self) -> Option<usize> {
        match self {
            Self::Signal(index) => Some(*index),
            _ => None,
        }
    }

    /// The node's window of time.
    pub(crate) fn window(&self) -> Option<Window> {
        match self {
            Self::Always(window, _)
            | Self::Eventually(window, _)
            | Self::Once(window, _)
            | Self::Until(window, _, _) => Some(*window),
            _ => None,
        }
    }
}
