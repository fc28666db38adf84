//! The tree of a formula, as a list of nodes in which children stand before their parents, and the check that its
//! conditions and numbers stand in their places and its units go together.

use crate::error::{FormulaError, Problem};
use crate::{Signal, Unit};
use std::ops::Range;

pub(crate) type NodeId = usize;

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Node {
    pub kind: Kind,
    /// Bytes of the text that an error marks.
    pub place: Range<usize>,
}

/// A window of time after (or, of `once`, before) a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Window {
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

/// The kind of a node's values.
#[derive(Clone, Copy, Debug)]
enum Gives {
    Number(Unit),
    Condition(Unit),
}

/// The unit of each node, of a condition that of its margin; the root is a condition.
pub(crate) fn check(
    text: &str,
    nodes: &[Node],
    root: NodeId,
    signals: &[Signal],
) -> Result<Vec<Unit>, FormulaError> {
    let mut gives: Vec<Gives> = Vec::with_capacity(nodes.len());
    for node in nodes {
        let checked = Checked { text, nodes, gives: &gives };
        let found = checked.node(node, signals)?;
        gives.push(found);
    }
    Checked { text, nodes, gives: &gives }.condition(root)?;
    Ok(gives.into_iter().map(|(Gives::Number(unit) | Gives::Condition(unit))| unit).collect())
}

struct Checked<'a> {
    text: &'a str,
    nodes: &'a [Node],
    /// The kinds of the nodes before this one: children stand before their parents.
    gives: &'a [Gives],
}

impl Checked<'_> {
    fn node(&self, node: &Node, signals: &[Signal]) -> Result<Gives, FormulaError> {
        Ok(match node.kind {
            Kind::Number(_) => Gives::Number(Unit::Any),
            Kind::Signal(index) => Gives::Number(signals[index].unit),
            Kind::Negative(a) | Kind::Absolute(a) => Gives::Number(self.number(a)?),
            Kind::Sum(a, b) | Kind::Difference(a, b) => Gives::Number(self.same(node, a, b)?),
            Kind::Product(a, b) => Gives::Number(self.number(a)?.times(self.number(b)?)),
            Kind::AtLeast(a, b) => Gives::Condition(self.same(node, a, b)?),
            Kind::Not(a) | Kind::Always(_, a) | Kind::Eventually(_, a) | Kind::Once(_, a) => {
                Gives::Condition(self.condition(a)?)
            }
            Kind::And(a, b) | Kind::Or(a, b) | Kind::Implies(a, b) | Kind::Until(_, a, b) => {
                let both = self.condition(a)?.with(self.condition(b)?);
                Gives::Condition(both.unwrap_or(Unit::Mixed))
            }
        })
    }

    fn number(&self, id: NodeId) -> Result<Unit, FormulaError> {
        match self.gives[id] {
            Gives::Number(unit) => Ok(unit),
            Gives::Condition(_) => Err(self.error(&self.nodes[id], Problem::ConditionForNumber)),
        }
    }

    fn condition(&self, id: NodeId) -> Result<Unit, FormulaError> {
        match self.gives[id] {
            Gives::Condition(unit) => Ok(unit),
            Gives::Number(_) => Err(self.error(&self.nodes[id], Problem::NumberForCondition)),
        }
    }

    fn same(&self, node: &Node, a: NodeId, b: NodeId) -> Result<Unit, FormulaError> {
        let (left, right) = (self.number(a)?, self.number(b)?);
        left.with(right).ok_or_else(|| self.error(node, Problem::Units { left, right }))
    }

    fn error(&self, node: &Node, problem: Problem) -> FormulaError {
        FormulaError::at(self.text, node.place.clone(), problem)
    }
}
