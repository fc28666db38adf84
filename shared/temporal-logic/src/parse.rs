//! Reads the words of a formula into its tree, by recursive descent along the grammar in the crate's documentation.

use crate::Signal;
use crate::error::{FormulaError, Problem};
use crate::syntax::{Kind, Node, NodeId, Window};
use crate::token::{Token, tokens};
use std::ops::Range;

/// Nesting that is read at most. It bounds the stack.
const MOST_DEPTH: usize = 64;

/// Words that no signal may be called.
const KEYWORDS: [&str; 9] =
    ["and", "or", "not", "implies", "always", "eventually", "once", "until", "abs"];

/// Nodes of the formula `text`, and its root.
pub(crate) fn formula(text: &str, signals: &[Signal]) -> Result<(Vec<Node>, NodeId), FormulaError> {
    let mut reader =
        Reader { text, tokens: tokens(text)?, at: 0, depth: 0, signals, nodes: Vec::new() };
    let root = reader.implied()?;
    match reader.peek() {
        Token::End => Ok((reader.nodes, root)),
        _ => Err(reader.unexpected("an operator or the end")),
    }
}

/// A word between two parts, and the node that it makes of them.
type Operator = (Token<'static>, fn(NodeId, NodeId) -> Kind);

struct Reader<'a> {
    text: &'a str,
    tokens: Vec<(Token<'a>, Range<usize>)>,
    at: usize,
    depth: usize,
    signals: &'a [Signal],
    nodes: Vec<Node>,
}

impl<'a> Reader<'a> {
    fn implied(&mut self) -> Result<NodeId, FormulaError> {
        self.deeper(|reader| {
            let left = reader.either()?;
            let place = reader.place();
            if !reader.take(Token::Name("implies")) {
                return Ok(left);
            }
            let right = reader.implied()?;
            Ok(reader.node(Kind::Implies(left, right), place))
        })
    }

    fn either(&mut self) -> Result<NodeId, FormulaError> {
        self.chain(Self::both, &[(Token::Name("or"), Kind::Or)])
    }

    fn both(&mut self) -> Result<NodeId, FormulaError> {
        self.chain(Self::until, &[(Token::Name("and"), Kind::And)])
    }

    fn sum(&mut self) -> Result<NodeId, FormulaError> {
        let operators: [Operator; 2] =
            [(Token::Symbol("+"), Kind::Sum), (Token::Symbol("-"), Kind::Difference)];
        self.chain(Self::product, &operators)
    }

    fn product(&mut self) -> Result<NodeId, FormulaError> {
        self.chain(Self::factor, &[(Token::Symbol("*"), Kind::Product)])
    }

    /// Parts joined by operators of one rank, from left to right.
    fn chain(
        &mut self,
        part: fn(&mut Self) -> Result<NodeId, FormulaError>,
        operators: &[Operator],
    ) -> Result<NodeId, FormulaError> {
        let mut left = part(self)?;
        while let Some((_, kind)) = operators.iter().find(|(word, _)| self.peek() == *word) {
            let place = self.place();
            self.advance();
            let right = part(self)?;
            left = self.node(kind(left, right), place);
        }
        Ok(left)
    }

    fn until(&mut self) -> Result<NodeId, FormulaError> {
        let left = self.prefixed()?;
        let place = self.place();
        if !self.take(Token::Name("until")) {
            return Ok(left);
        }
        let window = self.window()?;
        let right = self.prefixed()?;
        Ok(self.node(Kind::Until(window, left, right), place))
    }

    fn prefixed(&mut self) -> Result<NodeId, FormulaError> {
        let place = self.place();
        let temporal: fn(Window, NodeId) -> Kind = match self.peek() {
            Token::Name("not") => {
                self.advance();
                let inner = self.deeper(Self::prefixed)?;
                return Ok(self.node(Kind::Not(inner), place));
            }
            Token::Name("always") => Kind::Always,
            Token::Name("eventually") => Kind::Eventually,
            Token::Name("once") => Kind::Once,
            _ => return self.comparison(),
        };
        self.advance();
        let window = self.window()?;
        let inner = self.deeper(Self::prefixed)?;
        Ok(self.node(temporal(window, inner), place))
    }

    fn comparison(&mut self) -> Result<NodeId, FormulaError> {
        let left = self.sum()?;
        let place = self.place();
        let is_at_least = match self.peek() {
            Token::Symbol(">" | ">=") => true,
            Token::Symbol("<" | "<=") => false,
            _ => return Ok(left),
        };
        self.advance();
        let right = self.sum()?;
        let kind =
            if is_at_least { Kind::AtLeast(left, right) } else { Kind::AtLeast(right, left) };
        Ok(self.node(kind, place))
    }

    fn factor(&mut self) -> Result<NodeId, FormulaError> {
        let place = self.place();
        match self.peek() {
            Token::Number(number) => {
                self.advance();
                Ok(self.node(Kind::Number(number), place))
            }
            Token::Symbol("-") => {
                self.advance();
                let inner = self.deeper(Self::factor)?;
                Ok(self.node(Kind::Negative(inner), place))
            }
            Token::Symbol("(") => {
                self.advance();
                let inner = self.implied()?;
                self.expect(")", "\")\"")?;
                Ok(inner)
            }
            Token::Name("abs") => {
                self.advance();
                self.expect("(", "\"(\"")?;
                let inner = self.deeper(Self::sum)?;
                self.expect(")", "\")\"")?;
                Ok(self.node(Kind::Absolute(inner), place))
            }
            Token::Name(name) if !KEYWORDS.contains(&name) => {
                let index = self.signal(name, &place)?;
                self.advance();
                Ok(self.node(Kind::Signal(index), place))
            }
            _ => Err(self.unexpected(
                "a signal, a number, \"(\", \"not\", \"always\", \"eventually\" or \"once\"",
            )),
        }
    }

    fn window(&mut self) -> Result<Window, FormulaError> {
        let begin = self.place().start;
        if !self.take(Token::Symbol("[")) {
            return Ok(Window::ALL);
        }
        let first_s = self.seconds()?;
        self.expect(",", "\",\"")?;
        let last_s = self.seconds()?;
        let end = self.place().end;
        self.expect("]", "\"]\"")?;
        if first_s > last_s {
            return Err(FormulaError::at(
                self.text,
                begin..end,
                Problem::Window { first_s, last_s },
            ));
        }
        Ok(Window { first_s, last_s: Some(last_s) })
    }

    fn seconds(&mut self) -> Result<f64, FormulaError> {
        let Token::Number(seconds) = self.peek() else {
            return Err(self.unexpected("a time in s, at least 0"));
        };
        self.advance();
        Ok(seconds)
    }

    fn signal(&self, name: &str, place: &Range<usize>) -> Result<usize, FormulaError> {
        self.signals.iter().position(|signal| signal.name == name).ok_or_else(|| {
            let known: Vec<&'static str> = self.signals.iter().map(|signal| signal.name).collect();
            let distance = |known: &&str| strsim::osa_distance(name, known);
            let nearest =
                known.iter().copied().min_by_key(distance).filter(|known| distance(known) <= 3);
            FormulaError::at(
                self.text,
                place.clone(),
                Problem::UnknownSignal { name: name.to_owned(), known, nearest },
            )
        })
    }

    fn deeper<T>(
        &mut self,
        read: impl FnOnce(&mut Self) -> Result<T, FormulaError>,
    ) -> Result<T, FormulaError> {
        if self.depth == MOST_DEPTH {
            return Err(FormulaError::at(
                self.text,
                self.place(),
                Problem::Depth { most: MOST_DEPTH },
            ));
        }
        self.depth += 1;
        let result = read(self);
        self.depth -= 1;
        result
    }

    fn node(&mut self, kind: Kind, place: Range<usize>) -> NodeId {
        self.nodes.push(Node { kind, place });
        self.nodes.len() - 1
    }

    fn peek(&self) -> Token<'a> {
        self.tokens[self.at].0
    }

    fn place(&self) -> Range<usize> {
        self.tokens[self.at].1.clone()
    }

    /// Goes on to the next word; [`Token::End`] stays.
    fn advance(&mut self) {
        self.at = (self.at + 1).min(self.tokens.len() - 1);
    }

    /// Goes on if the next word is this one.
    fn take(&mut self, word: Token<'_>) -> bool {
        let there = self.peek() == word;
        if there {
            self.advance();
        }
        there
    }

    fn expect(&mut self, symbol: &'static str, cited: &'static str) -> Result<(), FormulaError> {
        if self.take(Token::Symbol(symbol)) { Ok(()) } else { Err(self.unexpected(cited)) }
    }

    fn unexpected(&self, expected: &'static str) -> FormulaError {
        let found = self.peek().cited();
        FormulaError::at(self.text, self.place(), Problem::Unexpected { found, expected })
    }
}
