//! Reading of placed values by serde: an error has the value's place, and the expected type in plain words.

use std::collections::{BTreeMap, btree_map};
use std::ops::Range;

use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{
    DeserializeSeed, Deserializer, Error, Expected, IntoDeserializer, MapAccess, SeqAccess,
    Unexpected, Visitor,
};
use serde::forward_to_deserialize_any;

use super::{Content, Placed};
use crate::refusal::Refusal;

impl Placed {
    /// The refusal of a value of another type than the expected one.
    fn mismatch(&self, expected: &dyn Expected) -> Refusal {
        let found = match &self.content {
            Content::Unreadable(found) => return Refusal::unreadable(found, expected),
            Content::Scalar(toml::Value::String(text)) => Unexpected::Str(text),
            Content::Scalar(toml::Value::Integer(number)) => Unexpected::Signed(*number),
            Content::Scalar(toml::Value::Float(number)) => Unexpected::Float(*number),
            Content::Scalar(toml::Value::Boolean(truth)) => Unexpected::Bool(*truth),
            Content::Scalar(other) => Unexpected::Other(other.type_str()),
            Content::Array(_) => Unexpected::Other("a list"),
            Content::Table(_) => Unexpected::Other("a table"),
        };
        Refusal::invalid_type(found, expected)
    }

    fn read_any<'de, V: Visitor<'de>>(&'de self, visitor: V) -> Result<V::Value, Refusal> {
        match &self.content {
            Content::Scalar(toml::Value::String(text)) => visitor.visit_str(text),
            Content::Scalar(toml::Value::Integer(number)) => visitor.visit_i64(*number),
            Content::Scalar(toml::Value::Float(number)) => visitor.visit_f64(*number),
            Content::Scalar(toml::Value::Boolean(truth)) => visitor.visit_bool(*truth),
            Content::Array(array) => visitor.visit_seq(Elements(array.iter())),
            Content::Table(table) => visitor.visit_map(Entries::of(table)),
            Content::Scalar(_) | Content::Unreadable(_) => Err(self.mismatch(&visitor)),
        }
    }

    /// Reads a whole number of a type that holds those from `least` to `most`.
    fn read_whole<'de, V: Visitor<'de>>(
        &'de self,
        visitor: V,
        least: i64,
        most: i64,
    ) -> Result<V::Value, Refusal> {
        let Content::Scalar(toml::Value::Integer(number)) = self.content else {
            return Err(self.mismatch(&"a whole number"));
        };
        visitor.visit_i64(number).map_err(|error: Refusal| {
            error.expecting(match number {
                number if number < least => format!("a whole number of {least} or more"),
                number if number > most => format!("a whole number up to {most}"),
                // Only types that exclude 0 refuse a number within these limits.
                _ => "a whole number of 1 or more".to_owned(),
            })
        })
    }

    fn read_tuple<'de, V: Visitor<'de>>(
        &'de self,
        count: usize,
        visitor: V,
        expected: &str,
    ) -> Result<V::Value, Refusal> {
        let read = match &self.content {
            Content::Array(array) if array.len() == count => self.read_any(visitor),
            Content::Array(array) => Err(Refusal::invalid_length(array.len(), &expected)),
            _ => Err(self.mismatch(&expected)),
        };
        read.map_err(|error| error.at(&self.place))
    }
}

/// Methods for types of whole numbers.
macro_rules! whole {
    ($($method:ident $type:ty;)+) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
            let least = i64::try_from(<$type>::MIN).unwrap_or(i64::MIN);
            let most = i64::try_from(<$type>::MAX).unwrap_or(i64::MAX);
            self.read_whole(visitor, least, most).map_err(|error| error.at(&self.place))
        }
    )+};
}

/// Methods for types that one form of a value fits.
macro_rules! of_form {
    ($($method:ident $form:pat, $expected:literal;)+) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
            let read = match &self.content {
                $form => self.read_any(visitor),
                _ => Err(self.mismatch(&$expected)),
            };
            read.map_err(|error| error.at(&self.place))
        }
    )+};
}

impl<'de> Deserializer<'de> for &'de Placed {
    type Error = Refusal;

    whole! {
        deserialize_i8 i8;
        deserialize_i16 i16;
        deserialize_i32 i32;
        deserialize_i64 i64;
        deserialize_u8 u8;
        deserialize_u16 u16;
        deserialize_u32 u32;
        deserialize_u64 u64;
    }

    of_form! {
        deserialize_bool Content::Scalar(toml::Value::Boolean(_)), "true or false";
        deserialize_f32 Content::Scalar(toml::Value::Float(_) | toml::Value::Integer(_)), "a number";
        deserialize_f64 Content::Scalar(toml::Value::Float(_) | toml::Value::Integer(_)), "a number";
        deserialize_str Content::Scalar(toml::Value::String(_)), "a string";
        deserialize_string Content::Scalar(toml::Value::String(_)), "a string";
        deserialize_seq Content::Array(_), "an array";
        deserialize_map Content::Table(_), "a table";
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        self.read_any(visitor).map_err(|error| error.at(&self.place))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        words: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        let read = match &self.content {
            Content::Scalar(toml::Value::String(word)) => {
                let word: StrDeserializer<'_, Refusal> = word.as_str().into_deserializer();
                visitor.visit_enum(word)
            }
            Content::Table(table) if table.len() == 1 => {
                visitor.visit_enum(MapAccessDeserializer::new(Entries::of(table)))
            }
            Content::Table(table) => {
                Err(Refusal::not_one(&format!("a table of {} keys", table.len()), words))
            }
            Content::Array(_) => Err(Refusal::not_one("a list", words)),
            Content::Scalar(other) => Err(Refusal::not_one(other.type_str(), words)),
            Content::Unreadable(found) => Err(Refusal::not_one(found, words)),
        };
        read.map_err(|error| error.at(&self.place))
    }

    /// Refuses a list of another length: serde ignores the elements behind the last one that it reads.
    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        count: usize,
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        self.read_tuple(count, visitor, &format!("a list of {count} values"))
    }

    /// Reads a list whose elements the struct's attribute `expecting` names.
    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        count: usize,
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        let expected = (&visitor as &dyn Expected).to_string();
        self.read_tuple(count, visitor, &expected)
    }

    /// Refuses a list: serde would take its elements for the fields in their order.
    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        self.deserialize_map(visitor)
    }

    forward_to_deserialize_any! {
        i128 u128 char bytes byte_buf unit unit_struct identifier ignored_any
    }
}

/// The elements of an array. The refusal of a type's own check stands at the element.
struct Elements<'a>(std::slice::Iter<'a, Placed>);

impl<'de> SeqAccess<'de> for Elements<'de> {
    type Error = Refusal;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Refusal> {
        let Some(element) = self.0.next() else { return Ok(None) };
        seed.deserialize(element).map(Some).map_err(|error| error.at(&element.place))
    }
}

/// The keys and values of a table, in the same way.
struct Entries<'a> {
    left: btree_map::Iter<'a, String, Placed>,
    value: Option<&'a Placed>,
}

impl<'a> Entries<'a> {
    fn of(table: &'a BTreeMap<String, Placed>) -> Self {
        Self { left: table.iter(), value: None }
    }
}

impl<'de> MapAccess<'de> for Entries<'de> {
    type Error = Refusal;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Refusal> {
        let Some((name, value)) = self.left.next() else { return Ok(None) };
        self.value = Some(value);
        seed.deserialize(Key { name, place: &value.key }).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Refusal> {
        let value = self.value.take().ok_or_else(|| Refusal::new("a value without a key", ""))?;
        seed.deserialize(value).map_err(|error| error.at(&value.place))
    }
}

/// A key on its way to a type's field.
pub(super) struct Key<'a> {
    name: &'a str,
    place: &'a Option<Range<usize>>,
}

impl<'de> Deserializer<'de> for Key<'de> {
    type Error = Refusal;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        let name: StrDeserializer<'_, Refusal> = self.name.into_deserializer();
        name.deserialize_any(visitor).map_err(|error| match self.place {
            Some(place) => error.at(place),
            None => error,
        })
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit
        unit_struct seq tuple tuple_struct map struct enum option newtype_struct identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;
    use toml::de::DeValue;

    use super::*;

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields, default)]
    struct Table {
        gain_per_s: f64,
        kind: Kind,
        steps: Option<u32>,
        levels: Vec<f64>,
    }

    #[derive(Debug, Default, Deserialize, PartialEq)]
    #[serde(rename_all = "kebab-case")]
    enum Kind {
        #[default]
        Plain,
        TwoStep,
    }

    impl Default for Table {
        fn default() -> Self {
            Self { gain_per_s: 1.0, kind: Kind::Plain, steps: None, levels: Vec::new() }
        }
    }

    fn read(text: &str) -> Result<Table, (String, String)> {
        let document = DeValue::parse(text).expect("the test's own text");
        let placed = Placed::of(&document, 0);
        Table::deserialize(&placed).map_err(|error| {
            let place = error.place().expect("every error has a place").clone();
            (error.message().to_owned(), text[place].to_owned())
        })
    }

    #[test]
    fn values_arrive() {
        let table = read("{ gain_per_s = 2, kind = \"two-step\", steps = 3, levels = [1, 2.5] }");
        let wanted =
            Table { gain_per_s: 2.0, kind: Kind::TwoStep, steps: Some(3), levels: vec![1.0, 2.5] };
        assert_eq!(table, Ok(wanted));
        assert_eq!(read("{}"), Ok(Table::default()));
    }

    #[test]
    fn a_fault_is_found_where_it_stands() {
        let place = |text: &str| read(text).expect_err("it is wrong").1;
        assert_eq!(place("{ steps = 3, gian_per_s = 2 }"), "gian_per_s");
        assert_eq!(place("{ gain_per_s = \"fast\" }"), "\"fast\"");
        assert_eq!(place("{ kind = \"three-step\" }"), "\"three-step\"");
        assert_eq!(place("{ levels = [1, true] }"), "true");
        assert_eq!(place("{ steps = -3 }"), "-3");
    }
}
