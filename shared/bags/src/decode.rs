//! A number out of a message's bytes, by the path of its field.

use crate::definition::{DEEPEST, Definition, Field, Kind, Repeat, Scalar};

/// Most steps of a walk for each byte of the message.
const STEPS_PER_BYTE: usize = 8;

/// Encoding of the messages of a topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// Little-endian CDR behind four bytes of encapsulation, with a definition in ROS 2's language. Scalars stand on
    /// multiples of their size.
    Cdr,
    /// ROS 1: little-endian without gaps, with its definition.
    Ros1,
    Json,
    /// Another encoding, by name.
    Other(String),
}

/// A message is shorter than its definition, or encoded in another way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Misfit;

/// The number at `path`; `None` if the type has no number there.
pub(crate) fn number(
    definition: &Definition,
    path: &str,
    is_cdr: bool,
    payload: &[u8],
) -> Result<Option<f64>, Misfit> {
    let bytes = match is_cdr {
        true => payload.strip_prefix(&[0, 1]).and_then(|rest| rest.get(2..)).ok_or(Misfit)?,
        false => payload,
    };
    let Some(path) = path.split('.').map(step).collect::<Option<Vec<_>>>() else {
        return Ok(None);
    };
    let budget = STEPS_PER_BYTE * (bytes.len() + 100);
    let mut walk = Walk { definition, is_cdr, bytes, at: 0, budget };
    walk.find(&definition.root, &path, 0)
}

/// The number at `path` of a JSON text.
pub(crate) fn json_number(path: &str, payload: &[u8]) -> Result<Option<f64>, Misfit> {
    let value: serde_json::Value = serde_json::from_slice(payload).map_err(|_| Misfit)?;
    let mut at = &value;
    for part in path.split('.') {
        let Some((name, index)) = step(part) else { return Ok(None) };
        let found = at.get(name).and_then(|value| index.map_or(Some(value), |i| value.get(i)));
        let Some(found) = found else { return Ok(None) };
        at = found;
    }
    Ok(at.as_f64())
}

/// A name and the index behind it.
fn step(part: &str) -> Option<(&str, Option<usize>)> {
    match part.split_once('[') {
        None => Some((part, None)),
        Some((name, index)) => Some((name, Some(index.strip_suffix(']')?.parse().ok()?))),
    }
}

/// A walk over a message, field by field.
struct Walk<'a> {
    definition: &'a Definition,
    /// The layout is CDR's, not ROS 1's.
    is_cdr: bool,
    bytes: &'a [u8],
    at: usize,
    /// Steps that are left. A definition can ask for more elements than the message has bytes.
    budget: usize,
}

impl Walk<'_> {
    fn find(
        &mut self,
        type_name: &str,
        path: &[(&str, Option<usize>)],
        depth: usize,
    ) -> Result<Option<f64>, Misfit> {
        let definition = self.definition;
        let ([(name, index), rest @ ..], Some(fields)) = (path, definition.fields(type_name))
        else {
            return Ok(None);
        };
        for field in fields {
            if field.name == *name && depth < DEEPEST {
                return self.value(field, *index, rest, depth);
            }
            self.skip_field(field, depth)?;
        }
        Ok(None)
    }

    fn value(
        &mut self,
        field: &Field,
        index: Option<usize>,
        rest: &[(&str, Option<usize>)],
        depth: usize,
    ) -> Result<Option<f64>, Misfit> {
        let index = match (field.repeat, index) {
            (Repeat::Once, None) => 0,
            (Repeat::Fixed(count), Some(index)) if index < count => index,
            (Repeat::Counted, Some(index)) => match self.bits(4)? as usize {
                count if index < count => index,
                // An array that is too short in this message has no number there.
                _ => return Ok(None),
            },
            _ => return Ok(None),
        };
        for _ in 0..index {
            self.skip(&field.kind, depth)?;
        }
        match &field.kind {
            Kind::Scalar(scalar) if rest.is_empty() => self.scalar(*scalar),
            Kind::Struct(name) if rest.is_empty() && self.definition.is_time(name) => {
                Ok(Some(self.signed(4)? + self.bits(4)? as f64 * 1e-9))
            }
            Kind::Struct(name) if !rest.is_empty() => self.find(name, rest, depth + 1),
            _ => Ok(None),
        }
    }

    fn scalar(&mut self, scalar: Scalar) -> Result<Option<f64>, Misfit> {
        Ok(Some(match scalar {
            Scalar::Unsigned(bytes) => self.bits(bytes)? as f64,
            Scalar::Signed(bytes) => self.signed(bytes)?,
            Scalar::Float(4) => f64::from(f32::from_bits(self.bits(4)? as u32)),
            Scalar::Float(_) => f64::from_bits(self.bits(8)?),
            Scalar::Time => self.bits(4)? as f64 + self.bits(4)? as f64 * 1e-9,
            Scalar::Duration => self.signed(4)? + self.signed(4)? * 1e-9,
            Scalar::Text => return Ok(None),
        }))
    }

    fn skip_field(&mut self, field: &Field, depth: usize) -> Result<(), Misfit> {
        let count = match field.repeat {
            Repeat::Once => 1,
            Repeat::Fixed(count) => count,
            Repeat::Counted => self.bits(4)? as usize,
        };
        (0..count).try_for_each(|_| self.skip(&field.kind, depth))
    }

    fn skip(&mut self, kind: &Kind, depth: usize) -> Result<(), Misfit> {
        self.budget = self.budget.checked_sub(1).ok_or(Misfit)?;
        match kind {
            Kind::Scalar(Scalar::Text) => {
                let length = self.bits(4)? as usize;
                self.pass(length)
            }
            Kind::Scalar(Scalar::Time | Scalar::Duration) => {
                self.bits(4).and(self.bits(4)).map(drop)
            }
            Kind::Scalar(
                Scalar::Signed(bytes) | Scalar::Unsigned(bytes) | Scalar::Float(bytes),
            ) => {
                self.align(*bytes);
                self.pass(*bytes)
            }
            Kind::Struct(name) => {
                let definition = self.definition;
                let fields = definition.fields(name).filter(|_| depth < DEEPEST).ok_or(Misfit)?;
                if fields.is_empty() && self.is_cdr {
                    // CDR has a byte for a struct without fields.
                    return self.pass(1);
                }
                fields.iter().try_for_each(|field| self.skip_field(field, depth + 1))
            }
        }
    }

    fn align(&mut self, bytes: usize) {
        if self.is_cdr {
            self.at = self.at.next_multiple_of(bytes);
        }
    }

    fn pass(&mut self, bytes: usize) -> Result<(), Misfit> {
        self.at = self.at.checked_add(bytes).filter(|at| *at <= self.bytes.len()).ok_or(Misfit)?;
        Ok(())
    }

    /// Takes a number of so many bytes, little-endian, as its bits.
    fn bits(&mut self, bytes: usize) -> Result<u64, Misfit> {
        self.align(bytes);
        let begin = self.at;
        self.pass(bytes)?;
        let bytes = self.bytes[begin..self.at].iter().rev();
        Ok(bytes.fold(0, |bits, byte| bits << 8 | u64::from(*byte)))
    }

    /// Takes a number in two's complement.
    fn signed(&mut self, bytes: usize) -> Result<f64, Misfit> {
        let rest = 64 - 8 * bytes;
        Ok((((self.bits(bytes)? << rest) as i64) >> rest) as f64)
    }
}
