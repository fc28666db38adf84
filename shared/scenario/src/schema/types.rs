//! The form of types that are declared elsewhere.

use super::{Schema, Shape, Variant};
use messages::Service;
use openscenario::model::action::Shape as Course;
use openscenario::road::Driven;
use road::LaneLines;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A number without a range.
macro_rules! numbers {
    ($($number:ty, $is_whole:literal;)+) => {$(
        impl Schema for $number {
            fn shape() -> Shape {
                Shape::Number { is_whole: $is_whole, range: None, unit: "" }
            }
        }
    )+};
}

numbers! {
    f64, false;
    u32, true;
}

impl Schema for bool {
    fn shape() -> Shape {
        Shape::Boolean
    }
}

impl Schema for String {
    fn shape() -> Shape {
        Shape::Text { words: Vec::new() }
    }
}

impl Schema for PathBuf {
    fn shape() -> Shape {
        String::shape()
    }
}

impl<T: Schema> Schema for Option<T> {
    const IS_OPTION: bool = true;

    fn shape() -> Shape {
        T::shape()
    }

    fn expected() -> Option<String> {
        T::expected()
    }
}

impl<T: Schema> Schema for Vec<T> {
    fn shape() -> Shape {
        Shape::List(Box::new(T::shape()))
    }
}

/// A table whose keys are names of the author's.
impl<T: 'static> Schema for BTreeMap<String, T> {
    fn shape() -> Shape {
        Shape::Free
    }
}

/// Lines of lanes: a list of stations.
impl Schema for LaneLines {
    fn shape() -> Shape {
        let number = Shape::Number { is_whole: false, range: None, unit: "m" };
        Shape::List(Box::new(Shape::List(Box::new(number))))
    }
}

/// A line along a road of a file: reading the file fills it.
impl Schema for Driven {
    fn shape() -> Shape {
        Shape::Free
    }
}

/// A table that its reader keeps as it is.
impl Schema for toml::Table {
    fn shape() -> Shape {
        Shape::Free
    }
}

impl Schema for Service {
    fn shape() -> Shape {
        words(Self::ALL.map(Self::name))
    }
}

impl Schema for Course {
    fn shape() -> Shape {
        let all = [Self::Linear, Self::Cubic, Self::Sinusoidal, Self::Step];
        let name = |course: Self| toml::Value::try_from(course).expect("a word");
        let names = all.map(name);
        words(names.each_ref().map(|name| name.as_str().unwrap_or_default()))
    }
}

fn words<const N: usize>(names: [&str; N]) -> Shape {
    let variant =
        |name: &str| Variant { name: name.to_owned(), meaning: String::new(), shape: None };
    Shape::Choice(names.into_iter().map(variant).collect())
}
