//! Checks that conditions and numbers stand in their places and that units go together.

use crate::error::{FormulaError, Problem};
use crate::syntax::{Kind, Node, NodeId};
use crate::{Signal, Unit};

/// The kind of a node's values.
#[derive(Clone, Copy, Debug)]
enum Gives {
    Number(Unit),
    /// A condition, with the unit of its margin.
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
