//! TraCI's bytes: commands out, answers in. Numbers are big-endian; a text is its length and its bytes.

use std::io::{self, ErrorKind, Read, Write};

use crate::ProgramError;

/// Longest message, bytes: the vehicles around the ego take a few thousand.
const MOST_BYTES: usize = 64 << 20;
/// A subscription from before this time to this time lasts for the whole run, s.
const ALWAYS_S: f64 = 1_073_741_824.0;
/// Deepest nesting of a compound value.
const MOST_DEPTH: u32 = 8;

/// The next message of a stream; `InvalidData` for a length that no message has.
pub fn read_message(stream: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut head = [0; 4];
    stream.read_exact(&mut head)?;
    let length = usize::try_from(i32::from_be_bytes(head)).ok();
    let length = length.and_then(|length| length.checked_sub(4)).filter(|n| *n <= MOST_BYTES);
    let mut body = vec![0; length.ok_or(ErrorKind::InvalidData)?];
    stream.read_exact(&mut body).map(|()| body)
}

pub fn write_message(stream: &mut impl Write, body: &[u8]) -> io::Result<()> {
    stream.write_all(&[&(body.len() as i32 + 4).to_be_bytes(), body].concat())
}

#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Number(f64),
    Text(String),
    Texts(Vec<String>),
    Point([f64; 2]),
    Compound(Vec<Value>),
}

impl Value {
    /// The number; NaN for another value.
    pub fn number(&self) -> f64 {
        if let Self::Number(number) = self { *number } else { f64::NAN }
    }

    /// The text; empty for another value.
    pub fn text(&self) -> &str {
        if let Self::Text(text) = self { text } else { "" }
    }

    /// The parts of a compound; none for another value.
    pub fn parts(&self) -> &[Value] {
        if let Self::Compound(parts) = self { parts } else { &[] }
    }
}

/// The body of a command. A typed value has its type before it.
#[derive(Clone, Debug, Default)]
pub struct Body(pub Vec<u8>);

impl Body {
    pub fn byte(mut self, value: u8) -> Self {
        self.0.push(value);
        self
    }

    pub fn whole(mut self, value: i32) -> Self {
        self.0.extend(value.to_be_bytes());
        self
    }

    pub fn number(mut self, value: f64) -> Self {
        self.0.extend(value.to_be_bytes());
        self
    }

    pub fn text(mut self, text: &str) -> Self {
        self = self.whole(text.len() as i32);
        self.0.extend(text.as_bytes());
        self
    }

    pub fn typed_text(self, text: &str) -> Self {
        self.byte(0x0c).text(text)
    }

    pub fn typed_number(self, value: f64) -> Self {
        self.byte(0x0b).number(value)
    }

    pub fn typed_whole(self, value: i32) -> Self {
        self.byte(0x09).whole(value)
    }

    /// Appends the command `id` with this body to a message, with its length in the form for long ones.
    pub fn write(&self, id: u8, message: &mut Vec<u8>) {
        let length = self.0.len() as i32 + 6;
        message.push(0);
        message.extend(length.to_be_bytes());
        message.push(id);
        message.extend(&self.0);
    }
}

/// A subscription to variables for the whole run; without variables its end.
pub fn subscription(to: impl Fn(Body) -> Body, variables: &[u8]) -> Body {
    let body = to(Body::default().number(-ALWAYS_S).number(ALWAYS_S));
    let mut body = body.byte(variables.len() as u8);
    body.0.extend(variables);
    body
}

pub struct Answer<'a>(pub &'a [u8]);

type Done<T> = Result<T, ProgramError>;

impl<'a> Answer<'a> {
    fn take(&mut self, count: usize) -> Done<&'a [u8]> {
        let taken = self.0.split_at_checked(count);
        let (taken, rest) = taken.ok_or(ProgramError::Nonsense("it ends too early"))?;
        self.0 = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Done<[u8; N]> {
        Ok(self.take(N)?.try_into().expect("it has this length"))
    }

    pub fn byte(&mut self) -> Done<u8> {
        Ok(self.array::<1>()?[0])
    }

    pub fn whole(&mut self) -> Done<i32> {
        Ok(i32::from_be_bytes(self.array()?))
    }

    /// A count of things that follow, each of at least one byte.
    pub fn count(&mut self) -> Done<usize> {
        let count = self.whole()?;
        let count = usize::try_from(count).ok().filter(|count| *count <= self.0.len());
        count.ok_or(ProgramError::Nonsense("a count beyond its end"))
    }

    pub fn number(&mut self) -> Done<f64> {
        Ok(f64::from_be_bytes(self.array()?))
    }

    pub fn text(&mut self) -> Done<String> {
        let length = self.count()?;
        Ok(String::from_utf8_lossy(self.take(length)?).into_owned())
    }

    /// The next command of a message: its id, its body, and all of it.
    pub fn command(&mut self) -> Done<(u8, Answer<'a>, &'a [u8])> {
        let (begun, short) = (self.0, usize::from(self.byte()?));
        let length = if short > 0 { short } else { self.whole()?.max(0) as usize };
        let head = begun.len() - self.0.len();
        self.0 = begun;
        let whole = self.take(length)?;
        let mut body = Answer(whole.get(head..).unwrap_or_default());
        Ok((body.byte()?, body, whole))
    }

    /// The words of a command that was refused.
    pub fn refusal(&mut self) -> Done<Option<String>> {
        let (_, mut body, _) = self.command()?;
        let (result, words) = (body.byte()?, body.text()?);
        Ok((result != 0).then_some(words))
    }

    /// The values of a subscription's variables, in their order.
    pub fn variables<const N: usize>(&mut self, asked: [u8; N]) -> Done<[Value; N]> {
        let mut values = asked.map(|_| Value::Number(f64::NAN));
        for (value, variable) in values.iter_mut().zip(asked) {
            let (given, result) = (self.byte()?, self.byte()?);
            *value = self.value()?;
            if result != 0 {
                return Err(ProgramError::Refused("a subscription", value.text().to_owned()));
            }
            if given != variable {
                return Err(ProgramError::Nonsense("a variable that was not asked for"));
            }
        }
        Ok(values)
    }

    pub fn value(&mut self) -> Done<Value> {
        self.nested(0)
    }

    fn nested(&mut self, depth: u32) -> Done<Value> {
        Ok(match self.byte()? {
            0x01 => Value::Point([self.number()?, self.number()?]),
            0x03 => {
                let point = [self.number()?, self.number()?];
                self.number()?;
                Value::Point(point)
            }
            0x07 | 0x08 => Value::Number(self.byte()?.into()),
            0x09 => Value::Number(self.whole()?.into()),
            0x0b => Value::Number(self.number()?),
            0x0c => Value::Text(self.text()?),
            0x0e => {
                let count = self.count()?;
                Value::Texts((0..count).map(|_| self.text()).collect::<Done<_>>()?)
            }
            0x0f if depth < MOST_DEPTH => {
                let count = self.count()?;
                let parts = (0..count).map(|_| self.nested(depth + 1));
                Value::Compound(parts.collect::<Done<_>>()?)
            }
            _ => return Err(ProgramError::Nonsense("a value of an unknown type")),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_command_has_the_length_of_a_long_one() {
        let mut message = Vec::new();
        Body::default().text(&"x".repeat(300)).write(0x2a, &mut message);
        assert_eq!((message[0], message[5], message.len()), (0, 0x2a, 1 + 4 + 1 + 304));
        assert_eq!(message[1..5], 310_i32.to_be_bytes());
        let mut short = Vec::new();
        Body::default().byte(7).write(0x2a, &mut short);
        assert_eq!(short, [0, 0, 0, 0, 7, 0x2a, 7]);
        assert_eq!(Answer(&short).command().expect("whole").1.0, [7]);
        let (id, body, _) = Answer(&[3, 0x2a, 7]).command().expect("SUMO's answers are short");
        assert_eq!((id, body.0), (0x2a, &[7][..]));
    }

    #[test]
    fn values_come_back_and_a_cut_answer_is_refused_at_each_byte() {
        let body = Body::default().byte(0x0f).whole(3).typed_number(1.5).typed_text("ab");
        let bytes = body.byte(0x0f).whole(1).typed_whole(-7).0;
        let value = Answer(&bytes).value().expect("whole");
        let parts = value.parts();
        assert_eq!((parts[0].number(), parts[1].text()), (1.5, "ab"));
        assert_eq!(parts[2].parts()[0].number(), -7.0);
        for end in 0..bytes.len() {
            assert!(Answer(&bytes[..end]).value().is_err(), "{end}");
        }
        let deep: Vec<u8> = [0x0f, 0, 0, 0, 1].repeat(20);
        assert!(Answer(&deep).value().is_err());
        assert!(Answer(&[0x0e, 0x7f, 0xff, 0xff, 0xff]).value().is_err(), "a count beyond the end");
    }
}
