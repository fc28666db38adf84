//! A table whose keys several types share: each reads the keys that it declares.

use std::cell::RefCell;

use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, MapAccess, VariantAccess, Visitor,
};
use serde::forward_to_deserialize_any;

use super::Placed;
use crate::refusal::Refusal;

/// A table with a key that chooses among the variants of an enum. Structs and that enum read it by turns; the keys
/// that none of them declares are left over.
pub(crate) struct Parts<'a> {
    table: &'a Placed,
    variant: &'a str,
    known: RefCell<Vec<&'static str>>,
}

impl<'a> Parts<'a> {
    /// The parts of `table`, whose key `chooser` holds the name `variant`.
    pub(crate) fn new(table: &'a Placed, chooser: &'static str, variant: &'a str) -> Self {
        Self { table, variant, known: RefCell::new(vec![chooser]) }
    }

    /// The keys that were declared by those who have read the table.
    pub(crate) fn known(&self) -> Vec<&'static str> {
        self.known.borrow().clone()
    }

    fn keys(&self, keys: &'static [&'static str]) -> Own<'a> {
        self.known.borrow_mut().extend(keys);
        Own { table: self.table, left: keys.iter(), found: None }
    }
}

impl<'de> Deserializer<'de> for &Parts<'de> {
    type Error = Refusal;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        self.table.deserialize_any(visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        keys: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        visitor.visit_map(self.keys(keys)).map_err(|error| error.at(&self.table.place))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        visitor.visit_enum(Chosen(self)).map_err(|error| error.at(&self.table.place))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit
        unit_struct newtype_struct seq tuple tuple_struct map identifier ignored_any
    }
}

/// The variant that the table names.
struct Chosen<'p, 'a>(&'p Parts<'a>);

impl<'de> EnumAccess<'de> for Chosen<'_, 'de> {
    type Error = Refusal;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), Refusal> {
        let name: serde::de::value::StrDeserializer<'_, Refusal> =
            self.0.variant.into_deserializer();
        Ok((seed.deserialize(name)?, self))
    }
}

impl<'de> VariantAccess<'de> for Chosen<'_, 'de> {
    type Error = Refusal;

    fn unit_variant(self) -> Result<(), Refusal> {
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Refusal> {
        seed.deserialize(self.0)
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Refusal> {
        self.0.deserialize_any(visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        keys: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        visitor.visit_map(self.0.keys(keys))
    }
}

/// The keys of a table that one type declares.
struct Own<'a> {
    table: &'a Placed,
    left: std::slice::Iter<'static, &'static str>,
    found: Option<(&'static str, &'a Placed)>,
}

impl<'de> MapAccess<'de> for Own<'de> {
    type Error = Refusal;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Refusal> {
        let table = self.table;
        self.found = self.left.find_map(|&key| Some((key, table.get(key)?)));
        let Some((key, _)) = self.found else { return Ok(None) };
        seed.deserialize(key.into_deserializer()).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Refusal> {
        let found = self.found.take();
        let (key, value) = found.ok_or_else(|| Refusal::new("a value without a key", ""))?;
        seed.deserialize(value).map_err(|error| error.at(&value.place).of_key(key))
    }
}
