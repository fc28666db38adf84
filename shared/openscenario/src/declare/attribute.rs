//! Attributes: types, ranges, words.

use std::marker::PhantomData;

use super::Node;
use crate::error::{ReadError, meant, one_of};
use crate::expression::Value;
use crate::scope::Raw;
use crate::words::Words;

/// Largest magnitude of a number, in any unit: beyond it no motion stays finite.
const MAX_NUMBER: f64 = 1e9;
/// Largest magnitude of a whole number: it counts lanes or executions.
const MAX_WHOLE: f64 = 1e6;

/// An attribute as the check and the reference see it.
#[derive(Debug)]
pub(crate) struct AttributeForm {
    pub name: &'static str,
    pub optional: bool,
    /// Its unit; empty without one.
    pub unit: &'static str,
    pub kind: fn() -> String,
}

impl AttributeForm {
    pub(crate) const fn of<T: FromAttribute>(name: &'static str, unit: &'static str) -> Self {
        Self { name, optional: T::OPTIONAL, unit, kind: T::KIND }
    }
}

pub(crate) trait Scalar {
    type Value;

    /// Its allowed values, for the reference and for errors.
    fn kind() -> String;

    fn take(given: &Given<'_>) -> Result<Self::Value, ReadError>;
}

/// The type of an attribute, which is optional as `Option`.
pub(crate) trait FromAttribute {
    const OPTIONAL: bool;
    const KIND: fn() -> String;
    type Value;

    fn read(node: Node<'_>, name: &str) -> Result<Self::Value, ReadError>;
}

impl<S: Scalar> FromAttribute for S {
    const OPTIONAL: bool = false;
    const KIND: fn() -> String = S::kind;
    type Value = S::Value;

    fn read(node: Node<'_>, name: &str) -> Result<S::Value, ReadError> {
        Option::<S>::read(node, name)?.ok_or_else(|| node.wrong(name, "is missing", S::kind()))
    }
}

impl<S: Scalar> FromAttribute for Option<S> {
    const OPTIONAL: bool = true;
    const KIND: fn() -> String = S::kind;
    type Value = Option<S::Value>;

    fn read(node: Node<'_>, name: &str) -> Result<Self::Value, ReadError> {
        let given = node.element.given(name);
        given.map(|_| S::take(&Given { node, raw: node.raw(name) })).transpose()
    }
}

pub(crate) struct Given<'a> {
    pub node: Node<'a>,
    pub raw: Raw,
}

impl Given<'_> {
    fn value(&self) -> Result<Value, ReadError> {
        self.raw.resolve(self.node.scope)
    }

    /// The text, exactly as a literal stands there.
    pub(crate) fn text(&self) -> Result<String, ReadError> {
        match self.raw.text.trim_start().starts_with('$') {
            true => Ok(self.value()?.text()),
            false => Ok(self.raw.text.clone()),
        }
    }

    /// A number, infinite ones included.
    fn any_number(&self, expected: &str) -> Result<f64, ReadError> {
        let value = self.value()?;
        let refuse = || self.raw.wrong(format!("`{}` is not a number", value.text()), expected);
        value.number().ok_or_else(refuse)
    }

    /// A finite number of a plausible magnitude, and in a range.
    pub(crate) fn number(
        &self,
        expected: &str,
        is_right: impl Fn(f64) -> bool,
    ) -> Result<f64, ReadError> {
        let number = self.any_number(expected)?;
        if !(number.abs() <= MAX_NUMBER) {
            let expected = format!("{expected}, from -{MAX_NUMBER:e} to {MAX_NUMBER:e}");
            return Err(self.raw.wrong(format!("{number} is out of range"), expected));
        }
        match is_right(number) {
            true => Ok(number),
            false => Err(self.raw.wrong(format!("{number} is out of range"), expected)),
        }
    }

    /// A whole number of a plausible magnitude, and not below `least`.
    fn whole(&self, expected: &str, least: i32) -> Result<i32, ReadError> {
        let number = self.number(expected, |number| number.abs() <= MAX_WHOLE)?;
        if libm::trunc(number) != number {
            return Err(self.raw.wrong(format!("{number} is not a whole number"), expected));
        }
        match number as i32 {
            whole if whole >= least => Ok(whole),
            whole => Err(self.raw.wrong(format!("{whole} is too small"), expected)),
        }
    }

    /// The meaning of one of some words.
    pub(crate) fn word<T: Copy>(&self, words: &[(&str, T)]) -> Result<T, ReadError> {
        let text = self.text()?;
        match words.iter().find(|(word, _)| *word == text) {
            Some((_, meaning)) => Ok(*meaning),
            None => {
                let known = words.iter().map(|(word, _)| *word);
                Err(self.raw.wrong(format!("`{text}` is not supported"), meant(&text, known)))
            }
        }
    }
}

/// Declares types of attributes: name, value, allowed values, reading.
macro_rules! scalars {
    ($($(#[$doc:meta])* $vis:vis $name:ident -> $value:ty: $kind:expr, |$given:ident| $take:expr;)*) => {$(
        $(#[$doc])*
        $vis struct $name;

        impl $crate::declare::Scalar for $name {
            type Value = $value;

            fn kind() -> String {
                $kind.into()
            }

            fn take(
                $given: &$crate::declare::Given<'_>,
            ) -> Result<$value, $crate::error::ReadError> {
                $take
            }
        }
    )*};
}

scalars! {
    pub(crate) Number -> f64: "a number", |given| given.number(&Self::kind(), |_| true);

    pub(crate) AtLeastZero -> f64: "0 or more", |given| given.number(&Self::kind(), |it| it >= 0.0);

    pub(crate) Positive -> f64: "more than 0", |given| given.number(&Self::kind(), |it| it > 0.0);

    /// A duration of at most 1e6 s; its value is in ns.
    pub(crate) Duration -> u64: "0 or more", |given| {
        let time_s = given.number(&Self::kind(), |time_s| (0.0..=1e6).contains(&time_s))?;
        Ok(libm::round(time_s * 1e9) as u64)
    };

    /// A bound above 0. `INF` means that there is none.
    pub(crate) Bound -> f64: "more than 0, or INF", |given| {
        match given.any_number(&Self::kind())? {
            bound if bound > 0.0 => Ok(bound),
            bound => Err(given.raw.wrong(format!("{bound} is out of range"), Self::kind())),
        }
    };

    pub(crate) Whole -> i32: "a whole number", |given| given.whole(&Self::kind(), i32::MIN);

    pub(crate) Count -> u32: "a whole number, 1 or more",
        |given| given.whole(&Self::kind(), 1).map(i32::unsigned_abs);

    pub(crate) Truth -> bool: "true or false", |given| {
        match given.value()? {
            Value::Boolean(value) => Ok(value),
            Value::Number(number) if number == 0.0 || number == 1.0 => Ok(number == 1.0),
            other => {
                let reason = format!("`{}` is not a truth value", other.text());
                Err(given.raw.wrong(reason, Self::kind()))
            }
        }
    };

    pub(crate) Text -> String: "a text", |given| given.text();

    /// A number, a truth value or a text.
    pub(crate) Literal -> Value: "a value", |given| given.value();
}

/// An attribute that is resolved later, in another scope.
pub(crate) struct Later<S>(PhantomData<S>);

impl<S: Scalar> Scalar for Later<S> {
    type Value = Raw;

    fn kind() -> String {
        S::kind()
    }

    fn take(given: &Given<'_>) -> Result<Raw, ReadError> {
        Ok(given.raw.clone())
    }
}

impl<W: Words> Scalar for W {
    type Value = Self;

    fn kind() -> String {
        kind_of(Self::WORDS)
    }

    fn take(given: &Given<'_>) -> Result<Self, ReadError> {
        given.word(Self::WORDS)
    }
}

/// The allowed words, for errors and for the reference.
pub(crate) fn kind_of<T>(words: &[(&str, T)]) -> String {
    one_of(words.iter().map(|(word, _)| *word))
}

/// Declares types of attributes by the words that stand for their values.
macro_rules! words {
    ($($(#[$doc:meta])* $name:ident = $value:ty {$($word:literal $meaning:expr),* $(,)?})*) => {
        $crate::declare::scalars! {$(
            $(#[$doc])*
            pub(crate) $name -> $value: $crate::declare::kind_of(&[$(($word, $meaning)),*]),
                |given| given.word(&[$(($word, $meaning)),*]);
        )*}
    };
}

pub(crate) use {scalars, words};
