//! Asks a type for its form through serde: what it wants to read, and what it refuses.
//!
//! A [`Tracer`] is a deserializer that has no document. It answers each question of the type with a
//! candidate, the first of which no quantity accepts: the refusal names what is expected. The type is
//! read again and again, each time with one more candidate or one more variant, until nothing is left to
//! learn. So the form cannot differ from what the program reads.

use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error as _, IntoDeserializer, MapAccess, SeqAccess,
    VariantAccess, Visitor,
};
use serde::forward_to_deserialize_any;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Places that are not written by hand: a translation from another format fills them.
const TRANSLATED: [&str; 1] = [".storyboard"];
/// Runs after which a type is taken for endless.
const MAX_RUNS: usize = 20_000;

/// What is known about one place of the document. A path is made of keys, `[]` for the element of a
/// list and `<variant>` for a variant.
#[derive(Clone, Debug, Default)]
pub(super) struct Node {
    pub(super) form: Form,
    /// What a value is to be, in the words of its refusal.
    pub(super) expected: Option<String>,
    /// Which candidate is tried.
    candidate: usize,
    /// Variants that have been read whole.
    explored: BTreeSet<usize>,
}

/// What a type wants to read in a place.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) enum Form {
    /// Any table: a law checks it.
    #[default]
    Free,
    Boolean,
    Whole,
    Number,
    Text,
    List,
    Tuple(usize),
    /// A table: the type's name and the keys.
    Table(&'static str, &'static [&'static str]),
    /// One of these words, or a table with one of them as its only key.
    Choice(&'static [&'static str]),
}

/// What the type says when it refuses an answer.
#[derive(Clone, Debug)]
pub(super) struct Refusal(pub(super) String);

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refusal {}

impl serde::de::Error for Refusal {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

/// What has been learnt so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Knowledge {
    pub(super) nodes: BTreeMap<String, Node>,
    /// The place that was answered last: a refusal is about it.
    last: String,
    /// Keys that are left out.
    left_out: BTreeSet<String>,
    /// Variants that were chosen in this run.
    chosen: Vec<(String, usize)>,
}

impl Knowledge {
    /// True if variant `index` of the choice at `path`, or a choice below it, is not known yet.
    fn is_unexplored(&self, path: &str, index: usize, variant: &str) -> bool {
        let below = format!("{path}<{variant}>");
        let mut choices = self.nodes.iter().filter(|(other, _)| other.starts_with(&below));
        !self.nodes[path].explored.contains(&index)
            || choices.any(|(_, node)| match node.form {
                Form::Choice(variants) => node.explored.len() < variants.len(),
                _ => false,
            })
    }
}

/// Reads one place.
struct Tracer<'a> {
    path: String,
    known: &'a RefCell<Knowledge>,
}

/// Learns the form of `T`, with one value of it.
///
/// # Panics
/// If the type refuses everything that is offered: it has a form that this module does not know.
pub(super) fn learn<T: serde::de::DeserializeOwned>() -> (Knowledge, T) {
    let known = RefCell::new(Knowledge::default());
    for _ in 0..MAX_RUNS {
        known.borrow_mut().chosen.clear();
        let read = T::deserialize(Tracer { path: String::new(), known: &known });
        let mut knowledge = known.borrow_mut();
        match read {
            Ok(value) => {
                let chosen = std::mem::take(&mut knowledge.chosen);
                let mut is_new = false;
                for (path, variant) in chosen {
                    let node = knowledge.nodes.get_mut(&path).expect("it was chosen there");
                    is_new |= node.explored.insert(variant);
                }
                if !is_new {
                    return (knowledge.clone(), value);
                }
            }
            Err(Refusal(message)) => {
                let last = knowledge.last.clone();
                let node = knowledge.nodes.get_mut(&last).expect("it was answered");
                if let Some((_, expected)) = message.split_once(", expected ") {
                    node.expected.get_or_insert_with(|| expected.to_owned());
                }
                node.candidate += 1;
                assert!(node.candidate < 4, "{last}: nothing is accepted here: {message}");
            }
        }
    }
    panic!("the type has no end");
}

/// Reads `T` with the keys of `left_out` missing.
pub(super) fn read_without<T: serde::de::DeserializeOwned>(
    known: Knowledge,
    left_out: BTreeSet<String>,
) -> (Knowledge, Result<T, Refusal>) {
    let known = RefCell::new(Knowledge { left_out, ..known });
    let read = T::deserialize(Tracer { path: String::new(), known: &known });
    (known.into_inner(), read)
}

impl Tracer<'_> {
    /// Notes the form of this place; the candidate that is to be tried.
    fn note(&self, form: Form) -> (usize, Option<String>) {
        let mut known = self.known.borrow_mut();
        known.last.clone_from(&self.path);
        let node = known.nodes.entry(self.path.clone()).or_default();
        node.form = form;
        (node.candidate, node.expected.clone())
    }

    fn whole(&self) -> i64 {
        let (candidate, expected) = self.note(Form::Whole);
        let least = expected.as_deref().and_then(range).map_or(1.0, |(least, _)| least);
        [i64::MIN, least as i64, 1, 0][candidate]
    }

    fn number(&self) -> f64 {
        let (candidate, expected) = self.note(Form::Number);
        let least = expected.as_deref().and_then(range).map_or(1.0, |(least, _)| least);
        [f64::NAN, least, 1.0, 0.0][candidate]
    }

    fn text(&self) -> String {
        let (candidate, expected) = self.note(Form::Text);
        let first = expected.as_deref().and_then(|text| words(text).into_iter().next());
        ["\u{1}".into(), first.unwrap_or_default(), "a".into(), "1".into()][candidate].clone()
    }

    fn below(&self, step: &str) -> Self {
        Self { path: format!("{}{step}", self.path), known: self.known }
    }
}

/// The range in words such as "a speed from 0 to 100 m/s".
pub(super) fn range(expected: &str) -> Option<(f64, f64)> {
    let (_, rest) = expected.split_once("from ")?;
    let mut numbers = rest.split([' ', ',']).filter_map(|word| word.parse::<f64>().ok());
    Some((numbers.next()?, numbers.next()?))
}

/// The words of "one of a, b, c".
pub(super) fn words(expected: &str) -> Vec<String> {
    let Some((_, list)) = expected.split_once("one of ") else { return Vec::new() };
    list.split(", ").map(|word| word.trim_matches('`').to_owned()).collect()
}

macro_rules! whole {
    ($($method:ident)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
            visitor.visit_i64(self.whole())
        }
    )*};
}

impl<'de> Deserializer<'de> for Tracer<'_> {
    type Error = Refusal;

    whole! {
        deserialize_i8 deserialize_i16 deserialize_i32 deserialize_i64
        deserialize_u8 deserialize_u16 deserialize_u32 deserialize_u64
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        self.note(Form::Boolean);
        visitor.visit_bool(false)
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        visitor.visit_f64(self.number())
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        visitor.visit_f64(self.number())
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        visitor.visit_string(self.text())
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        visitor.visit_string(self.text())
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        if TRANSLATED.contains(&self.path.as_str()) {
            self.note(Form::Free);
            return visitor.visit_none();
        }
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        self.note(Form::List);
        visitor.visit_seq(Elements { of: self, next: 0, count: 1, is_list: true })
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        count: usize,
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        self.note(Form::Tuple(count));
        visitor.visit_seq(Elements { of: self, next: 0, count, is_list: false })
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        count: usize,
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        self.deserialize_tuple(count, visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        self.note(Form::Free);
        visitor.visit_map(Keys { of: self, keys: &[], next: 0 })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        keys: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        self.note(Form::Table(name, keys));
        visitor.visit_map(Keys { of: self, keys, next: 0 })
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        self.note(Form::Choice(variants));
        let chosen = {
            let mut known = self.known.borrow_mut();
            let unexplored = (0..variants.len())
                .find(|&index| known.is_unexplored(&self.path, index, variants[index]));
            let chosen = unexplored.unwrap_or(0);
            known.chosen.push((self.path.clone(), chosen));
            chosen
        };
        visitor.visit_enum(Chosen { of: self, variant: variants[chosen] })
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        self.deserialize_map(visitor)
    }

    forward_to_deserialize_any! {
        i128 u128 char bytes byte_buf unit unit_struct identifier ignored_any
    }
}

/// The keys of a table.
struct Keys<'a> {
    of: Tracer<'a>,
    keys: &'static [&'static str],
    next: usize,
}

impl<'de> MapAccess<'de> for Keys<'_> {
    type Error = Refusal;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Refusal> {
        while let Some(key) = self.keys.get(self.next) {
            let place = self.of.below(&format!(".{key}"));
            if self.of.known.borrow().left_out.contains(&place.path) {
                self.next += 1;
                continue;
            }
            return seed.deserialize((*key).into_deserializer()).map(Some);
        }
        Ok(None)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Refusal> {
        let key = self.keys.get(self.next).ok_or_else(|| Refusal::custom("no key"))?;
        self.next += 1;
        seed.deserialize(self.of.below(&format!(".{key}")))
    }
}

/// The elements of a list or a tuple.
struct Elements<'a> {
    of: Tracer<'a>,
    next: usize,
    count: usize,
    is_list: bool,
}

impl<'de> SeqAccess<'de> for Elements<'_> {
    type Error = Refusal;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Refusal> {
        if self.next == self.count {
            return Ok(None);
        }
        let step = if self.is_list { "[]".into() } else { format!("[{}]", self.next) };
        self.next += 1;
        seed.deserialize(self.of.below(&step)).map(Some)
    }
}

/// A variant that was chosen.
struct Chosen<'a> {
    of: Tracer<'a>,
    variant: &'static str,
}

impl<'de> EnumAccess<'de> for Chosen<'_> {
    type Error = Refusal;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), Refusal> {
        let name: Result<_, Refusal> = seed.deserialize(self.variant.into_deserializer());
        Ok((name?, self))
    }
}

impl<'de> VariantAccess<'de> for Chosen<'_> {
    type Error = Refusal;

    fn unit_variant(self) -> Result<(), Refusal> {
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Refusal> {
        seed.deserialize(self.of.below(&format!("<{}>", self.variant)))
    }

    fn tuple_variant<V: Visitor<'de>>(self, count: usize, visitor: V) -> Result<V::Value, Refusal> {
        self.of.below(&format!("<{}>", self.variant)).deserialize_tuple(count, visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        keys: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        let place = self.of.below(&format!("<{}>", self.variant));
        place.deserialize_struct(self.variant, keys, visitor)
    }
}
